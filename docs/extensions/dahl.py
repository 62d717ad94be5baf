"""A friction law with a state: Dahl's, a contact that acts as a spring until it slips."""

import jax.numpy as jnp

from prsm_jax import friction_law
from prsm_jax.fields import Scalar, number
from prsm_jax.friction import StatefulFrictionLaw


@friction_law("dahl")
class DahlFriction(StatefulFrictionLaw):
    """Force per normal force σ z, ż = v − σ |v| z/μ (Dahl 1968); Coulomb's law in steady slip."""

    coefficient: Scalar = number("1", "friction coefficient, μ")
    stiffness: Scalar = number("1/m", "stiffness per normal force, σ")

    def friction_coefficient(self, sliding):
        return self.coefficient

    @property
    def deflection_scale(self):
        return self.coefficient / self.stiffness

    def deflection_rate(self, contact):
        speed = jnp.sqrt(jnp.sum(contact.slip**2) + 1e-30)
        relative = self.stiffness / self.coefficient * contact.deflection
        if contact.friction_direction is None:
            return contact.slip - speed * relative
        # Spin reduces the friction along the slip, and the deflection settles faster.
        length = jnp.sqrt(jnp.sum(contact.friction_direction**2) + 1e-30)
        return speed / length * (contact.friction_direction - relative)

    def deflected_friction(self, contact):
        return self.stiffness * contact.deflection
