"""Points of a unit cube: balanced by definition, with the argument of either name for the seed."""

import numpy as np
import pytest
from scipy.stats import qmc

from prsm_jax.numerics import latin_hypercube, sobol_points


@pytest.fixture(params=["rng", "seed"])
def scipy_that_takes(request, monkeypatch):
    """SciPy 1.14 takes `seed` alone, later versions `rng`."""

    def only(sampler):
        def sample(dimensions, **given):
            if set(given) != {request.param}:
                raise TypeError(f"unexpected keyword argument {set(given)}")
            return sampler(dimensions, given[request.param])

        return sample

    class OldHypercube(qmc.LatinHypercube):
        def __init__(self, d, generator):
            super().__init__(d, seed=generator)  # pyright: ignore[reportCallIssue]

    class OldSobol(qmc.Sobol):
        def __init__(self, d, generator):
            super().__init__(d, seed=generator)  # pyright: ignore[reportCallIssue]

    monkeypatch.setattr(qmc, "LatinHypercube", only(OldHypercube))
    monkeypatch.setattr(qmc, "Sobol", only(OldSobol))


@pytest.mark.usefixtures("scipy_that_takes")
def test_a_latin_hypercube_has_one_point_in_each_part():
    points = latin_hypercube(3, 12, 5)
    assert points.shape == (12, 3)
    for column in points.T:
        assert sorted(np.floor(12 * column)) == list(range(12))
    assert np.array_equal(points, latin_hypercube(3, 12, 5))
    assert not np.array_equal(points, latin_hypercube(3, 12, 6))


@pytest.mark.usefixtures("scipy_that_takes")
def test_sobol_points_are_balanced():
    """2^m points of a (t, m, s) net have one point in each of 2^m parts of an axis."""
    points = sobol_points(2, 4, np.random.default_rng(3))
    assert points.shape == (16, 2)
    for column in points.T:
        assert sorted(np.floor(16 * column)) == list(range(16))
    assert np.array_equal(points, sobol_points(2, 4, np.random.default_rng(3)))
