"""The benchmark of the catalogue: its problem, its batch, and its page against its own data."""

import functools
import json
import math
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from benchmarks.catalogue import command, lockstep
from benchmarks.catalogue.batched import solve, whole_beside
from benchmarks.catalogue.checked import design_of
from benchmarks.catalogue.lockstep import searched_together
from benchmarks.catalogue.page import page_of
from benchmarks.catalogue.picture import percents
from benchmarks.catalogue.problem import (
    ALLOWED,
    FEWEST_ROLLERS,
    LOWER,
    MEASURES,
    UPPER,
    built,
    dimensioned,
    limits_of,
    sizes,
    varied,
)
from benchmarks.catalogue.rival import decoded, encoded_start
from benchmarks.catalogue.tasks import measured_together, stacked, tasks_of

DOCS = Path(__file__).parents[2] / "docs"
#: Index of each size by its name.
SIZES = {size.name: size for size in sizes()}


def test_searches_in_step_get_their_own_answers():
    """Searches of 1 to 4 questions: as many calls as the longest one has."""
    together = []

    def answer(positions):
        together.append(positions.copy())
        return positions**2, positions[:, 0]

    def search(index, ask):
        found = []
        for step in range(index + 1):
            position = np.array([index + 10.0 * step, 1.0])
            squares, first = ask(position)
            np.testing.assert_array_equal(squares, position**2)
            found.append(float(first))
        return found

    results, shared = searched_together(search, answer, np.zeros((4, 2)))
    assert results == [[index + 10.0 * step for step in range(index + 1)] for index in range(4)]
    assert shared.calls == len(together) == 4
    assert shared.questions == 1 + 2 + 3 + 4


def test_a_failed_evaluation_ends_all_searches():
    def answer(_positions):
        raise ValueError("no values")

    with pytest.raises(RuntimeError, match="common evaluation"):
        searched_together(lambda _, ask: ask(np.zeros(1)), answer, np.zeros((3, 1)))


def test_a_search_that_fails_does_not_hold_up_the_others(monkeypatch):
    """Not even where one of them has not begun when it fails."""
    early, asked = threading.Semaphore(2), threading.Event()
    late = functools.partial(
        ThreadPoolExecutor, initializer=lambda: early.acquire(blocking=False) or time.sleep(0.2)
    )
    monkeypatch.setattr(lockstep, "ThreadPoolExecutor", late)

    def search(index, ask):
        if index == 0:
            assert asked.wait(10)
            raise ValueError("one search")
        asked.set()
        return ask(np.ones(1))

    with pytest.raises(ValueError, match="one search"):
        searched_together(search, lambda positions: (positions,), np.zeros((3, 1)))


@pytest.mark.parametrize("name", ["8 x 2, 4 starts", "30 x 6, 5 starts", "36 x 24, 6 starts"])
def test_a_varied_mechanism_is_the_built_one(name):
    """Every number, with other starts, lengths and angles; to rounding."""
    size = SIZES[name]
    starts, count = size.choices[-1], 7
    variables = (math.radians(51.0), 0.8, 0.7)
    expected = built(size, starts, *variables, count)
    found = varied(dimensioned(size, starts), jnp.asarray([*variables, float(count)]))
    assert float(found.stages[0].roller_count) == expected.stages[0].roller_count == count
    found = eqx.tree_at(lambda m: m.stages[0].roller_count, found, expected.stages[0].roller_count)
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14)


def test_every_choice_stays_in_the_envelope_of_its_size():
    """And the size's own number of starts is one of the choices."""
    assert len(SIZES) == 90
    for size in SIZES.values():
        assert size.choices[0] == size.starts
        for starts in size.choices:
            roller = size.row["nominal_diameter_mm"] / (starts - 2)
            outer = starts * roller + 2e3 * size.wall
            assert outer <= size.row["nut_outer_diameter_mm"] * (1 + 1e-12)
            assert roller >= 3.2 or starts == size.starts


def test_limits_are_those_of_the_start_less_the_allowed_loss():
    start = np.array([9.0, 8.0, 7.0, 6.0, 0.8, 0.7, 5e4])
    np.testing.assert_allclose(
        limits_of(start, 2e4, 0.005), [9.0, 8.0, 7.0, 6.0, 0.795, 0.695, 2e4], rtol=1e-15
    )
    assert limits_of(start, 9e4, 0.0)[-1] == 5e4


def test_the_rival_has_the_same_design_space():
    """The ends of its box are the bounds, with whole starts and rollers."""
    size = SIZES["30 x 5, 5 starts"]
    most = np.array([11.0, 14.0, 17.0, 20.0])
    ends = np.array([[0.0] * 5, [1.0] * 5, encoded_start()])
    index, variables = decoded(size, most, ends)
    assert [size.choices[i] for i in index] == [5, 8, 5]
    expected = [[*LOWER, FEWEST_ROLLERS], [*UPPER, 20.0], [math.pi / 4, 1.0, 1.0, 11.0]]
    np.testing.assert_allclose(variables, expected, rtol=1e-15)
    random = np.random.default_rng(1).random((500, 5))
    index, variables = decoded(size, most, random)
    assert set(index) == {0, 1, 2, 3}
    assert np.all(variables[:, 3] == np.round(variables[:, 3]))
    assert np.all(variables[:, 3] <= most[index])
    assert set(variables[index == 0, 3]) == set(range(FEWEST_ROLLERS, 12))


def _numbers(mechanism):
    values = prsm.compute(mechanism, MEASURES)
    return {name: float(jnp.sum(value)) for name, value in values.items()}


@pytest.mark.parametrize(
    ("count", "expected"),
    [(14.0, ()), (14 - 4e-15, ()), (14 - 3e-7, (14.0,)), (12.3, (12.0, 13.0))],
)
def test_numbers_of_rollers_to_search_again_with(count, expected):
    assert whole_beside(count) == expected


def test_a_search_with_whole_rollers_begins_at_the_end_before_it():
    tasks, _ = tasks_of([SIZES["68 x 12, 6 starts"]], 0.0)
    near = np.array([0.79, 1.9, 0.93, 13.9999997])
    again = tasks[0].with_rollers(14.0, near)
    np.testing.assert_array_equal(again.first, [0.79, 1.9, 0.93, 14.0])
    assert again.lower[3] == again.upper[3] == 14.0
    np.testing.assert_allclose(again.physical(again.unit(again.first)), again.first, rtol=1e-15)


def test_two_sizes_are_improved_and_feasible():
    """Built by public functions and evaluated one by one; no design nearby is better."""
    chosen = [SIZES["15 x 5, 5 starts"], SIZES["21 x 2, 5 starts"]]
    loss = ALLOWED["half_digit"]
    batch = solve(chosen, loss)
    for size in chosen:
        found = batch.best(size)
        own, design = dimensioned(size, size.starts), design_of(found)
        before, after = _numbers(own), _numbers(design)
        gained = min(
            math.log(after["dynamic_capacity"] / before["dynamic_capacity"]),
            math.log(after["axial_stiffness"] / before["axial_stiffness"]),
            math.log(before["nut_unit_mass"] / after["nut_unit_mass"]),
        )
        # The batch evaluates the same numbers in another order: rounding.
        assert gained == pytest.approx(found.objective, abs=1e-11)
        assert gained > 0.08
        # SLSQP ends within its tolerance of 1e-9 of a limit.
        assert after["static_capacity"] > before["static_capacity"] * (1 - 1e-8)
        assert after["efficiency"] > before["efficiency"] - loss - 1e-8
        assert after["efficiency_backward"] > before["efficiency_backward"] - loss - 1e-8
        load = float(own.operating_point.load)
        assert after["truncation_load"] > min(before["truncation_load"], load) * (1 - 1e-8)
        assert [one for one in prsm.check(design) if one.severity == "error"] == []
        assert found.kkt_residual < 1e-9
        _nothing_near_is_better(found)


def _nothing_near_is_better(found):
    """Of 2,000 designs within 2 % of the range, with these starts, none is feasible and better."""
    task = found.task
    near = task.unit(found.variables) + np.random.default_rng(0).uniform(-0.02, 0.02, (2000, 4))
    variables = task.physical(np.clip(near, 0.0, 1.0))
    batch = stacked([task.mechanism])
    values, good = measured_together(batch, jnp.zeros(2000, int), jnp.asarray(variables))
    ratios = np.asarray(values) / task.limits
    t = np.log(np.minimum(np.minimum(ratios[:, 0], ratios[:, 1]), 1 / ratios[:, 2]))
    feasible = np.asarray(good) & (ratios[:, 3:] >= 1).all(axis=1)
    assert feasible.sum() > 20
    assert t[feasible].max() < found.objective
    assert t.max() > found.objective


def _document():
    return json.loads((DOCS / "catalogue_benchmark.json").read_text(encoding="utf-8"))


def test_the_page_is_that_of_its_data():
    written = (DOCS / "catalogue_benchmark.md").read_text(encoding="utf-8")
    assert page_of(_document()) == written


def test_a_rival_that_is_not_installed_has_a_row(monkeypatch):
    monkeypatch.setattr(command, "why_left_out", lambda _: "not installed: pymoo")
    none: Any = None
    document = _document()
    for problem in document["problems"].values():
        problem["left_out"] = "not installed: pymoo"
        for row in problem["sizes"]:
            row["rivals"] = command.rivals_of(none, none, 100, 3)
    page = page_of(document)
    words = "not installed: pymoo"
    assert f"| NSGA-II | {words} | {words} |" in page
    assert "default operators" not in page
    (row,) = [line for line in page.splitlines() if line.startswith("| 8 x 2 |")][:1]
    assert row.endswith(" – |")


def test_stored_results_are_what_the_page_says():
    """Each of 90 sizes in both problems; masses by the volumes of cylinders."""
    rows = {one["size"]: one for one in _document()["problems"]["half_digit"]["sizes"]}
    assert list(rows) == list(SIZES)
    for problem in _document()["problems"].values():
        for row in problem["sizes"]:
            own, best, limits = row["own"], row["measures"], row["limits"]
            gained = [
                best["dynamic_capacity"] / own["dynamic_capacity"],
                best["axial_stiffness"] / own["axial_stiffness"],
                own["nut_unit_mass"] / best["nut_unit_mass"],
            ]
            # Twelve digits are stored.
            assert math.log(min(gained)) == pytest.approx(row["objective"], abs=1e-10)
            assert row["objective"] > -1e-9
            for name in MEASURES[3:]:
                assert best[name] > limits[name] * (1 - 1e-7)
            assert own["efficiency"] - limits["efficiency"] == pytest.approx(
                problem["allowed_loss"], abs=1e-11
            )
            assert row["kkt_residual"] < 1e-6
            assert row["checked"]["errors"] == []
            assert best["nut_unit_mass"] == pytest.approx(_mass(row), rel=1e-10)


def _mass(row):
    """Nut, rollers and two carriers, of steel [kg]."""
    size, found = SIZES[row["size"]], row["variables"]
    radius = size.diameter / 2 / (row["starts"] - 2)
    inner, length = row["starts"] * radius, row["nut_length_mm"] * 1e-3
    outer = row["nut_outer_diameter_mm"] * 5e-4
    nut = (outer**2 - inner**2) * length
    rollers = found["roller_count"] * radius**2 * 0.85 * length
    circle = size.diameter / 2 + radius
    carriers = 2 * 0.02 * length * ((circle + radius / 2) ** 2 - (circle - radius / 2) ** 2)
    return 7850 * math.pi * (nut + rollers + carriers)


def test_the_picture_shows_changes_that_are_better_above_zero():
    row = {
        "own": {"dynamic_capacity": 100.0, "axial_stiffness": 4.0, "nut_unit_mass": 2.0},
        "measures": {"dynamic_capacity": 125.0, "axial_stiffness": 5.0, "nut_unit_mass": 1.6},
    }
    assert percents([row], "dynamic_capacity") == pytest.approx([25.0])
    assert percents([row], "axial_stiffness") == pytest.approx([25.0])
    assert percents([row], "nut_unit_mass") == pytest.approx([20.0])
