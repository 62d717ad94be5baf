"""Three bodies on springs, as the poles of a secular equation."""

import functools
import operator
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool

from ...fields import Scalar

#: Pairs that are compared, in this sequence, to sort three values.
_EXCHANGES = ((0, 1), (1, 2), (0, 1))


class Poles(NamedTuple):
    """The three bodies in ascending order of d, everything divided by `scale` [1/s²]."""

    place: tuple[Scalar, ...]
    support: tuple[Scalar, ...]
    mesh: tuple[Scalar, ...]
    corner: tuple[Scalar, ...]
    #: κ_j g_j, with a floor far below rounding, so that no weight is zero.
    weight: tuple[Scalar, ...]
    #: d_2 − d_1 and d_3 − d_2, at least rounding.
    gaps: tuple[Scalar, Scalar]
    scale: Scalar
    #: Which pairs were exchanged in sorting, in the sequence (0, 1), (1, 2), (0, 1).
    swapped: tuple[Bool[Array, ""], ...]


def rounding(like: Scalar) -> float:
    return float(jnp.finfo(like.dtype).eps)


def added(values: Iterable[Scalar]) -> Scalar:
    return functools.reduce(operator.add, values)


def shortest(like: Scalar) -> float:
    """A distance that is practically zero, but can be a divisor."""
    return rounding(like) ** 5


def sorted_poles(
    support: list[Scalar], mesh: list[Scalar], mass: list[Scalar], factor: Scalar
) -> Poles:
    """Poles of three bodies; the roller's mass is the last of four.

    The scale, and with it every eigenvalue, is NaN if a stiffness is negative, a mass not positive,
    or a number is NaN.
    """
    inverse = [1 / value for value in mass]
    corner = [stiffness * inverse[3] for stiffness in mesh]
    on_support = [stiffness * part for stiffness, part in zip(support, inverse, strict=False)]
    squared = factor * factor
    on_mesh = [squared * stiffness * part for stiffness, part in zip(mesh, inverse, strict=False)]
    # The sum of all roots.
    scale = added(on_support) + added(on_mesh) + added(corner)
    unit = 1 / jnp.where(scale > 0, scale, 1.0)
    # The roots interlace the poles only if no stiffness and no mass is negative.
    weakest = functools.reduce(jnp.minimum, [*on_support, *on_mesh, *corner])
    stable = weakest >= 0
    corner, on_support, on_mesh = (
        [v * unit for v in values] for values in (corner, on_support, on_mesh)
    )
    place = [a + g for a, g in zip(on_support, on_mesh, strict=True)]
    swapped = []
    for i, j in _EXCHANGES:
        swap = place[i] > place[j]
        for values in (place, on_support, on_mesh, corner):
            values[i], values[j] = _exchanged(swap, values[i], values[j])
        swapped.append(swap)
    eps = rounding(unit)
    gaps = [
        jnp.maximum(place[j] - place[i], 2 * eps * place[j] + eps**4) for i, j in ((0, 1), (1, 2))
    ]
    return Poles(
        place=tuple(place),
        support=tuple(on_support),
        mesh=tuple(on_mesh),
        corner=tuple(corner),
        weight=tuple(k * g + eps**4 for k, g in zip(corner, on_mesh, strict=True)),
        gaps=(gaps[0], gaps[1]),
        scale=jnp.where(stable, scale, jnp.nan),
        swapped=tuple(swapped),
    )


def _exchanged(swap: Bool[Array, ""], left: Scalar, right: Scalar) -> tuple[Scalar, Scalar]:
    """Both values, exchanged where `swap`."""
    return jnp.where(swap, right, left), jnp.where(swap, left, right)


def in_given_order(poles: Poles, values: Sequence[Scalar]) -> list[Scalar]:
    """Values of the sorted bodies, in the order in which the bodies were given."""
    values = list(values)
    for swap, (i, j) in zip(poles.swapped[::-1], _EXCHANGES[::-1], strict=True):
        values[i], values[j] = _exchanged(swap, values[i], values[j])
    return values
