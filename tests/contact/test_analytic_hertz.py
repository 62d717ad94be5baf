"""Hertz contact: integrals, axis ratio, scaling laws, circles, no load, approximations."""

import equinox as eqx
import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
import scipy.special
from hypothesis import given, strategies as st
from scenes import array

from prsm_jax.contact import (
    APPROXIMATIONS,
    associated_elliptic_integrals,
    axis_ratio_of,
    complete_elliptic_integrals,
    hertz_contact,
)
from prsm_jax.contact.hertz._axis_ratio import antoine_log_axis_ratio
from prsm_jax.contact.hertz._hertz import _inverse_cube_root

_integrals = jax.jit(complete_elliptic_integrals)
_associated = jax.jit(associated_elliptic_integrals)
_axis_ratio = jax.jit(axis_ratio_of)
_hertz = eqx.filter_jit(hertz_contact)

#: From needles to circles.
RATIOS = np.concatenate([np.logspace(-8, 0, 60), 1 - np.logspace(-16, -1, 20)])


def test_elliptic_integrals_against_scipy():
    """Legendre's and Carlson's forms in SciPy.

    K to a few units of the last place. E is K − D + κ² D, which loses K/E ≤ 20 units for needles.
    """
    first, second = _integrals(jnp.asarray(RATIOS))
    square = RATIOS**2
    zero, one = np.zeros_like(square), np.ones_like(square)
    carlson_first = scipy.special.elliprf(zero, square, one)
    carlson_second = carlson_first - (1 - square) / 3 * scipy.special.elliprd(zero, square, one)
    np.testing.assert_allclose(first, scipy.special.ellipkm1(square), rtol=3e-15)
    np.testing.assert_allclose(first, carlson_first, rtol=3e-15)
    np.testing.assert_allclose(second, scipy.special.ellipe(1 - square), rtol=8e-15)
    np.testing.assert_allclose(second, carlson_second, rtol=1e-14)


@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 0.05, 0.5, 0.9, 0.999, 1 - 1e-9, 1.0])
def test_elliptic_integrals_against_mpmath(ratio):
    """K, B and D in 40 digits: no cancellation in D = (K − E)/m and B = K − D near the circle."""
    with mpmath.workdps(40):
        exact = mpmath.mpf(ratio)
        m = 1 - exact**2
        first, second = mpmath.ellipk(m), mpmath.ellipe(m)
        d = (first - second) / m if m else mpmath.pi / 4
        expected = [float(v) for v in (first, first - d, d)]
    # B = K − D loses K/B ≤ 15 units in the last place for the needle.
    np.testing.assert_allclose(_associated(array(ratio)), expected, rtol=4e-15)


@pytest.mark.parametrize("ratio", [1e-5, 1e-3, 0.03, 0.3, 0.7, 0.95, 0.999, 0.999999])
def test_axis_ratio_against_mpmath(ratio):
    """Forward in 40 digits: from κ to τ = (B − A)/(A + B), back by the package."""
    with mpmath.workdps(40):
        exact = mpmath.mpf(ratio)
        m = 1 - exact**2
        first, second = mpmath.ellipk(m), mpmath.ellipe(m)
        quotient = (first - second) / (second / exact**2 - first)
        anisotropy = float((1 - quotient) / (1 + quotient))
    # τ → 1 for needles: its last digit moves κ by 1e-16/(1 − τ).
    tolerance = 4e-15 + 3e-16 / (1 - anisotropy)
    assert _axis_ratio(array(anisotropy)) == pytest.approx(ratio, rel=tolerance)


def test_axis_ratio_is_regular_at_the_circle():
    """κ = 1 − (4/3) τ + (8/9) τ² + …: value, slope and curvature; and κ never exceeds 1."""
    # The integrals' polynomials are within 7e-17; their second derivatives within 1e-11.
    for derivative, expected, within in (
        (axis_ratio_of, 1.0, 1e-15),
        (jax.grad(axis_ratio_of), -4 / 3, 1e-12),
        (jax.jacfwd(axis_ratio_of), -4 / 3, 1e-12),
        (jax.grad(jax.grad(axis_ratio_of)), 16 / 9, 1e-11),
    ):
        assert derivative(array(0.0)) == pytest.approx(expected, rel=within)
        assert derivative(array(1e-9)) == pytest.approx(expected, rel=1e-7)
    assert np.all(_axis_ratio(jnp.linspace(0.0, 1e-14, 50)) <= 1)


FORCES, TOTALS, SHAPES = st.floats(1e-3, 1e5), st.floats(1, 1e4), st.floats(0, 0.999)


@given(FORCES, TOTALS, SHAPES, st.floats(1e9, 1e12))
def test_hertz_equations(force, total, shape, modulus):
    """p₀ = 3F/2πab, δ = p₀ b K/E*, the ellipse equation, and 1.5 = tangent/secant stiffness."""
    result = _hertz(array(force), array(total), array((shape * total) ** 2), array(modulus))
    major, minor = float(result.semi_major), float(result.semi_minor)
    first, second = (float(v) for v in _integrals(array(minor / major)))
    pressure = 3 * force / (2 * np.pi * major * minor)
    assert result.max_pressure == pytest.approx(pressure, rel=1e-13)
    assert result.approach == pytest.approx(pressure * minor * first / modulus, rel=1e-13)
    assert result.stiffness == pytest.approx(force / float(result.approach), rel=1e-13)
    assert result.stiffness_tangent == pytest.approx(1.5 * float(result.stiffness), rel=1e-15)
    ratio_squared = (minor / major) ** 2
    cubed = 3 * force * second / (2 * np.pi * modulus * ratio_squared * total)
    assert major == pytest.approx(cubed ** (1 / 3), rel=1e-13)


@given(FORCES, TOTALS, SHAPES)
def test_scaling_laws(force, total, shape):
    """Eight times the force: twice pressure and axes, four times the approach."""
    gap = array(total), array((shape * total) ** 2), array(1e11)
    one, eight = _hertz(array(force), *gap), _hertz(array(8 * force), *gap)
    for name, factor in (("max_pressure", 2), ("semi_major", 2), ("approach", 4)):
        expected = factor * float(getattr(one, name))
        assert getattr(eight, name) == pytest.approx(expected, rel=1e-14)


def test_tangent_stiffness_is_the_derivative():
    """dF/dδ = 1/(dδ/dF), by automatic differentiation of the approach."""
    gap = array(100.0), array(900.0), array(1e11)
    slope = jax.jit(jax.grad(lambda force: hertz_contact(force, *gap).approach))(array(250.0))
    expected = 1 / float(slope)
    assert _hertz(array(250.0), *gap).stiffness_tangent == pytest.approx(expected, rel=1e-13)


@jax.jit
def _all_results(force, total, difference, modulus):
    # As from a geometry: (B − A)² is a sum of squares that vanish at the circle.
    return jnp.stack(jax.tree.leaves(hertz_contact(force, total, difference**2, modulus)))


_forward = jax.jit(jax.jacfwd(_all_results, argnums=(0, 1, 2, 3)))
_reverse = jax.jit(jax.jacrev(_all_results, argnums=(0, 1, 2, 3)))


@pytest.mark.parametrize("force", [0.0, -5.0, 1e-12, 100.0])
@pytest.mark.parametrize("difference", [0.0, 1e-150, 1e-12, 5.0])
def test_values_and_gradients_are_finite_at_circles_and_without_load(force, difference):
    inputs = array(force), array(100.0), array(difference), array(1e11)
    values = np.asarray(_all_results(*inputs))
    assert np.all(np.isfinite(values))
    if force <= 0:
        # The elliptic integral is geometry, not load.
        assert np.all(values[:-1] == 0)
    scales = force, 100.0, 100.0, 1e11
    pairs = zip(_forward(*inputs), _reverse(*inputs), scales, strict=True)
    for one, other, scale in pairs:
        assert np.all(np.isfinite(one))
        # Elasticities agree to rounding.
        elasticity = np.abs(np.asarray(one - other)) * abs(scale)
        assert np.all(elasticity <= 1e-13 * np.abs(values))


def test_pressure_is_even_in_the_anisotropy():
    """Near the circle p₀ changes with (B − A)² only, at a finite rate: no kink."""

    def pressure(difference):
        square = difference**2
        return hertz_contact(array(100.0), array(100.0), square, array(1e11)).max_pressure

    circle, slope = jax.value_and_grad(pressure)(array(0.0))
    assert slope == 0
    changes = [float(pressure(array(d)) / circle - 1) for d in (0.5, 1.0, 2.0)]
    assert changes[1] / changes[0] == pytest.approx(4, rel=2e-3)
    assert changes[2] / changes[1] == pytest.approx(4, rel=8e-3)


@pytest.mark.parametrize(
    ("method", "pressure_bound", "approach_bound"),
    [
        # The published bound, 3e-6, is for p₀ and δ in closed form; here K and E are exact.
        ("antoine", 3e-8, 3e-8),
        ("power", 3e-5, 3e-5),
        ("hamrock_brewe", 1.0e-2, 1.9e-2),
        ("hamrock_brewe_log", 1.7e-2, 4.3e-2),
        ("lisowski", 2.1e-3, 1.0e-3),
    ],
)
def test_errors_of_the_approximations(method, pressure_bound, approach_bound):
    """Largest error over B/A = 1.15 to 1.6, where roller screws live; each bound is half used up.

    So the test fails both if a formula gets worse and if its stated error is a wild overestimate.
    """
    quotient = np.linspace(1.15, 1.6, 46)
    shape = jnp.asarray(((quotient - 1) / (quotient + 1)) ** 2)

    @jax.jit
    def evaluate(squares):
        def at(square):
            inputs = array(100.0), array(1.0), square, array(1e11)
            return [
                (r.max_pressure, r.approach)
                for r in (hertz_contact(*inputs, m) for m in ("exact", method))
            ]

        return jax.vmap(at)(squares)

    exact, approximate = evaluate(shape)
    errors = [np.max(np.abs(a / e - 1)) for a, e in zip(approximate, exact, strict=True)]
    assert errors[0] <= 1.05 * pressure_bound
    assert errors[1] <= 1.05 * approach_bound
    assert errors[0] > pressure_bound / 2


@pytest.mark.usefixtures("unchecked")
def test_methods_are_the_ones_that_are_documented():
    names = {"antoine", "power", "hamrock_brewe", "hamrock_brewe_log", "lisowski"}
    assert set(APPROXIMATIONS) == names
    with pytest.raises(ValueError, match="choose one of exact, antoine"):
        hertz_contact(array(1.0), array(1.0), array(0.0), array(1.0), "hertz")


def test_inverse_cube_root_over_forty_decades():
    """Of cubes of semi-axes far below an atom up to those of planets, and its derivative."""
    cubes = np.logspace(-69, 30, 397)
    root, slope = jax.jit(jax.vmap(jax.value_and_grad(_inverse_cube_root)))(jnp.asarray(cubes))
    np.testing.assert_allclose(root, 1 / np.cbrt(cubes), rtol=2e-15)
    np.testing.assert_allclose(slope, -1 / (3 * np.cbrt(cubes) * cubes), rtol=3e-15)


def test_antoines_axis_ratio_as_far_as_its_authors_say():
    """Off by at most 6e-6 up to B/A = 1e4: B/A of κ by Legendre's integrals in SciPy."""
    ratios = np.linspace(3e-3, 0.999, 300)
    parameter = 1 - ratios**2
    first, second = scipy.special.ellipkm1(ratios**2), scipy.special.ellipe(parameter)
    quotient = (second / ratios**2 - first) / (first - second)
    assert quotient.max() > 1e4
    found = np.exp(antoine_log_axis_ratio(jnp.log(jnp.asarray(quotient))))
    within = quotient <= 1e4
    np.testing.assert_allclose(found[within], ratios[within], rtol=6e-6)


@pytest.mark.parametrize(
    ("force", "total", "difference", "modulus"),
    [(60.0, -320.0, 160.0, 1e11), (60.0, np.inf, 160.0, 1e11)]
    + [(60.0, 320.0, 160.0, modulus) for modulus in (-1e11, 0.0, np.inf)],
)
def test_what_touches_in_no_ellipse_gives_no_number(force, total, difference, modulus):
    """Two hollow bodies had positive semi-axes and 3.3 GPa."""
    found = _hertz(array(force), array(total), array(difference**2), array(modulus))
    assert all(np.isnan(leaf) for leaf in jax.tree.leaves(found))


def test_forces_below_the_range_of_the_cube_root_are_none():
    """A semi-axis of 1e-48 m is that of no body; without this it is 0 and its stiffness is not."""
    given = array(320.0), array(160.0**2), array(115e9)
    least, slope = jax.jvp(lambda f: hertz_contact(f, *given), (array(1e-132),), (array(1.0),))
    assert all(leaf == 0 or name == 7 for name, leaf in enumerate(jax.tree.leaves(slope), 1))
    assert float(least.semi_major) == float(least.stiffness) == 0
    whole = _hertz(array(60.0), *given)
    for force in (1e-20, 1e-50, 1e-80, 1e-110, 1e-120):
        larger = _hertz(array(force), *given)
        share = (force / 60) ** (1 / 3)
        assert larger.stiffness / whole.stiffness == pytest.approx(share, rel=1e-13)
