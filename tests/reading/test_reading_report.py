"""Every table and sentence of a report against SI numbers, converted by `pint`."""

import dataclasses
import math
import re
from types import SimpleNamespace
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
import reading_scenes as made
import scenes
from expectations import reads
from reading_tables import assert_cell, assert_table, html_tables
from reading_units import assert_reads, numbers, to_si
from scipy.integrate import simpson

import prsm_jax as prsm
from prsm_jax.dynamics import STEADY_RESULTS
from prsm_jax.findings import StrengthCheck
from prsm_jax.geometry import Finding, roller_clearance
from prsm_jax.mechanism import body_mass, stage_mass
from prsm_jax.quantities import find_quantity
from prsm_jax.report import Change, Limit, Optimisation, ReportData, write_report
from prsm_jax.report.document import (
    _analysis_sections,
    _design_sections,
    _mechanism_section,
    _strength_section,
)
from prsm_jax.report.document._analysis_sections import steady_section, transient_section
from prsm_jax.report.document._sections import report_sections
from prsm_jax.report.motion_charts import histories
from prsm_jax.report.results import STRENGTH
from prsm_jax.text._plain_text import markdown as escaped
from tests.present import present

_MINUS = "\N{MINUS SIGN}"


@pytest.fixture(scope="module")
def actuator():
    return scenes.example("actuator")


def _optimisation():
    return Optimisation(
        objective="efficiency",
        objective_unit="1",
        history=(0.8512, 0.8834, 0.8791),
        variables=(
            Change("lead", "m", 0.0102, 0.0121, 0.005, 0.02, "", ("pitch",), ("nut_radius",)),
            Change("contact_angle", "rad", 0.785, 0.913, 0.5, 0.913, "upper"),
        ),
        quantities=(
            Change("efficiency", "1", 0.8512, 0.8791),
            Change("max_pressure", "Pa", 2.13e9, 2.97e9),
        ),
        limits=(
            Limit("max_pressure", "Pa", 2.97e9, 2.97e9, True, "upper", 1.3e-12),
            Limit("mass", "kg", 1.51, 1.32, False, "lower"),
        ),
        converged=True,
        kkt_residual=1.3e-9,
        message="KKT residual small",
        violations=(0.0, 0.1, 0.0),
    )


def _strength():
    sizes = {"m": 2e-5, "N": 7e4, "Pa": 1e9, "N/m": 4e8, "rad/s": 310.0, "s": 7e6, "N·m": 0.3}
    found = {}
    for name in STRENGTH:
        quantity = find_quantity(name)
        scale = sizes.get(quantity.unit, 2.0)
        found[name] = made.odds(1, scale=scale) if quantity.dimensions else made.odd(scale)
    return found


def _sensitivity():
    return SimpleNamespace(
        quantities=("efficiency", "max_pressure", "mass"),
        parameters=("lead", "contact_angle", "starts"),
        quantity_units=("1", "Pa", "kg"),
        parameter_units=("m", "rad", "1"),
        parameter_values=tuple(np.array([v]) for v in (0.01, 0.785, 5.0)),
        values=np.array([0.8512, 2.13e9, 0.0]),
        gradient=np.array([[3.1, 0.12, 0.013], [-4e10, 1.3e9, 1.1e8], [2.3, -0.4, 0.21]]),
        elasticity=np.array([[0.021, -0.013, 4e-4], [0.11, -0.62, -1.23], [0, 0, 0]]),
        elasticity_defined=np.array([True, True, False]),
        valid=np.array(True),
    )


@pytest.fixture(scope="module")
def data(actuator):
    own = {
        "meshings": (made.meshing(),),
        "contacts": (made.contact_pair(),),
        "modes": (made.modes(),),
        "steady": made.steady(),
        "forward": made.steady(4010.0),
        "backward": made.steady(2010.0),
        "strength": _strength(),
    }
    improved = ReportData(
        mechanism=actuator,
        title="after the optimisation",
        contacts=(made.contact_pair(),),
        modes=(made.modes(1.1),),
        steady=made.steady(3555.0),
        strength=_strength(),
        findings=(Finding("jamming", "error", 1, 0.3, 0.2, "cannot move"),),
    )
    findings = (
        Finding("buckling", "warning", 1, 1.2, 2.0, "too long"),
        Finding("mass", "error", 1, 1.0, 2.0, "too heavy"),
        Finding("ratio", "note", 1, 1.0, 2.0, "as it is"),
    )
    return ReportData(
        mechanism=actuator,
        title="A title",
        findings=findings,
        transient=made.transient(1),
        shared={0: made.distribution()},
        deflections={0: made.curve()},
        sensitivity=_sensitivity(),
        optimisation=_optimisation(),
        improved=improved,
        left_out=(("vibration", "no masses"),),
        source="my.toml",
        command="prsm demo",
        **own,
    )


@pytest.fixture(scope="module")
def sections(data):
    return {section.anchor: section for section in report_sections(data)}


def _paragraph(section, start):
    return next(words for words in section.paragraphs if words.startswith(start))


@reads("section", "_summary")
def test_summary(sections, data):
    section, point = sections["summary"], data.mechanism.operating_point
    steady = data.steady
    assert_reads(
        _paragraph(section, "At "),
        (point.speed, "rad/s"),
        (point.load, "N"),
        (steady.efficiency, "1"),
        (steady.drive_torque, "N·m"),
    )
    assert "and the torque at the screw " in _paragraph(section, "At ")
    (pair,) = data.contacts
    worst = max(float(side.hertz.max_pressure) for side in (pair.screw, pair.nut))
    # Of the most loaded thread, and of equal shares.
    pressures = (point.load, "N"), (data.shared[0].max_pressure, "Pa"), (worst, "Pa")
    assert_reads(_paragraph(section, "The largest contact pressure at the load of"), *pressures)
    start = _paragraph(section, "The checks of the start found")
    assert_reads(start, (1, "", "whole"), (1, "", "whole"))
    # Errors first.
    assert start.endswith("found 1 error and 1 warning: mass (error), buckling.")
    optimum = _paragraph(section, "The checks of the optimum found")
    assert optimum == "The checks of the optimum found 1 error: jamming (error)."
    words = _paragraph(section, "Efficiency rises from")
    assert_reads(
        words,
        *((0.8512, "1"), (0.8791, "1"), (2.97e9, "Pa"), (0.913, "rad")),
    )


@reads("section", "mechanism_section")
def test_mechanism(sections, actuator):
    table, operating = sections["mechanism"].tables
    (stage,) = actuator.stages
    thread = stage.thread
    n, roller = float(thread.starts), float(thread.roller_radius)
    lead = float(thread.lead)
    # One thread on rollers that neither gain nor lose on the nut: radii by the starts.
    screw, nut, centre = (n - 2) * roller, n * roller, (n - 1) * roller

    def length(value):
        return ("mm", value)

    rows = {
        "rollers": str(stage.roller_count),
        "thread starts of screw and nut": "5",
        "lead": length(lead),
        "pitch": length(lead / n),
        "screw diameter": length(2 * screw),
        "roller diameter": length(2 * roller),
        "nut thread diameter": length(2 * nut),
        "nut outer diameter": length(2 * (nut + float(stage.nut.wall_thickness))),
        "centre distance": length(centre),
        "contact angle (from the transverse plane)": ("°", thread.contact_angle),
        "flank angle": ("°", thread.flank_angle),
        "roller profile radius": length(thread.profile_radius),
        "helix angle of the screw": ("°", math.atan(lead / (2 * math.pi * screw))),
        "clearance between rollers": length(roller_clearance(stage)),
        "length of the screw": length(stage.screw.length),
        "length of the roller": length(stage.roller.length),
        "length of the nut": length(stage.nut.length),
        "loaded threads of a roller, each side": ("", stage.engaged_threads),
        "curvatures of the contact": stage.curvature,
    }
    found = dict(table.rows)
    modulus, ratio = found.pop("Young's modulus"), found.pop("Poisson's ratio")
    assert_reads(modulus, (stage.material.youngs_modulus, "Pa", "whole"))
    assert_reads(ratio, (stage.material.poisson_ratio, "", "whole"))
    assert_reads(found.pop("mass of a roller"), (body_mass(stage, "roller"), "kg"))
    assert_reads(found.pop("mass of the stage"), (stage_mass(stage), "kg"))
    assert set(found) == set(rows)
    for name, expected in rows.items():
        if isinstance(expected, str):
            assert found[name] == expected
            continue
        unit, value = expected
        (shown,) = numbers(found[name])
        assert shown.label == unit, name
        # Zeros at the end are left out: thousandths of a millimetre, hundredths of a degree.
        step = float(to_si(0.5e-2 if unit == "°" else 0.5e-3, unit))
        assert float(to_si(shown.value, unit)) == pytest.approx(float(value), abs=1.001 * step)
    assert_table(
        operating,
        ("", ""),
        [
            ("screw speed", (actuator.operating_point.speed, "rad/s")),
            ("axial load", (actuator.operating_point.load, "N")),
            ("simulated time", (actuator.operating_point.duration, "s")),
        ],
    )


@reads("section", "findings_section")
def test_findings(sections, data):
    tables = sections["findings"].tables
    assert [table.caption for table in tables] == ["Findings: start", "Findings: optimum"]
    for table, one in zip(tables, (data, data.improved), strict=True):
        rows = [(f.severity, f.name.replace("_", " "), f.message) for f in one.findings]
        assert_table(table, ("severity", "check", "message"), rows)


def test_findings_come_before_drawings_and_other_tables(data):
    sections = report_sections(data)
    assert [section.anchor for section in sections[:3]] == ["status", "summary", "findings"]
    assert not [*sections[1].tables, *(one for s in sections[:3] for one in s.pictures)]


def test_a_design_without_findings_says_so_beside_the_other(data):
    clean = dataclasses.replace(data, improved=dataclasses.replace(data.improved, findings=()))
    section = next(s for s in report_sections(clean) if s.anchor == "findings")
    assert [table.caption for table in section.tables] == ["Findings: start"]
    (words,) = section.paragraphs
    assert words.startswith("Optimum: the checks")
    assert words.endswith("found no errors, warnings or notes.")


def test_an_infeasible_optimisation_says_so_first(data):
    """No word of an optimum: the column is that of the best design found."""
    message = "no feasible design found; the design of least violation has backlash = -8 µm"
    failed = dataclasses.replace(
        data.optimisation, feasible=False, converged=False, message=message
    )
    sections = report_sections(dataclasses.replace(data, optimisation=failed))
    found = {section.anchor: section for section in sections}
    first = "No feasible design: the design of least violation has backlash = -8 µm."
    assert sections[0].paragraphs[0] == first
    assert found["optimisation"].paragraphs[0] == first
    variables, quantities, limits = found["optimisation"].tables
    assert variables.head[1:3] == quantities.head[1:3] == ("before", "best found")
    assert limits.head[1] == "best found"
    assert found["strength"].tables[0].head[-2:] == ("best found", "verdict after")
    assert found["vibration"].tables[0].head[-1] == "best found in Hz"
    assert [t.caption for t in found["findings"].tables] == [
        "Findings: start",
        "Findings: best found",
    ]
    for section in sections:
        said = [*section.paragraphs, *(p.caption for p in section.pictures)]
        said += [table.caption for table in section.tables]
        said += [cell for table in section.tables for cell in table.head]
        assert not [words for words in said if "ptimum" in words and "exact optimum" not in words]


@reads("section", "contact_section")
def test_contacts(sections, data):
    (table,) = sections["contact"].tables
    (pair,), (mesh,) = data.contacts, data.meshings
    units = (
        ("contact radius in mm", "m"),
        ("position in deg", "rad"),
        ("normal force in N", "N"),
        ("semi-axis a in µm", "m"),
        ("semi-axis b in µm", "m"),
        ("p₀ in MPa", "Pa"),
        ("approach in µm", "m"),
        ("stiffness F/δ in N/µm", "N/m"),
        ("dF/dδ in N/µm", "N/m"),
    )
    rows = []
    for side in ("screw", "nut"):
        hertz, place = getattr(pair, side).hertz, getattr(mesh, side)
        values = (
            place.contact_radius,
            place.contact_angle_position,
            getattr(pair, side).normal_force,
            hertz.semi_major,
            hertz.semi_minor,
            hertz.max_pressure,
            hertz.approach,
            hertz.stiffness,
            hertz.stiffness_tangent,
        )
        rows.append((side, *zip(values, (u for _, u in units), strict=True)))
    assert_table(table, ("side", *(name for name, _ in units)), rows)


@reads("section", "sharing_section")
def test_shared_loads(sections, data):
    (table,) = sections["load_sharing"].tables
    shared = data.shared[0]

    def factor(side):
        load = np.asarray(side.forward) + np.asarray(side.reverse)
        return load.max() / load.mean()

    rows = {
        "largest over mean thread load, screw": (factor(shared.screw), ""),
        "largest over mean thread load, nut": (factor(shared.nut), ""),
        "largest over mean roller load": (1.0, ""),
        "largest pressure": (shared.max_pressure, "Pa"),
        "deflection": (shared.elastic.deflection, "m"),
        "force in the spacer": (shared.spacer_force, "N"),
    }
    found = dict(table.rows)
    for name, expected in rows.items():
        assert_cell(found.pop(name), expected)
    # Stiffness by whatever name it has: the tangent of the nut.
    ((name, cell),) = found.items()
    assert "dF/dx" in name or "tangent" in name
    assert_cell(cell, (shared.tangent_stiffness, "N/m"))


@reads("section", "vibration_section")
def test_vibration(sections, data):
    (table,) = sections["vibration"].tables
    (before,), (after,) = data.modes, data.improved.modes
    rows = []
    for family in ("carrier", "torsional", "transverse", "roller"):
        group, other = before.group(family), after.group(family)
        elastic = [k for k, f in enumerate(np.asarray(group.frequencies)) if f > 0]
        for place, k in enumerate(elastic, start=1):
            rows.append(
                (
                    f"{family} {place}",
                    (group.frequencies[k], "Hz"),
                    str(group.multiplicity),
                    (group.mesh_energy_share[k], "1", "whole"),
                    (other.frequencies[k], "Hz"),
                )
            )
    rows.append(("rigid", "0", "1", "0", ""))
    head = ("mode", "frequency in Hz", "multiplicity", "energy in the contacts in %")
    assert_table(table, (*head, "after the optimisation in Hz"), rows)


@reads("section", "steady_section")
def test_steady(sections, data):
    section, state = sections["steady"], data.steady
    table, losses = section.tables
    rows = [
        ("efficiency, screw drives", (data.forward.efficiency, "1")),
        ("efficiency, load drives", (data.backward.efficiency, "1")),
        ("drive torque", (state.drive_torque, "N·m")),
        ("input power", (state.input_power, "W")),
        ("output power", (state.output_power, "W")),
        ("carrier speed over screw speed", (state.carrier_ratio[0], "")),
        ("normal force of screw on one roller", (state.contact_force[0], "N")),
        ("slip of screw on roller", (state.slip_speed[0], "m/s")),
        ("error of the power balance", (state.power_balance_residual, "", "whole")),
    ]
    assert_table(table, ("", ""), rows)
    assert "The load can drive the screw back." in section.paragraphs
    lost = sorted(((n, float(v)) for n, v in state.losses.items()), key=lambda pair: -pair[1])
    lost.append(("total", sum(v for _, v in lost)))
    expected = [
        (name.replace("_", " "), (v, "W"), (v / float(state.input_power), "1", "whole"))
        for name, v in lost
    ]
    assert_table(losses, ("loss", "power in W", "share of the input in %"), expected)


def test_where_the_nut_turns_its_speed_is_named(data):
    leg = scenes.example("humanoid_leg")
    locked = dataclasses.replace(data, mechanism=leg, backward=made.steady(0, True), improved=None)
    section = present(steady_section(locked))
    cells = [row[0] for row in section.tables[0].rows]
    named = {"normal force of nut on one roller", "slip of nut on roller"}
    assert {"efficiency, nut drives", "carrier speed over nut speed", *named} <= set(cells)
    assert any("the load alone does not turn the nut" in words for words in section.paragraphs)
    said = " ".join([*cells, *section.paragraphs])
    assert "drives the screw" not in said
    assert "of screw" not in said
    names = {one.name for one in histories(leg, made.transient())}
    assert {"nut speed", "travel of the screw", "teeth of the screw on roller"} <= names
    assert not [name for name in names if "last nut" in name or "ring gear" in name]
    run = dataclasses.replace(data, mechanism=leg, transient=made.transient(1), improved=None)
    (words,) = present(transient_section(run)).paragraphs
    assert words.startswith("The nut runs at full speed from the start")


def test_force_slip_and_torque_of_an_inverted_screw_that_runs_backward():
    """They are those of the nut: the rollers roll on the screw, under 3 kN / 10 / 0.706 = 425 N.

    Along the axis the nut slides at 50 turns/s times 5 mm. Its normal force, on flanks of 45° at a
    14 mm radius, and 0.07 of it along the slip carry 300 N. The torque has the sign of the speed.
    """
    leg = prsm.set_parameter(scenes.example("humanoid_leg"), "speed", -100 * math.pi)
    leg = prsm.set_parameter(leg, "load", -3000.0)
    state = prsm.steady_state(leg)
    data = ReportData(mechanism=leg, title="Leg", steady=state, forward=state, backward=state)
    sections = {section.anchor: section for section in report_sections(data)}
    cells = {row[0]: row[1] for row in sections["steady"].tables[0].rows}
    (force,), (slip,) = (
        numbers(cells[f"{words} roller"])
        for words in ("normal force of nut on one", "slip of nut on")
    )
    assert (force.label, slip.label) == ("N", "mm/s")
    axial, normal = 50 * 5 / slip.value, (2 + (5 / (2 * math.pi * 14)) ** 2) ** -0.5
    assert force.value == pytest.approx(300 / (normal - 0.07 * axial), rel=3e-4)
    loss = 10 * 0.07 * force.value * slip.value * 1e-3
    lost = {row[0]: row[1] for row in sections["steady"].tables[1].rows}
    assert float(lost["thread sliding"]) == pytest.approx(loss, rel=1e-3)
    (words,) = [w for w in sections["summary"].paragraphs if w.startswith("At ")]
    assert words.endswith(f" and the torque at the nut {cells['drive torque']}.")
    assert cells["drive torque"].startswith(f"{_MINUS}2.899")


def test_a_locked_mechanism_has_no_efficiency_of_the_load(data):
    locked = dataclasses.replace(data, backward=made.steady(0, True), improved=None)
    section = next(s for s in report_sections(locked) if s.anchor == "steady")
    cells = {row[0]: row[1] for row in section.tables[0].rows}
    assert cells["efficiency, load drives"] == "self-locking"
    assert any("is self-locking" in words for words in section.paragraphs)


def _in_state(state, name):
    code = jnp.asarray(STEADY_RESULTS.index(name))
    moves = name in ("successful", "self_locking")
    return dataclasses.replace(
        state, code=code, valid=jnp.asarray(moves), efficiency=jnp.asarray(-0.34)
    )


@pytest.mark.parametrize(
    ("name", "words"), [("jammed", "jammed"), ("self_locking", "self-locking")]
)
def test_a_locked_or_jammed_thread_says_what_it_is(data, name, words):
    """Nowhere is the efficiency of -34 % printed that the balance of powers gives."""
    state = _in_state(data.steady, name)
    after = dataclasses.replace(data.improved, steady=state)
    locked = dataclasses.replace(data, steady=state, forward=state, backward=state, improved=after)
    sections = {section.anchor: section for section in report_sections(locked)}
    cells = {row[0]: row[1] for row in sections["steady"].tables[0].rows}
    assert cells["efficiency, screw drives"] == cells["efficiency, load drives"] == words
    first = next(p for p in sections["summary"].paragraphs if p.startswith("At "))
    assert f"the mechanism has no efficiency; {words}" in first
    # A jammed thread moves nothing: its balance of forces has no solution.
    lacking = [name for name, cell in cells.items() if cell == "–"]
    forces = ["drive torque", "input power", "output power", "normal force of screw on one roller"]
    assert lacking == ([*forces, "error of the power balance"] if name == "jammed" else [])
    assert any("slip of screw on roller" in name for name in cells)
    assert len(sections["steady"].tables) == (1 if name == "jammed" else 2)
    assert bool(sections["steady"].pictures) == (name != "jammed")
    said = [cell for s in sections.values() for t in s.tables for row in t.rows for cell in row]
    said += [words for section in sections.values() for words in section.paragraphs]
    assert not [text for text in said if re.search(r"34(\.\d+)?\s%", text)]


def test_without_a_load_drag_is_the_only_loss(data):
    """All of the input goes into it, and forces and powers of 0 are in newtons and watts."""
    name, *others = data.steady.losses
    losses = {name: jnp.asarray(25.0), **dict.fromkeys(others, jnp.asarray(0.0))}
    state = dataclasses.replace(
        data.steady,
        output_power=jnp.asarray(0.0),
        input_power=jnp.asarray(25.0),
        contact_force=jnp.zeros_like(data.steady.contact_force),
        losses=losses,
    )
    point = dataclasses.replace(data.mechanism.operating_point, load=jnp.asarray(0.0))
    mechanism = dataclasses.replace(data.mechanism, operating_point=point)
    idle = dataclasses.replace(data, mechanism=mechanism, steady=state, improved=None)
    section = next(s for s in report_sections(idle) if s.anchor == "steady")
    cells, lost = {row[0]: row[1] for row in section.tables[0].rows}, section.tables[1].rows
    assert cells["output power"].split() == ["0", "W"]
    assert cells["input power"].split() == ["25.00", "W"]
    assert cells["normal force of screw on one roller"].split() == ["0", "N"]
    assert {row[1] for row in lost} == {"25.00", "0"}


def test_sensitivities_of_a_locked_thread_and_at_a_kink(data):
    """A state instead of an efficiency, and both derivatives where two branches meet."""
    table = _sensitivity()
    table.values = np.array([-0.34, 2.13e9, 0.0])
    # Per metre: 2e10 below the present lead, 5e10 above; the table has neither.
    table.kinks = (("max_pressure", "lead", 2e10, 5e10),)
    table.dependents = ((("pitch",), ("nut_radius", "roller_radius")), ((), ()), ((), ()))
    sections = report_sections(dataclasses.replace(data, sensitivity=table))
    section = next(s for s in sections if s.anchor == "sensitivity")
    changes, relative, moves = section.tables
    efficiency, pressure, _ = changes.rows
    assert efficiency == ("efficiency in %", "none", *("not defined",) * 3)
    assert relative.rows[0] == ("efficiency", *("not defined",) * 3)
    assert pressure[2] == "20.0 below, 50.0 above"
    # Times 0.01 m over 2.13 GPa.
    assert relative.rows[1][1] == "+0.0939 below, +0.2347 above"
    assert relative.rows[1][2] == f"{_MINUS}0.6200"
    assert any(words.startswith("Kinks:") for words in section.paragraphs)
    assert moves.head == ("parameter", "what follows", "what stays")
    assert moves.rows == (("lead", "pitch", "nut radius, roller radius"),)


@reads("section", "transient_section")
def test_transient(sections, data):
    (table,) = sections["transient"].tables
    run = data.transient
    settled = made.time_within_one_per_cent(run)
    torque = np.asarray(run.drive_torque)
    found = dict(table.rows)
    expected = {
        "efficiency at the start": (run.efficiency[0], "1"),
        "efficiency at the end": (run.efficiency[-1], "1"),
        "settling time (carriers within 1 %)": (settled, "s"),
        "largest magnitude of the drive torque": (np.abs(torque).max(), "N·m"),
        "drive torque at the end": (torque[-1], "N·m"),
        "solver": "Kvaerno5, 50 steps",
        "estimated error": "carrier speed uncertain by up to 2.7·10⁻⁵ % of the highest screw speed",
    }
    assert set(found) >= set(expected)
    for name, value in expected.items():
        assert_cell(found[name], value)


@pytest.mark.parametrize(
    ("settles", "words"),
    [
        (0.133e-3, "less than 2.50\u202fms (1 sample)"),
        (6e-3, "less than 7.50\u202fms (3 samples)"),
        (16e-3, "0.0160\u202fs"),
    ],
)
def test_a_settling_time_between_the_first_samples_is_a_bound(data, settles, words):
    """Samples every 2.5 ms; a hundredth of the distance is left at the settling time."""
    run = data.transient
    time = 100 * run.time
    ratio = 0.37 * (1 - jnp.exp(-time * np.log(100) / settles))
    run = dataclasses.replace(run, time=time, carrier_ratio=ratio[None])
    section = transient_section(dataclasses.replace(data, transient=run))
    assert section is not None
    assert ("settling time (carriers within 1 %)", words) in section.tables[0].rows


def test_an_uncertain_transient_is_an_assumption(data):
    """An estimate of 30 % beside the table, and as a sentence beneath it."""
    estimate = jnp.zeros(81).at[40].set(0.3)
    report = dataclasses.replace(
        data.transient.solver, error_estimate=estimate.max(), error_over_time=estimate
    )
    run = dataclasses.replace(data.transient, solver=report)
    sections = report_sections(dataclasses.replace(data, transient=run))
    section = next(s for s in sections if s.anchor == "transient")
    words = "carrier speed uncertain by up to 30 % of the highest screw speed at t = 1.00 ms"
    assert ("estimated error", words) in section.tables[0].rows
    assert words in section.assumptions[-1]


@reads("section", "strength_section")
def test_strength(sections, data):
    (table,) = sections["strength"].tables
    rows = []
    for name, value in data.strength.items():
        quantity, other = find_quantity(name), data.improved.strength[name]
        before, after = ((float(np.ravel(v)[0]), quantity.unit) for v in (value, other))
        # Without checks no quantity has a limit.
        row = (
            name.replace("_", " "),
            quantity.symbol,
            before,
            "",
            "",
            "no limit",
            after,
            "no limit",
        )
        rows.append(row)
    head = ("", "symbol", "value", "limit", "margin", "verdict")
    assert_table(table, (*head, "after the optimisation", "verdict after"), rows)


def test_verdicts_of_strength_are_those_of_the_checks(data):
    """The worst stage decides; a limit that another check has belongs to no other quantity."""
    checks = (
        StrengthCheck("static_safety", 1, 1.3, 1.0, "1", False, 0.23, "1", "pass"),
        StrengthCheck("buckling", 1, 1.5, 2.0, "1", False, -0.17, "1", "warning"),
        StrengthCheck("screw_speed", 1, 320.0, 300.0, "rad/s", True, -0.07, "1", "warning"),
        StrengthCheck("rating_life", 1, 4e6, 3e6, "s", False, 0.33, "1", "pass"),
        StrengthCheck("backlash", 1, -2e-5, 0.0, "m", False, -2e-5, "m", "fail"),
    )
    after = dataclasses.replace(data.improved, checks=checks[:1])
    both = dataclasses.replace(data, checks=checks, improved=after)
    section = next(s for s in report_sections(both) if s.anchor == "strength")
    rows = {row[0]: row for row in section.tables[0].rows}
    expected = {
        "static safety": ((1.0, ""), (0.23, "1"), "pass", "pass"),
        "buckling safety": ((2.0, ""), (-0.17, "1"), "warning", "no limit"),
        "critical speed margin": ((0.0, ""), (-0.07, "1"), "warning", "no limit"),
        "life ratio": ((1.0, ""), (0.33, "1"), "pass", "no limit"),
        "axial backlash": ((0.0, "m"), (-2e-5, "m"), "fail", "no limit"),
    }
    for name, (limit, margin, verdict, later) in expected.items():
        *_, limit_cell, margin_cell, verdict_cell, _, later_cell = rows[name]
        assert limit_cell.startswith("at least ")
        assert_reads(limit_cell.removeprefix("at least "), (*limit, "whole"))
        assert_reads(margin_cell, margin)
        assert (verdict_cell, later_cell) == (verdict, later)
    others = {row[5] for name, row in rows.items() if name not in expected}
    assert others == {"no limit"}


@reads("section", "sensitivity_section")
def test_sensitivities(sections, data):
    changes, relative = sections["sensitivity"].tables
    table = data.sensitivity
    head = ("quantity", "value", "per mm of lead", "per deg of contact angle", "per 1 of starts")
    assert tuple(changes.head) == head
    for row, unit, cells in zip(range(3), ("1", "Pa", "kg"), changes.rows, strict=True):
        label = cells[0].partition(" in ")[2]
        scale = float(to_si(1.0, label))
        assert_cell(cells[1], (table.values[row], unit), row=cells[0])
        steps = (to_si(1.0, "mm"), to_si(1.0, "deg"), 1.0)
        for cell, slope, step in zip(cells[2:], table.gradient[row], steps, strict=True):
            (shown,) = numbers(cell)
            assert abs(shown.value * scale - slope * step) <= 1.001 * shown.rounding * scale
            assert shown.rounding <= 0.006 * abs(shown.value)
    rows = [
        ("efficiency", *((v, "", "whole") for v in table.elasticity[0])),
        ("max pressure", *((v, "", "whole") for v in table.elasticity[1])),
        ("mass", *("not defined",) * 3),
    ]
    assert_table(relative, ("quantity", "lead", "contact angle", "starts"), rows)


def _change(before, after):
    return f"{100 * (after / before - 1):+.2f} %".replace("-", _MINUS)


@reads("section", "optimisation_section")
def test_optimisation(sections, data):
    section, found = sections["optimisation"], data.optimisation
    variables, quantities, limits = section.tables
    rows = []
    for one in found.variables:
        span = [(one.lower, one.unit, "whole"), (one.upper, one.unit, "whole")]
        note = "at the upper bound" if one.at_bound else ""
        name = one.name.replace("_", " ")
        ends = (one.before, one.unit), (one.after, one.unit)
        moves = ("pitch", "nut radius") if one.name == "lead" else ("nothing", "nothing")
        rows.append((name, *ends, span, note, *moves))
    head = ("variable", "before", "after", "range", "", "what follows", "what stays")
    assert_table(variables, head, rows)
    before, after = data.steady, data.improved.steady
    lost = [sum(float(v) for v in s.losses.values()) for s in (before, after)]
    rows: list[Any] = [
        ("efficiency", (0.8512, "1"), (0.8791, "1"), "+2.79 points"),
        ("max pressure", (2.13e9, "Pa"), (2.97e9, "Pa"), _change(2.13, 2.97)),
    ]
    for name, unit, pair in (
        ("drive torque", "N·m", [float(s.drive_torque) for s in (before, after)]),
        ("output power", "W", [float(s.output_power) for s in (before, after)]),
        ("loss power", "W", lost),
    ):
        rows.append((name, *((v, unit) for v in pair), _change(*pair)))
    assert_table(quantities, ("quantity", "before", "after", "change"), rows)
    rows = [
        (
            "max pressure",
            (2.97e9, "Pa"),
            [(2.97e9, "Pa")],
            [(1.0, "1")],
            "active",
            # One per cent more of 2.97 GPa at 1.3e-12 each, in percentage points.
            [(0.01 * 2.97e9 * 1.3e-12, "1")],
        ),
        ("mass", (1.51, "kg"), [(1.32, "kg")], [(1.32 / 1.51, "1")], "not active", ""),
    ]
    head = ("quantity", "at the optimum", "limit", "use of the limit", "", "objective for +1 %")
    assert_table(limits, head, rows)
    assert [row[2].split()[:2] for row in limits.rows] == [["at", "most"], ["at", "least"]]
    words = _paragraph(section, "Efficiency rises").partition("active limits are")[2]
    assert_reads(words, (2.97e9, "Pa"), (0.913, "rad"))
    first, last = _paragraph(section, "First-order").split(";")
    assert_reads(first, (1.3e-9, "", "whole"))
    # The residual stands there once.
    assert last.endswith("The search converged.")


def test_the_page_has_the_cells_of_the_tables(sections, data, tmp_path, monkeypatch):
    """HTML and Markdown hold every cell of every table, in its place."""
    from prsm_jax.report.document import _write

    # Pictures have readers of their own.
    names = [picture.name for section in sections.values() for picture in section.pictures]
    monkeypatch.setattr(_write, "_draw", lambda *_: dict.fromkeys(names, "data:,"))
    monkeypatch.setattr(_write, "_charts", lambda *_: {})
    path = write_report(tmp_path / "out", data)
    tables = [table for section in sections.values() for table in section.tables]
    for (caption, rows), table in zip(html_tables(path.read_text()), tables, strict=True):
        assert caption == table.caption
        head = [list(table.head)] if any(table.head) else []
        assert rows == head + [[c.strip() for c in row] for row in table.rows]
    markdown = (path.parent / "report.md").read_text()
    for table in tables:
        for row in table.rows:
            assert " | ".join(escaped(c) for c in row) in markdown


def test_stages_keep_their_numbers_apart(data):
    """Two stages: each row has the numbers of its own."""
    two = scenes.example("li2021_two_stage")
    steady = made.steady(stages=2)
    both = ReportData(
        mechanism=two,
        title="Two",
        meshings=(made.meshing(), made.meshing()),
        contacts=(made.contact_pair(), made.contact_pair()),
        steady=steady,
        forward=steady,
        backward=steady,
    )
    found = {section.anchor: section for section in report_sections(both)}
    cells = {row[0]: row[1] for row in found["steady"].tables[0].rows}
    for k in range(2):
        for words, values, unit in (
            ("carrier speed over screw speed", steady.carrier_ratio, ""),
            ("normal force of screw on one roller", steady.contact_force, "N"),
            ("slip of screw on roller", steady.slip_speed, "m/s"),
        ):
            assert_cell(cells[f"{words}, stage {k + 1}"], (values[k], unit))
    (table,) = found["contact"].tables
    for index, row in enumerate(table.rows):
        stage, side = divmod(index, 2)
        name = ("screw", "nut")[side]
        assert row[0] == f"stage {stage + 1}, {name}"
        hertz = getattr(both.contacts[stage], name).hertz
        assert_cell(row[6], (hertz.max_pressure, "Pa"), table.head[6])
        assert_cell(row[7], (hertz.approach, "m"), table.head[7])
    mechanism = found["mechanism"].tables[0]
    assert mechanism.head == ("", "stage 1", "stage 2")
    lead = next(row for row in mechanism.rows if row[0] == "lead")
    for cell, stage in zip(lead[1:], two.stages, strict=True):
        assert_reads(cell, (stage.thread.lead, "m", "whole"))


_DRAWN_BY = {
    _analysis_sections: (
        "contact_ellipses", "frequency_chart", "history_chart", "loss_chart", "mode_shapes",
        "power_flow_chart", "power_history_chart", "transient_chart",
    ),
    _design_sections: ("cross_section", "optimisation_chart", "sensitivity_bars"),
    _mechanism_section: ("cross_section",),
    _strength_section: (
        "force_deflection_chart", "life_chart", "shaft_limits_chart", "thread_load_chart",
    ),
}  # fmt: skip


def test_every_picture_is_of_its_part_of_the_data(data, monkeypatch):
    """Charts have readers of their own; here which numbers each is given."""
    for module, names in _DRAWN_BY.items():
        for name in names:
            keep = lambda *given, name=name, **more: (name, given, more)  # noqa: E731
            monkeypatch.setattr(module, name, keep)
    drawn = {p.name: p.draw() for section in report_sections(data) for p in section.pictures}
    after, found = data.improved, data.optimisation

    def given(picture, chart):
        name, values, more = drawn.pop(picture)
        assert name == chart
        return [*values, *more.values()]

    designs, pressures, lines = given("contact_ellipses", "contact_ellipses")
    assert list(designs) == list(pressures) == list(lines) == ["before", "after"]
    for label, whole in (("before", data), ("after", after)):
        assert designs[label] is whole.contacts[0]
        pair = (designs[label].screw.hertz, designs[label].nut.hertz)
        assert pressures[label] == tuple(float(hertz.max_pressure) for hertz in pair)
    for picture, chart, part in (
        ("frequencies", "frequency_chart", "modes"),
        ("losses", "loss_chart", "steady"),
    ):
        (designs,) = given(picture, chart)
        assert list(designs) == ["before", "after"]
        for one, whole in zip(designs.values(), (data, after), strict=True):
            wanted = getattr(whole, part)
            assert one is (wanted[0] if isinstance(wanted, tuple) else wanted)
    (flow,) = given("power_flow", "power_flow_chart")
    assert flow.sources == {"motor": pytest.approx(float(data.forward.input_power))}
    assert given("transient", "transient_chart") == [data.transient]
    for picture, chart in (("histories", "history_chart"), ("powers", "power_history_chart")):
        assert given(picture, chart) == [data.mechanism, data.transient]
    energy, words = given("energy_flow", "power_flow_chart")
    run = data.transient
    work = float(simpson(run.drive_torque * run.screw_speed, x=run.time))
    assert (energy.unit, energy.sources["motor"]) == ("J", pytest.approx(work, rel=1e-9))
    assert words == "Energy flow of the whole transient"
    (shared,) = given("thread_loads", "thread_load_chart")
    assert shared is data.shared[0]
    (curves,) = given("force_deflection", "force_deflection_chart")
    assert list(curves.values()) == [data.deflections[0]]
    capacity, spectrum, static, fatigue = given("life", "life_chart")
    assert fatigue is (data.fatigue[0] if data.fatigue else None)
    assert capacity == float(data.strength["dynamic_capacity"][0])
    assert static == float(data.strength["static_capacity"][0])
    cycle = data.mechanism.duty_cycle
    np.testing.assert_allclose(spectrum.load, cycle.load)
    np.testing.assert_allclose(spectrum.turned_angle, np.abs(cycle.speed * cycle.duration))
    stage, load, speed = given("shaft_limits", "shaft_limits_chart")
    assert stage is data.mechanism.stages[0]
    point = data.mechanism.operating_point
    assert float(load) == max(float(abs(point.load)), float(np.abs(cycle.load).max()))
    assert float(speed) == max(float(abs(point.speed)), float(np.abs(cycle.speed).max()))
    quantities, parameters, elasticity = given("sensitivities", "sensitivity_bars")
    assert (quantities, parameters) == (data.sensitivity.quantities, data.sensitivity.parameters)
    np.testing.assert_allclose(elasticity[:2], data.sensitivity.elasticity[:2])
    assert np.isnan(elasticity[2]).all()
    history, limits, objective, unit, violations, feasible = given(
        "optimisation", "optimisation_chart"
    )
    assert feasible
    assert (history, limits) == (found.history, found.limits)
    assert (objective, unit, violations) == ("efficiency", "1", found.violations)
    designs, number = given("before_after", "cross_section")
    assert list(designs) == ["Before", "After"]
    assert number == 1
    assert designs["After"] is after.mechanism
    designs, number = given("cross_section", "cross_section")
    assert list(designs.values()) == [data.mechanism]
    assert drawn == {}
