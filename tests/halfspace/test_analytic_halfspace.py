"""Half-space contact on a grid: influence, Hertz, other closed forms, conditions, invariance."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
import scipy.special
from hypothesis import given, settings, strategies as st
from scenes import array

from prsm_jax.contact import hertz_contact
from prsm_jax.halfspace import Grid, grid_over, normal_displacement, solve_contact

MODULUS = array(1.15e11)


@functools.partial(eqx.filter_jit)
def solve(grid, gap, load, material=None, tolerance=1e-8):
    return solve_contact(grid, gap, MODULUS, load=load, material=material, tolerance=tolerance)


@eqx.filter_jit
def pressed(grid, gap, approaches):
    """At several approaches in one batch."""
    return jax.vmap(lambda d: solve_contact(grid, gap, MODULUS, approach=d))(approaches)


def paraboloid(grid, first, second):
    x, y = grid.points
    return first * x**2 + second * y**2


# --- influence ---


def _point_by_quadrature(x, y, spacing_x, spacing_y):
    """∬ 1/(π E* r) over one cell centred on the origin, seen from (x, y)."""
    value, _ = scipy.integrate.dblquad(  # pyright: ignore[reportAssignmentType]
        lambda v, u: 1 / (np.pi * float(MODULUS) * np.hypot(x - u, y - v)),
        -spacing_x / 2,
        spacing_x / 2,
        -spacing_y / 2,
        spacing_y / 2,
        epsrel=1e-10,
    )
    return value


def test_influence_is_that_of_loaded_rectangles():
    """Against quadrature away from the cell; symmetric and positive definite; nothing wraps."""
    grid = Grid((6, 5), 2e-5, 3e-5)
    count = 30
    units = jnp.eye(count).reshape(count, 6, 5)
    columns = jax.vmap(lambda p: normal_displacement(grid, p, MODULUS))(units)
    matrix = np.asarray(columns).reshape(count, count)
    # The transform's rounding, of the largest influence.
    np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=1e-14 * matrix.max())
    assert np.linalg.eigvalsh((matrix + matrix.T) / 2).min() > 0
    for i, j in ((1, 0), (0, 2), (5, 4), (3, 1)):
        expected = _point_by_quadrature(2e-5 * i, 3e-5 * j, 2e-5, 3e-5)
        assert matrix[0, 5 * i + j] == pytest.approx(expected, rel=1e-9)
    # Centre of a square of side h: (4 h/π E*) asinh 1.
    square = normal_displacement(
        Grid((4, 4), 1e-5, 1e-5), jnp.zeros((4, 4)).at[1, 2].set(1.0), MODULUS
    )
    assert square[1, 2] == pytest.approx(4e-5 * np.arcsinh(1) / (np.pi * float(MODULUS)), rel=1e-12)


# --- closed forms ---

#: A and B [1/m]: a sphere, and the ratio B/A of Lisowski's screw side.
SHAPES = {"sphere": (100.0, 100.0), "ellipse": (68.456, 96.673)}


@pytest.mark.parametrize("shape", SHAPES)
def test_hertz_and_order_of_convergence(shape):
    """Within 0.3 % on 128 × 128 asked; 0.01 % reached, and errors fall as the square of the cells.

    Between two grids the ratio scatters with how the ellipse cuts the cells: over two halvings of
    the cells a factor of 16 is allowed to be 8.
    """
    first, second = SHAPES[shape]
    exact = hertz_contact(
        array(100.0), array(first + second), array((second - first) ** 2), MODULUS
    )
    errors = {}
    for count in (32, 128):
        grid = grid_over((count, count), 1.3 * exact.semi_major, 1.3 * exact.semi_minor)
        found = solve(grid, paraboloid(grid, first, second), array(100.0))
        assert int(found.code) == 0
        assert found.load == pytest.approx(100.0, rel=1e-12)
        errors[count] = [
            abs(float(a / b - 1))
            for a, b in (
                (found.max_pressure, exact.max_pressure),
                (found.approach, exact.approach),
            )
        ]
    assert max(errors[128]) < 1e-4
    assert max(errors[32]) < 1e-3
    assert max(errors[128]) < max(errors[32]) / 8
    # Contact area counts whole cells: first order.
    area = np.pi * float(exact.semi_major * exact.semi_minor)
    assert found.area == pytest.approx(area, rel=5e-3)
    x, y = grid.points
    inside = jnp.maximum(1 - (x / exact.semi_major) ** 2 - (y / exact.semi_minor) ** 2, 0.0)
    expected = exact.max_pressure * jnp.sqrt(inside)
    # Largest at the rim, where the pressure has an infinite slope: √(h/a) of a cell cut by it.
    assert jnp.max(jnp.abs(found.pressure - expected)) < 0.1 * exact.max_pressure
    assert jnp.mean(jnp.abs(found.pressure - expected)) < 1e-3 * exact.max_pressure


def _axisymmetric(slope, radius):
    """Load and approach at a contact radius, by Abel's transform (Johnson 1985, section 5.2)."""
    # r = a sin t removes the root.
    load, _ = scipy.integrate.quad(
        lambda t: (radius * np.sin(t)) ** 2 * slope(radius * np.sin(t)), 0, np.pi / 2
    )
    approach, _ = scipy.integrate.quad(lambda t: slope(radius * np.sin(t)), 0, np.pi / 2)
    return 2 * float(MODULUS) * load, radius * approach


_CORE, _ROUNDING = 0.6e-4, 2e-3
#: Gap and its slope as functions of the radius [m].
PROFILES = {
    "cone": (lambda r: 0.02 * r, lambda r: 0.02),
    "quartic": (lambda r: 1e10 * r**4, lambda r: 4e10 * r**3),
    "rounded punch": (
        lambda r: np.maximum(r - _CORE, 0) ** 2 / (2 * _ROUNDING),
        lambda r: max(r - _CORE, 0) / _ROUNDING,
    ),
}


@pytest.mark.parametrize("profile", PROFILES)
def test_closed_forms_that_are_not_hertz(profile):
    """Axisymmetric punches: load ↔ approach ↔ contact radius; and the other way by the approach."""
    gap, slope = PROFILES[profile]
    radius = 1e-4
    load, approach = _axisymmetric(slope, radius)
    grid = grid_over((32, 32), array(1.3 * radius), array(1.3 * radius))
    x, y = (np.asarray(c) for c in grid.points)
    heights = jnp.asarray(gap(np.hypot(x, y)))
    found = solve(grid, heights, array(load))
    assert int(found.code) == 0
    # 25 cells across: the error of Hertz contacts on this grid is 0.04 %; a cone's tip costs more.
    assert found.approach == pytest.approx(approach, rel=4e-3)
    assert found.area == pytest.approx(np.pi * radius**2, rel=5e-2)
    if profile != "rounded punch":
        back = pressed(grid, heights, array([found.approach, 0.5 * found.approach]))
        np.testing.assert_allclose(back.pressure[0], found.pressure, rtol=0, atol=1e-6 * 1e9)
        exponent = 2.0 if profile == "cone" else 5 / 4
        # F ∝ δ² for a cone, δ^{5/4} for r⁴; half the radius has a coarser grid.
        assert back.load[1] / back.load[0] == pytest.approx(0.5**exponent, rel=2e-2)


def test_flat_punch_by_its_mask():
    """A sharp edge: no material beyond it. δ = F/(2 a E*), first order in the cells' size."""
    grid = grid_over((64, 64), array(1.2e-4), array(1.2e-4))
    x, y = grid.points
    material = jnp.hypot(x, y) < 1e-4
    found = solve(grid, jnp.zeros(grid.shape), array(10.0), material)
    assert int(found.code) == 0
    assert not jnp.any(found.contact & ~material)
    radius = np.sqrt(float(jnp.sum(material.astype(float)) * grid.cell_area) / np.pi)
    assert found.approach == pytest.approx(10.0 / (2 * radius * float(MODULUS)), rel=1e-2)
    # p = F/(2πa²) at the centre.
    assert found.pressure[32, 32] == pytest.approx(10.0 / (2 * np.pi * radius**2), rel=2e-2)


# --- conditions and symmetries ---

_GRID = Grid((32, 32), 1e-5, 1e-5)
_ROUGH = np.random.default_rng(3).normal(size=(2, 32, 32))


def _rough(weights):
    x, y = _GRID.points
    smooth = 60 * x**2 + 90 * y**2 + 10 * x * y
    return smooth + 1e-7 * (
        weights[0] * jnp.asarray(_ROUGH[0]) + weights[1] * jnp.asarray(_ROUGH[1])
    )


WEIGHTS = st.tuples(st.floats(-1, 1), st.floats(-1, 1))


@settings(max_examples=10)
@given(WEIGHTS, st.floats(0.01, 20.0))
def test_conditions_of_contact(weights, load):
    """p ≥ 0, gap ≥ 0, one of both 0; the load is carried; and the same solution by its approach."""
    gap = _rough(weights)
    found = solve(_GRID, gap, array(load))
    assert int(found.code) == 0
    assert jnp.all(found.pressure >= 0)
    scale = float(jnp.max(found.displacement))
    assert jnp.min(found.separation) >= -1e-8 * scale
    assert jnp.max(jnp.where(found.contact, jnp.abs(found.separation), 0.0)) <= 1e-8 * scale
    assert jnp.sum(found.pressure) * _GRID.cell_area == pytest.approx(load, rel=1e-12)
    np.testing.assert_allclose(
        found.displacement, normal_displacement(_GRID, found.pressure, MODULUS), rtol=1e-12
    )
    back = pressed(_GRID, gap, found.approach[None])
    assert back.load[0] == pytest.approx(load, rel=1e-5)


@settings(max_examples=5)
@given(WEIGHTS, st.floats(0.1, 10.0), st.floats(1e-3, 1e3))
def test_turned_mirrored_and_scaled(weights, load, size):
    """Turned by 90° the pressures turn; all lengths × s and the load × s²: the same pressures."""
    gap = _rough(weights)
    found = solve(_GRID, gap, array(load))
    # What the tolerance on the gap leaves in the pressures of single cells.
    allowed = 1e-5 * float(jnp.max(found.pressure))
    turned = solve(_GRID, jnp.rot90(gap), array(load))
    np.testing.assert_allclose(turned.pressure, jnp.rot90(found.pressure), rtol=0, atol=allowed)
    grid = Grid(_GRID.shape, size * _GRID.spacing_x, size * _GRID.spacing_y)
    scaled = solve(grid, size * gap, array(size**2 * load))
    np.testing.assert_allclose(scaled.pressure, found.pressure, rtol=0, atol=allowed)
    assert scaled.approach == pytest.approx(size * float(found.approach), rel=1e-6)


def test_a_constant_in_the_gap_moves_the_approach_only():
    gap = _rough((1.0, 0.5))
    one, other = (solve(_GRID, gap + shift, array(3.0)) for shift in (0.0, 1e-4))
    np.testing.assert_allclose(one.pressure, other.pressure, rtol=0, atol=1e5)
    assert other.approach - one.approach == pytest.approx(1e-4, rel=1e-9)


# --- how it went ---


def test_codes():
    """0 found, 1 not converged (or not finite), 2 at the rim of the grid, 3 no contact."""
    x, y = _GRID.points
    gap = 60 * x**2 + 90 * y**2
    codes = [int(solve(_GRID, gap, array(load)).code) for load in (5.0, 1e4, 0.0, -3.0, np.nan)]
    assert codes == [0, 2, 3, 3, 1]
    assert int(solve(_GRID, gap.at[3, 4].set(jnp.nan), array(5.0)).code) == 1
    assert int(solve(_GRID, gap, array(5.0), None, -1.0).code) == 1
    batch = pressed(_GRID, gap, jnp.asarray([-1e-6, 1e-7, 1e-6, 1e-3]))
    assert batch.code.tolist() == [3, 0, 0, 2]
    assert batch.load[0] == 0
    assert np.all(np.isfinite(batch.pressure))
    unloaded = solve(_GRID, gap, array(0.0))
    assert unloaded.approach == jnp.min(gap)
    assert unloaded.max_pressure == 0


@pytest.mark.usefixtures("unchecked")
def test_misuse_is_refused():
    gap = jnp.zeros(_GRID.shape)
    with pytest.raises(ValueError, match="exactly one"):
        solve_contact(_GRID, gap, MODULUS)
    with pytest.raises(ValueError, match="exactly one"):
        solve_contact(_GRID, gap, MODULUS, load=1.0, approach=1e-6)
    with pytest.raises(ValueError, match="they must be equal"):
        solve_contact(_GRID, gap[:-1], MODULUS, load=1.0)
    with pytest.raises(ValueError, match="at least 4 each"):
        Grid((2, 32), 1e-5, 1e-5)
