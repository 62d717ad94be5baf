"""Time histories of a transient."""

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ...geometry import dimensions_possible, rollers_fit
from ...mechanism import Mechanism, Scalar, body_inertia, body_mass
from ...numerics import any_few, over_samples, sum_few
from ...programs import AbstractResult, listed
from .._kinematics import StageKinematics, travel_per_turn
from ..forces import (
    Scenario,
    StageState,
    axial_inertia,
    carrier_inertia,
    losses,
    roller_support_forces,
    stored_power,
)
from ..friction import turned
from ..steady import jamming_margin, steady_meaning

_MEANINGS = (
    "successful",
    "out of steps: the scene is stiffer or longer than max_steps allows; raise max_steps, shorten "
    "the duration, or loosen rtol and atol",
    "step size too small: the slip or the normal force jumps; check the thread for self-locking",
    "an implicit step could not be solved: check for a contact that is pulled (negative load), "
    "self-locking, or a meshing that did not converge",
    "no balance: friction cannot drive the carriers, or a contact would have to pull; check the "
    "thread for self-locking, and the sign of the load",
    "out of phases: the mechanism sticks and slips more often than most_phases allows; raise it, "
    "or shorten the duration",
    "the closed form does not hold: a thread locks, or the torque of a screw or the load of a nut "
    "changes its sign; choose the method rosenbrock",
    "jammed: friction in the threads takes all that the normal force lifts, and no torque moves "
    "the load; lower the friction or raise the contact angle (quantity jamming_margin)",
    "missed a phase: while the mechanism stuck, the torque passed a limit and came back between "
    "two steps; raise samples, which shortens them",
    steady_meaning("overlapping_rollers"),
    steady_meaning("impossible_dimension"),
    "not finite: a number of the mechanism or the scenario is NaN or infinite, or so large that a "
    "result is; correct it",
    "impossible duration: a simulation needs a duration of more than 0 s that is finite",
)
_JAMMED = 7
#: Codes from here on are of the mechanism and of the scenario; how the integration went is another
#: matter.
CANNOT_BE_BUILT, MEANS_NOTHING = 9, 11
_OVERLAPPING, _IMPOSSIBLE, _NOT_FINITE, _NO_DURATION = 9, 10, 11, 12


class SolverReport(AbstractResult):
    """How the integration went."""

    steps: Int[Array, ""]
    rejected: Int[Array, ""]
    #: 0 when successful; see `result`.
    code: Int[Array, ""]
    name: str = eqx.field(static=True)
    #: Largest error of the carrier ratio by what the method neglects, after settling; under a
    #: prescribed torque of the screw speed over its largest. `None` where nothing is neglected.
    error_estimate: Scalar | None = None
    #: Longest time constant in which carriers settle, where the method leaves that out [s].
    time_constant: Scalar | None = None

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch that this report is of; empty for a single design."""
        return self.code.shape

    @property
    @listed
    def result(self) -> str:
        """What `code` means, and what to do about it."""
        return _MEANINGS[int(self.code)]


def prescribed(scenario: Scenario, times: Float[Array, " times"]):
    """Screw speed, acceleration (or `None`) and load of a scenario at all times."""
    load = jax.vmap(scenario.load_at)(times) if callable(scenario.load) else None
    if load is None:
        load = jnp.broadcast_to(scenario.load_at(times[0]), times.shape)
    if not callable(scenario.speed):
        return jnp.broadcast_to(scenario.speed_at(times[0]), times.shape), None, load
    speed, acceleration = jax.vmap(scenario.motion_at)(times)
    return speed, acceleration, load


class CarrierHistory(eqx.Module):
    """What a method of `simulate` finds, at one time or at all of them; all else follows."""

    #: Ω [rad/s] and Ω̇ [rad/s²]; `None` for a constant speed, which leaves masses untraced.
    screw_speed: Float[Array, "*times"]
    screw_acceleration: Float[Array, "*times"] | None
    #: Load on the last nut [N].
    load: Float[Array, "*times"]
    carrier_speed: Float[Array, "*times stages"]
    states: tuple[StageState, ...]
    acceleration: Float[Array, "*times stages"]


class Phase(eqx.Module):
    """Stretches of turning or sticking; those past the last one have no length."""

    #: [s]
    start: Float[Array, " phases"]
    end: Float[Array, " phases"]
    #: +1 forward, −1 backward, 0 sticking.
    mode: Float[Array, " phases"]


class Transient(AbstractResult):
    """Time histories; stage × time where a stage is concerned."""

    time: Float[Array, " times"]
    screw_speed: Float[Array, " times"]
    carrier_speed: Float[Array, "stages times"]
    #: ω/Ω; 0 while the screw stands still.
    carrier_ratio: Float[Array, "stages times"]
    efficiency: Float[Array, " times"]
    drive_torque: Float[Array, " times"]
    contact_force: Float[Array, "stages times"]
    screw_roller_axial_force: Float[Array, "stages times"]
    ring_gear_force: Float[Array, "stages times"]
    carrier_force: Float[Array, "stages times"]
    spline_friction: Float[Array, "stages times"]
    stage_torque: Float[Array, "stages times"]
    #: Power of each modelled loss [W].
    losses: dict[str, Float[Array, " times"]]
    #: |drive − load − losses − rates of kinetic and bristle energy| over the largest power.
    power_balance_residual: Float[Array, " times"]
    #: Moment balance of the rollers about their axes, relative: Newton against Lagrange.
    newton_residual: Float[Array, "stages times"]
    #: Acceleration of the carriers ω̇ [rad/s²].
    carrier_acceleration: Float[Array, "stages times"]
    #: Load on the last nut [N].
    load: Float[Array, " times"]
    #: Unit vector of the slip of the screw over the roller, in the carrier's frame: radial,
    #: tangential, axial; where nothing slips that of the motion about to begin, if there is one.
    slip_direction: Float[Array, "stages times 3"]
    solver: SolverReport
    #: Ω̇ [rad/s²]; `None` for a constant speed.
    screw_acceleration: Float[Array, " times"] | None = None
    #: Power that the load takes [W].
    load_power: Float[Array, " times"] | None = None
    #: Rate at which bristles between the threads store energy [W]; `None` without such a law.
    bristle_power: Float[Array, " times"] | None = None
    #: Their deflection, in the carrier's frame [m]; 0 in stages without them.
    bristle_deflection: Float[Array, "stages times 3"] | None = None
    #: Travel of the last nut from where it started [m], and whether the mechanism sticks; only
    #: where the torque is prescribed.
    position: Float[Array, " times"] | None = None
    sticking: Bool[Array, " times"] | None = None
    #: Stretches of turning and sticking, where the torque is prescribed.
    phases: Phase | None = None

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch that these histories are of; empty for a single design."""
        return self.time.shape[:-1]


def _kinetic_power(mechanism: Mechanism, carrier_speed, acceleration, speed, screw_acceleration):
    """Rate of the kinetic energy of all bodies [W]."""
    stages = mechanism.stages
    power = sum(
        carrier_inertia(stage) * carrier_speed[index] * acceleration[index]
        for index, stage in enumerate(stages)
    )
    if screw_acceleration is None:
        return power
    for index, stage in enumerate(stages):
        moved = axial_inertia(stage) * travel_per_turn(stages, index + 1) ** 2
        moved = moved + body_inertia(stage, "screw")
        if index > 0:
            moved = moved + body_mass(stage, "screw") * travel_per_turn(stages, index) ** 2
        power = power + moved * speed * screw_acceleration
    return power


def _deflections(instant: tuple[StageState, ...]) -> Float[Array, "stages 3"] | None:
    if all(state.motion.deflection is None for state in instant):
        return None
    return jnp.stack(
        [
            jnp.zeros_like(state.motion.slip)
            if state.motion.deflection is None
            else turned(state.motion.deflection, state.flank)
            for state in instant
        ]
    )


def _relative(residual: Scalar, scale: Scalar) -> Scalar:
    """Without load there is nothing to compare with."""
    return jnp.abs(residual) / jnp.where(scale > 0, scale, 1.0)


def _finite(row: dict[str, Any]) -> Bool[Array, ""]:
    """Whether everything at one time is finite."""
    # 0 times what is NaN or infinite is NaN.
    return jnp.isfinite(sum(sum_few(0.0 * jnp.ravel(value)) for value in jax.tree.leaves(row)))


def code_of_finite(code: Int[Array, ""], finite: Bool[Array, " times"]) -> Int[Array, ""]:
    """A result code, and that of numbers that are not finite where it explains them.

    Where the first sample is not finite no method could have found more; later ones may also be
    lost by a method that gave up, which has a code of its own.
    """
    return jnp.where(~finite[0] | ((code == 0) & ~finite.all()), _NOT_FINITE, code)


def rows_of(
    mechanism: Mechanism, kinematics: tuple[StageKinematics, ...]
) -> Callable[[CarrierHistory], dict[str, Any]]:
    """A function that turns the state at one time into what a `Transient` has of that time.

    Apart from `transient_of`, so that states, which are many numbers, need not be kept for all
    times.
    """
    travel = travel_per_turn(mechanism.stages, len(mechanism.stages))

    def at(one: CarrierHistory) -> dict[str, Any]:
        speed, screw_acceleration, load = one.screw_speed, one.screw_acceleration, one.load
        carriers, instant, acceleration = one.carrier_speed, one.states, one.acceleration
        torque = instant[0].screw.drive_torque
        supports = [
            roller_support_forces(stage, geometry, state, acceleration[index])
            for index, (stage, geometry, state) in enumerate(
                zip(mechanism.stages, kinematics, instant, strict=True)
            )
        ]
        lost = losses(mechanism, kinematics, instant, speed)
        kinetic = _kinetic_power(mechanism, carriers, acceleration, speed, screw_acceleration)
        drive_power, load_power = torque * speed, load * travel * speed
        gross = functools.reduce(jnp.maximum, map(jnp.abs, (drive_power, load_power, kinetic)))
        imbalance = drive_power - load_power - sum(lost.values()) - kinetic
        stored = stored_power(mechanism, instant)
        if stored is not None:
            imbalance = imbalance - stored
        driving = speed * load >= 0
        useful = jnp.where(driving, load * travel, torque)
        spent = jnp.where(driving, torque, load * travel)
        moving = speed != 0
        forces = jnp.stack([s.forces.contact_force for s in instant])
        row = {
            "screw_speed": speed,
            "screw_acceleration": screw_acceleration,
            "load": load,
            "carrier_speed": carriers,
            "carrier_acceleration": acceleration,
            "carrier_ratio": jnp.where(moving, carriers / jnp.where(moving, speed, 1.0), 0.0),
            "efficiency": jnp.where(spent != 0, useful / jnp.where(spent != 0, spent, 1.0), 0.0),
            "drive_torque": torque,
            "contact_force": forces,
            "screw_roller_axial_force": jnp.stack(
                [
                    -s.forces.contact_force * k.meshing.screw.normal[2]
                    for s, k in zip(instant, kinematics, strict=True)
                ]
            ),
            "ring_gear_force": jnp.stack([s.ring_gear_force for s in supports]),
            "carrier_force": jnp.stack([s.carrier_force for s in supports]),
            "spline_friction": jnp.stack(
                [
                    jnp.zeros_like(torque)
                    if s.screw.spline_friction is None
                    else s.screw.spline_friction
                    for s in instant
                ]
            ),
            "stage_torque": jnp.stack([s.screw.drive_torque for s in instant]),
            "losses": lost,
            "power_balance_residual": jnp.abs(imbalance) / jnp.where(gross > 0, gross, 1.0),
            "newton_residual": jnp.stack(
                [
                    _relative(
                        support.moment_residual,
                        state.forces.contact_force * geometry.thread.roller_radius,
                    )
                    for support, state, geometry in zip(supports, instant, kinematics, strict=True)
                ]
            ),
            "slip_direction": jnp.stack([turned(s.motion.direction, s.flank) for s in instant]),
            "bristle_deflection": _deflections(instant),
            "bristle_power": stored,
            "load_power": load_power,
        }
        # Here, where the row is at hand: whoever keeps one history need not hold all of them.
        return {**row, "finite": _finite(row), "pulled": any_few(forces < 0)}

    return at


def histories(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    times: Float[Array, " times"],
    history: CarrierHistory,
    report: SolverReport,
) -> Transient:
    """Turn states at the sample times into the histories that users ask for."""
    rows = over_samples(rows_of(mechanism, kinematics), history)
    return transient_of(mechanism, kinematics, times, rows, report)


def transient_of(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    times: Float[Array, " times"],
    found: dict[str, Any],
    report: SolverReport,
) -> Transient:
    """The histories that users ask for, from what `rows_of` gives, with times first."""
    found = dict(found)
    finite = found.pop("finite") & jnp.isfinite(times)
    pulled = jnp.any(found.pop("pulled"))
    deflections: Any = found.pop("bristle_deflection")
    per_stage = (
        "carrier_speed",
        "carrier_acceleration",
        "carrier_ratio",
        "contact_force",
        "screw_roller_axial_force",
        "ring_gear_force",
        "carrier_force",
        "spline_friction",
        "stage_torque",
        "newton_residual",
        "slip_direction",
    )
    rows: dict[str, Any] = {
        name: jnp.moveaxis(row, 1, 0) if name in per_stage else row for name, row in found.items()
    }
    # The steps may have run out, or the rollers be at rest, before a sample shows it.
    fastest, most = (jnp.max(jnp.abs(found[name])) for name in ("screw_speed", "load"))
    margin = jamming_margin(mechanism, kinematics, fastest, most)
    jammed = pulled | ((report.code != 0) & (margin <= 0))
    code = jnp.where(jammed, _JAMMED, report.code)
    code = code_of_finite(code, finite)
    fit = jnp.stack([rollers_fit(stage) for stage in mechanism.stages]).all()
    possible = jnp.stack([dimensions_possible(stage) for stage in mechanism.stages]).all()
    code = jnp.where((code == 0) & ~fit, _OVERLAPPING, code)
    code = jnp.where(possible, code, _IMPOSSIBLE)
    code = jnp.where((times[-1] > 0) & jnp.isfinite(times[-1]), code, _NO_DURATION)
    return Transient(
        time=times,
        bristle_deflection=None if deflections is None else jnp.moveaxis(deflections, 1, 0),
        solver=dataclasses.replace(report, code=code),
        **rows,
    )
