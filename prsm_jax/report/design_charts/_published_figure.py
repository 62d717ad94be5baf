"""A recomputed figure of a paper, with the printed values marked."""

from typing import Any

import numpy as np

from ...text import DisplayUnit, display_unit
from ...validation import Mark, Panel, PublishedFigure, sources
from .._parts import in_words, legend_below, page_title
from .._style import INK, MUTED, SERIES, SMALL, Axes, Figure, drawn, page_figure

_DASHES = {0: "-", 1: "-", 2: (0, (5, 1.5))}
_MARK = "#7a0019"
_PANEL, _EXTRA = 62.0, 22.0


@drawn
def published_figure(figure: PublishedFigure) -> Figure:
    """Draw a published figure: the toolkit's curves on the paper's axes.

    Colours distinguish the cases (or the stages, if there is one case), dashes the stages. Dotted
    lines are values printed in the text of the paper.

    **Arguments:**

    - `figure`: from `prsm_jax.validation.published_figures`.

    **Returns:** a matplotlib figure; time in ms, ratios and efficiency as numbers.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    import matplotlib

    # Symbols of the papers are formulas; nothing here is text from a user.
    with matplotlib.rc_context({"text.parse_math": True}):
        return _page(figure)


def _page(figure: PublishedFigure) -> Figure:
    several = len(figure.panels) > 1
    rows = (len(figure.panels) + 1) // 2 if several else 1
    page = page_figure(_PANEL * rows + _EXTRA, 180.0 if several else 120.0)
    grid = page.subplots(rows, 2 if several else 1, squeeze=False).ravel()
    unit = display_unit("s", float(figure.time[-1]))
    time = unit(np.asarray(figure.time))
    for letter, axes, panel in zip("abcdefgh", grid, figure.panels, strict=False):
        axes.set_title(f"({letter}) {panel.name}" if several else panel.name)
        axes.set_xlabel(f"time in {unit.label}")
        axes.set_xlim(0, time[-1])
        _panel(axes, panel, time, len(figure.cases), unit)
        axes.grid(True)
    for axes in grid[len(figure.panels) :]:
        axes.set_visible(False)
    _legend(page, figure)
    cited = sources().get(figure.source, figure.source).split(",")[0].split(" ")[-1]
    year = "".join(c for c in figure.source if c.isdigit())
    page_title(page, f"{figure.caption} ({cited} et al. {year}, figure {figure.number})")
    return page


def _style(stage: int, case: int, cases: int) -> dict[str, Any]:
    """Later cases are thinner, so that all overlapping curves are visible."""
    dashes = _DASHES.get(stage, ":")
    if cases <= 1 and stage == 0:
        return {"color": INK, "ls": dashes, "lw": 1.2}
    colour = case if cases > 1 else stage - 1
    width = 1.2 if cases <= 1 else max(2.6 - 0.9 * case, 0.8)
    palette = (0, 3) if cases <= 1 else (5, 3, 0, 2)
    return {"color": SERIES[palette[colour % len(palette)]], "ls": dashes, "lw": width}


def _panel(axes: Axes, panel: Panel, time: np.ndarray, cases: int, clock: DisplayUnit) -> None:
    everything = np.concatenate([curve.y for curve in panel.curves])
    unit = DisplayUnit("" if panel.unit == "1" else panel.unit, 1.0)
    axes.set_ylabel(in_words(_symbol(panel.symbol), unit))
    for curve in panel.curves:
        axes.plot(time, unit(curve.y), **_style(curve.stage, curve.case, cases))
    levels = [mark.level for mark in panel.marks if mark.level is not None]
    low, high = min(0.0, everything.min()), max([everything.max(), *levels])
    # An efficiency far above zero fills its panel, as in the papers.
    if everything.min() > 0.3 * high:
        low = min([everything.min(), *levels])
    margin = 0.08 * (high - low)
    axes.set_ylim(low - (margin if low else 0), high + margin)
    for mark in panel.marks:
        _mark(axes, mark, clock, left=_ends_near(panel, mark.level))
    if panel.right is not None:
        _right(axes, panel.right, time)


def _ends_near(panel: Panel, level: float | None) -> bool:
    """Whether curves are nearer to a level in the end than at the start."""
    if level is None:
        return False
    distance = np.array([np.abs(curve.y[[0, -1]] - level) for curve in panel.curves]).min(axis=0)
    return bool(distance[1] < distance[0])


def _right(axes: Axes, panel: Panel, time: np.ndarray) -> None:
    """A second axis for curves of another unit, in the colour of these curves."""
    other = axes.twinx()
    colour = SERIES[2]
    for curve in panel.curves:
        other.plot(time, curve.y, color=colour, ls=(0, (1.5, 1.2)), lw=1.4)
    other.set_ylabel(f"{_symbol(panel.symbol)} in {panel.unit}", color=colour)
    other.spines["right"].set_visible(True)
    other.set_ylim(0, 1.15 * max(float(curve.y.max()) for curve in panel.curves))
    other.set_label(panel.name)
    other.tick_params(axis="x", labelbottom=False)


def _mark(axes: Axes, mark: Mark, clock: DisplayUnit, left: bool) -> None:
    """A dotted line, labelled at the end where the curves are farther away."""
    style = {"color": _MARK, "lw": 0.9, "ls": (0, (1, 1.5)), "zorder": 1}
    words = {"fontsize": SMALL, "color": _MARK}
    if mark.level is not None:
        axes.axhline(mark.level, **style)
        axes.text(
            0.015 if left else 0.985,
            mark.level,
            mark.words,
            transform=axes.get_yaxis_transform(),
            ha="left" if left else "right",
            va="bottom",
            **words,
        )
    if mark.time is not None:
        axes.axvline(clock(mark.time), **style)
        axes.text(
            clock(mark.time),
            0.04,
            f" {mark.words}",
            transform=axes.get_xaxis_transform(),
            ha="left",
            va="bottom",
            **words,
        )


def _symbol(symbol: str) -> str:
    """`F_RG` as mathematics with an upright index."""
    name, _, index = symbol.partition("_")
    return f"${name}_{{\\mathrm{{{index}}}}}$" if index else f"${name}$"


def _legend(page: Figure, figure: PublishedFigure) -> None:
    from matplotlib.lines import Line2D

    cases = len(figure.cases)
    curves = [curve for panel in figure.panels for curve in panel.curves]
    stages = sorted({curve.stage for curve in curves if curve.stage})
    handles = [
        Line2D([], [], **_style(0, case, cases), label=_case(words))
        for case, words in enumerate(figure.cases)
    ]
    for stage in stages if len(stages) > 1 else ():
        style = _style(stage, 0, cases)
        if cases > 1:
            style |= {"color": INK, "lw": 1.2}
        handles.append(Line2D([], [], **style, label=f"stage {stage}"))
    if any(panel.right is not None for panel in figure.panels):
        handles.append(
            Line2D([], [], color=SERIES[2], ls=(0, (1.5, 1.2)), lw=1.4, label="on the right")
        )
    if any(mark.printed for panel in figure.panels for mark in panel.marks):
        dotted = {"color": _MARK, "lw": 0.9, "ls": (0, (1, 1.5))}
        handles.append(Line2D([], [], **dotted, label="value in the text"))
    legend_below(page, handles, labelcolor=MUTED)


def _case(words: str) -> str:
    """Symbols of a case as mathematics."""
    return " ".join(_symbol(word) if "_" in word else word for word in words.split(" "))
