"""The front of a real mechanism: its ends, its points, and that nothing on a grid is better."""

import numpy as np
import pytest
import scenes

from prsm_jax.findings import check
from prsm_jax.mechanism import Nut
from prsm_jax.optimisation import optimise, pareto
from prsm_jax.quantities import compute
from prsm_jax.sweeps import sweep

BOX = {"lead": (5e-3, 15e-3), "contact_angle": (0.5, 1.1), "roller_radius": (3e-3, 6e-3)}
LIMITS = {"max_pressure": (None, 1.6e9)}
GOALS = {"efficiency": "maximise", "nut_outer_diameter": "minimise"}


@pytest.fixture(scope="module")
def mechanism():
    return scenes.mechanism(scenes.stage(nut=Nut(mass=2.0, inertia=9e-4, wall_thickness=8e-3)))


@pytest.fixture(scope="module")
def front(mechanism):
    return pareto(mechanism, GOALS, BOX, LIMITS, points=15)


def test_every_point_is_what_it_says(mechanism, front):
    assert front.converged, str(front)
    assert len(front.points) >= 14
    assert max(one.kkt_residual for one in front.points) <= 1e-6
    for index in (0, 7, len(front.points) - 1):
        again = compute(front.design(index), [*GOALS, *LIMITS])
        for name, value in front.points[index].objectives.items():
            assert float(again[name]) == pytest.approx(value, rel=1e-12)
        # The tolerance of constraints, in units of the limit.
        assert float(again["max_pressure"]) <= 1.6e9 * (1 + 1e-6)
        assert [f.name for f in check(front.design(index)) if f.severity == "error"] == []


def test_the_ends_are_the_best_of_each_objective(mechanism, front):
    most = optimise(mechanism, BOX, maximise="efficiency", constraints=LIMITS)
    least = optimise(mechanism, BOX, minimise="nut_outer_diameter", constraints=LIMITS)
    # 1e-4 of the other objective counts, so an end is short of the best by about its square.
    assert front.points[0].objectives["efficiency"] == pytest.approx(
        most.optimum.objective, rel=1e-6
    )
    assert front.points[-1].objectives["nut_outer_diameter"] == pytest.approx(
        least.optimum.objective, rel=1e-6
    )


def test_no_design_on_a_grid_is_better(mechanism, front):
    axes = {name: np.linspace(*bounds, 20) for name, bounds in BOX.items()}
    grid = sweep(mechanism, axes, [*GOALS, *LIMITS], findings=True)
    fine = (grid.max_pressure <= 1.6e9) & ~grid.failed & (grid.error == 0)
    found = np.stack(
        [-grid.efficiency.values[fine.values], grid.nut_outer_diameter.values[fine.values]], 1
    )
    assert len(found) > 100
    own = front.values * [-1, 1]
    for point in own:
        # No grid point is better in both by more than the rounding of the search.
        assert not np.any(np.all(found < point - 1e-6 * np.abs(point), axis=1))
