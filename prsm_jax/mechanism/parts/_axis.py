"""The axis around a mechanism: motor, shaft of the screw, load."""

from ...fields import (
    NOT_NEGATIVE,
    POSITIVE,
    Limited,
    Number,
    OptionalNumber,
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
    """The motor that turns the screw: a rotor, its shaft and a coupling in series."""

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
    """A second thrust bearing of the screw, beyond the nut."""

    distance: Number = number("m", "distance from the thrust bearing at the motor, on the screw")
    axial_stiffness: Number = number("N/m", "axial stiffness of this bearing", limit=POSITIVE)


class AxisShaft(Limited):
    """The screw as an elastic shaft between its thrust bearing and the nut.

    The thrust bearing at the motor has the `axial_stiffness` of the screw's support.
    """

    nut_distance: Number = number(
        "m", "distance on the screw from the thrust bearing to the middle of the nut"
    )
    far_bearing: FarBearing | None = part("the screw is free along the axis at its far end")


class AxisLoad(Limited):
    """What the nut moves."""

    mass: Number = number("kg", "mass that moves with the nut")
    tube_stiffness: OptionalNumber = optional_number(
        "N/m",
        "axial stiffness of the thrust tube between nut and load; rigid when absent",
        limit=POSITIVE,
    )


class Axis(Limited):
    """The axis around a mechanism of one stage, for its vibration in space.

    Its thrust bearing is the `axial_stiffness` of the screw's support.
    """

    motor: Motor | None = part("the screw turns freely, or on its own torsional support")
    shaft: AxisShaft | None = part("the screw is rigid between its thrust bearing and the nut")
    load: AxisLoad | None = part("nothing moves with the nut but its own parts")


__all__ = ["Axis", "AxisLoad", "AxisShaft", "FarBearing", "Motor", "PositionController"]
