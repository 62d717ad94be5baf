"""The report names what its numbers rest on next to them, in HTML and in Markdown."""

import dataclasses
import html
import re

import prsm_jax as prsm
from prsm_jax.report import write_report
from prsm_jax.text._plain_text import markdown as escaped


def _section(text, heading, marker):
    """The text of one section of a report."""
    start = text.index(heading)
    end = text.find(marker, start + len(heading))
    return text[start:end]


def test_sentences_stand_beneath_the_numbers_that_rest_on_them(data, tmp_path):
    # Wu's mechanism as if its stiffnesses had been derived and nothing been said on sharing.
    stage = dataclasses.replace(data.mechanism.stages[0], stiffness=None, sharing="unstated")
    mechanism = dataclasses.replace(data.mechanism, stages=(stage,))
    path = write_report(tmp_path / "out", dataclasses.replace(data, mechanism=mechanism), dpi=60)
    page, markdown = path.read_text(), (path.parent / "report.md").read_text()
    for title, names in (
        ("Thread contact", ["max_pressure"]),
        ("Vibration", ["natural_frequencies"]),
        ("In short", ["max_pressure", "efficiency"]),
    ):
        expected = prsm.assumptions(mechanism, names)
        assert expected
        in_html = html.unescape(_section(page, f"<h2>{title}</h2>", "</section>"))
        in_markdown = _section(markdown, f"\n## {title}\n", "\n## ")
        for sentence in expected:
            assert in_html.count(f"<li>{sentence}</li>") == 1
            assert in_markdown.count(f"\n* {escaped(sentence)}\n") == 1
    assert "rest on" not in _section(page, "<h2>Mechanism</h2>", "</section>")
    # Coulomb friction of the threads needs no contact ellipses.
    assert not re.search("rest on", _section(page, "<h2>Steady state</h2>", "</section>"))
