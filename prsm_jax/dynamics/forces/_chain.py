"""Forces through a chain of stages: each nut carries the next screw."""

import functools
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...fields import Scalar
from ...mechanism import Mechanism, Stage, body_inertia, body_mass
from ...programs import physics
from .._kinematics import StageKinematics, travel_per_radian
from ..friction import bearing_torque, drag_torque, loaded_flank_sign, spline_force
from ._stage_forces import Motion, StageForces, axial_inertia, stage_forces


class ScrewForces(eqx.Module):
    """Loads on the screw of one stage besides those of its rollers; `None` where not modelled."""

    #: Torque that drives this screw and all screws after it, M_S [N·m].
    drive_torque: Scalar
    #: Axial force that the previous nut (or the housing) carries, F_N of stage k − 1 [N].
    support_force: Scalar
    #: Friction force of the spline f_S [N].
    spline_friction: Scalar | None
    #: Friction torque of the thrust bearing [N·m].
    bearing_torque: Scalar | None
    #: Drag torque [N·m].
    drag_torque: Scalar | None


class StageState(eqx.Module):
    """Motion and forces of one stage at one instant."""

    motion: Motion
    forces: StageForces
    screw: ScrewForces
    #: Load on this stage's nut [N].
    nut_load: Scalar
    #: +1 or −1: loaded flanks; `motion` and `forces` are in the frame of these (`_flank`).
    flank_sign: Scalar


@physics("screw_inertia")
def _torque_of_inertia(stage: Stage, acceleration: Scalar) -> Scalar:
    return body_inertia(stage, stage.thread.family.turning) * acceleration


@physics("screw_inertia")
def _force_of_inertia(stage: Stage, acceleration: Scalar) -> Scalar:
    return body_mass(stage, "screw") * acceleration


def _coupled_frictions(torque, force, per_force, per_torque):
    """Solve M = torque + per_force |F|, F = force + per_torque |M|.

    Spline friction follows the drive torque, bearing friction the axial force, and each changes
    the other. For |per_force·per_torque| < 1 (always, for real friction coefficients) the solution
    is unique, and linear once both signs are known. Left side minus right side of the first
    equation grows with M, so its value at M = 0 determines the sign of M; likewise for F.
    """

    def sign(value):
        return jnp.where(value < 0, -1.0, 1.0).astype(value.dtype)

    torque_sign = sign(torque + per_force * jnp.abs(force))
    force_sign = sign(force + per_torque * jnp.abs(torque))
    per_force, per_torque = per_force * force_sign, per_torque * torque_sign
    moment = (torque + per_force * force) / (1 - per_force * per_torque)
    return moment, force + per_torque * moment


def screw_forces(
    stage: Stage,
    torque_on_screw: Scalar,
    axial_on_screw: Scalar,
    screw_speed: Scalar,
    sense: Scalar,
    driver: Stage | None,
    next_screw: ScrewForces | None,
    screw_acceleration: Scalar | None,
    axial_acceleration: Scalar | None,
) -> ScrewForces:
    """Torque and axial balance of one screw (Li et al. 2020, equations 21 and 22, with N).

    The spline slides by the lead of the previous stage, whose screw is its `driver`.
    """
    friction = stage.friction
    torque, axial = -torque_on_screw, axial_on_screw
    drag = None
    if friction is not None and friction.drag is not None:
        drag = drag_torque(friction.drag, screw_speed, sense)
        torque = torque + drag
    if next_screw is not None:
        torque = torque + next_screw.drive_torque
        if next_screw.spline_friction is not None:
            axial = axial - next_screw.spline_friction
    if screw_acceleration is not None:
        torque = torque + _torque_of_inertia(stage, screw_acceleration)
    if axial_acceleration is not None:
        axial = axial - _force_of_inertia(stage, axial_acceleration)

    per_torque = spline_constant = per_force = bearing_constant = None
    if friction is not None and friction.spline is not None and driver is not None:
        sliding = screw_speed * driver.thread.lead / (2 * jnp.pi)
        per_torque, spline_constant = spline_force(friction.spline, sliding, sense)
        axial = axial if spline_constant is None else axial + spline_constant
    if friction is not None and friction.thrust_bearing is not None:
        per_force, bearing_constant = bearing_torque(friction.thrust_bearing, screw_speed, sense)
        torque = torque if bearing_constant is None else torque + bearing_constant
    if per_torque is not None and per_force is not None:
        torque, axial = _coupled_frictions(torque, axial, per_force, per_torque)
    elif per_force is not None:
        torque = torque + per_force * jnp.abs(axial)
    elif per_torque is not None:
        axial = axial + per_torque * jnp.abs(torque)
    return ScrewForces(
        drive_torque=torque,
        support_force=axial,
        spline_friction=_friction(per_torque, torque, spline_constant),
        bearing_torque=_friction(per_force, axial, bearing_constant),
        drag_torque=drag,
    )


def _friction(per_load: Scalar | None, load: Scalar, constant: Scalar | None) -> Scalar | None:
    if per_load is None:
        return constant
    proportional = per_load * jnp.abs(load)
    return proportional if constant is None else proportional + constant


def chain_forces(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    motion_of: Callable[[int, Scalar, Scalar, Scalar | None], Motion],
    speed: Scalar,
    sense: Scalar,
    load: Scalar,
    screw_acceleration: Scalar | None = None,
    carrier_acceleration: Float[Array, " stages"] | None = None,
) -> tuple[StageState, ...]:
    """Forces in all stages, from the last nut to the first screw.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `kinematics`: kinematics of each stage.
    - `motion_of`: function of (stage index, flank sign, axial force, axial acceleration) to the
      stage's `Motion`, all in the frame of the loaded flank; a steady state needs the force to find
      the carrier speed.
    - `speed`: screw speed [rad/s].
    - `sense`: sense of turning of the screws, +1 or −1.
    - `load`: load on the last nut [N].
    - `screw_acceleration`: Ω̇ [rad/s²], or `None` at constant speed.
    - `carrier_acceleration`: ω̇ of every stage where it moves a nut with grooves along the axis
      [rad/s²]; else `None`.
    """
    stages = mechanism.stages
    states: list[StageState] = []
    next_screw, nut_load = None, load
    for index in reversed(range(len(stages))):
        stage = stages[index]
        nut_acceleration = screw_axial = None
        axial_force = nut_load
        if screw_acceleration is not None:
            nut_acceleration = -screw_acceleration * travel_per_radian(stages, index + 1)
            axial_force = nut_load - axial_inertia(stage) * nut_acceleration
            if index > 0:
                screw_axial = -screw_acceleration * travel_per_radian(stages, index)
        if carrier_acceleration is not None:
            # Such a nut travels by its lead per turn of screw over carrier; it is the only stage.
            own = carrier_acceleration[index] * travel_per_radian(stages, index + 1)
            nut_acceleration = own if nut_acceleration is None else nut_acceleration + own
            axial_force = nut_load - axial_inertia(stage) * nut_acceleration
        law = stage.thread_law
        per_roller = axial_force / stage.present_roller_count
        axial_slip = speed * kinematics[index].slip_per_screw[2]
        viscous = law is not None and law.viscous_resistance is not None
        if viscous and kinematics[index].axial_drive is not None:
            # The carrier moves the roller along the axis here, and its speed may depend on which
            # flanks carry: the usual ones do if they do with the speed that follows from it.
            usual = motion_of(index, jnp.ones_like(per_roller), axial_force, nut_acceleration)
            axial_slip = jax.lax.stop_gradient(usual.slip[2])
        flank_sign = loaded_flank_sign(law, per_roller, axial_slip)
        own_force = flank_sign * axial_force
        own_acceleration = None if nut_acceleration is None else flank_sign * nut_acceleration
        motion = motion_of(index, flank_sign, own_force, own_acceleration)
        forces = stage_forces(stage, kinematics[index], motion, own_force, flank_sign)
        screw = screw_forces(
            stage,
            forces.torque_on_screw,
            forces.axial_on_screw,
            speed,
            sense,
            stages[index - 1] if index > 0 else None,
            next_screw,
            screw_acceleration,
            screw_axial,
        )
        states.append(StageState(motion, forces, screw, nut_load, flank_sign))
        next_screw, nut_load = screw, screw.support_force
    return tuple(reversed(states))


def carrier_drives(states: tuple[StageState, ...]) -> Float[Array, " stages"]:
    """Moment that drives the carrier of each stage [N m]."""
    return jnp.stack([state.forces.carrier_drive for state in states])


def all_push(states: tuple[StageState, ...]) -> Bool[Array, "*times"]:
    """Whether all contacts push: beyond jamming the axial balance requires one that pulls."""
    return functools.reduce(jnp.logical_and, [s.forces.contact_force >= 0 for s in states])
