"""Tilts in space: against rigid bodies whose threads, teeth and pins are springs one by one."""

import numpy as np
import pytest
from spatial_scenes import THREADS, frequencies_of, modes_of, network_of, system_of
from tilt_assembly import of_coordinates, rigid_bodies, tilting_stage


def tilted(stage, threads=THREADS, **options):
    return system_of(stage, threads, tilt=True, **options)


@pytest.mark.parametrize("count", [3, 8])
@pytest.mark.parametrize("standstill", [False, True])
def test_matrices_are_those_of_rigid_bodies(count, standstill):
    stage = tilting_stage(count)
    network = network_of(tilted(stage, standstill=standstill))
    bodies = rigid_bodies(stage, standstill)
    change = of_coordinates(bodies, stage, network.coordinates)
    stiffness, masses = bodies.matrices()
    expected = change.T @ stiffness @ change
    found = np.asarray(network.stiffness_matrix())
    # Sums of some hundreds of doubles; the contact comes from a root found to about 1e-15.
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max(), rtol=0)
    inertias = change.T @ (masses[:, None] * change)
    np.testing.assert_allclose(np.diag(np.asarray(network.mass)), inertias, rtol=1e-13, atol=1e-16)


@pytest.mark.parametrize("count", [3, 5, 8])
def test_modes_by_symmetry_are_those_of_all_coordinates(count):
    system = tilted(tilting_stage(count))
    network = network_of(system)
    expected = frequencies_of(network.stiffness, network.rows, network.mass)
    modes = modes_of(system)
    assert len(expected) == 6 * count + 2 * 6 + 2 * 3
    np.testing.assert_allclose(modes.frequencies, expected, rtol=1e-12)
