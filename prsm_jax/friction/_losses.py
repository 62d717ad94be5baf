"""Friction of one stage: each loss is modelled only if the input defines it."""

from ..fields import NOT_NEGATIVE, SHARE, Limited, Scalar, number, part
from ._law import FrictionLaw
from ._screw_friction import Drag, SplineFriction, ThrustBearingFriction


class SpinFriction(Limited):
    """Spin of the contact ellipses about the common normal (screw and nut side).

    The coefficient applies to the nut side, which spins without sliding. The screw side slides and
    spins simultaneously: there the friction law of the threads applies.
    """

    coefficient: Scalar = number(
        "1", "friction coefficient in the spinning contact, μ", limit=NOT_NEGATIVE
    )


class RollingHysteresis(Limited):
    """Rolling resistance by elastic hysteresis in the contact ellipses (screw and nut side)."""

    loss_factor: Scalar = number(
        "1", "share of the elastic energy lost per cycle, α_h", limit=SHARE
    )


class Friction(Limited):
    """All losses of one stage; a loss that is `None` is not modelled and not traced."""

    thread: FrictionLaw | None = part(
        "no sliding loss in the threads, and no force that drives the carriers against losses"
    )
    spin: SpinFriction | None = part("no loss by spin of the contact ellipses about their normal")
    rolling_hysteresis: RollingHysteresis | None = part(
        "no rolling loss, so that carriers settle at the speed given by geometry"
    )
    spline: SplineFriction | None = part(
        "no axial force and no loss in the spline of a screw that moves axially"
    )
    thrust_bearing: ThrustBearingFriction | None = part(
        "no friction torque of the thrust bearing of the screw"
    )
    drag: Drag | None = part("no torque of seals and lubricant that does not depend on the load")
