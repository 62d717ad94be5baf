"""The distinct natural frequencies of a stage, for sweeps over millions of designs."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar
from ..programs import physics
from ._grouped_modes import frequency
from .arrowhead import arrowhead_modes
from .model import VibrationSystem, roller_corner


class DistinctFrequencies(eqx.Module):
    """Every natural frequency of a symmetric stage, listed once [Hz].

    With n bodies on the axis there are n + 1 torsional and n + 1 transverse frequencies, ascending.
    """

    #: Of the carrier alone, multiplicity 1; `None` without a carrier [Hz].
    carrier: Scalar | None
    #: Multiplicity 1 each [Hz].
    torsional: Float[Array, " modes"]
    #: Multiplicity 2 each [Hz].
    transverse: Float[Array, " modes"]
    #: Multiplicity N − 3 [Hz]: it does not occur with three rollers.
    roller: Scalar


@physics("distinct_frequencies")
def distinct_frequencies(
    system: VibrationSystem, *, roller_count: Scalar | None = None
) -> DistinctFrequencies:
    """Distinct natural frequencies of a stage whose rollers are equal and evenly spaced.

    The same numbers as those of `symmetric_modes`, without shapes and energies, at a cost that
    does not depend on the number of rollers, which may be traced. Under `jax.vmap`, over a system
    whose numbers are arrays of designs, everything is one fused loop over designs; chunks of a few
    thousand designs stay in the cache (`prsm_jax.sweeps.map_in_chunks`). Derivatives of first and
    second order are closed forms, correct at repeated and at zero roots.

    **Arguments:**

    - `system`: masses and springs from `vibration_system`; rollers that only rotate.
    - `roller_count`: replaces the number of the system. The equivalent mass of the carrier
      contains the rollers: give a system with the same number.

    **Returns:** the frequencies; NaN where a negative stiffness, a mass that is not positive, or
    NaN enters them.

    **Raises:** `ValueError` for a system without this symmetry, or with rollers that move in
    translation.
    """
    if not system.symmetric or system.translation is not None:
        raise ValueError(
            "distinct_frequencies needs at least 3 equal rollers, evenly spaced, supports equal in "
            "x and y, and rollers that only rotate; use stage_modes for any other system"
        )
    bodies, roller = system.bodies, system.roller_equivalent_mass
    count = jnp.asarray(system.roller_count if roller_count is None else roller_count)
    count = count.astype(roller.dtype)
    mesh = tuple(body.mesh_stiffness for body in bodies)
    torsional = arrowhead_modes(
        tuple(body.torsional_support for body in bodies),
        mesh,
        (*(body.equivalent_mass for body in bodies), roller),
        jnp.sqrt(count),
    )
    transverse = arrowhead_modes(
        tuple(body.radial_support for body in bodies),
        mesh,
        (*(body.mass for body in bodies), roller),
        jnp.sqrt(count / 2),
    )
    carrier = system.carrier
    if carrier is not None:
        carrier = frequency(carrier.torsional_support / carrier.equivalent_mass)
    return DistinctFrequencies(
        carrier=carrier,
        torsional=frequency(jnp.stack(torsional.values)),
        transverse=frequency(jnp.stack(transverse.values)),
        roller=frequency(roller_corner(system) / roller),
    )
