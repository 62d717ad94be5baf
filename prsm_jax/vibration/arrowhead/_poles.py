"""Three bodies on springs, as the poles of a secular equation."""

import functools
import operator
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool

from ...mechanism import Scalar

#: Neighbours that are compared, in turn, to sort three.
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
    #: Which neighbours were exchanged to sort them, in turn: (0, 1), (1, 2), (0, 1).
    swapped: tuple[Bool[Array, ""], ...]


def rounding(like: Scalar) -> float:
    return float(jnp.finfo(like.dtype).eps)


def added(values: Iterable[Scalar]) -> Scalar:
    return functools.reduce(operator.add, values)


def shortest(like: Scalar) -> float:
    """A distance that is zero for every purpose but that of dividing by it."""
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
    held = [stiffness * part for stiffness, part in zip(support, inverse, strict=False)]
    squared = factor * factor
    tied = [squared * stiffness * part for stiffness, part in zip(mesh, inverse, strict=False)]
    # The sum of all roots.
    scale = added(held) + added(tied) + added(corner)
    unit = 1 / jnp.where(scale > 0, scale, 1.0)
    # The roots interlace the poles only where every stiffness pulls back and every mass is one.
    weakest = functools.reduce(jnp.minimum, [*held, *tied, *corner])
    stable = weakest >= 0
    corner, held, tied = ([v * unit for v in values] for values in (corner, held, tied))
    place = [a + g for a, g in zip(held, tied, strict=True)]
    swapped = []
    for i, j in _EXCHANGES:
        wrong = place[i] > place[j]
        for values in (place, held, tied, corner):
            values[i], values[j] = _exchanged(wrong, values[i], values[j])
        swapped.append(wrong)
    eps = rounding(unit)
    gaps = [
        jnp.maximum(place[j] - place[i], 2 * eps * place[j] + eps**4) for i, j in ((0, 1), (1, 2))
    ]
    return Poles(
        place=tuple(place),
        support=tuple(held),
        mesh=tuple(tied),
        corner=tuple(corner),
        weight=tuple(k * g + eps**4 for k, g in zip(corner, tied, strict=True)),
        gaps=(gaps[0], gaps[1]),
        scale=jnp.where(stable, scale, jnp.nan),
        swapped=tuple(swapped),
    )


def _exchanged(wrong: Bool[Array, ""], left: Scalar, right: Scalar) -> tuple[Scalar, Scalar]:
    """Both values, the other way round where `wrong`."""
    return jnp.where(wrong, right, left), jnp.where(wrong, left, right)


def in_given_order(poles: Poles, values: Sequence[Scalar]) -> list[Scalar]:
    """Values of the sorted bodies, in the order in which the bodies were given."""
    values = list(values)
    for wrong, (i, j) in zip(poles.swapped[::-1], _EXCHANGES[::-1], strict=True):
        values[i], values[j] = _exchanged(wrong, values[i], values[j])
    return values
