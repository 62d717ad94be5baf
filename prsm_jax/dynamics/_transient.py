"""Transients of the carriers, integrated with diffrax."""

import dataclasses

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .._errors import MissingDataError, PrsmError
from ..fields import Scalar, refuse_options
from ..mechanism import Mechanism, of_one_design
from ..numerics import over_samples
from ..programs import is_known, repeated_program, traceable
from ..scenario import TorqueScenario, check_scenario
from ._kinematics import StageKinematics, free_carrier_ratio
from .forces import Scenario, default_scenario, drive_once
from .friction import has_bristles
from .histories import (
    CANNOT_BE_BUILT,
    MEANS_NOTHING,
    CarrierHistory,
    Settings,
    SolverReport,
    Transient,
    histories,
    integrated,
    judged_by_input,
    rows_of,
    transient_of,
)
from .solvers import (
    ATOL,
    MAX_STEPS,
    RTOL,
    BothModes,
    ForwardMode,
    Gradient,
    GradientMode,
    Method,
    MethodName,
    Rodasp,
    gradient_of,
    is_concrete,
    method_of,
    options_of,
)
from .speed_drive import (
    Problem,
    bristle_history,
    carrier_acceleration,
    chosen_method,
    closed_form_history,
    driven_states,
    error_weight,
    moves_nut,
    quasi_steady_at,
    quasi_steady_report,
    sample_times,
    scaled_rate,
    scene_problem,
    slides_on_both_sides,
    standstills,
    two_sides_history,
)
from .torque_drive import has_smooth_threads, smooth_torque_history, torque_history


@of_one_design
def simulate(
    mechanism: Mechanism,
    scenario: Scenario | TorqueScenario | None = None,
    *,
    method: Method | MethodName = "auto",
    gradient: GradientMode | Gradient = "both",
    rtol: float | Scalar | None = None,
    atol: float | Scalar | None = None,
    max_steps: int | None = None,
    throw: bool = True,
    kinematics: tuple[StageKinematics, ...] | None = None,
) -> Transient:
    """Simulate a mechanism under a prescribed screw speed, or a prescribed torque, and load.

    Under a prescribed torque (`TorqueScenario`) screw and carriers are states. They stick and slip
    with exact Coulomb friction, and events are located: the screw may be held while carriers coast.
    The method `"quasi_steady"` keeps the carriers in balance instead, with the screw as the only
    state; `solver.error_estimate` is then the error of the screw speed over the largest screw
    speed. With LuGre or regularised Coulomb friction in the threads the motion through standstill
    is smooth, bristles are states as well, and `"quasi_steady"` acts as `"auto"`. All that
    follows applies to a prescribed speed.

    Threads with LuGre friction add the deflections of their bristles to the states. These are
    stiff, so choose a method for stiff scenes.

    States are the carrier speeds, `[n_P J_P + N J_R (n − 1)² + N m_R a²] ω̇ = N f·d − resisting
    moments` (Li et al. 2021, in Lagrange's form); all forces follow algebraically at the sample
    times. Speed and time are scaled internally by the highest screw speed and the shortest time
    constant, so the tolerances are relative to those.

    **Arguments:**

    - `mechanism`: the mechanism, with masses and inertias of rollers and carriers (and of screws
      and nuts if the speed varies).
    - `scenario`: speed, load, duration; default the mechanism's own, else its operating point.
    - `method`: a word, or an object that carries its own options (`Rodasp(rtol=1e-6)`,
      `Diffrax(diffrax.Kvaerno5())` for any solver of diffrax). `"auto"` (see `choose_method`),
      `"closed_form"` (constant speed, load and friction coefficients: exact at any time, no
      integration), `"quasi_steady"` (no integration: carriers in balance at every instant, without
      their settling from the initial ratio; for scenes much longer than `solver.time_constant`, and
      the best for exact Coulomb friction through standstill. `solver.error_estimate` estimates
      the error by neglected terms), `"rosenbrock"` (RODASP 4/3, any stiffness, no iterations: the
      cheapest method that integrates), `"explicit"` (Tsitouras 5/4, not for stiff scenes), or
      `"implicit"` (Kvaerno 5/4 with Newton, any stiffness, the reference).
    - `gradient`: `"both"` (either mode through one program), `"reverse"` or `"forward"` (for few
      parameters). With the first two, RODASP at a prescribed speed keeps its steps, and derivatives
      follow them: reverse mode takes three to five times as long as the values, by any number of
      parameters. Elsewhere a first integration chooses the steps, and a second one repeats them for
      the derivatives; `"reverse"` is then checkpointed (bounded memory for long scenes), and for
      tolerances below 1e-10. Values are those of the first integration.
      Under a prescribed torque `"reverse"` integrates twice, to choose the steps and to take them,
      and agrees with forward mode to the tolerance; reverse mode through `"both"` to about 1e-5.
    - `rtol`, `atol`: step tolerances on the carrier ratio, for a method given by a word that takes
      them; 1e-8 and 1e-10 if not given; in float32 at least 1e-6 and 1e-7. Where, at a small lead,
      friction changes its direction within a narrow range of ratios, tolerances are relative to
      that range. Derivatives are those of the steps taken: at the default within about 2e-5 of the
      exact ones (`"implicit"` 1e-4; more where parts of them cancel), and within a hundredth of
      that at 1e-10.
    - `max_steps`: steps allowed, 4,096 if not given; `solver` reports if they do not suffice.
    - `throw`: raise if the solver fails. Inside a trace nothing is raised; see `solver.code`.
    - `kinematics`: kinematics of the stages, if known already.

    **Raises:** `MissingDataError` if masses or the scenario are not given, and for a prescribed
    torque or LuGre friction of recirculating and differential roller screws; `ValueError` for an
    unknown method or gradient, an option that the method does not take, an invalid scenario (a
    duration that is not above 0, NaN or infinite numbers), or the closed form under a prescribed
    torque; `PrsmError` if `throw` is set and the solver fails or the mechanism cannot be built (a
    dimension out of range, rollers that overlap).
    """
    requested = method_of(method, rtol=rtol, atol=atol, max_steps=max_steps)
    if scenario is None:
        scenario = default_scenario(mechanism)
    check_scenario(scenario)
    _check_grooved(mechanism, scenario, requested)
    settings = _settings(requested, gradient_of(gradient), scenario)
    # The scenario is a separate argument; in the mechanism it would be traced a second time.
    mechanism = dataclasses.replace(mechanism, scenario=None)
    scene = mechanism, scenario, kinematics = traceable((mechanism, scenario, kinematics))
    known = is_known((*scene, settings.rtol, settings.atol))
    either = isinstance(settings.gradient, BothModes)
    if known and either and not any(map(callable, jax.tree.leaves(scene))):
        # Nothing is differentiated; the loop of forward mode stops after the last step.
        settings = settings._replace(gradient=ForwardMode())
    if requested.chooses and isinstance(scenario, Scenario):
        chosen = chosen_method(
            mechanism, scenario, kinematics, settings.rtol, known, settling=True
        ).method
        settings = settings._replace(method=method_of(chosen))
    run, code = _transient(*scene, settings)
    closed = settings.method.carriers == "closed_form"
    if requested.chooses and closed and known and int(code) != 0:
        run, _ = _transient(*scene, settings._replace(method=Rodasp()))
    return _checked(run, throw)


def _check_grooved(
    mechanism: Mechanism, scenario: Scenario | TorqueScenario, method: Method
) -> None:
    """Refuse what is not known for rollers without lead.

    **Raises:** `MissingDataError` for a prescribed torque and for bristles; `ValueError` for a
    method that does not integrate.
    """
    if not (moves_nut(mechanism) or slides_on_both_sides(mechanism)):
        return
    named = f'type = "{mechanism.stages[0].type}"'
    if isinstance(scenario, TorqueScenario):
        raise MissingDataError(
            f"transients under a prescribed torque are not known for {named}; prescribe the speed"
        )
    if has_bristles(mechanism):
        raise MissingDataError(
            f"LuGre friction of the threads is not known for {named}; take another law"
        )
    if not method.chooses and method.carriers != "integrated":
        raise ValueError(
            f"method {method.word!r} is not for {named}; choose rosenbrock, explicit or implicit"
        )


def _settings(
    method: Method, gradient: GradientMode, scenario: Scenario | TorqueScenario
) -> Settings:
    """Settings of the integration by a method.

    **Raises:** `ValueError` for a method, or an option of it, that has no meaning in this scene.
    """
    torque = isinstance(scenario, TorqueScenario)
    method.check(gradient, torque)
    own_options = {name: getattr(method, name) for name in options_of(type(method))}
    if method.carriers == "in_balance" and not torque:
        named = [name for name, value in own_options.items() if value is not None]
        refuse_options(f"method {method.word!r}", named, (), " at a prescribed speed")
    defaults = {"rtol": RTOL, "atol": ATOL, "max_steps": MAX_STEPS}
    options = {
        name: value if own_options.get(name) is None else own_options[name]
        for name, value in defaults.items()
    }
    return Settings(method, gradient, **options)


@repeated_program
def _transient(
    mechanism: Mechanism,
    scenario: Scenario | TorqueScenario,
    kinematics: tuple[StageKinematics, ...] | None,
    settings: Settings,
) -> tuple[Transient, Int[Array, ""]]:
    """A transient by the method in the settings, and the result code of the method itself."""
    settings = settings.within(jnp.result_type(scenario.duration))
    if isinstance(scenario, TorqueScenario):
        history_of = smooth_torque_history if has_smooth_threads(mechanism) else torque_history
        run = history_of(mechanism, scenario, settings)
        return run, run.solver.code
    if slides_on_both_sides(mechanism):
        run = two_sides_history(mechanism, scenario, kinematics, settings)
        return judged_by_input(run, scenario), run.solver.code
    problem = scene_problem(mechanism, scenario, kinematics)
    times = sample_times(problem)
    if has_bristles(mechanism) and settings.method.carriers == "integrated":
        history, report = bristle_history(problem, times, settings)
        run = histories(mechanism, problem.kinematics, times, history, report)
        return judged_by_input(run, scenario), report.code
    # One pass per time, from the state to its results: all states of a long scene at once would
    # take more memory than the results, and would have to be read from there.
    rows_at = rows_of(mechanism, problem.kinematics)
    if settings.method.carriers == "in_balance":
        balanced_at = quasi_steady_at(problem)

        def balanced(time):
            history, neglected = balanced_at(time)
            return rows_at(history), neglected

        rows, neglected = over_samples(balanced, times)
        report = quasi_steady_report(neglected)
    else:
        if settings.method.carriers == "closed_form":
            speeds, report = closed_form_history(problem.reduced, problem.scenario, times)
        else:
            speeds, report = _integrated(problem, times, settings)
        rows = over_samples(lambda time, w: rows_at(evaluated(problem, time, w)), times, speeds)
    run = transient_of(mechanism, problem.kinematics, times, rows, report)
    return judged_by_input(run, scenario), report.code


def _checked(run: Transient, throw: bool) -> Transient:
    if throw and is_concrete(run.solver.code) and int(run.solver.code) != 0:
        code = int(run.solver.code)
        failure = "did not finish" if code < CANNOT_BE_BUILT else "is of an impossible mechanism"
        failure = failure if code < MEANS_NOTHING else "has invalid input"
        raise PrsmError(f"the transient {failure}: {run.solver.result}")
    return run


def _integrated(
    problem: Problem, times: Float[Array, " times"], settings: Settings
) -> tuple[Float[Array, "times stages"], SolverReport]:
    """Carrier speeds from their equation of motion, integrated [rad/s]."""
    scenario = problem.scenario
    start = scenario.initial_carrier_ratio * scenario.speed_at(times[0]) / problem.speed_scale
    constant = not (callable(scenario.speed) or callable(scenario.load))
    ratio, report = integrated(
        scaled_rate,
        start * jnp.ones_like(problem.inertia),
        scenario.duration / problem.time_scale,
        scenario.break_times / problem.time_scale,
        scenario.samples,
        settings,
        args=problem,
        autonomous=constant,
        longest=_longest_stable(problem, settings.method.longest_step) if constant else None,
        weight=error_weight(problem, settings.atol),
        standstills=standstills(problem, settings.atol),
    )
    return ratio * problem.speed_scale, report


def _longest_stable(problem: Problem, share: float | None) -> Scalar | None:
    """The longest scaled step at which a method damps deviations of the carriers.

    `share` is that over their time constant; `None` for a method that damps them at any step. The
    error estimate of settled carriers vanishes, so steps would become ever longer, and
    derivatives through such steps would grow without bound.
    """
    if share is None:
        return None
    zero = jnp.zeros_like(problem.speed_scale)
    free = jnp.stack([free_carrier_ratio(k) for k in problem.kinematics])
    settled = free * problem.scenario.speed_at(zero) / problem.speed_scale
    constant = scaled_rate.with_constant_drive()
    slopes = jax.jacfwd(lambda ratio: constant(zero, ratio, problem))(settled)
    fastest = jax.lax.stop_gradient(jnp.max(jnp.abs(jnp.diagonal(slopes))))
    settles = fastest > 0
    return jnp.where(settles, share / jnp.where(settles, fastest, 1.0), jnp.inf)


def evaluated(
    problem: Problem, time: Scalar, carrier_speed: Float[Array, " stages"]
) -> CarrierHistory:
    """Forces and accelerations of all stages at one time."""
    motion = drive_once(problem.scenario, time)
    rates = None
    if moves_nut(problem.mechanism):
        rates = carrier_acceleration(problem, motion, carrier_speed)
    states = driven_states(problem.mechanism, problem.kinematics, motion, carrier_speed, rates)
    drives = jnp.stack([state.forces.carrier_drive for state in states])
    return CarrierHistory(*motion, carrier_speed, states, drives / problem.inertia)
