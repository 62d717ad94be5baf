"""How one stage shares its load, and its force–deflection curve, as reports show them."""

import equinox as eqx
import jax.numpy as jnp

from ...load_sharing import ForceDeflection, LoadDistribution, force_deflection, load_distribution
from ...mechanism import Mechanism, Scalar

#: Points of a force–deflection curve, and how far it goes over the load.
_POINTS, _BEYOND = 61, 1.5

_load_distribution = eqx.filter_jit(load_distribution)
_force_deflection = eqx.filter_jit(force_deflection)


def shared_loads(
    mechanism: Mechanism, load: Scalar, stage: int
) -> tuple[LoadDistribution, ForceDeflection]:
    """The distribution under a load, and the curve up to half as much again on either side.

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs `load_sharing`.
    - `load`: axial load [N].
    - `stage`: which stage, counted from 1.
    """
    sharing = mechanism.stages[stage - 1].load_sharing
    most = _BEYOND * jnp.abs(load)
    both = sharing is not None and sharing.has_reverse_flanks
    # Closer together about no load, where the stiffness of a contact grows from 0.
    place = jnp.linspace(-1.0 if both else 0.0, 1.0, _POINTS)
    loads = most * jnp.sign(place) * jnp.abs(place) ** 1.5
    curve = _force_deflection(mechanism, loads, stage=stage)
    return _load_distribution(mechanism, load, stage=stage), curve
