"""Load distribution and force–deflection curve of one stage, as reports show them."""

import jax.numpy as jnp

from ...fields import Scalar
from ...load_sharing import ForceDeflection, LoadDistribution, force_deflection, load_distribution
from ...mechanism import Mechanism
from ...programs import one_program_where_possible

#: Points of a force–deflection curve, and its largest load over the load of the distribution.
_POINTS, _BEYOND = 61, 1.5

_load_distribution = one_program_where_possible(load_distribution)
_force_deflection = one_program_where_possible(force_deflection)


def shared_loads(
    mechanism: Mechanism, load: Scalar, stage: int
) -> tuple[LoadDistribution, ForceDeflection]:
    """Load distribution under a load, and force–deflection curve up to 1.5 times that load.

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs `load_sharing`.
    - `load`: axial load [N].
    - `stage`: which stage, counted from 1.
    """
    sharing = mechanism.stages[stage - 1].load_sharing
    most = _BEYOND * jnp.abs(load)
    both = sharing is not None and sharing.has_reverse_flanks
    # Denser about zero load, where the stiffness of a contact grows from 0.
    place = jnp.linspace(-1.0 if both else 0.0, 1.0, _POINTS)
    loads = most * jnp.sign(place) * jnp.abs(place) ** 1.5
    curve = _force_deflection(mechanism, loads, stage=stage)
    return _load_distribution(mechanism, load, stage=stage), curve
