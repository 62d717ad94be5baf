"""Growth with size: what is fitted and counted, and that what should be linear is."""

import json
import re
from typing import Any

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from benchmarks.__main__ import main
from benchmarks.load import tasks
from benchmarks.load.counted import counted
from benchmarks.load.growth import exponent, of_rows
from benchmarks.load.page import write_page
from benchmarks.load.sharing import sharing
from benchmarks.load.tasks import TASKS
from prsm_jax.load_sharing import Chains, Flanks, equilibrium, regularised
from prsm_jax.numerics import _stretches
from prsm_jax.numerics._stretches import over_samples


def test_an_exponent_is_that_of_the_large_sizes():
    sizes = [1, 100, 1000, 10_000]
    assert exponent(sizes, [3 * n**1.5 for n in sizes]) == pytest.approx(1.5)
    # A call costs 1 whatever its size: the smallest, 1/10,000 of the largest, does not count.
    assert exponent(sizes, [max(1.0, n / 100) for n in sizes]) == pytest.approx(1.0)
    assert exponent(sizes, [None, None, None, 1.0]) is None


def test_each_power_is_that_of_its_own_column():
    rows = [
        {"size": n, "operations": n**3, "processor_s": n**2, "run_bytes": n, "error": 0.0}
        for n in (1, 10, 100)
    ]
    # How long one ran that did not end says nothing.
    rows.append({**rows[-1], "size": 1000, "error": None})
    powers = {"operations": 3, "time": 2, "memory": 1}
    assert of_rows(rows) == {name: pytest.approx(power) for name, power in powers.items()}


def test_loops_count_by_their_trips_and_collect_what_they_return():
    def looped(values):
        return jax.lax.map(lambda value: value * value + 1.0, values)

    # A product and a sum, seven times; 8 bytes each, and seven times 8 that are collected.
    found = counted(looped, jnp.ones(7))
    assert found.operations == 14
    assert found.bytes == 2 * 8 + 7 * 8
    assert found.equations == 3
    product = counted(lambda a, b: a @ b, jnp.ones((4, 5)), jnp.ones((5, 3)))
    assert product.operations == 2 * 4 * 5 * 3


@pytest.mark.parametrize("count", [40, 41, 79, 80, 81])
def test_stretches_change_nothing(monkeypatch, count):
    monkeypatch.setattr(_stretches, "LONGEST", 40)
    rows = jnp.linspace(0.1, 3.0, count), {"b": jnp.arange(2.0 * count).reshape(count, 2)}

    def one(a, given):
        return jnp.sin(a) * given["b"], a**2

    for ours, plain in zip(over_samples(one, *rows), jax.vmap(one)(*rows), strict=True):
        np.testing.assert_array_equal(ours, plain)
    slopes = [
        jax.grad(lambda factor, over=over: jnp.sum(over(lambda a, g: one(factor * a, g), *rows)[0]))
        for over in (over_samples, lambda function, *rows: jax.vmap(function)(*rows))
    ]
    np.testing.assert_allclose(slopes[0](1.2), slopes[1](1.2), rtol=1e-13)
    loops = str(jax.make_jaxpr(lambda *rows: over_samples(one, *rows))(*rows)).count("scan[")
    assert loops == (count > 40)


def test_a_mission_is_linear_in_work_and_keeps_its_result_only():
    small, large = (
        counted(work.function, *work.arguments)
        for work in (TASKS["mission"].build(1), TASKS["mission"].build(2))
    )
    # A table of twice the points takes one more halving of 12, and stretches are not all as long.
    assert large.operations == pytest.approx(2 * small.operations, rel=0.03)
    # Bytes of a sample more. With all its numbers kept they are tens of thousands.
    kept = (large.bytes - small.bytes) / (3 * 3600)
    assert 8 < kept < 2500


def test_a_sequence_costs_the_same_however_often_it_is_repeated():
    times = jnp.linspace(0.0, 3.0, 50)

    def operations(repeats):
        part = prsm.scenario.TrapezoidalProfile(*map(jnp.asarray, (200.0, 0.03, 0.24, 0.03, 0.06)))
        profile = prsm.scenario.SequenceProfile((part,), repeats, reversing=True)
        return counted(jax.vmap(lambda time: profile(time)), times).operations

    assert operations(10_000) == operations(10)


@pytest.mark.parametrize("name", ["gradients_forward", "gradients_reverse"])
def test_designs_are_linear_in_work_and_keep_results_only(name, monkeypatch):
    monkeypatch.setattr(tasks, "_QUANTITIES", ("mass",))
    small, large = (
        counted(work.function, *work.arguments)
        for work in (TASKS[name].build(2000), TASKS[name].build(4000))
    )
    assert large.operations == 2 * small.operations
    # Three numbers in; a value and three derivatives out, collected by chunk and joined.
    assert (large.bytes - small.bytes) / 2000 == 8 * (3 + 2 * 4)


def test_threads_are_linear_and_rollers_cubic_in_work():
    def work(threads, rollers):
        function, arguments, _ = sharing(threads, rollers)
        return counted(function, *arguments)

    one, two, four = (work(threads, 6) for threads in (20, 40, 80))
    assert four.operations - two.operations == 2 * (two.operations - one.operations)
    assert four.bytes - two.bytes == 2 * (two.bytes - one.bytes)
    few, many = work(5, 20), work(5, 40)
    assert 2.5 < np.log2(many.operations / few.operations) < 3
    assert many.equations == few.equations


def test_the_program_of_rollers_with_play_is_linear_in_their_number():
    def equations(rollers):
        flanks = Flanks(*jnp.full((2, rollers, 5), 1e-6), *jnp.full((2, rollers, 1), 1e-8))
        unit = jnp.ones(())
        shaft = jnp.full(4, 1e-10)
        bare = Chains(jnp.ones(rollers), flanks, flanks, shaft, shaft, shaft, unit, unit, unit)
        chains = regularised(bare, load=100.0 * unit)
        return counted(eqx.filter_jit(equilibrium), chains, 100.0 * unit).equations

    first, second, third = (equations(rollers) for rollers in (17, 20, 23))
    assert third - second == second - first


def test_what_is_no_balance_is_seen():
    function, arguments, error = sharing(10, 6)
    found = function(*arguments)
    assert error(found) < 1e-8
    first, second, result, steps = found
    assert error((first.at[2, 3].multiply(1 + 1e-3), second, result, steps)) > 1e-4
    assert not error((first, second, result + 1, steps)) >= 0


def test_a_measurement_is_written_whole(tmp_path):
    """One task at its two smallest sizes, each in a process of its own; table, page, picture."""
    folder = tmp_path / "docs"
    given = ["load", "sharing_threads", "--smoke", "--out", str(tmp_path), "--docs", str(folder)]
    assert main(given) == 0
    (task,) = json.loads((tmp_path / "load.json").read_text(encoding="utf-8"))["tasks"]
    assert [row["size"] for row in task["sizes"]] == [10, 30]
    assert [row["steps"] for row in task["sizes"]] == [2, 3]
    for row in task["sizes"]:
        assert row["error"] < 1e-8
        assert 0 < row["best_s"] < row["compile_s"]
        assert 0 < row["run_bytes"] < 1e6 < row["peak_bytes"]
    page = (folder / "load.md").read_text(encoding="utf-8")
    table = (tmp_path / "load.md").read_text(encoding="utf-8")
    for text in (page, table):
        assert "| load sharing, threads of 6 unlike rollers | 30 threads |" in text
    assert (folder / "images" / "load.png").stat().st_size > 1000
    again = tmp_path / "again"
    assert main(["load", "--page", str(tmp_path / "load.json"), "--docs", str(again)]) == 0
    assert (again / "load.md").read_text(encoding="utf-8") == page


def test_tasks_by_name(capsys):
    assert main(["load", "--list"]) == 0
    assert capsys.readouterr().out.count("\n") == len(TASKS)
    with pytest.raises(SystemExit):
        main(["load", "nothing"])
    assert "unknown task nothing" in capsys.readouterr().err


def test_numbers_of_the_page_stand_under_their_headings(tmp_path):
    row = {"size": 3, "best_s": 1.5, "processor_s": 2.5, "operations": 7e6, "steps": 11}
    row |= {"run_bytes": 13e6, "peak_bytes": 17e8, "compile_s": 19.0, "error": None}
    task = {"title": "T", "unit": "u", "why": "w", "check": "c", "expected": 1.0}
    task["sizes"] = [row, {**row, "size": 2, "error": 1e-9}]
    task["exponents"] = {"operations": 1.01, "time": 1.02, "memory": 1.03}
    document = {"tasks": [task], "machine": {"cores": 2, "processor": "p"}}
    document |= {"date": "2026-01-02T03", "seconds": 60.0}
    page = write_page(document, tmp_path)[0].read_text(encoding="utf-8")
    rows = [re.split(r" *\| *", line)[1:-1] for line in page.splitlines() if line.startswith("| ")]
    (growth_names, growth), (names, cells), _ = [
        (rows[index - 2], row) for index, row in enumerate(rows) if row[0] == "T"
    ]
    assert dict(zip(growth_names, growth, strict=True)) == {
        **{"task": "T", "largest that ended": "2 us", "operations": "1.01", "expected": "1"},
        **{"processor time": "1.02", "memory": "1.03", "why": "w"},
    }
    assert dict(zip(names, cells, strict=True)) == {
        **{"task": "T", "size": "3", "run time": "1.5 s", "processor time": "2.5 s"},
        **{"operations": "7e+06", "steps": "11", "memory": "13 MB", "peak": "1.7e+03 MB"},
        **{"compiling": "19 s", "error": "not finite", "error against": "c"},
    }


def _solve(controller):
    """y' = ±1 − y, whose sign changes at each of three breaks, one of them given twice."""
    return diffrax.diffeqsolve(
        diffrax.ODETerm(lambda t, y, args: jnp.sign(jnp.sin(np.pi * t)) - y),
        diffrax.Tsit5(),
        *(jnp.asarray(0.0), jnp.asarray(3.5), None, jnp.asarray(0.5)),
        stepsize_controller=controller,
        saveat=diffrax.SaveAt(steps=True),
        max_steps=256,
    )


def test_steps_look_at_their_own_breaks_and_are_the_same():
    from prsm_jax.dynamics.solvers._many_breaks import ManyBreaks

    inner = diffrax.PIDController(rtol=1e-6, atol=1e-8)
    breaks = jnp.asarray([1.0, 2.0, 2.0, 3.0, 7.0, 7.0])
    ours: Any = ManyBreaks(inner, jump_ts=breaks)  # pyright: ignore[reportCallIssue]
    found, plain = _solve(ours), _solve(diffrax.ClipStepSizeController(inner, jump_ts=breaks))
    np.testing.assert_array_equal(found.ts, plain.ts)
    np.testing.assert_array_equal(found.ys, plain.ys)
    assert found.stats["num_rejected_steps"] == plain.stats["num_rejected_steps"]

    def work(kind, count):
        one, zero = jnp.asarray(1.0), jnp.asarray(0.0)
        controller = kind(inner, jump_ts=jnp.linspace(2.0, 3.0, count))
        term = diffrax.ODETerm(lambda t, y, args: -y)
        _, state = controller.init(term, zero, one, one, one, None, lambda *_: one, 5)

        def step(state):
            return controller.adapt_step_size(zero, one, one, one, None, 1e-9 * one, 5, state)[:4]

        return counted(step, state).operations

    assert work(ManyBreaks, 3000) == work(ManyBreaks, 300)
    assert work(diffrax.ClipStepSizeController, 3000) > work(ManyBreaks, 3000)
