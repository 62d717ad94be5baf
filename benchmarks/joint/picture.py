"""Jacobians and differences over the value, subset by subset."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..harness import save_picture

#: The goal: value and Jacobian by three numbers in the time of three values.
_GOAL = 3.0


def ratios(document: Mapping[str, Any]) -> dict[str, list[float]]:
    """What is drawn of one example, in the order of the concatenated Jacobian's ratio."""
    rows = sorted(document["joint"], key=lambda row: row["over_value"]["concatenated"])
    return {
        "value and Jacobian, dictionary": [row["over_value"]["dictionary"] for row in rows],
        "value and Jacobian, concatenated": [row["over_value"]["concatenated"] for row in rows],
        "central differences": [
            row["microseconds"]["central differences"] / row["microseconds"]["value"]
            for row in rows
        ],
    }


def draw(documents: Sequence[Mapping[str, Any]], path: Path) -> Path:
    """A panel for each example of which there are several subsets, as a PNG.

    **Arguments:**

    - `documents`: what `joint-<example>.json` has.
    - `path`: where the picture goes; written whole or not at all.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator, ScalarFormatter

    documents = [one for one in documents if len(one["joint"]) > 1] or documents
    figure = Figure(figsize=(max(8.0, 5.5 * len(documents)), 4.6), dpi=110, layout="constrained")
    panels = figure.subplots(1, len(documents), squeeze=False, sharey=True)[0]
    lines = []
    for axes, document in zip(panels, documents, strict=True):
        styles = (("o", "#0072b2"), ("x", "#d55e00"), ("^", "#7f7f7f"))
        lines = []
        for (name, values), (marker, colour) in zip(ratios(document).items(), styles, strict=True):
            places = range(1, len(values) + 1)
            lines += axes.plot(places, values, marker, color=colour, label=name, markersize=5)
        lines.append(axes.axhline(_GOAL, color="0.4", ls="--", lw=1, label="three values"))
        axes.set(title=document["example"], yscale="log", xlabel="subset of quantities, sorted")
        axes.yaxis.set_major_locator(
            FixedLocator([0.5, 1, 1.5, 2, 3, 4, 6, 8, 10, 20, 50, 100, 500])
        )
        axes.yaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.grid(which="major", color="0.9", linewidth=0.8)
        axes.set_axisbelow(True)
    panels[0].set_ylabel("run time over that of the value [1]")
    figure.legend(handles=lines, loc="outside lower center", ncols=2, fontsize=9, frameon=False)
    return save_picture(figure, path)
