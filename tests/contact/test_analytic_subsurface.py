"""Stress below contacts: closed forms, equilibrium, direct integration, limits, derivatives."""

import itertools

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from scenes import array
from scipy.special import ellipeinc, ellipkinc, elliprd, elliprf

from prsm_jax.contact import (
    axis_stress,
    line_subsurface_stress,
    max_shear_stress,
    principal_stresses,
    stress_peak,
    stress_peak_on_axis,
    subsurface_stress,
    von_mises_stress,
)
from prsm_jax.contact.special_functions import incomplete_elliptic_integrals
from prsm_jax.contact.special_functions._carlson import carlson_rf_and_rd

RATIO = 0.3  # Poisson's


@jax.jit
def _stresses(points, semi_axes, traction):
    """At several points under several contacts, p₀ = 1."""
    one, ratio = array(1.0), array(RATIO)
    return jax.vmap(lambda p, a: subsurface_stress(p, a, one, ratio, traction))(points, semi_axes)


def stresses(points, semi_axes, traction=(0.0, 0.0)):
    points = jnp.asarray(points, float).reshape(-1, 3)
    # One size for all, so that all share a program.
    count = len(points)
    padded = jnp.resize(points, (12, 3))
    axes = jnp.broadcast_to(jnp.asarray(semi_axes, float), (12, 2))
    return np.asarray(_stresses(padded, axes, jnp.asarray(traction, float)))[:count]


_carlson = jax.jit(carlson_rf_and_rd)


def test_carlson_integrals_against_scipy():
    x, y, z = np.meshgrid([0.0, 1e-6, 0.3], [1e-8, 0.5, 1.0], [0.2, 1.0, 3.0])
    given = [jnp.asarray(v.ravel()) for v in (x, y, z)]
    first, second = _carlson(*given)
    np.testing.assert_allclose(first, elliprf(*given), rtol=4e-15)
    np.testing.assert_allclose(second, elliprd(*given), rtol=4e-15)


@pytest.mark.parametrize("ratio", [1e3, 1e9, 1e18, 1e30, 1e60])
def test_carlson_integrals_of_very_unlike_arguments(ratio):
    """Contacts 1e15 times as long as wide have arguments whose ratio is 1e30."""
    values = [0.0, 1 / ratio, ratio**-0.5, 1.0]
    given = [
        (x, y, z) for x, y, z in itertools.product(values, repeat=3) if z > 0 and max(x, y) > 0
    ]
    found = _carlson(*(jnp.asarray(column) for column in zip(*given, strict=True)))
    with mpmath.workdps(40):
        first = [float(mpmath.elliprf(*map(mpmath.mpf, row))) for row in given]
        second = [float(mpmath.elliprd(*map(mpmath.mpf, row))) for row in given]
    np.testing.assert_allclose(found[0], first, rtol=2e-15)
    np.testing.assert_allclose(found[1], second, rtol=2e-15)


def _by_quadrature(square, depth, order):
    """∫ sin²θ/Δ and ∫ cos²θ/Δ up to arccot ζ, derived under the integral by κ², in 30 digits."""
    with mpmath.workdps(30):
        square, top = mpmath.mpf(square), mpmath.acot(mpmath.mpf(depth))
        factor = (-1) ** order * mpmath.rf(mpmath.mpf(1) / 2, order)

        def density(angle, power):
            delta = 1 - (1 - square) * mpmath.sin(angle) ** 2
            rest = mpmath.sin(angle) ** (2 * order) * mpmath.cos(angle) ** (2 - power)
            return factor * mpmath.sin(angle) ** power * rest / delta ** (order + mpmath.mpf(1) / 2)

        ends = [0, top / 2, top * 0.9, top * 0.99, top]
        found = [mpmath.quad(lambda a, p=p: density(a, p), ends) for p in (2, 0)]
        return [float(mpmath.mpf(one)) for one in found]


@jax.jit
def _by_square_and_depth(square, depth):
    """Both, their derivatives by κ² up to the second, that by ζ, and the first in reverse."""

    def both(square, depth):
        return jnp.stack(incomplete_elliptic_integrals(square, depth))

    first = jax.jacfwd(both)
    return (
        both(square, depth),
        first(square, depth),
        jax.jacfwd(first)(square, depth),
        jax.jacfwd(both, 1)(square, depth),
        jax.jacrev(both, (0, 1))(square, depth),
    )


@pytest.mark.parametrize("depth", [0.05, 0.4, 3.0])
@pytest.mark.parametrize("square", [1.0, 0.999, 0.3, 1e-2])
def test_incomplete_integrals_and_their_derivatives(square, depth):
    """By κ² also at a circle, where closed forms of the derivatives are quotients of zeros."""
    value, first, second, down, reverse = _by_square_and_depth(array(square), array(depth))
    # The derivatives of the duplications lose a digit or two next to the surface.
    for order, (found, tolerance) in enumerate(((value, 2e-15), (first, 2e-14), (second, 1e-13))):
        np.testing.assert_allclose(found, _by_quadrature(square, depth, order), rtol=tolerance)
    # The integrand at the upper end, times dθ/dζ.
    below = 1 + depth**2
    end = -1 / (below * np.sqrt(below * (square + depth**2)))
    np.testing.assert_allclose(down, [end, depth**2 * end], rtol=1e-15)
    np.testing.assert_allclose(reverse, [first, down], rtol=4e-15)


def test_derivatives_by_depth_have_no_loop_of_their_own():
    """They are elementary: one loop of duplications for the integrals, none besides."""

    def both(depth):
        return jnp.stack(incomplete_elliptic_integrals(array(0.5), depth))

    once, twice = (
        str(jax.make_jaxpr(one)(array(0.4))) for one in (jax.jacfwd(both), jax.hessian(both))
    )
    assert once.count(" scan[") == twice.count(" scan[") == 1


def thomas_hoersch(depth, ratio):
    """On the axis, z over b, as printed in textbooks; not for circles."""
    zeta, below = ratio * depth, 1 - ratio**2
    n = np.sqrt((ratio**2 + zeta**2) / (1 + zeta**2))
    angle = np.arctan2(1, zeta)
    first, second = ellipkinc(angle, below), ellipeinc(angle, below)
    along = -(1 - n) / 2 + zeta * (first - second)
    along_p = -n / ratio**2 + 1 + zeta * (second / ratio**2 - first)
    across = 1 / (2 * n) + 0.5 - n / ratio**2 + zeta * (second / ratio**2 - first)
    across_p = -1 + n + zeta * (first - second)
    scale = 2 * ratio / below
    return scale * np.array([along + RATIO * along_p, across + RATIO * across_p, -(1 / n - n) / 2])


@jax.jit
def _closed(depths, ratio):
    one, poisson = array(1.0), array(RATIO)
    return jax.vmap(lambda z: jnp.stack(axis_stress(z, one, ratio, one, poisson)))(depths)


@pytest.mark.parametrize("ratio", [0.02, 0.3, 0.8, 0.99])
def test_axis_by_closed_form_by_quadrature_and_by_textbook(ratio):
    """The quadrature leaves out 1e-12 at its ends; at 0.02 its nodes leave 1e-9."""
    depths = np.array([0.02, 0.5, 0.786, 2.0, 8.0])
    expected = np.array([thomas_hoersch(depth, ratio) for depth in depths])
    closed = _closed(jnp.asarray(depths * ratio), array(ratio))
    np.testing.assert_allclose(closed, expected, atol=2e-13)
    found = stresses([(0, 0, z * ratio) for z in depths], (1.0, ratio))
    diagonal = np.diagonal(found, axis1=1, axis2=2)
    np.testing.assert_allclose(diagonal, expected, atol=1e-8 if ratio < 0.1 else 1e-11)


def test_circle_on_its_axis():
    """σ_z = −1/(1 + z²), σ_r = −(1 + ν)(1 − z arctan 1/z) + ½/(1 + z²) (Johnson 1985, 3.45)."""
    z = np.array([0.0, 0.1, 0.48, 1.0, 5.0])
    found = stresses([(0, 0, v) for v in z], (1.0, 1.0))
    radial = -(1 + RATIO) * (1 - z * np.arctan2(1, z)) + 0.5 / (1 + z**2)
    expected = np.stack([radial, radial, -1 / (1 + z**2)], axis=1)
    np.testing.assert_allclose(np.diagonal(found, axis1=1, axis2=2), expected, atol=5e-12)


SURFACE = np.array(
    [(0.0, 0, 0), (0.5, 0.2, 0), (-0.3, 0.55, 0), (0.9, 0.1, 0), (1.3, 0.2, 0), (-0.2, 1.6, 0)]
)


@pytest.mark.parametrize("axes", [(1.0, 1.0), (1.0, 0.7), (0.6, 1.0), (1.0, 0.1)])
def test_surface_carries_the_pressure_and_the_friction_and_nothing_outside(axes):
    """The quadrature's worst place is the surface just outside."""
    traction = (0.3, -0.1)
    points = SURFACE * [*axes, 1.0]
    inside = 1 - SURFACE[:, 0] ** 2 - SURFACE[:, 1] ** 2
    pressure = np.sqrt(np.maximum(inside, 0.0))
    found = stresses(points, axes, traction)
    tolerance = 2e-5 if min(axes) < 0.5 else 2e-6
    np.testing.assert_allclose(found[:, 2, 2], -pressure, atol=tolerance)
    np.testing.assert_allclose(found[:, 0, 2], -traction[0] * pressure, atol=tolerance)
    np.testing.assert_allclose(found[:, 1, 2], -traction[1] * pressure, atol=tolerance)


def test_circle_with_friction_on_the_surface():
    """Hamilton 1983: σ_x = −π(4 + ν)/8 μ p₀ x/a from friction inside, and its trailing edge."""
    points = [(-1.0, 0, 0), (-0.4, 0.3, 0), (0.7, -0.2, 0)]
    slid, pressed = (stresses(points, (1.0, 1.0), (mu, 0.0)) for mu in (0.25, 0.0))
    expected = [-np.pi * (4 + RATIO) / 8 * 0.25 * x for x, _, _ in points]
    np.testing.assert_allclose((slid - pressed)[:, 0, 0], expected, atol=2e-7)
    trailing = (1 - 2 * RATIO) / 3 + np.pi * (4 + RATIO) / 8 * 0.25
    assert slid[0, 0, 0] == pytest.approx(trailing, abs=2e-7)


def _by_direct_integration(point, axes, traction, poisson):
    """Boussinesq's and Cerruti's point forces (Johnson 1985, 3.18, 3.75), summed up."""
    # x = a s cos t, y = b s sin t, s = sin u: the pressure's edge becomes smooth.
    u, weight = np.polynomial.legendre.leggauss(80)
    u, weight = np.pi / 4 * (u + 1), np.pi / 4 * weight
    angles = 2 * np.pi * np.arange(160) / 160
    s, t = np.meshgrid(np.sin(u), angles, indexing="ij")
    force = np.cos(u)[:, None] ** 2 * (weight * np.sin(u))[:, None] * (2 * np.pi / 160)
    force = force * axes[0] * axes[1] * np.ones_like(s)
    total = np.zeros((3, 3))
    x0, y0 = point[0] - axes[0] * s * np.cos(t), point[1] - axes[1] * s * np.sin(t)

    def pressed(x, y, z):
        r, c = np.sqrt(x**2 + y**2 + z**2), 1 - 2 * poisson
        d = r + z
        xx = c * (z / r**3 - 1 / (r * d) + x**2 * (2 * r + z) / (r**3 * d**2)) - 3 * x**2 * z / r**5
        yy = c * (z / r**3 - 1 / (r * d) + y**2 * (2 * r + z) / (r**3 * d**2)) - 3 * y**2 * z / r**5
        xy = c * x * y * (2 * r + z) / (r**3 * d**2) - 3 * x * y * z / r**5
        deep = -3 * z**2 / r**5
        return np.array([[xx, xy, x * deep], [xy, yy, y * deep], [x * deep, y * deep, z * deep]])

    def pulled(x, y, z):
        r, c = np.sqrt(x**2 + y**2 + z**2), 1 - 2 * poisson
        d = r + z
        xx = -3 * x**3 / r**5 + c * (
            x / r**3 - 3 * x / (r * d**2) + x**3 / (r**3 * d**2) + 2 * x**3 / (r**2 * d**3)
        )
        yy = -3 * x * y**2 / r**5 + c * (
            x / r**3 - x / (r * d**2) + x * y**2 / (r**3 * d**2) + 2 * x * y**2 / (r**2 * d**3)
        )
        zz = -3 * x * z**2 / r**5
        xy = -3 * x**2 * y / r**5 + c * (
            -y / (r * d**2) + x**2 * y / (r**3 * d**2) + 2 * x**2 * y / (r**2 * d**3)
        )
        yz, xz = -3 * x * y * z / r**5, -3 * x**2 * z / r**5
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    total = pressed(x0, y0, point[2]) + traction[0] * pulled(x0, y0, point[2])
    turned = pulled(y0, -x0, point[2])
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    total = total + traction[1] * np.einsum("ia,abst,jb->ijst", quarter, turned, quarter)
    return np.sum(total * force, axis=(2, 3)) / (2 * np.pi)


def test_against_direct_integration_of_point_forces():
    """Full tensor, friction in any direction, beside and below an ellipse."""
    axes, traction = (1.0, 0.6), (0.2, -0.35)
    points = [(0.3, 0.2, 0.4), (-0.8, 0.1, 0.5), (1.4, -0.7, 0.6), (0.1, 0.9, 1.2)]
    expected = [_by_direct_integration(p, axes, traction, RATIO) for p in points]
    np.testing.assert_allclose(stresses(points, axes, traction), expected, atol=1e-9)


def test_equilibrium_and_derivatives_both_ways():
    """div σ = 0 by automatic differentiation, forward and reverse, also on the axis."""
    given = jnp.asarray([1.0, 0.4]), array(1.0), array(RATIO), jnp.asarray([0.2, 0.1])
    points = jnp.asarray([[0.0, 0.0, 0.3], [0.4, 0.1, 0.2], [1.1, -0.3, 0.05], [1e-9, 0, 0.5]])

    @jax.jit
    def both(points):
        def at(point):
            return subsurface_stress(point, *given)

        return jax.vmap(jax.jacfwd(at))(points), jax.vmap(jax.jacrev(at))(points)

    forward, reverse = both(points)
    np.testing.assert_allclose(np.einsum("pijj->pi", forward), 0.0, atol=2e-7)
    np.testing.assert_allclose(forward, reverse, atol=1e-10)
    step = 1e-5
    ahead = np.array([0, 0, step])
    moved = np.concatenate([np.asarray(points) + ahead, np.asarray(points) - ahead])
    shifted = stresses(moved, (1.0, 0.4), (0.2, 0.1))
    numeric = (shifted[:4] - shifted[4:]) / (2 * step)
    np.testing.assert_allclose(np.asarray(forward)[..., 2], numeric, atol=2e-7)


def test_needle_is_a_line():
    """McEwen's closed form with friction, across a needle; the ends are 1/κ away."""
    flat = jnp.asarray([(0.0, 0.786), (0.5, 0.3), (-0.5, 0.0), (1.5, 0.2), (-2.0, 0.1)])
    line = jax.jit(jax.vmap(lambda p: line_subsurface_stress(
        p, array(1.0), array(1.0), array(RATIO), array(0.2))))(flat)  # fmt: skip
    order = [1, 0, 2]
    points = np.stack([np.zeros(5), flat[:, 0], flat[:, 1]], axis=1)
    found = stresses(points, (2e3, 1.0), (0.0, 0.2))[:, order][:, :, order]
    # 64 nodes for κ = 5e-4, and the ends themselves.
    np.testing.assert_allclose(found, line, atol=3e-3)
    assert float(max_shear_stress(line[0])) == pytest.approx(0.300, abs=0.01)


def _from_the_surface(x, z, friction):
    """σ_x, σ_z, τ_xz below lines of force on a half-plane, summed over √(1 − s²) (Flamant).

    With s = cos v nothing cancels beside the edge at 1; panels halve towards it.
    """
    nodes, weights = np.polynomial.legendre.leggauss(24)
    ends = np.append(0.0, np.pi * 2.0 ** np.arange(-60, 1))
    half = np.diff(ends)[:, None] / 2
    v = ends[:-1, None] + half * (1 + nodes)
    distance = (x - 1) + 2 * np.sin(v / 2) ** 2
    line = 2 / np.pi * half * weights * np.sin(v) ** 2 / (distance**2 + z**2) ** 2
    n0, n1, n2, n3 = (np.sum(line * distance**k) for k in range(4))
    return (
        -z * n2 - friction * n3,
        -(z**3) * n0 - friction * z**2 * n1,
        -(z**2) * n1 - friction * z * n2,
    )


@pytest.mark.parametrize(
    ("x", "z"), [(1.0, 1e-12), (1.0, 1e-9), (1.0, 1e-5), (1.0, 0.4), (1.02, 0.3), (1.5, 0.2)]
)
def test_below_and_beside_the_edge_of_a_line(x, z):
    """All digits, however close to the edge, where stresses rise as the root of the depth."""
    one = array(1.0)
    found = line_subsurface_stress(array([x, z]), one, one, array(RATIO), array(0.2))
    expected = _from_the_surface(x, z, 0.2)
    np.testing.assert_allclose((found[0, 0], found[2, 2], found[0, 2]), expected, rtol=1e-13)
    np.testing.assert_allclose(found[1, 1], RATIO * (expected[0] + expected[1]), rtol=1e-13)


def test_turning_the_axes_turns_the_stress():
    one = stresses([(0.1, 0.2, 0.3)], (0.5, 1.0), (0.3, 0.1))[0]
    other = stresses([(0.2, 0.1, 0.3)], (1.0, 0.5), (0.1, 0.3))[0]
    order = [1, 0, 2]
    np.testing.assert_allclose(one, other[order][:, order], rtol=1e-12)


def test_measures_against_eigenvalues():
    random = np.random.default_rng(5).normal(size=(40, 3, 3))
    tensors = random + random.transpose(0, 2, 1)
    tensors[0], tensors[1] = np.diag([2.0, 2.0, -1.0]), np.eye(3)
    values = np.linalg.eigvalsh(tensors)[:, ::-1]
    given = jnp.asarray(tensors)
    np.testing.assert_allclose(principal_stresses(given), values, atol=1e-7)
    np.testing.assert_allclose(
        max_shear_stress(given), (values[:, 0] - values[:, 2]) / 2, atol=1e-7
    )
    differences = sum((values[:, i] - values[:, i - 1]) ** 2 for i in range(3))
    np.testing.assert_allclose(von_mises_stress(given), np.sqrt(differences / 2), atol=1e-12)
    for measure in (von_mises_stress, max_shear_stress):
        slopes = jax.vmap(jax.grad(measure))(given)
        assert np.all(np.isfinite(slopes))


@jax.jit
def _on_axis(ratio, poisson):
    peaks = [
        stress_peak_on_axis(array(1.0), ratio, array(1.0), poisson, name)
        for name in ("von_mises", "max_shear")
    ]
    return jnp.stack([v for p in peaks for v in (p.value, p.depth)])


def test_largest_stress_without_friction():
    """Circle, ν 0.3: 0.310 p₀ at 0.481 a, von Mises 0.620 p₀; needle: shear 0.300 p₀ at 0.786 b."""
    circle = _on_axis(array(1.0), array(RATIO))
    np.testing.assert_allclose(circle, [0.6200, 0.4809, 0.3100, 0.4809], atol=5e-5)
    needle = _on_axis(array(1e-3), array(RATIO))
    assert float(needle[2]) == pytest.approx(0.3003, abs=5e-4)
    assert float(needle[3]) == pytest.approx(0.786e-3, rel=1e-3)


def test_derivatives_of_the_largest_stress():
    """Envelope theorem for the value, implicit function theorem for the place."""

    def peak(given):
        found = stress_peak_on_axis(array(1.0), given[0], array(1.0), given[1], "max_shear")
        return jnp.stack([found.value, found.depth])

    here, change = jnp.asarray([0.6, RATIO]), jnp.asarray([0.8, 0.5])
    _, forward = jax.jit(lambda h, c: jax.jvp(peak, (h,), (c,)))(here, change)
    reverse = jax.jit(jax.jacrev(peak))(here) @ change
    np.testing.assert_allclose(forward, reverse, rtol=1e-10)
    step = 1e-4
    ends = [_on_axis(*(here + sign * step * change))[2:] for sign in (1, -1)]
    # The difference has an error of second order in the step, and that of its rounding.
    np.testing.assert_allclose(forward, (ends[0] - ends[1]) / (2 * step), rtol=1e-7)


def test_friction_brings_the_largest_stress_up():
    """Below the middle without friction, at the trailing edge of the surface with μ = 0.5."""

    @jax.jit
    def peak(friction):
        pulled = jnp.stack([friction, jnp.zeros_like(friction)])
        return stress_peak(jnp.asarray([1.0, 1.0]), array(1.0), array(RATIO), pulled)

    still, slow, fast = (peak(array(mu)) for mu in (0.0, 0.25, 0.5))
    assert float(still.value) == pytest.approx(0.6200, abs=5e-5)
    assert float(still.depth) == pytest.approx(0.4809, abs=5e-5)
    assert 0 < float(slow.depth) < float(still.depth)
    assert float(slow.position[0]) > 0.1
    np.testing.assert_allclose(fast.position, [-1.0, 0.0, 0.0], atol=1e-12)
    # Hamilton's stresses at that edge: pure surface stress of pressure plus friction.
    pressed = (1 - 2 * RATIO) / 3
    x = pressed + 0.5 * np.pi * (4 + RATIO) / 8
    y = -pressed + 0.5 * np.pi * 3 * RATIO / 8
    expected = np.sqrt(x**2 - x * y + y**2)
    assert float(fast.value) == pytest.approx(expected, rel=1e-6)
    slope = jax.jit(jax.grad(lambda mu: peak(mu).value))(array(0.25))
    numeric = (peak(array(0.2501)).value - peak(array(0.2499)).value) / 2e-4
    assert float(slope) == pytest.approx(float(numeric), rel=1e-5)


def test_no_stress_without_a_load():
    """Contacts with and without load in one batch: zero stress and derivatives that are numbers."""
    poisson, pulled = array(RATIO), jnp.asarray([0.2, 0.1])

    def values(given):
        peak, depth = given[2], given[3]
        elliptical = subsurface_stress(
            jnp.stack([depth / 3, depth / 5, depth]), given[:2], peak, poisson, pulled, nodes=16
        )
        axis = jnp.stack(axis_stress(depth, given[0], given[1], peak, poisson))
        line = line_subsurface_stress(given[2:] * 0 + depth, given[1], peak, poisson, pulled[0])
        return jnp.concatenate([elliptical.ravel(), axis, line.ravel()])

    @jax.jit
    @jax.vmap
    def everything(given):
        value, slope = jax.linearize(values, given)
        (reverse,) = jax.vmap(jax.linear_transpose(slope, given))(jnp.eye(len(value)))
        return value, jax.vmap(slope)(jnp.eye(4)).T, reverse

    # Semi-axes, largest pressure, depth.
    given = [[0, 0, 0, 1.0], [0, 0, 0, 0], [2, 1, 1, 0.5], [2, 1, 1, 0], [2, 1, 1, 1e-6]]
    value, forward, reverse = everything(jnp.asarray(given))
    assert jnp.all(value[:2] == 0)
    assert jnp.count_nonzero(value[2]) == 17
    for slopes in (forward, reverse):
        assert jnp.all(slopes[:2] == 0)
    np.testing.assert_allclose(forward[2], reverse[2], atol=1e-12)
    # On the axis the surface is an ordinary place; the stress bends by less than 1e-5 there.
    np.testing.assert_allclose(forward[3, 9:12], reverse[3, 9:12], atol=1e-12)
    np.testing.assert_allclose(forward[3, 9:12], forward[4, 9:12], atol=1e-5)


@pytest.mark.usefixtures("unchecked")
def test_wrong_choices_are_refused():
    given = array(1.0), array(1.0), array(1.0), array(RATIO)
    with pytest.raises(ValueError, match="choose one of von_mises"):
        stress_peak_on_axis(*given, "mises")  # pyright: ignore[reportArgumentType]
    point, axes = jnp.zeros(3), jnp.ones(2)
    with pytest.raises(ValueError, match="nodes is 7"):
        subsurface_stress(point, axes, array(1.0), array(RATIO), nodes=7)
