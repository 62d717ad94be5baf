"""Contact of a ring and a screw on the grid: what the slices of a line contact leave out."""

import jax
import jax.numpy as jnp

from ..contact import LineContactResult, line_contact_under_force
from ..geometry import contact_zone, ring_gap
from ..mechanism import LineContact, Scalar
from ..programs import physics
from ._grid import Grid
from ._surface_contact import SurfaceContact, solve_contact, within_small_strains

#: Half the width of the grid over that of the widest slice, and its length over the zone's.
_WIDER, _LONGER = 2.5, 1.05


@physics("ring_contact")
def ring_contact(
    contact: LineContact,
    axial_force: Scalar,
    modulus: Scalar,
    *,
    shape: tuple[int, int] = (128, 64),
    slices: LineContactResult | None = None,
) -> SurfaceContact:
    """The flanks of a ring and a screw in contact on an elastic half-space.

    The gap is that of the exact flanks, counted along the arc from every slice's narrowest place.
    Unlike the slices of `line_contact`, every place feels all the others: the pressure rises where
    the zone ends although the flanks are straight, and evens out along the line where they are not
    parallel. Both bodies count as half-spaces past the ends, too; a crest that is a free edge is
    softer there.

    The rise at a sharp end has no limit: it grows slowly as the grid gets finer, until the edge
    that is broken in reality is resolved.

    **Arguments:**

    - `contact`: the flanks.
    - `axial_force`: on this contact [N].
    - `modulus`: contact modulus E* [Pa].
    - `shape`: cells along the contact line and across it.
    - `slices`: the same contact by slices, if known; it sets the extent of the grid.

    **Returns:** a `SurfaceContact`: x along the ring's generator, outwards, y along the arc.
    """
    if slices is None:
        slices = line_contact_under_force(contact, axial_force, modulus)
    inner, outer = contact_zone(contact)
    along = jnp.cos(contact.roller_profile_angle)
    length, width = _LONGER * (outer - inner) / along, 2 * _WIDER * slices.max_half_width
    # How far and where the grid reaches says nothing about the contact.
    length, width = jax.lax.stop_gradient((length, width))
    grid = Grid(shape, length / shape[0], width / shape[1])
    radius = (inner + outer) / 2 + grid.x * along
    geometry = slices.slices
    arc = jnp.interp(radius, geometry.radius, geometry.arc / geometry.radius) * radius
    normal = jnp.interp(radius, geometry.radius, geometry.normal)

    def row(r: Scalar, middle: Scalar):
        return jax.vmap(lambda y: ring_gap(contact, r, middle + y))(grid.y)

    gap = jax.vmap(row)(radius, arc)
    material = (radius >= inner) & (radius <= outer)
    lowest = jnp.min(jnp.where(material[:, None], gap, jnp.inf))
    force = (
        axial_force
        * slices.normal_force
        / jnp.where(slices.axial_force > 0, slices.axial_force, 1.0)
    )
    surface = solve_contact(
        grid,
        normal[:, None] * (gap - lowest),
        modulus,
        load=force,
        material=jnp.broadcast_to(material[:, None], shape),
    )
    return within_small_strains(surface, slices.max_pressure, modulus)
