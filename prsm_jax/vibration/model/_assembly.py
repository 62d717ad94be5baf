"""The spring network of a stage, and its reduced networks by symmetry."""

import functools
import operator
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Inexact

from ...fields import Scalar
from ...programs import physics
from ..arrowhead import SpringBlock
from ._spring_network import Coordinate, NetworkBuilder, Spring, SpringNetwork
from ._system import CarrierBody, CentralBody, VibrationSystem

#: The spring of each central body to a roller.
MESH_NAMES = {"screw": "screw_roller", "ring_gear": "ring_roller", "nut": "nut_roller"}


def mesh_name(body: str) -> str:
    """Name of the springs between a central body and the rollers."""
    return MESH_NAMES.get(body, f"{body}_roller")


def is_mesh(spring: str) -> bool:
    """Whether a spring is a contact of a central body with a roller."""
    return spring.endswith("_roller")


def roller_corner(system: VibrationSystem) -> Scalar:
    """k_s + k_r + k_n, the total stiffness of the mesh springs of one roller [N/m]."""
    return functools.reduce(operator.add, (body.mesh_stiffness for body in system.bodies))


def _block(system: VibrationSystem, support: str, mass: str, share: float) -> SpringBlock:
    bodies = system.bodies
    stiffness = jnp.stack([body.mesh_stiffness for body in bodies])
    masses = [*(getattr(body, mass) for body in bodies), system.roller_equivalent_mass]
    return SpringBlock(
        support=jnp.stack([getattr(body, support) for body in bodies]),
        mesh=stiffness,
        mass=jnp.stack(masses),
        factor=jnp.asarray((share * system.roller_count) ** 0.5, stiffness.dtype),
        signs=tuple(body.roller_sign for body in bodies),
    )


@physics("torsional_springs")
def torsional_springs(system: VibrationSystem) -> SpringBlock:
    """Harmonic 0 of the rollers: torsional modes in u of each body and u of all rollers."""
    return _block(system, "torsional_support", "equivalent_mass", 1.0)


@physics("transverse_springs")
def transverse_springs(system: VibrationSystem) -> SpringBlock:
    """Harmonic 1 of the rollers: transverse modes, each with multiplicity 2.

    Frequencies are independent of the positions of the contacts around the axes, which only turn
    the modes.
    """
    return _block(system, "radial_support", "mass", 0.5)


def torsional_block(
    system: VibrationSystem,
) -> tuple[Float[Array, "n n"], Float[Array, " n"]]:
    """Reduced torsional matrices: diagonal `K_ju + N k_j`, couplings `±√N k_j`, corner `Σ k_j`.

    **Returns:** stiffness matrix [N/m] and the diagonal of the mass matrix [kg].
    """
    springs = torsional_springs(system)
    return springs.stiffness_matrix(), springs.mass


def transverse_block(
    system: VibrationSystem,
) -> tuple[Float[Array, "n n"], Float[Array, " n"]]:
    """Reduced transverse matrices: diagonal `K_jx + N/2 k_j`, couplings `±√(N/2) k_j`.

    **Returns:** stiffness matrix [N/m] and the diagonal of the mass matrix [kg].
    """
    springs = transverse_springs(system)
    return springs.stiffness_matrix(), springs.mass


def coordinates(system: VibrationSystem) -> tuple[Coordinate, ...]:
    """The degrees of freedom: x, y, u of each body on the axis; u of each roller (and, where
    rollers translate, radial and tangential); of the carrier u, or x, y, u."""
    degrees = [
        Coordinate(body.name, direction) for body in system.bodies for direction in ("x", "y", "u")
    ]
    for direction in roller_directions(system):
        degrees += [Coordinate(f"roller {n}", direction) for n in system.roller_numbers]
    if system.carrier is not None:
        directions = ("u",) if system.translation is None else ("x", "y", "u")
        degrees += [Coordinate("carrier", direction) for direction in directions]
    return tuple(degrees)


def roller_directions(system: VibrationSystem) -> tuple[str, ...]:
    """Directions in which a roller moves."""
    return ("u",) if system.translation is None else ("u", "radial", "tangential")


@physics("dense_assembly")
def spring_network(
    system: VibrationSystem, phases: Float[Array, " bodies"] | None = None
) -> SpringNetwork:
    """All springs of a stage, without use of symmetry.

    A mesh spring lies along the line of action of body j and roller i, which is turned against
    the tangent by the contact angle α_j. With ψ = φ_i ∓ α_j (upper sign: screw) it stretches by

    `δ = −sin ψ x_j + cos ψ y_j + u_j ± u_i − cos α_j η_i ∓ sin α_j ζ_i`

    (Wu et al. 2022, equations 7 to 13, with the opposite sign of the screw's x, so that all
    bodies share one frame; for rollers that translate, ζ is radial and η tangential, as for the
    planets of Lin and Parker 1999). A pin stretches by the roller's displacement relative to the
    carrier, or relative to the housing if no carrier is modelled.

    **Arguments:**

    - `system`: the masses and springs.
    - `phases`: contact angles α of the bodies [rad]; by default those of the system, or zero.
      They do not change the frequencies of rollers that only rotate.
    """
    dtype = system.roller_equivalent_mass.dtype
    numbers, position = system.roller_numbers, system.roller_positions
    builder = NetworkBuilder(coordinates(system))
    names = [f"roller {number}" for number in numbers]
    rotation = [Coordinate(name, "u") for name in names]
    radial = [Coordinate(name, "radial") for name in names]
    tangential = [Coordinate(name, "tangential") for name in names]
    moving, scatter = system.translation, system.scatter
    factor = jnp.ones((), dtype)
    if scatter is not None and scatter.stiffness_factor is not None:
        factor = scatter.stiffness_factor
    mass: dict[Coordinate, Array] = {}

    for index, body in enumerate(system.bodies):
        x, y, u = (Coordinate(body.name, direction) for direction in ("x", "y", "u"))
        alpha = body.contact_angle if phases is None else phases[index]
        alpha = jnp.zeros((), dtype) if alpha is None else alpha
        sign, psi = body.roller_sign, position - body.roller_sign * alpha
        elongation = [
            (x, -jnp.sin(psi)),
            (y, jnp.cos(psi)),
            (u, jnp.ones((), dtype)),
            (rotation, jnp.full((), sign, dtype)),
        ]
        if moving is not None:
            elongation += [(tangential, -jnp.cos(alpha)), (radial, -sign * jnp.sin(alpha))]
        mesh = mesh_name(body.name)
        springs = tuple(Spring(mesh, number) for number in numbers)
        each = body.each_mesh_stiffness
        stiffness = factor * body.mesh_stiffness if each is None else each
        builder.add(springs, stiffness, elongation)
        other = body.radial_support if body.radial_support_y is None else body.radial_support_y
        support = f"{body.name}_support"
        for coordinate, name, stiffness in (
            (x, f"{support}_x", body.radial_support),
            (y, f"{support}_y", other),
            (u, f"{support}_torsional", body.torsional_support),
        ):
            builder.add((Spring(name),), stiffness, [(coordinate, jnp.ones((), dtype))])
        mass |= {x: body.mass, y: body.mass, u: body.equivalent_mass}

    share = jnp.ones((len(numbers),), dtype)
    if scatter is not None and scatter.mass_factor is not None:
        share = scatter.mass_factor
    for at in range(len(numbers)):
        mass[rotation[at]] = share[at] * system.roller_equivalent_mass
        if moving is not None:
            mass[radial[at]] = mass[tangential[at]] = share[at] * moving.mass

    carrier = system.carrier
    cu = Coordinate("carrier", "u")
    if moving is not None:
        minus = jnp.full((), -1.0, dtype)
        across, along = [(radial, minus)], [(tangential, minus)]
        if carrier is not None:
            cx, cy = Coordinate("carrier", "x"), Coordinate("carrier", "y")
            across += [(cx, jnp.cos(position)), (cy, jnp.sin(position))]
            along += [(cx, -jnp.sin(position)), (cy, jnp.cos(position)), (cu, -minus)]
        for name, elongation in (("pin_radial", across), ("pin_tangential", along)):
            pins = tuple(Spring(name, number) for number in numbers)
            builder.add(pins, moving.pin_stiffness, elongation)
    if carrier is not None:
        support = [(cu, "carrier_support_torsional", carrier.torsional_support)]
        mass[cu] = carrier.equivalent_mass
        if moving is not None:
            assert carrier.mass is not None
            radial_support = carrier.radial_support
            assert radial_support is not None
            for direction in ("x", "y"):
                coordinate = Coordinate("carrier", direction)
                mass[coordinate] = carrier.mass
                support.append((coordinate, f"carrier_support_{direction}", radial_support))
        for coordinate, name, stiffness in support:
            builder.add((Spring(name),), stiffness, [(coordinate, jnp.ones((), dtype))])
    return builder.network(mass)


def dense_matrices(
    system: VibrationSystem, phases: Float[Array, " bodies"] | None = None
) -> tuple[Float[Array, "n n"], Float[Array, " n"]]:
    """Full stiffness matrix [N/m] and diagonal of the mass matrix [kg]; see `spring_network`."""
    network = spring_network(system, phases)
    return network.stiffness_matrix(), network.mass


@physics("harmonic_network")
def harmonic_network(system: VibrationSystem, harmonic: int) -> SpringNetwork:
    """The reduced network of a symmetric system for one harmonic of the rollers' motion.

    Rollers move as `q_i = Re(Q e^{i h φ_i})`, normalised so that the energies of the N rollers add
    up to that of `Q`. Harmonic 0 has the rotations of the bodies on the axis, harmonic 1 their
    translations as one complex coordinate `w = i (x − i y)`, higher ones (all equal) no central
    body. The transformation is unitary, so multiplicities are known without a tolerance.

    **Arguments:**

    - `system`: a symmetric system.
    - `harmonic`: 0, 1 or 2; 2 stands for every higher one.
    """
    dtype = system.roller_equivalent_mass.dtype
    central = {0: "u", 1: "w"}.get(harmonic)
    supports = {0: "torsional_support", 1: "radial_support"}
    masses = {0: "equivalent_mass", 1: "mass"}
    moving = system.translation
    carrier = system.carrier if moving is not None else None
    share = 1.0 if harmonic == 0 else 0.5
    factor = jnp.asarray((share * system.roller_count) ** 0.5, dtype)
    bodies: list[tuple[str, CentralBody | CarrierBody]] = []
    bodies += [(body.name, body) for body in system.bodies]
    if carrier is not None:
        bodies.append(("carrier", carrier))
    mass: dict[Coordinate, Array] = {}
    if central is not None:
        for name, body in bodies:
            mass[Coordinate(name, central)] = getattr(body, masses[harmonic])
    u, radial, tangential = (
        Coordinate("roller", direction) for direction in ("u", "radial", "tangential")
    )
    mass[u] = system.roller_equivalent_mass
    if moving is not None:
        mass |= {radial: moving.mass, tangential: moving.mass}

    builder = NetworkBuilder(tuple(mass))
    for body in system.bodies:
        sign = body.roller_sign
        alpha = jnp.zeros((), dtype) if body.contact_angle is None else body.contact_angle
        elongation: list[Any] = [(u, jnp.full((), sign, dtype))]
        if moving is not None:
            elongation += [(tangential, -jnp.cos(alpha)), (radial, -sign * jnp.sin(alpha))]
        if central is not None:
            own = factor
            # If rollers only rotate, the phase is arbitrary: without it all numbers stay real.
            if harmonic == 1 and moving is not None:
                own = jax.lax.complex(factor * jnp.cos(alpha), -sign * factor * jnp.sin(alpha))
            elongation.append((Coordinate(body.name, central), own))
        builder.add((Spring(mesh_name(body.name)),), body.mesh_stiffness, elongation)
    if moving is not None:
        minus = jnp.full((), -1.0, dtype)
        across: list[Any] = [(radial, minus)]
        along: list[Any] = [(tangential, minus)]
        if carrier is not None and central is not None:
            along.append((Coordinate("carrier", central), factor))
            if harmonic == 1:
                quarter = jax.lax.complex(jnp.zeros_like(factor), -factor)
                across.append((Coordinate("carrier", central), quarter))
        builder.add((Spring("pin_radial"),), moving.pin_stiffness, across)
        builder.add((Spring("pin_tangential"),), moving.pin_stiffness, along)
    if central is not None:
        for name, body in bodies:
            stiffness: Inexact[Array, ""] = getattr(body, supports[harmonic])
            coordinate = Coordinate(name, central)
            support = Spring(f"{name}_support_{'torsional' if harmonic == 0 else 'radial'}")
            builder.add((support,), stiffness, [(coordinate, jnp.ones((), dtype))])
    return builder.network(mass)
