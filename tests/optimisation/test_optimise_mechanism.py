"""Optimisation of a real mechanism, against brute force; `tests/cli` has that of an example."""

import numpy as np
import pytest
import scenes

from prsm_jax.mechanism import Nut
from prsm_jax.optimisation import optimise
from prsm_jax.quantities import compute
from prsm_jax.sweeps import sweep


def test_nothing_on_a_grid_is_better():
    mechanism = scenes.mechanism(scenes.stage(nut=Nut(mass=2.0, inertia=9e-4, wall_thickness=8e-3)))
    box = {"lead": (5e-3, 15e-3), "contact_angle": (0.5, 1.1), "roller_radius": (3e-3, 6e-3)}
    limits = {"max_pressure": (None, 1.6e9), "nut_outer_diameter": (None, 60e-3)}
    best = optimise(mechanism, box, maximise="efficiency", constraints=limits, starts=2, seed=3)
    assert best.converged, str(best)
    assert best.kkt_residual < 1e-6
    # Pressure asks for a large roller, the housing for a small one.
    assert any(report.active for report in best.constraints), str(best)

    # The optimised mechanism, analysed afresh, gives what the report says.
    again = compute(best.mechanism, ["efficiency", *limits])
    assert float(again["efficiency"]) == pytest.approx(best.optimum.objective, rel=1e-12)
    for report in best.constraints:
        assert float(again[report.name]) == pytest.approx(report.value, rel=1e-12)

    axes = {name: np.linspace(*bounds, 24) for name, bounds in box.items()}
    grid = sweep(mechanism, axes, ["efficiency", *limits])
    feasible = (grid.max_pressure <= 1.6e9) & (grid.nut_outer_diameter <= 60e-3)
    found = grid.efficiency.where(feasible & ~grid.failed)
    assert feasible.sum() > 100
    assert float(found.max()) <= best.optimum.objective + 1e-12
    # One step of the grid changes the efficiency by about this much: the optimum is no mirage.
    spacing = float(abs(grid.efficiency.diff("lead")).max())
    assert best.optimum.objective <= float(found.max()) + 3 * spacing
