"""Every case runs, at its quick size, and its errors are those that README claims."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.cases import case_names, many_transients
from tests.compilation_cache import cache_folder

ROOT = Path(__file__).parents[2]
_PATHS = [str(ROOT), os.environ["PYTHONPATH"]]
#: A second run of the tests finds the programs of the first.
_KEPT = {
    "JAX_COMPILATION_CACHE_DIR": cache_folder(),
    "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A case by `--smoke`, in a process of its own as at the command line: its JSON and table."""
    known = {}
    folder = tmp_path_factory.mktemp("benchmarks")

    def find(name):
        if name not in known:
            subprocess.run(
                [sys.executable, "-m", "benchmarks", name, "--smoke", "--out", str(folder)],
                check=True,
                cwd=ROOT,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(_PATHS)} | _KEPT,
                capture_output=True,
            )
            found = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
            for problem in found["problems"]:
                assert (folder / f"{name}-{problem['name']}.png").stat().st_size > 1000
            known[name] = found, (folder / f"{name}.md").read_text(encoding="utf-8")
        return known[name]

    return find


@pytest.mark.parametrize("name", case_names())
def test_a_case_runs_and_comes_near_its_target(run, name):
    """Some setting of this package's methods comes near the error that the case compares at."""
    found, text = run(name)
    assert found["problems"]
    for problem in found["problems"]:
        ours = [row for row in problem["results"] if row["kind"] == "method"]
        assert ours
        for row in problem["results"]:
            for error in row["errors"].values():
                # Errors speak of those instances that they name.
                assert 0 < error["instances"] <= row["instances"]
                assert error["compared"] % error["instances"] == 0
        best = min(
            max(error["max"] for error in row["errors"].values())
            for row in ours
            if all(error["max"] is not None for error in row["errors"].values())
        )
        # The quick grids and tolerances are coarser than those that the target is for.
        # Grids of cells on flanks that end are good to a per cent.
        usual = 1e-2 if name == "truncated_contact" else 2e-5
        assert best <= 5 * problem.get("at_equal_error", {}).get("target", usual)
        for absent in problem["left_out"]:
            assert "not installed" in absent["reason"]
            assert re.search(rf"\| {re.escape(absent['method'])} \(rival\) \|.*left out", text)


def test_no_problem_of_a_case_is_left_out_of_the_smoke_run(run):
    """Settling, missions few and many, without a jump of friction too, derivatives, lock step."""
    names = {problem["name"] for problem in run("many_transients")[0]["problems"]}
    missions = {"mission", "mission_smooth", "many_missions"}
    assert names == {"settle", *missions, "gradients", "gradient_of_one", "lock_step"}


def test_rivals_that_are_not_installed_are_rows(monkeypatch):
    monkeypatch.setattr(many_transients, "missing_rivals", lambda: ["casadi", "numbalsoda"])
    cvodes = many_transients._CASADI.format("CVODES")
    assert many_transients._left_out(many_transients._LSODA, cvodes) == {
        many_transients._LSODA: "not installed: numbalsoda",
        cvodes: "not installed: casadi",
    }


@pytest.mark.parametrize(
    ("row", "case", "problem", "method", "place"),
    [
        ("meshing points of five", "meshing", "contact_point", "mesh, position only", -1),
        ("elliptical Hertz contact", "hertz", "range", "exact", -1),
        ("natural frequencies", "frequencies", "rollers_7", "reduced", 0),
    ],
)  # fmt: skip
def test_tolerances_of_the_readme(run, row, case, problem, method, place):
    """The error beside a line of README's table is at least the benchmark's, and no idle one."""
    (line,) = [
        one
        for one in (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
        if one.startswith(f"| {row} ")
    ]
    stated = float(re.findall(r"\d(?:\.\d)?e-\d+", line.split("|")[3])[place])
    (measured,) = [one for one in run(case)[0]["problems"] if one["name"] == problem]
    errors = [
        error["max"]
        for one in measured["results"]
        if one["method"] == method
        for error in one["errors"].values()
    ]
    assert 0.1 * stated <= max(errors) <= stated


def test_derivatives_through_the_chain_against_equations_written_apart(run):
    """Geometry to frequency by mpmath: meshing, curvatures, contact, gear, masses, eigenvalues."""
    (problem,) = [one for one in run("many_designs")[0]["problems"] if one["name"] == "geometry"]
    assert "mpmath" in problem["reference"]
    (ours,) = [one for one in problem["results"] if one["method"] == "distinct, forward"]
    assert max(error["max"] for error in ours["errors"].values()) < 1e-12
