"""Time histories under a prescribed torque."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..mechanism import Mechanism, TorqueScenario
from ._contact_losses import with_resistance
from ._kinematics import travel_per_turn
from ._stage_forces import carrier_inertia
from ._steady import all_kinematics
from ._torque_drive import (
    BACKWARD,
    FORWARD,
    STICKING,
    ScrewMotion,
    TorqueProblem,
    acceleration_of,
    breakaway_torques,
    drive_states,
    follow,
    required_torque,
)
from ._transient_result import CarrierHistory, SolverReport, Transient, histories


def torque_problem(mechanism: Mechanism, scenario: TorqueScenario) -> TorqueProblem:
    """Collect what the equation of motion needs."""
    kinematics = with_resistance(mechanism.stages, all_kinematics(mechanism))
    inertia = jnp.stack([carrier_inertia(stage) for stage in mechanism.stages])
    zero = jnp.zeros((), inertia.dtype)
    problem = TorqueProblem(mechanism, kinematics, scenario, inertia, jnp.ones_like(zero))

    def torque(acceleration):
        motion = ScrewMotion(zero, zero, acceleration)
        return required_torque(problem, zero, motion, jnp.ones_like(zero))

    _, total = jax.jvp(torque, (zero,), (jnp.ones_like(zero),))
    # Only a scale: nothing is differentiated through it.
    return eqx.tree_at(lambda p: p.total_inertia, problem, jax.lax.stop_gradient(total))


def torque_history(
    mechanism: Mechanism, scenario: TorqueScenario, rtol: float, atol: float, max_steps: int
) -> Transient:
    """Integrate under a prescribed torque, and evaluate all forces at the sample times.

    While the mechanism sticks, friction takes what it must; reported are then the forces at that
    one of the two limits which is nearer to the applied torque, and the applied torque itself.
    """
    problem = torque_problem(mechanism, scenario)
    dtype = problem.inertia.dtype
    times = jnp.linspace(0.0, 1.0, scenario.samples, dtype=dtype) * scenario.duration
    motion = follow(problem, times, rtol, atol, max_steps)

    def at(time, angle, speed, mode):
        sticking = mode == STICKING
        lower, upper = breakaway_torques(problem, time, angle)
        applied = scenario.torque_at(time)
        nearer = jnp.where(applied - lower < upper - applied, BACKWARD, FORWARD)
        sense = jnp.where(sticking, nearer, mode)
        acceleration, found = acceleration_of(problem, time, angle, speed, sense)
        acceleration = jnp.where(sticking, 0.0, acceleration)
        states, ratios, valid, load = drive_states(
            problem, time, ScrewMotion(angle, speed, acceleration), sense
        )
        drives = jnp.stack([state.forces.carrier_drive for state in states])
        carriers = jnp.where(sticking, jnp.zeros_like(drives), drives / problem.inertia)
        history = (speed, acceleration, load, ratios * speed, states, carriers)
        return history, valid & (found | sticking), applied

    rows, valid, applied = jax.vmap(at)(times, motion.angle, motion.speed, motion.mode)
    history = CarrierHistory(*rows)
    code = jnp.where((motion.code == 0) & jnp.logical_not(jnp.all(valid)), 4, motion.code)
    report = SolverReport(motion.steps, motion.rejected, code, "Tsit5 with events")
    found = histories(mechanism, problem.kinematics, times, history, report)
    travel = travel_per_turn(mechanism.stages, len(mechanism.stages))
    position: Float[Array, " times"] = travel * motion.angle
    return eqx.tree_at(
        lambda run: (run.drive_torque, run.position, run.sticking, run.phases),
        found,
        (applied, position, motion.mode == STICKING, motion.phases),
        is_leaf=lambda leaf: leaf is None,
    )
