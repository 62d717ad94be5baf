"""Influence of parts of the physics: changes of quantities, and other fronts."""

import itertools
import textwrap

import numpy as np

from ...studies import DriverStudy
from ...text import display_unit
from .._parts import in_words, legend_below
from .._style import INK, SERIES, Figure, drawn, page_figure, readable

#: What became of designs of a front without a part, with the marker of each.
_STATES = (("the same designs with complete physics", "o"), ("those that break a limit then", "x"))


@drawn
def variant_changes(study: DriverStudy) -> Figure:
    """Draw by how many per cent each quantity changes without each part of the physics.

    Bars are the present design; lines span the points of the front.

    **Arguments:**

    - `study`: result of `prsm_jax.study`.

    **Returns:** a matplotlib figure: a panel for each quantity.

    **Raises:** `ValueError` where no part was left out; `MissingExtraError` without matplotlib.
    """
    variants = [one for one in study.variants if one.changes]
    if not variants:
        raise ValueError("no part of the physics was left out in this study")
    names = list(study.problem.senses)
    figure = page_figure(22 + 8.0 * len(variants))
    panels = figure.subplots(1, len(names), squeeze=False, sharey=True)[0]
    for axes, name in zip(panels, names, strict=True):
        changes = [100 * one.changes[name] for one in variants]
        places = np.arange(len(variants))
        axes.barh(
            places, [float(one[0]) for one in changes], color=SERIES[0], height=0.55,
            label="present design",
        )  # fmt: skip
        for place, change in zip(places, changes, strict=True):
            points = change[1:][np.isfinite(change[1:])]
            if points.size:
                ends = [float(points.min()), float(points.max())]
                axes.plot(ends, [place, place], color=INK, lw=1.2, marker="|", label="front")
        axes.axvline(0, color=INK, lw=0.6)
        axes.set_yticks(places, [f"without {readable(one.name)}" for one in variants])
        axes.set_xlabel(textwrap.fill(f"{readable(name)}: change in %", 24))
        axes.margins(x=0.1)
        axes.grid(True, axis="x")
    panels[0].invert_yaxis()
    entries = dict(zip(*reversed(panels[0].get_legend_handles_labels()), strict=True))
    legend_below(figure, list(entries.values()))
    return figure


@drawn
def variant_fronts(study: DriverStudy) -> Figure:
    """Draw the front, and the designs of fronts without a part, computed with complete physics.

    Dashed lines are the fronts computed without the part. Their designs, computed with complete
    physics, are circles if they satisfy all limits, and crosses if they do not.

    **Arguments:**

    - `study`: result of `prsm_jax.study`.

    **Returns:** a matplotlib figure: one panel for two objectives, three for three.

    **Raises:** `ValueError` if no front was found without a part; `MissingExtraError` without
    matplotlib.
    """
    variants = [one for one in study.variants if one.front is not None and one.front.points]
    if not variants:
        raise ValueError("no front was found without a part of the physics")
    pairs = list(itertools.combinations(study.problem.objectives, 2))
    figure = page_figure(100.0 if len(pairs) == 1 else 78.0)
    panels = np.ravel(figure.subplots(1, len(pairs)))
    for axes, (x, y) in zip(panels, pairs, strict=True):
        shown = {
            name: display_unit(
                study.problem.units[name], map(float, study.designs.values[name]), name
            )
            for name in (x, y)
        }
        if study.front.points:
            ends = [shown[name](study.designs.values[name][1:]) for name in (x, y)]
            axes.plot(*ends, color=INK, lw=1.4, marker="o", ms=3.5, label="complete physics")
        seen: set[str] = set()
        for place, one in enumerate(variants):
            colour, words = SERIES[place], f"without {readable(one.name)}"
            order = [list(study.problem.objectives).index(name) for name in (x, y)]
            assert one.front is not None
            alone = [shown[n](one.front.values[:, i]) for n, i in zip((x, y), order, strict=True)]
            axes.plot(*alone, color=colour, lw=1.0, ls="--", label=words)
            full = [shown[name](one.complete[name]) for name in (x, y)]
            for kept, (state, marker) in zip((one.allowed, ~one.allowed), _STATES, strict=True):
                if kept.any():
                    seen.add(state)
                    # Sizes differ, so that designs that coincide are all visible.
                    axes.plot(
                        full[0][kept], full[1][kept], ls="", marker=marker, ms=7.0 - 1.5 * place,
                        mfc="none", mec=colour, label="_",
                    )  # fmt: skip
        # Each variant has its own colour; the legend has the shapes of all in black.
        for state, marker in _STATES:
            if state in seen:
                axes.plot([], [], ls="", marker=marker, mfc="none", mec=INK, label=state)
        for name, label in ((x, axes.set_xlabel), (y, axes.set_ylabel)):
            label(f"{in_words(readable(name), shown[name])} ({study.problem.senses[name]})")
        axes.grid(True)
        axes.margins(0.08)
    legend_below(figure, panels[0].get_legend_handles_labels()[0], most=3)
    return figure
