"""Contact of a ring and a screw on the grid, without the simplifications of slices."""

import jax
import jax.numpy as jnp

from ..contact import LineContactResult, line_contact_under_force
from ..fields import Scalar
from ..geometry import contact_zone, ring_gap
from ..mechanism import LineContact
from ..programs import physics
from ._grid import Grid
from ._surface_contact import SurfaceContact, solve_contact, within_small_strains

#: Width of the grid over that of the widest slice, and its length over that of the zone.
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

    The gap is that of the exact flanks, along the arc from the smallest gap of every slice. Unlike
    the slices of `line_contact`, all points influence each other: the pressure rises at the ends of
    the zone although the flanks are straight, and evens out along the line where they are not
    parallel. Both bodies are half-spaces beyond the ends, too; a real crest, with a free edge, is
    more compliant there.

    The rise at a sharp end has no limit: it grows slowly as the grid becomes finer, down to the
    size at which real edges are rounded.

    **Arguments:**

    - `contact`: the flanks.
    - `axial_force`: axial force on this contact [N].
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
    # The extent of the grid is not part of the contact: no derivatives.
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
