"""Modes of a stage in space, by the harmonics of its rollers."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...programs import physics
from .._grouped_modes import GroupedModes, ModeGroup, of_elastic
from .._spring_modes import spring_modes
from .._symmetric import meshed_share
from ..model import Coordinate, SpringNetwork, expanded_shapes, kinetic_energies
from ._network import spatial_coordinates, spatial_harmonic_network, spatial_network
from ._system import SpatialSystem

#: The group of harmonic 0, in which the lead couples axial and torsional motion.
AXIAL_TORSIONAL = "axial_torsional"
#: Group and multiplicity of harmonics 0 and ±1.
_HARMONICS = ((AXIAL_TORSIONAL, 1), ("transverse", 2))


class SpatialModes(GroupedModes):
    """Natural frequencies of one stage whose bodies move in space.

    Families: `axial` and `torsional` (all rollers move equally; the lead couples both, and the
    larger share of the kinetic energy gives the name), `transverse`, `roller`, and `rigid` for a
    motion without strain. Groups: `axial_torsional`, `transverse`, and with more than 3 rollers
    `roller`.

    Differentiable are frequencies, energy shares, and the shapes of simple roots.
    """

    groups: tuple[ModeGroup, ...]
    #: Share of the kinetic energy of each mode of the group `axial_torsional` that is in motion
    #: along z and in radial motion of the rollers; the rest is rotation of bodies, and motion of
    #: rollers around the screw. 0 for a rigid motion, whose shape is arbitrary.
    axial_share: Float[Array, "*batch modes"]
    network: SpringNetwork | None = None

    def _family_names(self, group: ModeGroup) -> list[str]:
        if group.family != AXIAL_TORSIONAL:
            return super()._family_names(group)
        return ["axial" if share > 0.5 else "torsional" for share in self.axial_share.tolist()]


def _group(
    system: SpatialSystem, harmonic: int, family: str, multiplicity: int, shapes: bool
) -> tuple[ModeGroup, Float[Array, " modes"]]:
    """The modes of one harmonic, and the axial share of each."""
    network = spatial_harmonic_network(system, harmonic)
    modes = spring_modes(network)
    frequencies = modes.angular_frequencies / (2 * jnp.pi)
    whole = None
    if shapes:
        amplitudes = dict(zip(network.coordinates, modes.shapes, strict=True))
        degrees = spatial_coordinates(system)
        whole = expanded_shapes(degrees, system.roller_positions, harmonic, amplitudes)
    share = of_elastic(meshed_share(network, modes.shapes), frequencies)
    axial = of_elastic(_axial_share(network, modes.shapes), frequencies)
    return ModeGroup(frequencies, share, multiplicity, family, whole), axial


def _axial_share(network: SpringNetwork, shapes) -> Float[Array, " modes"]:
    """Share of the kinetic energy along z and in radial motion of the rollers."""
    by_direction = SpringNetwork(
        network.stiffness,
        network.rows,
        network.mass,
        tuple(Coordinate(place.direction, place.body) for place in network.coordinates),
        network.springs,
    )
    energies = kinetic_energies(by_direction, shapes)
    return energies.get("z", 0.0) + energies["radial"]


@physics("spatial_modes")
def spatial_modes(system: SpatialSystem, *, shapes: bool = False) -> SpatialModes:
    """All natural frequencies of a stage in space, at a cost independent of its rollers' number.

    Harmonic 0 of the rollers moves with z and u of the bodies on the axis (axial–torsional, each
    simple), harmonics ±1 with their x and y (transverse, double), all others move alone (roller,
    N − 3 times). Derivatives at repeated roots: see `spring_modes`.

    **Arguments:**

    - `system`: masses and springs from `spatial_system`.
    - `shapes`: also give the mode shapes.
    """
    kinds = list(_HARMONICS)
    others = system.roller_count - 3
    if others > 0:
        kinds.append(("roller", others))
    found = [
        _group(system, harmonic, family, multiplicity, shapes)
        for harmonic, (family, multiplicity) in enumerate(kinds)
    ]
    groups = tuple(group for group, _ in found)
    network = spatial_network(system) if shapes else None
    return SpatialModes(groups, axial_share=found[0][1], network=network)
