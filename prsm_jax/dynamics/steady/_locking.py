"""Jamming and self-locking of threads: limits of the friction coefficient, and margins to them.

A driving screw jams where thread friction cancels the axial part of the normal force: the bracket
of the axial balance, |n_z| − μ v_z/‖v‖, vanishes. A driving load no longer turns its screw where
the moment of friction about the axis reaches that of the normal force. Both limits depend on the
direction of slip. Where rollers have a lead it follows from geometry alone, and both are closed
forms; with the flank angle α they tend to μ → cot α and μ → tan α. Rollers without lead slide as
friction drives them: there the margins are those of the balanced motion.
"""

import dataclasses
import functools
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ...contact import load_of
from ...fields import Scalar
from ...friction import Friction, scaled_friction
from ...mechanism import Mechanism, Stage
from ...numerics import dot_few, find_root_by_secants
from ...programs import physics
from .._kinematics import StageKinematics
from ..friction import law_inputs_of, slip_direction, thread_friction, with_resistance
from ._carrier_balance import balanced_carrier_ratio, free_slip, slip_per_turn
from ._steady import steady_state
from ._steady_result import JAMMED
from ._two_sliding_sides import two_sliding_sides
from ._unloaded import is_proportional, some_load


def _unit(kinematics: StageKinematics):
    """Slip direction of rollers without resistance, with the screw driving."""
    return slip_direction(slip_per_turn(kinematics).at(None))


def jamming_coefficient(kinematics: StageKinematics) -> Scalar:
    """Friction coefficient at which a driving screw jams, |n_z| ‖v‖ / v_z; about cot α."""
    return -kinematics.sliding.normal[2] / _unit(kinematics)[2]


def locking_coefficient(kinematics: StageKinematics) -> Scalar:
    """Friction coefficient above which a load does not turn the screw; about tan α.

    There the moments of normal force and friction about the screw's axis are equal,
    `μ = −(n × r)_z ‖v‖ / (v × r)_z`.
    """
    side, direction = kinematics.sliding, _unit(kinematics)
    angle = side.contact_angle_position
    tangent = jnp.stack([-jnp.sin(angle), jnp.cos(angle)])
    return dot_few(side.normal[:2], tangent) / dot_few(direction[:2], tangent)


def _proportional_to_force(friction: Friction | None) -> bool:
    """Whether thread friction is the only resistance, and is proportional to the normal force."""
    if friction is None:
        return True
    law, others = friction.thread, dataclasses.replace(friction, thread=None)
    alone = all(value is None for value in vars(others).values())
    if law is None:
        return alone
    return alone and is_proportional(law)


def _effective_coefficient(
    stage: Stage, kinematics: StageKinematics, speed: Scalar, load: Scalar | None
) -> Scalar:
    """Friction per normal force at the slip of a screw speed.

    A law that asks for the normal force gets that of the load without friction.
    """
    slip = free_slip(kinematics, jnp.abs(speed), jnp.ones_like(speed))
    law = stage.thread_law
    law_inputs = {}
    if law is not None and law.asks:
        assert load is not None
        normal = -kinematics.sliding.normal[2] * stage.present_roller_count
        (kinematics,) = with_resistance((stage,), (kinematics,))
        law_inputs = law_inputs_of(law, kinematics, slip, jnp.abs(load) / normal)
    per_force, _ = thread_friction(law, slip.velocity, slip.direction, law_inputs)
    return dot_few(per_force, slip.direction)


def friction_needs_load(mechanism: Mechanism) -> bool:
    """Whether friction coefficients of any stage's threads depend on more than the slip speed."""
    laws = [stage.thread_law for stage in mechanism.stages]
    return any(law is not None and law.asks for law in laws)


def friction_sets_motion(mechanism: Mechanism) -> bool:
    """Whether the slip depends on friction: of rollers without lead, which have no closed form."""
    families = [stage.thread.family for stage in mechanism.stages]
    return not all(one.lead_is_fixed and one.carrying is not None for one in families)


@physics("jamming")
def jamming_margin(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    speed: Scalar,
    load: Scalar | None = None,
) -> tuple[Scalar, Bool[Array, ""]]:
    """Remaining share of the axial balance's bracket, `1 − μ / μ_jam`, smallest of all stages.

    1 without friction; at 0 the driving screw jams. Finite and differentiable there and beyond.
    Where friction also sets the motion (rollers without lead) it is that share at the motion in
    balance, smaller of screw and nut; a recirculating roller screw has no balance between the jams
    of its two sides.

    **Arguments:**

    - `mechanism`, `kinematics`: the mechanism and its kinematics.
    - `speed`: screw speed, on which friction may depend [rad/s].
    - `load`: on the last nut; needed only by laws that ask for it (`friction_needs_load`), and by
      rollers without lead [N].

    **Returns:** the margin, and whether it was found: a closed form always is.
    """
    if friction_sets_motion(mechanism):
        return _carrying_share(mechanism, kinematics, jnp.abs(speed), load)
    margins = []
    for stage, geometry in zip(mechanism.stages, kinematics, strict=True):
        friction = _effective_coefficient(stage, geometry, speed, load)
        margins.append(1 - friction / jamming_coefficient(geometry))
    return functools.reduce(jnp.minimum, margins), jnp.asarray(True)


def _carrying_share(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    speed: Scalar,
    load: Scalar | None,
) -> tuple[Scalar, Bool[Array, ""]]:
    """Share of the axial normal force that friction leaves, and whether motion is in balance."""
    (stage,), (geometry,) = mechanism.stages, with_resistance(mechanism.stages, kinematics)
    load = some_load(jnp.abs(load_of(mechanism, load)))
    sense, meshed = jnp.ones_like(load), geometry.meshing.converged
    if stage.thread_law is None:
        return sense, meshed
    if stage.thread.family.carrying is None:
        sides = two_sliding_sides(stage, geometry, speed, sense, load)
        return jnp.minimum(sides.screw.share, sides.nut.share), sides.converged & meshed
    balance = balanced_carrier_ratio(stage, geometry, sense, speed, load)
    assert balance.contact is not None
    share = 1 + balance.contact.per_force[2] / geometry.sliding.normal[2]
    return share, balance.converged & meshed


def jams(
    mechanism: Mechanism, kinematics: tuple[StageKinematics, ...], speed: Scalar, load: Scalar
) -> Bool[Array, ""]:
    """Whether the driving screw jams at a speed and under a load.

    By the margin; where friction sets the motion the steady state tells with less work.
    """
    if not friction_sets_motion(mechanism):
        return jamming_margin(mechanism, kinematics, speed, load)[0] <= 0
    if any(stage.thread_law is None for stage in mechanism.stages):
        return jnp.asarray(False)
    return steady_state(mechanism, speed, load, kinematics).code == JAMMED


def _scaled(mechanism: Mechanism, factor: Scalar) -> Mechanism:
    """The mechanism with all friction times a factor."""
    stages = [i for i, stage in enumerate(mechanism.stages) if stage.friction is not None]

    def frictions(one: Mechanism) -> list[Any]:
        return [one.stages[i].friction for i in stages]

    scaled = [scaled_friction(friction, factor) for friction in frictions(mechanism)]
    return eqx.tree_at(frictions, mechanism, scaled)


@physics("self_locking")
def self_locking_margin(
    mechanism: Mechanism, kinematics: tuple[StageKinematics, ...], speed: Scalar, load: Scalar
) -> tuple[Scalar, Bool[Array, ""]]:
    """Margin of friction to self-locking, `1 − 1/s`.

    s is the factor on all friction of the mechanism at which the load no longer turns the screw.
    The margin is 1 without friction, positive where the load drives the screw back, 0 at the limit,
    and negative where the mechanism is self-locking. For threads alone it is `1 − μ/μ_lock`.

    **Arguments:**

    - `mechanism`, `kinematics`: the mechanism and its kinematics.
    - `speed`, `load`: at which friction is evaluated [rad/s, N].

    **Returns:** the margin, and whether the factor was found (it is not where friction does not
    grow enough to hold the load, or where so much friction puts the carriers out of balance).
    """
    if (
        len(mechanism.stages) == 1
        and _proportional_to_force(mechanism.stages[0].friction)
        and not friction_sets_motion(mechanism)
    ):
        stage, geometry = mechanism.stages[0], kinematics[0]
        ratio = _effective_coefficient(stage, geometry, speed, load)
        ratio = ratio / locking_coefficient(geometry)
        return 1 - ratio, jnp.asarray(True)
    load, speed = some_load(jnp.abs(load)), jnp.abs(speed)
    if all(stage.friction is None for stage in mechanism.stages):
        return jnp.ones_like(load), jnp.asarray(True)
    kinematics = tuple(dataclasses.replace(k, resistance=None) for k in kinematics)

    def driven_back(inverse: Scalar) -> tuple[Scalar, Bool[Array, ""]]:
        moved = _scaled(mechanism, 1 / inverse)
        found = steady_state(moved, -speed, load, kinematics, onset=-1.0)
        # The efficiency is nearly (1 − s μ/μ_lock)/(1 + s μ/μ_jam); useful over lost power is then
        # linear in 1/s.
        useful_over_lost = found.efficiency / (1 - found.efficiency)
        # Thread friction may not suffice to drive carriers whose losses have grown as well. Where
        # no friction holds the load the root is negative, where the thread jams.
        return useful_over_lost, found.computed

    def estimate(useful_over_lost: Scalar) -> Scalar:
        # 1/s is 1 less the efficiency where losses are proportional to friction.
        return jnp.clip(1 / (1 + useful_over_lost), 1e-6, 1e2)

    # The error left is about the product of the last two steps.
    accuracy = 1e-9 if load.dtype == jnp.float64 else 1e-5
    inverse, converged, as_given = find_root_by_secants(
        driven_back, jnp.ones_like(load), estimate, tolerance=accuracy, max_steps=60
    )
    rounding = 10 * jnp.finfo(load.dtype).eps
    no_friction = (as_given.value >= 1 / rounding) & as_given.valid
    return jnp.where(no_friction, 1.0, 1 - inverse), converged | no_friction
