"""Carrier speed at which the rollers of a stage are in balance, without integration."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..._errors import MissingDataError
from ...fields import Scalar
from ...mechanism import Stage
from ...numerics import above_or_nan, dot_few, length_few, root_or_zero, sum_few
from ...programs import physics
from .._kinematics import StageKinematics, free_carrier_ratio
from ..forces import Motion
from ..friction import (
    ScrewContact,
    Slip,
    has_contact_losses,
    has_unknown_share,
    resisting_moments,
    screw_contact,
    slip_direction,
)
from ._root_search import find_roots_and

#: Largest share of the friction that may drive an accelerating carrier. Where the load passes
#: through zero there is no friction to drive it: it then coasts for an instant, out of balance.
_LARGEST_SHARE = 0.9


class SlipPerTurn(NamedTuple):
    """Slip per radian of screw turn, by its parts along d and across it.

    `(ζ∞ − ζ) d + (v₀ × d) d⊥/|d|²`: the difference `v₀ − ζ d` itself is rounding noise at small
    leads, where the contact moves by millimetres per radian and slips by nanometres.
    """

    #: ∂/∂ω of the velocity of the roller's contact point, d [m/rad].
    drive: Float[Array, "2"]
    #: The part across d [m/rad].
    across: Float[Array, "2"]
    #: Axial part [m/rad].
    axial: Float[Array, "1"]
    #: ζ∞, the carrier ratio without resistance.
    free_ratio: Scalar
    #: Axial part of d; `None` where it is 0 [m/rad].
    axial_drive: Scalar | None = None

    def at(self, lag: Scalar | None) -> Float[Array, "3"]:
        """Slip at ζ = ζ∞ − lag; `None` is no lag [m/rad]."""
        in_plane = self.across if lag is None else self.across + lag * self.drive
        axial = self.axial
        if self.axial_drive is not None and lag is not None:
            axial = axial + lag * self.axial_drive
        return jnp.concatenate([in_plane, axial])


def slip_per_turn(kinematics: StageKinematics) -> SlipPerTurn:
    """The parts of the slip per radian of screw turn."""
    drive = kinematics.drive
    if kinematics.axial_drive is not None:
        return _slip_in_space(kinematics, kinematics.axial_drive)
    across = kinematics.crossing / dot_few(drive, drive) * jnp.stack([drive[1], -drive[0]])
    return SlipPerTurn(drive, across, kinematics.slip_per_screw[2:], free_carrier_ratio(kinematics))


def _slip_in_space(kinematics: StageKinematics, axial_drive: Scalar) -> SlipPerTurn:
    """The parts of a slip whose axial part changes with the carrier speed as well.

    With v₀ = (−y, x, h) and d = v₀ + κ (y, a − x, 0) it is `v₀ × d = κ (h (x − a), h y, −a y)`; the
    part of v₀ across d is `d × (v₀ × d)/|d|²`, without a difference of nearly equal numbers.
    """
    in_plane, lead = kinematics.drive, kinematics.slip_per_screw[2]
    aside = (in_plane - kinematics.slip_per_screw[:2]) * lead
    drive = jnp.concatenate([in_plane, axial_drive[None]])
    crossing = jnp.stack([-aside[1], aside[0], kinematics.crossing])
    square = dot_few(drive, drive)
    across = jnp.cross(drive, crossing) / square
    free = free_carrier_ratio(kinematics)
    return SlipPerTurn(in_plane, across[:2], across[2:], free, axial_drive)


def free_slip(kinematics: StageKinematics, speed: Scalar, sense: Scalar) -> Slip:
    """Slip of a carrier without resistance; its direction has no part along d."""
    turn = slip_per_turn(kinematics).at(None)
    direction = sense * slip_direction(turn)
    return Slip(speed * turn, direction, speed, speed * free_carrier_ratio(kinematics))


def steady_motion(
    kinematics: StageKinematics,
    ratio: Scalar,
    speed: Scalar,
    sense: Scalar,
    axial_acceleration: Scalar | None = None,
    share: Scalar | None = None,
    contact: ScrewContact | None = None,
    slip: Slip | None = None,
) -> Motion:
    """Motion at a carrier ratio; at standstill with the directions of impending motion.

    The slip, the share of the normal force that carries axially, and the contact of the screw side
    are passed where they are known.
    """
    if slip is None:
        turns = slip_per_turn(kinematics)
        turn = turns.at(turns.free_ratio - ratio)
        slip = Slip(speed * turn, sense * slip_direction(turn), speed, speed * ratio)
    turning = sense if kinematics.spin_sense > 0 else -sense
    return Motion(
        screw_speed=speed,
        carrier_speed=speed * ratio,
        slip=slip.velocity,
        direction=slip.direction,
        screw_sense=turning,
        nut_sense=turning,
        axial_acceleration=axial_acceleration,
        share=share,
        contact=contact,
    )


class CarrierPoint(NamedTuple):
    """State at an assumed carrier speed; it is the motion where `residual` vanishes."""

    #: Carrier ratio ω/Ω.
    ratio: Scalar
    slip: Slip
    contact: ScrewContact
    #: Zero in balance, and of order one.
    residual: Scalar
    #: Whether friction can drive the carrier.
    suffices: Bool[Array, ""]


class CarrierBalance(eqx.Module):
    """The balance of one stage's carrier, `N f·d = N (n − 1)(T_s + T_n) + I ζ Ω̇`.

    The slip v = v₀ − ζ d changes with the carrier ratio ζ only along d, and friction is parallel to
    it. So with the slip's component s along d and the remaining component q, the resistance is the
    share `s/√(s² + q²)` of `‖f‖ |d|`, for any law of friction. Spin turns friction slightly away
    from the slip; this part is subtracted from the share. The unknown is `t = s/q`.

    Where almost no load is left to drive an accelerating carrier, the share is limited. The carrier
    is then out of balance, but the energy still balances.

    **Raises:** `MissingDataError` if there is no thread friction.
    """

    stage: Stage
    kinematics: StageKinematics
    sense: Scalar
    speed: Scalar
    axial_force: Scalar
    inertia_per_ratio: Scalar | None
    #: Parts of the slip that do not change with the carrier ratio, evaluated outside the search.
    turns: SlipPerTurn
    #: (ζ∞ − ζ)/t.
    lag_per_tangent: Scalar

    def __check_init__(self) -> None:
        if self.stage.friction is None or self.stage.friction.thread is None:
            raise MissingDataError(
                "spin, rolling losses and inertia resist the rollers, and the load drives them "
                "where the nut has grooves; only thread friction can drive them or hold them: "
                "give [stage.friction.thread]"
            )

    def at(self, tangent: Scalar, share: Scalar | None = None) -> CarrierPoint:
        """State at `t`, and at a share of the normal force that carries, where that is unknown."""
        stage, kinematics = self.stage, self.kinematics
        lag = tangent * self.lag_per_tangent
        ratio, turn = self.turns.free_ratio - lag, self.turns.at(lag)
        direction = self.sense * slip_direction(turn)
        axial = self.axial_force / stage.present_roller_count
        slip = Slip(self.speed * turn, direction, self.speed, self.speed * ratio)
        contact = screw_contact(stage, kinematics, slip, axial, share=share)
        needed, suffices = self._drive_share(ratio, direction, contact)
        residual = tangent - jnp.sqrt(1 + tangent**2) * needed
        return CarrierPoint(ratio, slip, contact, residual, suffices)

    def _drive_share(
        self, ratio: Scalar, direction: Float[Array, "3"], contact: ScrewContact
    ) -> tuple[Scalar, Bool[Array, ""]]:
        """Resistance over the largest possible drive by friction, and whether friction suffices."""
        stage, kinematics, laws = self.stage, self.kinematics, self.stage.friction
        assert laws is not None
        force, per_force, constant, rub, _ = contact
        normal = kinematics.sliding.normal
        friction = force * per_force + constant
        resisting = jnp.zeros_like(ratio)
        if has_contact_losses(laws):
            nut_force = -(force * normal + friction)[2] / kinematics.rolling.normal[2]
            screw, nut = resisting_moments(stage, kinematics, force, nut_force, rub)
            resisting = kinematics.relative_spin_ratio * self.sense * (screw.total + nut.total)
            if kinematics.spin_sense < 0:
                resisting = -resisting
        if kinematics.axial_drive is not None:
            # The load drives the carrier.
            load = self.axial_force / stage.present_roller_count
            resisting = resisting - kinematics.axial_drive * load
        if self.inertia_per_ratio is not None:
            resisting = resisting + self.inertia_per_ratio * ratio / stage.present_roller_count
        square = sum_few(friction**2)
        rubs = above_or_nan(square)
        length = root_or_zero(square)
        reach = kinematics.reach
        largest = length * reach
        # The tangent refers to positive speed; friction changes sign with the sense.
        resisting = self.sense * resisting
        deviation_share = jnp.zeros_like(resisting)
        if rub is not None:
            # With spin, friction is not quite parallel to the slip.
            deviation = friction / jnp.where(rubs, length, 1.0) - direction
            deviation_share = jnp.where(rubs, self.sense * kinematics.along(deviation) / reach, 0.0)
        if self.inertia_per_ratio is None:
            share = jnp.where(rubs, resisting / jnp.where(rubs, largest, 1.0), 0.0)
            suffices = rubs | (resisting == 0)
            if kinematics.axial_drive is not None:
                # The load may exceed all that friction can hold.
                suffices = suffices & (jnp.abs(share) < 1)
            return share - deviation_share, suffices
        suffices = jnp.abs(resisting) < _LARGEST_SHARE * largest
        share = resisting / jnp.where(suffices, largest, 1.0)
        limit = _LARGEST_SHARE * jnp.sign(resisting)
        return jnp.where(suffices, share - deviation_share, limit), jnp.asarray(True)


def carrier_balance(
    stage: Stage,
    kinematics: StageKinematics,
    sense: Scalar,
    speed: Scalar,
    axial_force: Scalar,
    inertia_per_ratio: Scalar | None,
) -> CarrierBalance:
    """The balance of one stage's carrier; arguments as in `balanced_carrier_ratio`."""
    drive, turns = kinematics.drive, slip_per_turn(kinematics)
    if kinematics.axial_drive is None:
        square = dot_few(drive, drive)
        across = jnp.sqrt(kinematics.crossing**2 + kinematics.slip_per_screw[2] ** 2 * square)
        lag = across / square
    else:
        lag = length_few(turns.at(None)) / kinematics.reach
    return CarrierBalance(
        stage, kinematics, sense, speed, axial_force, inertia_per_ratio, turns, lag
    )


class BalancedCarrier(NamedTuple):
    """Carrier ratio ω/Ω in balance, and whether friction suffices for it."""

    ratio: Scalar
    converged: Bool[Array, ""]
    #: Slip and contact of the screw side, if solved for with the ratio; `None` for a carrier
    #: without resistance.
    slip: Slip | None = None
    contact: ScrewContact | None = None

    def motion(
        self,
        kinematics: StageKinematics,
        speed: Scalar,
        sense: Scalar,
        axial_acceleration: Scalar | None = None,
    ) -> Motion:
        """Motion in balance, at the speed and sense for which the balance was solved."""
        return steady_motion(
            kinematics,
            self.ratio,
            speed,
            sense,
            axial_acceleration,
            slip=self.slip or free_slip(kinematics, speed, sense),
            contact=self.contact,
        )


def balanced_carrier_ratio(
    stage: Stage,
    kinematics: StageKinematics,
    sense: Scalar,
    speed: Scalar,
    axial_force: Scalar,
    inertia_per_ratio: Scalar | None = None,
) -> BalancedCarrier:
    """Carrier ratio ω/Ω at which thread friction balances the resistance of the rollers.

    Without contact losses and inertia, friction has no component along d, and the ratio depends on
    geometry alone. Otherwise Newton's method solves the `CarrierBalance`.

    **Arguments:**

    - `stage`, `kinematics`: the stage and its meshing.
    - `sense`: sense of turning, +1 or −1.
    - `speed`: screw speed Ω; may be 0 unless friction vanishes with the slip [rad/s].
    - `axial_force`: axial force of all rollers together [N].
    - `inertia_per_ratio`: I Ω̇, the generalised inertia force per carrier ratio [N·m]; `None` in a
      steady state.

    **Raises:** `MissingDataError` if there is resistance but no thread friction.
    """
    driven = inertia_per_ratio is not None or kinematics.axial_drive is not None
    if not has_contact_losses(stage.friction) and not driven:
        return BalancedCarrier(free_carrier_ratio(kinematics), jnp.asarray(True))
    balance = carrier_balance(stage, kinematics, sense, speed, axial_force, inertia_per_ratio)
    return _balanced(balance)


@physics("carrier_balance")
def _balanced(balance: CarrierBalance) -> BalancedCarrier:
    """Carrier ratio and, where unknown, share of the normal force, solved together.

    A root search within a root search would be a large program.
    """
    start = jnp.zeros_like(balance.axial_force)
    shared = has_unknown_share(balance.stage, balance.kinematics)

    def residuals(unknowns):
        point = balance.at(unknowns[0], unknowns[1] if shared else None)
        axial_residual = [] if point.contact.residual is None else [point.contact.residual]
        return jnp.stack([point.residual, *axial_residual]), point

    shares = [-balance.kinematics.sliding.normal[2]] if shared else []
    accuracy = 1e-10 if start.dtype == jnp.float64 else 1e-4
    _, converged, point = find_roots_and(
        residuals, jnp.stack([start, *shares]), tolerance=accuracy, max_steps=30
    )
    return BalancedCarrier(point.ratio, converged & point.suffices, point.slip, point.contact)
