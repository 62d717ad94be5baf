"""Steady state: algebra, no integration."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .._errors import MissingDataError
from .._physics import physics
from .._root import find_root
from ..mechanism import CoulombFriction, Mechanism, Scalar, Stage, ViscousFriction
from ._chain import StageState, chain_forces
from ._contact_losses import has_contact_losses, resisting_moments
from ._kinematics import StageKinematics, free_carrier_ratio, stage_kinematics, travel_per_turn
from ._power import losses
from ._roller_balance import roller_support_forces
from ._stage_forces import Motion
from ._thread_friction import normal_force, slip_direction, thread_friction

#: A load so small that nothing but ratios notices it: the efficiency without load is its limit.
_NO_LOAD = 1e-30


class SteadyState(eqx.Module):
    """Steady operating point of a mechanism; arrays run over the stages.

    `efficiency` is output over input power: of the nut when the screw drives, of the screw when
    the load drives it back (negative when it does not move by itself: self-locking).
    """

    efficiency: Scalar
    #: ω/Ω of each stage.
    carrier_ratio: Float[Array, " stages"]
    #: Torque at the first screw [N·m].
    drive_torque: Scalar
    #: Normal force of the screw on one roller, all its threads together [N].
    contact_force: Float[Array, " stages"]
    #: Axial part of it [N].
    screw_roller_axial_force: Float[Array, " stages"]
    #: Load on each nut [N].
    nut_load: Float[Array, " stages"]
    #: Slip speed of the screw over the roller [m/s].
    slip_speed: Float[Array, " stages"]
    ring_gear_force: Float[Array, " stages"]
    carrier_force: Float[Array, " stages"]
    spline_friction: Float[Array, " stages"]
    #: Power of each modelled loss [W].
    losses: dict[str, Scalar]
    input_power: Scalar
    output_power: Scalar
    #: |input − output − losses| / input.
    power_balance_residual: Scalar
    #: False where the meshing has no solution, the thread locks, or the carrier cannot turn.
    valid: Bool[Array, ""]


@physics("carrier_balance")
def _carrier_ratio(
    stage: Stage, kinematics: StageKinematics, sense: Scalar, speed: Scalar, axial_force: Scalar
) -> tuple[Scalar, Bool[Array, ""]]:
    """Steady carrier ratio with resisting moments on the roller, and whether one was found.

    Thread friction has to push the roller against the moments in the contact ellipses:
    `f·d = (n − 1)(T_s + T_n)`. The slip v = v₀ − ω d changes with ω only along d, so with the
    component s of the slip along d and the rest q: Coulomb `s/√(s² + q²) = c`, c the ratio of
    resistance to friction, so s = q c/√(1 − c²); c depends weakly on the normal force and
    is found by Newton. Viscous friction gives s directly.
    """
    law = None if stage.friction is None else stage.friction.thread
    slip, drive = kinematics.slip_per_screw, kinematics.drive
    length = jnp.sqrt(drive @ drive)
    along = slip[:2] @ drive / length
    # A cross product: at small leads the slip is nearly all along d, and slip² − along² is noise.
    across = (slip[0] * drive[1] - slip[1] * drive[0]) / length
    across_squared = across**2 + slip[2] ** 2

    def resistance(ratio: Scalar) -> tuple[Scalar, Scalar]:
        """Resisting generalised force and normal force of one roller at a carrier ratio."""
        direction_slip = _unit_slip(kinematics, ratio)
        direction = sense * slip_direction(direction_slip)
        per_force, constant = thread_friction(law, speed * direction_slip, direction)
        axial = axial_force / stage.present_roller_count
        force = normal_force(kinematics.meshing.screw.normal, per_force, constant, axial)
        on_roller = force * kinematics.meshing.screw.normal + force * per_force + constant
        nut_force = -on_roller[2] / kinematics.meshing.nut.normal[2]
        screw, nut = resisting_moments(stage, kinematics, force, nut_force)
        return kinematics.relative_spin_ratio * (screw.total + nut.total), force

    if isinstance(law, ViscousFriction):
        # The axial slip, and with it the normal force, does not depend on the carrier.
        resisting, _ = resistance(along / length)
        moving = speed != 0
        slip_along = resisting / (law.coefficient * length * jnp.where(moving, speed, 1.0))
        return (along - jnp.where(moving, sense * slip_along, 0.0)) / length, moving
    if not isinstance(law, CoulombFriction):
        raise MissingDataError(
            "spin and rolling losses resist the rollers, and only thread friction can drive them; "
            "give [stage.friction.thread]"
        )

    def ratio_at(share: Scalar) -> Scalar:
        slip_along = share * jnp.sqrt(across_squared / (1 - share**2))
        return (along - slip_along) / length

    def residual(share: Scalar) -> Scalar:
        # A trial share of one or more has no slip that could balance it.
        bounded = jnp.clip(share, -0.999, 0.999)
        resisting, force = resistance(ratio_at(bounded))
        return share - resisting / (law.coefficient * force * length)

    share, found = find_root(
        residual,
        jnp.zeros_like(along),
        tolerance=1e-13 if along.dtype == jnp.float64 else 1e-5,
        max_steps=20,
    )
    found = found & (jnp.abs(share) < 0.999)
    return ratio_at(jnp.clip(share, -0.999, 0.999)), found


def _unit_slip(kinematics: StageKinematics, ratio: Scalar) -> Float[Array, "3"]:
    """Slip per radian of screw turn at a carrier ratio [m/rad]."""
    in_plane = kinematics.slip_per_screw[:2] - ratio * kinematics.drive
    return jnp.concatenate([in_plane, kinematics.slip_per_screw[2:]])


def _steady_states(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    speed: Scalar,
    sense: Scalar,
    load: Scalar,
) -> tuple[tuple[StageState, ...], list[Scalar], Bool[Array, ""]]:
    ratios: list[Scalar] = []
    valid = jnp.stack([k.meshing.converged for k in kinematics]).all()

    def motion_of(index: int, axial_force: Scalar, _) -> Motion:
        nonlocal valid
        stage, geometry = mechanism.stages[index], kinematics[index]
        if has_contact_losses(stage.friction):
            ratio, found = _carrier_ratio(stage, geometry, sense, speed, axial_force)
            valid = valid & found
        else:
            ratio = free_carrier_ratio(geometry)
        ratios.append(ratio)
        unit_slip = _unit_slip(geometry, ratio)
        return Motion(
            screw_speed=speed,
            carrier_speed=speed * ratio,
            slip=speed * unit_slip,
            direction=sense * slip_direction(unit_slip),
            screw_sense=sense,
            nut_sense=sense,
        )

    states = chain_forces(mechanism, kinematics, motion_of, sense, load)
    for state in states:
        # Past the locking limit the axial balance asks for a pulling contact.
        valid = valid & (state.forces.contact_force > 0)
    return states, ratios[::-1], valid


def _operating_point(mechanism: Mechanism, speed, load) -> tuple[Scalar, Scalar]:
    point = mechanism.operating_point
    dtype = mechanism.stages[0].thread.lead.dtype
    values = []
    for name, value in (("speed", speed), ("load", load)):
        if value is None:
            if point is None:
                raise MissingDataError(
                    f"no {name}: the mechanism has no operating point; pass {name}=… or give "
                    f"[operating_point] {name}"
                )
            value = getattr(point, name)
        values.append(jnp.asarray(value, dtype))
    return values[0], values[1]


def all_kinematics(mechanism: Mechanism) -> tuple[StageKinematics, ...]:
    """Kinematics of every stage."""
    return tuple(stage_kinematics(stage) for stage in mechanism.stages)


@physics("steady_state")
def steady_state(
    mechanism: Mechanism,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    kinematics: tuple[StageKinematics, ...] | None = None,
) -> SteadyState:
    """Steady state at a prescribed screw speed and load, in closed form.

    The carrier speed follows from f·d = 0, which is linear in it: geometry alone decides. Losses
    inside the contact ellipses, where modelled, shift it slightly. Forces then follow stage by
    stage from the load, and the efficiency is `F_n Σ L / (2π M)`, or its inverse when the load
    drives. The slip direction is that of the motion about to begin if the speed is 0.

    A negative load lies on the other flanks; the same mechanism seen from its other end carries
    it at the opposite speed, which is how it is computed.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `speed`: screw speed [rad/s]; negative with a positive load is back-driving. Default: that
      of the operating point.
    - `load`: axial load on the last nut [N]. Default: that of the operating point.
    - `kinematics`: kinematics of the stages, if known already.

    **Raises:** `MissingDataError` if speed, load, or data for a modelled loss are not given.
    """
    speed, load = _operating_point(mechanism, speed, load)
    if kinematics is None:
        kinematics = all_kinematics(mechanism)
    flank = jnp.where(load < 0, -1.0, 1.0).astype(load.dtype)
    load = flank * load + jnp.where(load == 0, _NO_LOAD, 0.0).astype(load.dtype)
    speed = flank * speed
    sense = jnp.where(speed < 0, -1.0, 1.0).astype(load.dtype)

    states, ratios, valid = _steady_states(mechanism, kinematics, speed, sense, load)
    torque = states[0].screw.drive_torque
    travel = travel_per_turn(mechanism.stages, len(mechanism.stages))
    lost = losses(mechanism, kinematics, states, speed)
    forward = sense > 0
    useful, driving = (
        jnp.where(forward, load * travel, torque),
        jnp.where(forward, torque, load * travel),
    )
    drive_power, load_power = torque * speed, load * travel * speed
    gross = jnp.maximum(jnp.abs(drive_power), jnp.abs(load_power))
    imbalance = drive_power - load_power - sum(lost.values())
    supports = [
        roller_support_forces(stage, geometry, state, None)
        for stage, geometry, state in zip(mechanism.stages, kinematics, states, strict=True)
    ]
    zero = jnp.zeros_like(load)
    return SteadyState(
        efficiency=useful / driving,
        carrier_ratio=jnp.stack(ratios),
        drive_torque=flank * torque,
        contact_force=jnp.stack([s.forces.contact_force for s in states]),
        screw_roller_axial_force=jnp.stack(
            [
                -s.forces.contact_force * k.meshing.screw.normal[2]
                for s, k in zip(states, kinematics, strict=True)
            ]
        ),
        nut_load=flank * jnp.stack([s.nut_load for s in states]),
        slip_speed=jnp.stack([_length(s.motion.slip) for s in states]),
        ring_gear_force=jnp.stack([s.ring_gear_force for s in supports]),
        carrier_force=jnp.stack([s.carrier_force for s in supports]),
        spline_friction=jnp.stack(
            [zero if s.screw.spline_friction is None else s.screw.spline_friction for s in states]
        ),
        losses=lost,
        input_power=jnp.where(forward, drive_power, -load_power),
        output_power=jnp.where(forward, load_power, -drive_power),
        power_balance_residual=jnp.abs(imbalance) / jnp.where(gross > 0, gross, 1.0),
        valid=valid,
    )


def _length(vector: Float[Array, "3"]) -> Scalar:
    square = jnp.sum(vector**2)
    some = square > 0
    return jnp.where(some, jnp.sqrt(jnp.where(some, square, 1.0)), 0.0)
