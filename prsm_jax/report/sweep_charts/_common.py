"""Common parts of all pictures of a sweep: units, words, marks of designs, the legend."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ...text import DisplayUnit, display_unit, in_unit
from .._parts import in_words, legend_below, legend_line
from .._style import INK, SMALL, Axes, Figure, readable
from ._limits import Best


def unit_of(data: Any, quantity: str = "") -> DisplayUnit:
    """The unit in which an array of the data set is shown."""
    values = np.asarray(data.values, float)
    finite = values[np.isfinite(values)]
    ends = [float(finite.min()), float(finite.max())]
    return display_unit(str(data.attrs.get("units", "1")), ends, quantity)


def label_of(name: str, unit: DisplayUnit) -> str:
    """The label of an axis, without the stage and the part of its number."""
    return in_words(readable(name.rpartition(".")[2]), unit)


def title_of(name: str) -> str:
    """The name of a quantity as a heading."""
    return f"{readable(name)[:1].upper()}{readable(name)[1:]}"


def marks_of(part: Any) -> tuple[np.ndarray, np.ndarray]:
    """For each design: whether it failed; whether it did not, but `check` finds an error."""
    failed = part["code"].values != 0
    errors = part["error"].values != 0 if "error" in part else np.zeros_like(failed)
    return failed, errors & ~failed


def mark(axes: Axes, x: np.ndarray, y: np.ndarray, failed: np.ndarray, errors: np.ndarray) -> None:
    """Crosses on the lower edge, dots on the values."""
    if failed.any():
        at, edge = axes.get_xaxis_transform(), np.zeros(failed.sum())
        crosses: dict[str, Any] = {"color": INK, "ms": 4, "clip_on": False, "ls": ""}
        axes.plot(x[failed], edge, marker="x", label="failed", transform=at, **crosses)
    if errors.any():
        place = np.repeat(x[errors], y.shape[1])
        dots: dict[str, Any] = {"color": INK, "ms": 3, "ls": "", "zorder": 4}
        label = "error of prsm check"
        axes.plot(place, y[errors].ravel(), marker=".", label=label, **dots)


def mark_best(
    axes: Axes, x: float, y: float, best: Best, unit: DisplayUnit, entries: list[Any]
) -> None:
    """A star on the best design, or an entry of the legend that says why there is none."""
    if best.marked:
        style: dict[str, Any] = {"mfc": "#d55e00", "mec": "white", "mew": 0.8, "clip_on": False}
        words = f"{best.words}: {in_unit(best.value, unit)}"
        axes.plot(x, y, "*", ms=12, zorder=5, ls="", label=words, **style)
        return
    if best.words not in [one.get_label() for one in entries]:
        entries.append(legend_line(best.words, linestyle=""))


def sweep_legend(figure: Figure, more: Iterable[Any] = (), note: str = "", most: int = 4) -> None:
    """A legend of all panels, each entry once, and `more` entries and a note after them."""
    by_label: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            by_label.setdefault(label, handle)
    entries = [*by_label.values(), *more]
    if note:
        entries.append(legend_line(note, linestyle=""))
    legend_below(figure, entries, most=most, fontsize=SMALL)


def place_in_words(part: Any, names: Sequence[str], places: Iterable[int]) -> str:
    """Values of fixed axes in words: "load 9.000 kN, roller count 10"."""
    words = []
    for name, place in zip(names, places, strict=False):
        coordinate = part[name].values[place]
        whole = np.issubdtype(part[name].dtype, np.integer)
        value = str(coordinate) if whole else in_unit(float(coordinate), unit_of(part[name]))
        words.append(f"{readable(name.rpartition('.')[2])} {value}")
    return ", ".join(words)
