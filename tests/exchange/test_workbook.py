"""The workbook of a report, read by openpyxl: numbers against the mechanism, units in headings."""

import copy
import dataclasses
import math
import pickle

import openpyxl
import pytest

import prsm_jax as prsm
from prsm_jax.exchange import write_workbook
from prsm_jax.exchange._cells import columns_of, number_cell
from prsm_jax.findings import StrengthCheck
from prsm_jax.optimisation import LimitReading
from prsm_jax.report import ReportData, Table
from prsm_jax.text import fixed, number, related, show, trimmed, with_label

#: Numbers are not rounded; conversions are multiplications.
EXACT = 1e-14
CHECKS = (
    StrengthCheck("static_safety", 1, 3.4567, 1.5, "1", False, 0.5661, "1", "pass"),
    StrengthCheck("buckling_load", 1, 23456.0, None, "N", False, None, "1", "no limit"),
    StrengthCheck("max_pressure", 1, 4.321e9, 4.2e9, "Pa", True, -0.0288, "1", "fail"),
    StrengthCheck("axial_backlash", 1, 12.3e-6, 20e-6, "m", True, 7.7e-6, "m", "pass"),
)


@pytest.fixture(scope="module")
def book(tmp_path_factory):
    mechanism = dataclasses.replace(prsm.load("wu2022"), revision="2.10")
    path = tmp_path_factory.mktemp("book") / "report.xlsx"
    data = ReportData(mechanism=mechanism, title="", checks=CHECKS, source="=1+1")
    assert write_workbook(path, data) == path
    assert [one.name for one in path.parent.iterdir()] == ["report.xlsx"]
    return openpyxl.load_workbook(path)


def _rows(sheet):
    return [[one for one in row if one is not None] for row in sheet.iter_rows(values_only=True)]


def _table(sheet, caption):
    """Headings and rows below a caption, up to an empty row, each row by the headings."""
    rows = list(sheet.iter_rows(values_only=True))
    start = next(i for i, row in enumerate(rows) if row[0] == caption)
    heads = [one for one in rows[start + 1] if one is not None]
    body = []
    for row in rows[start + 2 :]:
        if not any(one is not None for one in row):
            break
        body.append(dict(zip(heads, row, strict=False)))
    return heads, body


def test_checks_have_numbers_units_and_relations(book):
    heads, rows = _table(book["Status"], "Checks")
    assert heads[1:] == [
        "value",
        "unit",
        "limit",
        "unit of limit",
        "limit is",
        "margin",
        "unit of margin",
        "verdict",
    ]
    per_unit = {None: 1.0, "kN": 1e3, "MPa": 1e6, "µm": 1e-6, "%": 1e-2}
    assert len(rows) == len(CHECKS)
    for row, check in zip(rows, CHECKS, strict=True):
        value = row["value"] * per_unit[row["unit"]]
        assert value == pytest.approx(check.value, rel=EXACT)
        assert row["verdict"] == check.verdict
        if check.limit is None:
            assert (row["limit"], row["limit is"], row["margin"]) == (None, None, None)
            continue
        limit = row["limit"] * per_unit[row["unit of limit"]]
        assert limit == pytest.approx(check.limit, rel=EXACT)
        assert row["limit is"] == ("at most" if check.at_most else "at least")
        margin = row["margin"] * per_unit[row["unit of margin"]]
        assert margin == pytest.approx(check.margin, rel=EXACT)


def test_a_broken_limit_of_the_design_problem_is_on_the_sheet_of_the_status(tmp_path):
    limits = (
        LimitReading("max_pressure", "Pa", 2.3e9, 2.1e9, True, -2 / 21, "fail"),
        LimitReading("nut_outer_diameter", "m", 0.0571, 0.058, True, 9 / 580, "pass"),
        LimitReading("efficiency", "1", math.nan, 0.8, False, math.nan, "not evaluated"),
    )
    data = ReportData(mechanism=prsm.load("wu2022"), title="", checks=CHECKS[:1], limits=limits)
    sheet = openpyxl.load_workbook(write_workbook(tmp_path / "report.xlsx", data))["Status"]
    words = " ".join(str(one) for row in _rows(sheet) for one in row)
    assert "Status: fail." in words
    assert "Of 3 limits of the design problem ([optimise]) 1 is kept, 1 is broken" in words
    _, rows = _table(sheet, "Limits of the design problem ([optimise])")
    assert [row["verdict"] for row in rows] == ["fail", "pass", "not evaluated"]
    per_unit = {"MPa": 1e6, "mm": 1e-3, "%": 1e-2}
    for row, one in zip(rows[:2], limits[:2], strict=True):
        assert row["value"] * per_unit[row["unit"]] == pytest.approx(one.value, rel=EXACT)
        limit = row["limit"] * per_unit[row["unit of limit"]]
        assert limit == pytest.approx(one.limit, rel=EXACT)
        assert row["limit is"] == "at most"
    assert rows[2]["value"] is None


def test_dimensions_of_the_mechanism_are_numbers_with_units(book):
    thread = prsm.load("wu2022").stages[0].thread
    heads, rows = _table(book["Mechanism"], "Mechanism")
    assert heads == ["name", "value", "unit"]
    found = {row["name"]: (row["value"], row.get("unit")) for row in rows}
    for name, value in {
        "lead": thread.lead,
        "screw diameter": 2 * thread.screw_radius,
        "centre distance": thread.centre_distance,
    }.items():
        assert found[name] == (pytest.approx(1e3 * float(value), rel=EXACT), "mm")
    degrees = pytest.approx(float(thread.contact_angle) * 180 / math.pi, rel=1e-13)
    assert found["contact angle (from the transverse plane)"] == (degrees, "°")
    assert found["rollers"] == (7, None)
    assert found["Young's modulus"] == (212, "GPa")
    assert found["Poisson's ratio"] == (0.29, None)


def test_numbers_with_many_digits_are_not_rounded(tmp_path):
    """The mass of a cylinder, inputs of a duty cycle and limits, as a report rounds them."""
    roller = 2.0 / 3.0 * 1e-2
    words = f"""
[[stage]]
roller_count = 7
[stage.thread]
lead = 0.01
starts = 5
roller_radius = 0.004
contact_angle = 0.8
[stage.roller]
length = {roller}
[stage.screw]
length = 0.1
[stage.nut]
length = 0.05
wall_thickness = 0.005
[stage.carrier]
length = 0.004
radial_width = 0.006
count = 2
[stage.material]
youngs_modulus = 2.1e11
poisson_ratio = 0.3
density = 7850.0
[stage.friction.thread]
law = "coulomb"
coefficient = 0.1
[[duty_cycle]]
duration = 1.23456789012345
speed = 100.0
load = 5000.0
[optimise]
minimise = "mass"
[[optimise.variable]]
name = "lead"
lower = 0.005
upper = 0.02
[[optimise.constraint]]
quantity = "max_pressure"
upper = 2123456789.0123
"""
    path = tmp_path / "report.xlsx"
    write_workbook(path, ReportData(mechanism=prsm.loads(words), title=""))
    book = openpyxl.load_workbook(path)
    found = {row["name"]: row for row in _table(book["Mechanism"], "Mechanism")[1]}
    mass = 7850 * math.pi * 0.004**2 * roller
    assert found["mass of a roller"]["value"] == pytest.approx(1e3 * mass, rel=EXACT)
    assert found["mass of a roller"]["unit"] == "g"
    (phase,) = _table(book["Inputs"], "[[duty_cycle]]")[1]
    assert phase["duration [s]"] == pytest.approx(1.23456789012345, rel=EXACT)
    assert phase["speed [rpm]"] == pytest.approx(100 * 30 / math.pi, rel=EXACT)
    (limit,) = _table(book["Inputs"], "[optimise] constraints")[1]
    assert limit["limit [MPa]"] == pytest.approx(2123.4567890123, rel=EXACT)
    assert limit["limit is"] == "at most"


def test_no_cell_is_a_formula_and_versions_stay_text(book):
    for sheet in book:
        for row in sheet.iter_rows():
            assert all(cell.data_type in "ns" for cell in row)
    made = {row["name"]: row["value"] for row in _table(book["Provenance"], "Made with")[1]}
    assert made["mechanism from"] == "=1+1"
    signed = {row["name"]: row["value"] for row in _table(book["Provenance"], "Responsible")[1]}
    assert signed["revision"] == "2.10"


def test_assumptions_are_a_sheet_with_the_section_of_each(book):
    rows = _rows(book["Assumptions"])
    assert rows[0] == ["section", "assumption"]
    found = {tuple(row) for row in rows[1:]}
    title = "Assumptions and parts left out"
    assert {(title, words) for words in prsm.assumptions(prsm.load("wu2022"))} <= found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("12.31\u202fN·m", (12.31, "N·m", "", 2)),
        ("\N{MINUS SIGN}1.961", (-1.961, "", "", 3)),
        ("7.5·10⁻⁵\u202fmm", (7.5e-5, "mm", "", 1)),
        ("at most 4200\u202fMPa", (4200.0, "MPa", "at most", 0)),
        ("45°", (45.0, "°", "", 0)),
        ("90.47 %", (90.47, "%", "", 2)),
        ("equal to 5\u202fmm", (5.0, "mm", "equal to", 0)),
    ],
)
def test_a_cell_is_a_number_with_a_unit(text, expected):
    cell = number_cell(text)
    assert (cell.value, cell.unit, cell.relation, cell.decimals) == expected


@pytest.mark.parametrize(
    ("shown", "value", "unit", "relation", "text"),
    [
        (number(math.pi), math.pi, "", "", "3.142"),
        (number(1 / 3e9, 3), 1 / 3e9, "", "", "3.33·10⁻¹⁰"),
        (show(2127.712e6, "Pa"), 2127.712, "MPa", "", "2128\u202fMPa"),
        (related("at most", show(1e-3 / 7, "m")), 1 / 7, "mm", "at most", "at most 0.1429\u202fmm"),
        (fixed(0.5 - 1 / 3, 2, "+"), 0.5 - 1 / 3, "", "", "+0.17"),
        (fixed(1 / 3 - 0.5, 2, "+"), 1 / 3 - 0.5, "", "", "\N{MINUS SIGN}0.17"),
        (with_label(trimmed(22.4999, 2), "°", ""), 22.4999, "°", "", "22.5°"),
    ],
)
def test_a_shown_number_keeps_all_its_digits(shown, value, unit, relation, text):
    for one in (shown, copy.deepcopy(shown), pickle.loads(pickle.dumps(shown))):
        assert str(one) == one == text
        cell = number_cell(one)
        assert (cell.unit, cell.relation) == (unit, relation)
        assert cell.value == pytest.approx(value, rel=1e-15)
        assert cell.signed == text.startswith("+")


def test_what_is_not_finite_is_no_number():
    for value in (math.nan, math.inf, -math.inf):
        assert number_cell(number(value)) is None
        assert number_cell(fixed(value, 2)) is None


@pytest.mark.parametrize(
    "text", ["", "–", "0.11.0", "6 in 7 places", "carrier 1", "2026-11-24", "8c5caa", "12 apples"]
)
def test_other_text_stays_text(text):
    assert number_cell(text) is None


def test_a_unit_of_the_heading_is_written_in_brackets():
    table = Table(
        "",
        ("mode", "frequency in Hz", "share", "mass"),
        (("a", "839.13", "1 %", "3\u202fg"), ("b", "4847.5", "–", "4\u202fkg")),
    )
    columns = columns_of(table)
    assert [one.heading for one in columns] == [
        "mode",
        "frequency [Hz]",
        "share [%]",
        "mass",
        "unit of mass",
    ]
    assert columns[2].cells[1] == "–"
    assert columns[4].cells == ("g", "kg")
    assert columns_of(table, numbers=False)[1].cells == ("839.13", "4847.5")


def test_another_ending_is_refused(tmp_path):
    data = ReportData(mechanism=prsm.load("wu2022"), title="")
    with pytest.raises(ValueError, match=r"must be \.xlsx"):
        write_workbook(tmp_path / "report.xls", data)
    assert not list(tmp_path.iterdir())
