"""Thread contacts at the ends of their flanks: extent, and pressure at rounded crests."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._errors import MissingDataError
from ..contact import (
    RoundedEdge,
    StageContact,
    contact_modulus,
    edge_ratio,
    half_extents,
    largest_pressure,
    opposite_onset,
    rounded_edges,
)
from ..fields import Scalar
from ..geometry import FlankEnd, Meshing
from ..mechanism import Stage, material_of
from ._contacts import REFERENCE_LOAD, known_contact, thread_share
from ._powers import positive_power
from ._truncation import SideOnset, flank_sides, known_sides, side_onsets


def side_edges(
    stage: Stage, meshing: Meshing | None = None, contact: StageContact | None = None
) -> tuple[tuple[RoundedEdge, ...], tuple[RoundedEdge, ...]]:
    """Rounded crests that the ellipses of screw and nut side can extend beyond.

    **Arguments:**

    - `stage`: the stage; needs materials, `engaged_threads` and `thread.edge_radius`.
    - `meshing`: its meshing, if already known.
    - `contact`: `reference_contact` of the stage, if already known.

    **Raises:** `MissingDataError` if one of these is not given.
    """
    radius = stage.thread.edge_radius
    if radius is None:
        raise MissingDataError(
            "the pressure at a sharp edge has no finite value in elastic half-spaces; give "
            "stage.thread.edge_radius, the rounding radius of the edges at the crests"
        )
    screw, nut = (
        rounded_edges(
            side.contact.hertz,
            side.frame.curvature,
            side.ends,
            contact_modulus(material_of(stage, "roller"), material_of(stage, side.name)),
            radius,
        )
        for side in flank_sides(stage, meshing, contact)
    )
    return screw, nut


def edge_pressure(
    stage: Stage,
    load: Scalar,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
    sharing_factor: Scalar | float = 1.0,
    sides: tuple[SideOnset | None, SideOnset | None] | None = None,
) -> Scalar:
    """Largest pressure of the most loaded contacts, including rounded crests [Pa].

    For elastic half-spaces: where the pressure exceeds the strength of the steel, the edge yields.

    **Arguments:**

    - `stage`: the stage, with addenda and `thread.edge_radius`.
    - `load`: axial load on one flank, of one nut of a preloaded pair [N].
    - `meshing`: its meshing, if already known.
    - `contact`: `reference_contact` of the stage, if already known.
    - `sharing_factor`: load of the most loaded thread over the mean.
    - `sides`: `side_onsets` of the stage, if already known.

    **Raises:** `MissingDataError` if no end of a flank or no edge radius is given, or materials or
    engaged threads are missing.
    """
    meshing, contact = known_contact(stage, meshing, contact)
    if sides is None:
        sides = side_onsets(stage, meshing, contact)
    known_sides(sides)
    assert sides is not None
    effective_load = jnp.abs(load) * sharing_factor / thread_share(stage)
    return jnp.max(
        jnp.stack(
            [
                largest_pressure(side.pressure(effective_load), side.onsets, edges)
                for side, edges in zip(sides, side_edges(stage, meshing, contact), strict=True)
                if side is not None
            ]
        )
    )


class EndReach(eqx.Module):
    """One end of a flank, and the extent of the ellipse of its side towards it."""

    #: `"screw"` or `"nut"` side of the rollers.
    side: str = eqx.field(static=True)
    end: FlankEnd
    #: Half-extent of the ellipse towards the end under `REFERENCE_LOAD` on one flank, in equal
    #: shares [m].
    reference: Scalar
    #: Hertz pressure under that load [Pa].
    pressure: Scalar
    #: The edge there, if it is a rounded crest, and the argument `opposite` of `edge_ratio`.
    edge: RoundedEdge | None = None
    opposite: Scalar | None = None

    def half_extent(self, load: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
        """Half-extent under an axial load on one flank, if all threads share it equally [m]."""
        return self.reference * positive_power(load / REFERENCE_LOAD, 1 / 3)

    def edge_pressure(self, load: Scalar) -> Scalar:
        """Pressure at the rounded crest if threads share a load equally; 0 if not reached [Pa]."""
        assert self.edge is not None
        pressure = self.pressure * positive_power(load / REFERENCE_LOAD, 1 / 3)
        return pressure * edge_ratio(pressure, self.edge, self.opposite)


def end_reaches(
    stage: Stage, meshing: Meshing | None = None, contact: StageContact | None = None
) -> tuple[EndReach, ...]:
    """All ends of the flanks of a stage, in the order of `geometry.end_names`.

    **Arguments:** as in `side_onsets`.
    """
    meshing, contact = known_contact(stage, meshing, contact)
    sides = flank_sides(stage, meshing, contact)
    edges: list[list[tuple[RoundedEdge | None, Scalar | None]]]
    edges = [[(None, None)] * len(side.ends) for side in sides]
    if stage.thread.edge_radius is not None:
        for side, known, rounded in zip(
            sides, edges, side_edges(stage, meshing, contact), strict=True
        ):
            crests = [index for index, end in enumerate(side.ends) if end.kind == "crest"]
            for index, edge in zip(crests, rounded, strict=True):
                known[index] = edge, opposite_onset(edge, rounded)
    per_share = thread_share(stage) ** (-1 / 3)
    return tuple(
        EndReach(
            side.name,
            end,
            per_share * extent,
            per_share * side.contact.hertz.max_pressure,
            *edge,
        )
        for side, known in zip(sides, edges, strict=True)
        for end, extent, edge in zip(
            side.ends,
            half_extents(side.contact.hertz, side.frame.curvature, side.ends),
            known,
            strict=True,
        )
    )
