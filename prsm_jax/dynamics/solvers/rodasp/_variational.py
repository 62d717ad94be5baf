"""Derivatives of one step of states in a chain, by the variational equation along the solution."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ....numerics import apart
from .._driven_rate import DrivenRate
from ._jacobians import chain_jacobian, node_inverses, node_slopes


class Slopes(NamedTuple):
    """Derivatives of a step: of the state at its end, and of its interpolation."""

    end: Float[Array, " states"]
    first: Float[Array, " states"]
    second: Float[Array, " states"]


class Given(NamedTuple):
    """What a step depends on, or its derivatives; a derivative that is zero may be `None`."""

    field: DrivenRate
    #: The drive at the nodes of the step (`NODES`).
    drives: Sequence[Any]
    #: A scalar, and an array of the states.
    length: Any
    state: Any
    args: Any


def of_start_and_length(start, d_start, d_end) -> tuple[Any, Any]:
    """Derivatives of the start and of the length of a step; `None` where no end moves.

    **Arguments:**

    - `start`: of the step.
    - `d_start`, `d_end`: derivatives of its ends, or `None`.
    """
    if d_start is None and d_end is None:
        return None, None
    d_start, d_end = (jnp.zeros_like(start) if d is None else d for d in (d_start, d_end))
    return d_start, d_end - d_start


def step_slopes(
    given: Given, derivatives: Given, states: Sequence[Float[Array, " states"]]
) -> Slopes:
    """Derivatives of a step in one direction, by the variational equation.

    The rates depend on a parameter directly, through the drive, and through the ends of the step,
    which move with a reversal: `dz/ds = h (J z + g) + (dh) f`, with s from 0 to 1.

    **Arguments:**

    - `given`, `derivatives`: what the step depends on, and derivatives of it.
    - `states`: the states at the nodes of the step.
    """
    chain, length, d_length = given.field.chain, given.length, derivatives.length
    assert chain is not None
    jacobians, forcing = [], []
    for drive, d_drive, state in zip(given.drives, derivatives.drives, states, strict=True):
        numbers = list(state)
        jacobians.append(chain_jacobian(chain, drive, numbers, given.args))
        rates, changes = eqx.filter_jvp(
            lambda field, drive, args, numbers=numbers: field.chain(drive, numbers, args),
            (given.field, drive, given.args),
            (derivatives.field, d_drive, derivatives.args),
        )
        forcing.append(
            [
                (0.0 if d_rate is None else length * d_rate)
                + (0.0 * rate if d_length is None else d_length * rate)
                for rate, d_rate in zip(rates, changes, strict=True)
            ]
        )
    start = jnp.zeros_like(given.state) if derivatives.state is None else derivatives.state
    # Separate parts, because the three slopes of all states use the same numbers.
    inverses = apart(node_inverses)(jacobians, length)
    slopes = apart(node_slopes)(jacobians, inverses, forcing, length, list(start))
    first, middle, last = (jnp.stack([of_state[node] for of_state in slopes]) for node in range(3))
    # The cubic with these slopes, which ends where the method ends.
    total = (first + 4 * middle + last) / 6
    return Slopes(start + total, first - total, 2 * total - first - last)


__all__ = ["Given", "Slopes", "of_start_and_length", "step_slopes"]
