"""Static compliance of a network that may have rigid motions."""

import jax
import jax.numpy as jnp

from ...fields import Scalar
from ...numerics import above_or_nan
from .._spring_modes import RIGID_SHARE, SpringModes, spring_modes
from ..model import Coordinate, SpringNetwork

#: A rigid motion with less than this share of its kinetic energy at a coordinate does not move it;
#: rounding leaves about 1e-32.
_STILL = 1e-20


def static_compliance(
    network: SpringNetwork, coordinate: Coordinate, modes: SpringModes | None = None
) -> Scalar:
    """Displacement of a coordinate per static force at it, `Σ φ²/ω²` over all elastic modes [m/N].

    All terms are positive, so that nothing cancels, and rigid motions that do not move the
    coordinate (rollers that roll freely) need no support. Infinite where one moves it.

    **Arguments:**

    - `network`: the springs and masses.
    - `coordinate`: one of its degrees of freedom.
    - `modes`: those of the network, if already known.
    """
    modes = spring_modes(network) if modes is None else modes
    place = network.coordinates.index(coordinate)
    participation = jnp.abs(modes.shapes[place]) ** 2
    omega = modes.angular_frequencies
    elastic = above_or_nan(omega, RIGID_SHARE * jnp.max(omega))
    terms = participation / jnp.where(elastic, modes.eigenvalues, 1.0)
    moving = jax.lax.stop_gradient(participation * network.mass[place]) > _STILL
    compliance = jnp.sum(jnp.where(elastic, terms, 0.0))
    return jnp.where(jnp.any(~elastic & moving), jnp.inf, compliance)
