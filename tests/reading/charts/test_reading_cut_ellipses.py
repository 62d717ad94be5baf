"""Where flanks cut contact ellipses, one name has one number: in JSON, terminal and report."""

import dataclasses

import numpy as np
import pytest
from reading_figures import Chart
from reading_tables import assert_cell
from reading_units import assert_reads

import prsm_jax as prsm
from prsm_jax.report import Change, Optimisation, analyse, contact_pictures
from prsm_jax.report.document import _contact_pictures
from prsm_jax.report.document._sections import report_sections

#: Pitch 0.8 mm with flanks of 0.2 pitches on either side of the contact, at a high load.
_FILE = """
title = "cut"

[operating_point]
speed = "100 rpm"
load = "90 kN"

[[stage]]
roller_count = 10
engaged_threads = 10
curvature = "wu2022"

[stage.thread]
lead = "4 mm"
starts = 5
roller_radius = "5 mm"
contact_angle = "45 deg"
screw_addendum = "0.16 mm"
roller_addendum = "0.16 mm"

[stage.material]
youngs_modulus = "210 GPa"
poisson_ratio = 0.3

[stage.screw]
bore_radius = "4 mm"

[stage.nut]
wall_thickness = "10 mm"

[stage.load_sharing]
thread_count = 10
"""
_NAMES = ("max_pressure", "max_pressure_screw", "max_pressure_nut", "max_pressure_shared")


@pytest.fixture
def found(run, tmp_path):
    """The JSON of `prsm contact`, what it prints, the report's data, quantities."""
    path = tmp_path / "cut.toml"
    path.write_text(_FILE)
    mechanism = prsm.load(path)
    lighter = prsm.set_parameter(mechanism, "operating_point.load", 80e3)
    json, printed = run("contact", path)
    values = [prsm.compute(m, list(_NAMES)) for m in (mechanism, lighter)]
    data = analyse(mechanism, improved=lighter, transient=False)
    mass = Change("mass", "kg", 1.0, 0.9)
    made_up = Optimisation("mass", "kg", (1.0, 0.9), (), (mass,), (), converged=True)
    data = dataclasses.replace(data, optimisation=made_up)
    return (
        json["stages"][0],
        printed,
        data,
        [{k: np.ravel(v) for k, v in one.items()} for one in values],
    )


def test_same_pressures(found, monkeypatch):
    stage, printed, data, (values, after) = found
    sharing = stage["load_sharing"]
    whole = [stage[side]["whole_ellipse_max_pressure_pa"] for side in ("screw", "nut")]
    cut = [stage[side]["max_pressure_pa"] for side in ("screw", "nut")]
    # Cut deep enough for no table to round the difference away.
    assert min(np.divide(cut, whole)) > 1.05
    assert sharing["max_pressure_pa"] > 1.05 * sharing["whole_ellipse_max_pressure_pa"]

    # JSON: as the quantities of Python.
    np.testing.assert_allclose(cut[0], values["max_pressure_screw"][0], rtol=1e-12)
    np.testing.assert_allclose(cut[1], values["max_pressure_nut"][0], rtol=1e-12)
    shared = values["max_pressure_shared"][0]
    np.testing.assert_allclose(sharing["max_pressure_pa"], shared, rtol=1e-12)
    of_threads = [sharing[side]["thread_pressure_pa"] for side in ("screw", "nut")]
    np.testing.assert_allclose(np.max(of_threads), shared, rtol=1e-12)

    # Terminal.
    pressures = [
        (f"1 {side}", p, w) for side, p, w in zip(("screw", "nut"), cut, whole, strict=True)
    ]
    heads = printed.row("stage side")
    for name, p, w in pressures:
        cells = dict(zip(heads, printed.row(name), strict=True))
        assert float(cells["p₀ MPa"]) == pytest.approx(1e-6 * p, rel=1e-5)
        assert float(cells["p₀ of the whole ellipse MPa"]) == pytest.approx(1e-6 * w, rel=1e-5)
    start = "stage 1: load sharing, largest pressure"
    printed.line(start, shared, "Pa")
    printed.line(f"{start} of a whole ellipse", sharing["whole_ellipse_max_pressure_pa"], "Pa")

    # Report.
    sections = {section.anchor: section for section in report_sections(data)}
    (words,) = (w for w in sections["summary"].paragraphs if "contact pressure" in w)
    load = data.mechanism.operating_point.load
    assert_reads(words, (load, "N"), (shared, "Pa"), (max(cut), "Pa"))
    (table,) = sections["contact"].tables
    for row, p, w in zip(table.rows, cut, whole, strict=True):
        cells = dict(zip(table.head, row, strict=True))
        assert_cell(cells["p₀ in MPa"], (p, "Pa"), "p₀ in MPa")
        assert_cell(cells["p₀ of the whole ellipse in MPa"], (w, "Pa"), "p₀ in MPa")
    shares = {row[0]: row[1] for row in sections["load_sharing"].tables[0].rows}
    assert_cell(shares["largest pressure"], (shared, "Pa"))
    of_whole = sharing["whole_ellipse_max_pressure_pa"], "Pa"
    assert_cell(shares["largest pressure of a whole ellipse"], of_whole)
    _, quantities = sections["optimisation"].tables
    (row,) = (row for row in quantities.rows if row[0] == "max pressure")
    assert_cell(row[1], (max(cut), "Pa"))
    assert_cell(row[2], (after["max_pressure"][0], "Pa"))

    # Picture: before and after, screw and nut.
    (picture,) = (p for p in sections["contact"].pictures if p.name == "contact_ellipses")
    chart = Chart(picture.draw())
    panels = [a for a in chart.axes if a.get_label() != "<colorbar>"]
    expected = [
        one[f"max_pressure_{side}"][0] for one in (values, after) for side in ("screw", "nut")
    ]
    for axes, value in zip(panels, expected, strict=True):
        p0 = chart.text("along the major axis in", place=axes).split("\n")[1].partition(",")[0]
        assert_reads(p0, (value, "Pa"))

    # The same picture of the verb `contact`.
    alone = dataclasses.replace(data.mechanism.stages[0], load_sharing=None)
    mechanism = dataclasses.replace(data.mechanism, stages=(alone,))
    monkeypatch.setattr(_contact_pictures, "_true_flanks", lambda *_: {})
    monkeypatch.setattr(_contact_pictures, "subsurface_chart", lambda *_: None)
    figure = contact_pictures(mechanism)["contact-ellipses"]
    labels = [axes.get_xlabel() for axes in figure.axes if axes.get_xlabel()]
    for words, p, w in zip(labels, cut, whole, strict=True):
        first, last = words.split("\n")[1:]
        assert_reads(first.partition(",")[0], (p, "Pa"))
        assert_reads(last, (w, "Pa"))
