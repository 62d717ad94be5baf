"""Gains of each objective, size by size."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..harness import save_picture
from .problem import OBJECTIVES

#: Name, marker and colour of each objective.
_STYLES = {
    "dynamic_capacity": ("dynamic capacity, increase", "o", "#0072b2"),
    "axial_stiffness": ("axial stiffness, increase", "^", "#009e73"),
    "nut_unit_mass": ("mass of the nut unit, decrease", "s", "#d55e00"),
}
TITLES = {
    "no_loss": "no loss of efficiency",
    "half_digit": "efficiencies may fall by 0.005",
}


def percents(rows: Sequence[Mapping[str, Any]], name: str) -> np.ndarray:
    """Change of an objective against the size's own design, better above 0 [%]."""
    ratios = np.array([row["measures"][name] / row["own"][name] for row in rows])
    return 100 * (1 - ratios if name == "nut_unit_mass" else ratios - 1)


def draw(document: Mapping[str, Any], path: Path) -> Path:
    """A panel for each problem, with the sizes along the axis, as a PNG.

    **Arguments:**

    - `document`: what `catalogue.json` has.
    - `path`: where the picture goes; written whole or not at all.
    """
    from matplotlib.figure import Figure

    problems = document["problems"]
    figure = Figure(figsize=(10.0, 3.6 * len(problems)), dpi=110, layout="constrained")
    panels = figure.subplots(len(problems), 1, squeeze=False, sharex=True)[:, 0]
    for axes, (name, problem) in zip(panels, problems.items(), strict=True):
        rows = problem["sizes"]
        places = np.arange(1, len(rows) + 1)
        for objective in OBJECTIVES:
            label, marker, colour = _STYLES[objective]
            axes.plot(places, percents(rows, objective), marker, ms=4, color=colour, label=label)
        axes.axhline(0.0, color="0.4", lw=0.8)
        axes.set(title=TITLES[name], ylabel="change against the size's own [%]")
        axes.grid(axis="y", color="0.9", linewidth=0.8)
        axes.set_axisbelow(True)
        _mark_diameters(axes, rows)
    panels[-1].set_xlabel(
        "sizes in the order of the catalogue, by nominal diameter [mm] and starts, leads rising"
    )
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    return save_picture(figure, path)


def _mark_diameters(axes: Any, rows: Sequence[Mapping[str, Any]]) -> None:
    """Lines between series of one diameter and number of starts, and their names."""
    names = [f"{row['nominal_diameter_mm']:g}\n{row['own_starts']}" for row in rows]
    firsts = [i for i, name in enumerate(names) if i == 0 or name != names[i - 1]]
    for first in firsts[1:]:
        axes.axvline(first + 0.5, color="0.85", lw=0.8)
    ends = [*firsts[1:], len(names)]
    middles = [(first + end + 1) / 2 for first, end in zip(firsts, ends, strict=True)]
    axes.set_xticks(middles, [names[first] for first in firsts])
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(0.3, len(names) + 0.7)
