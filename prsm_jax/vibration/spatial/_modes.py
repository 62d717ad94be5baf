"""Modes of a stage in space, by the harmonics of its rollers."""

import dataclasses

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...programs import physics
from .._grouped_modes import GroupedModes, ModeGroup, of_elastic
from .._spring_modes import RIGID_SHARE, SpringModes, spring_modes
from .._symmetric import meshed_share
from ..model import (
    Coordinate,
    SpringNetwork,
    expanded_shapes,
    kinetic_energies,
    shares,
    strain_energies,
)
from ._network import spatial_coordinates, spatial_harmonic_network, spatial_network
from ._system import SpatialSystem

#: The group of harmonic 0, in which the lead couples axial and torsional motion.
AXIAL_TORSIONAL = "axial_torsional"
#: Springs that are strained by rotation about the axis, beside those named so.
_TORSIONAL = ("coupling", "motor_shaft", "position_gain", "ring_roller", "pin_tangential")
#: Group and multiplicity of harmonics 0 and ±1.
_HARMONICS = ((AXIAL_TORSIONAL, 1), ("transverse", 2))


@dataclasses.dataclass(frozen=True)
class SpatialMode:
    """One elastic axial–torsional mode, mass-normalised, of a single design."""

    #: From 1, the lowest elastic one.
    number: int
    #: `axial` or `torsional`.
    family: str
    #: [Hz].
    frequency: float
    #: Displacement along the axis by body [1/√kg]; of all rollers as `roller`.
    along: dict[str, float]
    #: Rotation u = r θ by body on the axis [1/√kg].
    around: dict[str, float]
    #: Share of the kinetic energy by body, and of the strain energy by spring, largest first. One
    #: per cent more stiffness raises the frequency by half the share of the spring in per cent.
    kinetic: dict[str, float]
    strain: dict[str, float]


class SpatialModes(GroupedModes):
    """Natural frequencies of one stage whose bodies move in space.

    Families: `axial` and `torsional` (all rollers move equally; the lead couples both, and
    `axial_share` above one half gives the name), `transverse`, `roller`, and `rigid` for a
    motion without strain. Groups: `axial_torsional`, `transverse`, and with more than 3 rollers
    `roller`.

    Differentiable are frequencies, energy shares, and the shapes of simple roots.
    """

    groups: tuple[ModeGroup, ...]
    #: Of each mode of the group `axial_torsional`, the share of its kinetic energy in motion along
    #: z and in radial motion of the rollers; the rest is rotation of bodies, and motion of rollers
    #: around the screw. With an axis, the share of its strain energy in springs that are not
    #: torsional: of a load that vibrates against a motor, the lighter one has more of the kinetic
    #: energy. 0 for a rigid motion, whose shape is arbitrary.
    axial_share: Float[Array, "*batch modes"]
    network: SpringNetwork | None = None

    def _family_names(self, group: ModeGroup) -> list[str]:
        if group.family != AXIAL_TORSIONAL:
            return super()._family_names(group)
        return ["axial" if share > 0.5 else "torsional" for share in self.axial_share.tolist()]

    def elastic_modes(self) -> tuple[SpatialMode, ...]:
        """The axial–torsional modes without the rigid motions, ascending; of a single design.

        **Raises:** `ValueError` if shapes were not requested.
        """
        network, group = self._with_shapes(), self.groups[0]
        assert group.shapes is not None
        shapes = group.shapes[..., 0]
        names, values = self._family_names(group), group.frequencies.tolist()
        least = RIGID_SHARE * float(max(one.frequencies.max() for one in self.groups))
        kinetic = shares(kinetic_energies(network, shapes))
        strain = shares(strain_energies(network, shapes))
        found: list[SpatialMode] = []
        for at, (value, family) in enumerate(zip(values, names, strict=True)):
            if value <= least:
                continue
            moved: dict[str, dict[str, float]] = {"z": {}, "u": {}}
            for one, size in zip(network.coordinates, shapes[:, at].tolist(), strict=True):
                if one.direction in moved:
                    moved[one.direction].setdefault(one.body.split()[0], size)
            along, around = moved.values()
            energies = (_largest_first(rows, at) for rows in (kinetic, strain))
            found.append(SpatialMode(len(found) + 1, family, value, along, around, *energies))
        return tuple(found)


def _largest_first(rows: dict[str, Array], at: int) -> dict[str, float]:
    values = {name: float(row[at]) for name, row in rows.items()}
    return dict(sorted(values.items(), key=lambda item: -item[1]))


def _group(
    system: SpatialSystem,
    harmonic: int,
    family: str,
    multiplicity: int,
    shapes: bool,
    modes: SpringModes | None = None,
) -> tuple[ModeGroup, Float[Array, " modes"]]:
    """The modes of one harmonic, and the axial share of each."""
    network = spatial_harmonic_network(system, harmonic)
    modes = spring_modes(network) if modes is None else modes
    frequencies = modes.angular_frequencies / (2 * jnp.pi)
    whole = None
    if shapes:
        amplitudes = dict(zip(network.coordinates, modes.shapes, strict=True))
        degrees = spatial_coordinates(system)
        whole = expanded_shapes(degrees, system.roller_positions, harmonic, amplitudes)
    share = of_elastic(meshed_share(network, modes.shapes), frequencies)
    along = _moving_along if system.axis is None else _strained_along
    axial = of_elastic(along(network, modes.shapes), frequencies)
    return ModeGroup(frequencies, share, multiplicity, family, whole), axial


def is_torsional(spring: str) -> bool:
    """Whether a spring is strained by rotation about the axis or by motion around it."""
    return spring in _TORSIONAL or spring.endswith("_torsional")


def _strained_along(network: SpringNetwork, shapes) -> Float[Array, " modes"]:
    """Share of the strain energy in springs that are not torsional."""
    energies = shares(strain_energies(network, shapes))
    return jnp.sum(jnp.stack([e for name, e in energies.items() if not is_torsional(name)]), axis=0)


def _moving_along(network: SpringNetwork, shapes) -> Float[Array, " modes"]:
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


@physics("axial_torsional_modes")
def axial_torsional_modes(
    system: SpatialSystem, modes: SpringModes | None = None
) -> tuple[ModeGroup, Float[Array, " modes"]]:
    """The modes of harmonic 0 alone, and the axial share of each; see `SpatialModes`.

    **Arguments:**

    - `system`: masses and springs from `spatial_system`.
    - `modes`: `spring_modes` of its network of harmonic 0, if already known.
    """
    return _group(system, 0, *_HARMONICS[0], shapes=False, modes=modes)


@physics("spatial_transverse_modes")
def spatial_transverse_modes(system: SpatialSystem) -> ModeGroup:
    """The modes of harmonics ±1 alone, each double."""
    return _group(system, 1, *_HARMONICS[1], shapes=False)[0]


def _kinds(system: SpatialSystem) -> list[tuple[str, int]]:
    """Group and multiplicity of each harmonic."""
    others = system.roller_count - 3
    return [*_HARMONICS, ("roller", others)] if others > 0 else [*_HARMONICS]


def spatial_spring_modes(system: SpatialSystem) -> tuple[SpringModes, ...]:
    """The modes of each harmonic's network, as `spatial_modes` takes them."""
    harmonics = range(len(_kinds(system)))
    return tuple(spring_modes(spatial_harmonic_network(system, one)) for one in harmonics)


@physics("spatial_modes")
def spatial_modes(
    system: SpatialSystem, *, shapes: bool = False, solved: tuple[SpringModes, ...] | None = None
) -> SpatialModes:
    """All natural frequencies of a stage in space, at a cost independent of its rollers' number.

    Harmonic 0 of the rollers moves with z and u of the bodies on the axis (axial–torsional, each
    simple), harmonics ±1 with their x and y (transverse, double), all others move alone (roller,
    N − 3 times). Derivatives at repeated roots: see `spring_modes`.

    **Arguments:**

    - `system`: masses and springs from `spatial_system`.
    - `shapes`: also give the mode shapes.
    - `solved`: `spatial_spring_modes` of the system, if already known.
    """
    modes = spatial_spring_modes(system) if solved is None else solved
    found = [
        _group(system, harmonic, *kind, shapes, modes[harmonic])
        for harmonic, kind in enumerate(_kinds(system))
    ]
    groups = tuple(group for group, _ in found)
    network = spatial_network(system) if shapes else None
    return SpatialModes(groups, axial_share=found[0][1], network=network)
