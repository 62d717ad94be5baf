"""Friction that falls with the slip speed."""

import equinox as eqx
import jax.numpy as jnp

from ..fields import NOT_NEGATIVE, Number, OptionalNumber, Scalar, number, optional_number
from ._law import FrictionLaw, Sliding
from ._register import friction_law


class StribeckCurve(FrictionLaw):
    """Steady slip of laws whose coefficient falls from a static to a sliding one."""

    static_coefficient: eqx.AbstractVar[Number]
    coefficient: eqx.AbstractVar[Number]
    stribeck_speed: eqx.AbstractVar[Number]
    viscous_coefficient: eqx.AbstractVar[OptionalNumber]

    def friction_coefficient(self, sliding: Sliding) -> Scalar:
        """μ + (μ_s − μ) e^{−(v/v_S)²}."""
        share = jnp.exp(-((sliding.speed / self.stribeck_speed) ** 2))
        return self.coefficient + (self.static_coefficient - self.coefficient) * share

    @property
    def viscous_resistance(self) -> Scalar | None:
        """c [N·s/m]."""
        return self.viscous_coefficient


@friction_law("stribeck")
class StribeckFriction(StribeckCurve):
    """Friction that falls from a static to a sliding coefficient as a film of lubricant builds up.

    Force `(μ + (μ_s − μ) e^{−(v/v_S)²}) F + c v` against the slip.
    """

    static_coefficient: Number = number(
        "1", "friction coefficient at the onset of slip, μ_s", limit=NOT_NEGATIVE
    )
    coefficient: Number = number("1", "friction coefficient of fast slip, μ", limit=NOT_NEGATIVE)
    stribeck_speed: Number = number("m/s", "slip speed of the transition, v_S")
    viscous_coefficient: OptionalNumber = optional_number(
        "N·s/m",
        "viscous friction coefficient, c; in a thread: per roller",
        limit=NOT_NEGATIVE,
    )
