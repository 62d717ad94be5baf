"""Transients of rollers that slide on the screw and in the nut: recirculating roller screws.

Two speeds are states, that of the carrier, ω, and that of the rollers against it, σ. With rollers
that advance by `z̈_R = h (ω̇ − Ω̇)`, because their grooves have no lead, and a nut by `−h Ω̇`, virtual
power gives

    (N m_R a² + J_P) ω̇ + N J_R (ω̇ + σ̇) + N m_R h z̈_R = −N Σ f·∂v/∂ω
                         N J_R (ω̇ + σ̇)               = −N Σ f·∂v/∂σ

with the friction f on a roller and the slip v of screw and nut over it. The normal forces follow
from the axial balances of nut and rollers, which hold z̈_R: two equations that are linear in the
accelerations where friction is in proportion to the normal force. Derived here.
"""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...mechanism import (
    Mechanism,
    Stage,
    body_inertia,
    mean_roller_inertia,
    mean_roller_mass,
)
from ...numerics import dot_few, over_samples, root_or_zero, solve_small
from ...programs import physics
from .._kinematics import StageKinematics, travel_per_radian
from ..forces import (
    Drive,
    Scenario,
    bound_scenario,
    drive_at,
    drive_once,
    held_mass,
    screw_forces,
)
from ..friction import turned
from ..histories import (
    Settings,
    Transient,
    finite_row,
    integrated,
    power_entries,
    relative,
    transient_of,
)
from ..solvers import DrivenRate
from ..steady import (
    SideSlips,
    SlidingSide,
    all_kinematics,
    check_losses,
    losses_of_both_sides,
    sliding_side,
    slips_of_both_sides,
    torque_on_screw,
)
from ._carrier_motion import ScaledProblem, fastest_drive, sample_times, with_scales


def slides_on_both_sides(mechanism: Mechanism) -> bool:
    """Whether the rollers slide on the screw and in the nut."""
    return mechanism.stages[-1].thread.family.carrying is None


class TwoSidesMasses(eqx.Module):
    """Masses and inertias of a stage; those of nut and screw are 0 at a constant speed.

    The nut's holds the carriers.
    """

    roller_mass: Scalar
    roller_inertia: Scalar
    carrier_inertia: Scalar
    nut_mass: Scalar
    screw_inertia: Scalar


def _masses(stage: Stage, accelerates: bool) -> TwoSidesMasses:
    zero = jnp.zeros_like(stage.thread.lead)
    carrier = nut = screw = zero
    if stage.carrier is not None:
        carrier = stage.carrier.count * body_inertia(stage, "carrier")
    if accelerates:
        nut, screw = held_mass(stage), body_inertia(stage, "screw")
    return TwoSidesMasses(
        mean_roller_mass(stage) + zero, mean_roller_inertia(stage) + zero, carrier, nut, screw
    )


class TwoSidesProblem(ScaledProblem):
    """Everything the equations of motion need."""

    masses: TwoSidesMasses
    slips: tuple[SideSlips, SideSlips]

    @property
    def stage(self) -> Stage:
        """The only stage."""
        return self.mechanism.stages[0]


class _Instant(NamedTuple):
    """Forces at one instant, in the frame of the loaded flank, and the flank's sign."""

    screw: SlidingSide
    nut: SlidingSide
    flank: Scalar
    #: Acceleration of the rollers along the axis, in that frame [m/s²].
    roller_rate: Scalar


def _instant(
    problem: TwoSidesProblem, drive: Drive, speeds: Float[Array, "2"], rates: Float[Array, "2"]
) -> _Instant:
    """Forces at given speeds and accelerations of carrier and rollers, [ω, σ]."""
    stage, masses = problem.stage, problem.masses
    count, lead = stage.present_roller_count, stage.thread.lead / (2 * jnp.pi)
    turning = jnp.zeros_like(drive.speed) if drive.acceleration is None else drive.acceleration
    on_nut = (drive.load + masses.nut_mass * lead * turning) / count
    advance = lead * (rates[0] - turning)
    flank = jnp.where(on_nut < 0, -1.0, 1.0).astype(on_nut.dtype)
    one = jnp.ones_like(on_nut)

    def side(slips: SideSlips, axial: Scalar) -> SlidingSide:
        slip = drive.speed * slips.per_screw
        slip = slip + speeds[0] * slips.per_carrier + speeds[1] * slips.per_spin
        return sliding_side(stage.thread_law, slips, flank * slip, one, one, flank * axial)

    screw = side(problem.slips[0], masses.roller_mass * advance - on_nut)
    return _Instant(screw, side(problem.slips[1], on_nut), flank, flank * advance)


@physics("two_sliding_sides_dynamics")
def _accelerations(
    problem: TwoSidesProblem, drive: Drive, speeds: Float[Array, "2"]
) -> Float[Array, "2"]:
    """[ω̇, σ̇], [rad/s²]."""
    stage, masses = problem.stage, problem.masses
    distance, lead = stage.thread.centre_distance, stage.thread.lead / (2 * jnp.pi)
    circling = masses.roller_mass * distance**2
    circling = circling + masses.carrier_inertia / stage.present_roller_count

    def unbalanced(rates: Float[Array, "2"]) -> Float[Array, "2"]:
        at = _instant(problem, drive, speeds, rates)
        pushes = [
            -sum(
                dot_few(side.friction, getattr(slips, name))
                for side, slips in zip((at.screw, at.nut), problem.slips, strict=True)
            )
            for name in ("per_carrier", "per_spin")
        ]
        own = masses.roller_inertia * (rates[0] + rates[1])
        axial = masses.roller_mass * lead * (at.flank * at.roller_rate)
        carrier = circling * rates[0] + own + axial - at.flank * pushes[0]
        return jnp.stack([carrier, own - at.flank * pushes[1]])

    def step(rates: Float[Array, "2"], _: None):
        return rates - solve_small(jax.jacfwd(unbalanced)(rates))(unbalanced(rates)), None

    # As for a carrier that moves the nut: the second step removes rounding.
    rates, _ = jax.lax.scan(step, jnp.zeros_like(speeds), length=2)
    return rates


def _scaled_drive(time: Scalar, problem: TwoSidesProblem) -> Drive:
    return drive_at(problem.scenario, time * problem.time_scale)


def _scaled(drive: Drive, ratios: Float[Array, "2"], problem: TwoSidesProblem):
    rates = _accelerations(problem, drive, ratios * problem.speed_scale)
    return rates * (problem.time_scale / problem.speed_scale)


_scaled_rate: DrivenRate = DrivenRate(_scaled_drive, _scaled)


def two_sides_problem(
    mechanism: Mechanism, kinematics: tuple[StageKinematics, ...], scenario: Scenario
) -> TwoSidesProblem:
    """Collect the input of the equations of motion, with its scales.

    The time scale is the shortest time constant of both speeds, a little beside ideal rolling.

    **Raises:** `MissingDataError` for losses other than thread friction by the slip speed, and for
    masses that are not given.
    """
    (stage,), (geometry,) = mechanism.stages, kinematics
    check_losses(stage)
    masses = _masses(stage, callable(scenario.speed))
    speed, drive = fastest_drive(scenario)
    slips = slips_of_both_sides(stage, geometry)
    one = jnp.ones_like(speed)
    problem = TwoSidesProblem(mechanism, kinematics, scenario, speed, one, masses, slips)
    beside = 0.8 * drive.speed * _ideal_ratios(stage)
    return with_scales(problem, lambda w: _accelerations(problem, drive, w), beside)


def _ideal_ratios(stage: Stage) -> Float[Array, "2"]:
    """ω/Ω and σ/Ω of rolling on the nominal circles."""
    carrier = stage.thread.ideal_carrier_ratio
    return jnp.stack([carrier, -stage.thread.rolling_ratio * carrier])


@physics("two_sliding_sides_transient")
def two_sides_history(
    mechanism: Mechanism,
    scenario: Scenario,
    kinematics: tuple[StageKinematics, ...] | None,
    settings: Settings,
) -> Transient:
    """A transient of a recirculating roller screw at a prescribed speed.

    Rollers start as if they rolled in the nut, with the carriers at the initial ratio.
    """
    scenario = bound_scenario(mechanism, scenario)
    kinematics = all_kinematics(mechanism) if kinematics is None else kinematics
    problem = two_sides_problem(mechanism, kinematics, scenario)
    stage = problem.stage
    times = sample_times(problem)
    begin = scenario.initial_carrier_ratio * scenario.speed_at(times[0]) / problem.speed_scale
    start = begin * jnp.stack([jnp.ones_like(begin), -stage.thread.rolling_ratio])
    ratios, report = integrated(
        _scaled_rate,
        start,
        scenario.duration / problem.time_scale,
        scenario.break_times / problem.time_scale,
        scenario.samples,
        settings,
        args=problem,
        autonomous=not (callable(scenario.speed) or callable(scenario.load)),
    )

    def row_at(time: Scalar, speeds: Float[Array, "2"]) -> dict[str, Any]:
        return _row(problem, drive_once(scenario, time), speeds)

    rows = over_samples(row_at, times, ratios * problem.speed_scale)
    return transient_of(mechanism, kinematics, times, rows, report)


def _kinetic_power(
    problem: TwoSidesProblem, drive: Drive, speeds: Float[Array, "2"], rates: Float[Array, "2"]
) -> Scalar:
    """Rate of the kinetic energy of all bodies [W]."""
    masses, thread = problem.masses, problem.stage.thread
    carrier, count = speeds[0], problem.stage.present_roller_count
    travel = thread.lead / (2 * jnp.pi)
    turning = jnp.zeros_like(drive.speed) if drive.acceleration is None else drive.acceleration
    rolling = masses.roller_inertia * (carrier + speeds[1]) * (rates[0] + rates[1])
    circling = masses.roller_mass * thread.centre_distance**2 * carrier * rates[0]
    advancing = masses.roller_mass * travel**2 * (carrier - drive.speed) * (rates[0] - turning)
    carriers = masses.carrier_inertia * carrier * rates[0]
    prescribed = (masses.nut_mass * travel**2 + masses.screw_inertia) * drive.speed * turning
    return count * (rolling + circling + advancing) + carriers + prescribed


def _row(problem: TwoSidesProblem, drive: Drive, speeds: Float[Array, "2"]) -> dict[str, Any]:
    """Entries of a `Transient` at one time."""
    stage, masses, (geometry,) = problem.stage, problem.masses, problem.kinematics
    thread, count = stage.thread, stage.present_roller_count
    speed, load, turning = drive.speed, drive.load, drive.acceleration
    carrier = speeds[0]
    rates = _accelerations(problem, drive, speeds)
    at = _instant(problem, drive, speeds, rates)
    flank, meshing = at.flank, geometry.meshing
    travel = travel_per_radian(problem.mechanism.stages, 1)
    zero = jnp.zeros_like(load)

    arms = [
        _arm(contact.contact_radius, contact.contact_angle_position)
        for contact in (meshing.screw, meshing.nut)
    ]
    moment = flank * torque_on_screw(geometry, count, at.screw)
    axial = -flank * count * at.screw.on_roller[2]
    screw = screw_forces(stage, moment, axial, speed, jnp.sign(speed), None, None, turning, None)
    losses = losses_of_both_sides(stage, at.screw, at.nut, screw, speed)
    kinetic = _kinetic_power(problem, drive, speeds, rates)

    distance = thread.centre_distance
    # Newton: moments about the roller's own axis, the force that pins have to add, and what that
    # does to the carriers.
    total = at.screw.on_roller + at.nut.on_roller
    about = [arm - jnp.stack([distance, zero]) for arm in arms]
    own = _moment(about[0], at.screw.on_roller) + _moment(about[1], at.nut.on_roller)
    own = own - flank * masses.roller_inertia * (rates[0] + rates[1])
    inward = -masses.roller_mass * carrier**2 * distance
    along = flank * masses.roller_mass * rates[0] * distance
    pin = jnp.stack([(inward - total[0]) / 2, (along - total[1]) / 2])
    carriers = 2 * count * distance * pin[1] + flank * masses.carrier_inertia * rates[0]

    moving = speed != 0
    force = at.screw.force
    stages = {
        "carrier_speed": carrier,
        "carrier_acceleration": rates[0],
        "carrier_ratio": jnp.where(moving, carrier / jnp.where(moving, speed, 1.0), 0.0),
        "contact_force": force,
        "screw_roller_axial_force": -force * meshing.screw.normal[2],
        "ring_gear_force": zero,
        "carrier_force": root_or_zero(dot_few(pin, pin)),
        "spline_friction": zero,
        "stage_torque": screw.drive_torque,
        "newton_residual": jnp.maximum(
            relative(own, force * thread.roller_radius),
            relative(carriers, count * force * distance),
        ),
        "slip_direction": turned(at.screw.direction, flank),
    }
    row = {
        **{name: value[None] for name, value in stages.items()},
        **power_entries(
            screw.drive_torque, load * travel, speed, load * travel * speed, losses, kinetic
        ),
        "screw_speed": speed,
        "screw_acceleration": turning,
        "load": load,
        "bristle_deflection": None,
        "bristle_power": None,
    }
    pulled = (force < 0) | (at.nut.force < 0)
    return {**row, "finite": finite_row(row), "pulled": pulled}


def _arm(radius: Scalar, angle: Scalar) -> Float[Array, "2"]:
    return radius * jnp.stack([jnp.cos(angle), jnp.sin(angle)])


def _moment(arm: Float[Array, "2"], force: Float[Array, "3"]) -> Scalar:
    """Moment about an axis along z."""
    return arm[0] * force[1] - arm[1] * force[0]
