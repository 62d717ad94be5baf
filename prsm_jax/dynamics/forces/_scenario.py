"""The default scenario of a mechanism, and the drive and load of a scenario at one time."""

from typing import NamedTuple

from ..._errors import MissingDataError
from ...fields import Scalar
from ...mechanism import Mechanism
from ...numerics import apart
from ...scenario import Scenario, TorqueScenario


class Drive(NamedTuple):
    """How a scene drives and loads a mechanism at one time."""

    #: Screw speed [rad/s].
    speed: Scalar
    #: Its derivative [rad/s²], unless the speed is constant.
    acceleration: Scalar | None
    #: Load on the last nut [N].
    load: Scalar


def drive_at(scenario: Scenario, time: Scalar) -> Drive:
    """Speed, acceleration and load of a scene at a time [s]."""
    return Drive(*scenario.motion_at(time), scenario.load_at(time))


def drive_once(scenario: Scenario, time: Scalar) -> Drive:
    """As `drive_at`, computed once for everything that uses it.

    XLA would otherwise fuse it with every use: a step with a sinusoidal screw speed had 141 sines
    and cosines instead of 15.
    """
    if callable(scenario.speed) or callable(scenario.load):
        return apart(drive_at)(scenario, time)
    return drive_at(scenario, time)


def default_scenario(mechanism: Mechanism) -> Scenario | TorqueScenario:
    """The mechanism's own scenario, or that of its operating point.

    The latter is a step in speed, with the rollers initially at rest.

    **Raises:** `MissingDataError` if there is no scenario, and the operating point or its duration
    is not given.
    """
    if mechanism.scenario is not None:
        return mechanism.scenario
    point, other = mechanism.operating_point, "[scenario] (in Python, a Scenario as an argument)"
    if point is None:
        raise MissingDataError(
            "neither scenario nor operating point is given: give [operating_point] with speed, "
            f"load and duration, or {other}"
        )
    if point.duration is None:
        raise MissingDataError(f"operating_point.duration is missing: give it, or {other}")
    return Scenario(point.speed, point.load, point.duration)
