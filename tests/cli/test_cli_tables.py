"""Tables of the terminal: nothing is lost at any width, and units are an engineer's."""

import re

import pint
import pytest

from prsm_jax.cli._tables import in_units
from prsm_jax.text._text_table import TextTable
from tests import scenes
from tests.report.report_scenes import make_optimum

TABLE = TextTable(
    "Some quantities and what they mean, in a title that is longer than a narrow line",
    ("name", "value N/µm", "longer heading of numbers", "verdict", "description"),
    [
        ("axial_stiffness", 1234.5678, 1.25e9, "pass", "force by travel of the nut, both sides"),
        ("mass", None, -3.0, "warning", "all bodies together"),
    ],
)


@pytest.mark.parametrize("width", [None, 200, 120, 80, 60, 40])
def test_a_table_loses_nothing_at_any_width(width):
    text = TABLE.text(width)
    if width is not None:
        assert max(map(len, text.splitlines())) <= width
    # Numbers are never broken, words only at spaces.
    words = set(text.split())
    assert words >= {"1234.57", "1.25e+09", "-3", "–", "pass", "warning", "axial_stiffness"}
    assert words >= {"force", "by", "travel", "of", "the", "nut,", "both", "sides", "bodies"}
    assert words >= {"N/µm", "longer", "heading", "numbers", "narrow"}
    # Once for each part; parts repeat the first column and nothing else.
    assert text.count("1234.57") == text.count("1.25e+09") == 1


def test_numbers_are_right_aligned_and_words_left():
    lines = TextTable("", ("a", "b"), [("x", 1.0), ("long", 100.0)]).text().splitlines()
    assert lines[2:] == ["x       1", "long  100"]


def test_zero_has_no_sign():
    lines = TextTable("", ("a", "b"), [("x", -0.0), ("y", -0.5)]).text().splitlines()
    assert lines[2:] == ["x     0", "y  -0.5"]


def test_markdown_has_the_same_cells():
    text = TABLE.markdown()
    assert "| axial_stiffness | 1234.57 | 1.25e+09 | pass | force by travel" in text
    assert "| mass | – | -3 |" in text


def test_lines_are_in_the_units_that_an_engineer_reads():
    ureg = pint.UnitRegistry()
    lines = [
        ("length", 0.0123, "m"),
        ("pressure", 2.1e9, "Pa"),
        ("stiffness", -3.2e8, "N/m"),
        ("speed", 157.0, "rad/s"),
        ("efficiency", 0.85, "1", "efficiency"),
        ("nothing", None, "N"),
    ]
    rows = {words: (value, unit) for words, value, unit in in_units(lines)}
    for words, unit, si, value in (
        ("length", "mm", "m", 0.0123),
        ("pressure", "MPa", "Pa", 2.1e9),
        ("stiffness", "N/µm", "N/m", -3.2e8),
        ("speed", "rpm", "rad/s", 157.0),
    ):
        expected = ureg.Quantity(value, si).to(unit).magnitude
        assert rows[words] == (pytest.approx(expected, rel=1e-12), unit)
    assert rows["efficiency"] == (85.0, "%")
    assert rows["nothing"][0] is None


@pytest.mark.parametrize(
    "verb",
    [
        *("check", "contact", "modal", "response", "campbell", "steady", "simulate"),
        *("sensitivity", "strength"),
    ],
)
def test_the_terminal_is_filled_and_not_overrun(prsm, monkeypatch, verb):
    words = ["--quantities", "efficiency,max_pressure"] if verb == "sensitivity" else []
    for columns in ("60", "80", "132"):
        monkeypatch.setenv("COLUMNS", columns)
        status, out, err = prsm(verb, "wu2022", *words)
        assert (status, err) == (0, "")
        assert max(map(len, out.splitlines())) <= int(columns)


@pytest.mark.parametrize("columns", [60, 80])
def test_the_table_of_an_optimisation_fits(columns):
    """As `optimise` and `demo` print it; in a mechanism's own units, and with its findings."""
    best = make_optimum(scenes.example("actuator"))
    lines = best.text(columns).splitlines()
    assert max(map(len, lines)) <= columns
    assert any("max_pressure" in line for line in lines)


def test_the_catalogue_and_the_published_numbers_fit_80_columns(prsm, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    for words in (["quantities"], ["validate", "lin_parker1999"]):
        status, out, err = prsm(*words)
        assert (status, err) == (0, "")
        assert max(map(len, out.splitlines())) <= 80


def _row(text, start):
    (line,) = [line for line in text.splitlines() if line.startswith(start)]
    return [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e[+-]\d+)?", line)]


def test_sensitivities_are_per_millimetre_and_per_degree(prsm, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    words = ("--quantities", "max_pressure,axial_stiffness,efficiency")
    parameters = ("--parameters", "lead,contact_angle")
    _, out, _ = prsm("sensitivity", "wu2022", *words, *parameters)
    import prsm_jax

    table = prsm_jax.sensitivity(
        scenes.example("wu2022"),
        ["max_pressure", "axial_stiffness", "efficiency"],
        ["lead", "contact_angle"],
    )
    ureg = pint.UnitRegistry()
    for i, (name, si, shown) in enumerate(
        (("max_pressure", "Pa", "MPa"), ("axial_stiffness", "N/m", "N/µm"), ("efficiency", "", "%"))
    ):
        by = [
            ureg.Quantity(float(table.gradient[i, 0]), f"({si or 1}) / m").to(
                f"({shown or 1}) / mm" if shown != "%" else "1/mm"
            ),
            ureg.Quantity(float(table.gradient[i, 1]), f"({si or 1}) / rad").to(
                f"({shown or 1}) / deg" if shown != "%" else "1/deg"
            ),
        ]
        scale = 100 if shown == "%" else 1
        expected = [scale * quantity.magnitude for quantity in by]
        assert _row(out, f"{name} [{shown}]")[1:] == pytest.approx(expected, rel=1e-5)
