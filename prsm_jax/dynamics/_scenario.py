"""The scenario of a mechanism that is simulated without one."""

from .._errors import MissingDataError
from ..mechanism import Mechanism, Scenario as Scenario, TorqueScenario


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
