"""Which carrier speed balances the rollers of a stage, without integrating anything."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .._errors import MissingDataError
from .._physics import physics
from .._root import find_root
from ..mechanism import Scalar, Stage
from ._contact_losses import has_contact_losses, resisting_moments
from ._kinematics import StageKinematics, free_carrier_ratio
from ._stage_forces import Motion
from ._thread_friction import normal_force, slip_direction, thread_friction

#: Share of the friction that may drive a carrier which accelerates. Where the load passes through
#: zero no friction is left for that: the carriers then coast for an instant, out of balance.
_LARGEST_SHARE = 0.9


def unit_slip(kinematics: StageKinematics, ratio: Scalar) -> Float[Array, "3"]:
    """Slip per radian of screw turn at a carrier ratio [m/rad]."""
    in_plane = kinematics.slip_per_screw[:2] - ratio * kinematics.drive
    return jnp.concatenate([in_plane, kinematics.slip_per_screw[2:]])


def steady_motion(
    kinematics: StageKinematics,
    ratio: Scalar,
    speed: Scalar,
    sense: Scalar,
    axial_acceleration: Scalar | None = None,
) -> Motion:
    """Motion at a carrier ratio; at standstill with the directions of that about to begin."""
    turn = unit_slip(kinematics, ratio)
    return Motion(
        screw_speed=speed,
        carrier_speed=speed * ratio,
        slip=speed * turn,
        direction=sense * slip_direction(turn),
        screw_sense=sense,
        nut_sense=sense,
        axial_acceleration=axial_acceleration,
    )


def balanced_carrier_ratio(
    stage: Stage,
    kinematics: StageKinematics,
    sense: Scalar,
    speed: Scalar,
    axial_force: Scalar,
    inertia_per_ratio: Scalar | None = None,
) -> tuple[Scalar, Bool[Array, ""]]:
    """Carrier ratio ω/Ω at which thread friction drives the rollers as it must.

    Without contact losses and inertia friction has no component along d: geometry alone decides.
    Otherwise `N f·d = N (n − 1)(T_s + T_n) + I ζ Ω̇`. The slip v = v₀ − ζ d changes with the ratio ζ
    only along d. Friction is parallel to it, so with the slip's component s along d and the rest q,
    `s/√(s² + q²)` is the share that the resistance is of `‖f‖ |d|`. `t = s/q` is found by Newton,
    for any law of friction. Where next to no load is left to drive what accelerates, the ratio is
    limited; nothing is lost by that but the balance, and the energy still balances.

    **Arguments:**

    - `stage`, `kinematics`: the stage and its meshing.
    - `sense`: sense of turning, +1 or −1.
    - `speed`: screw speed Ω; may be 0 unless friction vanishes with the slip [rad/s].
    - `axial_force`: what the rollers together carry axially [N].
    - `inertia_per_ratio`: I Ω̇, the generalised inertia force per carrier ratio [N·m]; `None` in a
      steady state.

    **Returns:** the ratio, and whether friction suffices.

    **Raises:** `MissingDataError` if there is resistance but no thread friction.
    """
    free = free_carrier_ratio(kinematics)
    losses = has_contact_losses(stage.friction)
    if not losses and inertia_per_ratio is None:
        return free, jnp.asarray(True)
    return _balanced(stage, kinematics, sense, speed, axial_force, inertia_per_ratio, free, losses)


@physics("carrier_balance")
def _balanced(stage, kinematics, sense, speed, axial_force, inertia_per_ratio, free, losses):
    law = None if stage.friction is None else stage.friction.thread
    if law is None:
        raise MissingDataError(
            "spin, rolling losses and inertia resist the rollers, and only thread friction can "
            "drive them; give [stage.friction.thread]"
        )
    drive, slip = kinematics.drive, kinematics.slip_per_screw
    length = jnp.sqrt(drive @ drive)
    # A cross product: at small leads the slip is nearly all along d, and slip² − along² is noise.
    across = (slip[0] * drive[1] - slip[1] * drive[0]) / length
    across = jnp.sqrt(across**2 + slip[2] ** 2)
    count = stage.present_roller_count

    def ratio_at(tangent: Scalar) -> Scalar:
        return free - tangent * across / length

    def share_at(tangent: Scalar) -> tuple[Scalar, Bool[Array, ""]]:
        """Resistance over the largest drive that friction has; and whether there is friction."""
        ratio = ratio_at(tangent)
        turn = unit_slip(kinematics, ratio)
        per_force, constant = thread_friction(law, speed * turn, sense * slip_direction(turn))
        normal = kinematics.meshing.screw.normal
        force = normal_force(normal, per_force, constant, axial_force / count)
        friction = force * per_force + constant
        resisting = jnp.zeros_like(tangent)
        if losses:
            nut_force = -(force * normal + friction)[2] / kinematics.meshing.nut.normal[2]
            screw, nut = resisting_moments(stage, kinematics, force, nut_force)
            resisting = kinematics.relative_spin_ratio * sense * (screw.total + nut.total)
        if inertia_per_ratio is not None:
            resisting = resisting + inertia_per_ratio * ratio / count
        square = jnp.sum(friction**2)
        rubs = square > 0
        largest = jnp.where(rubs, jnp.sqrt(jnp.where(rubs, square, 1.0)), 0.0) * length
        # The tangent counts the slip at positive speed; friction turns with the sense.
        resisting = sense * resisting
        if inertia_per_ratio is None:
            share = jnp.where(rubs, resisting / jnp.where(rubs, largest, 1.0), 0.0)
            return share, rubs | (resisting == 0)
        suffices = jnp.abs(resisting) < _LARGEST_SHARE * largest
        share = resisting / jnp.where(suffices, largest, 1.0)
        limit = _LARGEST_SHARE * jnp.sign(resisting)
        return jnp.where(suffices, share, limit), jnp.asarray(True)

    def residual(tangent: Scalar) -> Scalar:
        return tangent - jnp.sqrt(1 + tangent**2) * share_at(tangent)[0]

    start = jnp.zeros_like(free)
    accuracy = 1e-13 if free.dtype == jnp.float64 else 1e-5
    tangent, found = find_root(residual, start, tolerance=accuracy, max_steps=20)
    return ratio_at(tangent), found & share_at(tangent)[1]
