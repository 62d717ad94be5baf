"""Functions of a mechanism in place of names of quantities, and definitions that are run again."""

import copy
import gc
import pickle
import subprocess
import sys
import weakref
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax
from prsm_jax.quantities import _catalogue, catalogue, find_quantity, quantity_name

_MECHANISM = prsm_jax.load("wu2022")
_LEAD, _ANGLE = 10e-3, np.pi / 4


@pytest.fixture(autouse=True)
def forgotten(monkeypatch):
    """Names and programs of these tests stay here; other tests keep their programs."""
    monkeypatch.setattr(_catalogue, "_FUNCTIONS", {})
    monkeypatch.setattr(_catalogue, "_CATALOGUE", dict(_catalogue._CATALOGUE))
    times = []
    monkeypatch.setattr(_catalogue.jax, "clear_caches", lambda: times.append(1))
    return times


def steepness(mechanism):
    """Square of the lead times the angle."""
    thread = mechanism.stages[0].thread
    return thread.lead**2 * thread.contact_angle


def test_a_function_is_computed_under_its_name():
    values = prsm_jax.compute(_MECHANISM, ["nut_radius", steepness])
    assert list(values) == ["nut_radius", "steepness"]
    assert float(values["steepness"]) == pytest.approx(_LEAD**2 * _ANGLE, rel=1e-15)
    entry = find_quantity("steepness")
    assert (entry.unit, entry.description) == ("1", "Square of the lead times the angle.")
    assert "steepness" not in [one.name for one in catalogue()]
    assert prsm_jax.compute(_MECHANISM, ["steepness"]).keys() == {"steepness"}


def test_a_function_sees_the_operating_point_that_is_given():
    def power(mechanism):
        return mechanism.operating_point.speed * mechanism.operating_point.load

    (value,) = prsm_jax.compute(_MECHANISM, [power], speed=3.0, load=500.0).values()
    assert float(value) == 1500.0
    (value,) = prsm_jax.compute(_MECHANISM, [power]).values()
    assert float(value) == pytest.approx(100.0 * 7000.0)


def test_derivatives_of_a_function_are_those_of_its_formula():
    table = prsm_jax.sensitivity(_MECHANISM, [steepness], ["lead", "contact_angle"], kinks=False)
    assert table.quantities == ("steepness",)
    expected = [[2 * _LEAD * _ANGLE, _LEAD**2]]
    np.testing.assert_allclose(table.gradient, expected, rtol=1e-14)


def test_a_sweep_with_gradients_of_a_function():
    leads = [1e-3, 2e-3, 4e-3]
    data = prsm_jax.sweep(
        _MECHANISM, {"lead": leads}, [steepness], gradients=["lead"], findings=False
    )
    np.testing.assert_allclose(data["steepness"], np.square(leads) * _ANGLE, rtol=1e-14)
    np.testing.assert_allclose(data["steepness_by_lead"], 2 * np.array(leads) * _ANGLE, rtol=1e-14)


def test_a_store_does_not_know_a_function(tmp_path):
    with pytest.raises(
        ValueError, match=r"the function steepness, .* decorator prsm_jax\.quantity"
    ):
        prsm_jax.sweep(_MECHANISM, {"lead": [1e-3]}, [steepness], store=tmp_path / "a.zarr")
    assert not list(tmp_path.iterdir())


def test_functions_as_objective_and_as_constraint():
    """The least (L − 7 mm)² with λ L ≥ 8 mm rad in the bounds lies on the limit."""

    def distance(mechanism):
        return (1e3 * mechanism.stages[0].thread.lead - 7) ** 2

    def product(mechanism):
        thread = mechanism.stages[0].thread
        return 1e3 * thread.lead * thread.contact_angle

    best = prsm_jax.optimise(
        _MECHANISM,
        {"lead": (5e-3, 20e-3)},
        minimise=distance,
        constraints={product: (8.0, None)},
        respect_findings=False,
        starts=1,
    )
    lead = float(best.mechanism.stages[0].thread.lead)
    assert lead == pytest.approx(8e-3 / _ANGLE, rel=1e-6)
    assert best.converged
    assert [one.quantity for one in best.problem.objectives] == ["distance"]
    assert "distance" in str(best)


def test_functions_without_names_of_their_own_are_numbered():
    def made(power):
        def inner(mechanism):
            return mechanism.stages[0].thread.lead ** power

        return inner

    first, second = made(1), made(2)
    values = prsm_jax.compute(_MECHANISM, [first, second, lambda m: m.stages[0].thread.starts])
    assert list(values) == ["inner", "inner_2", "function"]
    found = [float(value) for value in values.values()]
    assert found == pytest.approx([_LEAD, _LEAD**2, 5.0], rel=1e-15)
    # Only those of one call are numbered, and the same function is one quantity.
    assert [str(quantity_name(one)) for one in (first, second, made(3))] == ["inner"] * 3
    assert list(prsm_jax.compute(_MECHANISM, [first, first])) == ["inner"]
    third = prsm_jax.compute(_MECHANISM, [made(3), "nut_radius", second, lambda m: 1.0])
    assert list(third) == ["inner", "nut_radius", "inner_2", "function"]
    assert float(third["inner"]) == pytest.approx(_LEAD**3, rel=1e-15)
    assert all(type(name) is str for name in third)


def _objective(factor: float):
    """A function that is defined anew in every call, as in a notebook or in a class."""

    def cost(mechanism):
        return factor * mechanism.stages[0].thread.lead

    return cost


def test_a_closure_has_its_name_in_every_call():
    """And its own number: not that of a program of the closure before."""
    found = [
        float(prsm_jax.compute(_MECHANISM, [_objective(factor)])["cost"])
        for factor in (2.0, 3.0, 3.0)
    ]
    assert found == pytest.approx([2 * _LEAD, 3 * _LEAD, 3 * _LEAD], rel=1e-15)
    for factor in (2.0, 3.0):
        values, code = prsm_jax.quantities.compute_coded(_MECHANISM, [_objective(factor)])
        assert float(values["cost"]) == pytest.approx(factor * _LEAD, rel=1e-15)
        assert int(code) == 0


def test_closures_of_one_name_in_other_verbs():
    for factor in (2.0, 3.0):
        cost = _objective(factor)
        table = prsm_jax.sensitivity(_MECHANISM, [cost], ["lead"], kinks=False, second=True)
        assert table.quantities == ("cost",)
        np.testing.assert_allclose(table.gradient, [[factor]], rtol=1e-14)
        data = prsm_jax.sweep(_MECHANISM, {"lead": [1e-3, 2e-3]}, [cost], findings=False)
        np.testing.assert_allclose(data["cost"], [factor * 1e-3, factor * 2e-3], rtol=1e-14)


def test_closures_of_one_name_as_objectives():
    """The least (L − c)² is at the lead c."""

    def distance_to(centre):
        def distance(mechanism):
            return (1e3 * (mechanism.stages[0].thread.lead - centre)) ** 2

        return distance

    for centre in (8e-3, 11e-3):
        best = prsm_jax.optimise(
            _MECHANISM,
            {"lead": (5e-3, 20e-3)},
            minimise=distance_to(centre),
            respect_findings=False,
            constraints={},
            starts=1,
        )
        assert float(best.mechanism.stages[0].thread.lead) == pytest.approx(centre, rel=1e-5)
        assert [one.quantity for one in best.problem.objectives] == ["distance"]


def test_closures_of_one_name_in_one_problem_are_numbered():
    from prsm_jax.optimisation._problem import problem_of

    first, second = _objective(1.0), _objective(2.0)
    bounds = {"lead": (5e-3, 20e-3)}
    problem = problem_of(_MECHANISM, None, bounds, None, first, {second: (0.0, 1.0)})
    assert [one.quantity for one in problem.objectives] == ["cost"]
    assert [one.quantity for one in problem.constraints] == ["cost_2"]
    again = copy.deepcopy(problem), pickle.loads(pickle.dumps(problem))
    assert all(one.constraints[0].quantity == "cost_2" for one in again)


def test_closures_of_one_name_with_tolerances():
    zones = [prsm_jax.mechanism.Tolerance("lead", -1e-5, 1e-5)]
    for factor in (2.0, 3.0):
        found = prsm_jax.tolerance(
            _MECHANISM,
            [_objective(factor)],
            method="first_order",
            tolerances=zones,
        )
        assert found.quantities == ("cost",)
        (method,) = found.methods.values()
        assert float(method.estimates["cost"].mean) == pytest.approx(factor * _LEAD, rel=1e-12)


def test_a_closure_is_not_kept():
    cost = _objective(5.0)
    assert float(prsm_jax.compute(_MECHANISM, [cost])["cost"]) == pytest.approx(5 * _LEAD)
    alive = weakref.ref(cost)
    del cost
    gc.collect()
    assert alive() is None
    # Its unit and description are known, for results that were computed before.
    assert find_quantity("cost").unit == "1"
    with pytest.raises(prsm_jax.UnknownNameError, match="the function cost does not exist any"):
        prsm_jax.compute(_MECHANISM, ["cost"])


def test_functions_of_a_generator_exist_until_they_are_computed():
    found = prsm_jax.compute(_MECHANISM, (_objective(factor) for factor in (2.0, 3.0)))
    assert list(found) == ["cost", "cost_2"]
    assert [float(one) for one in found.values()] == pytest.approx([2 * _LEAD, 3 * _LEAD])


def test_a_closure_over_a_traced_number():
    def value(factor):
        return prsm_jax.compute(_MECHANISM, [_objective(factor)])["cost"]

    factors = jnp.asarray([2.0, 3.0])
    with jax.checking_leaks():
        np.testing.assert_allclose(jax.vmap(value)(factors), factors * _LEAD, rtol=1e-15)
        assert float(jax.grad(value)(2.0)) == pytest.approx(_LEAD, rel=1e-15)
        assert float(jax.jit(value)(2.0)) == pytest.approx(2 * _LEAD, rel=1e-15)


class _Priced:
    def __init__(self, price):
        self.price = price

    def cost(self, mechanism):
        return self.price * mechanism.stages[0].thread.lead


def test_a_method_is_one_quantity_however_often_it_is_read():
    one, other = _Priced(2.0), _Priced(3.0)
    found = prsm_jax.compute(_MECHANISM, [one.cost, one.cost, other.cost])
    assert list(found) == ["cost", "cost_2"]
    assert [float(value) for value in found.values()] == pytest.approx([2 * _LEAD, 3 * _LEAD])


def test_a_text_in_place_of_a_list():
    for verb in (prsm_jax.compute, prsm_jax.sensitivity, prsm_jax.quantities.compute_coded):
        expected = r"^quantities is the text 'efficiency'; give a list of names$"
        with pytest.raises(ValueError, match=expected):
            verb(_MECHANISM, "efficiency")


_CELL = """
@quantity("of_a_cell", "x", "m", "a lead")
def of_a_cell(analysis):
    return {} * analysis.mechanism.stages[0].thread.lead
"""


def test_a_definition_that_is_run_again_replaces_the_first(forgotten):
    scope: dict[str, Any] = {"__name__": "cell"}
    exec("def again(m): return m.stages[0].thread.lead", scope)
    assert float(prsm_jax.compute(_MECHANISM, [scope["again"]])["again"]) == _LEAD
    exec("def again(m): return 2 * m.stages[0].thread.lead", scope)
    assert float(prsm_jax.compute(_MECHANISM, [scope["again"]])["again"]) == 2 * _LEAD
    # Programs know a function itself.
    assert not forgotten
    scope["quantity"] = prsm_jax.quantity
    for number in (1, 3):
        exec(_CELL.format(number), scope)
        value = prsm_jax.compute(_MECHANISM, ["of_a_cell"])["of_a_cell"]
        assert float(value) == pytest.approx(number * _LEAD)
    # Programs that know the quantity by its name only must be compiled again.
    assert len(forgotten) == 1


def test_a_quantity_of_the_catalogue_may_be_given_as_its_function():
    entry = find_quantity("nut_radius")
    assert quantity_name(entry.function) == "nut_radius"
    assert list(prsm_jax.compute(_MECHANISM, [entry.function])) == ["nut_radius"]


def test_mistakes_are_named():
    def mass(mechanism):
        return mechanism.stages[0].thread.lead

    with pytest.raises(ValueError, match="the function mass has the name of a quantity"):
        prsm_jax.compute(_MECHANISM, [mass])

    def two(mechanism):
        return jnp.stack([mechanism.stages[0].thread.lead] * 2)

    with pytest.raises(ValueError, match=r"the function two returns an array of shape \(2,\)"):
        prsm_jax.compute(_MECHANISM, [two])


_RERUN = """
import numpy as np, prsm_jax as prsm
m = prsm.load("wu2022")
for factor in (1.0, 3.0):
    @prsm.quantity("scaled_lead", "x", "m", "a lead")
    def scaled_lead(analysis, factor=factor):
        return factor * analysis.mechanism.stages[0].thread.lead
    print(float(prsm.sensitivity(m, ["scaled_lead"], ["lead"], kinks=False).gradient[0, 0]))
    data = prsm.sweep(m, {"lead": [2e-3]}, ["scaled_lead"], gradients=["lead"], findings=False)
    print(float(data["scaled_lead"][0]), float(data["scaled_lead_by_lead"][0]))
"""


def test_sensitivities_and_sweeps_follow_a_cell_that_is_run_again():
    """In a process of its own, which forgets its programs."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", _RERUN], capture_output=True, text=True, check=True
    )
    found = [float(word) for word in done.stdout.split()]
    assert found == pytest.approx([1.0, 2e-3, 1.0, 3.0, 6e-3, 3.0], rel=1e-14)
