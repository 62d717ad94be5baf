"""Variables of the unit: names, units and descriptions."""

from typing import NamedTuple


class Output(NamedTuple):
    """An output of the unit: one number, or one of each stage."""

    name: str
    unit: str
    description: str
    per_stage: bool = False

    def names(self, stages: int) -> list[str]:
        """Names of its variables, as FMI writes elements of arrays: `carrier_speed[2]`."""
        if not self.per_stage:
            return [self.name]
        return [f"{self.name}[{number}]" for number in range(1, stages + 1)]


#: Exponents of the SI base units (and rad) of each unit, as FMI defines units.
UNITS: dict[str, dict[str, int]] = {
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
}
OUTPUTS = (
    Output("screw_angle", "rad", "angle of the first screw since the start"),
    Output("screw_speed", "rad/s", "speed of the first screw"),
    Output("screw_acceleration", "rad/s2", "acceleration of the first screw"),
    Output("nut_position", "m", "position of the last nut"),
    Output("nut_speed", "m/s", "speed of the last nut"),
    Output("carrier_speed", "rad/s", "speed of the carrier of a stage", per_stage=True),
    Output("roller_speed", "rad/s", "speed of the rollers about their own axes", per_stage=True),
    Output("contact_force", "N", "normal force of the screw on one roller", per_stage=True),
    Output("friction_torque", "N.m", "torque that friction takes from the first screw"),
    Output("loss_power", "W", "power of all losses"),
)
#: The only output that is a truth.
STICKING = "sticking"
