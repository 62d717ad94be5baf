"""Loads in place of 0, under which ratios of forces are those of a vanishing load."""

from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ...fields import Scalar
from ...friction import FrictionLaw
from ...mechanism import Mechanism

_Forces = TypeVar("_Forces")
#: Load in place of 0, too small to change anything but ratios, and the load below which a load
#: counts as 0 because squares of forces and moments underflow; by the bits of a number [N].
_NO_LOAD = {64: 1e-30, 32: 1e-12}
_LEAST_LOAD = {64: 1e-100, 32: 1e-14}
#: Far above the forces [N], moments [N·m], powers [W] and efficiencies of the load in place of 0,
#: and far below those of drag.
_TRACE = {64: 1e-20, 32: 1e-9}


def _is_unloaded(load: Scalar) -> Bool[Array, ""]:
    return (load == 0) | (jnp.abs(load) < _LEAST_LOAD[jnp.finfo(load.dtype).bits])


def _sign(load: Scalar, stand_in: Scalar | float) -> Scalar:
    """Sign of a load; that of its stand-in where it is exactly 0."""
    return jnp.where(load == 0, stand_in, jnp.sign(load)).astype(load.dtype)


def some_load(load: Scalar, sign: Scalar | float = 1.0) -> Scalar:
    """The load, or in place of 0 a load that is too small to change anything but ratios [N].

    The load in place of 0 has a `sign`: with that of the motion it is the screw that drives.
    """
    stand_in = _NO_LOAD[jnp.finfo(load.dtype).bits] * _sign(load, sign)
    return load + jnp.where(_is_unloaded(load), stand_in, 0.0).astype(load.dtype)


def unit_load(load: Scalar, sign: Scalar | float) -> tuple[Scalar, Scalar]:
    """A load for forces that are proportional to it, and the factor on these forces.

    The load itself and 1; in place of 0, 1 N of a `sign` and what makes the load of it. The
    derivative of a ratio of two forces by the load is then exactly 0, also without a load: under
    `some_load` it is the rounding error of two equal terms over the load, about 1e14/N.
    """
    unloaded, sign = _is_unloaded(load), _sign(load, sign)
    # The product of sign and load would be −0 where the sign is −1.
    size = jnp.where(sign < 0, 0.0 - load, load)
    return jnp.where(unloaded, sign, load), jnp.where(unloaded, size, jnp.ones_like(load))


def without_traces(number: Array, load: Scalar) -> Array:
    """A number at a load, less what the load in place of 0 adds to it; its derivatives stay."""
    fixed = jax.lax.stop_gradient(number)
    trace = _is_unloaded(load) & (jnp.abs(fixed) < _TRACE[jnp.finfo(load.dtype).bits])
    return number - jnp.where(trace, fixed, 0.0)


def proportional_to_load(mechanism: Mechanism) -> bool:
    """Whether all forces of a steady state except inertia are proportional to the load."""
    for stage in mechanism.stages:
        friction = stage.friction
        if friction is None:
            continue
        if any(one is not None for one in (friction.spin, friction.rolling_hysteresis)):
            return False
        if friction.drag is not None:
            return False
        at_radius = (friction.spline, friction.thrust_bearing)
        laws = [friction.thread, *(None if one is None else one.law for one in at_radius)]
        if not all(law is None or is_proportional(law) for law in laws):
            return False
    return True


def is_proportional(law: FrictionLaw) -> bool:
    """Whether friction is proportional to the normal force."""
    return not (law.load_independent or law.asks or law.viscous_resistance is not None)


def scaled(forces: _Forces, factor: Scalar) -> _Forces:
    """Forces and moments times a factor."""
    return jax.tree.map(lambda one: factor * one, forces)
