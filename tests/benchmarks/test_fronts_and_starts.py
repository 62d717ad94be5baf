"""The page of fronts and starts: its numbers, its verdicts, and which parts it has."""

import json

from benchmarks.__main__ import main


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
    assert "at once is 4 times as fast; the objectives differ by 2e-09" in page


def test_a_goal_that_is_missed_is_called_so(tmp_path):
    assert "goal NOT reached" in _page(tmp_path, "fronts", "fronts", _fronts(0.99))
