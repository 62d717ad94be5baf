"""A fault costs its section, which is named at the top; the rest of the report is there."""

import dataclasses
import re

import pytest

from prsm_jax.report import ReportData, analyse, write_report
from prsm_jax.report.document import _analysis_sections, _sections
from prsm_jax.report.results import _analyse


def _fails(*_, **__):
    raise ZeroDivisionError("by <nothing> | at all")


@pytest.fixture
def written(data, tmp_path, monkeypatch):
    """Writes a report of few pictures; HTML, Markdown and what was told of faults."""
    monkeypatch.setattr(_sections, "mechanism_section", lambda _: None)
    told = []

    def write(report=None):
        some = dataclasses.replace(data, modes=None, meshings=None, contacts=None)
        path = write_report(tmp_path / "out", report or some, dpi=40, on_fault=told.append)
        return path.read_text(), (path.parent / "report.md").read_text(), told

    return write


def test_a_section_that_cannot_be_made(written, monkeypatch):
    monkeypatch.setattr(_sections, "steady_section", _fails)
    html, markdown, told = written()
    words = "The section is missing: ZeroDivisionError: by <nothing> | at all"
    assert told == [f"Steady state: {words}"]
    assert html.index("not complete") < html.index("Steady state: The section") < html.index("<h2>")
    assert html.count("by &lt;nothing&gt; | at all") == 2
    assert r"by \<nothing\> \| at all" in markdown
    # All the other sections are there.
    for title in ("In short", "Findings", "Provenance"):
        assert f"<h2>{title}</h2>" in html


def test_a_picture_that_cannot_be_drawn(written, monkeypatch, tmp_path):
    monkeypatch.setattr(_analysis_sections, "loss_chart", _fails)
    html, markdown, told = written()
    assert told == [
        "Steady state: The picture losses is missing: ZeroDivisionError: by <nothing> | at all"
    ]
    # The numbers of its section, and its other picture, are there.
    section = html[html.index('<section id="steady">') :].split("</section>")[0]
    assert "<table>" in section
    assert len(re.findall("<img", section)) == 1
    assert "Figure 1." in section
    assert not list((tmp_path / "out" / "figures").glob("losses.*"))
    assert "losses.png" not in markdown


def test_an_analysis_that_fails(wu2022, written, monkeypatch):
    names = ("_all_modes", "_strength", "_shared", "_contacts", "_steady_states")
    for name in (*names, "margin_numbers"):
        monkeypatch.setattr(_analyse, name, _fails)
    data = analyse(wu2022, transient=False)
    assert {part for part, _ in data.faults} == {
        *("checks", "contact", "vibration", "steady state", "strength", "load sharing"),
    }
    # What a file has no data for is no fault.
    assert not {part for part, _ in data.left_out} & {part for part, _ in data.faults}
    html, _, told = written(data)
    assert len(told) == 6
    assert "The checks could not be made." in html
    assert "found no errors" not in html


def test_a_fault_is_a_warning_where_nobody_listens(wu2022, tmp_path, monkeypatch):
    monkeypatch.setattr(_sections, "mechanism_section", _fails)
    with pytest.warns(UserWarning, match="Mechanism: The section is missing: ZeroDivisionError"):
        write_report(tmp_path / "out", ReportData(mechanism=wu2022, title="x"), dpi=40)


def test_no_fault_no_word(written):
    html, markdown, told = written()
    assert told == []
    for page in (html.split("</style>")[1], markdown):
        assert "fault" not in page
