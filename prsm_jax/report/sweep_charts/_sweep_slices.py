"""Maps of a sweep with several components, or with more than two axes."""

import dataclasses
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from .._parts import colour_bar, map_of_one_value, page_title
from .._style import INK, SMALL, Figure, page_figure
from ._boundaries import draw_on_map, limit_entries
from ._common import (
    label_of,
    mark_best,
    marks_of,
    place_in_words,
    sweep_legend,
    title_of,
    unit_of,
)
from ._limits import QuantityLimit, best_design, cut, outside_of

#: Largest number of slices of a third axis.
_SLICES = 6


def sweep_slices(
    part: Any,
    quantity: str,
    axes_names: list[str],
    limits: Sequence[QuantityLimit],
    sense: Literal["maximise", "minimise"],
    note: str = "",
) -> Figure:
    """Maps of the first two axes: a panel for each component, or for values of the third axis."""
    x_name, y_name, *others = axes_names
    data = part[quantity].transpose(*axes_names, "component")
    values = np.asarray(data.values, float)
    first = data.isel(component=0)
    failed, errors = (
        part["code"].copy(data=flags).transpose(*axes_names).values for flags in marks_of(part)
    )
    outside = outside_of(limits, first).values if limits else None
    best = best_design(values[..., 0], errors, outside, sense)
    behind = best.place[2:]
    if data.sizes["component"] > 1 or not others:
        panels = [(behind, index) for index in range(data.sizes["component"])]
    else:
        length = data.sizes[others[0]]
        third = np.unique(np.round(np.linspace(0, length - 1, _SLICES)).astype(int))
        # One of the slices goes through the best design.
        third[np.argmin(np.abs(third - behind[0]))] = behind[0]
        panels = [((int(i), *behind[1:]), 0) for i in third]
    unit, x_unit, y_unit = unit_of(data, quantity), unit_of(part[x_name]), unit_of(part[y_name])
    x, y = (
        one(np.asarray(part[name].values, float))
        for one, name in ((x_unit, x_name), (y_unit, y_name))
    )
    shown = [unit(values[(slice(None), slice(None), *place, index)].T) for place, index in panels]
    columns = 2 if len(panels) == 4 else min(3, len(panels))
    rows = -(-len(panels) // columns)
    figure = page_figure(24 + 58 * rows + 2.5 * len(limits), min(180, 40 + 55 * columns))
    drawn_panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    alike = data.sizes["component"] == 1
    everything = np.concatenate([plane.ravel() for plane in shown])
    image: Any = None
    like = first.isel(dict.fromkeys(others, 0), drop=True).transpose(y_name, x_name)
    cuts = [
        [cut(one, dict(zip(others, place, strict=True)), like) for one in limits]
        for place, _ in panels
    ]
    entries = limit_entries(_joined(limits, cuts))
    for axes, plane, (place, index), here in zip(drawn_panels, shown, panels, cuts, strict=False):
        image = _plane(axes, (x, y), plane, everything if alike else plane.ravel()) or image
        if not alike and image is not None:
            colour_bar(figure, image, axes, "")
        draw_on_map(axes, x, y, here)
        flags = (flag[(slice(None), slice(None), *place)].T for flag in (failed, errors))
        for flag, marker, size, label in zip(
            flags, "x.", (3, 2.5), ("failed", "error of prsm check"), strict=True
        ):
            at = np.argwhere(flag)
            if at.size:
                dots: dict[str, Any] = {"color": INK, "ms": size, "clip_on": False}
                axes.plot(x[at[:, 1]], y[at[:, 0]], marker, label=label, **dots)
        if alike and behind == place:
            mark_best(axes, x[best.place[0]], y[best.place[1]], best, unit, entries)
        if alike:
            axes.set_title(place_in_words(part, others[:1], place[:1]), fontsize=SMALL)
        else:
            axes.set_title(str(data["component"].values[index]), fontsize=SMALL)
    for number, axes in enumerate(drawn_panels):
        if number >= len(panels):
            axes.remove()
            continue
        if number % columns == 0:
            axes.set_ylabel(label_of(y_name, y_unit))
        if number + columns >= len(panels):
            axes.set_xlabel(label_of(x_name, x_unit))
            axes.tick_params(labelbottom=True)
    if alike and image is not None:
        colour_bar(figure, image, list(drawn_panels[: len(panels)]), label_of(quantity, unit))
    fixed = place_in_words(part, others[1:] if alike else others, behind[1:] if alike else behind)
    heading = title_of(quantity) if alike else f"{title_of(quantity)} in {unit.label}"
    page_title(figure, f"{heading}, at {fixed}" if fixed else heading)
    sweep_legend(figure, entries, note, most=2 if limits else 4)
    return figure


def _joined(
    limits: Sequence[QuantityLimit], cuts: list[list[QuantityLimit]]
) -> list[QuantityLimit]:
    """The limits over all panels."""
    import xarray

    return [
        dataclasses.replace(one, excess=xarray.concat([c.excess for c in panels], "panel"))
        for one, *panels in zip(limits, *cuts, strict=True)
    ]


def _plane(axes: Any, where: tuple[Any, Any], plane: np.ndarray, scale: np.ndarray) -> Any:
    """Filled contours; nothing if no design of the plane has a value."""
    from matplotlib.ticker import MaxNLocator

    finite = scale[np.isfinite(scale)]
    if not finite.size or not np.isfinite(plane).any():
        return None
    masked = np.ma.masked_invalid(plane)
    if finite.min() == finite.max():
        return map_of_one_value(axes, *where, masked)
    levels = MaxNLocator(14).tick_values(finite.min(), finite.max())
    return axes.contourf(*where, masked, levels=levels, cmap="cividis")
