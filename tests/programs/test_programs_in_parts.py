"""Calculations that a process that runs one verb compiles as two programs beside each other."""

import dataclasses
import threading

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from alike import same_but_for_rounding
from scenes import example

import prsm_jax as prsm
from prsm_jax.mechanism import (
    Constraint,
    DesignProblem,
    Objective,
    OperatingCase,
    Variable,
    set_parameters,
)
from prsm_jax.optimisation.search import Evaluator
from prsm_jax.optimisation.search._parts import parts_of
from prsm_jax.programs import (
    _stored,
    one_program_where_possible,
    prepare_program,
    stored_facts,
)
from prsm_jax.quantities import by_friction
from prsm_jax.sensitivities import _sensitivity


def test_a_long_list_of_quantities_is_two_programs(one_verb, usual, traced_again):
    """The table is that of one program: also a quantity of many components, and a failed one."""
    mechanism = example("wu2022")
    names = ["efficiency", "natural_frequencies", "max_pressure", "drive_torque", "mass"]

    def run():
        return prsm.sensitivity(mechanism, names, ["lead", "contact_angle"])

    expected, first = usual(run), run()
    assert len(list(one_verb.iterdir())) == 2
    traced_again()
    for table in (first, run()):
        assert table.quantities == expected.quantities
        assert table.quantity_units == expected.quantity_units
        assert table.to_dict().keys() == expected.to_dict().keys()
        same_but_for_rounding(table, expected)
    assert bool(expected.valid)
    broken = set_parameters(mechanism, {"contact_angle": float("nan")}, checked=False)
    table = prsm.sensitivity(broken, names, ["lead", "contact_angle"])
    assert not bool(table.valid)
    # All parts have to be usable, not only one.
    parts = [
        {key: np.ones(1) for key in ("values", "gradient", "elasticity", "elasticity_defined")}
        | {"by_name": {name: np.ones(())}, "valid": np.asarray(valid)}
        for name, valid in (("mass", True), ("efficiency", False))
    ]
    assert not bool(_sensitivity._joined(("mass", "efficiency"), parts)["valid"])


_VARIABLES = (Variable("lead", 6e-3, 14e-3), Variable("contact_angle", 0.6, 0.9))
#: Those with friction and the others in turn; one has several components.
_QUANTITIES = ("drive_torque", "natural_frequencies", "efficiency", "max_pressure", "loss_power")


def _problem(quantities=_QUANTITIES, **others):
    limits = tuple(Constraint(name, 0.0) for name in quantities[:-1])
    return DesignProblem(_VARIABLES, (Objective(quantities[-1], "minimise"),), limits, **others)


@pytest.mark.parametrize("points", [(), (OperatingCase(100.0, 5e3), OperatingCase(50.0, 9e3))])
def test_a_search_with_friction_and_without_is_two_programs(one_verb, usual, points):
    """Values, derivatives and the names of the rows are those of one program."""
    mechanism, problem = example("wu2022"), _problem(operating_points=points)
    position = np.array([0.3, 0.6])

    def made():
        search = Evaluator(mechanism, problem, None, None)
        return search, search.point(position).values, search.jacobian(position)

    expected, values, slopes = usual(made)
    found, same_values, same_slopes = made()
    assert len(parts_of(found.program_inputs)) == 2
    assert found.rows.names == expected.rows.names
    assert found.point(position).good
    assert len(values) == len(same_values) == len(found.rows.weights)
    # Compiled differently: another order of additions.
    np.testing.assert_allclose(same_values, values, rtol=1e-9)
    largest = np.max(np.abs(slopes), axis=1, keepdims=True)
    assert np.all(np.abs(same_slopes - slopes) <= 1e-9 * largest)
    # The programs, and shapes and names of margins.
    assert len(list(one_verb.iterdir())) == 3


@pytest.mark.parametrize("usable", [(True, True), (True, False), (False, True)])
def test_both_parts_of_a_search_have_to_be_usable(one_verb, usable):
    problem = _problem(("mass", "efficiency"))
    search = Evaluator(example("wu2022"), problem, None, None, margins=False)
    # The mass is in the first part.
    search._derivatives = [
        lambda _, one=one, number=number: (
            (jnp.full(1, number), jnp.asarray(one)),
            jnp.full((1, 2), -number),
        )
        for number, one in zip((2.0, 3.0), usable, strict=True)
    ]
    point = search.point(np.array([0.3, 0.6]))
    assert point.good == all(usable)
    # The objective is named first.
    np.testing.assert_array_equal(point.values, [3.0, 2.0])
    np.testing.assert_array_equal(point.slopes, [[-3.0, -3.0], [-2.0, -2.0]])


@pytest.mark.parametrize("quantities", [("drive_torque", "efficiency"), ("mass", "max_pressure")])
def test_a_search_for_one_kind_of_quantities_is_one_program(one_verb, quantities):
    search = Evaluator(example("wu2022"), _problem(quantities), None, None)
    assert parts_of(search.program_inputs) == (search.program_inputs,)


def test_quantities_with_friction_are_those_that_assume_a_law_of_it():
    friction, rest = by_friction(("mass", "efficiency"))
    assert (friction, rest) == (("efficiency",), ("mass",))
    friction, rest = by_friction(_QUANTITIES)
    assert friction == ("drive_torque", "efficiency", "loss_power")
    assert rest == ("natural_frequencies", "max_pressure")
    with pytest.raises(prsm.UnknownNameError, match="efficency"):
        by_friction(["efficency"])


def test_missing_data_are_named_by_their_quantity(one_verb):
    """Also where the quantity belongs to the second program."""
    problem = _problem(("mass", "efficiency"))
    mechanism = dataclasses.replace(example("wu2022"), operating_point=None)
    with pytest.raises(prsm.MissingDataError, match="quantity 'efficiency'"):
        Evaluator(mechanism, problem, None, None)


def _root(number):
    return jnp.sqrt(number)


@pytest.fixture
def waiting(monkeypatch):
    """A function with a stored program, an event that its compiler waits for, and waits in vain."""
    module = _root.__module__.partition(".")[0]
    monkeypatch.setattr(_stored, "_KNOWN", {*_stored._KNOWN, module})
    goes_on, in_vain = threading.Event(), []
    compiled = jax.stages.Lowered.compile

    def patient(lowered, *args, **kwargs):
        if not goes_on.wait(10):
            in_vain.append(lowered)
        return compiled(lowered, *args, **kwargs)

    monkeypatch.setattr(jax.stages.Lowered, "compile", patient)
    yield one_program_where_possible(_root), goes_on, in_vain
    goes_on.set()


def test_one_can_wait_until_a_program_has_been_traced(one_verb, usual, waiting):
    """While it is being compiled, the next trace delays no other."""
    function, goes_on, in_vain = waiting
    number = jnp.asarray(2.0)
    traced = prepare_program(function, number)
    traced()
    assert not in_vain
    goes_on.set()
    assert function(number) == pytest.approx(2**0.5)
    # Nothing to wait for: the program is in use, or the process runs longer.
    assert prepare_program(function, number)() is None
    assert usual(lambda: prepare_program(function, number)()) is None


def test_facts_wait_only_where_they_have_to_be_traced(one_verb):
    order = []

    def facts(number):
        order.append("traced")
        return (3,)

    def found():
        return stored_facts("test", facts, jnp.zeros(()), after=lambda: order.append("waited"))

    assert found() == (3,)
    assert order == ["waited", "traced"]
    assert found() == (3,)
    assert order == ["waited", "traced"]
