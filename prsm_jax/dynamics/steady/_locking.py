"""Jamming and self-locking of threads: what friction they bear, and how far they are from it.

A screw that drives jams where friction takes all that the normal force lifts: the bracket of the
axial balance, |n_z| − μ v_z/‖v‖, vanishes. A load that drives no longer turns its screw where the
moment of friction about the axis reaches that of the normal force. The slip decides both, and its
direction follows from geometry alone, so both limits are closed forms; the flank angle α shows in
them, μ → cot α and μ → tan α.
"""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ...friction import scaled_friction
from ...mechanism import Friction, Mechanism, Scalar, Stage
from ...numerics import dot_few, find_root
from ...programs import physics
from .._kinematics import StageKinematics, travel_per_turn
from ..friction import asked_of, slip_direction, thread_friction, with_resistance
from ._carrier_balance import free_slip, slip_per_turn
from ._steady import SteadyState, some_load, steady_state


def _unit(kinematics: StageKinematics):
    """Direction of the slip of rollers that turn freely, the screw driving."""
    return slip_direction(slip_per_turn(kinematics).at(None))


def jamming_coefficient(kinematics: StageKinematics) -> Scalar:
    """Friction coefficient at which a driving screw jams, |n_z| ‖v‖ / v_z; about cot α."""
    return -kinematics.meshing.screw.normal[2] / _unit(kinematics)[2]


def locking_coefficient(kinematics: StageKinematics) -> Scalar:
    """Friction coefficient above which a load does not turn the screw; about tan α.

    There the moments of normal force and friction about the screw's axis are equal,
    `μ = −(n × r)_z ‖v‖ / (v × r)_z`.
    """
    side, direction = kinematics.meshing.screw, _unit(kinematics)
    angle = side.contact_angle_position
    tangent = jnp.stack([-jnp.sin(angle), jnp.cos(angle)])
    return dot_few(side.normal[:2], tangent) / dot_few(direction[:2], tangent)


def _proportional_to_force(friction: Friction | None) -> bool:
    """Whether thread friction alone resists, and in proportion to the normal force."""
    if friction is None:
        return True
    law, thread = friction.thread, dataclasses.replace(friction, thread=None)
    alone = all(value is None for value in vars(thread).values())
    if law is None:
        return alone
    return alone and not (law.load_independent or law.asks or law.viscous_resistance is not None)


def _effective_coefficient(
    stage: Stage, kinematics: StageKinematics, speed: Scalar, load: Scalar | None
) -> Scalar:
    """Friction per normal force at the slip of a screw speed.

    Of a law that asks for the normal force, at that which the load has without friction.
    """
    slip = free_slip(kinematics, jnp.abs(speed), jnp.ones_like(speed))
    law = stage.thread_law
    asked = {}
    if law is not None and law.asks:
        assert load is not None
        normal = -kinematics.meshing.screw.normal[2] * stage.present_roller_count
        (kinematics,) = with_resistance((stage,), (kinematics,))
        asked = asked_of(law, kinematics, slip, jnp.abs(load) / normal)
    per_force, _ = thread_friction(law, slip.velocity, slip.direction, asked)
    return dot_few(per_force, slip.direction)


def friction_needs_load(mechanism: Mechanism) -> bool:
    """Whether friction coefficients of any stage's threads depend on more than the slip speed."""
    laws = [stage.thread_law for stage in mechanism.stages]
    return any(law is not None and law.asks for law in laws)


@physics("jamming")
def jamming_margin(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    speed: Scalar,
    load: Scalar | None = None,
) -> Scalar:
    """What is left of the axial balance's bracket, `1 − μ / μ_jam`, the smallest of all stages.

    1 without friction; at 0 the driving screw jams. Finite and differentiable there and beyond.

    **Arguments:**

    - `mechanism`, `kinematics`: the mechanism and its kinematics.
    - `speed`: screw speed, on which friction may depend [rad/s].
    - `load`: on the last nut; needed only by laws that ask for it (`friction_needs_load`) [N].
    """
    margins = []
    for stage, geometry in zip(mechanism.stages, kinematics, strict=True):
        friction = _effective_coefficient(stage, geometry, speed, load)
        margins.append(1 - friction / jamming_coefficient(geometry))
    return functools.reduce(jnp.minimum, margins)


def _scaled(mechanism: Mechanism, factor: Scalar) -> Mechanism:
    """The mechanism with all friction times a factor."""
    stages = [i for i, stage in enumerate(mechanism.stages) if stage.friction is not None]

    def frictions(one: Mechanism) -> list:
        return [one.stages[i].friction for i in stages]

    scaled = [scaled_friction(friction, factor) for friction in frictions(mechanism)]
    return eqx.tree_at(frictions, mechanism, scaled)


@physics("self_locking")
def self_locking_margin(
    mechanism: Mechanism, kinematics: tuple[StageKinematics, ...], speed: Scalar, load: Scalar
) -> tuple[Scalar, Bool[Array, ""]]:
    """How far friction is from holding the load, `1 − 1/s`.

    s is the factor by which all friction of the mechanism would have to grow for the load not to
    turn the screw: 1 without friction, positive where the load drives the screw back, 0 at the
    limit, negative where it holds by itself. For threads alone `1 − μ/μ_lock`.

    **Arguments:**

    - `mechanism`, `kinematics`: the mechanism and its kinematics.
    - `speed`, `load`: at which friction is evaluated [rad/s, N].

    **Returns:** the margin, and whether the factor was found (it is not where some friction does
    not grow enough to hold, or where with so much of it the carriers are out of balance).
    """
    if len(mechanism.stages) == 1 and _proportional_to_force(mechanism.stages[0].friction):
        stage, geometry = mechanism.stages[0], kinematics[0]
        ratio = _effective_coefficient(stage, geometry, speed, load)
        ratio = ratio / locking_coefficient(geometry)
        return 1 - ratio, jnp.asarray(True)
    kinematics = tuple(dataclasses.replace(k, resistance=None) for k in kinematics)
    load, speed = some_load(jnp.abs(load)), jnp.abs(speed)
    frictionless = load * travel_per_turn(mechanism.stages, len(mechanism.stages))

    def driven_back(logarithm: Scalar) -> SteadyState:
        moved = _scaled(mechanism, jnp.exp(logarithm))
        return steady_state(moved, -speed, load, kinematics, onset=-1.0)

    def holding(logarithm: Scalar) -> Scalar:
        """Torque that the load still has at the screw, relative to that without friction."""
        return driven_back(logarithm).drive_torque / frictionless

    # Torque against friction is nearly a hyperbola, 1 − s μ/μ_lock over 1 + s μ/μ_jam.
    now = holding(jnp.zeros_like(load))
    start = jnp.log(jnp.clip(1 / jnp.clip(1 - now, 1e-3, 1e3), 1e-2, 1e2))
    accuracy = 1e-12 if start.dtype == jnp.float64 else 1e-5
    logarithm, found = find_root(holding, start, tolerance=accuracy, max_steps=40)
    # Thread friction may not suffice to drive carriers whose losses have grown as well.
    found = found & driven_back(logarithm).computed
    none = jax.lax.stop_gradient(now) >= 1
    return jnp.where(none, 1.0, 1 - jnp.exp(-logarithm)), found | none
