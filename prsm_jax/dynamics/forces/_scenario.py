"""The scenario of a mechanism that is simulated without one, and how scenarios drive."""

from typing import NamedTuple

from ..._errors import MissingDataError
from ...mechanism import Mechanism, Scalar, Scenario as Scenario, TorqueScenario
from ...numerics import apart


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
    """The same, computed once for all that follows from it.

    What follows would otherwise be fused with it: a step in which a sine drives the screw had 141
    sines and cosines in place of 13.
    """
    if callable(scenario.speed) or callable(scenario.load):
        return apart(drive_at)(scenario, time)
    return drive_at(scenario, time)


def default_scenario(mechanism: Mechanism) -> Scenario | TorqueScenario:
    """The mechanism's own scenario, or that of its operating point.

    The latter is a step of the speed from rollers at rest.

    **Raises:** `MissingDataError` if there is no scenario, and the operating point or its duration
    is not given.
    """
    if mechanism.scenario is not None:
        return mechanism.scenario
    point = mechanism.operating_point
    if point is None or point.duration is None:
        raise MissingDataError(
            "no scenario: pass one, or give [scenario], or [operating_point] with speed, load and "
            "duration"
        )
    return Scenario(point.speed, point.load, point.duration)
