"""Prescribed torque with carriers as states: screw and carriers stick and slip, each by itself.

Modes are those of the screw: it turns forward, turns backward, or is held. In either of the first
two each carrier is in step with it, or coasts (`_driven_carriers`); a held screw's carriers rest,
or coast until friction has stopped them. An event ends a phase where the screw's speed passes
through zero, where the torque passes the limit that a held screw can take, where a coasting carrier
stops, or where a carrier has to be described the other way. A screw that reverses beneath a
carrier turns against it for a while: where the rollers begin to turn the other way, what resists
that jumps, which is an event as well.

In step, the tangent of the slip settles at a rate inversely proportional to the speed of the screw,
without bound as it stops: it ends in the ratio in which screw and carriers come to rest together.
Below a speed of `_SLOWEST` the rate is kept where it is. What that changes is of the second order
in that speed. Past the end of the phase the rate falls again as it grew before, so that a long step
across standstill meets no rate much larger than at its beginning. With the largest rate kept there,
every stage of such a step multiplied what carriers were out of balance: values in exact balance
passed the error control, and their derivatives, with errors by rounding only, were wrong.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..._errors import MissingDataError
from ...mechanism import Scalar
from ...numerics import min_few
from ..histories import Phase, Settings
from ..solvers import solver_of
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
from ._torque_drive import STEPS_PER_SAMPLE, held, next_mode

#: Carriers that turn faster than this many times the screw coast. They are in step again below
#: `_BACK`, and in between at the start of a phase by `_MIDDLE`.
_BACK, _MIDDLE, _AWAY = 4.0, 5.0, 6.0
#: Speeds over the speed scale: where a speed counts as past zero, where a carrier counts as at
#: rest once the screw is, and below which settling becomes no faster.
_PAST, _AT_REST, _SLOWEST = 1e-12, 1e-9, 1e-7
#: Turning of rollers over the screw's, past zero, at which what resists it changes its sign: more
#: than the turning changes in the time to which events are located.
_TURNED = 1e-6


class Motions(eqx.Module):
    """Motion of screw and carriers at the sample times, and the phases they went through."""

    angle: Float[Array, " times"]
    speed: Float[Array, " times"]
    mode: Float[Array, " times"]
    carriers: Carriers
    #: ω [rad/s].
    carrier_speed: Float[Array, "times stages"]
    #: Whether all is at rest from a sample to the next.
    sticks: Bool[Array, " times"]
    found: Phases


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
        """Motion of the carriers; those that coast beside a held screw never turn back."""
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
            label.get("ways"),
        )

    def begin(self, share: Scalar, kept: Array):
        """Label and first state of a phase, from angle and speeds."""
        problem, scale, time = self.problem, self.scale, share * self.duration
        angle, speed = self.angle(kept), kept[1] * scale
        # At the start of all, carriers keep their ratio to a screw that turns.
        first = jnp.isinf(kept[2:])
        turning = jnp.where(first, 0.0, kept[2:]) * scale
        coasts = jax.lax.stop_gradient(
            jnp.abs(turning) > _MIDDLE * jnp.abs(speed) + _AT_REST * scale
        )
        none = jnp.zeros_like(turning)
        carriers = Carriers(coasts, none, turning)
        limits = self.limits(share, angle, carriers)
        mode = next_mode(problem.scenario, time, speed, limits)
        # A torque that jumps has done so in a moment.
        soon = time + jnp.where(speed == 0, 4 * EVENT * self.duration, 0.0)
        sense = jnp.where(mode == STICKING, FORWARD, mode)
        onset, found = leaving(problem, soon, angle, speed, sense, carriers)
        moves = speed != 0
        ratios = turning / jnp.where(moves, speed, 1.0)
        in_step = jnp.where(moves & ~first, slip_geometry(problem).tangent(ratios), onset)
        # A screw that is braked harder than friction can brake the carriers has no such ratio, nor
        # has one that leaves rest while its load passes through zero, without friction: they then
        # begin in that of rolling, and from rest settle in no time.
        in_step = jnp.where((mode == STICKING) | ((first | ~moves) & ~found), none, in_step)
        values = jnp.where(coasts, kept[2:], in_step)
        label = {"mode": mode, "coasts": coasts, "sign": jnp.sign(turning)}
        if any(resists_turning(problem)):
            over = turning_over(problem, slip_geometry(problem).ratio(in_step))
            # Carriers that begin to turn do so with the screw.
            label["ways"] = jax.tree.map(
                lambda speed: jnp.where((speed < 0) & moves & ~first, -1.0, 1.0), over
            )
        return label, jnp.concatenate([kept[:2], values])

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
        hold = held(applied, limits) / problem.torque_scale
        onward = jnp.where(coasts, label["sign"] * state[2:] + _PAST, jnp.inf)
        ratio = slip_geometry(problem).ratio(carriers.tangent)
        faster = jnp.abs(state[2:]) - _BACK * jnp.abs(state[1])
        in_step = _AWAY - jnp.abs(ratio)
        if carriers.ways is not None:
            ways, over = carriers.ways, turning_over(problem, ratio)
            # Nothing turns rollers back over the nut whose carrier turns with the screw.
            left = jnp.where(ways.nut < 0, _TURNED - over.nut, jnp.inf)
            in_step = jnp.minimum(in_step, jnp.minimum(left, ways.screw * over.screw + _TURNED))
        alike = jnp.where(coasts, faster, in_step)
        turning = jnp.minimum(mode * state[1] + _PAST, min_few(alike))
        return jnp.where(mode == STICKING, jnp.minimum(hold, min_few(onward)), turning)

    def turning(self, state: Array, label) -> Array:
        """Carrier speeds over the scale."""
        ratio = slip_geometry(self.problem).ratio(state[2:])
        return jnp.where(label["coasts"], state[2:], ratio * state[1])

    def end(self, state: Array, label, ended: Bool[Array, ""]) -> Array:
        """Angle and speeds; those that an event has brought to zero are exactly that."""
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

    They start in the ratio that a moving screw's carriers settle in. Steps are no longer than the
    time between two samples, while the screw is held a quarter of that.

    **Arguments:**

    - `problem`, `times`: the scene and its samples.
    - `settings`: solver, tolerances and kind of derivative; the method `"auto"` is RODASP.

    **Raises:** `MissingDataError` if a stage has no thread friction.
    """
    _check_friction(problem)
    scenario, dtype, end = problem.scenario, times.dtype, times[-1]
    # Speed that such a torque reaches in the scene.
    scale = jax.lax.stop_gradient(problem.torque_scale * end / problem.total_inertia)
    law = _Law(problem, end, scale)
    between = times[1] / end
    method = "rosenbrock" if settings.method == "auto" else settings.method
    found = follow_phases(
        PhaseLaws(
            law.begin,
            law.rate,
            law.margin,
            law.end,
            lambda label: jnp.where(label["mode"] == STICKING, between / STEPS_PER_SAMPLE, between),
        ),
        _start(law, dtype),
        times,
        scenario.break_times,
        scenario.most_phases,
        solver_of(method, settings.rtol, settings.atol, False, compact=True, own=settings.own),
        settings,
    )
    angle, mode = jax.vmap(law.angle)(found.states), found.labels["mode"]
    carriers = jax.vmap(law.carriers)(found.states, found.labels)
    turning = jax.vmap(law.turning)(found.states, found.labels) * scale
    rests = (mode == STICKING) & ~jnp.any(carriers.coasts, axis=1)
    sticks = rests[:-1] & rests[1:] & (angle[:-1] == angle[1:])
    speed = jnp.where(mode == STICKING, 0.0, found.states[:, 1] * scale)
    turning = jnp.where(((mode == STICKING)[:, None]) & ~carriers.coasts, 0.0, turning)
    return Motions(
        angle,
        speed,
        mode,
        carriers,
        turning,
        jnp.append(sticks, jnp.asarray(False)),
        found._replace(phases=joined(found.phases)),
    )


def joined(phases: Phase) -> Phase:
    """Phases of the screw: those that differ only in what its carriers do are one."""
    mode = phases.mode
    begins = jnp.concatenate([jnp.ones_like(mode[:1], bool), mode[1:] != mode[:-1]])
    last = len(mode) - 1
    first = jnp.nonzero(begins, size=len(mode), fill_value=last + 1)[0]
    there = first <= last
    ends = jnp.concatenate([first[1:], jnp.asarray([last + 1])]) - 1
    first, ends = jnp.minimum(first, last), jnp.minimum(ends, last)
    finish = phases.end[-1]
    return Phase(
        start=jnp.where(there, phases.start[first], finish),
        end=jnp.where(there, phases.end[ends], finish),
        mode=jnp.where(there, mode[first], 0.0),
    )


def _start(law: _Law, dtype) -> Array:
    """Angle and speeds at the start; carriers' are found when the first phase begins."""
    speed = law.problem.scenario.initial_speed.astype(dtype) / law.scale
    unknown = jnp.full(law.stages, jnp.inf, dtype)
    return jnp.concatenate([jnp.zeros_like(speed)[None], speed[None], unknown])
