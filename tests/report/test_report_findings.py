"""Both designs' findings, and an optimisation without a feasible design, on the written page."""

import dataclasses

import pytest

from prsm_jax.geometry import Finding
from prsm_jax.report import _write, write_report

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
    message = "no feasible design found; the least violation leaves backlash = -8 µm"
    html, markdown = pages(feasible=False, converged=False, message=message)
    words = "No feasible design: the least violation leaves backlash = -8 µm."
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
