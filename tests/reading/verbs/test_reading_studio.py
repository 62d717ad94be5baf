"""The studio: what its verb prints, and the numbers of its page turned back to SI."""

import dataclasses
import json
import math
import re
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from expectations import reads
from reading_tables import html_tables
from reading_units import assert_reads

import prsm_jax.studio
from prsm_jax.cli import main
from prsm_jax.findings import StrengthCheck
from prsm_jax.geometry import Finding
from prsm_jax.studio import LimitReading, Numbers, Verdicts, _snippets, studio_variables
from prsm_jax.text import display_unit

_SMALL = Path(__file__).parents[2] / "studio" / "small_screw.toml"
_ADDRESS = "http://127.0.0.1:4711/token/"


@reads("verb", "studio")
def test_studio(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PRSM_JAX_CACHE", "")
    served = []

    def serve(session, *, port, told):
        served.append((session, port))
        told(_ADDRESS)

    monkeypatch.setattr(prsm_jax.studio, "serve", serve)
    verb = ["studio", str(_SMALL), "--port", "4711", "--set", "lead=9 mm", "--out", "mine"]
    assert main([*verb, "--no-browser"]) == 0
    assert capsys.readouterr().out.splitlines()[0] == _ADDRESS
    assert main([*verb, "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found == {"address": _ADDRESS, "folder": str(tmp_path / "mine")}
    session, port = served[-1]
    assert port == 4711
    assert float(session.original.stages[0].thread.lead) == 9e-3
    assert not list(tmp_path.iterdir())


def _numbers() -> Numbers:
    quantities = ("efficiency", "max_pressure", "rating_life_time[1]", "rating_life_time[2]")
    values = np.array([0.8765, 2.1234e9, 3456.0 * 3600, 4567.0 * 3600])
    changes = np.array(
        [[1.23e-3, -2.34e-4], [-4.56e7, 0.0], [1.5 * 3600, -2.5 * 3600], [7200.0, 3600.0]]
    )
    return Numbers(
        quantities,
        ("1", "Pa", "s", "s"),
        ("lead", "contact_angle"),
        {"lead": 9e-3, "contact_angle": 0.8},
        values,
        changes,
        changes / values[:, None],
        True,
    )


_VARIABLES = tuple(
    one
    for one in studio_variables(prsm_jax.load("wu2022"))
    if one.name in ("lead", "contact_angle")
)


def test_values_and_bars():
    numbers = _numbers()
    page = unescape(_snippets.numbers_html(numbers, _VARIABLES))
    blocks = page.split('<section class="quantity">')[1:]
    labels = (
        "efficiency",
        "max pressure",
        "rating life time, stage 1",
        "rating life time, stage 2",
    )
    for row, (block, label) in enumerate(zip(blocks, labels, strict=True)):
        unit, longest = numbers.units[row], np.abs(numbers.relative[row]).max()
        assert f"<h3>{label} " in block
        shown = re.search(r"<output[^>]*>(.*)</output>", block)
        assert shown is not None
        assert_reads(shown[1], (numbers.values[row], unit))
        changes = re.findall(r'class="change">(.*?)</span>', block)
        widths = [float(one) for one in re.findall(r"width:([\d.]+)%", block)]
        arrows = re.findall(r'class="arrow (?:up|down)">(.?)</span>', block)
        for column, text in enumerate(changes):
            change, share = numbers.changes[row, column], numbers.relative[row, column]
            if change == 0:
                assert (text, arrows[column], widths[column]) == ("no effect", "", 0)
                continue
            assert_reads(text, (change, unit, "coarse"))
            assert arrows[column] == ("▲" if change > 0 else "▼")
            # One decimal of a per cent.
            assert widths[column] == pytest.approx(100 * abs(share) / longest, abs=0.051)


def test_comparison():
    kept, now = _numbers(), _numbers()
    design = {"lead": 9.5e-3, "contact_angle": 0.8}
    values = now.values * [1.01, 1.0, 0.9, 1 + 1e-15]
    now = dataclasses.replace(now, design=design, values=values)
    ((_, (_, *rows)),) = html_tables(_snippets.comparison_html(kept, now, _VARIABLES))
    names = ["lead", "contact angle", "efficiency", "max pressure"]
    assert [row[0] for row in rows[:4]] == names
    assert_reads(rows[0][1], (9e-3, "m"))
    assert_reads(rows[0][2], (9.5e-3, "m"))
    assert_reads(rows[0][3].partition(" (")[0], (0.5e-3, "m", "coarse"))
    assert rows[0][3].endswith("(+5.56 %)")
    assert [rows[index][3] for index in (1, 3, 5)] == ["same"] * 3
    assert_reads(rows[2][3].partition(" (")[0], (0.01 * 0.8765, "1", "coarse"))
    assert rows[4][3].endswith("(−10.00 %)")


def test_status():
    checks = (
        StrengthCheck("buckling", 1, 4.25, 2.0, "1", False, 0.53, "1", "pass"),
        StrengthCheck("max_pressure", 0, 2.1e9, 1.9e9, "Pa", True, -0.105, "1", "fail"),
    )
    finding = Finding("backlash", "warning", 1, 1e-5, 0.0, "teeth <touch>")
    limits = (LimitReading("nut_radius[1]", "m", 15e-3, 14e-3, True, -1 / 14, "fail"),)
    page = _snippets.status_html(Verdicts(checks, (finding,), "fail"), limits, 1)
    assert 'class="status fail"' in page
    assert "teeth &lt;touch&gt;" in page
    (_, (_, limit)), (_, (_, *broken)) = html_tables(page)
    ((_, (_, *rows)),) = html_tables(_snippets.checks_html(checks, 1))
    assert limit[0] == "nut radius"
    assert_reads(limit[1], (15e-3, "m"))
    assert_reads(limit[2].removeprefix("at most "), (14e-3, "m"))
    assert_reads(limit[3], (-1 / 14, "1", "coarse"))
    assert [row[-1] for row in rows] == ["pass", "fail"]
    # In the box itself only what is broken.
    assert broken == rows[1:]
    assert_reads(rows[1][1], (2.1e9, "Pa"))
    assert_reads(rows[1][2].removeprefix("at most "), (1.9e9, "Pa"))
    assert_reads(rows[1][3], (-0.105, "1", "coarse"))
    assert "backlash" in page
    assert "backlash" not in _snippets.notes_html((finding,))
    # A limit of the file that is broken is a failure, whatever the checks say.
    page = _snippets.status_html(Verdicts(checks[:1], (), "pass"), limits, 1)
    assert 'class="status fail"' in page
    page = _snippets.status_html(Verdicts(checks[:1], (), "pass"), (), 1)
    assert 'class="status pass"' in page
    page = _snippets.status_html(Verdicts((), (), "no checks"), (), 1)
    assert 'class="status no-checks"' in page
    assert "No checks" in page


def test_units_of_the_controls():
    lead, angle = _VARIABLES
    assert (lead.unit, angle.unit) == (display_unit("m", 9e-3), display_unit("rad", 0.8))
    assert lead.shown(9e-3) == pytest.approx(9.0)
    assert angle.read(45.0) == pytest.approx(math.pi / 4, rel=1e-15)
