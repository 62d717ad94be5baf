"""Directions in the space of the numbers of a mechanism, along which quantities are differentiated.

The physics is traced once for any number of directions, and only along numbers that one of them
moves: derivatives along the others would be compiled as well, and be multiplied by 0.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
from jaxtyping import Array

from ...fields import Scalar
from .._mechanism import Mechanism
from ._parameters import Parameter
from ._set_parameters import set_parameters, written_out

#: A function that moves a mechanism, and the numbers at which it leaves it as it is.
Move: TypeAlias = tuple[Callable[[Any], Mechanism], Any]


class Directions(NamedTuple):
    """The numbers of a mechanism that move, and how they move along each direction.

    - `points`: the numbers that move.
    - `tangents`: for each of them its changes, directions first.
    - `placed`: the mechanism with other values of these numbers.
    """

    points: list[Array]
    tangents: list[Array]
    placed: Callable[[Sequence[Array]], Mechanism]


def move_alone(mechanism: Mechanism, numbers: Sequence[Parameter]) -> Move:
    """Numbers that change by equal amounts, together with the dimensions that follow from them."""

    def moved(values: tuple[Scalar, ...]) -> Mechanism:
        result = mechanism
        for number, value in zip(numbers, values, strict=True):
            result = number.set(result, value)
        return result

    return moved, tuple(number.get(mechanism) for number in numbers)


def move_while_others_stay(mechanism: Mechanism, name: str, values: Mapping[str, Scalar]) -> Move:
    """One of several numbers that are set together; the others keep their values.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `name`: the number that changes.
    - `values`: the present value of each number, in the order in which they are set.
    """

    def moved(value: Scalar) -> Mechanism:
        return set_parameters(mechanism, {**values, name: value}, checked=False)

    return moved, values[name]


def directions_of(
    mechanism: Mechanism, moves: Sequence[Move], numbers: Sequence[Parameter]
) -> Directions:
    """The directions of moves, each by itself: none depends on which others are in the list.

    **Arguments:**

    - `mechanism`: the mechanism; its numbers may be traced.
    - `moves`: from `move_alone` or `move_while_others_stay`.
    - `numbers`: all numbers that are set by a move.
    """
    kept = {id(leaf) for leaf in jax.tree.leaves(mechanism)}
    structure = jax.tree.structure(mechanism)
    added = [
        number.path
        for number in numbers
        if jax.tree.structure(number.set(mechanism, number.get(mechanism))) != structure
    ]
    changed: list[bool] = []

    def direction(move: Move) -> tuple[Mechanism, Mechanism]:
        place, values = move

        def moved_to(values) -> Mechanism:
            moved = written_out(place(values), added)
            # A number that the move does not touch is the same object as before.
            here = [id(leaf) not in kept for leaf in jax.tree.leaves(moved)]
            changed[:] = map(max, changed, here) if changed else here
            return moved

        return jax.jvp(moved_to, (values,), (jax.tree.map(jnp.ones_like, values),))

    pairs = [direction(move) for move in moves]
    leaves, whole = jax.tree.flatten(pairs[0][0])
    tangents = zip(*(jax.tree.leaves(along) for _, along in pairs), strict=True)

    def placed(points: Sequence[Array]) -> Mechanism:
        rest = iter(points)
        every = [next(rest) if one else leaf for leaf, one in zip(leaves, changed, strict=True)]
        return jax.tree.unflatten(whole, every)

    return Directions(
        [leaf for leaf, one in zip(leaves, changed, strict=True) if one],
        [jnp.stack(along) for along, one in zip(tangents, changed, strict=True) if one],
        placed,
    )
