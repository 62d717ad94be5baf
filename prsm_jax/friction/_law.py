"""What a friction law is: one class with one method, in this package or in a user's own file.

A law is a frozen pytree of its numbers. It says what friction coefficient a sliding contact has;
the direction of the force, its balance with the load and everything that follows are the same for
all laws. A law lists in `asks` what it needs beyond the slip speed; nothing else is computed.
"""

import abc
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from ..fields import (
    Limited,
    Scalar,
)
from ..numerics import dot_few

#: What a law may ask for, with unit and meaning.
ASKED = {
    "normal_force": "N: normal force of one roller, all its threads together",
    "pressure": "Pa: largest Hertz pressure of the screw side, the threads loaded equally",
    "rolling_speed": "m/s: mean speed of both surfaces through the contact (entrainment)",
}


class Sliding(eqx.Module):
    """A sliding contact as a friction law sees it.

    **Arguments:**

    - `speed`: slip speed, 0 or more; where the ellipse spins too, the mean of the local ones [m/s].
    - `asked`: what the law asks for (`FrictionLaw.asks`), by name.
    - `squared_speed`: its square, where that is known by itself: unlike the speed it is smooth at
      standstill [m²/s²].
    """

    speed: Scalar
    asked: dict[str, Scalar] = eqx.field(default_factory=dict)
    squared_speed: Scalar | None = None

    @property
    def square(self) -> Scalar:
        """Square of the slip speed [m²/s²]."""
        return self.speed**2 if self.squared_speed is None else self.squared_speed

    def _of(self, name: str) -> Scalar:
        if name not in self.asked:
            raise ValueError(
                f"a friction law uses {name}, which it does not ask for; add it to the law's "
                f'asks = ("{name}",)'
            )
        return self.asked[name]

    @property
    def normal_force(self) -> Scalar:
        """Normal force of one roller, all its threads together [N]."""
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
    """Base of all friction laws: force `μ F` against the slip, and `c v` beside it.

    A law is a class with its numbers as fields (`prsm_jax.number`) and `friction_coefficient`. The
    decorator `prsm_jax.friction_law` gives it the name by which files know it. Class attributes
    declare its kind:

    - `smooth_at_standstill`: friction passes through 0 smoothly as the slip changes its sign (it
      is proportional to slow slip). Other friction jumps there, and can hold a load at rest.
    - `load_independent`: there is no part in proportion to the normal force.
    - `constant`: the coefficient never changes; settling then has a closed form.
    - `asks`: what it needs beside the slip speed, of `normal_force`, `pressure`, `rolling_speed`.
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

        - `sliding`: slip speed, and what the law asks for.
        """

    def coefficient_per_speed(self, sliding: Sliding) -> Scalar:
        """μ/v of a law that is smooth at standstill [s/m]; v is never 0 here.

        Its first derivative at standstill is right in any case. A law that gives the quotient in
        closed form, by `sliding.square`, has higher derivatives there, too.
        """
        return self.friction_coefficient(sliding) / sliding.speed

    @property
    def viscous_resistance(self) -> Scalar | None:
        """Friction force per slip speed that needs no normal force [N·s/m]; `None` if none."""
        return None


class Deflected(NamedTuple):
    """Slip of the screw over one roller, and how far what lies between them is deflected."""

    #: [m/s].
    slip: Float[Array, "3"]
    #: In the tangent plane of the contact [m].
    deflection: Float[Array, "3"]
    #: Friction of slip and spin together per unit of μ F, a vector shorter than 1, and the mean
    #: local slip speed [m/s]; `None` where no spin is modelled.
    held: Float[Array, "3"] | None = None
    mean_speed: Scalar | None = None


class StatefulFrictionLaw(FrictionLaw):
    """A law with a state: a deflection z in the tangent plane of each contact [m].

    In steady slip it is `friction_coefficient`. It passes through standstill by its state.

    **Raises:** `ValueError` if it asks for more than slip and deflection.
    """

    smooth_at_standstill: ClassVar[bool] = True
    has_state: ClassVar[bool] = True

    def __check_init__(self):
        if self.asks:
            raise ValueError(
                f"{type(self).__name__}: asks for {', '.join(self.asks)}; a law with a state knows "
                "slip and deflection only, so leave asks empty"
            )

    @property
    @abc.abstractmethod
    def deflection_scale(self) -> Scalar:
        """Deflection of the size that the state reaches [m]."""

    @abc.abstractmethod
    def deflection_rate(self, contact: Deflected) -> Float[Array, "3"]:
        """How fast the state changes, ż [m/s]."""

    @abc.abstractmethod
    def deflected_friction(self, contact: Deflected) -> Float[Array, "3"]:
        """Friction per normal force on the way to steady slip [1]."""

    def stored_power(self, contact: Deflected) -> Scalar:
        """Rate at which the state stores energy, per normal force [m/s]; 0 if it stores none."""
        return 0.0 * dot_few(contact.slip, contact.deflection)


def check_asked(cls: type, names: Sequence[str]) -> None:
    """**Raises:** `ValueError` if a law asks for what nothing can tell."""
    for name in names:
        if name not in ASKED:
            raise ValueError(
                f"friction law {cls.__name__}: asks for {name!r}; choose of {', '.join(ASKED)}"
            )
