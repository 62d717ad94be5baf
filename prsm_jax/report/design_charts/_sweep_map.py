"""A map of a quantity over two axes of a sweep."""

from typing import Any, Literal

import numpy as np

from ...text import display_unit, in_unit
from .._parts import colour_bar, in_words
from .._style import INK, SMALL, Figure, drawn, page_figure, readable


@drawn
def sweep_map(
    dataset: Any,
    quantity: str,
    *,
    x: str | None = None,
    y: str | None = None,
    sense: Literal["maximise", "minimise"] = "maximise",
) -> Figure:
    """Draw contours of a quantity over two axes of a sweep, with its optimum.

    Further axes are fixed at the optimum. Crosses mark designs that failed, dots those in which
    `check` finds an error; the optimum is one of the others, if there are any.

    **Arguments:**

    - `dataset`: an `xarray.Dataset` from a sweep; units are in the attribute `units`.
    - `quantity`: name of a variable in it that has only the axes of the sweep.
    - `x`, `y`: the two axes; default the first two of the quantity.
    - `sense`: whether the optimum is the largest or the smallest value.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` for an unknown name, fewer than two axes, or when no design
    succeeded; `MissingExtraError` without matplotlib.
    """
    if quantity not in dataset:
        raise ValueError(f"the sweep has no {quantity!r}; it has {', '.join(dataset.data_vars)}")
    data = dataset[quantity]
    long_axes = [str(d) for d in data.dims if data.sizes[d] > 1]
    chosen = [x, y] if x is not None and y is not None else long_axes[:2]
    if len(chosen) < 2 or any(axis not in data.dims for axis in chosen) or chosen[0] == chosen[1]:
        raise ValueError(
            f"a map of {quantity!r} needs two axes of more than one value; it has "
            f"{', '.join(long_axes) or 'none'}"
        )
    values = np.asarray(data.values, dtype=float)
    if not np.isfinite(values).any():
        raise ValueError(f"no design of the sweep has a {quantity!r}; every one failed")
    pick = np.nanargmax if sense == "maximise" else np.nanargmin
    flawed = _flawed(dataset, data)
    usable = np.isfinite(values) & ~flawed.values
    usable = usable if usable.any() else np.isfinite(values)
    best = np.unravel_index(pick(np.where(usable, values, np.nan)), values.shape)
    other_axes = {
        str(d): int(i)
        for d, i in zip(data.dims, best, strict=True)
        if d not in chosen and data.sizes[d] > 1
    }
    fixed = {d: int(i) for d, i in zip(data.dims, best, strict=True) if d not in chosen}
    plane, dots = (one.isel(fixed).transpose(chosen[1], chosen[0]) for one in (data, flawed))
    dots = np.argwhere(dots.values & np.isfinite(np.asarray(plane.values, dtype=float)))
    return _draw(data, plane, dots, quantity, chosen, best, other_axes, sense)


def _flawed(dataset: Any, data: Any) -> Any:
    """Designs in which `check` finds an error, over the axes of a quantity."""
    if "error" not in dataset:
        return data.isnull() & False
    codes = dataset["error"]
    return (codes > 0).broadcast_like(data).transpose(*data.dims)


def _axis(data: Any, name: str):
    coordinate = np.asarray(data[name].values, dtype=float)
    unit = display_unit(str(data[name].attrs.get("units", "1")), [float(v) for v in coordinate])
    return unit(coordinate), unit, in_words(readable(name), unit)


def _draw(data, plane, dots, quantity: str, chosen, best, other_axes, sense: str) -> Figure:
    values = np.asarray(plane.values, dtype=float)
    finite = values[np.isfinite(values)]
    unit = display_unit(
        str(data.attrs.get("units", "1")),
        [float(v) for v in (finite.min(), finite.max())],
        quantity,
    )
    (xs, _, x_label), (ys, _, y_label) = (_axis(data, name) for name in chosen)
    figure = page_figure(110, 150)
    axes = figure.add_subplot()
    shown = unit(values)
    style: dict[str, Any] = {"cmap": "cividis"}
    masked = np.ma.masked_invalid(shown)
    if finite.min() < finite.max():
        filled: Any = axes.contourf(xs, ys, masked, levels=14, **style)
        levels = filled.levels
        axes.contour(xs, ys, masked, levels=levels[::2], colors="white", linewidths=0.5)
    else:
        filled = axes.pcolormesh(xs, ys, masked, shading="nearest", **style)
    bar = colour_bar(figure, filled, axes, "", shrink=1.0)
    bar.set_label(in_words(readable(quantity), unit))
    failed = np.argwhere(~np.isfinite(values))
    if failed.size:
        axes.plot(
            xs[failed[:, 1]], ys[failed[:, 0]], "x", color=INK, ms=4, clip_on=False, label="failed"
        )
    if dots.size:
        at = xs[dots[:, 1]], ys[dots[:, 0]]
        axes.plot(*at, ".", color=INK, ms=3, clip_on=False, label="error of prsm check")
    index = dict(zip((str(d) for d in data.dims), best, strict=True))
    at_x, at_y = xs[index[chosen[0]]], ys[index[chosen[1]]]
    value = in_unit(float(np.asarray(data.values)[best]), unit)
    word = "largest" if sense == "maximise" else "smallest"
    axes.plot(
        at_x,
        at_y,
        "*",
        ms=12,
        mfc="#d55e00",
        mec="white",
        mew=0.8,
        ls="",
        clip_on=False,
        zorder=5,
        label=f"{word}: {value}",
    )
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.set_title(f"{readable(quantity)[:1].upper()}{readable(quantity)[1:]}")
    figure.legend(loc="outside lower center", ncols=3, fontsize=SMALL)
    if other_axes:
        words = ", ".join(
            f"{readable(name)} {in_unit(float(data[name].values[i]), _axis(data, name)[1])}"
            for name, i in other_axes.items()
        )
        axes.text(1.0, 1.02, f"at {words}", transform=axes.transAxes, ha="right", fontsize=SMALL)
    return figure
