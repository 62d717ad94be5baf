"""The verbs that improve a design, and the demo: its optimum and its claims."""

import dataclasses
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
    lambda m: prsm_jax.compute(m, ["efficiency", "max_pressure", "drive_torque"])
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


#: A screw with a comment on every kind of line, and a variable that the file does not give.
SMALL = """# A screw of which little is known.
title = "Small screw"

[operating_point]
speed = "1500 rpm"            # of the screw
load = "12 kN"

[[stage]]
roller_count = 10
engaged_threads = 20          # of 25

[stage.thread]
lead = "10 mm"                # pitch 2 mm
starts = 5
roller_radius = "4 mm"        # nut of 40 mm in diameter follows
contact_angle = "45 deg"

[stage.material]              # steel
youngs_modulus = "210 GPa"
poisson_ratio = 0.3

[stage.friction.thread]       # grease
law = "coulomb"
coefficient = 0.06

[optimise]
maximise = "efficiency"
starts = 4
seed = 0

[[optimise.variable]]
name = "lead"
lower = "5 mm"
upper = "20 mm"

[[optimise.variable]]
name = "roller_profile_radius"
lower = "4 mm"
upper = "12 mm"

[[optimise.constraint]]       # of every thread
quantity = "max_pressure"
upper = "1.9 GPa"

[[optimise.constraint]]       # what the motor gives
quantity = "drive_torque"
upper = "25 N m"
"""


def test_optimise_writes_a_file_that_gives_the_same_numbers(prsm_json, tmp_path):
    (tmp_path / "small.toml").write_text(SMALL)
    results = prsm_json("optimise", "small.toml", "--starts", "1", "--out", tmp_path / "new")
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
    assert text.startswith(
        "# Changed by prsm optimise: stage.thread.lead, stage.thread.roller_profile_radius.\n"
        "# The comments of the changed lines were removed; other comments may describe the former "
        "numbers.\n\n# A screw of which little is known.\n"
    )
    # The comment that described the former lead is gone, the others stay.
    comments, before = (
        [line.partition("#")[2] for line in one.splitlines() if "#" in line]
        for one in (text, SMALL)
    )
    before.remove(" pitch 2 mm")
    assert comments[2:] == before
    assert len(before) > 5
    # The numbers are rounded, by no more than 1e-6 of any of these.
    again = file.load(results["mechanism"])
    for name, value in results["optimum"]["variables"].items():
        assert float(prsm_jax.get_parameter(again, name)) == pytest.approx(value, rel=1e-5)
        before = float(prsm_jax.get_parameter(file.loads(SMALL), name))
        assert value != pytest.approx(before, rel=1e-2)
    values = _compute(again)
    assert float(values["efficiency"]) == pytest.approx(results["optimum"]["objective"], rel=1e-6)
    limits = {c["quantity"]: c for c in results["constraints"]}
    for name in ("max_pressure", "drive_torque"):
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
    assert best.converged, str(best)
    assert best.kkt_residual < 1e-6
    assert best.problem == mechanism.design_problem
    assert len(best.constraints) == len(mechanism.design_problem.constraints)
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
    json.dumps(best.to_dict(), allow_nan=False)
    assert best.optimum.objective > best.start.objective


def test_margins_of_dimensions_have_the_units_of_their_numbers(optimum):
    _, best = optimum
    given = {one.name: (one.value, one.unit) for one in best.margins}
    at = best.optimum.variables
    for name, value, unit in (
        ("lead", at["lead"], "m"),
        ("roller_radius", at["roller_radius"], "m"),
        ("contact_angle", min(at["contact_angle"], np.pi / 2 - at["contact_angle"]), "rad"),
        ("roller_profile_radius", at["roller_profile_radius"], "m"),
    ):
        assert given[f"dimension of {name} (stage 1)"] == (pytest.approx(value, rel=1e-12), unit)


def test_the_example_breaks_four_limits_as_its_comment_says(optimum):
    _, best = optimum
    (line,) = (one for one in str(best).splitlines() if "start breaks" in one)
    named = line.partition(": ")[2].split("; ")
    assert [one.partition(" = ")[0] for one in named] == [
        "max_pressure_shared",
        "first_axial_frequency",
        "nut_axial_stiffness_secant",
        "nut_outer_diameter",
    ]
    assert named[3] == "nut_outer_diameter = 60 against a limit of 58 mm"


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


def test_warnings_are_constraints_on_request(prsm_json, tmp_path):
    """20 threads between the gears of a roller of 50 mm: a pitch of 2 mm, a lead of 10 mm."""
    start = scenes.frictionless(
        roller=prsm_jax.mechanism.Roller(mass=0.03, inertia=4e-7, length=50e-3),
        nut=prsm_jax.mechanism.Nut(mass=2.2, inertia=9e-4),
        gear=prsm_jax.mechanism.Gear(np.radians(20), roller_teeth=16, face_width=6e-3),
        sharing="equal",
    )
    problem = prsm_jax.mechanism.DesignProblem(
        (
            prsm_jax.mechanism.Variable("lead", 5e-3, 20e-3),
            prsm_jax.mechanism.Variable("roller_radius", 3e-3, 5e-3),
        ),
        (prsm_jax.mechanism.Objective("nut_speed", "maximise"),),
    )
    path = tmp_path / "start.toml"
    text = file.dumps(dataclasses.replace(start, design_problem=problem))
    path.write_text(text, encoding="utf-8")
    words = ("optimise", path, "--out", tmp_path / "out")
    assert prsm_json(*words)["optimum"]["variables"]["lead"] > 12.4e-3
    avoided = prsm_json(*words, "--avoid-warnings")
    assert avoided["optimum"]["variables"]["lead"] == pytest.approx(10e-3, rel=1e-4)
    front = prsm_json(
        *("pareto", path, "--maximise", "nut_speed", "--minimise", "nut_radius"),
        *("--points", "3", "--avoid-warnings"),
    )
    assert max(one["variables"]["lead"] for one in front["points"]) < 10.001e-3
