"""Claims on stresses below contacts, on rings, and on laws of friction and findings."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scenes import array

from prsm_jax.contact import hertz_contact, line_contact_under_force, subsurface_stress
from prsm_jax.geometry import ring_vertex
from prsm_jax.halfspace import grid_over, solve_contact, subsurface_stress_field
from prsm_jax.validation._shape_function import _solved
from tests.docs.claims import Claim
from tests.docs.claims.claims_contact import HERTZ, SURFACES, _grid_errors, _ring

_POISSON = 0.3
_POINTS = 150


@functools.cache
def _points(place: str) -> np.ndarray:
    """Random points over (a, b, b): in the body, just below the surface, outside on it."""
    random = np.random.default_rng(64)
    points = random.uniform(-1.5, 1.5, (20 * _POINTS, 3))
    depth = random.uniform(0.0, 1.0, len(points))
    points[:, 2] = depth * {"body": 1.5, "below": 1e-3, "outside": 0.0}[place]
    if place == "outside":
        points = points[np.hypot(points[:, 0], points[:, 1]) > 1]
    return points[:_POINTS]


@functools.partial(jax.jit, static_argnums=2)
def _stresses(points, ratio, nodes):
    axes, pulled = jnp.stack([jnp.ones_like(ratio), ratio]), jnp.asarray([0.08, 0.05])
    scale = jnp.stack([axes[0], axes[1], axes[1]])

    def at(point):
        return subsurface_stress(
            point * scale, axes, jnp.ones_like(ratio), array(_POISSON), pulled, nodes=nodes
        )

    return jax.lax.map(at, points)


def _node_errors(ratio: float, nodes: int):
    """Largest error of a component over p₀ against 1024 nodes, in three places."""

    def values() -> list[float]:
        found = []
        for place in ("body", "below", "outside"):
            points = jnp.asarray(_points(place))
            few, many = (_stresses(points, array(ratio), n) for n in (nodes, 1024))
            found.append(float(jnp.max(jnp.abs(few - many))))
        return found

    return values


def _steeper() -> list[float]:
    """How much larger the coefficient is at the contact than on the line of centres [%]."""
    contact, _, found = _ring(5.0)
    middle = found.slices.radius[len(found.slices.radius) // 2]
    here = eqx.filter_jit(ring_vertex)(contact, middle).coefficient
    slope, distance = np.tan(contact.screw_profile_angle), contact.centre_distance
    on_the_line = slope * distance / (2 * middle * (distance - middle))
    return [100 * (float(here / on_the_line) - 1)]


def _by_slices() -> list[float]:
    """Slices by default, and what they leave of the pressure of a ring that bears on its crest."""
    contact, modulus, found = _ring(5.0)
    fine = eqx.filter_jit(line_contact_under_force)(contact, array(55.0), modulus, 4097)
    slices = len(found.slices.radius) - 1
    return [slices, abs(float(found.max_pressure / fine.max_pressure) - 1)]


def _slopes() -> list[float]:
    """By lead angle, roller radius, either profile angle alone, and both, at 5° [MPa/°, MPa/mm]."""
    _, slopes = _solved(5.0)
    degree = 1e-6 * np.pi / 180
    either = [abs(slopes[f"{body} profile angle"]) * degree for body in ("screw", "roller")]
    return [
        slopes["lead angle"] * degree,
        -slopes["roller radius"] * 1e-9,
        float(np.mean(either)),
        abs(slopes["both profile angles"]) * degree,
    ]


@eqx.filter_jit
def _half_space(cells: int, ratio, depth):
    """A Hertz ellipse with friction on a grid: the solver's field at one depth, and the closed."""
    load, modulus, pulled = array(100.0), array(1.15e11), (array(0.2), array(-0.1))
    total, apart = (1 + ratio) * 70.0, ((ratio - 1) * 70.0) ** 2
    hertz = hertz_contact(load, total, apart, modulus)
    grid = grid_over((cells, cells), 1.3 * hertz.semi_major, 1.3 * hertz.semi_minor)
    x, y = grid.points
    found = solve_contact(grid, 70.0 * x**2 + ratio * 70.0 * y**2, modulus, load=load)
    below = depth * hertz.semi_minor
    tractions = {
        f"traction_{way}": mu * found.pressure for way, mu in zip("xy", pulled, strict=True)
    }
    field = subsurface_stress_field(
        grid, found.pressure, below[None], array(_POISSON), **tractions
    ).tensor[0]
    flat = jnp.stack([x, y, jnp.broadcast_to(below, x.shape)], axis=-1).reshape(-1, 3)
    axes = jnp.stack([hertz.semi_major, hertz.semi_minor])

    def closed(point):
        return subsurface_stress(
            point, axes, hertz.max_pressure, array(_POISSON), jnp.stack(pulled)
        )

    exact = jax.lax.map(closed, flat).reshape(field.shape)
    return jnp.max(jnp.abs(field - exact)) / hertz.max_pressure


def _fields() -> list[float]:
    """Largest error at a depth of 0.3 b over p₀ [%], on 32 × 32 and 64 × 64 cells."""
    return [100 * float(_half_space(n, array(1.4), array(0.3))) for n in (32, 64)]


@eqx.filter_jit
def _below_sphere(cells: int):
    load, modulus, like = array(100.0), array(1.15e11), array(100.0)
    hertz = hertz_contact(load, 2 * like, 0 * like, modulus)
    grid = grid_over((cells, cells), 1.3 * hertz.semi_major, 1.3 * hertz.semi_major)
    x, y = grid.points
    found = solve_contact(grid, like * (x**2 + y**2), modulus, load=load)
    depths = hertz.semi_major * jnp.linspace(0.4, 0.56, 33)
    stress = subsurface_stress_field(grid, found.pressure, depths, array(_POISSON))
    largest, depth = stress.max_von_mises
    return largest / hertz.max_pressure, depth / hertz.semi_major


def _sphere() -> list[float]:
    return [float(value) for value in _below_sphere(32)]


def _off_sphere() -> list[float]:
    """How much less it is than the largest on the axis by Johnson's closed form [%]."""
    z = np.linspace(0.3, 0.7, 4001)
    down = -1 / (1 + z**2)
    radial = -(1 + _POISSON) * (1 - z * np.arctan(1 / z)) - down / 2
    return [100 * (1 - _sphere()[0] / np.max(np.abs(down - radial)))]


def _of_paper() -> list[float]:
    """Printed finite elements against printed Hertz pressures [%]: the least and the largest."""
    printed = ((608, 999), (1480, 1259), (879, 1221))
    off = sorted(100 * abs(element / hertz - 1) for element, hertz in printed)
    return [off[0], off[-1]]


CLAIMS = [
    *(
        Claim(HERTZ, f"| {ratio}, {nodes} | {{}} | {{}} | {{}} |", _node_errors(ratio, nodes))
        for ratio, nodes in ((0.7, 64), (0.7, 96), (0.1, 64), (0.01, 96))
    ),
    Claim(HERTZ, "where it is {} % larger", _steeper),
    Claim(
        HERTZ,
        "*rises* by {} MPa per degree of lead angle, falls by {} MPa per mm of roller radius, "
        "and changes by {} MPa per degree of one profile angle, but by {} MPa per degree if both",
        _slopes,
    ),
    Claim(HERTZ, "with {} slices the error is {} of the pressure of an edge contact", _by_slices),
    Claim(SURFACES, "| 256 × 256 | {} | {} |", lambda: list(_grid_errors(256))),
    Claim(SURFACES, "it gives {} $p_0$ at {} $a$ on 32 × 32 cells", _sphere),
    Claim(SURFACES, "cells, {} % less than in closed form", _off_sphere),
    Claim(
        SURFACES,
        "at a depth of 0.3 $b$ is {} % of $p_0$ on 32 × 32 cells and {} % on 64 × 64",
        _fields,
    ),
    Claim(SURFACES, "at 25 and 50 N ({} to {} %)", _of_paper),
]
