"""Forces through a chain of stages: each nut carries the next screw."""

import equinox as eqx
import jax.numpy as jnp

from .._physics import physics
from ..mechanism import (
    ConstantDrag,
    Mechanism,
    Scalar,
    SplineFriction,
    Stage,
    ThrustBearingFriction,
    body_inertia,
    body_mass,
)
from ._kinematics import StageKinematics, travel_per_turn
from ._stage_forces import Motion, StageForces, axial_inertia, stage_forces


class ScrewForces(eqx.Module):
    """What acts on the screw of one stage beside its rollers; `None` where not modelled."""

    #: Torque that drives this screw and all screws after it, M_S [N·m].
    drive_torque: Scalar
    #: Axial force that the previous nut (or the housing) carries, F_N of stage k − 1 [N].
    support_force: Scalar
    #: Friction force of the spline f_S [N].
    spline_friction: Scalar | None
    #: Friction torque of the thrust bearing [N·m].
    bearing_torque: Scalar | None
    #: Constant drag torque [N·m].
    drag_torque: Scalar | None


class StageState(eqx.Module):
    """Motion and forces of one stage at one instant."""

    motion: Motion
    forces: StageForces
    screw: ScrewForces
    #: Load on this stage's nut [N].
    nut_load: Scalar


@physics("drag")
def _drag_torque(law: ConstantDrag, sense: Scalar) -> Scalar:
    return law.torque * sense


@physics("spline_friction")
def _spline_force_per_torque(law: SplineFriction, sense: Scalar) -> Scalar:
    return law.coefficient / law.radius * sense


@physics("thrust_bearing_friction")
def _bearing_torque_per_force(law: ThrustBearingFriction, sense: Scalar) -> Scalar:
    return law.coefficient * law.radius * sense


@physics("screw_inertia")
def _torque_of_inertia(stage: Stage, acceleration: Scalar) -> Scalar:
    return body_inertia(stage, "screw") * acceleration


@physics("screw_inertia")
def _force_of_inertia(stage: Stage, acceleration: Scalar) -> Scalar:
    return body_mass(stage, "screw") * acceleration


def _coupled_frictions(torque, force, per_force, per_torque):
    """Solve M = torque + per_force |F|, F = force + per_torque |M|.

    Spline friction follows the drive torque, bearing friction the axial force, and each changes
    the other. For per_force·per_torque < 1 (always, for real friction coefficients) the solution
    is unique; it is linear once the two signs are known, so the four cases are tried in turn.
    """
    candidates = []
    for torque_sign in (1.0, -1.0):
        for force_sign in (1.0, -1.0):
            gain = per_force * per_torque * torque_sign * force_sign
            moment = (torque + per_force * force_sign * force) / (1 - gain)
            axial = force + per_torque * torque_sign * moment
            consistent = (moment * torque_sign >= 0) & (axial * force_sign >= 0)
            candidates.append((consistent, moment, axial))
    _, moment, axial = candidates[-1]
    for consistent, candidate_moment, candidate_axial in candidates[-2::-1]:
        moment = jnp.where(consistent, candidate_moment, moment)
        axial = jnp.where(consistent, candidate_axial, axial)
    return moment, axial


def screw_forces(
    stage: Stage,
    forces: StageForces,
    sense: Scalar,
    next_screw: ScrewForces | None,
    screw_acceleration: Scalar | None,
    axial_acceleration: Scalar | None,
) -> ScrewForces:
    """Torque and axial balance of one screw (Li et al. 2020, equations 21 and 22, with N)."""
    friction = stage.friction
    torque, axial = -forces.torque_on_screw, forces.axial_on_screw
    drag = None
    if friction is not None and friction.drag is not None:
        drag = _drag_torque(friction.drag, sense)
        torque = torque + drag
    if next_screw is not None:
        torque = torque + next_screw.drive_torque
        if next_screw.spline_friction is not None:
            axial = axial - next_screw.spline_friction
    if screw_acceleration is not None:
        torque = torque + _torque_of_inertia(stage, screw_acceleration)
    if axial_acceleration is not None:
        axial = axial - _force_of_inertia(stage, axial_acceleration)

    spline = None if friction is None else friction.spline
    bearing = None if friction is None else friction.thrust_bearing
    per_torque = None if spline is None else _spline_force_per_torque(spline, sense)
    per_force = None if bearing is None else _bearing_torque_per_force(bearing, sense)
    if per_torque is not None and per_force is not None:
        torque, axial = _coupled_frictions(torque, axial, per_force, per_torque)
    elif per_force is not None:
        torque = torque + per_force * jnp.abs(axial)
    elif per_torque is not None:
        axial = axial + per_torque * jnp.abs(torque)
    return ScrewForces(
        drive_torque=torque,
        support_force=axial,
        spline_friction=None if per_torque is None else per_torque * jnp.abs(torque),
        bearing_torque=None if per_force is None else per_force * jnp.abs(axial),
        drag_torque=drag,
    )


def chain_forces(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    motion_of,
    sense: Scalar,
    load: Scalar,
    screw_acceleration: Scalar | None = None,
) -> tuple[StageState, ...]:
    """Forces in all stages, from the last nut to the first screw.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `kinematics`: kinematics of each stage.
    - `motion_of`: function of (stage index, axial force, axial acceleration) to the stage's
      `Motion`; a steady state needs the force to find the carrier speed.
    - `sense`: sense of turning of the screws, +1 or −1.
    - `load`: load on the last nut [N].
    - `screw_acceleration`: Ω̇ [rad/s²], or `None` at constant speed.
    """
    stages = mechanism.stages
    states: list[StageState] = []
    next_screw, nut_load = None, load
    for index in reversed(range(len(stages))):
        stage = stages[index]
        nut_acceleration = screw_axial = None
        axial_force = nut_load
        if screw_acceleration is not None:
            nut_acceleration = -screw_acceleration * travel_per_turn(stages, index + 1)
            axial_force = nut_load - axial_inertia(stage) * nut_acceleration
            if index > 0:
                screw_axial = -screw_acceleration * travel_per_turn(stages, index)
        motion = motion_of(index, axial_force, nut_acceleration)
        forces = stage_forces(stage, kinematics[index], motion, axial_force)
        screw = screw_forces(stage, forces, sense, next_screw, screw_acceleration, screw_axial)
        states.append(StageState(motion, forces, screw, nut_load))
        next_screw, nut_load = screw, screw.support_force
    return tuple(reversed(states))
