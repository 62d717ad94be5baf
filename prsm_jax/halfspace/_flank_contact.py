"""Contact of two real flanks of a stage: true gap, crests, roughness."""

import dataclasses
from collections.abc import Callable
from typing import Annotated

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..contact import HertzContact, contact_modulus, engaged_threads, hertz_contact
from ..fields import In, Scalar
from ..geometry import Meshing, dimensions_possible, mesh
from ..mechanism import Stage, material_of, of_one_design
from ..results import Result
from ._flank_gap import FlankGap, TangentPlane, checked_side, flank_gap, tangent_plane
from ._grid import grid_over
from ._surface_contact import SurfaceContact, solve_contact, within_small_strains

#: Heights on the grid [m], or a function of the coordinates [m] that gives them.
Heights = (
    Float[Array, "nx ny"]
    | Callable[[Float[Array, "nx ny"], Float[Array, "nx ny"]], Float[Array, "nx ny"]]
)


#: Half the grid over the relative radius of curvature, for a contact without load (no ellipse).
_UNLOADED = 1e-4


class FlankContact(Result):
    """One thread contact of a roller with true surfaces, and its Hertz contact."""

    surface: SurfaceContact
    flanks: FlankGap
    plane: TangentPlane
    #: Contact of the osculating paraboloids, under the same normal force or at the given approach.
    hertz: HertzContact
    #: Normal force per axial force of the contact, F_n/F_a.
    normal_per_axial: Annotated[Scalar, In("1")]


def _rounded(flanks: FlankGap, edge_radius: Scalar) -> Float[Array, "nx ny"]:
    """Gap with rounded edges: beyond the crest the flank recedes by s²/2ρ."""
    gap = flanks.gap
    for edge in (flanks.body_edge, flanks.roller_edge):
        if edge is not None:
            gap = gap + jnp.maximum(-edge, 0.0) ** 2 / (2 * edge_radius)
    return gap


def _hertz_force(
    approach: Scalar, total: Scalar, difference_squared: Scalar, modulus: Scalar
) -> Scalar:
    """Normal force of a Hertz contact at an approach, F ∝ δ^{3/2}; 0 where it is open."""
    unit = hertz_contact(jnp.ones_like(modulus), total, difference_squared, modulus)
    return (jnp.maximum(approach, 0.0) / unit.approach) ** 1.5


@of_one_design
def flank_contact(
    stage: Stage,
    side: str,
    load: Scalar | float | None = None,
    shape: tuple[int, int] = (128, 128),
    *,
    approach: Scalar | float | None = None,
    extent: Scalar | float = 1.3,
    heights: Heights | None = None,
    edge_radius: Scalar | float | None = None,
    meshing: Meshing | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 1000,
) -> FlankContact:
    """Contact of one thread of a roller with its true flanks, as half-spaces.

    The gap is that of the exact flanks along their common normal. The grid lies in the tangent
    plane along the principal directions of the gap and covers a multiple of the Hertz ellipse. The
    flanks end at the crests of screw (nut) and roller where `screw_addendum` and `roller_addendum`
    are given; the nut's thread is taken as high as the screw's. A half-space has material beyond
    such an edge, so the pressure close to a sharp edge is singular and rises as the grid is
    refined, and the real, free edge is more compliant: use `edge_radius`, or evaluate the pressure
    away from the edge.

    The axial load is shared equally by rollers and threads, as in `stage_contact`. Curvatures and
    normals are always exact, independent of the stage's convention. Without a load there is no
    pressure, and the result code is 3; under a load too large for the half-space model it is 4.

    **Arguments:**

    - `stage`: the stage; needs materials, and `engaged_threads` for a load.
    - `side`: `"screw"` or `"nut"`.
    - `load`: axial load on the nut [N]; its sign is ignored; or
    - `approach`: approach of the two flanks of this contact along their common normal, 0 where
      smooth flanks touch [m]. The grid is that of the Hertz ellipse at this approach. Rough flanks,
      whose peaks touch earlier, at an approach of 0 or less, need a load instead.
    - `shape`: number of cells along the major and the minor axis of the ellipse.
    - `extent`: half the grid over the semi-axes of the Hertz ellipse.
    - `heights`: sum of the roughness or waviness of both surfaces, positive outwards, so a peak
      reduces the gap: an array, or a function of the coordinates x and y on the grid [m].
    - `edge_radius`: rounding radius of the edges at the crests [m]; default: that of the thread, if
      any. The rounding begins at the crest, and no cell is excluded. The result is differentiable
      in it and in the addenda.
    - `meshing`: the thread's meshing, if already known.
    - `tolerance`, `max_iterations`: as in `solve_contact`.

    **Raises:** `MissingDataError` if materials or engaged threads are not given; `ValueError` for
    an unknown side, heights that do not fit the grid, and unless exactly one of `load` and
    `approach` is given.
    """
    if (load is None) == (approach is None):
        raise ValueError(
            f"load is {load!r} and approach is {approach!r}; give exactly one of the two"
        )
    side = checked_side(side)
    thread = stage.thread
    edge_radius = thread.edge_radius if edge_radius is None else edge_radius
    meshing = mesh(thread) if meshing is None else meshing
    contact = getattr(meshing, side)
    modulus = contact_modulus(material_of(stage, "roller"), material_of(stage, side))
    normal_per_axial = 1 / jnp.abs(contact.normal[2])
    curvature = contact.curvature
    paraboloids = curvature.total, curvature.difference_squared, modulus
    if load is None:
        approach = jnp.asarray(approach, modulus.dtype)
        force = _hertz_force(approach, *paraboloids)
    else:
        magnitude = jnp.abs(jnp.asarray(load, modulus.dtype))
        axial = magnitude / (stage.present_roller_count * engaged_threads(stage))
        force = axial * normal_per_axial
    hertz = hertz_contact(force, *paraboloids)
    half_axes = (
        jnp.where(hertz.semi_minor > 0, axis, _UNLOADED / curvature.total)
        for axis in (hertz.semi_major, hertz.semi_minor)
    )
    grid = grid_over(shape, *(extent * half for half in half_axes))
    plane = tangent_plane(thread, meshing, side)
    flanks = flank_gap(thread, plane, side, grid)
    material = None if edge_radius is not None else flanks.material
    gap = flanks.gap
    if edge_radius is not None:
        gap = _rounded(flanks, jnp.asarray(edge_radius, gap.dtype))
    if heights is not None:
        gap = gap - (heights(*grid.points) if callable(heights) else heights)
    surface = solve_contact(
        grid,
        gap,
        modulus,
        load=force if approach is None else None,
        approach=approach,
        material=material,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )
    surface = within_small_strains(surface, hertz.max_pressure, modulus)
    possible = dimensions_possible(stage) & meshing.converged
    surface = dataclasses.replace(surface, code=jnp.where(possible, surface.code, 5))
    return FlankContact(surface, flanks, plane, hertz, normal_per_axial)
