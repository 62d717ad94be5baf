"""A picture of one quantity of any sweep: lines, a map, slices, or points."""

import math
from typing import Any, Literal

import numpy as np

from ...text import DisplayUnit, display_unit, in_unit
from .._parts import colour_bar, in_words, legend_below, page_title
from .._style import INK, SERIES, SMALL, Figure, drawn, page_figure, readable
from ._sweep_map import sweep_map

#: Designs in a picture; of more, every second, third, … along the axes is drawn.
_MOST = 250_000
#: Slices of a third axis, components of a quantity, and points of a scatter.
_SLICES, _COMPONENTS, _POINTS = 6, 6, 4000
_DESIGN = "design"


@drawn
def sweep_figure(
    dataset: Any, quantity: str, *, sense: Literal["maximise", "minimise"] = "maximise"
) -> Figure:
    """Draw a quantity of a sweep in the way that fits its axes.

    | designs | picture |
    | --- | --- |
    | one axis | a line for each component; crosses and dots as below |
    | two axes | `sweep_map`; a panel for each component if there are several |
    | more axes | maps of the first two axes at 6 values of the third, through the best design |
    | `list`, `lhs`, `sobol` | points against each axis |

    Crosses mark designs that failed, on the lower edge where the picture has an axis of the
    quantity, and dots designs in which `check` finds an error. Of more than 250,000 designs every
    second, third, … value of the longest axes is drawn; of points, 4,000. Of more than 6
    components the first 6 are drawn.

    **Arguments:**

    - `dataset`: an `xarray.Dataset` from a sweep.
    - `quantity`: name of a variable in it.
    - `sense`: whether the best design has the largest or the smallest value.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` for an unknown name, a sweep of one design, or when no design
    succeeded; `MissingExtraError` without matplotlib.
    """
    if quantity not in dataset:
        raise ValueError(f"the sweep has no {quantity!r}; it has {', '.join(dataset.data_vars)}")
    designs = tuple(map(str, dataset["code"].dims))
    long_axes = [d for d in designs if dataset.sizes[d] > 1]
    if not long_axes:
        raise ValueError(f"a picture of {quantity!r} needs more than one design")
    names = [quantity, *(name for name in ("code", "error") if name in dataset)]
    part = _thinned(dataset[names], designs)
    part = part.isel({d: 0 for d in designs if d not in long_axes}).load()
    if designs != (_DESIGN,):
        # Axes may be given in any order; lines and contours need an ascending one.
        part = part.sortby(long_axes)
    own = [str(d) for d in part[quantity].dims if d not in designs]
    part = part.assign({quantity: _flat(part[quantity], own)})
    if not np.isfinite(part[quantity].values).any():
        raise ValueError(f"no design of the picture has a {quantity!r}; every one failed")
    if designs == (_DESIGN,):
        return _points(part, quantity)
    if len(long_axes) == 1:
        return _lines(part, quantity, long_axes[0])
    if len(long_axes) == 2 and part.sizes["component"] == 1:
        return sweep_map(part.isel(component=0), quantity, sense=sense)
    return _slices(part, quantity, long_axes, sense)


def _thinned(dataset: Any, designs: tuple[str, ...]) -> Any:
    """Every second, third, … value of the longest axes, so that few designs are left."""
    steps = dict.fromkeys(designs, 1)
    most = _POINTS if designs == (_DESIGN,) else _MOST

    def length(name: str) -> int:
        return -(-dataset.sizes[name] // steps[name])

    while math.prod(map(length, designs)) > most:
        steps[max(designs, key=length)] += 1
    return dataset.isel({name: slice(None, None, step) for name, step in steps.items()})


def _flat(data: Any, own: list[str]) -> Any:
    """A quantity with one axis of components, the first few; their names are a coordinate."""
    shape = [data.sizes[d] for d in own]
    moved = data.transpose(*(d for d in data.dims if d not in own), *own)
    values = moved.values.reshape(*moved.shape[: moved.ndim - len(own)], -1)[..., :_COMPONENTS]
    words = [
        ", ".join(
            f"{d.removeprefix(f'{data.name}_')} {i + 1}"
            for d, i in zip(own, place, strict=True)
            if data.sizes[d] > 1
        )
        for place in np.ndindex(*shape)
    ]
    import xarray

    flat = xarray.DataArray(
        values,
        dims=[*(d for d in data.dims if d not in own), "component"],
        coords={n: c for n, c in data.coords.items() if not set(c.dims) & set(own)},
        attrs=data.attrs,
        name=data.name,
    )
    return flat.assign_coords(component=words[:_COMPONENTS])


def _unit_of(data: Any, quantity: str = "") -> DisplayUnit:
    values = np.asarray(data.values, float)
    finite = values[np.isfinite(values)]
    ends = [float(finite.min()), float(finite.max())]
    return display_unit(str(data.attrs.get("units", "1")), ends, quantity)


def _label(name: str, unit: DisplayUnit) -> str:
    return in_words(readable(name.rpartition(".")[2]), unit)


def _title(name: str) -> str:
    return f"{readable(name)[:1].upper()}{readable(name)[1:]}"


def _marks(part: Any) -> tuple[np.ndarray, np.ndarray]:
    """Of each design: whether it failed, and whether `check` finds an error in another one."""
    failed = part["code"].values != 0
    errors = part["error"].values != 0 if "error" in part else np.zeros_like(failed)
    return failed, errors & ~failed


def _mark(axes: Any, x: np.ndarray, y: np.ndarray, failed: np.ndarray, errors: np.ndarray) -> None:
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


def _legend(figure: Figure) -> None:
    found: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    legend_below(figure, list(found.values()), most=4, fontsize=SMALL)


def _lines(part: Any, quantity: str, axis: str) -> Figure:
    data = part[quantity]
    unit, x_unit = _unit_of(data, quantity), _unit_of(part[axis])
    x, y = x_unit(np.asarray(part[axis].values, float)), unit(np.asarray(data.values, float))
    figure = page_figure(90, 150)
    axes = figure.add_subplot()
    words = list(data["component"].values)
    # A design between two that failed has no neighbour to draw a line to.
    marker: dict[str, Any] = {"marker": "o", "ms": 3} if len(x) <= 30 else {}
    for index, word in enumerate(words):
        style: dict[str, Any] = {"label": str(word)} if len(words) > 1 else {}
        axes.plot(x, y[:, index], color=SERIES[index % len(SERIES)], lw=1.4, **marker, **style)
    axes.margins(y=0.1)
    _mark(axes, x, y, *_marks(part))
    axes.set_xlabel(_label(axis, x_unit))
    axes.set_ylabel(in_words(readable(quantity), unit))
    axes.set_title(_title(quantity))
    _legend(figure)
    return figure


def _points(part: Any, quantity: str) -> Figure:
    data = part[quantity]
    unit = _unit_of(data, quantity)
    y = unit(np.asarray(data.values, float))
    names = [str(name) for name, c in part.coords.items() if c.dims == (_DESIGN,)]
    columns = 2 if len(names) == 4 else min(3, len(names))
    rows = -(-len(names) // columns)
    figure = page_figure(20 + 60 * rows, 30 + 55 * columns)
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True)
    words = list(data["component"].values)
    failed, errors = _marks(part)
    for place, axes in enumerate(panels.ravel()):
        if place >= len(names):
            axes.remove()
            continue
        x_unit = _unit_of(part[names[place]])
        x = x_unit(np.asarray(part[names[place]].values, float))
        for index, word in enumerate(words):
            style: dict[str, Any] = {"label": str(word)} if len(words) > 1 else {}
            axes.plot(
                x,
                y[:, index],
                ls="",
                marker="o",
                ms=3 if len(x) < 500 else 1.5,
                mew=0,
                color=SERIES[index % len(SERIES)],
                **style,
            )
        _mark(axes, x, y, failed, errors)
        axes.set_xlabel(_label(names[place], x_unit))
        if place % columns == 0:
            axes.set_ylabel(in_words(readable(quantity), unit))
    page_title(figure, _title(quantity))
    _legend(figure)
    return figure


def _slices(part: Any, quantity: str, axes_names: list[str], sense: str) -> Figure:
    """Maps of the first two axes: a panel for each component, or for values of the third axis."""
    x_name, y_name, *others = axes_names
    data = part[quantity].transpose(*axes_names, "component")
    values = np.asarray(data.values, float)
    failed, errors = (
        part["code"].copy(data=flags).transpose(*axes_names).values for flags in _marks(part)
    )
    usable = np.where(errors[..., None], np.nan, values)
    usable = usable if np.isfinite(usable).any() else values
    pick = np.nanargmax if sense == "maximise" else np.nanargmin
    best = np.unravel_index(pick(usable[..., 0]), failed.shape)
    if data.sizes["component"] > 1 or not others:
        panels = [(best[2:], index) for index in range(data.sizes["component"])]
    else:
        length = data.sizes[others[0]]
        third = np.unique(np.round(np.linspace(0, length - 1, _SLICES)).astype(int))
        # One of the slices goes through the best design.
        third[np.argmin(np.abs(third - best[2]))] = best[2]
        panels = [((int(i), *best[3:]), 0) for i in third]
    unit, x_unit, y_unit = _unit_of(data, quantity), _unit_of(part[x_name]), _unit_of(part[y_name])
    x, y = (
        one(np.asarray(part[name].values, float))
        for one, name in ((x_unit, x_name), (y_unit, y_name))
    )
    shown = [unit(values[(slice(None), slice(None), *place, index)].T) for place, index in panels]
    columns = 2 if len(panels) == 4 else min(3, len(panels))
    rows = -(-len(panels) // columns)
    figure = page_figure(24 + 58 * rows, min(180, 40 + 55 * columns))
    drawn_panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    alike = data.sizes["component"] == 1
    everything = np.concatenate([plane.ravel() for plane in shown])
    image: Any = None
    for axes, plane, (place, index) in zip(drawn_panels, shown, panels, strict=False):
        image = _plane(axes, (x, y), plane, everything if alike else plane.ravel()) or image
        if not alike and image is not None:
            colour_bar(figure, image, axes, "")
        flags = (flag[(slice(None), slice(None), *place)].T for flag in (failed, errors))
        for flag, marker, size, label in zip(
            flags, "x.", (3, 2.5), ("failed", "error of prsm check"), strict=True
        ):
            at = np.argwhere(flag)
            if at.size:
                dots: dict[str, Any] = {"color": INK, "ms": size, "clip_on": False}
                axes.plot(x[at[:, 1]], y[at[:, 0]], marker, label=label, **dots)
        if alike and (*best[2:],) == (*place,):
            value = in_unit(float(values[(*best, 0)]), unit)
            word = "largest" if sense == "maximise" else "smallest"
            style: dict[str, Any] = {"mfc": "#d55e00", "mec": "white", "clip_on": False}
            at_x, at_y = x[best[0]], y[best[1]]
            axes.plot(at_x, at_y, "*", ms=11, zorder=5, ls="", label=f"{word}: {value}", **style)
        if alike:
            axes.set_title(_at(part, others[:1], place[:1]), fontsize=SMALL)
        else:
            axes.set_title(str(data["component"].values[index]), fontsize=SMALL)
    for number, axes in enumerate(drawn_panels):
        if number >= len(panels):
            axes.remove()
            continue
        if number % columns == 0:
            axes.set_ylabel(_label(y_name, y_unit))
        if number + columns >= len(panels):
            axes.set_xlabel(_label(x_name, x_unit))
            axes.tick_params(labelbottom=True)
    if alike and image is not None:
        colour_bar(figure, image, list(drawn_panels[: len(panels)]), _label(quantity, unit))
    fixed = _at(part, others[1:] if alike else others, best[3:] if alike else best[2:])
    heading = _title(quantity) if alike else f"{_title(quantity)} in {unit.label}"
    page_title(figure, f"{heading}, at {fixed}" if fixed else heading)
    _legend(figure)
    return figure


def _plane(axes: Any, where: tuple[Any, Any], plane: np.ndarray, scale: np.ndarray) -> Any:
    """Filled contours; nothing if no design of the plane has a value."""
    from matplotlib.ticker import MaxNLocator

    finite = scale[np.isfinite(scale)]
    if not finite.size or not np.isfinite(plane).any():
        return None
    masked = np.ma.masked_invalid(plane)
    if finite.min() == finite.max():
        return axes.pcolormesh(*where, masked, shading="nearest", cmap="cividis")
    levels = MaxNLocator(14).tick_values(finite.min(), finite.max())
    return axes.contourf(*where, masked, levels=levels, cmap="cividis")


def _at(part: Any, names: list[str], places: Any) -> str:
    words = []
    for name, place in zip(names, places, strict=False):
        found = part[name].values[place]
        whole = np.issubdtype(part[name].dtype, np.integer)
        value = str(found) if whole else in_unit(float(found), _unit_of(part[name]))
        words.append(f"{readable(name.rpartition('.')[2])} {value}")
    return ", ".join(words)
