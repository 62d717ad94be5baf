"""Friction that falls with the slip speed."""

from ..fields import (
    NOT_NEGATIVE,
    Scalar,
    number,
    optional_number,
)
from ._law import FrictionLaw, Sliding, falling_coefficient
from ._register import friction_law


@friction_law("stribeck")
class StribeckFriction(FrictionLaw):
    """Friction that falls from a static to a sliding coefficient as a film of lubricant builds up.

    Force `(μ + (μ_s − μ) e^{−(v/v_S)²}) F + c v` against the slip.
    """

    static_coefficient: Scalar = number(
        "1", "friction coefficient at the onset of slip, μ_s", limit=NOT_NEGATIVE
    )
    coefficient: Scalar = number("1", "friction coefficient of fast slip, μ", limit=NOT_NEGATIVE)
    stribeck_speed: Scalar = number("m/s", "slip speed of the transition, v_S")
    viscous_coefficient: Scalar | None = optional_number(
        "N·s/m",
        "viscous friction coefficient, c; in a thread that of one roller",
        limit=NOT_NEGATIVE,
    )

    def friction_coefficient(self, sliding: Sliding) -> Scalar:
        """μ + (μ_s − μ) e^{−(v/v_S)²}."""
        return falling_coefficient(
            self.static_coefficient, self.coefficient, self.stribeck_speed, sliding.speed
        )

    @property
    def viscous_resistance(self) -> Scalar | None:
        """c [N·s/m]."""
        return self.viscous_coefficient
