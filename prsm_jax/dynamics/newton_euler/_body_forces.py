"""Forces on every part, in Newton's formulation."""

import dataclasses
from typing import Annotated

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...fields import In, Scalar
from ...mechanism import Mechanism, of_one_design, require_type
from ...numerics import length_few
from ...programs import mapped, one_program
from ...results import DesignResult
from .._kinematics import StageKinematics, travel_per_radian
from ..forces import sense_of
from ..friction import bearing_torque, drag_torque, spline_force, with_resistance
from ..histories import Transient
from ..steady import SteadyState, all_kinematics
from ._equations_of_motion import contact_moments, from_following, newton_forces
from ._free_bodies import (
    ScrewAcceleration,
    StageSurroundings,
    radii_of,
    roller_acceleration,
    roller_forces,
)
from ._part_masses import PartMasses, part_masses


class Instant(eqx.Module):
    """Motion of a mechanism at one instant, and its load."""

    #: Ω [rad/s].
    screw_speed: Float[Array, "*times"]
    #: ω of every stage [rad/s].
    carrier_speed: Float[Array, "*times stages"]
    #: Load on the last nut [N].
    load: Float[Array, "*times"]
    #: Ω̇ [rad/s²]; `None` at constant speed, where masses of nuts and screws are not needed.
    screw_acceleration: Float[Array, "*times"] | None = None
    #: Unit vector of the slip of every stage; `None` takes it from the slip itself. At standstill,
    #: direction of impending motion.
    slip_direction: Float[Array, "*times stages 3"] | None = None
    #: Deflection of the bristles between the threads [m]; only under LuGre's law, and `None` for
    #: bristles that have settled.
    bristle_deflection: Float[Array, "*times stages 3"] | None = None


class BodyForces(DesignResult):
    """Forces on every part; arrays run over the stages, then over times, then over directions.

    Vectors are in the frame that turns with the stage's carrier: radial (from the screw's axis
    through the roller's), tangential, axial (along the load on the nut). Forces on a roller are
    those on one roller; its reactions on screw, nut and carriers are opposite, times the number of
    rollers. Torques are about the axis of the screw, positive in the sense of positive speed.

    "Screw" is the body that turns, on which the rollers slide, and "nut" the one that is held: in
    an inverted roller screw these are its nut and its screw, and "ring gear" is the teeth of its
    screw.
    """

    #: Normal force of the screw on one roller, all threads together [N].
    screw_contact_force: Annotated[Float[Array, "stages *times"], In("N")]
    #: Normal force of the nut on one roller [N].
    nut_contact_force: Annotated[Float[Array, "stages *times"], In("N")]
    #: Normal force of the screw as a vector, and friction of the screw on the roller [N].
    screw_normal_on_roller: Annotated[Float[Array, "stages *times 3"], In("N")]
    screw_friction_on_roller: Annotated[Float[Array, "stages *times 3"], In("N")]
    nut_on_roller: Annotated[Float[Array, "stages *times 3"], In("N")]
    #: Tooth force of the ring gear on one end of a roller [N]; radial only if a gear is given.
    ring_gear_on_roller: Annotated[Float[Array, "stages *times 3"], In("N")]
    #: Force of one carrier's pin on one end of a roller [N].
    pin_on_roller: Annotated[Float[Array, "stages *times 3"], In("N")]
    #: Resisting moments in the contacts of one roller (spin and rolling) [N·m]: of the screw and of
    #: the nut on the roller.
    screw_moment_on_roller: Annotated[Float[Array, "stages *times"], In("N·m")]
    nut_moment_on_roller: Annotated[Float[Array, "stages *times"], In("N·m")]
    #: Acceleration of a roller's centre of mass [m/s²].
    roller_acceleration: Float[Array, "stages *times 3"]
    #: ω̇ [rad/s²].
    carrier_acceleration: Float[Array, "stages *times"]
    #: Axial force of the nut on all its carriers together [N].
    carrier_axial_force: Annotated[Float[Array, "stages *times"], In("N")]
    #: Axial force on the nut by the next screw, or the load [N].
    nut_load: Annotated[Float[Array, "stages *times"], In("N")]
    #: Axial force of the screw on the previous nut, or the housing, through the thrust bearing [N].
    thrust_bearing_force: Annotated[Float[Array, "stages *times"], In("N")]
    #: Friction torque of that bearing on the screw, against its turning [N·m].
    thrust_bearing_torque: Annotated[Float[Array, "stages *times"], In("N·m")]
    #: Torque of the spline on the screw; on the first screw, torque of the motor [N·m].
    drive_torque: Annotated[Float[Array, "stages *times"], In("N·m")]
    #: Axial friction of the spline on the screw [N].
    spline_friction: Annotated[Float[Array, "stages *times"], In("N")]
    #: Drag between screw and nut, against the turning of the screw [N·m].
    drag_torque: Annotated[Float[Array, "stages *times"], In("N·m")]
    #: External torque that keeps the nut from turning [N·m].
    anti_rotation_torque: Annotated[Float[Array, "stages *times"], In("N·m")]
    #: Whether the equations have a solution.
    solved: Annotated[Bool[Array, "*times"], In("1")]
    #: Whether the arrays have an axis of times.
    over_time: bool = eqx.field(static=True, default=False)

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch that these forces are of; empty for a single design."""
        return self.solved.shape[:-1] if self.over_time else self.solved.shape

    @property
    @mapped
    def motor_torque(self) -> Float[Array, "*times"]:
        """Torque at the first screw [N·m]."""
        return self.drive_torque[0]

    @property
    @mapped
    def housing_force(self) -> Float[Array, "*times"]:
        """Axial force on the housing through the first thrust bearing [N]."""
        return self.thrust_bearing_force[0]

    @property
    def ring_gear_force(self) -> Float[Array, "stages *times"]:
        """Tooth force on one end of a roller, magnitude [N]."""
        return length_few(self.ring_gear_on_roller)

    @property
    def carrier_force(self) -> Float[Array, "stages *times"]:
        """Force of a pin, magnitude [N]."""
        return length_few(self.pin_on_roller)


@of_one_design
@one_program
def body_forces(
    mechanism: Mechanism,
    run: Transient | SteadyState | Instant,
    kinematics: tuple[StageKinematics, ...] | None = None,
) -> BodyForces:
    """Forces on every part of a mechanism in motion, by Newton–Euler's equations of each body.

    Roller (with gear and pins at both ends), carriers, nut with ring gears, and screw of every
    stage are free bodies; forces, carrier accelerations and the laws of friction are solved as one
    system (Li et al. 2020, equations 17 to 28). `simulate` and `steady_state` find their forces
    from Lagrange's equations instead; the two agree to rounding.

    For a run under a prescribed torque these are, while it sticks, the forces at the nearer limit
    of sticking.

    **Arguments:**

    - `mechanism`: the mechanism of the run.
    - `run`: a `Transient`, a `SteadyState`, or an `Instant` of your own.
    - `kinematics`: kinematics of the stages, if known already.

    **Returns:** `BodyForces`; a transient's have a time axis after that of the stages.

    **Raises:** `MissingDataError` if a mass is needed and not given. Masses of rollers and carriers
    are needed unless in a steady state, those of screws and nuts where the screw accelerates.
    """
    known = ("standard", "inverted")
    require_type(mechanism.stages, "the forces on all bodies (body_forces) are", known)
    if kinematics is None:
        kinematics = all_kinematics(mechanism)
    kinematics = with_resistance(mechanism.stages, kinematics)
    if isinstance(run, Instant):
        return _at(mechanism, kinematics, _masses(mechanism, run, False), run)
    if isinstance(run, SteadyState):
        instant = Instant(
            run.screw_speed,
            run.carrier_ratio * run.screw_speed,
            run.nut_load[-1],
            slip_direction=run.slip_direction,
        )
        result = _at(mechanism, kinematics, _masses(mechanism, instant, True), instant)
        zeros = jnp.zeros_like(run.carrier_ratio)
        return eqx.tree_at(lambda forces: forces.carrier_acceleration, result, zeros)
    history = Instant(
        run.screw_speed,
        run.carrier_speed.T,
        run.load,
        run.screw_acceleration,
        jnp.moveaxis(run.slip_direction, 0, 1),
        None if run.bristle_deflection is None else jnp.moveaxis(run.bristle_deflection, 0, 1),
    )
    masses = _masses(mechanism, history, False)
    rows = jax.vmap(lambda one: _at(mechanism, kinematics, masses, one))(history)
    rows = jax.tree.map(lambda row: jnp.moveaxis(row, 1, 0) if row.ndim > 1 else row, rows)
    return dataclasses.replace(rows, over_time=True)


def _masses(mechanism: Mechanism, run: Instant, settled: bool) -> tuple[PartMasses, ...]:
    accelerates = run.screw_acceleration is not None
    return tuple(
        part_masses(stage, accelerates, index > 0, settled)
        for index, stage in enumerate(mechanism.stages)
    )


def _known(
    mechanism: Mechanism, kinematics: StageKinematics, run: Instant, index: int
) -> StageSurroundings:
    """Known quantities of one stage, for the equations of its forces."""
    stage = mechanism.stages[index]
    friction = stage.friction
    speed, carrier = run.screw_speed, run.carrier_speed[index]
    direction = None if run.slip_direction is None else run.slip_direction[index]
    # The axial slip has the sense of the screw's rotation, even at standstill.
    sense = sense_of(speed if direction is None else direction[2])
    rolling = kinematics.relative_spin_ratio * carrier
    stands = (speed == 0) & (carrier == 0)
    zero = jnp.zeros_like(speed)
    spline = bearing = (zero, zero)
    drag = zero
    if friction is not None and friction.spline is not None and index > 0:
        sliding = speed * mechanism.stages[index - 1].thread.lead / (2 * jnp.pi)
        spline = _parts(spline_force(friction.spline, sliding, sense), zero)
    if friction is not None and friction.thrust_bearing is not None:
        bearing = _parts(bearing_torque(friction.thrust_bearing, speed, sense), zero)
    if friction is not None and friction.drag is not None:
        drag = drag_torque(friction.drag, speed, sense)
    rate, acceleration = run.screw_acceleration, None
    if rate is not None:
        nut, screw = (
            -rate * travel_per_radian(mechanism.stages, upto) for upto in (index + 1, index)
        )
        acceleration = ScrewAcceleration(rate, nut, screw)
    return StageSurroundings(
        screw_speed=speed,
        carrier_speed=carrier,
        slip_direction=direction,
        deflection=None if run.bristle_deflection is None else run.bristle_deflection[index],
        screw_sense=jnp.where(stands, sense, sense_of(speed + rolling)),
        nut_sense=jnp.where(stands, sense, sense_of(rolling)),
        spline=spline,
        bearing=bearing,
        drag_torque=drag,
        acceleration=acceleration,
    )


def _parts(friction: tuple[Scalar | None, Scalar | None], zero: Scalar) -> tuple[Scalar, Scalar]:
    per_load, constant = friction
    return zero if per_load is None else per_load, zero if constant is None else constant


def _at(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    masses: tuple[PartMasses, ...],
    run: Instant,
) -> BodyForces:
    stages = mechanism.stages
    surroundings = tuple(
        _known(mechanism, kinematics[index], run, index) for index in range(len(stages))
    )
    solution, solved = newton_forces(mechanism, kinematics, masses, surroundings, run.load)
    rows = []
    for index, (stage, geometry, mass, known, unknowns) in enumerate(
        zip(stages, kinematics, masses, surroundings, solution, strict=True)
    ):
        following = from_following(stages, solution, index, run.load)
        vectors = roller_forces(stage, geometry, known, unknowns)
        acceleration = unknowns.carrier_acceleration / mass.reference
        screw_moment, nut_moment = contact_moments(stage, geometry, known, unknowns)
        held, radius = radii_of(stage)
        rows.append(
            {
                "screw_contact_force": jnp.abs(unknowns.screw_contact),
                "nut_contact_force": unknowns.nut_contact,
                "screw_normal_on_roller": vectors.normal,
                "screw_friction_on_roller": vectors.friction,
                "nut_on_roller": vectors.nut,
                "ring_gear_on_roller": vectors.ring_gear,
                "pin_on_roller": vectors.pin,
                "screw_moment_on_roller": known.screw_sense * screw_moment,
                "nut_moment_on_roller": known.nut_sense * nut_moment,
                "roller_acceleration": roller_acceleration(stage, known, acceleration),
                "carrier_acceleration": acceleration,
                "carrier_axial_force": unknowns.carrier_axial,
                "nut_load": following.load,
                "thrust_bearing_force": unknowns.support,
                "thrust_bearing_torque": radius * unknowns.bearing_torque,
                "drive_torque": radius * unknowns.drive_torque,
                "spline_friction": unknowns.spline_friction,
                "drag_torque": known.drag_torque,
                "anti_rotation_torque": held * unknowns.anti_rotation,
            }
        )
    columns = {name: jnp.stack([row[name] for row in rows]) for name in rows[0]}
    return BodyForces(**columns, solved=solved, over_time=False)
