"""Steady state of rollers that slide on the screw and in the nut: recirculating roller screws.

Grooves have no lead, so a roller advances over screw and nut, and slides on both. Two speeds are
unknown, that of the carrier, ω, and that of the roller against it, σ. With the contact points
(x, y) of both sides, the roller's axis at (a, 0) and the lead over 2π, h, the slips of screw and
nut over the roller are, in the carrier's frame,

    v_s = (Ω − ω) (−y_s, x_s, h) − σ (−y_s, x_s − a, 0)
    v_n =      −ω (−y_n, x_n, h) − σ (−y_n, x_n − a, 0).

Neither speed changes the nut's travel, so friction alone balances: with the friction forces f on
the roller, `f_s·∂v_s/∂ω + f_n·∂v_n/∂ω = 0`, and the same for σ. The time in which a cam lifts a
roller back is neglected: all rollers carry load at all times.
"""

import contextlib
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..._errors import MissingDataError
from ...fields import Scalar
from ...friction import FrictionLaw
from ...geometry import ThreadContact
from ...mechanism import Stage, mean_roller_mass
from ...numerics import dot_few, length_few, root_or_zero
from ...programs import physics
from .._kinematics import StageKinematics
from ..forces import ScrewForces
from ..friction import has_contact_losses, slip_direction, thread_friction
from ._root_search import find_roots_and
from ._unloaded import scaled


class SlidingSide(NamedTuple):
    """Slip, normal force and friction of one side of a roller."""

    slip: Float[Array, "3"]
    direction: Float[Array, "3"]
    #: Normal force on the roller, and its friction [N].
    force: Scalar
    friction: Float[Array, "3"]
    on_roller: Float[Array, "3"]
    #: Axial part of normal force and of the friction in proportion to it, over the normal force
    #: and over its axial part [1]: 1 without such friction, 0 where the contact jams.
    share: Scalar


class TwoSides(NamedTuple):
    """Steady motion and forces of one roller, in the frame of the loaded flank."""

    #: ω/Ω and σ/Ω.
    carrier_ratio: Scalar
    spin_ratio: Scalar
    screw: SlidingSide
    nut: SlidingSide
    converged: Bool[Array, ""]

    def scaled(self, factor: Scalar) -> "TwoSides":
        """The same motion with all forces times a factor."""

        def of(side: SlidingSide) -> SlidingSide:
            forces = scaled((side.force, side.friction, side.on_roller), factor)
            return SlidingSide(side.slip, side.direction, *forces, side.share)

        return self._replace(screw=of(self.screw), nut=of(self.nut))


class SideSlips(NamedTuple):
    """Slip of one side per radian: of the screw, and its changes with ω and σ [m/rad]."""

    per_screw: Float[Array, "3"]
    per_carrier: Float[Array, "3"]
    per_spin: Float[Array, "3"]
    #: Axial part of the unit normal into the roller.
    normal: Float[Array, "3"]

    def at(self, carrier: Scalar, spin: Scalar) -> Float[Array, "3"]:
        """Slip at ω/Ω and σ/Ω, per radian of the screw."""
        return self.per_screw + carrier * self.per_carrier + spin * self.per_spin


def _side_slips(contact: ThreadContact, distance: Scalar, lead: Scalar, turns: bool) -> SideSlips:
    x = contact.contact_radius * jnp.cos(contact.contact_angle_position)
    y = contact.contact_radius * jnp.sin(contact.contact_angle_position)
    zero = jnp.zeros_like(y)
    around = jnp.stack([-y, x, lead])
    own = around if turns else jnp.zeros_like(around)
    return SideSlips(own, -around, -jnp.stack([-y, x - distance, zero]), contact.normal)


def slips_of_both_sides(stage: Stage, kinematics: StageKinematics) -> tuple[SideSlips, SideSlips]:
    """Slips of screw and nut over a roller, as in the text above."""
    distance, lead = stage.thread.centre_distance, stage.thread.lead / (2 * jnp.pi)
    meshing = kinematics.meshing
    return (
        _side_slips(meshing.screw, distance, lead, True),
        _side_slips(meshing.nut, distance, lead, False),
    )


def sliding_side(
    law: FrictionLaw | None,
    slips: SideSlips,
    turn: Float[Array, "3"],
    speed: Scalar,
    sense: Scalar,
    axial: Scalar,
) -> SlidingSide:
    """Forces of one side.

    `turn` is the slip per radian of a screw that turns at `speed` in a sense, `axial` the axial
    force of the body on one roller [N].
    """
    velocity, direction = speed * turn, sense * slip_direction(turn)
    per_force, constant = thread_friction(law, velocity, direction)
    share = 1 + per_force[2] / slips.normal[2]
    force = (axial - constant[2]) / (slips.normal[2] * share)
    friction = force * per_force + constant
    on_roller = force * slips.normal + friction
    return SlidingSide(velocity, direction, force, friction, on_roller, share)


def check_losses(stage: Stage) -> None:
    """**Raises:** `MissingDataError` for losses that are not known where rollers slide twice."""
    law = stage.thread_law
    if has_contact_losses(stage.friction) or (law is not None and (law.asks or law.has_state)):
        raise MissingDataError(
            f"the steady state of a {stage.type} roller screw is known for thread friction that "
            "depends on the slip speed alone; remove spin and rolling_hysteresis from "
            "stage.friction, and choose Coulomb, Stribeck or viscous friction of the threads"
        )


@physics("two_sliding_sides")
def two_sliding_sides(
    stage: Stage, kinematics: StageKinematics, speed: Scalar, sense: Scalar, axial_force: Scalar
) -> TwoSides:
    """Carrier ratio, spin and forces at which friction on both sides balances.

    Without friction any ratio is in balance; it is then that of vanishing equal friction.

    **Arguments:**

    - `stage`, `kinematics`: the stage and its meshing.
    - `speed`, `sense`: Ω [rad/s] and its sense, +1 or −1, known at standstill too.
    - `axial_force`: of all rollers together, in the frame of the loaded flank [N].

    **Raises:** `MissingDataError` for losses other than thread friction by the slip speed.
    """
    check_losses(stage)
    thread, law = stage.thread, stage.thread_law
    distance, lead = thread.centre_distance, thread.lead / (2 * jnp.pi)
    sides = slips_of_both_sides(stage, kinematics)
    axial = axial_force / stage.present_roller_count
    start = thread.ideal_carrier_ratio
    start_spin = -thread.rolling_ratio * start
    # Where the slip turns: its axial part over the change of its transverse part.
    narrow = lead / distance

    def at(unknowns: Float[Array, "2"]):
        carrier = start + unknowns[0] * narrow
        spin = start_spin + unknowns[1] * narrow
        turns = [one.at(carrier, spin) for one in sides]
        screw = sliding_side(law, sides[0], turns[0], speed, sense, -axial)
        nut = sliding_side(law, sides[1], turns[1], speed, sense, axial)
        pushes = [
            sense * side.friction if law is not None else side.force * slip_direction(turn)
            for side, turn in zip((screw, nut), turns, strict=True)
        ]
        size = sum(length_few(push) for push in pushes)
        size = jnp.where(size > 0, size, 1.0)
        balance = [
            sum(dot_few(push, getattr(one, name)) for push, one in zip(pushes, sides, strict=True))
            for name in ("per_carrier", "per_spin")
        ]
        reach = jnp.stack([distance, thread.roller_radius])
        return jnp.stack(balance) / (reach * size), (carrier, spin, screw, nut)

    accuracy = 1e-10 if start.dtype == jnp.float64 else 1e-4
    guess = jnp.zeros((2,), start.dtype)
    _, converged, (carrier, spin, screw, nut) = find_roots_and(
        at, guess, tolerance=accuracy, max_steps=40
    )
    return TwoSides(carrier, spin, screw, nut, converged)


def torque_on_screw(kinematics: StageKinematics, count: Scalar | int, side: SlidingSide) -> Scalar:
    """Torque of all rollers on the screw about its axis [N·m]."""
    contact = kinematics.meshing.screw
    angle = contact.contact_angle_position
    arm = contact.contact_radius * jnp.stack([-jnp.sin(angle), jnp.cos(angle)])
    return -count * dot_few(arm, side.on_roller[:2])


def losses_of_both_sides(
    stage: Stage, screw: SlidingSide, nut: SlidingSide, forces: ScrewForces, speed: Scalar
) -> dict[str, Scalar]:
    """Power of every modelled loss by name, at a screw speed [W]."""
    powers: dict[str, Scalar] = {}
    if stage.thread_law is not None:
        both = [dot_few(side.friction, side.slip) for side in (screw, nut)]
        powers["thread_sliding"] = stage.present_roller_count * (both[0] + both[1])
    if forces.bearing_torque is not None:
        powers["thrust_bearing"] = forces.bearing_torque * speed
    if forces.drag_torque is not None:
        powers["drag"] = forces.drag_torque * speed
    return powers


def pin_force(stage: Stage, sides: TwoSides, speed: Scalar) -> Scalar:
    """Force of one carrier pin on one end of a roller, with the centripetal force if masses are
    known [N].
    """
    total = sides.screw.on_roller + sides.nut.on_roller
    radial = -total[0]
    with contextlib.suppress(MissingDataError):
        mass = mean_roller_mass(stage)
        carrier = sides.carrier_ratio * speed
        radial = radial - mass * carrier**2 * stage.thread.centre_distance
    return root_or_zero((radial / 2) ** 2 + (total[1] / 2) ** 2)
