"""Time histories under a prescribed torque."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...fields import Scalar
from ...mechanism import Mechanism
from ...scenario import TorqueScenario
from .._kinematics import travel_per_radian
from ..forces import all_push
from ..histories import (
    CarrierHistory,
    Phase,
    Settings,
    SolverReport,
    Transient,
    code_of_finite,
    histories,
)
from ._driven_carriers import driven, onsets, resists_turning, slip_geometry
from ._neglected_lag import neglected
from ._stick_slip import follow_carriers
from ._torque_balance import (
    BACKWARD,
    FORWARD,
    STICKING,
    ScrewMotion,
    TorqueProblem,
    breakaway_torques,
    instant,
    moving,
    resting,
    torque_problem,
)
from ._torque_drive import MISSED, follow, holding_margin, looks, passed


def torque_history(mechanism: Mechanism, scenario: TorqueScenario, settings: Settings) -> Transient:
    """Integrate under a prescribed torque, and evaluate all forces at the sample times.

    Carriers are states too, unless the method is `"quasi_steady"`. While the mechanism sticks,
    friction balances the applied torque; the reported forces are then those at the limit nearer to
    the applied torque, and the reported torque is the applied one.
    """
    problem = torque_problem(mechanism, scenario)
    times = jnp.linspace(0.0, 1.0, scenario.samples, dtype=problem.inertia.dtype)
    times = times * scenario.duration
    if settings.method.carriers == "in_balance":
        return _quasi_steady(problem, times, settings)
    return _integrated(problem, times, settings)


def _nearer(applied: Scalar, limits: Float[Array, "2"]) -> Scalar:
    """Sense of the limit that is nearer to a torque."""
    lower, upper = limits
    return jnp.where(applied - lower < upper - applied, BACKWARD, FORWARD)


def _integrated(
    problem: TorqueProblem, times: Float[Array, " times"], settings: Settings
) -> Transient:
    """Screw and carriers as states."""
    motions = follow_carriers(problem, times, settings)
    resists = jnp.asarray(resists_turning(problem))

    def at(time, step, sticks, angle, speed, mode, carriers):
        rests = (mode == STICKING) & ~jnp.any(carriers.coasts)
        # One program for the limits here, and between this sample and the next.
        between = looks(time, step)
        onward = jax.vmap(lambda look: onsets(problem, look, angle, carriers))(between)
        limits = onward[0][0].screw.drive_torque
        torques = jax.vmap(problem.scenario.torque_at)(between)
        missed = sticks & passed(jax.vmap(holding_margin)(torques, limits) / problem.torque_scale)
        applied = problem.scenario.torque_at(time)
        forward = _nearer(applied, limits[0]) == FORWARD
        resting, load = jax.tree.map(lambda x: jnp.where(forward, x[0, 1], x[0, 0]), onward)
        now = driven(problem, time, angle, speed, mode, carriers)
        states = jax.tree.map(lambda a, b: jnp.where(rests, a, b), resting, now.states)
        acceleration, accelerations = (
            jnp.where(rests, 0.0, rate) for rate in (now.acceleration, now.carriers)
        )
        load = jnp.where(rests, load, now.load)
        # The resistance of rollers can stop them, but not reverse them.
        dragged = resists & ~carriers.coasts
        dragged = dragged & (slip_geometry(problem).ratio(carriers.tangent) < 0)
        if carriers.senses is not None:
            dragged = dragged & (carriers.senses.nut > 0)
        valid = all_push(states) & ~jnp.any(dragged) & (rests | now.converged)
        return (acceleration, load, states, accelerations), valid, applied, missed

    rows, valid, applied, missed = jax.vmap(at)(
        times,
        jnp.diff(times, append=times[-1:]),
        motions.sticks,
        motions.angle,
        motions.speed,
        motions.mode,
        motions.carriers,
    )
    acceleration, load, states, accelerations = rows
    history = CarrierHistory(
        motions.speed, acceleration, load, motions.carrier_speed, states, accelerations
    )
    solution = motions.solution
    # The torque passed a limit and came back between two steps of a phase of sticking.
    code = jnp.where((solution.code == 0) & jnp.any(missed), MISSED, solution.code)
    report = SolverReport(solution.steps, solution.rejected, code, f"{settings.name} with events")
    run = _checked_histories(problem, times, history, report, valid)
    return _with_motion(problem, run, applied, motions.angle, motions.mode, solution.phases)


def _quasi_steady(
    problem: TorqueProblem, times: Float[Array, " times"], settings: Settings
) -> Transient:
    """The screw as a state, with carriers in balance at every instant."""
    motion = follow(problem, times, settings)

    def at(time, angle, speed, mode):
        sticking = mode == STICKING
        applied = problem.scenario.torque_at(time)
        limits = breakaway_torques(problem, time, angle)
        sense = jnp.where(sticking, _nearer(applied, limits), mode)
        at_rest, turning = (
            resting(problem, time, angle, sense),
            moving(problem, time, angle, speed, sense),
        )
        balance = jax.tree.map(lambda a, b: jnp.where(sticking, a, b), at_rest, turning)
        acceleration = balance.acceleration
        now = instant(
            problem, time, ScrewMotion(angle, speed, acceleration), sense, balance.unknowns
        )
        states, ratios, load = now.states, now.ratios, now.load
        drives = jnp.stack([state.forces.carrier_drive for state in states])
        carriers = jnp.where(sticking, jnp.zeros_like(drives), drives / problem.inertia)
        history = (speed, acceleration, load, ratios * speed, states, carriers)
        return history, now.valid & balance.converged, applied

    rows, valid, applied = jax.vmap(at)(times, motion.angle, motion.speed, motion.mode)
    history = CarrierHistory(*rows)
    error, longest = neglected(problem, times, history, motion.mode)
    report = SolverReport(
        motion.steps,
        motion.rejected,
        motion.code,
        "quasi-steady carriers, Tsit5 with events",
        error_estimate=error,
        time_constant=longest,
    )
    run = _checked_histories(problem, times, history, report, valid)
    return _with_motion(problem, run, applied, motion.angle, motion.mode, motion.phases)


def _checked_histories(
    problem: TorqueProblem,
    times: Float[Array, " times"],
    history: CarrierHistory,
    report: SolverReport,
    valid: Bool[Array, " times"],
) -> Transient:
    code = jnp.where((report.code == 0) & jnp.logical_not(jnp.all(valid)), 4, report.code)
    report = eqx.tree_at(lambda r: r.code, report, code)
    return histories(problem.mechanism, problem.kinematics, times, history, report)


def _with_motion(
    problem: TorqueProblem,
    run: Transient,
    applied: Float[Array, " times"],
    angle: Float[Array, " times"],
    mode: Float[Array, " times"],
    phases: Phase,
) -> Transient:
    stages = problem.mechanism.stages
    position = travel_per_radian(stages, len(stages)) * angle
    # A held screw stays at rest even if the torque is NaN.
    code = code_of_finite(run.solver.code, jnp.isfinite(applied + position))
    return eqx.tree_at(
        lambda run: (run.drive_torque, run.position, run.sticking, run.phases, run.solver.code),
        run,
        (applied, position, mode == STICKING, phases, code),
        is_leaf=lambda leaf: leaf is None,
    )
