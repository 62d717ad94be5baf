"""Fronts and starts: what the commands measure, the rival's problem, and the page of both."""

import dataclasses
import json

import numpy as np
import pytest
import scenes
import stand_in_for_pymoo

import prsm_jax as prsm
from benchmarks.__main__ import main
from benchmarks.fronts.command import PROBLEMS
from benchmarks.fronts.rival import nsga2
from benchmarks.harness import why_left_out
from prsm_jax.mechanism import Constraint, DesignProblem, Nut, Objective, Variable


def _run():
    return {
        "machine": {"cores": 2, "processor": "slide rule"},
        "date": "2026-01-02T03:04:05+00:00",
    }


def _rival(population, seed, volume):
    return {
        "population": population,
        "seed": seed,
        "evaluations": 4000,
        "points": 9,
        "hypervolume": volume,
        "seconds": 12.34,
    }


def _fronts(ratio):
    one = {
        "points": 11,
        "evaluations": 150,
        "derivative_evaluations": 50,
        "evaluations_by_variables": 350,
        "largest_kkt_residual": 3e-7,
        "converged": True,
        "hypervolume": 0.75,
        "seconds": 1.25,
        "nsga2": [_rival(11, 1, 0.75 / ratio), _rival(100, 2, 0.5)],
        "evaluation_ratio": 20.0,
        "hypervolume_ratio": ratio,
    }
    return {**_run(), "problems": {"efficiency_size": one}}


def _starts():
    def row(best, values, seconds):
        return {
            "best": best,
            "evaluations": values,
            "derivative_evaluations": 7,
            "searches": 3,
            "samples_s": [seconds, 2 * seconds],
            "first_call_s": 30.0,
        }

    rows = {"one by one": row(0.9, 5000, 8.0), "at once": row(0.9, 600, 2.0)}
    return {
        **_run(),
        "example": "actuator",
        "starts": 200,
        "rows": rows,
        "speed_ratio": 4.0,
        "difference": 2e-9,
    }


def _page(folder, command, name, document):
    path = folder / f"{name}.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    given = [command, "--page", str(path), "--docs", str(folder), "--out", str(folder)]
    assert main(given) == 0
    return (folder / "fronts.md").read_text(encoding="utf-8")


def test_each_command_writes_what_is_known(tmp_path):
    page = _page(tmp_path, "fronts", "fronts", _fronts(1.25))
    assert "| gradients, 11 points | 0.75000 | 200 (350) | 1.2 s |" in page
    assert "| NSGA-II, 11 a generation, seed 1 | 0.60000 | 4000 | 12.3 s |" in page
    assert "best of NSGA-II 1.2500, with 20.0 times fewer evaluations: goal reached" in page
    assert "Many starts" not in page
    page = _page(tmp_path, "starts", "starts", _starts())
    assert "NSGA-II, 100 a generation, seed 2" in page
    assert "| one by one | 0.9 | 5000 | 7 | 3 | 8.00 s | 30.0 s |" in page
    assert '"At once" is 4 times as fast (median of runs in turn)' in page
    assert "the relative difference of the objectives is 2e-09." in page


def test_a_goal_that_is_missed_is_called_so(tmp_path):
    assert "goal NOT reached" in _page(tmp_path, "fronts", "fronts", _fronts(0.99))


def test_a_rival_that_is_not_installed_has_a_row(tmp_path):
    document = _fronts(1.25)
    document["problems"]["efficiency_size"] |= {
        "nsga2": [],
        "left_out": why_left_out("no_such_package"),
        "evaluation_ratio": None,
        "hypervolume_ratio": None,
    }
    page = _page(tmp_path, "fronts", "fronts", document)
    assert "| NSGA-II | not installed: no_such_package | – | – |" in page
    assert "The goal is not judged. Largest Karush–Kuhn–Tucker residual of a point 3e-07" in page
    assert why_left_out("pytest") is None


#: Cheap to compile; the pressure bounds the front.
_PROBLEM = DesignProblem(
    (Variable("lead", 5e-3, 15e-3), Variable("roller_radius", 3e-3, 6e-3)),
    (Objective("efficiency", "maximise"),),
    (
        Constraint("max_pressure", upper=1.6e9),
        Constraint("nut_outer_diameter", lower=0.04, upper=0.16),
    ),
)


@pytest.fixture
def mechanism(monkeypatch):
    nut = Nut(mass=2.0, inertia=9e-4, wall_thickness=8e-3)
    made = scenes.mechanism(scenes.stage(nut=nut))
    made = dataclasses.replace(made, design_problem=_PROBLEM)
    monkeypatch.setattr(prsm, "load", lambda _: made)
    return made


def test_fronts_run_without_pymoo(mechanism, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("benchmarks.fronts.command.why_left_out", lambda _: "not installed: it")
    words = ["efficiency_size", "--points", "4", "--seeds", "1"]
    given = ["--out", str(tmp_path), "--docs", str(tmp_path)]
    assert main(["fronts", *words, *given]) == 0
    one = json.loads((tmp_path / "fronts.json").read_text())["problems"]["efficiency_size"]
    assert one["converged"]
    assert one["points"] == 4
    assert one["nsga2"] == []
    assert 0.3 < one["hypervolume"] < 1
    assert one["evaluations_by_variables"] == one["evaluations"] + 2 * one["derivative_evaluations"]
    assert "NSGA-II not installed: it" in capsys.readouterr().out
    page = (tmp_path / "fronts.md").read_text(encoding="utf-8")
    assert "| gradients, 4 points |" in page
    assert "| NSGA-II | not installed: it | – | – |" in page


def test_the_rival_has_the_same_problem(mechanism, monkeypatch):
    """Objectives and violations of random designs, against `compute` at the same designs."""
    seen = stand_in_for_pymoo.install(monkeypatch)
    problem = dataclasses.replace(_PROBLEM, objectives=PROBLEMS["efficiency_size"])
    found, count, seconds = nsga2(mechanism, problem, 8, 16, 1)
    assert count == 16
    assert seconds > 0
    assert [len(one.positions) for one in seen] == [8, 8]
    feasible = []
    for given in seen:
        for place, objectives, broken in zip(*given, strict=True):
            lead, radius = 5e-3 + 10e-3 * place[0], 3e-3 + 3e-3 * place[1]
            design = prsm.mechanism.set_parameters(
                mechanism, {"lead": lead, "roller_radius": radius}
            )
            names = ["efficiency", "nut_outer_diameter", "max_pressure"]
            efficiency, size, pressure = map(float, prsm.compute(design, names).values())
            # Rounding of the same numbers in another program.
            np.testing.assert_allclose(objectives, [-efficiency, size], rtol=1e-11)
            # Over the larger of both limits.
            over = [pressure / 1.6e9 - 1, (0.04 - size) / 0.16, size / 0.16 - 1]
            for one in over:
                assert np.isclose(broken, one, rtol=1e-9, atol=1e-12).any(), (one, broken)
            errors = [f.name for f in prsm.check(design) if f.severity == "error"]
            assert (max(broken) <= 0) == (not errors and max(over) <= 0)
            if max(broken) <= 0:
                feasible.append(objectives)
    assert 0 < len(feasible) < 16
    np.testing.assert_array_equal(found, feasible)


def test_starts_run(mechanism, tmp_path, capsys):
    words = ["--starts", "4", "--steps", "3", "--keep", "2", "--rounds", "1"]
    given = ["--out", str(tmp_path), "--docs", str(tmp_path)]
    assert main(["starts", *words, *given]) == 0
    document = json.loads((tmp_path / "starts.json").read_text())
    slow, fast = document["rows"].values()
    # Both reach the same optimum, which the exit status says too.
    assert document["difference"] == abs(fast["best"] - slow["best"]) / abs(slow["best"])
    assert document["speed_ratio"] == slow["samples_s"][0] / fast["samples_s"][0]
    assert slow["searches"] == 4
    assert "4 starts: at once is" in capsys.readouterr().out
    page = (tmp_path / "fronts.md").read_text(encoding="utf-8")
    assert f"| one by one | {slow['best']:.10g} |" in page
