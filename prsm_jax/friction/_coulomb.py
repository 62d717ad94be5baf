"""Coulomb friction, and Coulomb friction smoothed at standstill."""

from typing import ClassVar

import jax.numpy as jnp

from ..fields import NOT_NEGATIVE, POSITIVE, Number, Scalar, number
from ._law import FrictionLaw, Sliding
from ._register import friction_law


@friction_law("coulomb")
class CoulombFriction(FrictionLaw):
    """Coulomb friction: force μ F against the slip."""

    constant: ClassVar[bool] = True
    coefficient: Number = number("1", "friction coefficient, μ", limit=NOT_NEGATIVE)

    def friction_coefficient(self, sliding: Sliding) -> Scalar:
        """μ."""
        return self.coefficient


@friction_law("regularised_coulomb")
class RegularisedCoulombFriction(FrictionLaw):
    """Coulomb friction smoothed over a small slip: force μ F v / √(v² + ε²).

    Differentiable through standstill and reversal. A loaded contact creeps where Coulomb friction
    would hold it; meanwhile the error of the power is about μ F ε.
    """

    smooth_at_standstill: ClassVar[bool] = True
    coefficient: Number = number("1", "friction coefficient, μ", limit=NOT_NEGATIVE)
    width: Number = number(
        "m/s", "slip speed over which the force changes its sign, ε", limit=POSITIVE
    )

    def friction_coefficient(self, sliding: Sliding) -> Scalar:
        """μ v / √(v² + ε²)."""
        return self.coefficient * sliding.speed / jnp.sqrt(sliding.speed**2 + self.width**2)

    def coefficient_per_speed(self, sliding: Sliding) -> Scalar:
        """μ / √(v² + ε²)."""
        return self.coefficient / jnp.sqrt(sliding.square + self.width**2)
