"""Status, inputs, assumptions and provenance of a report, and the verbs that print checks."""

import dataclasses
import json
import math

import pytest
import scenes
from expectations import reads
from reading_tables import assert_json, assert_table, html_tables
from reading_units import assert_reads

import prsm_jax as prsm
from prsm_jax.cli import _plugins
from prsm_jax.cli.verbs import _analyse, _demo
from prsm_jax.findings import Finding, StrengthCheck
from prsm_jax.mechanism import DesignProblem, Objective, OperatingCase, Variable
from prsm_jax.optimisation import LimitReading
from prsm_jax.report import MARGINS_IN_WORDS, Origin, ReportData
from prsm_jax.report.document._sections import report_sections

_CHECKS = (
    StrengthCheck("static_safety", 1, 1.234, 1.0, "1", False, 0.1896, "1", "pass"),
    StrengthCheck("max_pressure", 0, 4.51e9, 4.2e9, "Pa", True, -0.0738, "1", "fail"),
    StrengthCheck("rating_life", 1, 9.123e6, 1.08e7, "s", False, -0.1553, "1", "warning"),
    StrengthCheck("screw_speed", 1, 261.8, 301.3, "rad/s", True, 0.1311, "1", "pass"),
    StrengthCheck(
        *("contact_truncation", 1, 0.10423, 0.0, "1", True, -4.137e-5, "m", "warning"),
        subject="crest of screw on the screw side",
        at_load="the static capacity",
    ),
    StrengthCheck("backlash", 1, 3.21e-5, 0.0, "m", False, 3.21e-5, "m", "pass"),
    StrengthCheck("dynamic_capacity", 1, 6.543e4, None, "N", False, None, "1", "no limit"),
)
#: Label, and dimension of value and margin.
_LABELS = {
    "static_safety": "static safety under the largest load",
    "max_pressure": "contact pressure at the operating point, equal sharing",
    "rating_life": "rating life, with its factors",
    "screw_speed": "speed of the body that turns",
    "contact_truncation": (
        "share of the ellipse past the crest of screw on the screw side (at the static capacity)"
    ),
    "backlash": "backlash",
    "dynamic_capacity": "dynamic capacity",
}


def _rows(checks):
    for one in checks:
        limit: tuple = ()
        margin: tuple = ()
        if one.limit is not None:
            limit = ("at most " if one.at_most else "at least ", one.limit, one.unit)
            margin = (one.margin, one.margin_unit)
        yield _LABELS[one.name], (one.value, one.unit), limit, margin, one.verdict


def _assert_rows(rows, checks):
    """Cells of a table of checks, read back to SI."""
    for cells, (label, value, limit, margin, verdict) in zip(rows, _rows(checks), strict=True):
        assert cells[0] == label
        assert_reads(cells[1], value)
        assert cells[1].endswith("%") == label.startswith("share of the ellipse")
        if limit:
            assert cells[2].startswith(limit[0])
            assert_reads(cells[2].removeprefix(limit[0]), (limit[1], limit[2], "whole"))
            assert_reads(cells[3], margin)
        else:
            assert not any(cells[2:4])
        assert cells[4] == verdict


@pytest.fixture(scope="module")
def data():
    mechanism = scenes.example("wu2022")
    found = (Finding("buckling", "warning", 1, 1.2, 2.0, "too long"),)
    origin = Origin("", "0123abcd" * 8, ("lead=12 mm",), "A. Uthor", "B", "2026-11-24")
    return ReportData(
        mechanism,
        "x",
        checks=_CHECKS,
        findings=found,
        source="my.toml",
        command="prsm report my.toml",
        left_out=(("vibration", "no masses"),),
        origin=origin,
    )


@pytest.fixture(scope="module")
def sections(data):
    return {section.anchor: section for section in report_sections(data)}


@reads("section", "status_section")
def test_status(sections, data):
    section = sections["status"]
    assert section.status == data.status == "fail"
    (table,) = section.tables
    assert table.head == ("check", "value", "limit", "margin", "verdict")
    assert table.verdict_columns == (4,)
    _assert_rows(table.rows, _CHECKS)
    first = section.paragraphs[0]
    assert first == (
        "Status: fail. Of 7 checks 3 keep their limit, 2 are beyond a limit of severity warning, "
        "1 fails, 1 has no limit. The findings have 1 warning."
    )


def test_status_of_two_designs(data):
    """Both are shown; the status of the report is that of the improved design."""
    kept = tuple(one for one in _CHECKS if one.verdict in ("pass", "no limit"))
    after = dataclasses.replace(data, checks=kept, findings=())
    section = report_sections(dataclasses.replace(data, improved=after))[0]
    assert (section.anchor, section.status) == ("status", "pass")
    assert [one.caption for one in section.tables] == ["Checks: start", "Checks: optimum"]
    _assert_rows(section.tables[1].rows, kept)
    assert section.paragraphs[0].startswith("Status of the start: fail.")
    assert section.paragraphs[1].startswith("Status of the optimum: pass.")
    one = dataclasses.replace(data, checks=kept[:1], findings=())
    words = report_sections(one)[0].paragraphs[0]
    assert words.startswith("Status: pass. Of 1 check 1 keeps its limit. The")
    # The findings of geometry are made, so the status is theirs.
    bare = report_sections(dataclasses.replace(data, checks=(), findings=()))[0]
    assert (bare.status, bare.tables) == ("pass", ())
    assert "No check has a limit." in bare.paragraphs[0]
    unknown = dataclasses.replace(data, checks=None, findings=None)
    section = report_sections(unknown)[0]
    assert section.status == "warning"
    assert "Not everything could be checked." in section.paragraphs[0]


#: In SI: a value in each display unit, limits of each kind, a component, an operating point.
_LIMITS = (
    LimitReading("max_pressure_shared", "Pa", 2.3e9, 2.1e9, True, -2 / 21, "fail"),
    LimitReading("nut_outer_diameter", "m", 0.0571, 0.058, True, 9 / 580, "pass"),
    LimitReading("stage_stiffness[2]", "N/m", 7.26e8, 7.8e8, False, -54 / 780, "fail"),
    LimitReading("drive_torque", "N·m", 22.4, 25.0, True, 0.104, "pass", False, 261.8, 8e3),
    LimitReading("roller_clearance", "m", -4.5e-5, 0.0, False, -4.5e-5, "fail"),
    LimitReading("carrier_ratio", "1", 0.31, 0.4, True, -0.225, "fail", True),
    LimitReading("efficiency", "1", math.nan, 0.8, False, math.nan, "not evaluated"),
)


def _assert_limits(rows, limits=_LIMITS):
    """Cells of a table of limits, read back to SI."""
    for cells, one in zip(rows, limits, strict=True):
        assert cells[0].startswith(one.quantity.partition("[")[0].replace("_", " "))
        if one.load is not None:
            speed, load = cells[0].partition(" at ")[2].split(" and ")
            assert_reads(speed, (one.speed, "rad/s"))
            assert_reads(load, (one.load, "N"))
        sense = "equal to " if one.equal else "at most " if one.at_most else "at least "
        assert cells[2].startswith(sense)
        if one.limit:
            assert_reads(cells[2].removeprefix(sense), (one.limit, one.unit, "whole"))
        if one.verdict == "not evaluated":
            assert not cells[1] + cells[3]
        else:
            assert_reads(cells[1], (one.value, one.unit))
            assert_reads(cells[3], (one.margin, "1" if one.limit else one.unit, "coarse"))
        assert cells[4] == one.verdict


def test_limits_of_the_design_problem_are_in_the_status(data):
    """A broken limit of the file is a failure, however well all checks are kept."""
    kept = tuple(one for one in _CHECKS if one.verdict == "pass")
    one = dataclasses.replace(data, checks=kept, findings=(), limits=_LIMITS)
    section = report_sections(one)[0]
    assert (section.anchor, section.status, one.status) == ("status", "fail", "fail")
    checks, limits = section.tables
    assert limits.caption == "Limits of the design problem ([optimise])"
    assert limits.head == ("quantity", "value", "limit", "margin", "verdict")
    assert limits.verdict_columns == (4,)
    _assert_rows(checks.rows, kept)
    _assert_limits(limits.rows)
    assert section.paragraphs[0] == (
        "Status: fail. Of 3 checks 3 keep their limit. Of 7 limits of the design problem "
        "([optimise]) 2 are kept, 4 are broken, 1 was not evaluated. The findings have no error "
        "and no warning."
    )
    assert "at the operating point of the mechanism" in section.paragraphs[2]
    good = dataclasses.replace(one, limits=_LIMITS[1:2])
    section = report_sections(good)[0]
    assert section.status == "pass"
    assert "Of 1 limit of the design problem ([optimise]) 1 is kept." in section.paragraphs[0]
    lost = dataclasses.replace(one, limits=None)
    section = report_sections(lost)[0]
    assert section.status == "warning"
    assert "The limits of the design problem ([optimise]) could not be" in section.paragraphs[0]
    # The design before is broken, the one after is kept: each has its own table.
    both = report_sections(dataclasses.replace(one, improved=good))[0]
    assert both.status == "pass"
    assert [table.caption for table in both.tables] == [
        "Checks: start",
        "Limits of the design problem ([optimise]): start",
        "Checks: optimum",
        "Limits of the design problem ([optimise]): optimum",
    ]
    _assert_limits(both.tables[3].rows, _LIMITS[1:2])


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"nut_speed": 0.25}, "at which the nut moves with 250.0 mm/s"),
        (
            {"operating_points": (OperatingCase(100.0, 5e3),)},
            "operating point of [optimise] at which the margi",
        ),
        ({"tolerance_sigmas": 3.0}, "a search also adds 3 standard deviations"),
    ],
)
def test_where_limits_were_read(data, settings, words):
    problem = DesignProblem((Variable("lead", 4e-3, 9e-3),), (Objective("mass"),), **settings)
    mechanism = dataclasses.replace(data.mechanism, design_problem=problem)
    one = dataclasses.replace(data, mechanism=mechanism, limits=_LIMITS)
    # Between a number and its unit is a narrow space.
    assert words in " ".join(report_sections(one)[0].paragraphs[-1].split())


@reads("section", "inputs_section")
def test_inputs(sections):
    """Without a file; `tests/report/document/test_report_inputs.py` compares numbers of files."""
    tables = {table.caption: table for table in sections["inputs"].tables}
    rows = {row[0]: row for row in tables["[stage.thread]"].rows}
    thread = scenes.example("wu2022").stages[0].thread
    assert_reads(rows["lead"][1], (thread.lead, "m", "whole"))
    assert_reads(rows["contact angle"][1], (thread.contact_angle, "rad", "whole"))
    friction = {row[0]: row[1] for row in tables["[stage.friction.thread]"].rows}
    assert friction["law"] == "coulomb"
    assert_reads(friction["coefficient"], (0.05, "", "whole"))


@reads("section", "left_out_section")
def test_left_out(sections, data):
    section = sections["left_out"]
    absent, failed = section.tables
    assert failed.rows == (("vibration", "no masses"),)
    names = {row[0] for row in absent.rows}
    assert "stage.1.strength" in names
    assert "stage.1.friction" not in names
    assert all(row[1] and row[2] for row in absent.rows)
    assert section.assumptions == prsm.assumptions(data.mechanism)


@reads("section", "provenance_section")
def test_provenance(sections, data):
    responsible, made = sections["provenance"].tables
    assert_table(
        responsible,
        ("", ""),
        [
            *(("author", "A. Uthor"), ("revision", "B"), ("date", "2026-11-24")),
            ("signature", "…" * 12),
        ],
    )
    rows = dict(made.rows)
    assert rows["SHA-256 of this file"] == data.origin.sha256
    assert rows["mechanism from"] == "my.toml"
    assert rows["changed on the command line"] == "lead=12 mm"
    assert rows["prsm_jax"] == prsm.__version__
    assert rows["numbers"] == "float64"


@reads("verb", "strength")
def test_strength(run, monkeypatch):
    monkeypatch.setattr(_analyse, "check_values", lambda _: {})
    monkeypatch.setattr(_analyse, "checked_numbers", lambda _: None)
    monkeypatch.setattr(_analyse, "check_from", lambda *_: ())
    monkeypatch.setattr(_analyse, "strength_checks_from", lambda *_: _CHECKS)
    found, printed = run("strength", "wu2022", status=1)
    assert found["status"] == "fail"
    assert_json(found["checks"], [dataclasses.asdict(one) for one in _CHECKS])
    assert {"name", "value", "limit", "unit", "margin", "verdict"} <= set(found["checks"][0])
    printed.row("Strength of wu2022: fail")
    assert printed.row("check") == ["value", "limit", "margin", "verdict"]
    for label, value, limit, margin, verdict in _rows(_CHECKS):
        cells = printed.row(label)
        assert_reads(cells[0], value)
        assert cells[-1] == verdict
        if limit:
            assert_reads(cells[1].removeprefix(limit[0]), (limit[1], limit[2], "whole"))
            assert_reads(cells[2], margin)
    # How margins follow from values and limits stands below the table.
    printed.row(MARGINS_IN_WORDS)
    printed.finish()


def test_strength_names_broken_limits_of_the_design_problem(run, monkeypatch, tmp_path):
    """Beside the status, which is that of the checks."""
    kept = tuple(one for one in _CHECKS if one.verdict == "pass")
    monkeypatch.setattr(_analyse, "check_values", lambda _: {})
    monkeypatch.setattr(_analyse, "checked_numbers", lambda _: None)
    monkeypatch.setattr(_analyse, "check_from", lambda *_: ())
    monkeypatch.setattr(_analyse, "strength_checks_from", lambda *_: kept)
    monkeypatch.setattr(_analyse, "_limits", lambda _: _LIMITS)
    found, printed = run("strength", "wu2022", "--out", tmp_path / "out")
    assert found["status"] == "pass"
    for entry, one in zip(found["limits"], _LIMITS, strict=True):
        assert_json(entry["value"], None if math.isnan(one.value) else one.value)
        assert (entry["limit"], entry["unit"]) == (one.limit, one.unit)
        assert entry["verdict"] == one.verdict
    words = " ".join(cell for cells in printed.lines for cell in cells)
    assert "Of 7 limits of the design problem ([optimise]) 2 are kept, 4 are broken" in words
    assert "The status above does not include them" in words
    assert_reads(printed.row("max pressure shared")[0], (2.3e9, "Pa"))
    # Those that are kept are no concern of this verb.
    assert "drive torque" not in words
    assert "max pressure shared" in (tmp_path / "out" / "strength.md").read_text()
    monkeypatch.setattr(_analyse, "_limits", lambda _: _LIMITS[1:2])
    _, printed = run("strength", "wu2022")
    assert "design problem" not in " ".join(cell for cells in printed.lines for cell in cells)


def test_strength_of_a_file_without_limits(run, monkeypatch):
    """No table, no verdict, and what the file must hold."""
    monkeypatch.setattr(_analyse, "check_values", lambda _: {})
    monkeypatch.setattr(_analyse, "checked_numbers", lambda _: None)
    monkeypatch.setattr(_analyse, "check_from", lambda *_: ())
    monkeypatch.setattr(_analyse, "strength_checks_from", lambda *_: ())
    found, printed = run("strength", "wu2022")
    assert (found["status"], found["checks"]) == ("no checks", [])
    words = " ".join(cell for cells in printed.lines for cell in cells)
    assert words.startswith("No checks: the file gives no limit. Give permissible_pressure")
    assert "Strength of" not in words
    assert "margin" not in words


@reads("verb", "report")
def test_report(run, monkeypatch, data, tmp_path):
    """The JSON, the table, and what goes into the report."""
    from prsm_jax import report

    given = {}

    def analyse(mechanism, **more):
        given.update(more)
        return dataclasses.replace(data, mechanism=mechanism, limits=_LIMITS)

    def write(folder, data, *, on_fault):
        return folder / "report.html"

    monkeypatch.setattr(report, "analyse", analyse)
    monkeypatch.setattr(report, "write_report", write)
    words = ("report", "wu2022", "--out", tmp_path / "a b", "--author", "N. N.", "--revision", "C")
    words += ("--no-transient",)
    monkeypatch.setattr(_plugins, "_loaded", [("my laws.py", math), ("fits", math)])
    found, printed = run(*words, "--set", "lead=12 mm")
    assert found["report"] == str(tmp_path / "a b" / "report.html")
    assert found["status"] == "fail"
    assert found["complete"] is True
    assert_json(found["checks"], [dataclasses.asdict(one) for one in _CHECKS])
    origin = given["origin"]
    assert (origin.author, origin.revision, origin.settings) == ("N. N.", "C", ("lead=12 mm",))
    assert found["sha256"] == origin.sha256
    assert given["command"] == (
        f"prsm report wu2022 --out '{tmp_path}/a b' --set 'lead=12 mm' --no-transient "
        "--author 'N. N.' --revision C --plugin 'my laws.py' --plugin fits"
    )
    printed.row("Status: fail")
    printed.row("check")
    for label, value, *_ in _rows(_CHECKS):
        assert_reads(printed.row(label)[0], value)
    printed.row("Limits of the design problem ([optimise])")
    assert_reads(printed.row("max pressure shared")[0], (2.3e9, "Pa"))
    assert [one["verdict"] for one in found["limits"]] == [one.verdict for one in _LIMITS]


def test_a_file_that_changes_while_it_is_read_is_refused(run, monkeypatch, tmp_path, capsys):
    from prsm_jax.cli import main
    from prsm_jax.cli._common import Common

    path = tmp_path / "my.toml"
    path.write_text(prsm.file.example_text("wu2022"))
    load = Common.load

    def changing(self, source):
        mechanism = load(self, source)
        path.write_text(path.read_text() + "# more\n")
        return mechanism

    monkeypatch.setattr(Common, "load", changing)
    assert main(["report", str(path), "--out", str(tmp_path / "out")]) == 2
    assert "changed while it was read" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert _demo.Signed().author == ""


def test_checks_of_a_page_are_those_of_the_python_api(tmp_path):
    """From the file to the cell of the page and the JSON, without a number in between."""
    from prsm_jax.cli import main

    text = prsm.file.example_text("wu2022") + (
        '\n[stage.strength]\nstatic_capacity = "60 kN"\ndynamic_capacity = "45 kN"\n'
        'required_life = "500 h"\n'
    )
    path = tmp_path / "my.toml"
    path.write_text(text)
    out = tmp_path / "out"
    words = [
        "report",
        str(path),
        "--out",
        str(out),
        "--no-transient",
        "--json",
        str(tmp_path / "j"),
    ]
    assert main(words) in (0, 1)
    checks = prsm.strength_checks(prsm.load(path))
    found = json.loads((tmp_path / "j").read_text())
    assert [one["name"] for one in found["checks"]] == [one.name for one in checks]
    for one, check in zip(found["checks"], checks, strict=True):
        assert one["verdict"] == check.verdict
        assert one["value"] == pytest.approx(check.value, rel=1e-9)
        assert_json(one["margin"], check.margin)
    tables = dict(html_tables((out / "report.html").read_text()))
    rows = tables["Checks"][1:]
    by_label = {row[0]: row for row in rows}
    assert_reads(by_label["static safety under the largest load"][1], (60 / 7, ""))
    life = 1e6 * (45 / 7) ** 3 * 2 * 3.141592653589793 / 100
    assert_reads(by_label["rating life, with its factors"][1], (life, "s"))
    content = json.loads((out / "report.json").read_text())
    assert content["status"] == found["status"]
    assert content["sections"][0]["tables"][0]["rows"] == rows
