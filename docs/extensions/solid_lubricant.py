"""A friction law: a solid lubricant, whose shear strength does not grow with the pressure."""

from prsm_jax import FrictionLaw, friction_law
from prsm_jax.fields import NOT_NEGATIVE, Scalar, number


@friction_law("solid_lubricant")
class SolidLubricantFriction(FrictionLaw):
    """A film of constant shear strength (MoS₂): μ = τ₀/p̄ + α with the mean pressure p̄ = 2/3 p₀.

    Bowden and Tabor 1950. Higher pressure means less friction.
    """

    asks = ("pressure",)
    shear_strength: Scalar = number("Pa", "shear strength of the film, τ₀")
    coefficient: Scalar = number("1", "coefficient at high pressure, α", limit=NOT_NEGATIVE)

    def friction_coefficient(self, sliding):
        mean_pressure = 2 / 3 * sliding.pressure
        return self.shear_strength / mean_pressure + self.coefficient
