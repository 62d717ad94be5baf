"""Interface of friction laws: one class with one method, of this package or of a user's own file.

A law is a frozen pytree of its numbers. It gives the friction coefficient of a sliding contact; the
direction of the force, its balance with the load and everything that follows are the same for all
laws. A law lists in `asks` the quantities that it needs besides the slip speed; no others are
computed.
"""

import abc
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from ..fields import Limited, Scalar, old_name, renamed_arguments
from ..numerics import dot_few

#: Quantities that a law may request, with unit and meaning.
LAW_INPUTS = {
    "normal_force": "N: normal force of one roller, summed over its threads",
    "pressure": "Pa: largest Hertz pressure of the screw side, with equally loaded threads",
    "rolling_speed": "m/s: mean speed of both surfaces through the contact (entrainment)",
}


@renamed_arguments(asked="law_inputs")
class Sliding(eqx.Module):
    """State of a sliding contact, the input of a friction law.

    **Arguments:**

    - `speed`: slip speed, 0 or more; with spin, the mean of the local slip speeds [m/s].
    - `law_inputs`: the quantities requested by the law (`FrictionLaw.asks`), by name.
    - `squared_speed`: square of the speed, if known independently: unlike the speed it is smooth at
      standstill [m²/s²].
    """

    speed: Scalar
    law_inputs: dict[str, Scalar] = eqx.field(default_factory=dict)
    squared_speed: Scalar | None = None

    @property
    def asked(self) -> dict[str, Scalar]:
        """Old name of `law_inputs`."""
        return old_name(self, "asked", "law_inputs")

    @property
    def square(self) -> Scalar:
        """Square of the slip speed [m²/s²]."""
        return self.speed**2 if self.squared_speed is None else self.squared_speed

    def _of(self, name: str) -> Scalar:
        if name not in self.law_inputs:
            raise ValueError(
                f"a friction law uses {name}, which it does not request; add it to the law's "
                f'asks = ("{name}",)'
            )
        return self.law_inputs[name]

    @property
    def normal_force(self) -> Scalar:
        """Normal force of one roller, summed over its threads [N]."""
        return self._of("normal_force")

    @property
    def pressure(self) -> Scalar:
        """Largest Hertz pressure of the screw side [Pa]."""
        return self._of("pressure")

    @property
    def rolling_speed(self) -> Scalar:
        """Mean speed of both surfaces through the contact [m/s]."""
        return self._of("rolling_speed")


class FrictionLaw(Limited):
    """Base of all friction laws: force `μ F` against the slip, plus `c v`.

    A law is a class with its numbers as fields (`prsm_jax.fields.number`) and
    `friction_coefficient`. The decorator `prsm_jax.friction_law` gives it the name that files use.
    Class attributes declare its kind:

    - `smooth_at_standstill`: friction passes through 0 smoothly when the slip changes its sign (it
      is proportional to slow slip). The friction of other laws jumps there, and can hold a load at
      rest.
    - `load_independent`: no part is proportional to the normal force.
    - `constant`: the coefficient is constant; settling then has a closed form.
    - `asks`: what it needs besides the slip speed: any of `normal_force`, `pressure`,
      `rolling_speed`.
    """

    law: ClassVar[str] = ""
    smooth_at_standstill: ClassVar[bool] = False
    load_independent: ClassVar[bool] = False
    constant: ClassVar[bool] = False
    has_state: ClassVar[bool] = False
    asks: ClassVar[tuple[str, ...]] = ()

    @abc.abstractmethod
    def friction_coefficient(self, sliding: Sliding) -> Scalar:
        """Friction force over normal force, μ [1].

        **Arguments:**

        - `sliding`: slip speed, and the quantities in `asks`.
        """

    def coefficient_per_speed(self, sliding: Sliding) -> Scalar:
        """μ/v of a law that is smooth at standstill [s/m]; v is never 0 here.

        The first derivative at standstill is always correct. If a law gives the quotient in closed
        form, from `sliding.square`, higher derivatives there are correct, too.
        """
        return self.friction_coefficient(sliding) / sliding.speed

    @property
    def viscous_resistance(self) -> Scalar | None:
        """Friction force per slip speed, independent of the load [N·s/m]; `None` if none."""
        return None


class Deflected(NamedTuple):
    """Slip of the screw relative to one roller, and deflection of the layer between them."""

    #: [m/s].
    slip: Float[Array, "3"]
    #: In the tangent plane of the contact [m].
    deflection: Float[Array, "3"]
    #: Friction of combined slip and spin per unit of μ F, a vector of magnitude below 1, and the
    #: mean local slip speed [m/s]; `None` if spin is not modelled.
    friction_direction: Float[Array, "3"] | None = None
    mean_speed: Scalar | None = None

    @property
    def held(self) -> Float[Array, "3"] | None:
        """Old name of `friction_direction`."""
        return old_name(self, "held", "friction_direction")


class StatefulFrictionLaw(FrictionLaw):
    """A law with a state: a deflection z in the tangent plane of each contact [m].

    Its friction in steady slip is `friction_coefficient`. The state carries it through standstill.

    **Raises:** `ValueError` if it requests more than slip and deflection.
    """

    smooth_at_standstill: ClassVar[bool] = True
    has_state: ClassVar[bool] = True

    def __check_init__(self) -> None:
        if self.asks:
            raise ValueError(
                f"{type(self).__name__}: asks for {', '.join(self.asks)}; a law with a state "
                "receives only slip and deflection, so leave asks empty"
            )

    @property
    @abc.abstractmethod
    def deflection_scale(self) -> Scalar:
        """Typical magnitude of the deflection [m]."""

    @abc.abstractmethod
    def deflection_rate(self, contact: Deflected) -> Float[Array, "3"]:
        """Rate of change of the state, ż [m/s]."""

    @abc.abstractmethod
    def deflected_friction(self, contact: Deflected) -> Float[Array, "3"]:
        """Friction per normal force before steady slip is reached [1]."""

    def stored_power(self, contact: Deflected) -> Scalar:
        """Rate at which the state stores energy, per normal force [m/s]; 0 if it stores none."""
        return 0.0 * dot_few(contact.slip, contact.deflection)


def check_law_inputs(cls: type, names: Sequence[str]) -> None:
    """**Raises:** `ValueError` if a law requests an unknown quantity."""
    for name in names:
        if name not in LAW_INPUTS:
            choices = ", ".join(LAW_INPUTS)
            raise ValueError(
                f"friction law {cls.__name__}: asks for {name!r}; choose from {choices}"
            )
