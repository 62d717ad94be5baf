"""Masses and springs of one stage whose bodies move in space."""

import dataclasses
import functools
import operator

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import CountOrTraced, Scalar, as_count, plain
from ...geometry import Meshing, ThreadContact, mesh
from ...mechanism import (
    Axis,
    Side,
    Stage,
    Support,
    body_inertia,
    body_mass,
    material_of,
    tilting_inertia,
)
from ...programs import physics
from ...stiffness import ThreadStiffness, ring_roller_stiffness
from ._axis import AxisSystem, axis_system
from ._bodies import SpatialBody, moving_with, nominal_radius, supports
from ._springs import (
    RollerSpring,
    contact_places,
    contact_springs,
    tangential_ratio,
    tangents,
)
from ._tilt import (
    OPPOSITE_CARRIERS,
    opposite_carriers,
    pin_distance,
    teeth_distance,
    thread_spread,
    with_tilt,
)

SIDES: tuple[Side, ...] = ("screw", "nut")


class SpatialSystem(eqx.Module):
    """Masses and springs of a stage with equal, evenly spaced rollers."""

    bodies: tuple[SpatialBody, ...]
    springs: tuple[RollerSpring, ...]
    roller_mass: Scalar
    #: J/r² [kg].
    roller_equivalent_mass: Scalar
    roller_count: CountOrTraced = eqx.field(converter=as_count)
    #: The axis around the stage, which harmonic 0 moves.
    axis: AxisSystem | None = None
    #: Moment of inertia of a roller about a diameter over r² [kg]; `None` if no body tilts.
    roller_tilt_mass: Scalar | None = None

    @property
    def roller_positions(self) -> Float[Array, " rollers"]:
        """Angle of each roller around the screw, φ_i = 2π(i − 1)/N [rad]."""
        count = plain(self.roller_count)
        return 2 * jnp.pi * jnp.arange(count, dtype=self.roller_mass.dtype) / count


def _refuse_asymmetric(stage: Stage) -> None:
    reason = None
    if plain(stage.roller_count) < 3:
        reason = f"roller_count is {plain(stage.roller_count)}"
    elif stage.unequal_roller:
        reason = f"unequal_roller lists roller {stage.unequal_roller[0].number}"
    elif stage.rollers_carry_otherwise:
        reason = "rollers carry different loads by load_sharing.part_errors or free_nut"
    for name in ("screw", "nut", "ring_gear", "carrier"):
        body = getattr(stage, name)
        support: Support | None = None if body is None else body.support
        if support is not None and support.radial_stiffness_y is not None:
            reason = f"{name}.support has radial_stiffness_y"
    if reason is not None:
        raise ValueError(
            f"spatial_modal needs at least 3 equal rollers and supports that are equal in x and y, "
            f"but {reason}; remove it, or use modal, the bending–torsional model"
        )


def _thread_springs(
    stage: Stage,
    threads: ThreadStiffness,
    meshing: Meshing,
    sticking: bool,
    standstill: bool,
    tilt: bool,
) -> list[RollerSpring]:
    thread = stage.thread
    family = thread.family
    sides: tuple[tuple[Side, ThreadContact, Scalar], ...] = (
        ("screw", meshing.screw, threads.screw_roller),
        ("nut", meshing.nut, threads.nut_roller),
    )
    spread = thread_spread(stage) if tilt else None
    normal: list[RollerSpring] = []
    along: list[RollerSpring] = []
    for side, contact, axial_stiffness in sides:
        direction = contact.normal_parts
        stiffness = axial_stiffness / direction[2] ** 2
        places = contact_places(contact, side, family)
        radii = nominal_radius(thread, side), thread.roller_radius
        of_contact = places, radii, spread
        normal += contact_springs(f"{side}_roller", side, stiffness, direction, *of_contact)
        if side in family.sliding and not standstill:
            continue
        if sticking or standstill:
            ratio = tangential_ratio(material_of(stage, "roller"), material_of(stage, side))
            tangential = ratio * stiffness
        else:
            # Springs without stiffness, as for supports that are not given.
            tangential = jnp.zeros_like(stiffness)
        name = f"sticking_{side}_roller"
        for tangent in tangents(direction):
            along += contact_springs(name, side, tangential, tangent, *of_contact)
    return normal + along


def _gear_springs(stage: Stage, stiffness: Scalar, side: Side, tilt: bool) -> list[RollerSpring]:
    """The teeth touch where the pitch circles do, and push along the line of action.

    Teeth of a ring gear push rollers inwards, those of a screw outwards.
    """
    outwards = 1 if side == "screw" else -1
    zero, thread = jnp.zeros_like(stiffness), stage.thread
    radii = nominal_radius(thread, side), thread.roller_radius
    angle = zero if stage.gear is None else stage.gear.pressure_angle
    action = outwards * jnp.sin(angle), jnp.cos(angle), zero
    places = (radii[0], zero), (-outwards * radii[1], zero)
    spread = teeth_distance(stage) if tilt else None
    return contact_springs("ring_roller", side, stiffness, action, places, radii, spread)


def _pin_springs(
    stage: Stage, support: Support, like: Scalar, carrier: str | None, beside: Side, tilt: bool
) -> list[RollerSpring]:
    thread = stage.thread
    one, zero = jnp.ones_like(like), jnp.zeros_like(like)
    still = (zero, zero, zero, zero)
    springs: list[RollerSpring] = []
    if support.radial_stiffness is not None:
        pins = {
            "pin_radial": ((-one, zero, zero, zero), (one, zero, zero, zero)),
            "pin_tangential": ((zero, -one, zero, zero), (zero, one, zero, one)),
        }
        for name, (roller, central) in pins.items():
            stiffness, moved = support.radial_stiffness, still if carrier is None else central
            springs.append(RollerSpring(stiffness, roller, moved, name, carrier))
            if tilt:
                # The ends of a tilted roller move oppositely, across the direction of the tilt.
                lever = pin_distance(stage) / thread.roller_radius
                ends = (zero, -lever) if name == "pin_radial" else (lever, zero)
                opposite = None if carrier is None else OPPOSITE_CARRIERS
                pin = RollerSpring(stiffness, still, moved, name, opposite, roller_tilt=ends)
                springs.append(pin)
    if support.axial_stiffness is not None:
        # Retaining rings hold the carriers in the body in which rollers keep their axial place.
        roller, held = (zero, zero, -one, zero), (zero, zero, one, zero)
        pin = RollerSpring(support.axial_stiffness, roller, held, "pin_axial", beside)
        if tilt:
            lever = thread.centre_distance / nominal_radius(thread, beside)
            pin = dataclasses.replace(pin, central_tilt=(zero, -lever * one))
        springs.append(pin)
    return springs


def _central(
    stage: Stage, side: Side, carriers: Scalar | None, like: Scalar, tilt: bool
) -> SpatialBody:
    """Screw or nut, with the ring gear that is fixed to the nut, and the carriers beside it."""
    moving = moving_with(stage, side)
    fixed = tuple(name for name in moving if name != "carrier")
    given = [name for name in fixed if getattr(stage, name) is not None]
    mass = functools.reduce(operator.add, (body_mass(stage, name) for name in given))
    inertia = functools.reduce(operator.add, (body_inertia(stage, name) for name in given))
    body = SpatialBody(
        mass=mass,
        equivalent_mass=inertia / nominal_radius(stage.thread, side) ** 2,
        radial_support=supports(stage, fixed, "radial", like),
        torsional_support=supports(stage, fixed, "torsional", like),
        name=side,
        axial_mass=mass if carriers is None else mass + carriers,
        axial_support=supports(stage, moving, "axial", like),
    )
    return with_tilt(stage, body, side, carriers is not None) if tilt else body


@physics("spatial_system")
def spatial_system(
    stage: Stage,
    threads: ThreadStiffness,
    meshing: Meshing | None = None,
    *,
    sticking: bool = True,
    standstill: bool = False,
    axis: Axis | None = None,
    motor_held: bool = False,
    tilt: bool = False,
) -> SpatialSystem:
    """Collect the masses and springs of one stage whose bodies move in space.

    Screw, nut and each roller move in x, y, z and turn about z, and on request tilt. The ring gear
    is fixed to the nut. A thread contact is a spring along the common normal n of its flanks, with
    `k_n = k_a / n_z²` from the axial stiffness k_a of all engaged threads. Where the rollers roll
    (in the nut of a standard roller screw), it has Mindlin's stiffness in both tangential
    directions too; where they slide, none, unless the mechanism stands still. Teeth are springs
    along their line of action. Pins are springs between rollers and carriers, which move in x and y
    and turn with them, but axially with the body in which the rollers keep their place (the nut; of
    an inverted roller screw the screw). Without pins (`roller.support.radial_stiffness`) nothing
    connects rollers and carriers: these then only add their mass to that body in z.

    With `tilt` the bodies also tilt about x and y, in the middle of the nut, where the middles of
    screw and rollers lie too. Of a contact of stiffness k whose n threads have the distances ζ from
    their middle, a tilt ψ of a body against the roller stretches each by `ζ d·(ψ × e_z)`, so that
    one more spring k acts on `s d·(ψ × e_z)`, `s² = Σ ζ²/n = p² (n² − 1)/12`. Teeth and pins lie at
    both ends of the rollers, and each carrier moves sideways and turns for itself in its plane,
    which tilts with the body beside which it stays. Moments of inertia are `J/2 + m l²/12`.

    **Arguments:**

    - `stage`: the stage; needs masses and inertias (given or from dimensions).
    - `threads`: axial thread contact stiffness of one roller.
    - `meshing`: its meshing, if already known.
    - `sticking`: whether contacts that roll have a tangential stiffness; needs the materials of
      the bodies in contact.
    - `standstill`: whether the mechanism stands still, so that no contact slides: all have a
      tangential stiffness.
    - `axis`: the axis around the stage (`axis_system`); default none.
    - `motor_held`: whether the rotor of its motor does not turn.
    - `tilt`: whether screw, nut and rollers also tilt; needs their lengths, and the number of
      engaged threads.

    **Raises:** `MissingDataError` if masses or materials are missing; `ValueError` for fewer than 3
    or unequal rollers, and for supports that differ in x and y; with `tilt` for carriers other than
    two.
    """
    _refuse_asymmetric(stage)
    meshing = mesh(stage.thread) if meshing is None else meshing
    thread = stage.thread
    springs = _thread_springs(stage, threads, meshing, sticking, standstill, tilt)
    like = meshing.nut.contact_radius
    teeth = ring_roller_stiffness(stage)
    if teeth is not None and thread.family.gear_body is not None:
        springs += _gear_springs(stage, teeth, thread.family.gear_body, tilt)

    pins = stage.roller.support
    radial_pins = None if pins is None else pins.radial_stiffness
    carrier = stage.carrier if radial_pins is not None else None
    # Where rollers keep their place in neither body, a cage in the nut guides them.
    beside = thread.family.carrying or "nut"
    if pins is not None:
        name = None if carrier is None else "carrier"
        springs += _pin_springs(stage, pins, like, name, beside, tilt)
    carriers = None
    if stage.carrier is not None:
        carriers = stage.carrier.count * body_mass(stage, "carrier")
    bodies = [
        _central(stage, side, carriers if side == beside else None, like, tilt) for side in SIDES
    ]
    if carrier is not None and carriers is not None:
        inertia = carrier.count * body_inertia(stage, "carrier")
        bodies.append(
            SpatialBody(
                mass=carriers,
                equivalent_mass=inertia / thread.centre_distance**2,
                radial_support=supports(stage, ("carrier",), "radial", like),
                torsional_support=supports(stage, ("carrier",), "torsional", like),
                name="carrier",
            )
        )
        if tilt:
            bodies.append(opposite_carriers(stage, bodies[-1]))
    around: AxisSystem | None = None
    on_axis = tuple(bodies)
    if axis is not None:
        on_axis, around = axis_system(axis, stage, on_axis, motor_held)
    elif motor_held:
        raise ValueError("motor_held is True, but the mechanism has no axis; give [axis.motor]")
    return SpatialSystem(
        bodies=on_axis,
        springs=tuple(springs),
        roller_mass=body_mass(stage, "roller"),
        roller_equivalent_mass=body_inertia(stage, "roller") / thread.roller_radius**2,
        roller_count=stage.roller_count,
        axis=around,
        roller_tilt_mass=tilting_inertia(stage, "roller") / thread.roller_radius**2
        if tilt
        else None,
    )
