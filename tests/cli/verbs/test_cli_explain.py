"""`prsm explain`: which parts a file carries, in the JSON and in the tables."""

import equinox as eqx
import jax
import jax.numpy as jnp
import pytest
from scenes import example

import prsm_jax as prsm
from benchmarks.load.counted import counted
from prsm_jax.explanation import Account, Cost, Explanation, Part, Program, places


def _efficiency(one):
    return prsm.steady_state(one).efficiency


@pytest.fixture(scope="module")
def found():
    return prsm.explain(example("li2021_two_stage"), programs=["steady_state"])


def test_the_json_has_what_python_has(prsm_json, found):
    told = prsm_json("explain", "li2021_two_stage", "--programs", "steady_state")
    assert told.pop("valid", True)
    assert told == found.to_dict()
    parts = {part["name"]: part for part in told["parts"]}
    spline = parts["stage.2.friction.spline"]
    assert spline["present"]
    assert (spline["kind"], spline["law"]) == ("table", "coulomb")
    assert spline["laws"] == ["coulomb", "regularised_coulomb", "stribeck", "viscous"]
    cost = spline["costs"]["steady_state"]
    (whole,) = [p["equations"] for p in told["programs"]]
    assert cost["equations"] == whole - cost["equations_without"] > 0
    assert (cost["flops"], cost["run_s"], cost["needed"]) == (None, None, None)
    spin = parts["stage.1.friction.spin"]
    assert not spin["present"]
    assert spin["costs"] == {}
    assert spin["write"] == "[stage.friction.spin] (coefficient)"
    assert spin["reason"] == "not given; write [stage.friction.spin] (coefficient)"
    assert parts["operating_point"]["costs"]["steady_state"]["needed"].startswith("no speed: ")


def test_what_it_says_to_write_makes_the_part(tmp_path):
    """The keys that it names are those that a file needs."""
    lacking = {p.name: p for p in places(example("li2021_two_stage"))}
    assert lacking["stage.1.friction.drag"].write == "[stage.friction.drag] (torque)"
    text = prsm.file.example_text("li2021_two_stage")
    head, last = text.rsplit("[stage.friction.spline]", 1)
    more = prsm.loads(f"{head}[stage.friction.drag]\ntorque = 1\n[stage.friction.spline]{last}")
    assert {p.name: p.present for p in places(more)}["stage.2.friction.drag"]


def test_the_table_has_the_same_numbers(prsm, found):
    status, out, _ = prsm("explain", "li2021_two_stage", "--programs", "steady_state")
    assert status == 0
    rows = {line.split()[0]: line.split() for line in out.splitlines() if line.strip()}
    assert int(rows["steady_state"][1]) == found.programs[0].account.equations
    for part in found.carried:
        if part.place.kind == "number":
            assert part.name not in rows
            continue
        cost = part.costs["steady_state"]
        expected = "needed" if cost.needed else str(cost.equations)
        assert expected in rows[part.name], part.name
    left = out.partition("Parts left out")[2]
    assert "[stage.friction.spin]" in left
    # Both stages lack it, so it stands there once.
    assert left.count("[stage.friction.spin]") == 1


def test_an_unknown_program_is_refused(prsm):
    status, out, err = prsm("explain", "wu2022", "--programs", "steady")
    assert (status, out) == (2, "")
    assert err.startswith("prsm: unknown program 'steady'; did you mean steady_state")


def test_equations_are_those_that_the_numbers_need():
    """Of one number by a count of another program; ranges that are checked for a code are none."""
    from importlib import import_module

    account = import_module("prsm_jax.explanation._account")
    one = example("li2021_two_stage")
    few, read = account.traced(_efficiency, one)
    every = counted(eqx.filter_jit(prsm.steady_state), one).equations
    assert 0 < few.equations < every
    assert ("stages", 0, "thread", "lead") in read
    assert ("stages", 0, "nut", "mass") not in read
    jaxpr = jax.make_jaxpr(jax.jit(lambda x: jax.lax.map(lambda y: y * y + 1.0, x)))(jnp.ones(3))
    # A call, a loop, and a product and a sum in it.
    assert account.equation_count(jaxpr.jaxpr) == 4


def test_a_compiled_program_is_measured():
    from importlib import import_module

    account = import_module("prsm_jax.explanation._account")

    def analysis(one):
        numbers = jnp.full((30, 40), one.stages[0].thread.lead)
        return numbers @ numbers.T

    found = account.compiled(analysis, example("wu2022"), 7)
    assert found.equations == 7
    assert found.flops == pytest.approx(2 * 30 * 40 * 30, rel=0.1)
    assert found.bytes >= 8 * 30 * 30
    assert found.memory_bytes >= 8 * 30 * 30
    assert found.compile_s > 0
    assert found.run_s > 0


def test_every_measure_stands_in_its_column():
    """Differences of accounts that are known, in the JSON and in the table."""
    (place,) = [p for p in places(example("wu2022")) if p.name == "stage.1.gear"]
    whole = Account(100, 50.0, 400.0, 64, 2.0, 1e-3)
    absent = Account(90, 45.0, 300.0, 60, 1.5, 0.75e-3)
    part = Part(place, {"modes": Cost(whole, absent)})
    one = Explanation("title", (Program("modes", whole),), (part,))
    cost = one.to_dict()["parts"][0]["costs"]["modes"]
    found = [cost[m] for m in ("equations", "flops", "bytes", "memory_bytes", "compile_s", "run_s")]
    assert found == [10, 5.0, 100.0, 4, 0.5, 0.25e-3]
    assert cost["bytes_without"] == 300.0
    programs, carried, _ = one.tables()
    assert programs.columns[1:] == (
        "equations", "flops", "bytes", "memory [B]", "compiling [s]", "run [s]",
    )  # fmt: skip
    assert programs.rows[0][1:] == (100, 50.0, 400.0, 64, 2.0, 1e-3)
    assert carried.rows[0][1:-1] == tuple(found)
