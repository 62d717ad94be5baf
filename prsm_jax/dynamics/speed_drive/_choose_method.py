"""Choice of the cheapest method that suits a scene."""

from typing import NamedTuple

import jax.numpy as jnp

from ...fields import Scalar
from ...mechanism import Mechanism, of_one_design
from ...numerics import over_samples
from ...programs import is_known, repeated_program, traceable
from ...scenario import TorqueScenario
from .._kinematics import StageKinematics
from ..forces import Scenario, bound_scenario
from ..friction import has_bristles, with_resistance
from ..solvers import MethodName
from ..steady import all_kinematics
from ._carrier_motion import Problem, carrier_problem, jumps_at_standstill, moves_nut, sample_times
from ._closed_form import closed_form_history, settles_in_closed_form
from ._quasi_steady import quasi_steady_at, quasi_steady_report
from ._two_sides_transient import slides_on_both_sides

#: Largest time constant of settling over the time between two samples at which settling does not
#: show: after so many time constants the initial deviation has decayed to rounding.
_UNSEEN = 1 / 36
#: Accepted error of quasi-steady carriers over the tolerance of the scene.
_ACCEPTED = 10.0


class MethodChoice(NamedTuple):
    """A method of `simulate`, and why it was chosen."""

    method: MethodName
    reason: str


@of_one_design
def choose_method(
    mechanism: Mechanism, scenario: Scenario | TorqueScenario, *, rtol: float = 1e-8
) -> MethodChoice:
    """The method that `simulate(method="auto")` takes.

    1. Constant speed and load with Coulomb friction: the closed form, unless a torque or a load
       changes its sign while the carriers settle.
    2. Varying speed or load: quasi-steady, if the carriers settle between two samples and the
       estimated error of the neglected terms stays below 10 rtol; or, whatever the estimated error,
       if the screw passes a standstill at which thread friction jumps, because no integrator passes
       it cleanly. The reason says which of the two, and states the error.
    3. Everything else: RODASP, whether stiff or not (the chart of `benchmarks`, case transient,
       compares it with the explicit and the implicit solver).

    Under a prescribed torque it is RODASP, with screw and carriers as states. The other choice,
    quasi-steady carriers, is never made automatically.

    Inside a trace (`jit`, `vmap`, `grad`) no number is known, and the choice depends on the
    structure of the scene alone: the closed form or RODASP. For the full choice, call this outside
    and pass the method.

    **Arguments:**

    - `mechanism`, `scenario`: the scene.
    - `rtol`: the tolerance that `simulate` is called with.

    **Returns:** the method and the reason.

    **Raises:** `MissingDataError` as `simulate` does.
    """
    if isinstance(scenario, TorqueScenario):
        return MethodChoice("rosenbrock", "torque prescribed: screw and carriers are states")
    scene = traceable((mechanism, scenario, None))
    return chosen_method(*scene, rtol, is_known((*scene, rtol)))


def scene_problem(
    mechanism: Mechanism, scenario: Scenario, kinematics: tuple[StageKinematics, ...] | None
) -> Problem:
    """Input of the methods for a prescribed speed."""
    scenario = bound_scenario(mechanism, scenario)
    if kinematics is None:
        kinematics = all_kinematics(mechanism)
    return carrier_problem(mechanism, with_resistance(mechanism.stages, kinematics), scenario)


def chosen_method(
    mechanism: Mechanism,
    scenario: Scenario,
    kinematics: tuple[StageKinematics, ...] | None,
    rtol: float | Scalar,
    known: bool,
    *,
    settling: bool = False,
) -> MethodChoice:
    """As `choose_method`.

    **Arguments:**

    - `mechanism`, `scenario`, `kinematics`, `rtol`: as those of `simulate`.
    - `known`: whether numbers are known (outside a trace).
    - `settling`: take the closed form without checking that it holds; its result code tells.
    """
    scene = (mechanism, scenario, kinematics)
    if moves_nut(mechanism) or slides_on_both_sides(mechanism):
        return MethodChoice("rosenbrock", "rollers without lead: the carriers do not move alone")
    if settles_in_closed_form(mechanism, scenario):
        if settling or not known or int(_settling_code(*scene)) == 0:
            return MethodChoice("closed_form", "constant speed and load, Coulomb friction")
        return MethodChoice("rosenbrock", "a torque or a load changes its sign while settling")
    if has_bristles(mechanism):
        return MethodChoice("rosenbrock", "bristles are stiff")
    if known and (callable(scenario.speed) or callable(scenario.load)):
        code, error, lag, reverses, step = (jnp.asarray(x).item() for x in _quasi_steady(*scene))
        unseen = lag < _UNSEEN * step
        if code == 0 and unseen and error < _ACCEPTED * rtol:
            return MethodChoice(
                "quasi_steady",
                f"carriers settle between samples (time constant {lag:.2g} s); error {error:.1g}",
            )
        if code == 0 and reverses and jumps_at_standstill(mechanism):
            return MethodChoice(
                "quasi_steady",
                f"friction jumps at standstill of the screw; error {error:.1g}",
            )
    return MethodChoice("rosenbrock", "has to be integrated")


@repeated_program
def _settling_code(mechanism, scenario, kinematics):
    problem = scene_problem(mechanism, scenario, kinematics)
    return closed_form_history(problem.reduced, problem.scenario, sample_times(problem))[1].code


@repeated_program
def _quasi_steady(mechanism, scenario, kinematics):
    problem = scene_problem(mechanism, scenario, kinematics)
    times = sample_times(problem)
    balanced_at = quasi_steady_at(problem)

    def at(time):
        history, neglected = balanced_at(time)
        return history.screw_speed, neglected

    speed, neglected = over_samples(at, times)
    report = quasi_steady_report(neglected)
    reverses = jnp.any(speed[1:] * speed[:-1] <= 0)
    results = (report.code, report.error_estimate, report.time_constant, reverses)
    return *results, times[1] - times[0]
