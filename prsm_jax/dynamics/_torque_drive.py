"""Prescribed torque: the screw as a state, with exact Coulomb friction that sticks and slips.

The carriers follow the screw (see `_torque_balance`), so the mechanism has one degree of freedom
and three modes: turning forward, turning backward, and sticking. While it turns everything is
smooth, also past standstill, because the directions of slip are those of the mode and not of the
speed; an event ends the mode where the speed passes through zero. While it sticks the torque lies
between the two limits at which it would begin to turn, and an event ends that where one is passed.
"""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..mechanism import Scalar
from ._integration import Settings
from ._solvers import adjoint_of, controller_of
from ._torque_balance import (
    BACKWARD,
    FORWARD,
    STICKING,
    TorqueProblem,
    breakaway_torques,
    moving,
)
from ._transient_result import Phase

#: While it sticks nothing moves, and steps are limited only so that they see what the torque does.
_STEPS_PER_SAMPLE = 4
#: Between these steps the torque is looked at again, afterwards: a phase that was passed over is
#: then reported.
_LOOKS_PER_SAMPLE = 32
#: Events are located to this share of the duration.
_EVENT = 1e-10


def next_mode(problem: TorqueProblem, time: Scalar, angle: Scalar, speed: Scalar) -> Scalar:
    """Mode in which the mechanism goes on: by its speed, or from rest by the torque."""
    lower, upper = breakaway_torques(problem, time, angle)
    # On a limit itself, where a phase of sticking has just ended, it turns: to the accuracy of the
    # event, before which a torque that jumps may still be far from the limit.
    later = problem.scenario.torque_at(time + 4 * _EVENT * problem.scenario.duration)
    now = problem.scenario.torque_at(time)
    width = 1e-9 * (jnp.abs(upper) + jnp.abs(lower))
    forward = jnp.maximum(now, later) >= upper - width
    backward = jnp.minimum(now, later) <= lower + width
    from_rest = jnp.where(forward, FORWARD, jnp.where(backward, BACKWARD, STICKING))
    return jax.lax.stop_gradient(jnp.where(speed == 0, from_rest, jnp.sign(speed)))


_MISSED = 8


def _missed(times, angles, modes, hold) -> Bool[Array, ""]:
    """Whether the torque passed a limit between two samples of one phase of sticking."""
    shares = jnp.arange(1, _LOOKS_PER_SAMPLE, dtype=times.dtype) / _LOOKS_PER_SAMPLE
    sticks = (modes[:-1] == STICKING) & (modes[1:] == STICKING) & (angles[:-1] == angles[1:])

    def passed(time, step, angle):
        return jnp.any(jax.vmap(lambda share: hold(time + share * step, angle))(shares) < -1e-6)

    passes = jax.vmap(passed)(times[:-1], jnp.diff(times), angles[:-1])
    return jax.lax.stop_gradient(jnp.any(sticks & passes))


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


def follow(problem: TorqueProblem, times: Float[Array, " times"], settings: Settings) -> StickSlip:
    """Integrate through all phases; each ends at an event, located by bisection.

    Steps are no longer than a quarter of the time between two samples. Where the torque passed a
    limit and came back between two steps of a phase of sticking, that is reported.

    Derivatives go through the events: the time at which a phase ends moves with the parameters.
    """
    import diffrax
    import optimistix

    scenario, inertia = problem.scenario, problem.total_inertia
    end, dtype = times[-1], times.dtype
    torque = problem.torque_scale
    #: Speed that such a torque reaches in the scene; states and time are of order one in it.
    scale = jax.lax.stop_gradient(torque * end / inertia)

    def rate(share, state, mode):
        time = share * end
        angle, speed = state[0] * scale * end, state[1] * scale
        sense = jnp.where(mode == STICKING, FORWARD, mode)
        acceleration = moving(problem, time, angle, speed, sense).acceleration
        turning = mode != STICKING
        moved = jnp.stack([state[1], acceleration * end / scale])
        return jnp.where(turning, moved, jnp.zeros_like(moved))

    def hold(time, angle):
        """How far the torque is from the nearer limit; positive while the mechanism sticks."""
        lower, upper = breakaway_torques(problem, time, angle)
        applied = scenario.torque_at(time)
        return jnp.minimum(upper - applied, applied - lower) / torque

    def margin(t, y, args, **_):
        """Positive while the phase lasts."""
        mode = args
        held = hold(t * end, y[0] * scale * end)
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
            dt0=grid[1] / _STEPS_PER_SAMPLE,
            y0=state,
            args=mode,
            saveat=diffrax.SaveAt(
                subs=(diffrax.SubSaveAt(t1=True), diffrax.SubSaveAt(ts=jnp.maximum(grid, start)))
            ),
            stepsize_controller=controller_of(
                settings.rtol,
                settings.atol,
                scenario.break_times / end,
                jnp.ones_like(end),
                grid[1] / _STEPS_PER_SAMPLE,
            ),
            event=diffrax.Event(
                margin,
                # Newton would leave the step where the margin bends.
                optimistix.Bisection(rtol=_EVENT, atol=_EVENT),
                direction=False,
            ),
            max_steps=settings.max_steps,
            throw=False,
            adjoint=adjoint_of(settings.gradient),
        )
        times_found: Any = solution.ts
        values_found: Any = solution.ys
        stop, last = times_found[0][-1], values_found[0][-1]
        # Where the torque jumps over the limit, bisection ends at two neighbouring numbers, and the
        # margin in between is never small.
        ended = (solution.result == diffrax.RESULTS.event_occurred) | (
            solution.result == diffrax.RESULTS.nonlinear_max_steps_reached
        )
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
    missed = _missed(times, values[:, 0] * scale * end, modes, hold)
    code = jnp.where((code == 0) & missed, _MISSED, code)
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
