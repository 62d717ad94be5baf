"""Prescribed torque with carriers as states: screw and carriers stick and slip independently.

Modes are those of the screw: it turns forward, turns backward, or is held. While it turns, each
carrier is in step with it, or coasts (`_driven_carriers`); while it is held, carriers rest, or
coast until friction has stopped them. An event ends a phase where the screw speed passes through
zero, where the torque passes the limit of a held screw, where a coasting carrier stops, or where a
carrier changes between in step and coasting. After a reversal the screw turns against a carrier for
a while: where the rollers begin to turn the other way their resistance jumps, which is an event as
well.

In step, the tangent of the slip settles at a rate inversely proportional to the screw speed, which
is unbounded as the screw stops: it ends in the ratio in which screw and carriers come to rest
together. Below a speed of `_SLOWEST` the rate is constant; the effect is of second order in that
speed. Past the end of the phase the rate decreases as it grew before, so that a long step across
standstill meets no rate much larger than at its beginning. With the largest rate held there, every
stage of such a step multiplied the deviation of carriers from balance: values in exact balance
passed the error control, and their derivatives, with errors by rounding only, were wrong.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..._errors import MissingDataError
from ...fields import Scalar
from ...numerics import min_few
from ..histories import Phase, Settings
from ._driven_carriers import (
    Carriers,
    driven,
    leaving,
    onset_torques,
    resists_turning,
    slip_geometry,
    turning_over,
)
from ._phases import EVENT, PhaseLaws, Phases, before, follow_phases
from ._torque_balance import FORWARD, STICKING, TorqueProblem
from ._torque_drive import STEPS_PER_SAMPLE, holding_margin, next_mode

#: Speeds of carriers over that of the screw: above `_COASTS` they coast, below `_BACK` they are in
#: step again; at the start of a phase `_MIDDLE` is the limit.
_BACK, _MIDDLE, _COASTS = 4.0, 5.0, 6.0
#: Speeds over the speed scale: beyond which a speed counts as past zero, below which a carrier
#: counts as at rest once the screw is, and below which settling becomes no faster.
_PAST, _AT_REST, _SLOWEST = 1e-12, 1e-9, 1e-7
#: Turning of rollers over the screw's, past zero, at which their resistance changes its sign: more
#: than the change of turning within the accuracy of event times.
_TURNED = 1e-6


class Motions(eqx.Module):
    """Motion of screw and carriers at the sample times, and the phases."""

    angle: Float[Array, " times"]
    speed: Float[Array, " times"]
    mode: Float[Array, " times"]
    carriers: Carriers
    #: ω [rad/s].
    carrier_speed: Float[Array, "times stages"]
    #: Whether everything is at rest from a sample to the next.
    sticks: Bool[Array, " times"]
    solution: Phases


def _check_friction(problem: TorqueProblem) -> None:
    for number, stage in enumerate(problem.mechanism.stages, start=1):
        if stage.friction is None or stage.friction.thread is None:
            raise MissingDataError(
                f"stage {number}: only thread friction can drive the rollers; give "
                "[stage.friction.thread]"
            )


class _Law(eqx.Module):
    """The motion in numbers of order one: speeds over a scale, and shares of the duration."""

    problem: TorqueProblem
    #: [s], [rad/s]
    duration: Scalar
    scale: Scalar

    @property
    def stages(self) -> int:
        return len(self.problem.kinematics)

    def angle(self, state: Array) -> Scalar:
        return state[0] * self.scale * self.duration

    def limits(self, share: Scalar, angle: Scalar, carriers: Carriers) -> Float[Array, "2"]:
        return onset_torques(self.problem, share * self.duration, angle, carriers)

    def carriers(self, state: Array, label) -> Carriers:
        """Motion of the carriers; those that coast while the screw is held never reverse."""
        values, coasts = state[2:], label["coasts"]
        speeds = values * self.scale
        sign, least = label["sign"], _SLOWEST * self.scale
        onward = sign * jnp.maximum(sign * speeds, least)
        speeds = jnp.where(label["mode"] == STICKING, onward, speeds)
        none = jnp.zeros_like(values)
        return Carriers(
            coasts,
            jnp.where(coasts, none, values),
            jnp.where(coasts, speeds, none),
            label.get("senses"),
        )

    def begin(self, share: Scalar, persistent: Array):
        """Label and first state of a phase, from angle and speeds."""
        problem, scale, time = self.problem, self.scale, share * self.duration
        angle, speed = self.angle(persistent), persistent[1] * scale
        # At the start of the scene, carriers keep their ratio to a screw that turns.
        first = jnp.isinf(persistent[2:])
        turning = jnp.where(first, 0.0, persistent[2:]) * scale
        coasts = jax.lax.stop_gradient(
            jnp.abs(turning) > _MIDDLE * jnp.abs(speed) + _AT_REST * scale
        )
        none = jnp.zeros_like(turning)
        carriers = Carriers(coasts, none, turning)
        limits = self.limits(share, angle, carriers)
        mode = next_mode(problem.scenario, time, speed, limits)
        # Slightly later, a torque that jumps now has jumped.
        soon = time + jnp.where(speed == 0, 4 * EVENT * self.duration, 0.0)
        sense = jnp.where(mode == STICKING, FORWARD, mode)
        onset, converged = leaving(problem, soon, angle, speed, sense, carriers)
        moves = speed != 0
        ratios = turning / jnp.where(moves, speed, 1.0)
        in_step = jnp.where(moves & ~first, slip_geometry(problem).tangent(ratios), onset)
        # There is no such ratio if the screw is braked harder than friction can brake the carriers,
        # or leaves rest while its load passes through zero, without friction: carriers then begin
        # in the ratio of free rolling, and from rest settle immediately.
        in_step = jnp.where((mode == STICKING) | ((first | ~moves) & ~converged), none, in_step)
        values = jnp.where(coasts, persistent[2:], in_step)
        label = {"mode": mode, "coasts": coasts, "sign": jnp.sign(turning)}
        if any(resists_turning(problem)):
            over = turning_over(problem, slip_geometry(problem).ratio(in_step))
            # Carriers that begin to turn do so with the screw.
            label["senses"] = jax.tree.map(
                lambda speed: jnp.where((speed < 0) & moves & ~first, -1.0, 1.0), over
            )
        return label, jnp.concatenate([persistent[:2], values])

    def rate(self, share: Scalar, state: Array, label) -> Array:
        problem, scale, end = self.problem, self.scale, self.duration
        mode, carriers = label["mode"], self.carriers(state, label)
        turns = mode != STICKING
        speed = jnp.where(turns, state[1] * scale, 0.0)
        now = driven(problem, share * end, self.angle(state), speed, mode, carriers)
        geometry = slip_geometry(problem)
        ratio = geometry.ratio(carriers.tangent)
        slowest = mode * jnp.maximum(jnp.abs(state[1]), _SLOWEST) * scale
        slowest = jnp.where(turns, slowest, 1.0)
        settling = (ratio * now.acceleration - now.carriers) / slowest
        settling = settling * (geometry.drive / geometry.across) * end
        settling = jnp.where(turns, settling, 0.0)
        values = jnp.where(label["coasts"], now.carriers * end / scale, settling)
        screw = jnp.stack([speed / scale, now.acceleration * end / scale])
        return jnp.concatenate([screw, values])

    def margin(self, share: Scalar, state: Array, label) -> Scalar:
        problem, mode, coasts = self.problem, label["mode"], label["coasts"]
        carriers = self.carriers(state, label)
        earlier = before(share)
        limits = self.limits(earlier, self.angle(state), carriers)
        applied = problem.scenario.torque_at(earlier * self.duration)
        hold = holding_margin(applied, limits) / problem.torque_scale
        onward = jnp.where(coasts, label["sign"] * state[2:] + _PAST, jnp.inf)
        ratio = slip_geometry(problem).ratio(carriers.tangent)
        faster = jnp.abs(state[2:]) - _BACK * jnp.abs(state[1])
        in_step = _COASTS - jnp.abs(ratio)
        if carriers.senses is not None:
            senses, over = carriers.senses, turning_over(problem, ratio)
            # Rollers whose carrier turns with the screw are not turned back over the nut.
            nut_margin = jnp.where(senses.nut < 0, _TURNED - over.nut, jnp.inf)
            in_step = jnp.minimum(
                in_step, jnp.minimum(nut_margin, senses.screw * over.screw + _TURNED)
            )
        carrier_margins = jnp.where(coasts, faster, in_step)
        turning = jnp.minimum(mode * state[1] + _PAST, min_few(carrier_margins))
        return jnp.where(mode == STICKING, jnp.minimum(hold, min_few(onward)), turning)

    def turning(self, state: Array, label) -> Array:
        """Carrier speeds over the scale."""
        ratio = slip_geometry(self.problem).ratio(state[2:])
        return jnp.where(label["coasts"], state[2:], ratio * state[1])

    def end(self, state: Array, label, ended: Bool[Array, ""]) -> Array:
        """Angle and speeds; speeds that an event has brought to zero are exactly zero."""
        turning, coasts = self.turning(state, label), label["coasts"]
        stops = ended & (jnp.abs(state[1]) < _AT_REST)
        speed = jnp.where(stops | (label["mode"] == STICKING), 0.0, state[1])
        rests = (speed == 0) & (~coasts | (jnp.abs(turning) < _AT_REST))
        turning = jnp.where(rests, 0.0, turning)
        return jnp.concatenate([state[:1], speed[None], turning])


def follow_carriers(
    problem: TorqueProblem, times: Float[Array, " times"], settings: Settings
) -> Motions:
    """Integrate screw and carriers through all phases.

    Carriers start in the ratio in which they settle if the screw moves. Steps are no longer than
    the time between two samples; while the screw is held, no longer than a quarter of it.

    **Arguments:**

    - `problem`, `times`: the scene and its samples.
    - `settings`: method, tolerances and mode of differentiation.

    **Raises:** `MissingDataError` if a stage has no thread friction.
    """
    _check_friction(problem)
    scenario, dtype, end = problem.scenario, times.dtype, times[-1]
    # Speed that the torque scale reaches in the scene.
    scale = jax.lax.stop_gradient(problem.torque_scale * end / problem.total_inertia)
    law = _Law(problem, end, scale)
    interval = times[1] / end
    solution = follow_phases(
        PhaseLaws(
            law.begin,
            law.rate,
            law.margin,
            law.end,
            lambda label: jnp.where(
                label["mode"] == STICKING, interval / STEPS_PER_SAMPLE, interval
            ),
        ),
        _start(law, dtype),
        times,
        scenario.break_times,
        scenario.most_phases,
        settings.method.make_solver(settings.rtol, settings.atol, compact=True),
        settings,
    )
    angle, mode = jax.vmap(law.angle)(solution.states), solution.labels["mode"]
    carriers = jax.vmap(law.carriers)(solution.states, solution.labels)
    turning = jax.vmap(law.turning)(solution.states, solution.labels) * scale
    rests = (mode == STICKING) & ~jnp.any(carriers.coasts, axis=1)
    sticks = rests[:-1] & rests[1:] & (angle[:-1] == angle[1:])
    speed = jnp.where(mode == STICKING, 0.0, solution.states[:, 1] * scale)
    turning = jnp.where(((mode == STICKING)[:, None]) & ~carriers.coasts, 0.0, turning)
    return Motions(
        angle,
        speed,
        mode,
        carriers,
        turning,
        jnp.append(sticks, jnp.asarray(False)),
        solution._replace(phases=joined(solution.phases)),
    )


def joined(phases: Phase) -> Phase:
    """Phases of the screw: phases that differ only in the motion of carriers are merged."""
    mode = phases.mode
    begins = jnp.concatenate([jnp.ones_like(mode[:1], bool), mode[1:] != mode[:-1]])
    last = len(mode) - 1
    first = jnp.nonzero(begins, size=len(mode), fill_value=last + 1)[0]
    used = first <= last
    ends = jnp.concatenate([first[1:], jnp.asarray([last + 1])]) - 1
    first, ends = jnp.minimum(first, last), jnp.minimum(ends, last)
    finish = phases.end[-1]
    return Phase(
        start=jnp.where(used, phases.start[first], finish),
        end=jnp.where(used, phases.end[ends], finish),
        mode=jnp.where(used, mode[first], 0.0),
    )


def _start(law: _Law, dtype) -> Array:
    """Angle and speeds at the start; those of carriers are set when the first phase begins."""
    speed = law.problem.scenario.initial_speed.astype(dtype) / law.scale
    unknown = jnp.full(law.stages, jnp.inf, dtype)
    return jnp.concatenate([jnp.zeros_like(speed)[None], speed[None], unknown])
