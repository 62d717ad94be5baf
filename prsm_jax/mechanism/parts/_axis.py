"""The axis around a mechanism: motor, shaft of the screw, load.

The motor turns the screw, and the nut moves the load; in an inverted roller screw the motor turns
the nut, and the screw moves the load.
"""

from ...fields import (
    NOT_NEGATIVE,
    POSITIVE,
    Limited,
    Number,
    OptionalNumber,
    choice,
    number,
    optional_number,
    part,
)


class PositionController(Limited):
    """A position loop of the motor: torque −K_p φ − K_d φ̇ at small motion, φ measured at the motor.

    An integral part acts below the natural frequencies and is left out.
    """

    proportional_gain: Number = number(
        "N·m/rad", "torque per angle of the motor, K_p", limit=POSITIVE
    )
    derivative_gain: OptionalNumber = optional_number(
        "N·m·s/rad", "torque per speed of the motor, K_d", limit=NOT_NEGATIVE
    )


class Motor(Limited):
    """The motor: a rotor, its shaft and a coupling in series."""

    inertia: Number = number(
        "kg·m²", "moment of inertia of the rotor, with all that is fixed to it"
    )
    shaft_stiffness: OptionalNumber = optional_number(
        "N·m/rad", "torsional stiffness of the motor's shaft; rigid when absent", limit=POSITIVE
    )
    coupling_stiffness: OptionalNumber = optional_number(
        "N·m/rad", "torsional stiffness of the coupling; rigid when absent", limit=POSITIVE
    )
    controller: PositionController | None = part("the motor turns freely: no position loop")


class FarBearing(Limited):
    """A second thrust bearing of the screw, beyond the nut; not of an inverted roller screw."""

    distance: Number = number("m", "distance from the thrust bearing at the motor, on the screw")
    axial_stiffness: Number = number("N/m", "axial stiffness of this bearing", limit=POSITIVE)


class AxisShaft(Limited):
    """The screw as an elastic shaft between its thrust bearing and the nut.

    The thrust bearing at the motor has the `axial_stiffness` of the screw's support. The screw of
    an inverted roller screw has no thrust bearing; its end at the load takes the bearing's place.
    """

    nut_distance: Number = number(
        "m",
        "distance on the screw from the thrust bearing (inverted: from its end at the load) to the "
        "middle of the nut",
    )
    far_bearing: FarBearing | None = part("the screw is free along the axis at its far end")


class AxisLoad(Limited):
    """What the nut moves; in an inverted roller screw, what the screw moves."""

    mass: Number = number("kg", "mass that moves with the nut (inverted: with the screw)")
    tube_stiffness: OptionalNumber = optional_number(
        "N/m",
        "axial stiffness of the thrust tube between nut (inverted: screw) and load; rigid when "
        "absent",
        limit=POSITIVE,
    )


class Axis(Limited):
    """The axis around a mechanism of one stage, for its vibration in space.

    Its thrust bearing is the `axial_stiffness` of the support of the body that turns.
    """

    motor: Motor | None = part(
        "the body that turns does so freely, or on its own torsional support"
    )
    shaft: AxisShaft | None = part("the screw is rigid between its thrust bearing and the nut")
    load: AxisLoad | None = part("nothing moves along the axis but the mechanism's own parts")
    tilt: bool = choice(
        "whether screw, nut and rollers also tilt where bodies move in space; needs their lengths "
        "and the number of engaged threads",
        default=False,
    )


__all__ = ["Axis", "AxisLoad", "AxisShaft", "FarBearing", "Motor", "PositionController"]
