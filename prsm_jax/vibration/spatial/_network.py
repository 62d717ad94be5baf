"""The spring network of a stage in space: whole, and reduced for each harmonic of its rollers."""

from typing import Any

import jax
import jax.numpy as jnp

from ...fields import Scalar
from ...programs import physics
from ..model import Coordinate, NetworkBuilder, Spring, SpringNetwork
from ._axis import AxisSystem
from ._bodies import SpatialBody
from ._springs import RollerSpring
from ._system import SpatialSystem

#: Directions of a roller, in the order of `RollerSpring.roller`, and its tilts.
ROLLER_DIRECTIONS = ("radial", "tangential", "z", "u")
_ROLLER_TILTS = ("tilt_radial", "tilt_tangential")
#: Directions of a body on the axis: all, and those of harmonics 0 and 1.
_DIRECTIONS = ("x", "y", "z", "u", "tilt_x", "tilt_y")
_OF_HARMONIC = {0: ("z", "u"), 1: ("w", "tilt_w")}


def _roller_directions(system: SpatialSystem) -> tuple[str, ...]:
    return ROLLER_DIRECTIONS + (() if system.roller_tilt_mass is None else _ROLLER_TILTS)


def _moves(body: SpatialBody, direction: str) -> bool:
    if direction == "z":
        return body.axial_mass is not None
    return body.tilt_mass is not None or not direction.startswith("tilt")


def _on_axis(system: SpatialSystem, directions: tuple[str, ...]) -> list[Coordinate]:
    """The degrees of freedom of the stage's bodies on the axis, without one that is held."""
    held = None if system.axis is None else system.axis.held_coordinate
    degrees = [
        Coordinate(body.name, direction)
        for body in system.bodies
        for direction in directions
        if _moves(body, direction)
    ]
    return [one for one in degrees if one != held]


def spatial_coordinates(system: SpatialSystem) -> tuple[Coordinate, ...]:
    """The degrees of freedom: x, y, z, u of bodies on the axis (no z of a carrier), z and u of the
    parts of the axis around them, and radial, tangential, z, u of each roller. Where bodies tilt,
    a tilt is r ψ with its angle ψ about x and y, of a roller about its radial and tangential
    direction."""
    degrees = _on_axis(system, _DIRECTIONS)
    if system.axis is not None:
        degrees += system.axis.coordinates
    for direction in _roller_directions(system):
        count = len(system.roller_positions)
        degrees += [Coordinate(f"roller {number}", direction) for number in range(1, count + 1)]
    return tuple(degrees)


def _of_body(body: SpatialBody, direction: str) -> tuple[Scalar, Scalar, str]:
    """Mass and support of a body in a direction, and the word for it."""
    if direction == "z":
        assert body.axial_mass is not None
        assert body.axial_support is not None
        return body.axial_mass, body.axial_support, "axial"
    if direction == "u":
        return body.equivalent_mass, body.torsional_support, "torsional"
    if direction.startswith("tilt"):
        assert body.tilt_mass is not None
        assert body.tilt_support is not None
        return body.tilt_mass, body.tilt_support, "tilting"
    return body.mass, body.radial_support, "radial" if direction == "w" else direction


def _add_bodies(builder: NetworkBuilder, system: SpatialSystem, degrees) -> dict[Coordinate, Any]:
    """Supports of the bodies on the axis; returns the masses of their coordinates."""
    bodies = {body.name: body for body in system.bodies}
    mass: dict[Coordinate, Any] = {}
    for coordinate in degrees:
        if coordinate.body in bodies:
            body = bodies[coordinate.body]
            mass[coordinate], stiffness, word = _of_body(body, coordinate.direction)
            spring = Spring(f"{coordinate.body}_support_{word}")
            builder.add((spring,), stiffness, [(coordinate, jnp.ones_like(stiffness))])
    return mass


def _add_axis(builder: NetworkBuilder, axis: AxisSystem, degrees) -> dict[Coordinate, Any]:
    """Springs of the axis; returns the masses of its own coordinates."""
    for spring in axis.springs:
        ends = [Coordinate(body, spring.direction) for body in spring.bodies]
        for name, stiffness in zip(spring.names, spring.shares, strict=True):
            one = jnp.ones_like(stiffness)
            stretch = [(end, sign * one) for end, sign in zip(ends, (1, -1), strict=False)]
            kept = [pair for pair in stretch if pair[0] in degrees]
            if kept:
                builder.add((Spring(name),), stiffness, kept)
    return {one: axis.mass(one) for one in axis.coordinates}


def _roller_mass(system: SpatialSystem, direction: str) -> Scalar:
    if system.roller_tilt_mass is not None and direction in _ROLLER_TILTS:
        return system.roller_tilt_mass
    return system.roller_equivalent_mass if direction == "u" else system.roller_mass


def _of_roller(system: SpatialSystem, spring: RollerSpring) -> list[tuple[str, Scalar]]:
    """Elongation of a spring per unit of each direction of its roller."""
    parts: list[tuple[str, Scalar]] = [*zip(ROLLER_DIRECTIONS, spring.roller, strict=True)]
    if spring.roller_tilt is not None:
        parts += zip(_ROLLER_TILTS, spring.roller_tilt, strict=True)
    return parts


@physics("spatial_dense_assembly")
def spatial_network(system: SpatialSystem) -> SpringNetwork:
    """All springs of a stage, without use of symmetry.

    A body at (x, y) moves by `x cos φ_i + y sin φ_i` along the line of centres of roller i and by
    `−x sin φ_i + y cos φ_i` across it.
    """
    degrees = spatial_coordinates(system)
    position = system.roller_positions
    numbers = range(1, len(position) + 1)
    cosine, sine = jnp.cos(position), jnp.sin(position)
    builder = NetworkBuilder(degrees)
    for spring in system.springs:
        elongation: list[Any] = []
        for direction, value in _of_roller(system, spring):
            own = [Coordinate(f"roller {number}", direction) for number in numbers]
            elongation.append((own, value))
        if spring.body is not None:
            along, around, axial, turn = spring.central
            components = {
                "x": along * cosine - around * sine,
                "y": along * sine + around * cosine,
                "z": axial,
                "u": turn,
            }
            if spring.central_tilt is not None:
                along, around = spring.central_tilt
                components["tilt_x"] = along * cosine - around * sine
                components["tilt_y"] = along * sine + around * cosine
            for direction, value in components.items():
                coordinate = Coordinate(spring.body, direction)
                if coordinate in degrees:
                    elongation.append((coordinate, value))
        names = tuple(Spring(spring.name, number) for number in numbers)
        builder.add(names, spring.stiffness, elongation)
    mass = _add_bodies(builder, system, degrees)
    if system.axis is not None:
        mass |= _add_axis(builder, system.axis, degrees)
    for coordinate in degrees:
        if coordinate not in mass:
            mass[coordinate] = _roller_mass(system, coordinate.direction)
    return builder.network(mass)


@physics("spatial_harmonic_network")
def spatial_harmonic_network(system: SpatialSystem, harmonic: int) -> SpringNetwork:
    """The reduced network for one harmonic of the rollers' motion.

    As in `harmonic_network`: rollers move as `q_i = Re(Q e^{i h φ_i})`, normalised so that the
    energies of the N rollers add up to that of `Q`. Harmonic 0 has z and u of the bodies on the
    axis, harmonic 1 their translations as one complex coordinate `w = i (x − i y)`, of which
    roller i sees `Re(w e^{iφ_i})` as tangential and `Re(−i w e^{iφ_i})` as radial displacement,
    and their tilts likewise; higher ones (all equal) have no body on the axis. The transformation
    is unitary.

    **Arguments:**

    - `system`: masses and springs from `spatial_system`.
    - `harmonic`: 0, 1 or 2; 2 stands for every higher one.
    """
    axis = system.axis if harmonic == 0 else None
    degrees = _on_axis(system, _OF_HARMONIC.get(harmonic, ()))
    if axis is not None:
        degrees += axis.coordinates
    rollers = tuple(Coordinate("roller", one) for one in _roller_directions(system))
    count = jnp.asarray(system.roller_count).astype(system.roller_mass.dtype)
    factor = jnp.sqrt(count if harmonic == 0 else count / 2)
    builder = NetworkBuilder((*degrees, *rollers))
    for spring in system.springs:
        elongation: list[Any] = [
            (Coordinate("roller", one), value) for one, value in _of_roller(system, spring)
        ]
        if spring.body is not None:
            along, around, axial, turn = (factor * value for value in spring.central)
            moved = {"z": axial, "u": turn}
            if harmonic == 1:
                moved = {"w": jax.lax.complex(around, -along)}
                if spring.central_tilt is not None:
                    along, around = (factor * value for value in spring.central_tilt)
                    moved["tilt_w"] = jax.lax.complex(around, -along)
            for direction, value in moved.items():
                coordinate = Coordinate(spring.body, direction)
                if coordinate in degrees:
                    elongation.append((coordinate, value))
        builder.add((Spring(spring.name),), spring.stiffness, elongation)
    mass = _add_bodies(builder, system, degrees)
    if axis is not None:
        mass |= _add_axis(builder, axis, degrees)
    mass |= {roller: _roller_mass(system, roller.direction) for roller in rollers}
    return builder.network(mass)
