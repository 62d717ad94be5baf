"""Which carrier speed balances the rollers of a stage, without integrating anything."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .._errors import MissingDataError
from .._guards import above_or_nan
from .._physics import physics
from .._root import find_root
from ..mechanism import Scalar, Stage
from ._contact_losses import has_contact_losses, resisting_moments
from ._kinematics import StageKinematics, free_carrier_ratio
from ._rubbing import ScrewContact, Slip, rubbing_of, screw_contact
from ._small_newton import find_roots
from ._stage_forces import Motion
from ._thread_friction import slip_direction

#: Share of the friction that may drive a carrier which accelerates. Where the load passes through
#: zero no friction is left for that: the carriers then coast for an instant, out of balance.
_LARGEST_SHARE = 0.9


def unit_slip(
    kinematics: StageKinematics, ratio: Scalar | None = None, lag: Scalar | None = None
) -> Float[Array, "3"]:
    """Slip per radian of screw turn at a carrier ratio ζ [m/rad].

    Its part along d and that across it, `(ζ∞ − ζ) d + (v₀ × d) d⊥/|d|²`. The difference `v₀ − ζ d`
    itself is noise at small leads, where the contact moves by millimetres per radian and slips by
    nanometres.

    **Arguments:**

    - `kinematics`: of the stage.
    - `ratio`: carrier ratio ζ; that of a carrier which nothing resists if absent.
    - `lag`: ζ∞ − ζ, where it is known better than by subtraction.
    """
    drive, slip = kinematics.drive, kinematics.slip_per_screw
    in_plane = kinematics.crossing / (drive @ drive) * jnp.stack([drive[1], -drive[0]])
    if lag is None and ratio is not None:
        lag = free_carrier_ratio(kinematics) - ratio
    if lag is not None:
        in_plane = in_plane + lag * drive
    return jnp.concatenate([in_plane, slip[2:]])


def steady_motion(
    kinematics: StageKinematics,
    ratio: Scalar,
    speed: Scalar,
    sense: Scalar,
    axial_acceleration: Scalar | None = None,
    share: Scalar | None = None,
    contact: ScrewContact | None = None,
    lag: Scalar | None = None,
) -> Motion:
    """Motion at a carrier ratio; at standstill with the directions of that about to begin.

    With the share of the normal force that carries, or all of the screw side, where that is known;
    `lag` is as in `unit_slip`.
    """
    turn = unit_slip(kinematics, ratio, lag)
    return Motion(
        screw_speed=speed,
        carrier_speed=speed * ratio,
        slip=speed * turn,
        direction=sense * slip_direction(turn),
        screw_sense=sense,
        nut_sense=sense,
        axial_acceleration=axial_acceleration,
        share=share,
        contact=contact,
    )


class CarrierBalance(eqx.Module):
    """The balance of one stage's carrier, `N f·d = N (n − 1)(T_s + T_n) + I ζ Ω̇`.

    The slip v = v₀ − ζ d changes with the carrier ratio ζ only along d, and friction is parallel to
    it. So with the slip's component s along d and the rest q, `s/√(s² + q²)` is the share that the
    resistance is of `‖f‖ |d|`, for any law of friction; spin turns friction a little from the slip,
    which is taken off that share. The unknown is `t = s/q`.

    Where next to no load is left to drive what accelerates, the share is limited; nothing is lost
    by that but the balance, and the energy still balances.

    **Raises:** `MissingDataError` if there is no thread friction.
    """

    stage: Stage
    kinematics: StageKinematics
    sense: Scalar
    speed: Scalar
    axial_force: Scalar
    inertia_per_ratio: Scalar | None

    def __check_init__(self):
        if self.stage.friction is None or self.stage.friction.thread is None:
            raise MissingDataError(
                "spin, rolling losses and inertia resist the rollers, and only thread friction can "
                "drive them; give [stage.friction.thread]"
            )

    def lag(self, tangent: Scalar) -> Scalar:
        """By how much the carrier ratio at `t` is below that of a carrier which nothing resists."""
        drive, slip = self.kinematics.drive, self.kinematics.slip_per_screw
        square = drive @ drive
        across = jnp.sqrt(self.kinematics.crossing**2 + slip[2] ** 2 * square)
        return tangent * across / square

    def ratio(self, tangent: Scalar) -> Scalar:
        """Carrier ratio ω/Ω at `t`."""
        return free_carrier_ratio(self.kinematics) - self.lag(tangent)

    def contact(self, tangent: Scalar, share: Scalar | None = None) -> ScrewContact:
        """The screw side at `t`, and where slip and spin are one at a share that carries."""
        stage, kinematics = self.stage, self.kinematics
        turn = unit_slip(kinematics, lag=self.lag(tangent))
        slip = Slip(self.speed * turn, self.sense * slip_direction(turn))
        axial = self.axial_force / stage.present_roller_count
        return screw_contact(stage, kinematics, slip, axial, share=share)

    def _drive_share(
        self, tangent: Scalar, contact: ScrewContact
    ) -> tuple[Scalar, Bool[Array, ""]]:
        """Resistance over the largest drive that friction has; and whether there is enough."""
        stage, kinematics, friction_of = self.stage, self.kinematics, self.stage.friction
        assert friction_of is not None
        ratio, count = self.ratio(tangent), stage.present_roller_count
        direction = self.sense * slip_direction(unit_slip(kinematics, lag=self.lag(tangent)))
        force, per_force, constant, rub, _ = contact
        normal = kinematics.meshing.screw.normal
        friction = force * per_force + constant
        resisting = jnp.zeros_like(tangent)
        if has_contact_losses(friction_of):
            nut_force = -(force * normal + friction)[2] / kinematics.meshing.nut.normal[2]
            screw, nut = resisting_moments(stage, kinematics, force, nut_force, rub)
            resisting = kinematics.relative_spin_ratio * self.sense * (screw.total + nut.total)
        if self.inertia_per_ratio is not None:
            resisting = resisting + self.inertia_per_ratio * ratio / count
        square = jnp.sum(friction**2)
        rubs = above_or_nan(square)
        length = jnp.where(rubs, jnp.sqrt(jnp.where(rubs, square, 1.0)), 0.0)
        reach = jnp.sqrt(kinematics.drive @ kinematics.drive)
        largest = length * reach
        # The tangent counts the slip at positive speed; friction turns with the sense.
        resisting = self.sense * resisting
        aside = jnp.zeros_like(resisting)
        if rub is not None:
            # Across an ellipse that spins, friction is not quite parallel to the slip.
            leaning = friction / jnp.where(rubs, length, 1.0) - direction
            aside = jnp.where(rubs, self.sense * (leaning[:2] @ kinematics.drive) / reach, 0.0)
        if self.inertia_per_ratio is None:
            share = jnp.where(rubs, resisting / jnp.where(rubs, largest, 1.0), 0.0)
            return share - aside, rubs | (resisting == 0)
        suffices = jnp.abs(resisting) < _LARGEST_SHARE * largest
        share = resisting / jnp.where(suffices, largest, 1.0)
        limit = _LARGEST_SHARE * jnp.sign(resisting)
        return jnp.where(suffices, share - aside, limit), jnp.asarray(True)

    def residual(self, tangent: Scalar, contact: ScrewContact) -> Scalar:
        """Zero in balance, and of order one."""
        return tangent - jnp.sqrt(1 + tangent**2) * self._drive_share(tangent, contact)[0]

    def suffices(self, tangent: Scalar, contact: ScrewContact) -> Bool[Array, ""]:
        """Whether friction can drive the carrier."""
        return self._drive_share(tangent, contact)[1]


class BalancedCarrier(NamedTuple):
    """Carrier ratio ω/Ω in balance, and whether friction suffices for it."""

    ratio: Scalar
    found: Bool[Array, ""]
    #: The screw side, where it was found with the ratio.
    contact: ScrewContact | None = None
    #: By how much the ratio is below that of a carrier which nothing resists; `None` if that is it.
    lag: Scalar | None = None

    def motion(
        self,
        kinematics: StageKinematics,
        speed: Scalar,
        sense: Scalar,
        axial_acceleration: Scalar | None = None,
    ) -> Motion:
        """Motion in balance."""
        lag = jnp.zeros_like(self.ratio) if self.lag is None else self.lag
        return steady_motion(
            kinematics,
            self.ratio,
            speed,
            sense,
            axial_acceleration,
            contact=self.contact,
            lag=lag,
        )


def balanced_carrier_ratio(
    stage: Stage,
    kinematics: StageKinematics,
    sense: Scalar,
    speed: Scalar,
    axial_force: Scalar,
    inertia_per_ratio: Scalar | None = None,
) -> BalancedCarrier:
    """Carrier ratio ω/Ω at which thread friction drives the rollers as it must.

    Without contact losses and inertia friction has no component along d: geometry alone decides.
    Otherwise Newton solves the `CarrierBalance`.

    **Arguments:**

    - `stage`, `kinematics`: the stage and its meshing.
    - `sense`: sense of turning, +1 or −1.
    - `speed`: screw speed Ω; may be 0 unless friction vanishes with the slip [rad/s].
    - `axial_force`: what the rollers together carry axially [N].
    - `inertia_per_ratio`: I Ω̇, the generalised inertia force per carrier ratio [N·m]; `None` in a
      steady state.

    **Raises:** `MissingDataError` if there is resistance but no thread friction.
    """
    if not has_contact_losses(stage.friction) and inertia_per_ratio is None:
        return BalancedCarrier(free_carrier_ratio(kinematics), jnp.asarray(True))
    balance = CarrierBalance(stage, kinematics, sense, speed, axial_force, inertia_per_ratio)
    return _balanced(balance)


@physics("carrier_balance")
def _balanced(balance: CarrierBalance) -> BalancedCarrier:
    start = jnp.zeros_like(balance.axial_force)
    if rubbing_of(balance.stage, balance.kinematics) is not None:
        return _balanced_with_force(balance, start)

    # A plain function: JAX wants to hash it, and a method carries arrays.
    def residual(tangent: Scalar) -> Scalar:
        return balance.residual(tangent, balance.contact(tangent))

    accuracy = 1e-13 if start.dtype == jnp.float64 else 1e-5
    tangent, found = find_root(residual, start, tolerance=accuracy, max_steps=20)
    found = found & balance.suffices(tangent, balance.contact(tangent))
    return BalancedCarrier(balance.ratio(tangent), found, lag=balance.lag(tangent))


def _balanced_with_force(balance: CarrierBalance, start: Scalar) -> BalancedCarrier:
    """Carrier and normal force at once: a root within a root would be a large program."""

    def residuals(unknowns):
        tangent, share = unknowns[0], unknowns[1]
        contact = balance.contact(tangent, share)
        assert contact.missed is not None
        return jnp.stack([balance.residual(tangent, contact), contact.missed])

    begin = jnp.stack([start, -balance.kinematics.meshing.screw.normal[2]])
    accuracy = 1e-10 if start.dtype == jnp.float64 else 1e-4
    (tangent, share), found = find_roots(residuals, begin, tolerance=accuracy, max_steps=30)
    contact = balance.contact(tangent, share)
    found = found & balance.suffices(tangent, contact)
    return BalancedCarrier(balance.ratio(tangent), found, contact, balance.lag(tangent))
