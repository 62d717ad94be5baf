"""Power losses by name."""

import jax.numpy as jnp

from ...fields import Scalar
from ...mechanism import Mechanism, Stage
from ...numerics import dot_few
from .._kinematics import StageKinematics
from ..friction import bristle_power, deflected
from ._chain import StageState


def stage_bristle_power(stage: Stage, state: StageState) -> Scalar:
    """Rate at which the deflections of a stage's contacts store energy [W]."""
    motion, forces = state.motion, state.forces
    assert motion.deflection is not None
    contact = deflected(motion.slip, motion.deflection, forces.rubbing)
    return bristle_power(stage, contact, forces.contact_force)


def stored_power(mechanism: Mechanism, states: tuple[StageState, ...]) -> Scalar | None:
    """Rate at which all bristles store energy [W]; `None` without any."""
    powers = [
        stage_bristle_power(stage, state)
        for stage, state in zip(mechanism.stages, states, strict=True)
        if state.motion.deflection is not None
    ]
    return sum(powers[1:], powers[0]) if powers else None


def losses(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    states: tuple[StageState, ...],
    screw_speed: Scalar,
) -> dict[str, Scalar]:
    """Power of every modelled loss, all stages together [W].

    Names: `thread_sliding`, `spin`, `rolling_hysteresis`, `spline`, `thrust_bearing`, `drag`. A
    loss that no stage models is not in the dictionary.

    **Arguments:**

    - `mechanism`, `kinematics`, `states`: the mechanism, its kinematics and its forces.
    - `screw_speed`: Ω [rad/s].
    """
    powers: dict[str, Scalar] = {}

    def add(name: str, power: Scalar) -> None:
        powers[name] = powers[name] + power if name in powers else power

    for index, (stage, geometry, state) in enumerate(
        zip(mechanism.stages, kinematics, states, strict=True)
    ):
        count, motion, forces = stage.present_roller_count, state.motion, state.forces
        friction = stage.friction
        if friction is None:
            continue
        if friction.thread is not None:
            sliding = count * dot_few(forces.friction, motion.slip)
            if motion.deflection is not None:
                # Power that bends the bristles is stored, not yet lost.
                sliding = sliding - stage_bristle_power(stage, state)
            add("thread_sliding", sliding)
        rolling = geometry.relative_spin_ratio * motion.carrier_speed
        for moment, rate in (
            (forces.screw_moment, motion.screw_sense * (motion.screw_speed + rolling)),
            (forces.nut_moment, motion.nut_sense * rolling),
        ):
            if moment is None:
                continue
            if moment.spin is not None:
                add("spin", count * moment.spin * rate)
            if moment.rolling_hysteresis is not None:
                add("rolling_hysteresis", count * moment.rolling_hysteresis * rate)
        screw = state.screw
        if screw.spline_friction is not None:
            previous = mechanism.stages[index - 1].thread
            sliding = screw_speed * previous.lead / (2 * jnp.pi)
            add("spline", screw.spline_friction * sliding)
        if screw.bearing_torque is not None:
            add("thrust_bearing", screw.bearing_torque * screw_speed)
        if screw.drag_torque is not None:
            add("drag", screw.drag_torque * screw_speed)
    return powers
