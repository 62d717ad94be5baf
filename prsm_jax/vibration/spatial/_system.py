"""Masses and springs of one stage whose bodies move in space."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import CountOrTraced, Scalar, as_count, plain
from ...geometry import Meshing, mesh
from ...mechanism import Axis, Stage, Support, body_inertia, body_mass, material_of
from ...programs import physics
from ...stiffness import ThreadStiffness, ring_roller_stiffness
from ._axis import AxisSystem, axis_system
from ._bodies import SpatialBody
from ._springs import (
    RollerSpring,
    contact_spring,
    nut_places,
    screw_places,
    tangential_ratio,
    tangents,
)


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


def _supports(stage: Stage, names: tuple[str, ...], direction: str, like: Scalar) -> Scalar:
    """Sum of the supports of bodies that are fixed to each other; zero where none is given."""
    total = jnp.zeros_like(like)
    for name in names:
        body = getattr(stage, name)
        support: Support | None = None if body is None else body.support
        stiffness = None if support is None else getattr(support, f"{direction}_stiffness")
        if stiffness is not None:
            total = total + stiffness
    return total


def _thread_springs(
    stage: Stage, threads: ThreadStiffness, meshing: Meshing, sticking: bool
) -> list[RollerSpring]:
    thread = stage.thread
    screw_radii = thread.screw_radius, thread.roller_radius
    nut_radii = thread.nut_radius, thread.roller_radius
    screw, nut = meshing.screw.normal_parts, meshing.nut.normal_parts
    screw_stiffness = threads.screw_roller / screw[2] ** 2
    nut_stiffness = threads.nut_roller / nut[2] ** 2
    at_screw, at_nut = screw_places(meshing.screw), nut_places(meshing.nut)
    if sticking:
        ratio = tangential_ratio(material_of(stage, "roller"), material_of(stage, "nut"))
        tangential = ratio * nut_stiffness
    else:
        # Springs without stiffness, as for supports that are not given.
        tangential = jnp.zeros_like(nut_stiffness)
    sticks = "sticking_nut_roller"
    return [
        contact_spring("screw_roller", "screw", screw_stiffness, screw, at_screw, screw_radii),
        contact_spring("nut_roller", "nut", nut_stiffness, nut, at_nut, nut_radii),
        *(
            contact_spring(sticks, "nut", tangential, tangent, at_nut, nut_radii)
            for tangent in tangents(nut)
        ),
    ]


def _gear_spring(stage: Stage, stiffness: Scalar) -> RollerSpring:
    """The teeth touch where the pitch circles do, and push along the line of action."""
    zero, radii = jnp.zeros_like(stiffness), (stage.thread.nut_radius, stage.thread.roller_radius)
    angle = zero if stage.gear is None else stage.gear.pressure_angle
    action = -jnp.sin(angle), jnp.cos(angle), zero
    places = (radii[0], zero), (radii[1], zero)
    return contact_spring("ring_roller", "nut", stiffness, action, places, radii)


def _pin_springs(support: Support, like: Scalar, carrier: str | None) -> list[RollerSpring]:
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
    if support.axial_stiffness is not None:
        # Carriers are held in the nut by retaining rings, and move axially with it.
        roller, nut = (zero, zero, -one, zero), (zero, zero, one, zero)
        springs.append(RollerSpring(support.axial_stiffness, roller, nut, "pin_axial", "nut"))
    return springs


@physics("spatial_system")
def spatial_system(
    stage: Stage,
    threads: ThreadStiffness,
    meshing: Meshing | None = None,
    *,
    sticking: bool = True,
    axis: Axis | None = None,
    motor_held: bool = False,
) -> SpatialSystem:
    """Collect the masses and springs of one stage whose bodies move in space.

    Screw, nut and each roller move in x, y, z and turn about z; tilts are left out. The ring gear
    is fixed to the nut. A thread contact is a spring along the common normal n of its flanks, with
    `k_n = k_a / n_z²` from the axial stiffness k_a of all engaged threads; a contact at the nut,
    which rolls, has Mindlin's stiffness in both tangential directions too, one at the screw, which
    slides, none. Teeth are springs along their line of action. Pins are springs between rollers and
    carriers, which move in x and y and turn with them, but axially with the nut. Without pins
    (`roller.support.radial_stiffness`) nothing connects rollers and carriers: these then only add
    their mass to the nut in z.

    **Arguments:**

    - `stage`: the stage; needs masses and inertias (given or from dimensions).
    - `threads`: axial thread contact stiffness of one roller.
    - `meshing`: its meshing, if already known.
    - `sticking`: whether contacts at the nut have a tangential stiffness; needs the materials of
      roller and nut.
    - `axis`: the axis around the stage (`axis_system`); default none.
    - `motor_held`: whether the rotor of its motor does not turn.

    **Raises:** `MissingDataError` if masses or materials are missing; `ValueError` for fewer than 3
    or unequal rollers, and for supports that differ in x and y.
    """
    _refuse_asymmetric(stage)
    meshing = mesh(stage.thread) if meshing is None else meshing
    thread, ring = stage.thread, stage.ring_gear
    springs = _thread_springs(stage, threads, meshing, sticking)
    like = meshing.nut.contact_radius
    teeth = ring_roller_stiffness(stage)
    if teeth is not None:
        springs.append(_gear_spring(stage, teeth))

    pins = stage.roller.support
    radial_pins = None if pins is None else pins.radial_stiffness
    carrier = stage.carrier if radial_pins is not None else None
    if pins is not None:
        springs += _pin_springs(pins, like, None if carrier is None else "carrier")

    nut_mass, nut_inertia = body_mass(stage, "nut"), body_inertia(stage, "nut")
    if ring is not None:
        nut_mass = nut_mass + body_mass(stage, "ring_gear")
        nut_inertia = nut_inertia + body_inertia(stage, "ring_gear")
    carriers = None
    nut_axial_mass = nut_mass
    if stage.carrier is not None:
        carriers = stage.carrier.count * body_mass(stage, "carrier")
        nut_axial_mass = nut_mass + carriers
    screw_mass = body_mass(stage, "screw")
    on_nut = ("nut", "ring_gear")
    bodies = [
        SpatialBody(
            mass=screw_mass,
            equivalent_mass=body_inertia(stage, "screw") / thread.screw_radius**2,
            radial_support=_supports(stage, ("screw",), "radial", like),
            torsional_support=_supports(stage, ("screw",), "torsional", like),
            name="screw",
            axial_mass=screw_mass,
            axial_support=_supports(stage, ("screw",), "axial", like),
        ),
        SpatialBody(
            mass=nut_mass,
            equivalent_mass=nut_inertia / thread.nut_radius**2,
            radial_support=_supports(stage, on_nut, "radial", like),
            torsional_support=_supports(stage, on_nut, "torsional", like),
            name="nut",
            axial_mass=nut_axial_mass,
            axial_support=_supports(stage, (*on_nut, "carrier"), "axial", like),
        ),
    ]
    if carrier is not None and carriers is not None:
        inertia = carrier.count * body_inertia(stage, "carrier")
        bodies.append(
            SpatialBody(
                mass=carriers,
                equivalent_mass=inertia / thread.centre_distance**2,
                radial_support=_supports(stage, ("carrier",), "radial", like),
                torsional_support=_supports(stage, ("carrier",), "torsional", like),
                name="carrier",
            )
        )
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
    )
