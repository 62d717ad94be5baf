"""Lisowski 2014: pressures of the true flanks, compared with finite elements and Hertz theory."""

import dataclasses
import functools
from collections.abc import Iterator

import equinox as eqx
import jax.numpy as jnp

from ...fields import as_scalar
from ...geometry import Meshing, mesh
from ...halfspace import FlankContact, flank_contact
from ...mechanism import Stage
from .._difference import not_comparable, unexplained
from .._examples import example
from .._registry import rows_of
from .._row import Row
from .._thread_contacts import LOADS
from ._lisowski2014 import BY_FLANKS, ELEMENTS, TABLES

_CELLS = 32
_EXTENT = 1.3
#: Radius that the crests' edges are rounded by [m]; sharp ones have infinite pressures.
EDGE_RADIUS = 0.2e-3
#: Heights of threads: no flank ends inside a contact, and a fortieth of the pitch [m].
_HIGH, LOW = 1e-3, 0.05e-3
#: Element size of the paper [m].
_ELEMENT = 1e-5


_mesh = eqx.filter_jit(mesh)


@eqx.filter_jit
def _contact(stage: Stage, meshing: Meshing, side: str, load, extent, cells: int) -> FlankContact:
    rounded = as_scalar(EDGE_RADIUS)
    return flank_contact(
        stage, side, load, (cells, cells), extent=extent, edge_radius=rounded, meshing=meshing
    )


@functools.cache
def flanks(
    side: str,
    load: float,
    addendum: float = _HIGH,
    extent: float = _EXTENT,
    cells: int = _CELLS,
) -> FlankContact:
    """Contact of one pair of the paper's threads with true flanks.

    **Arguments:**

    - `side`: `"screw"` or `"nut"`.
    - `load`: axial load on the pair [N].
    - `addendum`: height of the screw's and nut's threads above the nominal radius [m].
    - `extent`: half the grid over the semi-axes of the Hertz ellipse.
    - `cells`: cells along each axis of the grid.
    """
    stage = example("lisowski2014").stages[0]
    thread = dataclasses.replace(
        stage.thread, screw_addendum=as_scalar(addendum), roller_addendum=as_scalar(_HIGH)
    )
    stage = Stage(
        thread=thread, roller_count=1, material=stage.material, engaged_threads=as_scalar(1.0)
    )
    contact = _contact(stage, _mesh(thread), side, jnp.asarray(load), jnp.asarray(extent), cells)
    if int(contact.surface.code) != 0:
        raise RuntimeError(
            f"no contact of the {side} side at {load} N: code {contact.surface.code}"
        )
    return contact


def _share(contact: FlankContact) -> float:
    """Largest pressure over that of exact Hertz theory."""
    return float(contact.surface.max_pressure / contact.hertz.max_pressure)


@rows_of("lisowski2014")
def true_flanks() -> Iterator[Row]:
    """Tables 1 and 2, finite elements beside the contact of the true flanks."""
    for side, pressures in ELEMENTS.items():
        for load, printed in zip(LOADS, pressures, strict=True):
            if printed is None:
                continue
            contact = flanks(side, load)
            hertz = float(contact.hertz.max_pressure) / 1e6
            expected = BY_FLANKS[side][LOADS.index(load)]
            yield unexplained(
                f"{TABLES[side]}: finite elements beside true flanks, {side} side, {load:.0f} N",
                printed,
                float(contact.surface.max_pressure) / 1e6,
                "MPa",
                # Discretisation error of 32 cells per axis.
                between=(0.998 * expected, 1.002 * expected),
                note="half-space contact with the exact gap of the helicoids, within "
                f"{100 * abs(_share(contact) - 1):.2g} % of exact Hertz theory on the flanks' "
                f"curvatures ({hertz:.1f} MPa): neither the shape of the flanks nor the friction "
                "between bodies of one material lowers the pressure; the paper's Hertz column has "
                "helix-like radii, and its elements agree with it at 100 N only",
            )


@rows_of("lisowski2014")
def edges() -> Iterator[Row]:
    """Section 4: the nut side's edge zone, and the size of the elements."""
    high, low = flanks("nut", 50.0), flanks("nut", 50.0, LOW)
    assert low.flanks.body_edge is not None
    past = int(jnp.sum(low.surface.contact & (low.flanks.body_edge < 0)))
    reach = 1e3 * _radial_reach(high)
    yield not_comparable(
        "section 4: the contact of roller and nut has an edge zone, 50 N; height of the nut's "
        "thread below which there is one",
        "an edge zone",
        reach,
        "mm",
        between=(0.1, 0.102),
        missing="this is the reach of the ellipse along the nut's radius; heights of threads are "
        f"not printed. With a height of {1e3 * LOW:g} mm, {past} cells beyond the crest carry load "
        f"and the pressure is {_share(low):.2f} times Hertz. A crest inside the "
        "contact would explain an open contact area, not the low "
        f"879 MPa: an edge, here rounded by {1e3 * EDGE_RADIUS:g} mm, raises the pressure. The "
        "paper takes the pressure at the border of the sliding zone, which is not the largest",
    )
    for side, printed in (("screw", "39.1"), ("nut", "28.0")):
        load = 25.0 if side == "screw" else 50.0
        # The minor axis has cells of that size; the major axis has longer ones.
        axis = float(flanks(side, load).hertz.semi_minor)
        coarse = flanks(side, load, _HIGH, _ELEMENT * _CELLS / 2 / axis)
        highest = float(jnp.max(coarse.surface.pressure) / coarse.hertz.max_pressure)
        yield unexplained(
            f"section 4: error at low load from elements of 0.01 mm, {side} side, {load:.0f} N",
            printed,
            100 * abs(highest - 1),
            "%",
            between=(0.05, 0.5),
            note="computed: the error of the largest pressure on a grid with cells of "
            f"{1e3 * float(coarse.surface.grid.spacing_x):.4f} by 0.01 mm, "
            f"{2 * axis / _ELEMENT:.0f} of them across the minor axis of the ellipse. "
            "The size of the elements alone does not explain the printed error; "
            "an error of their contact (the approach is only "
            f"{1e6 * float(coarse.hertz.approach):.1f} µm) may",
        )


def _radial_reach(contact: FlankContact) -> float:
    """Reach of the ellipse from its centre along the radius of the nut [m]."""
    plane, hertz = contact.plane, contact.hertz
    radius = plane.origin[:2] / jnp.linalg.norm(plane.origin[:2])
    along = jnp.stack([jnp.sum(radius * plane.major[:2]), jnp.sum(radius * plane.minor[:2])])
    axes = jnp.stack([hertz.semi_major, hertz.semi_minor])
    return float(jnp.linalg.norm(along * axes))
