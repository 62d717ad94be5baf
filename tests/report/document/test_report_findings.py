"""Both designs' findings, and an optimisation without a feasible design, on the written page."""

import dataclasses

import pytest
from report_scenes import make_optimum

from prsm_jax.geometry import Finding
from prsm_jax.optimisation import ConstraintReport
from prsm_jax.report import summarise_optimisation, write_report
from prsm_jax.report.document import _write
from prsm_jax.report.document._section import Table

_START = Finding("buckling", "warning", 1, 1.2, 2.0, "the screw is slender")
_END = Finding("backlash", "error", 1, -8e-6, 0.0, "teeth interfere by 8 µm")


@pytest.fixture
def pages(data, optimisation, tmp_path, monkeypatch):
    """HTML and Markdown of a report with findings of both designs, with no picture drawn."""
    monkeypatch.setattr(
        _write,
        "_draw",
        lambda sections, *_: {p.name: "data:," for s in sections for p in s.pictures},
    )

    def write(**changes):
        found = dataclasses.replace(optimisation, **changes)
        after = dataclasses.replace(data, findings=(_END,))
        both = dataclasses.replace(data, findings=(_START,), optimisation=found, improved=after)
        path = write_report(tmp_path / "out", both)
        return path.read_text(), (path.parent / "report.md").read_text()

    return write


def test_findings_of_both_designs_stand_before_drawings_and_tables(pages):
    html, markdown = pages()
    for page, picture, dimensions in (
        (html, "<img", "<caption>Mechanism</caption>"),
        (markdown, "![", "**Mechanism**"),
    ):
        last = max(page.index(one.message) for one in (_START, _END))
        assert last < page.index(picture)
        assert last < page.index(dimensions)
        for name in ("Findings: start", "Findings: optimum"):
            assert page.index(name) < last
        assert "backlash (error)" in page[: page.index("Findings: start")]


def test_no_feasible_design_is_the_first_sentence(pages):
    message = "no feasible design found; the design of least violation has backlash = -8 µm"
    html, markdown = pages(feasible=False, converged=False, message=message)
    words = "No feasible design: the design of least violation has backlash = -8 µm."
    assert html.index("<p>") == html.index(f"<p>{words}</p>")
    assert markdown.partition("## In short")[2].strip().startswith(words)
    for page in (html, markdown):
        assert "Findings: best found" in page
        assert "after the optimisation" not in page


def test_long_cells_are_broken_and_numbers_are_not(pages):
    """What stays with a design variable is a line of names; a number is never broken."""
    html, _ = pages()
    table = html[html.index("<caption>Design variables</caption>") :].split("</table>")[0]
    cells = table.split("<td")[1:]
    long = [cell for cell in cells if len(cell.split("</td>")[0].partition(">")[2]) > 40]
    assert long
    assert all(cell.startswith(' class="words"') for cell in long)
    assert not [cell for cell in cells if cell not in long and "words" in cell]


def test_what_check_keeps_the_optimum_from_is_named_as_a_limit(wu2022):
    """A margin at its limit limits the design like a constraint; others are not mentioned."""
    optimum = make_optimum(wu2022)

    def margin(name, value, active):
        return ConstraintReport(name, "m", value, 1e-6, None, None, 1e-6, active, True, 250.0)

    margins = margin("backlash (stage 1)", 1e-6, True), margin("bore (stage 1)", 4e-3, False)
    start = dataclasses.replace(
        optimum.start, margins={"backlash (stage 1)": 55e-6, "bore (stage 1)": 3e-3}
    )
    found = summarise_optimisation(dataclasses.replace(optimum, start=start, margins=margins))
    assert "check: backlash (stage 1) at 1.000\N{NARROW NO-BREAK SPACE}µm" in found.in_a_sentence()
    limit = found.limits[-1]
    assert (limit.quantity, limit.value, limit.limit) == ("check: backlash (stage 1)", 1e-6, 1e-6)
    assert (limit.sense, limit.active, limit.use) == ("lower", True, 1.0)
    assert (found.quantities[-1].before, found.quantities[-1].after) == (55e-6, 1e-6)
    assert not [one for one in (*found.limits, *found.quantities) if "bore" in str(one)]


def test_a_sentence_that_begins_with_a_number_stands_on_the_left():
    sentences = ("90 ring gear teeth are not divisible by 11 rollers: each roller must be turned",)
    table = Table("", ("check", "message", "value"), (("gear assembly", *sentences, "2.5 MPa"),))
    assert table.text_columns == (0, 1)


def test_names_of_checks_are_not_broken(pages):
    html, _ = pages()
    rule = "#findings td:not(:last-child) { overflow-wrap: normal; white-space: nowrap; }"
    assert rule in html
    # The message is last.
    table = html[html.index('id="findings"') :].split("</table>")[0]
    assert table.rindex('class="text">message</th>') > table.rindex(">check</th>")


def test_words_stand_on_the_left_and_numbers_on_the_right(pages):
    html, markdown = pages()
    assert "| severity | check | message |\n|---|---|---|\n| warning |" in markdown
    assert '<th scope="col" class="text">message</th>' in html
    assert "| quantity | before | after | change |\n|---|---:|---:|---:|\n" in markdown
