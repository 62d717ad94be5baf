"""Every key and line of the verbs of vibration and of design, against SI numbers."""

import dataclasses
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
import reading_scenes as made
import scenes
from expectations import reads
from reading_tables import Terminal, assert_json, column_unit, without_words
from reading_units import to_si

import prsm_jax
from prsm_jax.cli.verbs import _modal, _sweep, _vibrate
from prsm_jax.mechanism import Constraint, DesignProblem, Objective, Variable
from prsm_jax.optimisation import ConstraintReport, Design, Optimum, Run
from prsm_jax.report import summarise_optimisation
from prsm_jax.response import FrequencyResponse
from prsm_jax.sensitivities import Sensitivity
from prsm_jax.vibration import FAMILIES


@pytest.fixture(scope="module")
def modes():
    return scenes.modal(scenes.example("wu2022"), shapes=True)


@reads("verb", "modal")
def test_modal(run, monkeypatch, modes):
    loci = made.loci()
    monkeypatch.setattr(_modal, "run_modal", lambda *_, **__: modes)
    monkeypatch.setattr(_modal, "frequency_loci", lambda *_, **__: loci)
    words = ("--against", "contact_angle", "--from", "40 deg", "--to", "50 deg")
    found, printed = run("modal", "wu2022", "--shapes", *words)
    families = ["torsional", "transverse"]
    veering = {"family": "torsional", "value": 0.8, "frequencies_hz": [2970.0, 3030.0]}
    assert_json(
        without_words(found),
        {
            "stage": 1,
            "frequencies_hz": modes.frequencies,
            "families": list(modes.families),
            "multiplicities": list(modes.multiplicities),
            "coordinates": [str(c) for c in modes.coordinates],
            "shapes_per_sqrt_kg": np.asarray(modes.shapes).T,
            "kinetic_energy_shares": dict(modes.kinetic_energy_shares()),
            "strain_energy_shares": dict(modes.strain_energy_shares()),
            "against": {
                "parameter": "contact_angle",
                "unit": "rad",
                "values": np.linspace(0.6, 1.0, 21),
                "valid": np.ones(21, bool),
                "frequencies_hz": {f: loci.frequencies[f] for f in families},
                "multiplicities": {"torsional": 1, "transverse": 2},
                "veerings": [veering],
            },
        },
    )
    rows = [
        (modes.families[at], (modes.frequencies[at], "Hz"), (modes.multiplicities[at], ""))
        for at in modes.distinct
    ]
    printed.table(("family", "f Hz", "times"), rows)
    ends = [
        (f, (curve[0], "Hz"), (curve[-1], "Hz"))
        for f in families
        for curve in np.asarray(loci.frequencies[f]).T
    ]
    columns = printed.row("family")
    assert columns == ["f Hz at 40 deg", "f Hz at 50 deg"]
    for family, *pair in ends:
        for cell, (value, _) in zip(printed.row(family), pair, strict=True):
            assert float(cell) == pytest.approx(float(value), rel=5e-6)
    assert set(families) <= set(FAMILIES)
    printed.row("Natural frequencies: wu2022, stage 1")
    printed.finish()


def _light(hertz):
    return 1e-6 / (1 - (hertz / 2000) ** 2 + 0.1j)


@reads("verb", "response")
def test_response(run, monkeypatch, modes):
    def respond(_, source, target, hertz, *, kind, **__):
        value = jnp.asarray(_light(np.asarray(hertz)))
        return FrequencyResponse(hertz, value, jnp.zeros(len(hertz), bool), source, target, kind)

    monkeypatch.setattr(_vibrate, "_modes", lambda *_, **__: modes)
    monkeypatch.setattr(_vibrate, "_frequency_response", respond)
    words = ("--fmin", 300, "--fmax", 3000, "--points", 7, "--ratio", "0.02", "--kind", "mobility")
    found, printed = run("response", "wu2022", "--from", "nut x", "--to", "screw x", *words)
    hertz = np.geomspace(300, 3000, 7)
    value = _light(hertz)
    assert_json(
        without_words(found),
        {
            "stage": 1,
            "from": "nut x",
            "to": "screw x",
            "kind": "mobility",
            "unit": "m/(N·s)",
            "damping": "modal",
            "frequency_hz": hertz,
            "real": value.real,
            "imaginary": value.imag,
            "magnitude_db": 20 * np.log10(np.abs(value)),
            "phase_rad": np.angle(value),
            "at_pole": np.zeros(7, bool),
            "natural_frequencies_hz": modes.frequencies,
            "families": list(modes.families),
            "multiplicities": list(modes.multiplicities),
        },
    )
    head = printed.row("family")
    assert head == ["f Hz", "times", "|H| dB re 1 m/(N·s)", "phase deg"]
    for at in modes.distinct:
        frequency = float(modes.frequencies[at])
        here = _light(frequency)
        cells = [float(cell) for cell in printed.row(modes.families[at])]
        expected = [frequency, modes.multiplicities[at], 20 * np.log10(abs(here))]
        expected.append(np.degrees(np.angle(here)))
        assert cells == pytest.approx(expected, rel=5e-6)
    printed.row("Mobility of screw x per force at nut x: wu2022, stage 1")
    printed.finish()


@reads("verb", "campbell")
def test_campbell(run, monkeypatch):
    diagram = prsm_jax.campbell(scenes.example("wu2022"), carrier_ratio=0.375)
    monkeypatch.setattr(_vibrate, "_campbell", lambda *_, **__: diagram)
    found, printed = run("campbell", "wu2022", "--max-rpm", 3000)
    speed = float(to_si(3000, "rpm"))
    crossings = [c for c in diagram.crossings() if c.speed <= speed]
    for one in crossings:
        order = next(o for o in diagram.orders if o.name == one.order)
        # h · order · Ω/2π meets f.
        meets = one.harmonic * abs(float(order.order)) * one.speed / (2 * np.pi)
        assert meets == pytest.approx(one.frequency, rel=1e-12)
    assert_json(
        without_words(found),
        {
            "stage": 1,
            "carrier_ratio": 0.375,
            "max_speed_rpm": 3000.0,
            "orders": [
                {
                    "name": o.name,
                    "order": o.order,
                    "lobes": o.lobes,
                    "description": o.description,
                }
                for o in diagram.orders
            ],
            "frequencies_hz": diagram.modes.frequencies,
            "families": list(diagram.modes.families),
            "multiplicities": list(diagram.modes.multiplicities),
            "crossings": [
                {
                    "speed_rpm": c.speed / float(to_si(1.0, "rpm")),
                    "speed_rad_per_s": c.speed,
                    "order": c.order,
                    "harmonic": c.harmonic,
                    "frequency_hz": c.frequency,
                    "family": c.family,
                    "multiplicity": c.multiplicity,
                    "excited": c.excited,
                }
                for c in crossings
            ],
        },
    )
    head = printed.row("rpm")
    assert head == ["order", "harmonic", "f Hz", "family", "times", "excited"]
    for c in (c for c in crossings if c.excited):
        cells = printed.lines.pop(1)
        assert float(to_si(float(cells[0]), "rpm")) == pytest.approx(c.speed, rel=5e-6)
        assert cells[1:3] == [c.order, str(c.harmonic)]
        assert float(cells[3]) == pytest.approx(c.frequency, rel=5e-6)
        assert cells[4:] == [c.family, str(c.multiplicity), "yes"]
    assert printed.lines[0] == ["Critical speeds up to 3000 rpm: wu2022, stage 1"]
    orders = ", ".join(f"{o.name} {float(o.order):.5g}" for o in diagram.orders)
    assert printed.lines[1:] == [[f"carrier ratio 0.375; orders per turn of the screw: {orders}"]]
    _, printed = run("campbell", "wu2022", "--max-rpm", 1)
    (lowest, *_) = [one for one in diagram.crossings() if one.excited]
    (said,) = [cells[0] for cells in printed.lines if cells[0].startswith("The lowest is")]
    value, rest = said.removeprefix("The lowest is ").split(" rpm, where harmonic ")
    assert float(to_si(float(value), "rpm")) == pytest.approx(lowest.speed, rel=5e-6)
    harmonic, order, _, frequency, unit, family = rest.replace(" of", "").split()
    assert (int(harmonic), order, family) == (lowest.harmonic, lowest.order, f"({lowest.family}).")
    assert unit == "Hz"
    assert float(frequency) == pytest.approx(lowest.frequency, rel=5e-6)


def _table():
    return Sensitivity(
        values=jnp.asarray([0.8512, 2.13e9, 0.0]),
        gradient=jnp.asarray([[3.1, 0.12], [-4e10, 1.3e9], [2.3, -0.4]]),
        elasticity=jnp.asarray([[0.021, -0.013], [0.11, -0.62], [0.0, 0.0]]),
        elasticity_defined=jnp.asarray([True, True, False]),
        parameter_values=(jnp.asarray([0.01]), jnp.asarray([0.785])),
        valid=jnp.asarray(True),
        quantities=("efficiency", "max_pressure", "mass"),
        parameters=("lead", "contact_angle"),
        quantity_units=("1", "Pa", "kg"),
        parameter_units=("m", "rad"),
        dependents=((("pitch",), ("starts", "nut_radius")), ((), ("lead",))),
    )


@reads("verb", "sensitivity")
def test_sensitivity(run, monkeypatch):
    table = _table()
    asked = {}
    monkeypatch.setattr(
        "prsm_jax.sensitivities.sensitivity", lambda *_, **more: asked.update(more) or table
    )
    found, printed = run("sensitivity", "wu2022")
    found = without_words(found)
    expected = {
        "quantities": list(table.quantities),
        "parameters": list(table.parameters),
        "quantity_units": list(table.quantity_units),
        "parameter_units": list(table.parameter_units),
        "values": table.values,
        "gradient": table.gradient,
        "elasticity": [[0.021, -0.013], [0.11, -0.62], None],
        "parameter_values": [[0.01], [0.785]],
        "kinks": [],
        "follows": {"lead": ["pitch"], "contact_angle": []},
        "stays": {"lead": ["starts", "nut_radius"], "contact_angle": ["lead"]},
    }
    assert found["elasticity"][2] == [None, None]
    expected["elasticity"][2] = found["elasticity"][2]
    expected = {k: v for k, v in expected.items() if k != "elasticity"}
    np.testing.assert_allclose(found["elasticity"][:2], table.elasticity[:2])
    found.pop("elasticity")
    assert_json(found, expected)
    _read_sensitivity(printed, table)
    # What follows when a parameter moves, and what stays.
    for words in (
        "lead: moves with it: pitch; stays: starts, nut radius",
        "contact_angle: moves with it: nothing; stays: lead",
    ):
        assert printed.row(words) == []
    printed.finish()


def _read_sensitivity(printed: Terminal, table: Sensitivity) -> None:
    head = printed.row("quantity")
    assert head[0] == "value"
    steps = [column.removeprefix("per ").split(" of ") for column in head[1:]]
    assert [name for _, name in steps] == list(table.parameters)
    assert [float(to_si(1, label)) for label, _ in steps] == pytest.approx([1e-3, np.pi / 180])
    for row, name in enumerate(table.quantities):
        cells = next(c for c in printed.lines if c[0].split(" [")[0] == name)
        printed.lines.remove(cells)
        label = column_unit(cells[0])
        per = float(to_si(1.0, label))
        shown = [float(cell) * per for cell in cells[1:]]
        slopes = [
            float(g) * float(to_si(1.0, unit))
            for g, (unit, _) in zip(table.gradient[row], steps, strict=True)
        ]
        assert shown == pytest.approx([float(table.values[row]), *slopes], rel=5e-6)
    assert printed.row("elasticity (% per %)") == list(table.parameters)
    for row, name in enumerate(table.quantities):
        cells = printed.row(name)
        if row == 2:
            assert cells == ["–", "–"]
        else:
            found = [float(cell) for cell in cells]
            assert found == pytest.approx(table.elasticity[row].tolist(), abs=5.1e-5)


#: Of each quantity by each pair of parameters [SI], no two of the numbers above alike.
_SECOND = (
    ((12.5, -3.25), (-3.25, 0.75)),
    ((7.5e12, -4.5e10), (-4.5e10, 2.25e9)),
    ((-150.0, 45.0), (45.0, 8.5)),
)


@reads("verb", "sensitivity")
def test_second_derivatives(run, monkeypatch):
    """A row for each pair, per the steps of the first table, millimetres and degrees."""
    table = dataclasses.replace(_table(), hessian=jnp.asarray(_SECOND))
    asked = []

    def sensitivity(*_, second, **__):
        asked.append(second)
        return table

    monkeypatch.setattr("prsm_jax.sensitivities.sensitivity", sensitivity)
    found, printed = run("sensitivity", "wu2022", "--second")
    assert asked == [True, True]
    # Rows are quantities; then both parameters, in the order of the table.
    assert_json(found["hessian"], _SECOND)
    _read_sensitivity(printed, table)
    assert printed.row("second derivative") == ["by", "and by", "value"]
    steps = {"mm": 1e-3, "deg": np.pi / 180}
    units = dict(zip(table.parameters, steps, strict=True))
    for quantity, rows in zip(table.quantities, _SECOND, strict=True):
        for first, second in ((0, 0), (0, 1), (1, 1)):
            head, *cells = printed.lines.pop(0)
            name, _, label = head.partition(" per ")
            by = [table.parameters[first], table.parameters[second]]
            assert name.split(" [")[0] == quantity
            assert label.split(" ") == [units[one] for one in by]
            assert cells[:2] == by
            per = float(to_si(1.0, column_unit(name)))
            slope = float(cells[2]) * per
            expected = rows[first][second] * steps[units[by[0]]] * steps[units[by[1]]]
            # Six digits are printed.
            assert slope == pytest.approx(expected, rel=5e-6)
    for parameter in table.parameters:
        (words,) = [line for line in printed.lines if line[0].startswith(f"{parameter}: moves")]
        printed.lines.remove(words)
    printed.finish()


def make_optimum(mechanism):
    """An optimum of which no two numbers are alike."""
    problem = DesignProblem(
        (Variable("lead", 0.005, 0.02), Variable("contact_angle", 0.5, 1.0)),
        (Objective("efficiency", "maximise"),),
        (Constraint("max_pressure", upper=3.1e9), Constraint("mass", lower=1.11, upper=2.22)),
    )

    def design(lead, angle, objective, pressure, mass, violation):
        return Design(
            {"lead": lead, "contact_angle": angle},
            objective,
            {"max_pressure": pressure, "mass": mass},
            True,
            violation,
        )

    start = design(0.0102, 0.785, 0.8512, 2.13e9, 1.51, 0.0)
    end = design(0.0121, 1.0, 0.8791, 3.1e9, 1.32, 1e-12)
    constraints = (
        ConstraintReport(
            "max_pressure", "Pa", 3.1e9, None, 3.1e9, None, 3.1e9, True, True, 1.3e-12
        ),
        ConstraintReport("mass", "kg", 1.32, 1.11, 2.22, None, 1.11, False, True, 0.0),
    )
    search = Run(start, end, (0.8512, 0.9, 0.8791), (0.0, 0.1, 1e-12), (), (), 1.7e-9, 2, 3, "done")
    other = Run(end, None, (0.6,), (0.7,), (), (), float("inf"), 5, 1, "stuck")
    return Optimum(
        mechanism=mechanism,
        problem=problem,
        method="slsqp",
        start=start,
        optimum=end,
        constraints=constraints,
        bounds_active={"contact_angle": "upper"},
        bound_multipliers={"contact_angle": 0.137},
        converged=True,
        kkt_residual=1.7e-9,
        stationarity=1.6e-9,
        message="KKT residual small",
        runs=(other, search),
        best_run=1,
        evaluations=31,
        derivative_evaluations=17,
        variable_units={"lead": "m", "contact_angle": "rad"},
    )


def _design_keys(one):
    return {
        "variables": dict(one.variables),
        "objective": one.objective,
        "constraints": dict(one.constraints),
        "margins": {},
        "usable": True,
        "violation": one.violation,
    }


@reads("verb", "optimise")
def test_optimise(run, monkeypatch, tmp_path):
    best = make_optimum(scenes.example("wu2022"))
    monkeypatch.setattr("prsm_jax.optimisation.optimise", lambda *_, **__: best)
    found, printed = run("optimise", "wu2022", "--out", tmp_path / "new")
    found = without_words(found)
    path = found.pop("mechanism")
    assert float(prsm_jax.load(path).stages[0].thread.lead) > 0
    # Keys of new parts are read by the tests of those parts.
    runs = [
        {
            "start": _design_keys(one.start),
            "end": None if one.end is None else _design_keys(one.end),
            "objective_history": list(one.objective_history),
            "violation_history": list(one.violation_history),
            "kkt_residual": None if np.isinf(one.kkt_residual) else one.kkt_residual,
            "failures": one.failures,
            "iterations": one.iterations,
            "message": one.message,
        }
        for one in best.runs
    ]
    constraints = [
        {
            "quantity": "max_pressure",
            "unit": "Pa",
            "value": 3.1e9,
            "limit": 3.1e9,
            "lower": None,
            "upper": 3.1e9,
            "equal": None,
            "multiplier": 1.3e-12,
            "active": True,
            "satisfied": True,
        },
        {
            "quantity": "mass",
            "unit": "kg",
            "value": 1.32,
            "limit": 1.11,
            "lower": 1.11,
            "upper": 2.22,
            "equal": None,
            "multiplier": 0.0,
            "active": False,
            "satisfied": True,
        },
    ]
    assert_json(
        found,
        {
            "start": _design_keys(best.start),
            "optimum": _design_keys(best.optimum),
            "objective": [{"quantity": "efficiency", "sense": "maximise", "weight": 1.0}],
            "objective_history": [0.8512, 0.9, 0.8791],
            "constraints": constraints,
            "bounds_active": {"contact_angle": "upper"},
            "bound_multipliers": {"contact_angle": 0.137},
            "feasible": True,
            "margins": [],
            "findings_start": [],
            "findings_optimum": [],
            "converged": True,
            "kkt_residual": 1.7e-9,
            "stationarity": 1.6e-9,
            "method": "slsqp",
            "message": "KKT residual small",
            "evaluations": 31,
            "derivative_evaluations": 17,
            "best_run": 1,
            "runs": runs,
            "variable_units": {"lead": "m", "contact_angle": "rad"},
        },
    )
    _read_optimum(printed)
    # Each variable says what follows and what stays.
    (follows,) = (cells[0] for cells in printed.lines if cells[0].startswith("lead: "))
    assert follows.startswith("lead: moves with it: pitch; stays: starts, roller radius, ")
    (follows,) = (cells[0] for cells in printed.lines if cells[0].startswith("contact_angle: "))
    assert "flank angle" in follows.partition("; stays: ")[0]


def test_variables_beside_each_other_are_not_said_to_follow():
    """The profile radius follows the contact angle, unless the same optimisation varies it."""
    best = make_optimum(scenes.mechanism())
    names = ("contact_angle", "roller_profile_radius")
    problem = dataclasses.replace(
        best.problem, variables=(Variable(names[0], 0.5, 1.0), Variable(names[1], 3e-3, 9e-3))
    )
    values = {names[0]: 0.785, names[1]: 5e-3}
    best = dataclasses.replace(
        best,
        problem=problem,
        start=dataclasses.replace(best.start, variables=values),
        optimum=dataclasses.replace(best.optimum, variables=values),
        variable_units={names[0]: "rad", names[1]: "m"},
        bounds_active={},
    )
    (line,) = (one for one in str(best).splitlines() if one.startswith("contact_angle: "))
    follows, _, stays = line.partition("; stays: ")
    assert "flank angle" in follows
    assert "roller profile radius" in stays
    assert "roller profile radius" not in follows
    angle, profile = summarise_optimisation(best).variables
    assert "flank_angle" in angle.follows
    assert "roller_profile_radius" in angle.stays
    assert "roller_profile_radius" not in angle.follows
    assert "contact_angle" in profile.stays


def test_the_limits_that_the_start_breaks_are_named():
    """With value and limit, in an engineer's units; a limit that is reached is not broken."""
    best = make_optimum(scenes.mechanism())

    def lines(pressure, mass):
        constraints = {"max_pressure": pressure, "mass": mass}
        start = dataclasses.replace(best.start, constraints=constraints)
        text = str(dataclasses.replace(best, start=start))
        return [line for line in text.splitlines() if "start breaks" in line]

    said = "limits of the optimisation that the start breaks: "
    assert lines(3.1e9, 1.11) == lines(3.1e9 * (1 + 1e-8), 2.22) == []
    assert lines(3.3e9, 1.5) == [said + "max_pressure = 3300 against a limit of 3100 MPa"]
    assert lines(3.0e9, 1.0) == [said + "mass = 1 against a limit of 1.11 kg"]
    assert lines(3.2e9, 2.5) == [
        said + "max_pressure = 3200 against a limit of 3100 MPa; mass = 2.5 against a limit of "
        "2.22 kg"
    ]


def test_the_terminal_tells_the_state_of_a_locked_thread(run, monkeypatch):
    """A jammed start has no efficiency in the table of the optimisation, nor in sensitivities."""
    import dataclasses

    best = make_optimum(scenes.example("wu2022"))
    start = dataclasses.replace(best.start, objective=-0.34)
    monkeypatch.setattr(
        "prsm_jax.optimisation.optimise", lambda *_, **__: dataclasses.replace(best, start=start)
    )
    _, printed = run("optimise", "wu2022")
    (cells,) = (cells for cells in printed.lines if cells[0].startswith("maximise efficiency"))
    assert cells[1:3] == ["none", "87.91"]
    table = dataclasses.replace(_table(), values=jnp.asarray([-0.34, 2.13e9, 0.0]))
    asked = {}
    monkeypatch.setattr(
        "prsm_jax.sensitivities.sensitivity", lambda *_, **more: asked.update(more) or table
    )
    _, printed = run("sensitivity", "wu2022")
    assert printed.row("efficiency [%]") == ["none", "–", "–"]
    assert printed.row("efficiency") == ["–", "–"]


def _read_optimum(printed: Terminal) -> None:
    def row(start):
        cells = next(c for c in printed.lines if c[0].startswith(start))
        printed.lines.remove(cells)
        return float(to_si(1.0, column_unit(cells[0]))), cells[1:]

    per, cells = row("maximise efficiency")
    assert [per * float(c) for c in cells] == pytest.approx([0.8512, 0.8791], rel=5e-6)
    for start, values, limits, state in (
        ("lead", (0.0102, 0.0121), (0.005, 0.02), ""),
        ("contact_angle", (0.785, 1.0), (0.5, 1.0), "at upper bound"),
        ("max_pressure", (2.13e9, 3.1e9), (3.1e9,), "active"),
        ("mass", (1.51, 1.32), (1.11, 2.22), ""),
    ):
        per, cells = row(start)
        assert [per * float(c) for c in cells[:2]] == pytest.approx(values, rel=5e-6)
        words = cells[2].replace("≤", "<=").replace("≥", ">=")
        shown = [float(w) for w in words.split() if w[0].isdigit()]
        assert [per * v for v in shown] == pytest.approx(limits, rel=5e-6)
        if start == "max_pressure":
            assert words.startswith("<=")
        if start == "mass":
            assert words.index(">=") < words.index("<=")
        assert cells[3:] == ([state] if state else [])


@reads("verb", "sweep")
def test_sweep(run, monkeypatch, tmp_path):
    import xarray

    given = []

    def sweep(_, axes, quantities, **more):
        given.append((axes, quantities, more["store"]))
        # Three rollers too many, and one design that does not mesh.
        codes = np.array([2] * 3 + [3] + [0] * 17, np.int8)
        # Overlapping rollers are an error of check too; five others interfere or are overloaded.
        errors = np.array([2] * 3 + [0] + [4] * 2 + [3] * 3 + [0] * 12, np.int8)
        meanings = {
            "code": (codes, "successful impossible_dimension overlapping_rollers no_meshing"),
            "error": (errors, "none dimension roller_clearance backlash static_safety"),
        }
        variables: dict[str, Any] = {
            name: ("design", values, {"flag_meanings": words})
            for name, (values, words) in meanings.items()
        }
        variables["failed"] = ("design", codes != 0)
        return xarray.Dataset(variables, attrs={"points": 21, "failed": 4})

    monkeypatch.setattr(_sweep, "run_sweep", sweep)
    axis = ("--axis", "lead=5 mm:15 mm:3", "--axis", "contact_angle=30 deg,45 deg")
    found, printed = run("sweep", "wu2022", *axis, "--quantities", "efficiency, mass")
    store = found.pop("store")
    reasons = {"overlapping_rollers": 3, "no_meshing": 1}
    errors = {"backlash": 3, "static_safety": 2}
    wanted = {"points": 21, "failed": 4, "reasons": reasons, "errors": errors}
    wanted |= {"missing": 0, "exports": [], "constraints": []}
    assert_json(without_words(found), wanted)
    axes, quantities, place = given[0]
    assert quantities == ["efficiency", "mass"]
    assert str(place) == store
    np.testing.assert_allclose(axes["lead"], to_si([5, 10, 15], "mm"))
    np.testing.assert_allclose(axes["contact_angle"], to_si([30, 45], "deg"))
    assert " ".join(printed.lines[0]) == (
        "21 designs: 4 failed (overlapping rollers 3, no meshing 1), 5 others with errors of prsm "
        "check (backlash 3, static safety 2)"
    )


@reads("verb", "validate")
def test_validate(run, monkeypatch):
    from prsm_jax import validation
    from prsm_jax.validation import differs, number

    rows = [
        number("Table 1, pressure", "1539", 1539.4, "MPa", note="as printed"),
        differs(
            "Table 1, area",
            "12.5",
            13.75,
            "mm²",
            between=(13.6, 13.9),
            because="another area",
            evidence=12.47,
            evidence_between=(12.4, 12.6),
        ),
    ]
    monkeypatch.setattr(validation, "validate", lambda *_: rows)
    found, printed = run("validate")
    kept = ("item", "published", "computed", "relative_difference", "verdict", "note", "unit")
    expected = [
        ("Table 1, pressure", 1539.0, 1539.4, 1539.4 / 1539 - 1, "reproduced", "as printed", "MPa"),
        ("Table 1, area", 12.5, 13.75, 0.1, "differs because", "another area", "mm²"),
    ]
    for row, values in zip(found["rows"], expected, strict=True):
        assert_json({k: row[k] for k in kept}, dict(zip(kept, values, strict=True)))
        assert row["source"] == ""
    assert [row["bounds"] for row in found["rows"]] == [None, [13.6, 13.9]]
    assert [row["evidence"] for row in found["rows"]] == [None, 12.47]
    assert [row["evidence_bounds"] for row in found["rows"]] == [None, [12.4, 12.6]]
    assert [row["tolerance"] for row in found["rows"]] == [pytest.approx(0.5), None]
    assert [row["own"] for row in found["rows"]] == [None, None]
    cells = [" ".join(line) for line in printed.lines]
    for item, published, computed, difference, verdict, _, unit in expected:
        line = next(line for line in cells if item in line)
        for value in (published, computed):
            assert f"{value:g}" in line
        assert verdict in line
        if unit == "mm²":
            below = cells[cells.index(line) + 1]
            assert "within 13.6 to 13.9 mm²; evidence 12.47, within 12.4 to 12.6" in below
        assert f"{100 * difference:.2g}"[:3] in line or f"{difference:.1e}"[:3] in line


@reads("verb", "demo")
@pytest.mark.parametrize("feasible", [True, False])
def test_demo(monkeypatch, tmp_path, capsys, feasible):
    """What results.json holds, and what goes into the report; no file of what breaks limits."""
    import dataclasses
    import json

    from prsm_jax import cli, report
    from prsm_jax.cli.verbs import _contact, _demo
    from prsm_jax.report import ReportData

    mechanism = scenes.example("actuator")
    best, table, written = make_optimum(mechanism), _table(), {}
    best = dataclasses.replace(best, feasible=feasible, converged=feasible)

    def design():
        return ReportData(
            mechanism=mechanism,
            title="one",
            meshings=(made.meshing(),),
            contacts=(made.contact_pair(),),
            modes=(made.modes(),),
            steady=made.steady(),
            transient=made.transient(1),
        )

    before, after = design(), design()

    def analyse(_, **more):
        written.update(more)
        return before

    def with_optimisation(data, sensitivity, optimisation, improved):
        assert data is before
        written.update(sensitivity=sensitivity, optimisation=optimisation, improved=improved)
        return dataclasses.replace(before, improved=after)

    def write(folder, data, *, attachments, on_fault):
        written.update(data=data, files=attachments)
        return folder / "report.html"

    peaks = lambda major, minor, pressure, ratio, measure: _Peak(pressure, minor, measure)  # noqa: E731
    monkeypatch.setattr(_contact, "stress_peak_on_axis", peaks)
    # The invented places lie on no flank that could end.
    monkeypatch.setattr(_contact, "side_onsets", lambda *_: None)
    monkeypatch.setattr(_demo, "_contact_results", _contact.contact_results)
    monkeypatch.setattr("prsm_jax.optimisation.optimise", lambda *_, **__: best)
    asked = {}
    monkeypatch.setattr(
        "prsm_jax.sensitivities.sensitivity", lambda *_, **more: asked.update(more) or table
    )
    monkeypatch.setattr(report, "analyse", analyse)
    monkeypatch.setattr(report, "with_optimisation", with_optimisation)
    monkeypatch.setattr(report, "write_report", write)
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / "optimised.toml").write_text("old", encoding="utf-8")
    assert cli.main(["demo", "--out", str(tmp_path / "new")]) == int(not feasible)
    assert set(asked["quantities"]) > {"dynamic_capacity", "rating_life_time", "buckling_safety"}
    assert ("optimised.toml" in written["files"]) == feasible
    found = without_words(json.loads(written["files"]["results.json"]))
    assert found.pop("status") == {"start": "pass", "optimum": "pass"}
    assert set(found.pop("checks")) == {"start", "optimum"}
    assert set(found.pop("limits")) == {"start", "optimum"}
    assert found.pop("sha256") == written["origin"].sha256
    assert set(found) == {"before", "after", "sensitivity", "optimise"}
    for name, one in (("before", before), ("after", after)):
        assert set(found[name]) == {"contact", "modal", "steady", "simulate"}
        (stage,) = found[name]["contact"]["stages"]
        for side in ("screw", "nut"):
            hertz = getattr(one.contacts[0], side).hertz
            assert stage[side]["max_pressure_pa"] == pytest.approx(float(hertz.max_pressure))
            assert stage[side]["approach_m"] == pytest.approx(float(hertz.approach))
        assert_json(found[name]["modal"]["frequencies_hz"], one.modes[0].frequencies)
        assert found[name]["steady"]["efficiency"] == pytest.approx(float(one.steady.efficiency))
        point = mechanism.operating_point
        assert found[name]["steady"]["speed_rad_per_s"] == pytest.approx(float(point.speed))
        assert_json(found[name]["simulate"]["drive_torque_nm"], one.transient.drive_torque)
    assert found["sensitivity"]["gradient"] == table.gradient.tolist()
    assert found["optimise"]["optimum"]["objective"] == 0.8791
    assert written["optimisation"].feasible == feasible
    assert written["sensitivity"] is table
    assert written["optimisation"].quantities[0].after == pytest.approx(0.8791)
    first, second = capsys.readouterr().out.split("] optimising")
    assert (f"  {tmp_path / 'new' / 'optimised.toml'}" in second.splitlines()) == feasible
    earlier = f"{tmp_path / 'new' / 'optimised.toml'} is of an earlier run"
    assert (earlier in second.splitlines()) == (not feasible)
    if not feasible:
        # The first line of the optimisation, and the head of its column.
        lines = second.splitlines()
        assert lines[1].startswith("NO FEASIBLE DESIGN: ")
        assert "best found" in second
        assert "optimum" not in second.partition("done; look at")[0]
    _read_sensitivity(Terminal(first), table)
    _read_optimum(Terminal(second))


class _Peak:
    def __init__(self, pressure, minor, measure):
        self.value = (0.6 if measure == "von_mises" else 0.3) * pressure
        self.depth = minor / 2
