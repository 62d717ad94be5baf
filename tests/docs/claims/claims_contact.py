"""Claims of the pages on contacts, computed with the public functions of `prsm_jax`."""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scenes import array, example

from prsm_jax.contact import (
    contact_modulus,
    hertz_contact,
    line_contact_under_force,
    line_subsurface_stress,
    max_shear_stress,
    stress_peak,
    stress_peak_on_axis,
    von_mises_stress,
)
from prsm_jax.geometry import matched_profile_angle
from prsm_jax.halfspace import grid_over, ring_contact, solve_contact
from prsm_jax.mechanism import material_of
from tests.docs.claims import Claim
from tests.present import present

HERTZ = "docs/contact_hertz.md"
SURFACES = "docs/contact_surfaces.md"
_POISSON = 0.3


@functools.cache
def _hertz_errors(method: str, largest: float, smallest: float = 1.0) -> dict[str, float]:
    """Largest relative errors of an approximation over a range of B/A."""
    ratio = jnp.geomspace(smallest, largest, 4001)

    def solve(one, how):
        total = array(100.0) * (1 + one)
        return hertz_contact(
            array(50.0), total, (total * (one - 1) / (1 + one)) ** 2, array(1e11), how
        )

    found, exact = (
        jax.jit(jax.vmap(functools.partial(solve, how=how)))(ratio) for how in (method, "exact")
    )
    names = ("max_pressure", "approach", "semi_major", "semi_minor")
    return {
        name: float(jnp.max(jnp.abs(getattr(found, name) / getattr(exact, name) - 1)))
        for name in names
    }


def _ladder(method: str, scale: float, wide: float):
    """Largest of p₀, δ and of a, b for roller screws, and of p₀, δ over four decades."""

    def values() -> list[float]:
        narrow, far = _hertz_errors(method, 1.6, 1.15), _hertz_errors(method, 1e4)
        return [
            *(scale * narrow[name] for name in ("max_pressure", "approach")),
            *(scale * narrow[name] for name in ("semi_major", "semi_minor")),
            *(wide * far[name] for name in ("max_pressure", "approach")),
        ]

    return values


@eqx.filter_jit
def _on_axis(ratio):
    peaks = [
        stress_peak_on_axis(array(1.0), ratio, array(1.0), array(_POISSON), name)
        for name in ("max_shear", "von_mises")
    ]
    return jnp.stack([peaks[0].value, peaks[0].depth, peaks[1].value])


def _below(ratio: float):
    def values() -> list[float]:
        shear, depth, mises = np.asarray(_on_axis(array(ratio)))
        return [shear, depth / ratio, mises]

    return values


def _below_line() -> list[float]:
    """On the axis of a line contact: largest shear in the plane, its depth, von Mises' stress."""
    depth = jnp.linspace(0.5, 1.1, 601)

    def at(z):
        point = jnp.stack([jnp.zeros_like(z), z])
        stress = line_subsurface_stress(point, array(1.0), array(1.0), array(_POISSON))
        return max_shear_stress(stress), von_mises_stress(stress)

    shear, mises = jax.jit(jax.vmap(at))(depth)
    best = int(jnp.argmax(shear))
    return [float(shear[best]), float(depth[best]), float(jnp.max(mises))]


@jax.jit
def _peak(coefficient):
    pulled = jnp.stack([coefficient, jnp.zeros_like(coefficient)])
    return stress_peak(jnp.asarray([1.0, 1.0]), array(1.0), array(_POISSON), pulled)


@functools.cache
def _pulled(friction: float) -> tuple[float, float]:
    """Von Mises' stress of a circle over that without friction, and its depth."""
    here, still = _peak(array(friction)), _peak(array(0.0))
    return float(here.value / still.value), float(here.depth)


def _edge_friction() -> list[float]:
    """Coefficient at which the largest stress moves to the surface, to 1e-4."""
    low, high = 0.2, 0.5
    while high - low > 1e-4:
        middle = (low + high) / 2
        low, high = (low, middle) if _pulled(middle)[1] == 0 else (middle, high)
    return [high]


@functools.cache
def _ring(lead_angle: float):
    """Slices and modulus of the ring example at some lead angle [deg], 55 N."""
    stage = example("ring_roller").stages[0]
    steel = material_of(stage, "screw")
    contact = dataclasses.replace(
        present(stage.line_contact), lead_angle=array(np.radians(lead_angle))
    )
    modulus = contact_modulus(steel, steel)
    return contact, modulus, _slices(contact, modulus)


@eqx.filter_jit
def _slices(contact, modulus):
    return line_contact_under_force(contact, array(55.0), modulus)


@functools.cache
def _half_space(lead_angle: float, shape: tuple[int, int]):
    contact, modulus, slices = _ring(lead_angle)
    return _on_grid(contact, modulus, shape, slices)


@eqx.filter_jit
def _on_grid(contact, modulus, shape, slices):
    return ring_contact(contact, array(55.0), modulus, shape=shape, slices=slices)


def _line_row(lead_angle: float):
    def values() -> list[float]:
        _, _, slices = _ring(lead_angle)
        coarse, fine = (_half_space(lead_angle, shape) for shape in ((64, 32), (128, 64)))
        pressures = [[float(jnp.max(one.pressure)) / 1e6] for one in (coarse, fine)]
        if lead_angle == 0:
            middles = [
                float(one.pressure[len(one.pressure) // 2].max()) / 1e6 for one in (coarse, fine)
            ]
            pressures = [[m, p[0]] for m, p in zip(middles, pressures, strict=True)]
        approaches = [1e6 * float(slices.approach), 1e6 * float(fine.approach)]
        return [float(slices.max_pressure) / 1e6, *pressures[0], *pressures[1], *approaches]

    return values


def _opening() -> list[float]:
    _, _, slices = _ring(5.0)
    return [1e6 * float(jnp.max(slices.slices.gap)), 100 * float(slices.loaded_share)]


def _matched() -> list[float]:
    contact, _, _ = _ring(5.0)
    return [float(jnp.degrees(eqx.filter_jit(matched_profile_angle)(contact)))]


def _moved() -> list[float]:
    _, _, slices = _ring(5.0)
    return [float(np.degrees(np.max(np.abs(slices.slices.arc / slices.slices.radius))))]


@functools.cache
def _grid_errors(cells: int) -> tuple[float, float]:
    """Errors of largest pressure and approach, B/A = 1.4, against exact Hertz theory."""
    smaller, load, modulus = array(70.0), array(100.0), array(1.15e11)
    larger = 1.4 * smaller

    @jax.jit
    def solve():
        hertz = hertz_contact(load, smaller + larger, (larger - smaller) ** 2, modulus)
        grid = grid_over((cells, cells), 1.3 * hertz.semi_major, 1.3 * hertz.semi_minor)
        x, y = grid.points
        found = solve_contact(grid, smaller * x**2 + larger * y**2, modulus, load=load)
        return (
            found.max_pressure / hertz.max_pressure - 1,
            found.approach / hertz.approach - 1,
        )

    pressure, approach = solve()
    return abs(float(pressure)), abs(float(approach))


CLAIMS = [
    Claim(HERTZ, f"| {name} | {{}}, {{}} | {{}}, {{}} | {{}}, {{}} |", _ladder(method, 1.0, 1.0))
    for name, method in (("`antoine` (2006), exact integrals", "antoine"),)
]
CLAIMS += [
    Claim(
        HERTZ,
        "exact integrals | {}, {} | {}, {} | {} %, {} % |",
        _ladder("power", 1.0, 100.0),
    ),
    *(
        Claim(
            HERTZ,
            f"| {name} | {{}} %, {{}} % | {{}} %, {{}} % | {{}} %, {{}} % |",
            _ladder(method, 100.0, 100.0),
        )
        for name, method in (
            ("`lisowski` (2014), polynomials corrected", "lisowski"),
            ("`hamrock_brewe` (1983), power form", "hamrock_brewe"),
            ("`hamrock_brewe_log` (1977)", "hamrock_brewe_log"),
        )
    ),
    Claim(HERTZ, "| circle | {} $p_0$ | {} $a$ | {} $p_0$ |", _below(1.0)),
    Claim(HERTZ, "| $b/a = 0.8$ | {} $p_0$ | {} $b$ | {} $p_0$ |", _below(0.8)),
    Claim(HERTZ, "| $b/a = 0.5$ | {} $p_0$ | {} $b$ | {} $p_0$ |", _below(0.5)),
    Claim(HERTZ, "| line | {} $p_0$ | {} $b$ | {} $p_0$ |", _below_line),
    Claim(
        HERTZ,
        "Friction of 0.1 raises von Mises' stress of a circle by {} %, of 0.25 by {} %;",
        lambda: [100 * (_pulled(friction)[0] - 1) for friction in (0.1, 0.25)],
    ),
    Claim(HERTZ, "from {} on the maximum is at the trailing edge", _edge_friction),
    Claim(HERTZ, "by about $L/(2\\pi d\\tan j)$ ({}° in the example)", _moved),
    Claim(HERTZ, "the gap opens by {} µm over 2 mm", lambda: _opening()[:1]),
    Claim(HERTZ, "and {} % of the zone carries the whole load", lambda: _opening()[1:]),
    Claim(HERTZ, "$\\tan^2 k = \\tan^2 j + \\tan^2\\psi$ ({}°)", _matched),
    Claim(
        HERTZ,
        "| 0 | {} MPa | {} in the middle, {} at the ends | {}, {} | {} µm | {} µm |",
        _line_row(0.0),
    ),
    Claim(HERTZ, "| 1° | {} MPa | {} MPa at the crest | {} MPa | {} µm | {} µm |", _line_row(1.0)),
    Claim(HERTZ, "| 5° | {} MPa | {} MPa at the crest | {} MPa | {} µm | {} µm |", _line_row(5.0)),
    *(
        Claim(
            SURFACES,
            f"| {cells} × {cells} | {{}} | {{}} |",
            functools.partial(lambda n: list(_grid_errors(n)), cells),
        )
        for cells in (16, 32, 64, 128)
    ),
]
