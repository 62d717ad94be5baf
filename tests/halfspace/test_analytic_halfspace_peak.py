"""The largest pressure between the cells of a grid, for pressures that are known between them."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from prsm_jax.halfspace import grid_over, solve_contact
from prsm_jax.halfspace._peak import peak_pressure

_peak = jax.jit(peak_pressure)


def _hertzian(place, bends=(0.02, 0.03), twist=0.01, cells=(9, 7), top=3e9):
    """p² = p₀² (1 − a x² − b y² − c x y) about a place that is counted in cells."""
    x, y = np.meshgrid(*(np.arange(n) for n in cells), indexing="ij")
    x, y = x - place[0], y - place[1]
    square = 1 - bends[0] * x**2 - bends[1] * y**2 - twist * x * y
    return jnp.asarray(top * np.sqrt(np.maximum(square, 0.0)))


@pytest.mark.parametrize(
    "place", [(4.0, 3.0), (4.3, 2.6), (1.2, 3.4), (0.7, 1.3), (6.8, 4.9), (7.4, 5.4), (4.4, 0.6)]
)
def test_vertex_of_a_hertz_pressure_wherever_it_falls(place):
    """Exact, in the second cell from an edge of the grid as well."""
    pressure = _hertzian(place)
    assert float(_peak(pressure)) == pytest.approx(3e9, rel=1e-13)
    assert float(jnp.max(pressure)) <= 3e9


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sense", [1, -1])
def test_an_edge_has_its_own_value(axis, sense):
    """Pressures that grow towards the rim of the grid have no vertex on it."""
    ramp = np.linspace(1.0, 2.0, 6)[::sense]
    pressure = np.sqrt(np.repeat(ramp[:, None], 5, axis=1))
    assert float(_peak(jnp.asarray(pressure if axis == 0 else pressure.T))) == pytest.approx(
        np.sqrt(2.0), rel=1e-15
    )


def test_a_vertex_more_than_a_cell_away_does_not_count():
    """A single cell that bears, and no load at all."""
    alone = np.zeros((5, 5))
    alone[2, 2] = 7.0
    assert float(_peak(jnp.asarray(alone))) == pytest.approx(7.0, rel=1e-15)
    assert float(_peak(jnp.zeros((5, 5)))) == 0.0
    # Nearly straight along x: the paraboloid's vertex lies far outside of the contact.
    x, y = np.meshgrid(np.arange(7.0), np.arange(7.0) - 3, indexing="ij")
    slope = 1 + 0.1 * x - 1e-3 * x**2 - 0.02 * y**2
    slope[5:] = 0.0
    found = float(_peak(jnp.asarray(np.sqrt(slope))))
    assert found == pytest.approx(np.sqrt(slope.max()), rel=0.05)


def test_no_vertex_beyond_a_sharp_edge():
    """A roller with square ends: pressure rises to the last cell, and is a step there."""
    grid = grid_over((32, 32), jnp.asarray(1e-3), jnp.asarray(3e-4))
    x, y = grid.points
    material = jnp.abs(x) < 6e-4
    found = solve_contact(
        grid, y**2 / 2 / 5e-3, jnp.asarray(1.15e11), load=jnp.asarray(200.0), material=material
    )
    assert int(found.code) == 0
    largest = float(jnp.max(found.pressure))
    # It is at an end, and higher than in the middle.
    assert largest > 1.1 * float(jnp.max(found.pressure[15:17]))
    assert float(found.max_pressure) == pytest.approx(largest, rel=1e-14)
