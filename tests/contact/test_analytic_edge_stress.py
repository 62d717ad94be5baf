"""Largest stress at the edge of a contact, with friction in any direction: NumPy's own field."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array
from scipy.optimize import minimize_scalar
from scipy.special import ellipkinc, elliprd

from prsm_jax.contact import stress_peak, subsurface_stress
from prsm_jax.contact.stress._edge_stress import edge_integrals, edge_stress
from prsm_jax.contact.stress._stress_peak import _MEASURES

RATIO = 0.3  # Poisson's
MEASURES = ("von_mises", "max_shear", "tension")


def _in_plane(angle, b, friction, degrees):
    """σ_x, σ_y, τ_xy over p₀ at the edge of an ellipse of semi-axes 1 and b.

    Waves over all directions: the pressure as a Fourier series, friction in Legendre's and
    Carlson's integrals.
    """
    along, across = friction * np.cos(np.radians(degrees)), friction * np.sin(np.radians(degrees))
    square = b**2
    # ∫ sin²/Δ, ∫ cos²/Δ and ∫ sin² cos²/Δ³ over a quarter, in m = 1 − b².
    d = elliprd(0.0, square, 1.0) / 3
    whole = ellipkinc(np.pi / 2, 1 - square)
    c = (2 * d - whole) / (1 - square) if b < 1 else np.pi / 16
    first, second, mixed = (2 / np.pi * x for x in (b * d, whole - d, b * c))
    cosine, sine = np.cos(angle), np.sin(angle)
    x = along * (first + RATIO * mixed) * cosine + across * RATIO * (second - b * mixed) * sine
    y = across * (second + RATIO * b * mixed) * sine + along * RATIO * (first - mixed) * cosine
    shear = across * (first / 2 - RATIO * mixed) * cosine
    shear = shear + along * (second / 2 - RATIO * b * mixed) * sine
    q, m = (1 - b) / (1 + b), np.arange(1, 400)
    terms = (1 - q**2) * 2 * m / (4 * m**2 - 1) * q ** (m - 1.0)
    waves = np.exp(2j * np.multiply.outer(angle, m)) @ terms
    pressed = (1 - 2 * RATIO) / 2 * waves
    return -np.pi * x + pressed.real, -np.pi * y - pressed.real, -np.pi * shear + pressed.imag


def _measures(stress):
    """By name, from the principal stresses of the plane and 0 normal to it."""
    x, y, shear = stress
    mean, radius = (x + y) / 2, np.hypot((x - y) / 2, shear)
    high, low = np.maximum(mean + radius, 0.0), np.minimum(mean - radius, 0.0)
    return {
        "von_mises": np.sqrt(x**2 - x * y + y**2 + 3 * shear**2),
        "max_shear": (high - low) / 2,
        "tension": high,
    }


def _largest(name, b, friction, degrees):
    """The largest value along the edge and its angle."""

    def below(angle):
        return -_measures(_in_plane(angle, b, friction, degrees))[name]

    angles = np.linspace(-np.pi, np.pi, 1001)
    place = angles[np.argmin(below(angles))]
    found: Any = minimize_scalar(
        below, bounds=(place - 0.01, place + 0.01), method="bounded", options={"xatol": 1e-9}
    )
    return -found.fun, found.x


def _program(name):
    @jax.jit
    def peak(arguments):
        b, friction, angle = arguments[0], arguments[1], jnp.radians(arguments[2])
        axes = jnp.stack([jnp.ones_like(b), b])
        pulled = friction * jnp.stack([jnp.cos(angle), jnp.sin(angle)])
        found = stress_peak(axes, array(1.0), array(RATIO), pulled, name)
        return jnp.concatenate([found.value[None], found.position])

    return peak


_peaks = {name: _program(name) for name in MEASURES}


def _of_point_forces(x, y, z, b, traction):
    """σ_x, σ_y, τ_xy of Boussinesq's and Cerruti's point forces (Johnson 1985, 3.18 and 3.75), in
    polar coordinates about the point, dense there and at the edge.
    """
    angles = (np.arange(1200) + 0.5) * 2 * np.pi / 1200
    nodes, weights = np.polynomial.legendre.leggauss(240)
    nodes, weights = (1 + nodes) / 2, weights / 2
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    square, half = c**2 + (s / b) ** 2, x * c + y * s / b**2
    root = np.sqrt(np.maximum(half**2 - square * (x**2 + (y / b) ** 2 - 1), 0.0))
    log = np.arcsinh((root - half) / square / z)
    stretched = log * (1 - (1 - nodes) ** 2)
    r = z * np.sinh(stretched)
    area = z * np.cosh(stretched) * log * 2 * (1 - nodes) * weights * r * 2 * np.pi / 1200
    inside = 1 - (x + r * c) ** 2 - ((y + r * s) / b) ** 2
    force = area * np.sqrt(np.maximum(inside, 0.0)) / (2 * np.pi)
    u, v, rho, m = -r * c, -r * s, np.hypot(r, z), 1 - 2 * RATIO
    h = rho + z

    def normal(u):
        radial = z / rho**3 - 1 / (rho * h) + u**2 * (rho + h) / (rho**3 * h**2)
        return m * radial - 3 * z * u**2 / rho**5

    def pulled(u, v):
        direct = 1 / rho**3 - 3 / (rho * h**2) + u**2 / (rho**3 * h**2)
        cross = 1 / rho**3 - 1 / (rho * h**2) + v**2 / (rho**3 * h**2)
        sheared = -1 / (rho * h**2) + u**2 / (rho**3 * h**2) + 2 * u**2 / (rho**2 * h**3)
        return (
            -3 * u**3 / rho**5 + m * u * (direct + 2 * u**2 / (rho**2 * h**3)),
            -3 * u * v**2 / rho**5 + m * u * (cross + 2 * v**2 / (rho**2 * h**3)),
            -3 * u**2 * v / rho**5 + m * v * sheared,
        )

    mixed = u * v * (m * (rho + h) / (rho**3 * h**2) - 3 * z / rho**5)
    total = [normal(u), normal(v), mixed]
    one, other = pulled(u, v), pulled(v, u)
    total[0] = total[0] + traction[0] * one[0] + traction[1] * other[1]
    total[1] = total[1] + traction[0] * one[1] + traction[1] * other[0]
    total[2] = total[2] + traction[0] * one[2] + traction[1] * other[2]
    return np.array([np.sum(force * t) for t in total])


@pytest.mark.parametrize(("b", "friction", "degrees"), [(0.2, 0.5, 30.0), (0.5, 0.3, 45.0)])
def test_stress_at_the_edge_against_point_forces(b, friction, degrees):
    """Below the edge stresses fall as the root of the depth: two depths give that at the edge."""
    _, angle = _largest("tension", b, friction, degrees)
    x, y = np.cos(angle) * (1 - 1e-9), b * np.sin(angle) * (1 - 1e-9)
    traction = friction * np.cos(np.radians(degrees)), friction * np.sin(np.radians(degrees))
    near, far = (_of_point_forces(x, y, depth * b, b, traction) for depth in (1e-4, 4e-4))
    np.testing.assert_allclose(2 * near - far, _in_plane(angle, b, friction, degrees), atol=2e-3)


_at_edge = jax.jit(
    lambda angle, b, pulled: jnp.stack(
        edge_stress(angle, b, array(RATIO), pulled, edge_integrals(b))
    )
)


@pytest.mark.parametrize("b", [0.1, 0.5, 0.9, 0.91, 1.0])
def test_closed_form_at_the_edge(b):
    """On both sides of the change from its series to its closed form, at b = 0.905."""
    pulled = 0.4 * jnp.asarray([np.cos(np.radians(25.0)), np.sin(np.radians(25.0))])
    for angle in (0.0, 0.7, 2.0, -1.9):
        found = _at_edge(array(angle), array(b), pulled)
        # Rounding of the difference of integrals in the NumPy one near a circle.
        np.testing.assert_allclose(found, _in_plane(angle, b, 0.4, 25.0), atol=1e-13)


CASES = [
    ("tension", 0.1, 0.5, 45.0),
    ("tension", 0.2, 0.5, 30.0),
    ("tension", 0.3, 0.33, 20.0),
    ("tension", 0.3, 0.4, 60.0),
    ("tension", 0.2, 0.1, 45.0),
    ("tension", 0.7, 0.3, 45.0),
    ("tension", 0.5, 0.4, 0.0),
    ("tension", 1.0, 0.4, 35.0),
    ("von_mises", 0.5, 0.5, 45.0),
    ("von_mises", 0.2, 0.5, 70.0),
    ("von_mises", 0.3, 0.4, 60.0),
]


@pytest.mark.parametrize(("name", "b", "friction", "degrees"), CASES)
def test_oblique_friction_finds_the_largest_stress_of_the_edge(name, b, friction, degrees):
    """It is far from the end of the section along the friction."""
    expected, angle = _largest(name, b, friction, degrees)
    value, *position = np.asarray(_peaks[name](jnp.asarray([b, friction, degrees])))
    assert value == pytest.approx(expected, rel=1e-12)
    place = [np.cos(angle), b * np.sin(angle), 0.0]
    np.testing.assert_allclose(position, place, atol=1e-7)


def _differences(function, at, steps):
    """Central differences of fourth order by each argument; derivatives last."""
    columns = []
    for step in np.diag(steps):
        near, far = function(at + step) - function(at - step), function(at + 2 * step)
        columns.append((8 * near - far + function(at - 2 * step)) / (12 * step.sum()))
    return np.stack(columns, axis=-1)


_slopes = {name: jax.jit(jax.jacfwd(_peaks[name])) for name in ("tension", "von_mises")}


@pytest.mark.parametrize(
    ("name", "b", "friction", "degrees"),
    [("tension", 0.2, 0.5, 30.0), ("tension", 1.0, 0.4, 35.0), ("von_mises", 0.5, 0.5, 45.0)],
)
def test_derivatives_at_the_edge_contain_its_motion(name, b, friction, degrees):
    """By axis ratio, friction and its angle: of the value against the largest of NumPy's field."""
    at = np.array([b, friction, degrees])
    expected = _differences(lambda x: np.array(_largest(name, *x)[0]), at[:], [1e-3, 1e-3, 0.1])
    found = np.asarray(_slopes[name](jnp.asarray(at)))
    if b < 1:
        np.testing.assert_allclose(found[0], expected, rtol=1e-7, atol=1e-9)
    else:
        # Beyond the circle the axes change places, and NumPy's field has none.
        np.testing.assert_allclose(found[0, 1:], expected[1:], rtol=1e-7, atol=1e-9)
    moved = _differences(
        lambda x: np.asarray(_peaks[name](jnp.asarray(x)))[1:], at, [1e-3, 1e-3, 0.1]
    )
    columns = slice(None) if b < 1 else slice(1, None)
    np.testing.assert_allclose(found[1:, columns], moved[:, columns], rtol=1e-6, atol=1e-8)


def test_second_derivatives_at_the_edge_contain_its_motion():
    """Against differences of the first."""
    at = np.array([0.2, 0.5, 30.0])
    second = jax.jit(jax.jacfwd(jax.jacfwd(lambda x: _peaks["tension"](x)[0])))
    slope = _slopes["tension"]
    expected = _differences(lambda x: np.asarray(slope(jnp.asarray(x)))[0], at, [1e-3, 1e-3, 0.1])
    np.testing.assert_allclose(second(jnp.asarray(at)), expected, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("measure", MEASURES)
def test_no_point_of_a_dense_grid_is_above_the_peak(measure):
    """Ellipses, friction and its directions at random; the edge and the inside."""
    rng = np.random.default_rng(5)
    count = 10
    ratio, friction = 10 ** rng.uniform(-1.0, 0.0, count), rng.uniform(0.0, 0.7, count)
    turn = rng.uniform(0.0, np.pi, count)
    axes = jnp.asarray(np.stack([np.ones(count), ratio], axis=-1))
    traction = jnp.asarray((friction * np.stack([np.cos(turn), np.sin(turn)])).T)

    def peak(semi_axes, pulled):
        return stress_peak(semi_axes, array(1.0), array(0.3), pulled, measure).value

    found = np.asarray(jax.jit(jax.vmap(peak))(axes, traction))
    share, angle, depth = np.meshgrid(
        [*np.linspace(0.0, 1.0, 12), 1.05],
        np.linspace(0.0, 2 * np.pi, 49)[:-1],
        [0.0, *np.geomspace(1e-2, 1.0, 9)],
    )
    unit = np.stack([share * np.cos(angle), share * np.sin(angle), depth], axis=-1).reshape(-1, 3)

    def largest(semi_axes, pulled):
        def at(point):
            return _MEASURES[measure](
                subsurface_stress(point, semi_axes, array(1.0), array(0.3), pulled)
            )

        return jnp.max(jax.vmap(at)(jnp.asarray(unit) * jnp.append(semi_axes, semi_axes[1])[None]))

    above = np.asarray(jax.jit(jax.vmap(largest))(axes, traction)) - found
    # The quadrature of the field beside the edge has errors of 1e-4; the grid is 0.05 wide.
    assert above.max() < 3e-4
    assert np.median(above) > -0.02
