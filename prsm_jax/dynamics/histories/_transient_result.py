"""Time histories of a transient."""

import dataclasses
from collections.abc import Callable
from typing import Annotated, Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ...fields import In, Scalar
from ...geometry import dimensions_possible, rollers_fit
from ...mechanism import Mechanism, body_inertia, body_mass
from ...numerics import any_few, over_samples, sum_few
from ...programs import listed
from ...results import DesignResult, lines_of, outcome
from ...text import Line
from .._kinematics import StageKinematics, travel_per_radian, travel_share
from ..forces import (
    Scenario,
    StageState,
    axial_inertia,
    carrier_inertia,
    forces_by_stage,
    losses,
    roller_support_forces,
    stored_power,
)
from ..friction import turned
from ..steady import jams, steady_meaning
from ._power_entries import power_entries, relative

_MEANINGS = (
    "successful",
    "out of steps: the simulation needs more than max_steps steps; raise max_steps, shorten "
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
    steady_meaning("jammed"),
    "missed a phase: while the mechanism stuck, the torque passed a limit and came back between "
    "two steps; raise samples to shorten the steps",
    steady_meaning("overlapping_rollers"),
    steady_meaning("impossible_dimension"),
    "not finite: a number of the mechanism or the scenario is NaN or infinite, or so large that a "
    "result is not finite; correct it",
    "impossible duration: a simulation needs a finite duration of more than 0 s",
)

_JAMMED = 7
#: Codes from here on concern the mechanism and the scenario, not the integration.
CANNOT_BE_BUILT, MEANS_NOTHING = 9, 11
_OVERLAPPING, _IMPOSSIBLE, _NOT_FINITE, _NO_DURATION = 9, 10, 11, 12


class SolverReport(DesignResult):
    """How the integration went."""

    #: Steps of the integrator, and those of them that were repeated with a smaller step.
    steps: Annotated[Int[Array, ""], In("1")]
    rejected: Annotated[Int[Array, ""], In("1")]
    #: 0 when successful; see `result`.
    code: Int[Array, ""]
    name: str = eqx.field(static=True)
    #: Upper estimate of the error by terms that the method neglects, after settling, over the
    #: highest screw speed: of the carrier speeds; under a prescribed torque, of the screw speed.
    #: `None` if no terms are neglected.
    error_estimate: Annotated[Scalar | None, In("1")] = None
    #: Longest time constant in which carriers settle, where the method neglects settling [s].
    time_constant: Annotated[Scalar | None, In("s")] = None
    #: The estimate of the carrier speeds at each sample time, whose largest is `error_estimate`.
    #: Just before and after a reversal of the load a sample may err by more than its own estimate.
    #: `None` under a prescribed torque, and if no terms are neglected.
    error_over_time: Annotated[Float[Array, " times"] | None, In("1")] = None

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch that this report is of; empty for a single design."""
        return self.code.shape

    def lines(self) -> list[Line]:
        """What `print` shows."""
        names = [meaning.partition(":")[0] for meaning in _MEANINGS]
        return [outcome(self.code, names), Line("method", self.name), *lines_of(self)]

    @property
    @listed
    def result(self) -> str:
        """Meaning of `code`, with the remedy."""
        return _MEANINGS[int(self.code)]


def prescribed(
    scenario: Scenario, times: Float[Array, " times"]
) -> tuple[Float[Array, " times"], Float[Array, " times"] | None, Float[Array, " times"]]:
    """Screw speed, acceleration (or `None`) and load of a scenario at all times."""
    load = jax.vmap(scenario.load_at)(times) if callable(scenario.load) else None
    if load is None:
        load = jnp.broadcast_to(scenario.load_at(times[0]), times.shape)
    if not callable(scenario.speed):
        return jnp.broadcast_to(scenario.speed_at(times[0]), times.shape), None, load
    speed, acceleration = jax.vmap(scenario.motion_at)(times)
    return speed, acceleration, load


class CarrierHistory(eqx.Module):
    """Result of a method of `simulate`, at one time or at all; all other results follow from it."""

    #: Ω [rad/s] and Ω̇ [rad/s²]; `None` for a constant speed, where masses are not needed.
    screw_speed: Float[Array, "*times"]
    screw_acceleration: Float[Array, "*times"] | None
    #: Load on the last nut [N].
    load: Float[Array, "*times"]
    carrier_speed: Float[Array, "*times stages"]
    states: tuple[StageState, ...]
    acceleration: Float[Array, "*times stages"]


class Phase(eqx.Module):
    """Phases of turning or sticking; entries past the last phase have no length."""

    #: Start and end of each phase [s].
    start: Float[Array, " phases"]
    end: Float[Array, " phases"]
    #: +1 forward, −1 backward, 0 sticking.
    mode: Float[Array, " phases"]


class Transient(DesignResult):
    """Time histories; stage × time where a stage is concerned."""

    time: Annotated[Float[Array, " times"], In("s")]
    #: Speed of the body that turns: first screw, or nut of an inverted roller screw [rad/s].
    screw_speed: Annotated[Float[Array, " times"], In("rad/s")]
    #: ω [rad/s].
    carrier_speed: Annotated[Float[Array, "stages times"], In("rad/s")]
    #: ω/Ω; 0 while the screw stands still.
    carrier_ratio: Annotated[Float[Array, "stages times"], In("1")]
    #: Ratio of the powers of load and drive [1]; see `prsm_jax.dynamics.known_efficiency`.
    efficiency: Float[Array, " times"]
    #: Torque at the body that turns [N·m].
    drive_torque: Annotated[Float[Array, " times"], In("N·m")]
    #: Normal force of the body that turns on one roller, all its threads together [N].
    contact_force: Annotated[Float[Array, "stages times"], In("N")]
    #: Axial part of it [N].
    screw_roller_axial_force: Annotated[Float[Array, "stages times"], In("N")]
    #: Tooth force of the ring gear, and force of the carrier's pin, at one of the two ends of one
    #: roller [N].
    ring_gear_force: Annotated[Float[Array, "stages times"], In("N")]
    carrier_force: Annotated[Float[Array, "stages times"], In("N")]
    #: Axial friction force of the spline of each screw that moves along the axis [N].
    spline_friction: Annotated[Float[Array, "stages times"], In("N")]
    #: Torque at the screw, or at the nut that turns, of each stage [N·m].
    stage_torque: Float[Array, "stages times"]
    #: Power of each modelled loss [W].
    losses: Annotated[dict[str, Float[Array, " times"]], In("W")]
    #: |drive − load − losses − rates of kinetic and bristle energy| over the largest power.
    power_balance_residual: Annotated[Float[Array, " times"], In("1")]
    #: Moment balance of the rollers about their axes, relative: Newton against Lagrange.
    newton_residual: Float[Array, "stages times"]
    #: Acceleration of the carriers ω̇ [rad/s²].
    carrier_acceleration: Float[Array, "stages times"]
    #: Load on the last nut, or on the screw if the nut turns [N].
    load: Annotated[Float[Array, " times"], In("N")]
    #: Unit vector of the slip of the body that turns over the roller, in the carrier's frame:
    #: radial, tangential, axial; without slip that of impending motion, if any.
    slip_direction: Float[Array, "stages times 3"]
    solver: SolverReport
    #: Ω̇ [rad/s²]; `None` for a constant speed.
    screw_acceleration: Float[Array, " times"] | None = None
    #: Power that the load absorbs [W].
    load_power: Annotated[Float[Array, " times"] | None, In("W")] = None
    #: Rate at which bristles between the threads store energy [W]; `None` without such a law.
    bristle_power: Float[Array, " times"] | None = None
    #: Deflection of the bristles, in the carrier's frame [m]; 0 in stages without bristles.
    bristle_deflection: Float[Array, "stages times 3"] | None = None
    #: Travel of the last nut from its start [m], and whether the mechanism sticks; `None` unless
    #: the torque is prescribed.
    position: Annotated[Float[Array, " times"] | None, In("m")] = None
    sticking: Bool[Array, " times"] | None = None
    #: Phases of turning and sticking, under a prescribed torque.
    phases: Phase | None = None

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch that these histories are of; empty for a single design."""
        return self.time.shape[:-1]

    def lines(self) -> list[Line]:
        """What `print` shows: the smallest and the largest number of each history."""
        samples = Line("samples", self.time.shape[-1])
        # In front, because a solver that gave up explains all that follows.
        solver = [
            dataclasses.replace(one, label=f"solver: {one.label}") for one in self.solver.lines()
        ]
        own = [one for one in lines_of(self) if not one.label.startswith("solver: ")]
        return [*solver[:3], samples, *own]


def _kinetic_power(mechanism: Mechanism, carrier_speed, acceleration, speed, screw_acceleration):
    """Rate of the kinetic energy of all bodies [W]."""
    stages = mechanism.stages
    power = sum(
        carrier_inertia(stage) * carrier_speed[index] * acceleration[index]
        for index, stage in enumerate(stages)
    )
    for index, stage in enumerate(stages):
        if not stage.thread.family.lead_is_fixed:
            # The nut travels by the lead per turn of screw over carrier.
            over = -acceleration[index]
            over = over if screw_acceleration is None else screw_acceleration + over
            mass = axial_inertia(stage) * travel_per_radian(stages, index + 1) ** 2
            power = power + mass * (speed - carrier_speed[index]) * over
    if screw_acceleration is None:
        return power
    for index, stage in enumerate(stages):
        moved = body_inertia(stage, stage.thread.family.turning)
        if stage.thread.family.lead_is_fixed:
            moved = moved + axial_inertia(stage) * travel_per_radian(stages, index + 1) ** 2
        if index > 0:
            moved = moved + body_mass(stage, "screw") * travel_per_radian(stages, index) ** 2
        power = power + moved * speed * screw_acceleration
    return power


def _deflections(instant: tuple[StageState, ...]) -> Float[Array, "stages 3"] | None:
    if all(state.motion.deflection is None for state in instant):
        return None
    return jnp.stack(
        [
            jnp.zeros_like(state.motion.slip)
            if state.motion.deflection is None
            else turned(state.motion.deflection, state.flank_sign)
            for state in instant
        ]
    )


def finite_row(row: dict[str, Any]) -> Bool[Array, ""]:
    """Whether everything at one time is finite."""
    # 0 times NaN or infinity is NaN.
    return jnp.isfinite(sum(sum_few(0.0 * jnp.ravel(value)) for value in jax.tree.leaves(row)))


def code_of_finite(code: Int[Array, ""], finite: Bool[Array, " times"]) -> Int[Array, ""]:
    """The result code, replaced by that of non-finite numbers where this explains the failure.

    If the first sample is not finite, no method could succeed. Later samples may also be non-finite
    because a method gave up, which has its own code.
    """
    return jnp.where(~finite[0] | ((code == 0) & ~finite.all()), _NOT_FINITE, code)


def judged_by_input(run: Transient, scenario: Scenario) -> Transient:
    """The transient with the code of non-finite numbers if a function of the scenario gives one.

    Under a prescribed speed neither speed nor load depends on what a method makes of them.
    """
    if not (callable(scenario.speed) or callable(scenario.load)):
        return run
    given = jnp.isfinite(run.screw_speed + run.load).all()
    code = run.solver.code
    code = jnp.where(given | (code >= _OVERLAPPING), code, _NOT_FINITE)
    return eqx.tree_at(lambda run: run.solver.code, run, code)


def rows_of(
    mechanism: Mechanism, kinematics: tuple[StageKinematics, ...]
) -> Callable[[CarrierHistory], dict[str, Any]]:
    """A function that converts the state at one time into the entries of a `Transient`.

    Separate from `transient_of`, so that states, which are many numbers, need not be stored for all
    times.
    """
    lead = travel_per_radian(mechanism.stages, len(mechanism.stages))

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
        loss_powers = losses(mechanism, kinematics, instant, speed)
        kinetic = _kinetic_power(mechanism, carriers, acceleration, speed, screw_acceleration)
        moving = speed != 0
        ratio = jnp.where(moving, carriers / jnp.where(moving, speed, 1.0), 0.0)
        # Travel of the last nut per radian of the screw.
        share = travel_share(mechanism.stages[-1].thread, ratio[-1])
        travel = lead if share is None else lead * share
        load_power = load * travel * speed
        if share is not None:
            load_power = load * lead * (speed - carriers[-1])
        stored = stored_power(mechanism, instant)
        row = {
            **power_entries(torque, load * travel, speed, load_power, loss_powers, kinetic, stored),
            **forces_by_stage(kinematics, instant, supports),
            "screw_speed": speed,
            "screw_acceleration": screw_acceleration,
            "load": load,
            "carrier_speed": carriers,
            "carrier_acceleration": acceleration,
            "carrier_ratio": ratio,
            "stage_torque": jnp.stack([s.screw.drive_torque for s in instant]),
            "newton_residual": jnp.stack(
                [
                    relative(
                        support.moment_residual,
                        state.forces.contact_force * geometry.thread.roller_radius,
                    )
                    for support, state, geometry in zip(supports, instant, kinematics, strict=True)
                ]
            ),
            "bristle_deflection": _deflections(instant),
            "bristle_power": stored,
        }
        # Evaluated here, for one row: a caller that keeps one history need not store all of them.
        return {**row, "finite": finite_row(row), "pulled": any_few(row["contact_force"] < 0)}

    return at


def histories(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    times: Float[Array, " times"],
    history: CarrierHistory,
    report: SolverReport,
) -> Transient:
    """Convert states at the sample times into the histories of a `Transient`."""
    rows = over_samples(rows_of(mechanism, kinematics), history)
    return transient_of(mechanism, kinematics, times, rows, report)


def transient_of(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    times: Float[Array, " times"],
    entries: dict[str, Any],
    report: SolverReport,
) -> Transient:
    """A `Transient` from the entries by `rows_of`, with times along the first axis."""
    entries = dict(entries)
    finite = entries.pop("finite") & jnp.isfinite(times)
    pulled = jnp.any(entries.pop("pulled"))
    deflections: Any = entries.pop("bristle_deflection")
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
        name: jnp.moveaxis(row, 1, 0) if name in per_stage else row for name, row in entries.items()
    }
    # The steps may have run out, or the rollers may be at rest, before a sample shows the jam.
    fastest, largest_load = (jnp.max(jnp.abs(entries[name])) for name in ("screw_speed", "load"))
    locks = jams(mechanism, kinematics, fastest, largest_load)
    jammed = pulled | ((report.code != 0) & locks)
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
