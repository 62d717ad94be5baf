"""Plans: which designs a sweep computes, and in which blocks.

A block is a range of neighbouring designs that is computed and stored as a whole. Its edges are
those of the chunks of a zarr array, so that no two processes write to one file.
"""

import itertools
import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from ..fields import FEWEST_TRACED
from ..mechanism import Mechanism, set_parameters
from ..numerics import latin_hypercube, sobol_points
from ._axes import Axis, axes_of

#: `grid`: all combinations of the values. `list`: the first value of each axis, then the second,
#: and so on. `lhs`: a Latin hypercube, and `sobol`: Sobol's sequence, between two limits.
PlanName = Literal["grid", "list", "lhs", "sobol"]

#: Name of the dimension of plans that are not a grid.
DESIGN = "design"


@dataclass(frozen=True)
class Plan:
    """Designs of a sweep, numbered in the order in which the last axis changes fastest."""

    kind: PlanName
    #: For a grid the values along each dimension; for other plans the values of all designs.
    axes: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        if self.kind == "grid":
            return tuple(len(axis.values) for axis in self.axes)
        return (len(self.axes[0].values),)

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return tuple(axis.name for axis in self.axes) if self.kind == "grid" else (DESIGN,)

    @property
    def points(self) -> int:
        """Number of designs."""
        return math.prod(self.shape)

    def values(self, where: tuple[slice, ...]) -> dict[str, np.ndarray]:
        """Values of all axes [SI] in a block; for a grid, arrays that broadcast to its shape."""
        if self.kind != "grid":
            return {axis.name: axis.values[where] for axis in self.axes}
        parts = [axis.values[part] for axis, part in zip(self.axes, where, strict=True)]
        return dict(zip(self.dimensions, np.ix_(*parts), strict=True))

    def static_choices(self, traced: Collection[str] = ()) -> list[dict[str, int]]:
        """Every combination of values that are part of the program; an empty one if there are none.

        Values that the program takes as numbers, of the axes in `traced`, are 0.
        """
        static = [axis for axis in self.axes if axis.static]
        columns = [fixed_counts(axis.values, axis.name in traced) for axis in static]
        if self.kind == "grid":
            choices = itertools.product(*map(np.unique, columns))
        else:
            choices = dict.fromkeys(zip(*columns, strict=True)) if static else [()]
        names = [axis.name for axis in static]
        return [dict(zip(names, map(int, choice), strict=True)) for choice in choices]


def fixed_counts(values: np.ndarray, traced: bool) -> np.ndarray:
    """Whole numbers that are part of the program; 0 where the program takes them as numbers."""
    return np.where(values >= FEWEST_TRACED, 0, values) if traced else values


@dataclass(frozen=True)
class Blocks:
    """Blocks: each has all values of the last dimensions, some of one, and one of those before."""

    shape: tuple[int, ...]
    #: Shape of one block; at the end of a dimension it may be shorter.
    block: tuple[int, ...]

    @property
    def size(self) -> int:
        """The most designs in a block."""
        return math.prod(self.block)

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of blocks along each dimension."""
        return tuple(-(-n // b) for n, b in zip(self.shape, self.block, strict=True))

    def __len__(self) -> int:
        return math.prod(self.counts)

    def slices(self, number: int) -> tuple[slice, ...]:
        """Where a block lies in an array over the plan."""
        places = np.unravel_index(number, self.counts)
        return tuple(
            slice(int(i) * b, min((int(i) + 1) * b, n))
            for i, b, n in zip(places, self.block, self.shape, strict=True)
        )

    def lengths(self, number: int) -> tuple[int, ...]:
        """Shape of a block."""
        return tuple(part.stop - part.start for part in self.slices(number))

    def designs(self, number: int) -> np.ndarray:
        """Numbers of the designs of a block, which follow one another."""
        first = np.ravel_multi_index([part.start for part in self.slices(number)], self.shape)
        return np.arange(first, first + math.prod(self.lengths(number)))


def blocks_of(shape: tuple[int, ...], most: int) -> Blocks:
    """Blocks of nearly equal size with at most `most` designs each."""
    block = [1] * len(shape)
    inside = 1
    for place in reversed(range(len(shape))):
        length = shape[place]
        if inside * length <= most:
            block[place], inside = length, inside * length
            continue
        pieces = -(-length // max(1, most // inside))
        block[place] = -(-length // pieces)
        break
    return Blocks(shape, tuple(block))


def plan_of(
    mechanism: Mechanism,
    axes: Mapping[str, Iterable[Any]],
    fixed: Mapping[str, object],
    kind: PlanName,
    points: int | None,
    seed: int,
) -> Plan:
    """Check the axes and lay out the designs of a sweep.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `axes`: values [SI] by the name of a parameter; for `"lhs"` and `"sobol"` the lower and the
      upper limit.
    - `fixed`: `speed` and `load` given in addition to the axes, or `None`.
    - `kind`: how the values become designs.
    - `points`: number of designs of `"lhs"` and `"sobol"`; must be `None` for the others.
    - `seed`: of `"lhs"` and `"sobol"`.

    **Raises:** as `axes_of`; `ValueError` for an unknown plan, lists of different lengths, limits
    in the wrong order, and `points` missing, below 1, or given for a plan that does not take it.
    """
    if kind not in get_args(PlanName):
        names = ", ".join(get_args(PlanName))
        raise ValueError(f"plan is {kind!r}; it must be one of {names}")
    checked = tuple(axis for axis, _ in axes_of(mechanism, axes, fixed))
    sampled = kind in ("lhs", "sobol")
    if not sampled and points is not None:
        raise ValueError(f"points is {points}, but plan {kind!r} takes its designs from the values")
    if sampled:
        if not isinstance(points, int) or points < 1:
            raise ValueError(
                f"points is {points}; plan {kind!r} needs a number of designs, a whole number of 1 "
                "or more"
            )
        if seed < 0:
            raise ValueError(f"seed is {seed}; give a whole number of 0 or more")
        checked = _sampled(checked, kind, points, seed)
    elif kind == "list":
        lengths = {axis.name: len(axis.values) for axis in checked}
        if len(set(lengths.values())) > 1:
            words = ", ".join(f"{name} {count}" for name, count in lengths.items())
            raise ValueError(f"plan 'list' needs as many values on every axis, not {words}")
    plan = Plan(kind, checked)
    for choice in plan.static_choices():
        # An invalid whole number raises an error before anything is computed.
        with_static(mechanism, choice)
    return plan


def with_static(mechanism: Mechanism, choice: Mapping[str, int]) -> Mechanism:
    """The mechanism with these values that are part of the program; 0 keeps the present value."""
    return set_parameters(mechanism, {name: value for name, value in choice.items() if value})


def _sampled(axes: tuple[Axis, ...], kind: str, points: int, seed: int) -> tuple[Axis, ...]:
    """Values of all designs, spread between two limits of each axis."""
    for axis in axes:
        if len(axis.values) != 2 or axis.values[0] > axis.values[1]:
            raise ValueError(
                f"axis {axis.name!r} holds {', '.join(f'{v:g}' for v in axis.values)}; plan "
                f"{kind!r} needs a lower and an upper limit, in this order"
            )
    if kind == "lhs":
        places = latin_hypercube(len(axes), points, seed)
    else:
        # Sobol's points come in powers of two; the first ones of the next power are taken.
        places = sobol_points(len(axes), math.ceil(math.log2(points)), seed)[:points]

    def spread(axis: Axis, share: np.ndarray) -> Axis:
        lower, upper = axis.values
        if axis.static:
            return replace(axis, values=(lower + share * (upper - lower + 1)).astype(np.int64))
        return replace(axis, values=lower + share * (upper - lower))

    return tuple(spread(axis, share) for axis, share in zip(axes, places.T, strict=True))
