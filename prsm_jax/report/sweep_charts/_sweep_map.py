"""A map of a quantity over two axes of a sweep."""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from .._parts import colour_bar, in_words, map_of_one_value
from .._style import INK, SMALL, Figure, drawn, page_figure, readable
from ._boundaries import draw_on_map, limit_entries
from ._common import label_of, mark_best, place_in_words, sweep_legend, title_of, unit_of
from ._limits import (
    Best,
    Constraints,
    QuantityLimit,
    best_design,
    constraints_in,
    cut,
    limits_of,
    outside_of,
)


@drawn
def sweep_map(
    dataset: Any,
    quantity: str,
    *,
    x: str | None = None,
    y: str | None = None,
    sense: Literal["maximise", "minimise"] = "maximise",
    constraints: Constraints = None,
) -> Figure:
    """Draw contours of a quantity over two axes of a sweep, with its optimum.

    Further axes are fixed at the optimum. Crosses mark designs that failed, dots those in which
    `check` finds an error; the optimum is one of the others. Without others there is no star, and
    the legend says so.

    With `constraints`, a line shows where a quantity is at its limit, with ticks on the side
    outside, which is hatched. The optimum is then the best design within all limits.

    **Arguments:**

    - `dataset`: an `xarray.Dataset` from a sweep; units are in the attribute `units`.
    - `quantity`: name of a variable in it that has only the axes of the sweep.
    - `x`, `y`: the two axes; default the first two of the quantity.
    - `sense`: whether the optimum is the largest or the smallest value.
    - `constraints`: (lower, upper) [SI] by the name of a variable, as for `sweep_figure`.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` for an unknown name, fewer than two axes, or when no design
    succeeded; `MissingExtraError` without matplotlib.
    """
    return map_with_note(dataset, quantity, x, y, sense=sense, constraints=constraints)


def map_with_note(
    dataset: Any,
    quantity: str,
    x: str | None = None,
    y: str | None = None,
    *,
    sense: Literal["maximise", "minimise"],
    constraints: Constraints,
    note: str = "",
) -> Figure:
    """A map as `sweep_map`, with a note at the end of its legend."""
    if quantity not in dataset:
        raise ValueError(f"the sweep has no {quantity!r}; it has {', '.join(dataset.data_vars)}")
    limited = constraints_in(dataset, constraints)
    dims = [str(d) for d in dataset[quantity].dims]
    long_axes = [d for d in dims if dataset.sizes[d] > 1]
    chosen = [x, y] if x is not None and y is not None else long_axes[:2]
    if len(chosen) < 2 or any(axis not in dims for axis in chosen) or chosen[0] == chosen[1]:
        raise ValueError(
            f"a map of {quantity!r} needs two axes of more than one value; it has "
            f"{', '.join(long_axes) or 'none'}"
        )
    # Contours have their larger values on the left only along ascending axes.
    dataset = dataset.sortby(chosen)
    data = dataset[quantity]
    values = np.asarray(data.values, dtype=float)
    if not np.isfinite(values).any():
        raise ValueError(f"no design of the sweep has a {quantity!r}; every one failed")
    flawed = _flawed(dataset, data)
    limits = limits_of(dataset, limited, dims)
    outside = outside_of(limits, data).values if limits else None
    best = best_design(values, flawed.values, outside, sense)
    fixed = {d: i for d, i in zip(dims, best.place, strict=True) if d not in chosen}
    plane, dots = (one.isel(fixed).transpose(chosen[1], chosen[0]) for one in (data, flawed))
    shown = {d: i for d, i in fixed.items() if data.sizes[d] > 1}
    words = f"at {place_in_words(dataset, list(shown), shown.values())}" if shown else ""
    at = best.place[dims.index(chosen[0])], best.place[dims.index(chosen[1])]
    cuts = [cut(one, fixed, plane) for one in limits]
    return _draw(plane, dots.values, at, best, words, cuts, note)


def _flawed(dataset: Any, data: Any) -> Any:
    """Designs in which `check` finds an error, over the axes of a quantity."""
    if "error" not in dataset:
        return data.isnull() & False
    codes = dataset["error"]
    return (codes > 0).broadcast_like(data).transpose(*data.dims)


def _draw(
    plane: Any,
    flawed: np.ndarray,
    place: tuple[int, int],
    best: Best,
    where: str,
    limits: Sequence[QuantityLimit],
    note: str,
) -> Figure:
    values, quantity = np.asarray(plane.values, dtype=float), str(plane.name)
    finite = values[np.isfinite(values)]
    unit = unit_of(plane, quantity)
    y_name, x_name = map(str, plane.dims)
    x_unit, y_unit = unit_of(plane[x_name]), unit_of(plane[y_name])
    xs, ys = (
        one(np.asarray(plane[name].values, dtype=float))
        for one, name in ((x_unit, x_name), (y_unit, y_name))
    )
    figure = page_figure(110 + 2.5 * len(limits), 150)
    axes = figure.add_subplot()
    shown = unit(values)
    masked = np.ma.masked_invalid(shown)
    if finite.min() < finite.max():
        filled: Any = axes.contourf(xs, ys, masked, levels=14, cmap="cividis")
        levels = filled.levels
        axes.contour(xs, ys, masked, levels=levels[::2], colors="white", linewidths=0.5)
    else:
        filled = map_of_one_value(axes, xs, ys, masked)
    bar = colour_bar(figure, filled, axes, "", shrink=1.0)
    bar.set_label(in_words(readable(quantity), unit))
    draw_on_map(axes, xs, ys, limits)
    failed = np.argwhere(~np.isfinite(values))
    if failed.size:
        axes.plot(
            xs[failed[:, 1]], ys[failed[:, 0]], "x", color=INK, ms=4, clip_on=False, label="failed"
        )
    dots = np.argwhere(flawed & np.isfinite(values))
    if dots.size:
        at = xs[dots[:, 1]], ys[dots[:, 0]]
        axes.plot(*at, ".", color=INK, ms=3, clip_on=False, label="error of prsm check")
    entries = limit_entries(limits)
    mark_best(axes, xs[place[0]], ys[place[1]], best, unit, entries)
    axes.set_xlabel(label_of(x_name, x_unit))
    axes.set_ylabel(label_of(y_name, y_unit))
    axes.set_title(title_of(quantity))
    sweep_legend(figure, entries, note, most=2 if limits else 3)
    if where:
        axes.text(1.0, 1.02, where, transform=axes.transAxes, ha="right", fontsize=SMALL)
    return figure
