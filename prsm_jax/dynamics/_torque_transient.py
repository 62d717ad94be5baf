"""Time histories under a prescribed torque."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..mechanism import Mechanism, TorqueScenario
from ._integration import Settings
from ._kinematics import travel_per_turn
from ._torque_balance import (
    BACKWARD,
    FORWARD,
    STICKING,
    ScrewMotion,
    breakaway_torques,
    instant,
    moving,
    resting,
    torque_problem,
)
from ._torque_drive import follow
from ._transient_result import CarrierHistory, SolverReport, Transient, histories


def torque_history(mechanism: Mechanism, scenario: TorqueScenario, settings: Settings) -> Transient:
    """Integrate under a prescribed torque, and evaluate all forces at the sample times.

    While the mechanism sticks, friction takes what it must; reported are then the forces at that
    one of the two limits which is nearer to the applied torque, and the applied torque itself.
    """
    problem = torque_problem(mechanism, scenario)
    dtype = problem.inertia.dtype
    times = jnp.linspace(0.0, 1.0, scenario.samples, dtype=dtype) * scenario.duration
    motion = follow(problem, times, settings)

    def at(time, angle, speed, mode):
        sticking = mode == STICKING
        lower, upper = breakaway_torques(problem, time, angle)
        applied = scenario.torque_at(time)
        nearer = jnp.where(applied - lower < upper - applied, BACKWARD, FORWARD)
        sense = jnp.where(sticking, nearer, mode)
        still, turning = (
            resting(problem, time, angle, sense),
            moving(problem, time, angle, speed, sense),
        )
        balance = jax.tree.map(lambda a, b: jnp.where(sticking, a, b), still, turning)
        acceleration = balance.acceleration
        now = instant(
            problem, time, ScrewMotion(angle, speed, acceleration), sense, balance.tangents
        )
        states, ratios, load = now.states, now.ratios, now.load
        drives = jnp.stack([state.forces.carrier_drive for state in states])
        carriers = jnp.where(sticking, jnp.zeros_like(drives), drives / problem.inertia)
        history = (speed, acceleration, load, ratios * speed, states, carriers)
        return history, now.valid & balance.found, applied

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
