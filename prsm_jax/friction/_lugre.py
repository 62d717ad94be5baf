"""Bristles between the threads: the LuGre law.

Canudas de Wit, Olsson, Åström, Lischinsky, A new model for control of systems with friction, IEEE
Transactions on Automatic Control 40 (1995) 419–425, here per unit of normal force and for a vector
of slip. The deflection z lies in the tangent plane of the contact, like the slip.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import NOT_NEGATIVE, POSITIVE, Number, OptionalNumber, Scalar, number, optional_number
from ..numerics import dot_few, length_few, sum_few
from ._law import Deflected, Sliding, StatefulFrictionLaw
from ._register import friction_law
from ._stribeck import StribeckCurve


@friction_law("lugre")
class LuGreFriction(StribeckCurve, StatefulFrictionLaw):
    """Bristles between the threads that bend before they slip (Canudas de Wit et al. 1995).

    Deflection z and force of one roller, both vectors in the tangent plane of the contact:
    `ż = v − σ₀ |v| z / g(v)` with `g = μ + (μ_s − μ) e^{−(v/v_S)²}`, and `F (σ₀ z + σ₁ ż) + σ₂ v`.
    In steady slip this is Stribeck's law; at rest the contact is a spring of stiffness F σ₀. It
    passes smoothly through standstill and reversal and holds the load.

    Stiffness and damping are per unit of normal force. `σ₁ = 2 √(σ₀ m / F)` is critical damping for
    a mass m held by a force F. Constant damping gives a large force when slip begins suddenly, and
    the contact may then supply energy unless σ₂ ≥ σ₁ F (μ_s − μ)/μ (Barabanov and Ortega 2000);
    with a damping speed v_d the damping decreases with slip, `σ₁ e^{−(v/v_d)²}`.
    """

    static_coefficient: Number = number(
        "1", "friction coefficient at the onset of slip, μ_s", limit=NOT_NEGATIVE
    )
    coefficient: Number = number("1", "friction coefficient of fast slip, μ", limit=NOT_NEGATIVE)
    stribeck_speed: Number = number("m/s", "slip speed of the transition, v_S")
    bristle_stiffness: Number = number(
        "1/m", "stiffness of the bristles per normal force, σ₀", limit=POSITIVE
    )
    bristle_damping: Number = number(
        "s/m", "damping of the bristles per normal force, σ₁", limit=NOT_NEGATIVE
    )
    damping_speed: OptionalNumber = optional_number(
        "m/s", "slip speed over which bristle damping decreases, v_d; constant damping if not given"
    )
    viscous_coefficient: OptionalNumber = optional_number(
        "N·s/m",
        "viscous friction coefficient of one roller, σ₂",
        limit=NOT_NEGATIVE,
    )

    @property
    def deflection_scale(self) -> Scalar:
        """Deflection at the largest force of the bristles, μ_s/σ₀ [m]."""
        return self.static_coefficient / self.bristle_stiffness

    def deflection_rate(self, contact: Deflected) -> Float[Array, "3"]:
        """Rate of deflection of the bristles, `ż = v − σ₀ |v| z / g(v)` [m/s].

        With spin, the bristles approach the force of combined slip and spin, `g(Φ) T` with
        `T = ∂Φ/∂v`, and the faster the larger the share of spin: `ż = |v|/|T| (T − σ₀ z/g(Φ))`.
        """
        slip, deflection, gradient, mean_speed = contact
        speed, stiffness = length_few(slip), self.bristle_stiffness
        if gradient is None or mean_speed is None:
            steady_coefficient = self.friction_coefficient(Sliding(speed))
            return slip - stiffness * speed / steady_coefficient * deflection
        length = length_few(gradient)
        rate = speed / jnp.where(length > 0, length, 1.0)
        steady_coefficient = self.friction_coefficient(Sliding(mean_speed))
        return rate * (gradient - stiffness / steady_coefficient * deflection)

    def deflected_friction(self, contact: Deflected) -> Float[Array, "3"]:
        """Friction per normal force, σ₀ z + σ₁ ż."""
        damping = self.bristle_damping
        if self.damping_speed is not None:
            damping = damping * jnp.exp(-sum_few(contact.slip**2) / self.damping_speed**2)
        return self.bristle_stiffness * contact.deflection + damping * self.deflection_rate(contact)

    def stored_power(self, contact: Deflected) -> Scalar:
        """Rate at which the bristles store energy per normal force, σ₀ z·ż [m/s]."""
        bending = dot_few(contact.deflection, self.deflection_rate(contact))
        return self.bristle_stiffness * bending
