"""A picture of one quantity of any sweep: lines, a map, slices, or points."""

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from ...mechanism import Constraint
from .._style import Figure, drawn
from ._common import marks_of
from ._limits import Constraints, best_design, constraints_in, limits_of, outside_of
from ._sweep_lines import sweep_lines, sweep_points
from ._sweep_map import map_with_note
from ._sweep_slices import sweep_slices

#: Largest number of designs in a picture; if there are more, every second, third, … value of an
#: axis is drawn.
_MOST = 250_000
#: Largest numbers of components of a quantity, and of points against an axis.
_COMPONENTS, _POINTS = 6, 4000
#: Of the choice of points.
_SEED = 0
_DESIGN = "design"


@drawn
def sweep_figure(
    dataset: Any,
    quantity: str,
    *,
    sense: Literal["maximise", "minimise"] = "maximise",
    constraints: Constraints = None,
) -> Figure:
    """Draw a quantity of a sweep in the way that fits its axes.

    | designs | picture |
    | --- | --- |
    | one axis | a line for each component; crosses and dots as below |
    | two axes | `sweep_map`; a panel for each component if there are several |
    | more axes | maps of the first two axes at 6 values of the third, through the best design |
    | `list`, `lhs`, `sobol` | points against each axis |

    Crosses mark designs that failed, on the lower edge where the picture has an axis of the
    quantity, and dots designs in which `check` finds an error. With more than 250,000 designs only
    every second, third, … value of the longest axes is drawn; of more than 4,000 points 4,000 are
    chosen at random, always the same. The best of all designs is drawn too, and the legend says how
    many are drawn. Only the first 6 components are drawn.

    With `constraints`, maps have a line where a quantity is at its limit, with ticks on the side
    outside, which is hatched. Over one axis the ranges outside are hatched; limits of the drawn
    quantity are levels. Points outside are hollow. A star marks the best design within all limits.
    If a limited quantity has several components, the one furthest beyond the limit counts.

    **Arguments:**

    - `dataset`: an `xarray.Dataset` from a sweep.
    - `quantity`: name of a variable in it.
    - `sense`: whether the best design has the largest or the smallest value.
    - `constraints`: (lower, upper) [SI] by the name of a variable, `None` for no limit on a side,
      or one number for an equality, which has a line and excludes no design; or the `constraints`
      of a design problem.

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
    limited = constraints_in(dataset, constraints)
    names = [quantity, *(name for name in ("code", "error") if name in dataset)]
    names += [one.quantity for one in limited]
    part = dataset[list(dict.fromkeys(names))]
    kept = _kept(part, designs)
    note = ""
    if kept:
        best = _place_of_best(part, quantity, limited, designs, sense)
        part = part.isel({name: np.union1d(places, best[name]) for name, places in kept.items()})
        few, many = (math.prod(one.sizes[name] for name in designs) for one in (part, dataset))
        note = f"{few} of {many} designs drawn"
    part = part.isel({d: 0 for d in designs if d not in long_axes}).load()
    if designs != (_DESIGN,):
        # Axes may be given in any order; lines and contours need an ascending one.
        part = part.sortby(long_axes)
    limits = limits_of(part, limited, long_axes)
    own = [str(d) for d in part[quantity].dims if d not in designs]
    part = part.assign({quantity: _flat(part[quantity], own)})
    if not np.isfinite(part[quantity].values).any():
        raise ValueError(f"no design of the picture has a {quantity!r}; every one failed")
    if designs == (_DESIGN,):
        return sweep_points(part, quantity, limits, sense, note)
    if len(long_axes) == 1:
        return sweep_lines(part, quantity, long_axes[0], limits, sense, note)
    if len(long_axes) == 2 and part.sizes["component"] == 1:
        first = part.isel(component=0)
        more: Any = {"sense": sense, "constraints": limited or None, "note": note}
        return map_with_note(first, quantity, **more)
    return sweep_slices(part, quantity, long_axes, limits, sense, note)


def _kept(dataset: Any, designs: tuple[str, ...]) -> dict[str, np.ndarray]:
    """By axis: places of the values that are drawn; empty if all are drawn."""
    if designs == (_DESIGN,):
        many = dataset.sizes[_DESIGN]
        # Every second design of Sobol's sequence would be in one half of the range of an axis.
        chosen = np.random.default_rng(_SEED).permutation(many)[:_POINTS]
        return {_DESIGN: chosen} if many > _POINTS else {}
    steps = dict.fromkeys(designs, 1)

    def length(name: str) -> int:
        return -(-dataset.sizes[name] // steps[name])

    while math.prod(map(length, designs)) > _MOST:
        steps[max(designs, key=length)] += 1
    places = {name: np.arange(0, dataset.sizes[name], step) for name, step in steps.items()}
    return places if max(steps.values()) > 1 else {}


def _place_of_best(
    dataset: Any,
    quantity: str,
    limited: Sequence[Constraint],
    designs: tuple[str, ...],
    sense: Literal["maximise", "minimise"],
) -> dict[str, int]:
    """Along each axis, the place of the best of all designs by the first component."""
    data = dataset[quantity]
    data = data.isel({d: 0 for d in data.dims if d not in designs}).transpose(*designs)
    values = np.asarray(data.values, float)
    if not np.isfinite(values).any():
        raise ValueError(f"no design of the picture has a {quantity!r}; every one failed")
    flags = dataset["code"].copy(data=marks_of(dataset)[1]).transpose(*designs)
    limits = limits_of(dataset, limited, designs)
    outside = outside_of(limits, data).values if limits else None
    return dict(zip(designs, best_design(values, flags.values, outside, sense).place, strict=True))


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
