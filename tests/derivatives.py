"""Compiled derivatives of quantities, shared by the tests of gradients.

One direction at a time: such programs compile in half the time of whole Jacobians.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scenes import equal_shares, example

import prsm_jax as prsm

VARIABLES = ("lead", "contact_angle", "roller_radius")
QUANTITIES = (
    "torsional_frequencies",
    "transverse_frequencies",
    "roller_frequency",
    "carrier_frequency",
    "efficiency",
    "max_pressure_screw",
    "max_pressure_nut",
    "thread_stiffness_screw",
    "thread_stiffness_nut",
    "axial_stiffness",
)


def shipped(name):
    """A shipped example; the actuator with its profile radius given, as in its optimisation."""
    found = example(name)
    if name == "actuator":
        # How threads share has tests of its own.
        found = equal_shares(name)
        radius = prsm.get_parameter(found, "roller_profile_radius")
        found = prsm.set_parameter(found, "roller_profile_radius", radius)
    return found


def _evaluate(mechanism, changes, quantities):
    """Quantities, one after the other, with the variables changed by these shares."""
    moved = mechanism
    for variable, change in zip(VARIABLES, changes, strict=True):
        for number in range(1, len(mechanism.stages) + 1):
            path = f"stage.{number}.{variable}"
            value = prsm.get_parameter(mechanism, path)
            moved = prsm.set_parameter(moved, path, value * (1 + change))
    found = prsm.compute(moved, quantities)
    return jnp.concatenate([jnp.ravel(found[name]) for name in quantities])


@eqx.filter_jit
def value_and_slope(mechanism, changes, direction, quantities):
    """Quantities and their derivative along a direction of relative changes, forward mode."""
    return jax.jvp(lambda c: _evaluate(mechanism, c, quantities), (changes,), (direction,))


@eqx.filter_jit
def pulled_back(mechanism, weights, quantities):
    """Gradient of a weighted sum of quantities, reverse mode: to all numbers, and to changes."""
    nothing = jnp.zeros(len(VARIABLES))
    _, pullback = eqx.filter_vjp(lambda m, c: _evaluate(m, c, quantities), mechanism, nothing)
    return pullback(weights)


def all_values(leaves, rest, quantities):
    """Quantities, one after the other, of a mechanism in two parts."""
    found = prsm.compute(eqx.combine(leaves, rest), quantities)
    return jnp.concatenate([jnp.ravel(found[name]) for name in quantities])


@eqx.filter_jit
def along(leaves, direction, rest, quantities):
    """Quantities and their derivative along a change of all numbers of a mechanism at once.

    `leaves` and `rest` are the two parts of `eqx.partition(mechanism, eqx.is_inexact_array)`.
    """
    return jax.jvp(lambda x: all_values(x, rest, quantities), (leaves,), (direction,))


@eqx.filter_jit
def by_all_numbers(leaves, weights, rest, quantities):
    """Gradient of a weighted sum of quantities by all numbers of a mechanism, reverse mode."""
    return jax.vjp(lambda x: all_values(x, rest, quantities), leaves)[1](weights)[0]


def some_direction(leaves, seed):
    """A change of every number by a share of its own."""
    random = np.random.default_rng(seed)
    return jax.tree.map(lambda x: jnp.asarray(x * random.uniform(-1, 1, x.shape)), leaves)


def central_slope(leaves, direction, rest, quantities, step=1e-6):
    """Derivative along a direction by central differences; NaN where a value is infinite."""

    def at(share):
        moved = jax.tree.map(lambda x, d: x + share * d, leaves, direction)
        return np.asarray(along(moved, direction, rest, quantities)[0])

    with np.errstate(invalid="ignore"):
        return (at(step) - at(-step)) / (2 * step)


def inner(first, second):
    """Sum of the products of all numbers of two trees."""
    pairs = zip(jax.tree.leaves(first), jax.tree.leaves(second), strict=True)
    return sum(float(jnp.sum(a * b)) for a, b in pairs)


def forward(mechanism, quantities):
    """Values, and their derivatives to relative changes of the variables [quantity, variable]."""
    nothing, columns = jnp.zeros(len(VARIABLES)), []
    for direction in jnp.eye(len(VARIABLES)):
        values, slope = value_and_slope(mechanism, nothing, direction, quantities)
        columns.append(np.asarray(slope))
    return np.asarray(values), np.stack(columns, axis=1)


def reverse(mechanism, quantities, size):
    """Gradients to the whole mechanism, one per quantity, and the derivatives as in `forward`."""
    rows = [pulled_back(mechanism, weights, quantities) for weights in jnp.eye(size)]
    return [row[0] for row in rows], np.stack([np.asarray(row[1]) for row in rows])
