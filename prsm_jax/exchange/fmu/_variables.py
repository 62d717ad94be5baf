"""Variables of the unit: names, units and descriptions."""

from typing import NamedTuple

from ...mechanism import Mechanism


def described(words: str, mechanism: Mechanism) -> str:
    """The description of a variable: its words, in which {…} stand for bodies of the mechanism.

    Names of variables are those of a standard roller screw for all types: of an inverted one,
    `screw_speed` is the speed of the nut.

    **Arguments:**

    - `words`: with `{driven}` for the body at the motor, `{moved}` for that at the load, and
      `{turning}` for the body of each stage that turns.
    - `mechanism`: the mechanism.
    """
    # All stages of a series are of one type.
    family = mechanism.stages[0].thread.family
    first, last = ("first ", "last ") if len(mechanism.stages) > 1 else ("", "")
    return words.format(
        driven=first + family.turning, moved=last + family.held, turning=family.turning
    )


class Output(NamedTuple):
    """An output of the unit: one number, or one of each stage; `described` takes its words."""

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
    Output("screw_angle", "rad", "angle of the {driven} since the start"),
    Output("screw_speed", "rad/s", "speed of the {driven}"),
    Output("screw_acceleration", "rad/s2", "acceleration of the {driven}"),
    Output("nut_position", "m", "position of the {moved}"),
    Output("nut_speed", "m/s", "speed of the {moved}"),
    Output("carrier_speed", "rad/s", "speed of the carrier of a stage", per_stage=True),
    Output("roller_speed", "rad/s", "speed of the rollers about their own axes", per_stage=True),
    Output("contact_force", "N", "normal force of the {turning} on one roller", per_stage=True),
    Output("friction_torque", "N.m", "torque that friction takes from the {driven}"),
    Output("loss_power", "W", "power of all losses"),
)
#: The only output that is a truth.
STICKING = "sticking"
