"""Friction outside the threads: any law at the radius of a spline or a thrust bearing; drag."""

from typing import Any, TypeAlias

import equinox as eqx
from jaxtyping import ArrayLike

from ..fields import (
    NOT_NEGATIVE,
    POSITIVE,
    Converted,
    Limited,
    Number,
    OptionalNumber,
    Scalar,
    number,
    optional_number,
)
from ._coulomb import CoulombFriction
from ._law import FrictionLaw

#: Field with a law: a number stands for Coulomb friction with this coefficient.
Law: TypeAlias = Converted[FrictionLaw, FrictionLaw | ArrayLike]


def _law(value: FrictionLaw | ArrayLike) -> FrictionLaw:
    return value if isinstance(value, FrictionLaw) else CoulombFriction(value)


def _law_field(**units: str) -> Any:
    """The law of a spline or bearing, whose numbers stand in the same table of a file.

    `units` maps a number's unit in a thread to its unit here.
    """
    metadata = {"same_table": True, "usual_law": "coulomb", "units": units}
    return eqx.field(converter=_law, metadata=metadata)


def _radius(description: str) -> Any:
    """The radius, required unless the law is independent of the load."""
    return optional_number("m", description, law_decides=True)


class FrictionAtRadius(Limited):
    """A friction law, and the radius at which it acts. The law's numbers are attributes, too.

    **Raises:** `ValueError` without a radius if the law needs one, or with a law that has a state
    or requests more than the slip speed.
    """

    law: eqx.AbstractVar[Law]
    radius: eqx.AbstractVar[OptionalNumber]

    def __check_init__(self) -> None:
        law, owner = self.law, type(self).__name__
        if law.has_state or law.asks:
            reason = "has a state" if law.has_state else f"asks for {', '.join(law.asks)}"
            raise ValueError(
                f"{owner}: the law {type(law).__name__} {reason}, which only threads give; choose "
                "another law"
            )
        if self.radius is None and not law.load_independent:
            raise ValueError(f"{owner}: radius is missing; the law {type(law).__name__} needs it")

    @property
    def arm(self) -> Scalar:
        """The radius of a law that needs one [m]."""
        assert self.radius is not None
        return self.radius

    def __getattr__(self, name: str) -> Any:
        if name in ("law", "radius") or name.startswith("_"):
            raise AttributeError(name)
        return getattr(self.law, name)


class SplineFriction(FrictionAtRadius):
    """Friction in the spline that turns an axially moving screw (not the first one)."""

    law: Law = _law_field()
    radius: OptionalNumber = _radius("effective radius of the spline, r_SS")


class ThrustBearingFriction(FrictionAtRadius):
    """Friction of the thrust bearing of the screw, in the previous nut or the housing.

    Its slip speed is the speed of the screw at the radius. The viscous part is a torque c Ω, c in
    N·m·s.
    """

    law: Law = _law_field(**{"N·s/m": "N·m·s"})
    radius: OptionalNumber = _radius("effective radius of the bearing, r_NS")


class Drag(Limited):
    """Drag torque on the screw, independent of the load (seals, lubricant): constant, and c Ω."""

    torque: Number = number("N·m", "constant drag torque", limit=NOT_NEGATIVE)
    viscous_coefficient: OptionalNumber = optional_number(
        "N·m·s", "viscous drag coefficient, c", limit=NOT_NEGATIVE
    )
    width: OptionalNumber = optional_number(
        "rad/s",
        "speed over which the constant torque changes its sign; step change if not given",
        limit=POSITIVE,
    )
