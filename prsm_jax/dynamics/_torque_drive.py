"""Prescribed torque: the screw as a state, with exact Coulomb friction that sticks and slips.

The carriers follow the screw (see `_quasi_steady`), so the mechanism has one degree of freedom and
three modes: turning forward, turning backward, and sticking. While it turns everything is smooth,
also past standstill, because the directions of slip are those of the mode and not of the speed;
an event ends the mode where the speed passes through zero. While it sticks the torque lies between
the two limits at which it would begin to turn, and an event ends that where one is passed.
"""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._physics import physics
from .._root import find_root
from ..mechanism import Mechanism, Scalar, TorqueScenario
from ._carrier_balance import balanced_carrier_ratio, steady_motion
from ._chain import StageState, chain_forces
from ._kinematics import StageKinematics, travel_per_turn
from ._stage_forces import Motion
from ._transient_result import Phase

FORWARD, BACKWARD, STICKING = 1.0, -1.0, 0.0


class TorqueProblem(eqx.Module):
    """Everything that the equation of motion needs, as one pytree."""

    mechanism: Mechanism
    kinematics: tuple[StageKinematics, ...]
    scenario: TorqueScenario
    inertia: Float[Array, " stages"]
    #: Inertia of everything that moves, seen by the screw, to scale accelerations [kg·m²].
    total_inertia: Scalar


class ScrewMotion(eqx.Module):
    """Angle, speed and acceleration of the screw."""

    angle: Scalar
    speed: Scalar
    acceleration: Scalar


@physics("torque_drive")
def drive_states(
    problem: TorqueProblem, time: Scalar, motion: ScrewMotion, sense: Scalar
) -> tuple[tuple[StageState, ...], Float[Array, " stages"], Bool[Array, ""], Scalar]:
    """Forces of all stages for a motion of the screw, with slip in the directions of a sense.

    **Returns:** the states, the carrier ratios, whether every balance was found, and the load [N].
    """
    mechanism, kinematics = problem.mechanism, problem.kinematics
    travel = travel_per_turn(mechanism.stages, len(mechanism.stages))
    position = problem.scenario.initial_position + travel * motion.angle
    load = problem.scenario.load(
        time, position, travel * motion.speed, travel * motion.acceleration
    )
    ratios: list[Scalar] = []
    valid = jnp.asarray(True)

    def motion_of(index: int, flank: Scalar, axial_force: Scalar, axial_acceleration) -> Motion:
        nonlocal valid
        own_speed, own_sense = flank * motion.speed, flank * sense
        ratio, found = balanced_carrier_ratio(
            mechanism.stages[index],
            kinematics[index],
            own_sense,
            own_speed,
            axial_force,
            problem.inertia[index] * (flank * motion.acceleration),
        )
        valid = valid & found
        ratios.append(ratio)
        return steady_motion(kinematics[index], ratio, own_speed, own_sense, axial_acceleration)

    states = chain_forces(
        mechanism, kinematics, motion_of, motion.speed, sense, load, motion.acceleration
    )
    for state in states:
        # Past the locking limit the axial balance asks for a pulling contact.
        valid = valid & (state.forces.contact_force >= 0)
    return states, jnp.stack(ratios[::-1]), valid, load


def required_torque(
    problem: TorqueProblem, time: Scalar, motion: ScrewMotion, sense: Scalar
) -> Scalar:
    """Torque at the first screw that a motion needs [N·m]."""
    return drive_states(problem, time, motion, sense)[0][0].screw.drive_torque


def acceleration_of(
    problem: TorqueProblem, time: Scalar, angle: Scalar, speed: Scalar, sense: Scalar
) -> tuple[Scalar, Bool[Array, ""]]:
    """Acceleration at which the required torque is the prescribed one [rad/s²].

    The friction of splines and thrust bearings depends on forces that depend on the acceleration:
    the loop is solved, by Newton, on an equation that is linear but for that.
    """
    torque, inertia = problem.scenario.torque_at(time), problem.total_inertia

    def residual(scaled: Scalar) -> Scalar:
        motion = ScrewMotion(angle, speed, scaled * size / inertia)
        return (required_torque(problem, time, motion, sense) - torque) / size

    still = ScrewMotion(angle, speed, jnp.zeros_like(speed))
    at_rest = jax.lax.stop_gradient(required_torque(problem, time, still, sense))
    size = jnp.abs(at_rest) + jnp.abs(jax.lax.stop_gradient(torque))
    size = jnp.where(size > 0, size, 1.0)
    scaled, found = find_root(residual, jnp.zeros_like(speed), tolerance=1e-12, max_steps=20)
    return scaled * size / inertia, found


def breakaway_torques(problem: TorqueProblem, time: Scalar, angle: Scalar) -> tuple[Scalar, Scalar]:
    """Torques at which a mechanism at rest begins to turn backward and forward [N·m].

    In between it sticks. Backward it holds by itself if that is negative: self-locking.
    """
    rest = ScrewMotion(angle, jnp.zeros_like(angle), jnp.zeros_like(angle))
    lower, upper = (
        required_torque(problem, time, rest, jnp.asarray(sense, angle.dtype))
        for sense in (BACKWARD, FORWARD)
    )
    return lower, upper


def next_mode(problem: TorqueProblem, time: Scalar, angle: Scalar, speed: Scalar) -> Scalar:
    """Mode in which the mechanism goes on: by its speed, or from rest by the torque."""
    lower, upper = breakaway_torques(problem, time, angle)
    torque = problem.scenario.torque_at(time)
    # On a limit itself, where a phase of sticking has just ended, it turns.
    width = 1e-9 * (jnp.abs(upper) + jnp.abs(lower))
    forward, backward = torque >= upper - width, torque <= lower + width
    from_rest = jnp.where(forward, FORWARD, jnp.where(backward, BACKWARD, STICKING))
    return jax.lax.stop_gradient(jnp.where(speed == 0, from_rest, jnp.sign(speed)))


class StickSlip(eqx.Module):
    """Motion of the screw at the sample times, and the phases it went through."""

    angle: Float[Array, " times"]
    speed: Float[Array, " times"]
    mode: Float[Array, " times"]
    phases: Phase
    phase_count: Int[Array, ""]
    steps: Int[Array, ""]
    rejected: Int[Array, ""]
    code: Int[Array, ""]


def follow(
    problem: TorqueProblem, times: Float[Array, " times"], rtol: float, atol: float, max_steps: int
) -> StickSlip:
    """Integrate through all phases; each ends at an event, located by bisection.

    A phase that would begin and end between two samples is not seen.

    Derivatives go through the events: the time at which a phase ends moves with the parameters.
    """
    import diffrax
    import optimistix

    scenario, inertia = problem.scenario, problem.total_inertia
    end, dtype = times[-1], times.dtype
    rest = required_torque(
        problem, times[0], ScrewMotion(*([jnp.zeros((), dtype)] * 3)), jnp.ones((), dtype)
    )
    torque = jnp.abs(jax.lax.stop_gradient(rest)) + jnp.abs(
        jax.lax.stop_gradient(scenario.torque_at(times[0]))
    )
    torque = jnp.where(torque > 0, torque, 1.0)
    #: Speed that such a torque reaches in the scene; states and time are of order one in it.
    scale = jax.lax.stop_gradient(torque * end / inertia)

    def rate(share, state, mode):
        time = share * end
        angle, speed = state[0] * scale * end, state[1] * scale
        sense = jnp.where(mode == STICKING, FORWARD, mode)
        acceleration, _ = acceleration_of(problem, time, angle, speed, sense)
        turning = mode != STICKING
        moved = jnp.stack([state[1], acceleration * end / scale])
        return jnp.where(turning, moved, jnp.zeros_like(moved))

    def margin(t, y, args, **_):
        """Positive while the phase lasts."""
        mode = args
        lower, upper = breakaway_torques(problem, t * end, y[0] * scale * end)
        applied = scenario.torque_at(t * end)
        held = jnp.minimum(upper - applied, applied - lower) / torque
        # A phase of turning begins at rest: it has ended when the speed is truly past zero.
        return jnp.where(mode == STICKING, held, mode * y[1] + 1e-12)

    def phase(carry, _):
        start, state, done, values, modes, steps, rejected, code = carry
        speed = state[1]
        mode = next_mode(problem, start * end, state[0] * scale * end, speed * scale)
        grid = times / end
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(rate),
            diffrax.Tsit5(),
            t0=start,
            t1=jnp.ones_like(start),
            dt0=None,
            y0=state,
            args=mode,
            saveat=diffrax.SaveAt(
                subs=(diffrax.SubSaveAt(t1=True), diffrax.SubSaveAt(ts=jnp.maximum(grid, start)))
            ),
            # No longer than a sample: nothing moves while it sticks, and one step over all of it
            # would not see the torque pass a limit and come back.
            stepsize_controller=diffrax.PIDController(rtol=rtol, atol=atol, dtmax=grid[1]),
            event=diffrax.Event(
                margin,
                # Newton would leave the step where the margin bends.
                optimistix.Bisection(rtol=1e-10, atol=1e-10),
                direction=False,
            ),
            max_steps=max_steps,
            throw=False,
            adjoint=diffrax.DirectAdjoint(),
        )
        times_found: Any = solution.ts
        values_found: Any = solution.ys
        stop, last = times_found[0][-1], values_found[0][-1]
        ended = solution.result == diffrax.RESULTS.event_occurred
        finished = solution.result == diffrax.RESULTS.successful
        inside = (grid >= start) & (grid <= stop) & jnp.logical_not(done)
        values = jnp.where(inside[:, None], values_found[1], values)
        modes = jnp.where(inside, mode, modes)
        last = jnp.where(ended, last.at[1].set(0.0), last)
        state = jnp.where(done, state, last)
        failed = jnp.logical_not(ended | finished | done)
        code = jnp.where(failed & (code == 0), 1, code)
        used = jnp.where(done, 0, 1)
        steps = steps + used * solution.stats["num_accepted_steps"]
        rejected = rejected + used * solution.stats["num_rejected_steps"]
        record = (start * end, jnp.where(done, start, stop) * end, mode)
        next_done = done | finished | failed
        following = jnp.where(done, start, stop)
        carry = (following, state, next_done, values, modes, steps, rejected, code)
        return carry, (record, jnp.logical_not(done))

    zero = jnp.zeros((), int)
    first = jnp.stack([jnp.zeros((), dtype), scenario.initial_speed.astype(dtype) / scale])
    start = (
        jnp.zeros((), dtype),
        first,
        jnp.asarray(False),
        jnp.zeros((len(times), 2), dtype),
        jnp.zeros(len(times), dtype),
        zero,
        zero,
        zero,
    )
    carry, (phases, used) = jax.lax.scan(phase, start, None, length=scenario.most_phases)
    _, _, done, values, modes, steps, rejected, code = carry
    code = jnp.where(done, code, jnp.where(code == 0, 5, code))
    return StickSlip(
        angle=values[:, 0] * scale * end,
        speed=values[:, 1] * scale,
        mode=modes,
        phases=Phase(*phases),
        phase_count=jnp.sum(used),
        steps=steps,
        rejected=rejected,
        code=code,
    )
