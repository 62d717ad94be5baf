"""Derivatives of contacts on grids: forward = reverse = finite differences, and those of Hertz."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, stage, thread

import prsm_jax as prsm
from prsm_jax.contact import hertz_contact
from prsm_jax.halfspace import Grid, flank_contact, grid_over, solve_contact

_RANDOM = np.random.default_rng(5)
_BASE = {"load": 100.0, "first": 68.456, "second": 96.673, "modulus": 1.15e11}
NAMES = (*_BASE, "spacing_x", "spacing_y")


def _values(changes):
    """Load, curvatures and modulus changed by shares; spacings beside those of the ellipse."""
    numbers = {
        name: value * (1 + change)
        for (name, value), change in zip(_BASE.items(), changes[:4], strict=True)
    }
    total, difference = numbers["first"] + numbers["second"], numbers["second"] - numbers["first"]
    exact = hertz_contact(numbers["load"], total, difference**2, numbers["modulus"])
    half_x, half_y = exact.semi_major * (1 + changes[4]), exact.semi_minor * (1 + changes[5])
    grid = grid_over((32, 32), 1.3 * half_x, 1.3 * half_y)
    x, y = grid.points
    gap = numbers["first"] * x**2 + numbers["second"] * y**2
    found = solve_contact(
        grid, gap, numbers["modulus"], load=numbers["load"], tolerance=1e-12, max_iterations=200
    )
    # In units of order one.
    return jnp.log(
        jnp.stack([found.max_pressure, found.approach, exact.max_pressure, exact.approach])
    )


def test_derivatives_against_hertz_and_finite_differences():
    """A grid that grows with the ellipse has the derivatives of exact Hertz theory."""
    step, none = 1e-4, jnp.zeros(6)

    # One program gives the values for the differences as well: compiling is what costs.
    @jax.jit
    def everything(changes):
        value, slope = jax.linearize(_values, changes)
        (reverse,) = jax.vmap(jax.linear_transpose(slope, changes))(jnp.eye(len(value)))
        return value, jax.vmap(slope)(jnp.eye(6)).T, reverse

    _, forward, reverse = (np.asarray(rows) for rows in everything(none))
    # Both solve the same linear system, to 1e-11.
    np.testing.assert_allclose(forward, reverse, rtol=0, atol=1e-9)
    ends = [[everything(sign * step * axis)[0] for axis in jnp.eye(6)] for sign in (1, -1)]
    differences = (np.asarray(ends[0]) - np.asarray(ends[1])).T / (2 * step)
    # Truncation of second order in the step; no cell changes sides within it.
    np.testing.assert_allclose(forward, differences, rtol=0, atol=1e-6)
    # p₀ and δ to the grid's 0.1 %; spacings by themselves change nothing but the error.
    np.testing.assert_allclose(forward[:2, :4], forward[2:, :4], rtol=0, atol=1e-3)
    assert np.max(np.abs(forward[:2, 4:])) < 1e-2


_GRID = Grid((16, 16), 1e-5, 1e-5)
_X, _Y = _GRID.points
_GAP = 60 * _X**2 + 90 * _Y**2 + 1e-7 * jnp.asarray(_RANDOM.normal(size=(16, 16)))
_MATERIAL = _X < 3e-5


def _field(control, gap, target):
    options = {control: target}
    found = solve_contact(
        _GRID, gap, array(1.15e11), material=_MATERIAL, tolerance=1e-12, **options
    )
    return found.pressure


@pytest.mark.parametrize(("control", "target"), [("load", 3.0), ("approach", 4e-7)])
def test_pressures_by_gap_heights(control, target):
    """A rough gap with an edge: both modes, finite differences, and a symmetric influence."""
    directions = 1e-7 * jnp.asarray(_RANDOM.normal(size=(2, 16, 16)))

    @jax.jit
    def everything(gap):
        value, slope = jax.linearize(lambda g: _field(control, g, array(target)), gap)
        pulled = jax.linear_transpose(slope, gap)
        return value, jax.vmap(slope)(directions), pulled(directions[1])[0]

    value, (first, second), pulled = everything(_GAP)
    step = 1e-6
    ends = [everything(_GAP + sign * step * directions[0])[0] for sign in (1, -1)]
    difference = (ends[0] - ends[1]) / (2 * step)
    scale = float(jnp.max(jnp.abs(first)))
    assert jnp.sum(value > 0) > 10
    assert jnp.all(jnp.isfinite(value))
    assert jnp.all(jnp.where(value > 0, 0.0, first) == 0)
    np.testing.assert_allclose(first, difference, rtol=0, atol=1e-4 * scale)
    forward, reverse = jnp.sum(directions[1] * first), jnp.sum(pulled * directions[0])
    np.testing.assert_allclose(forward, reverse, rtol=1e-7)
    # ∂p/∂g is the inverse influence on the cells in contact: symmetric, and softening.
    np.testing.assert_allclose(forward, jnp.sum(directions[0] * second), rtol=1e-7)
    assert jnp.sum(directions[0] * first) < 0


def test_flanks_differentiate_through_meshing_and_gap():
    """Lead, contact angle, load, addendum with a rounded edge: both modes, finite differences."""
    one = stage(
        roller_count=1,
        engaged_threads=1.0,
        geometry=thread(5e-3, roller_addendum=0.12e-3),
        friction=None,
    )

    def values(changes):
        moved = one
        for name, change in zip(
            ("lead", "contact_angle", "roller_addendum"), changes, strict=False
        ):
            value = prsm.get_parameter(prsm.Mechanism((one,)), name)
            moved = eqx.tree_at(lambda s, n=name: getattr(s.thread, n), moved, value * (1 + change))
        found = flank_contact(
            moved,
            "screw",
            100.0 * (1 + changes[3]),
            (32, 32),
            edge_radius=0.3e-3,
            tolerance=1e-12,
        )
        # In units of order one.
        return jnp.stack([1e-9 * found.surface.max_pressure, 1e6 * found.surface.approach])

    none, step = jnp.zeros(4), 1e-4
    direction = jnp.asarray([0.3, -0.2, 0.1, 0.5])

    @jax.jit
    def everything(changes):
        value, slope = jax.linearize(values, changes)
        pull = jax.linear_transpose(slope, changes)
        return value, slope(direction), jax.vmap(pull)(jnp.eye(2))[0]

    value, forward, reverse = everything(none)
    ends = [everything(sign * step * direction)[0] for sign in (1, -1)]
    difference = (ends[0] - ends[1]) / (2 * step)
    np.testing.assert_allclose(reverse @ direction, forward, rtol=1e-7)
    # The grid's directions are held in derivatives: turning it moves the cells' errors only.
    np.testing.assert_allclose(forward / value, difference / value, rtol=0, atol=5e-4)
    # A longer flank lowers pressure and approach.
    assert np.all(reverse[:, 2] < 0)
    # The other way round: the same contact, its derivative by the load mirrored.
    load = jnp.asarray([0.0, 0.0, 0.0, 1.0])
    pulled, _, mirrored = everything(-2.0 * load)
    np.testing.assert_array_equal(pulled, value)
    np.testing.assert_array_equal(mirrored, np.asarray(reverse) * [1, 1, 1, -1])
    # Without a load nothing depends on anything, but where the cells lie.
    unloaded, ahead, back = everything(-1.0 * load)
    for numbers in (unloaded, ahead, back):
        np.testing.assert_allclose(numbers, 0.0, atol=1e-6)


def test_reverse_derivative_of_the_load_itself():
    """Of a sum of all pressures nothing but rounding is left to be solved for; it was NaN."""
    one = stage(geometry=thread(roller_profile_radius=5.7e-3))

    @jax.jit
    def slope(load):
        surface = flank_contact(one, "nut", load, (8, 8)).surface
        return surface.load

    value, pulled = jax.value_and_grad(slope)(array(17e3))
    # Proportional to the axial load.
    assert float(pulled) == pytest.approx(float(value) / 17e3, rel=1e-12)
