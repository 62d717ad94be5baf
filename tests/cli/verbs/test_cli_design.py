"""The verbs that improve a design, and the demo: its optimum and its claims."""

import json
import tomllib
from pathlib import Path

import equinox as eqx
import numpy as np
import pytest

import prsm_jax
from prsm_jax import file
from tests import scenes
from tests.present import present

_compute = eqx.filter_jit(
    lambda m: prsm_jax.compute(m, ["efficiency", "max_pressure_shared", "drive_torque"])
)


def test_sensitivity_json(prsm_json):
    results = prsm_json(
        "sensitivity",
        "wu2022",
        "--quantities",
        "efficiency,carrier_frequency",
        "--parameters",
        "lead,roller_radius",
    )
    assert results["quantities"] == ["efficiency", "carrier_frequency[1]"]
    assert results["parameters"] == ["lead", "roller_radius"]
    assert np.shape(results["gradient"]) == np.shape(results["elasticity"]) == (2, 2)
    # ω² = K/(J/a² + N m) and a is proportional to the roller radius: closed form.
    stage = scenes.example("wu2022").stages[0]
    turning = float(stage.carrier.inertia / stage.thread.centre_distance**2)
    circling = 7 * float(present(stage.roller.mass))
    assert results["elasticity"][1][1] == pytest.approx(turning / (turning + circling), rel=1e-10)


def test_optimise_writes_a_file_that_gives_the_same_numbers(prsm_json, tmp_path):
    results = prsm_json("optimise", "actuator", "--starts", "1", "--out", tmp_path / "new")
    assert results.keys() >= {
        "start",
        "optimum",
        "objective_history",
        "constraints",
        "converged",
        "mechanism",
    }
    assert results["converged"]
    text = Path(results["mechanism"]).read_text()
    source = file.example_text("actuator")
    # The numbers are rounded, by no more than 1e-6 of any of these.
    comments = [
        [line.partition("#")[2] for line in one.splitlines() if "#" in line]
        for one in (text, source)
    ]
    assert comments[0] == comments[1]
    assert len(comments[0]) > 5
    again = file.load(results["mechanism"])
    values = _compute(again)
    assert float(values["efficiency"]) == pytest.approx(results["optimum"]["objective"], rel=1e-6)
    limits = {c["quantity"]: c for c in results["constraints"]}
    for name in ("max_pressure_shared", "drive_torque"):
        assert float(values[name]) == pytest.approx(limits[name]["value"], rel=1e-6)
        assert {"value", "limit", "active"} <= limits[name].keys()


def test_sweep_writes_a_store(prsm_json, tmp_path):
    results = prsm_json(
        "sweep",
        "wu2022",
        "--axis",
        "lead=5 mm:15 mm:3",
        "--axis",
        "roller_count=5,9",
        "--quantities",
        "efficiency",
        "--out",
        tmp_path,
    )
    assert (results["points"], results["failed"]) == (6, 0)
    import xarray

    data = xarray.open_zarr(results["store"], consolidated=False)
    np.testing.assert_allclose(data["lead"], [5e-3, 10e-3, 15e-3])
    assert data["efficiency"].shape == (3, 2)


@pytest.mark.parametrize(
    "axis", ["lead", "lead=1:2", "lead=5 mm:x:3", "leed=1,2", "lead=5 kg,6 kg"]
)
def test_a_bad_axis_is_one_line(prsm, tmp_path, axis):
    status, out, err = prsm("sweep", "wu2022", "--axis", axis, "--out", tmp_path / "o")
    assert (status, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    assert not (tmp_path / "o").exists()


@pytest.fixture(scope="module")
def optimum():
    mechanism = scenes.example("actuator")
    return mechanism, prsm_jax.optimise(mechanism)


def test_the_optimum_is_at_limits_that_are_named(optimum):
    mechanism, best = optimum
    assert best.problem == mechanism.design_problem
    assert len(best.constraints) == len(mechanism.design_problem.constraints)
    assert best.converged, str(best)
    assert best.kkt_residual < 1e-6
    active = {c.name for c in (*best.constraints, *best.margins) if c.active}
    # The margins of `check` belong to the limits, though the file does not name them.
    named = {"nut_axial_stiffness_secant", "nut_outer_diameter", "drive_torque"}
    assert active == named | {"backlash (stage 1)"}
    assert best.feasible
    assert [f.name for f in best.findings_optimum if f.severity == "error"] == []
    assert [f.name for f in prsm_jax.check(best.mechanism) if f.severity == "error"] == []
    # Without the margins of `check` its play would be -7.8 um.
    play = prsm_jax.compute(best.mechanism, ["axial_backlash"])["axial_backlash"]
    assert float(play[0]) > 0.9e-6
    assert not best.bounds_active
    assert best.optimum.objective > best.start.objective
    json.dumps(best.to_dict(), allow_nan=False)


def test_brute_force_finds_nothing_better(optimum):
    """A grid over the whole box: no feasible design is better, and the best is a step away."""
    mechanism, best = optimum
    problem = mechanism.design_problem
    counts = {"lead": 16, "contact_angle": 13, "roller_radius": 16, "roller_profile_radius": 13}
    axes = {v.name: np.linspace(v.lower, v.upper, counts[v.name]) for v in problem.variables}
    # The optimum's own values are on the grid too, so that its neighbours are.
    for name, values in axes.items():
        step = values[1] - values[0]
        optimal = best.optimum.variables[name]
        axes[name] = np.unique(np.concatenate([values, optimal + step * np.array([-0.1, 0, 0.1])]))
    names = ["efficiency", "axial_backlash", *(c.quantity for c in problem.constraints)]
    data = prsm_jax.sweep(mechanism, axes, names)
    feasible = ~data["failed"].values
    # What `check` asks for, and the micrometre of reserve.
    feasible &= data["axial_backlash"].values[..., 0] >= 1e-6 * (1 - 1e-9)
    for constraint in problem.constraints:
        values = data[constraint.quantity].values
        # The optimum itself lies on its limits to rounding.
        if constraint.upper is not None:
            feasible &= values <= constraint.upper * (1 + 1e-9)
        if constraint.lower is not None:
            feasible &= values >= constraint.lower * (1 - 1e-9)
    found = data["efficiency"].values[feasible]
    assert feasible.sum() > 100
    assert found.max() == pytest.approx(best.optimum.objective, abs=1e-9)
    # Without the limits there are better designs: the comparison can fail.
    assert np.nanmax(data["efficiency"].values) > best.optimum.objective + 0.005


#: Examples that ask for an optimisation; that of the demo is among them.
OPTIMISED = [name for name in file.example_names() if "\n[optimise]" in file.example_text(name)]


@pytest.mark.timeout(900)
@pytest.mark.parametrize("name", OPTIMISED)
def test_the_optimum_of_every_example_passes_check(prsm, prsm_json, tmp_path, name):
    """The file as it is written and rounded; its findings are those that the optimisation told."""
    results = prsm_json("optimise", name, "--out", tmp_path)
    assert results["converged"]
    status, out, err = prsm("check", results["mechanism"], "--json", "-")
    assert (status, err) == (0, "")
    checked = json.loads(out)
    assert checked["errors"] == 0
    told = [(f["name"], f["severity"]) for f in results["findings_optimum"]]
    assert told == [(f["name"], f["severity"]) for f in checked["findings"]]
    start = [(f.name, f.severity) for f in prsm_jax.check(scenes.example(name))]
    assert [(f["name"], f["severity"]) for f in results["findings_start"]] == start


def test_the_example_of_the_demo_is_one_of_them():
    assert "actuator" in OPTIMISED


@pytest.mark.timeout(900)
@pytest.mark.usefixtures("memory_for_large_programs")
def test_demo(prsm, tmp_path):
    """Everything is there, and the optimised file gives the numbers that the report claims."""
    folder = tmp_path / "demo"
    status, out, err = prsm("demo", "--out", folder)
    assert status == 0, err
    assert str(folder / "report.html") in out
    for name in ("report.html", "report.md", "report.json", "results.json", "optimised.toml"):
        assert (folder / name).stat().st_size > 1000
    pictures = {path.stem for path in (folder / "figures").glob("*.png")}
    assert pictures >= {
        "before_after",
        "frequencies",
        "transient",
        "sensitivities",
        "optimisation",
        "losses",
    }
    results = json.loads((folder / "results.json").read_text())
    differentiated = results["sensitivity"]["quantities"]
    assert {"dynamic_capacity[1]", "rating_life_time[1]", "buckling_safety"} <= set(differentiated)
    assert "rating life time, stage 1" in (folder / "report.md").read_text()
    assert tomllib.loads((folder / "optimised.toml").read_text())["stage"]
    assert prsm("check", folder / "optimised.toml")[0] == 0
    improved = file.load(folder / "optimised.toml")
    state = scenes.steady_state(improved)
    claimed = results["optimise"]["optimum"]["objective"]
    assert float(state.efficiency) == pytest.approx(claimed, rel=1e-6)
    assert results["after"]["steady"]["efficiency"] == pytest.approx(claimed, rel=1e-6)
    # The report says so in words: per cent with the digits that it prints.
    assert f"{100 * claimed:.2f}" in (folder / "report.md").read_text()
