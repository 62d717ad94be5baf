"""Prescribed torque with quasi-steady carriers: the screw as a state that sticks and slips.

The carriers follow the screw (see `_torque_balance`), so the mechanism has one degree of freedom
and three modes: turning forward, turning backward, and sticking. While it turns everything is
smooth, also past standstill, because the directions of slip are those of the mode and not of the
speed; an event ends the mode where the speed passes through zero. While it sticks the torque lies
between the two limits at which it would begin to turn; an event ends sticking at a limit.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ...fields import Scalar
from ...scenario import TorqueScenario
from ..histories import Phase, Settings
from ._phases import EVENT, PhaseLaws, before, follow_phases
from ._torque_balance import BACKWARD, FORWARD, STICKING, TorqueProblem, breakaway_torques, moving

#: While it sticks nothing moves, and steps are limited only to follow the torque.
STEPS_PER_SAMPLE = 4
#: Times per sample at which the torque is checked afterwards, to report a missed phase.
LOOKS_PER_SAMPLE = 32
#: Result code of a missed phase.
MISSED = 8


def next_mode(
    scenario: TorqueScenario, time: Scalar, speed: Scalar, limits: Float[Array, "2"]
) -> Scalar:
    """Next mode of the mechanism: by its speed, or from rest by the torque.

    **Arguments:**

    - `scenario`, `time`, `speed`: the drive, the time and the screw speed.
    - `limits`: torques at which it begins to turn backward and forward [N·m].
    """
    lower, upper = limits
    # At a limit, where a phase of sticking has just ended, it turns. The torque is checked within
    # the accuracy of the event: before the event, a torque that jumps may be far from the limit.
    later = scenario.torque_at(time + 4 * EVENT * scenario.duration)
    now = scenario.torque_at(time)
    width = 1e-9 * (jnp.abs(upper) + jnp.abs(lower))
    forward = jnp.maximum(now, later) >= upper - width
    backward = jnp.minimum(now, later) <= lower + width
    from_rest = jnp.where(forward, FORWARD, jnp.where(backward, BACKWARD, STICKING))
    return jax.lax.stop_gradient(jnp.where(speed == 0, from_rest, jnp.sign(speed)))


def holding_margin(applied: Scalar, limits: Float[Array, "2"]) -> Scalar:
    """How far a torque is from the nearer limit; positive while the mechanism sticks [N·m]."""
    lower, upper = limits
    return jnp.minimum(upper - applied, applied - lower)


def looks(time: Scalar, step: Scalar) -> Float[Array, " looks"]:
    """Times from a sample to the next, starting with the sample."""
    return time + step * jnp.arange(LOOKS_PER_SAMPLE, dtype=time.dtype) / LOOKS_PER_SAMPLE


def passed(margins: Float[Array, " looks"]) -> Bool[Array, ""]:
    """Whether the torque passed a limit between two samples.

    **Arguments:**

    - `margins`: `holding_margin` over the torque scale.
    """
    return jax.lax.stop_gradient(jnp.any(margins[1:] < -1e-6))


class StickSlip(eqx.Module):
    """Motion of the screw at the sample times, and the phases."""

    angle: Float[Array, " times"]
    speed: Float[Array, " times"]
    mode: Float[Array, " times"]
    phases: Phase
    steps: Int[Array, ""]
    rejected: Int[Array, ""]
    code: Int[Array, ""]


def follow(problem: TorqueProblem, times: Float[Array, " times"], settings: Settings) -> StickSlip:
    """Integrate through all phases; each ends at an event, located by bisection.

    Steps are no longer than a quarter of the time between two samples. If the torque passed a limit
    and came back between two steps of a phase of sticking, the code reports it.
    """

    scenario, inertia = problem.scenario, problem.total_inertia
    end, dtype = times[-1], times.dtype
    torque = problem.torque_scale
    #: Speed that the torque scale reaches in the scene; states and time are of order one in it.
    scale = jax.lax.stop_gradient(torque * end / inertia)

    def begin(share, persistent):
        time, angle = share * end, persistent[0] * scale * end
        limits = breakaway_torques(problem, time, angle)
        mode = next_mode(scenario, time, persistent[1] * scale, limits)
        return {"mode": mode}, persistent

    def rate(share, state, label):
        mode = label["mode"]
        angle, speed = state[0] * scale * end, state[1] * scale
        sense = jnp.where(mode == STICKING, FORWARD, mode)
        acceleration = moving(problem, share * end, angle, speed, sense).acceleration
        moved = jnp.stack([state[1], acceleration * end / scale])
        return jnp.where(mode != STICKING, moved, jnp.zeros_like(moved))

    def hold(time, angle):
        limits = breakaway_torques(problem, time, angle)
        return holding_margin(scenario.torque_at(time), limits) / torque

    def margin(share, state, label):
        mode = label["mode"]
        hold_margin = hold(before(share) * end, state[0] * scale * end)
        # A phase of turning may begin at rest, so it ends only where the speed is well past zero.
        return jnp.where(mode == STICKING, hold_margin, mode * state[1] + 1e-12)

    laws = PhaseLaws(
        begin,
        rate,
        margin,
        end=lambda state, _, ended: jnp.where(ended, state.at[1].set(0.0), state),
        longest=lambda _: times[1] / end / STEPS_PER_SAMPLE,
    )
    first = jnp.stack([jnp.zeros((), dtype), scenario.initial_speed.astype(dtype) / scale])
    solver = settings.method.make_solver(settings.rtol, settings.atol)
    solution = follow_phases(
        laws, first, times, scenario.break_times, scenario.most_phases, solver, settings
    )
    angle, mode = solution.states[:, 0] * scale * end, solution.labels["mode"]
    sticks = (mode[:-1] == STICKING) & (mode[1:] == STICKING) & (angle[:-1] == angle[1:])

    def missed(time, step, angle):
        return passed(jax.vmap(lambda look: hold(look, angle))(looks(time, step)))

    passes = jax.vmap(missed)(times[:-1], jnp.diff(times), angle[:-1])
    code = jnp.where((solution.code == 0) & jnp.any(sticks & passes), MISSED, solution.code)
    return StickSlip(
        angle=angle,
        speed=solution.states[:, 1] * scale,
        mode=mode,
        phases=solution.phases,
        steps=solution.steps,
        rejected=solution.rejected,
        code=code,
    )
