"""Viscous friction."""

from typing import ClassVar

import jax.numpy as jnp

from ..fields import NOT_NEGATIVE, Number, Scalar, number
from ._law import FrictionLaw, Sliding
from ._register import friction_law


@friction_law("viscous")
class ViscousFriction(FrictionLaw):
    """Viscous friction: force c v against the slip, independent of the normal force."""

    smooth_at_standstill: ClassVar[bool] = True
    load_independent: ClassVar[bool] = True
    coefficient: Number = number(
        "N·s/m",
        "viscous friction coefficient, c; in a thread: per roller",
        limit=NOT_NEGATIVE,
    )

    def friction_coefficient(self, sliding: Sliding) -> Scalar:
        """0."""
        return jnp.zeros_like(sliding.speed)

    @property
    def viscous_resistance(self) -> Scalar:
        """c [N·s/m]."""
        return self.coefficient
