"""Optimisation of real mechanisms, against brute force."""

import equinox as eqx
import jax
import numpy as np
import pytest
import scenes

from prsm_jax.mechanism import DesignProblem, Nut, Objective, Variable, set_parameters
from prsm_jax.optimisation import optimise
from prsm_jax.optimisation.search import Evaluator, _evaluator
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


def test_the_optimum_is_evaluated_by_the_programs_of_the_search():
    """Also where the search has made a number of its own of one that followed from others."""
    mechanism = scenes.mechanism()
    bounds = {"roller_radius": (3e-3, 6e-3), "roller_profile_radius": (4e-3, 12e-3)}
    problem = DesignProblem(
        tuple(Variable(name, *ends) for name, ends in bounds.items()),
        (Objective("max_pressure", "minimise"),),
    )
    first = Evaluator(mechanism, problem, None, None)
    changed = set_parameters(mechanism, {"roller_radius": 5e-3, "roller_profile_radius": 8e-3})
    second = Evaluator(changed, problem, None, None)
    assert jax.tree.structure(changed) != jax.tree.structure(mechanism)
    assert _described(first.program_inputs) == _described(second.program_inputs)
    position = np.array([0.3, 0.6])
    np.testing.assert_array_equal(first.point(position).values, second.point(position).values)


def test_a_long_search_goes_on_without_derivatives(monkeypatch):
    """The second program gives the values and derivatives of the first, and is compiled beside."""
    monkeypatch.setattr(_evaluator, "_WITH_DERIVATIVES", 4)
    asked, prepared = [], []
    bind = _evaluator.bind_program

    def recorded(function, *given):
        program, name = bind(function, *given), function.__name__.removeprefix("compiled_")

        def run(position):
            asked.append(name)
            return program(position)

        return run

    def prepare(function, *_):
        prepared.append((function, len(asked)))
        return lambda: None

    programs = [_evaluator.compiled_derivatives, _evaluator.compiled_values]
    monkeypatch.setattr(_evaluator, "bind_program", recorded)
    monkeypatch.setattr(_evaluator, "prepare_program", prepare)
    problem = DesignProblem((Variable("lead", 5e-3, 15e-3),), (Objective("max_pressure"),))
    search = Evaluator(scenes.frictionless(), problem, None, None, margins=False)
    positions = np.linspace(0.1, 0.9, 6)[:, None]
    values = [search.point(one).values for one in positions]
    assert asked == 4 * ["derivatives"] + 2 * ["values"]
    # The search needs the first one from the beginning, the other one perhaps.
    assert prepared == [(programs[0], 0), (programs[1], 2)]
    assert (search.evaluations, search.derivative_evaluations) == (6, 0)
    slope = search.jacobian(positions[5])
    assert asked[6:] == ["derivatives"]
    again = Evaluator(scenes.frictionless(), problem, None, None, margins=False)
    for position, value in zip(positions, values, strict=True):
        # Another program adds in another order.
        np.testing.assert_allclose(again.point(position).values, value, rtol=1e-14)
        found = again.jacobian(position)
    np.testing.assert_allclose(found, slope, rtol=1e-12)
    # Derivatives come with the first four.
    assert asked[7:] == 4 * ["derivatives"] + 2 * ["values", "derivatives"]
    assert (again.evaluations, again.derivative_evaluations) == (6, 6)


def _described(inputs):
    """What a compiled program depends on."""
    leaves, structure = jax.tree.flatten(inputs)
    return structure, [jax.typeof(leaf) if eqx.is_array(leaf) else leaf for leaf in leaves]
