"""A friction law: a solid lubricant, whose shear strength does not grow with the pressure."""

import jax.numpy as jnp

from prsm_jax import FrictionLaw, friction_law
from prsm_jax.fields import NOT_NEGATIVE, Number, number


@friction_law("solid_lubricant")
class SolidLubricantFriction(FrictionLaw):
    """A film of constant shear strength (MoS₂): μ = τ₀/p̄ + α with the mean pressure p̄ = 2/3 p₀.

    Bowden and Tabor 1950. Higher pressure means less friction. At very small loads the film no
    longer covers the contact: a mean pressure below ten times its strength is raised to that.
    """

    asks = ("pressure",)
    shear_strength: Number = number("Pa", "shear strength of the film, τ₀")
    coefficient: Number = number("1", "coefficient at high pressure, α", limit=NOT_NEGATIVE)

    def friction_coefficient(self, sliding):
        mean_pressure = jnp.maximum(2 / 3 * sliding.pressure, 10 * self.shear_strength)
        return self.shear_strength / mean_pressure + self.coefficient
