"""A study: its pictures, its tables, the report, and the JSON of its verb."""

import dataclasses
import hashlib
import json
import math
import shlex

import numpy as np
import pytest
from expectations import reads
from reading_artists import box_of, x_data
from reading_figures import Chart, handles
from reading_tables import assert_json, assert_table, html_tables, without_words
from study_scene import DRIVERS, SENSES, SIZES, UNITS, made

from prsm_jax import file
from prsm_jax.report import (
    conflict_maps,
    front_gradient_chart,
    origin_of_file,
    study_maps,
    study_sections,
    variant_changes,
    variant_fronts,
    write_study,
)
from prsm_jax.report.document import _study_sections

NAMES = [one.name for one in DRIVERS]
PAIRS = [(0, 1), (0, 2), (1, 2)]
#: Values of the drivers in the map nearest to those of the present design.
NEAREST = (1, 1, 1)


@pytest.fixture(scope="module")
def study():
    return made("efficiency", "nut_outer_diameter")


def _cut(values, pair):
    place = [slice(None) if i in pair else NEAREST[i] for i in range(3)]
    return values[tuple(place)]


def _of_unit(name):
    return {"contact_angle": "rad"}.get(name, "m")


def _dressed(chart, axes, study, pair):
    """Dots at designs that are not allowed, and the square of the present one."""
    units = [_of_unit(NAMES[i]) for i in pair]
    dots, front, square = chart.lines(axes)
    allowed = _cut(study.map.allowed, pair)
    x, y = (study.map.coordinates[NAMES[i]] for i in pair)
    places = [(x[i], y[j]) for j in range(len(y)) for i in range(len(x)) if not allowed[i, j]]
    chart.curve(axes, dots, *np.transpose(places), units)
    found = [[one.variables[NAMES[i]] for one in study.front.points] for i in pair]
    chart.curve(axes, front, *found, units)
    chart.curve(axes, square, *([DRIVERS[i].present] for i in pair), units)


def _filled(axes, chart, cut, x, y, convert):
    """The colour at each design is that of its value."""
    from matplotlib.contour import ContourSet

    sets = [one for one in axes.collections if isinstance(one, ContourSet)]
    filled = next(one for one in sets if one.filled)
    levels = convert(np.asarray(filled.levels))
    for i, j in np.argwhere(np.isfinite(cut)):
        band = int(np.searchsorted(levels, cut[i, j])) - 1
        path = filled.get_paths()[band]
        # The corner of the grid lies on the edge of the band: a little inside of it.
        inside = tuple(float(v[k] + 1e-6 * (v.mean() - v[k])) for v, k in ((x, i), (y, j)))
        near = min(abs(levels - cut[i, j])) < 1e-4 * np.ptp(levels)
        assert near or path.contains_point((inside[0], inside[1]), radius=1e-6), (i, j, cut[i, j])
    chart.take(*axes.collections)


@reads("chart", "study_maps")
def test_maps(study):
    chart = Chart(study_maps(study))
    panels = [one for one in chart.axes if one.get_xlabel()]
    bars = [one for one in chart.axes if one not in panels]
    assert len(panels) == 9
    for row, name in enumerate(SENSES):
        label = bars[row].get_ylabel()
        assert label.endswith(f"\n({SENSES[name]})")
        unit = label.partition("\n")[0].rpartition(" in ")[2]
        factor = {"%": 100.0, "mm": 1e3, "kg": 1.0}[unit]
        for axes, pair in zip(panels[3 * row :], PAIRS, strict=False):
            scales = [{"m": 1e3, "rad": 180 / math.pi}[_of_unit(NAMES[i])] for i in pair]
            x, y = (
                scale * study.map.coordinates[NAMES[i]]
                for i, scale in zip(pair, scales, strict=True)
            )
            cut = _cut(study.map.values[name], pair)
            _filled(axes, chart, cut, x, y, lambda levels, factor=factor: levels / factor)
            _dressed(chart, axes, study, pair)
    for third, unit in ((2, "m"), (1, "rad"), (0, "m")):
        value = study.map.coordinates[NAMES[third]][NEAREST[third]]
        chart.says(f"at {NAMES[third].replace('_', ' ')} ", (value, unit))
    for bar in bars:
        chart.take(*bar.collections)
    assert handles(chart.figure) == [
        "breaks a limit, or error of prsm check",
        "front, projected",
        "present design",
    ]
    chart.finish()


def test_maps_of_one_value_end_where_the_ranges_end(study):
    """A row of a constant quantity has the axes of the rows with contours."""
    constant = dict(study.map.values, mass=np.where(study.map.usable, 1.5, np.nan))
    one_mass = dataclasses.replace(study.map, values=constant)
    figure = study_maps(dataclasses.replace(study, map=one_mass))
    panels = [one for one in figure.axes if one.get_xlabel()]
    for number, axes in enumerate(panels):
        for i, limits in zip(PAIRS[number % 3], (axes.get_xlim(), axes.get_ylim()), strict=True):
            scale = {"m": 1e3, "rad": 180 / math.pi}[_of_unit(NAMES[i])]
            ends = [scale * DRIVERS[i].lower, scale * DRIVERS[i].upper]
            assert limits == pytest.approx(ends, rel=1e-12), (number, NAMES[i])
    figure.draw_without_rendering()
    colours = [one.collections[0].get_facecolor()[-1] for one in panels[6:]]
    assert colours == [pytest.approx(colours[0])] * 3, "the colour bar is that of all three"


def test_maps_without_a_refused_design(study):
    """Nothing is marked, and the panels fill the page."""
    shape = study.map.allowed.shape
    nothing = {name: np.zeros(shape) for name in study.map.violations}
    allowed = dataclasses.replace(study.map, usable=np.ones(shape, bool), violations=nothing)
    assert allowed.allowed.all()
    for draw in (study_maps, conflict_maps):
        figure = draw(dataclasses.replace(study, map=allowed))
        assert handles(figure) == ["front, projected", "present design"]
        rows = {round(one.get_position().y0, 6): one for one in figure.axes if one.get_xlabel()}
        heights = [one.get_position().height for one in rows.values()]
        assert sum(heights) > 0.5, heights


def test_designs_that_fail_are_crosses_with_a_number(study):
    """Not dots of broken limits; the number is that of the whole map, as in the sentence."""
    usable = study.map.usable.copy()
    usable[NEAREST] = False
    values = {name: np.where(usable, one, np.nan) for name, one in study.map.values.items()}
    reasons = {"overlapping_rollers": 1, "no_meshing": 1}
    grid = dataclasses.replace(study.map, usable=usable, values=values, reasons=reasons)
    changed = dataclasses.replace(study, map=grid)
    for draw in (study_maps, conflict_maps):
        chart = Chart(draw(changed))
        panels = [one for one in chart.axes if one.get_xlabel()]
        for number, axes in enumerate(panels):
            pair = PAIRS[number % 3]
            cross, dots, *_ = chart.lines(axes)
            assert cross.get_marker() == "x"
            x, y = ([study.map.coordinates[NAMES[i]][NEAREST[i]]] for i in pair)
            chart.curve(axes, cross, x, y, [_of_unit(NAMES[i]) for i in pair])
            refused = _cut(~grid.allowed & usable, pair)
            assert len(np.asarray(dots.get_xdata())) == refused.sum()
        assert handles(chart.figure)[0] == f"failed: 2 of {usable.size} designs of the map"
    sentence = changed.sentences()["drivers"][0]
    assert "2 fail (overlapping rollers 1, no meshing 1), prsm check finds errors" in sentence


@reads("chart", "conflict_maps")
@pytest.mark.parametrize("limits", [False, True])
def test_conflict_maps(study, limits):
    chart = Chart(conflict_maps(study, limits))
    panels = [one for one in chart.axes if one.get_xlabel()]
    (bar,) = [one for one in chart.axes if one not in panels]
    assert bar.get_ylabel() == "cosine: −1 conflict, +1 agreement"
    wanted = [one for one in study.conflicts if one.limit == limits]
    pairs = [(0, 2)] if limits else PAIRS
    if limits:
        wanted = wanted[:2]
    assert len(panels) == len(wanted) * len(pairs)
    for number, axes in enumerate(panels):
        one, pair = wanted[number // len(pairs)], pairs[number % len(pairs)]
        words = f"{one.first} against {one.second}".replace("_", " ")
        assert axes.get_title("left").replace("\n", " ") == words
        scales = [{"m": 1e3, "rad": 180 / math.pi}[_of_unit(NAMES[i])] for i in pair]
        x, y = (s * study.map.coordinates[NAMES[i]] for i, s in zip(pair, scales, strict=True))
        _filled(axes, chart, _cut(one.cosine, pair), x, y, lambda levels: levels)
        _dressed(chart, axes, study, pair)
    chart.take(*bar.collections, bar.yaxis.label)
    chart.finish()


@reads("chart", "front_gradient_chart")
@pytest.mark.parametrize(
    "objectives",
    [("efficiency", "nut_outer_diameter"), ("efficiency", "nut_outer_diameter", "mass")],
)
def test_front_with_arrows(objectives):
    from matplotlib.quiver import Quiver
    from matplotlib.text import Annotation

    study = made(*objectives)
    chart = Chart(front_gradient_chart(study))
    planes = [(0, 1)] if len(objectives) == 2 else PAIRS
    legend = handles(chart.figure)
    steps = {words.partition(" % more ")[2]: words.partition(" ")[0] for words in legend}
    for axes, plane in zip(chart.axes, planes, strict=True):
        x, y = (objectives[i] for i in plane)
        units = UNITS[x], UNITS[y]
        values = study.designs.values
        if len(objectives) == 2:
            chart.curve(axes, chart.lines(axes)[0], values[x][1:], values[y][1:], units)
        points, square = chart.lines(axes)
        chart.curve(axes, points, values[x][1:], values[y][1:], units)
        chart.curve(axes, square, values[x][:1], values[y][:1], units)
        arrows = [one for one in axes.collections if isinstance(one, Quiver)]
        assert len(arrows) == 3
        for index, (driver, one) in enumerate(zip(DRIVERS, arrows, strict=True)):
            step = float(steps[driver.name.replace("_", " ")]) / 100
            for way, name, moved in (("x", x, one.U), ("y", y, one.V)):
                change = chart.si(axes, way, np.asarray(moved), UNITS[name])
                wanted = values[name] * study.designs.elasticities[name][:, index] * step
                np.testing.assert_allclose(change, wanted[1:], rtol=1e-9)
            chart.take(one)
        assert f"({SENSES[x]})" in axes.get_xlabel()
        assert f"({SENSES[y]})" in axes.get_ylabel()
        # Points by their numbers, where they are not too near to each other.
        for text in axes.findobj(Annotation):
            place = int(text.get_text())
            at = [values[x][place], values[y][place]]
            for way, value, name, found in zip("xy", at, (x, y), text.xy, strict=True):
                assert chart.si(axes, way, found, UNITS[name]) == pytest.approx(value)
            chart.take(text)
    # The legend gives the step, which was read above.
    chart.ignore(text for one in chart.figure.legends for text in one.texts)
    chart.finish()


@reads("chart", "variant_changes")
def test_changes(study):
    chart = Chart(variant_changes(study))
    spin = study.variants[0]
    for axes, name in zip(chart.axes, SENSES, strict=True):
        assert axes.get_xlabel().replace("\n", " ") == f"{_words(name)}: change in %"
        change = 100 * spin.changes[name]
        (bar,) = axes.patches
        assert box_of(bar).get_width() == pytest.approx(change[0])
        chart.take(bar)
        span, zero = chart.lines(axes)
        np.testing.assert_allclose(x_data(span), [change[1:].min(), change[1:].max()])
        assert list(x_data(zero)) == [0, 0]
        chart.take(span, zero)
    assert chart.ticks(chart.axes[0]) == ["without spin"]
    assert handles(chart.figure) == ["front", "present design"]
    chart.finish()


@reads("chart", "variant_fronts")
def test_other_fronts(study):
    chart = Chart(variant_fronts(study))
    (axes,) = chart.axes
    x, y = study.problem.objectives
    units = UNITS[x], UNITS[y]
    spin = study.variants[0]
    front, alone, allowed, refused, *shapes = chart.lines(axes)
    # For the legend alone: every variant has its own colour.
    assert [(one.get_marker(), len(x_data(one))) for one in shapes] == [("o", 0), ("x", 0)]
    chart.take(*shapes)
    chart.curve(axes, front, study.designs.values[x][1:], study.designs.values[y][1:], units)
    chart.curve(axes, alone, spin.front.values[:, 0], spin.front.values[:, 1], units)
    full = spin.complete
    chart.curve(axes, allowed, full[x][[0, 2]], full[y][[0, 2]], units)
    chart.curve(axes, refused, full[x][[1]], full[y][[1]], units)
    assert refused.get_marker() == "x"
    assert handles(chart.figure) == [
        "complete physics",
        "without spin",
        "the same designs with complete physics",
        "those that break a limit then",
    ]
    chart.finish()


def _tables(study):
    found = {}
    for section in study_sections(study, "prsm study x"):
        for table in section.tables:
            found[table.caption] = table
    return found


def _words(name):
    return name.replace("_", " ")


def _four_digits(*values):
    """Cells of a report, rounded once from the values themselves."""
    return tuple(f"{value:#.4g}".replace("-", "−") for value in values)


def test_the_report_has_operating_point_and_origin(study):
    """Speed and load of all designs, unless they are drivers, and the provenance of any report."""
    drivers = study_sections(study)[1]
    speed, load = 100.0, 7e3
    rows = [("screw speed", (speed, "rad/s")), ("axial load", (load, "N"))]
    assert_table(drivers.tables[0], ("", ""), rows)
    assert drivers.tables[0].rows == (
        ("screw speed", "954.9\N{NARROW NO-BREAK SPACE}rpm"),
        ("axial load", "7.000\N{NARROW NO-BREAK SPACE}kN"),
    )
    over_load = (dataclasses.replace(DRIVERS[0], name="load"), *DRIVERS[1:])
    problem = dataclasses.replace(study.problem, drivers=over_load)
    (table,) = _study_sections._operating_point(dataclasses.replace(study, problem=problem))
    assert table.rows == (drivers.tables[0].rows[0], ("axial load", "a driver"))
    origin = origin_of_file("wu2022", settings=["load=3 kN"], author="A. Uthor", date="2026-11-29")
    section = study_sections(study, "prsm study x", source="wu2022", origin=origin)[-1]
    responsible, made = ({row[0]: row[1] for row in table.rows} for table in section.tables)
    assert (responsible["author"], responsible["date"]) == ("A. Uthor", "2026-11-29")
    assert made["mechanism from"] == "wu2022"
    digest = hashlib.sha256(file.example_text("wu2022").encode()).hexdigest()
    assert made["SHA-256 of this file"] == digest
    assert made["changed on the command line"] == "load=3 kN"
    assert made["command"] == "prsm study x"


def test_a_change_by_rounding_alone_is_none(study):
    """The report says 0, as its sentence says that the quantity is the same."""
    (spin, failed), values = study.variants, np.array([1e-17, 3e-12, -2e-13, 0.0])
    same = dataclasses.replace(spin, changes=dict(spin.changes, mass=values))
    changed = dataclasses.replace(study, variants=(same, failed))
    (_, _, row, *_) = _tables(changed)[
        "Relative change of quantities without a part of the physics, in %"
    ].rows
    assert row == ("spin", "mass", "0", "0", "0")
    assert "mass is the same" in changed.sentences()["variants"][0]


def test_tables_of_the_report(study):
    tables = _tables(study)
    rows = [
        (f"{_words(d.name)} in {'deg' if d.unit == 'rad' else 'mm'}",
         *((v, d.unit) for v in (d.present, d.lower, d.upper)), str(3 + i))
        for i, d in enumerate(DRIVERS)
    ]  # fmt: skip
    assert_table(tables["Drivers"], ("driver", "present", "from", "to", "values"), rows)
    shown = {"efficiency": "%", "nut_outer_diameter": "mm", "mass": "kg", "max_pressure": "MPa"}
    rows = [
        (
            f"{_words(name)} in {shown[name]}",
            *(
                (value, UNITS[name])
                for value in (
                    study.designs.values[name][0],
                    np.nanmin(study.map.values[name]),
                    np.nanmax(study.map.values[name]),
                )
            ),
            SENSES.get(name, ""),
            "<= 1600" if name == "max_pressure" else "",
        )
        for name in SIZES
    ]
    head = ("quantity", "present design", "smallest in the map", "largest in the map", "sense")
    assert_table(tables["Quantities"], (*head, "limit"), rows)
    caption = "Conflicts: cosine of the angle between elasticities, and share of designs below 0"
    for row, one in zip(tables[caption].rows, study.conflicts, strict=True):
        second = _words(one.second) + (" (limit)" if one.limit else "")
        assert row[:2] == (_words(one.first), second)
        shares = 100 * one.share, 100 * one.share_allowed
        assert row[2:] == _four_digits(one.present, *one.range, *shares)
    caption = (
        "Share of the map [%] in which more of a driver improves one quantity, worsens the other"
    )
    for row, one in zip(tables[caption].rows, study.conflicts, strict=True):
        assert row[2:] == _four_digits(*(100 * v for v in one.by_driver.values()))
    order = ["efficiency", "nut_outer_diameter", "mass"]
    rows = []
    for index in range(4):
        active = ("breaks max pressure", "", "max pressure", "max pressure, upper bound of lead")
        broken = study.designs.violations["max_pressure"][0] > 0
        words = {0: "breaks max pressure" if broken else "", 1: "max pressure"}.get(
            index, "max pressure, upper bound of lead"
        )
        assert words in active
        rows.append(
            (
                "present" if not index else str(index),
                *((study.designs.values[name][index], UNITS[name]) for name in order),
                *((study.designs.coordinates[d.name][index], d.unit) for d in DRIVERS),
                words,
            )
        )
    head = (
        *(f"{_words(name)} in {shown[name]}" for name in order),
        "lead in mm",
        "contact angle in deg",
        "roller radius in mm",
    )
    assert_table(tables["Front"], ("design", *head, "active limits"), rows)
    for row, one in zip(
        tables["Gradients on the front, relative, in % per %"].rows, study.gradients, strict=True
    ):
        wanted = [one.elasticities[n][d] for n in study.problem.objectives for d in NAMES]
        found = [float(cell.replace("−", "-")) for cell in row[1:]]
        assert found == pytest.approx([*wanted, one.exchange], abs=5.1e-4)
    said = tables["Changes by the gradient at each point"].rows
    assert [row[1] for row in said] == [one.sentence for one in study.gradients]
    spin = study.variants[0]
    changes = tables["Relative change of quantities without a part of the physics, in %"].rows
    for row, name in zip(changes, SENSES, strict=False):
        assert row[:2] == ("spin", _words(name))
        change = 100 * spin.changes[name]
        wanted = [change[0], change[1:].min(), change[1:].max()]
        assert row[2:] == _four_digits(*wanted)
    assert changes[3] == ("load sharing", "it has no mass", "–", "–", "–")
    judged = tables["Fronts found without a part, computed with complete physics"].rows
    assert judged == (("spin", "3", "2", "93.45", "max pressure by up to 12.3 %"),)
    best = tables["Best design for each objective, without a part of the physics"]
    for row in best.rows:
        front = study.front if row[1] == "nothing" else spin.front
        name = row[0].replace(" ", "_")
        pick = max if SENSES[name] == "maximise" else min
        point = pick(front.points, key=lambda one: one.objectives[name])
        scales = (1e3, 180 / math.pi, 1e3)
        wanted = [s * v for s, v in zip(scales, point.variables.values(), strict=True)]
        assert list(map(float, row[2:])) == pytest.approx(wanted, rel=5.1e-4)
    assert len(best.rows) == 4


def test_the_report_holds_all_of_it(study, tmp_path):
    path = write_study(
        tmp_path / "r",
        study,
        attachments={"study.json": "{}"},
        dpi=40,
    )
    page = path.read_text()
    assert "study of design drivers" in page
    for sentence in study.assumptions:
        assert f"<li>{sentence}</li>" in page
    captions = [caption for caption, _ in html_tables(page)]
    assert captions == [t.caption for s in study_sections(study) for t in s.tables]
    names = {one.stem for one in (tmp_path / "r" / "figures").iterdir()}
    assert names == {"map", "conflict", "conflict_limits", "front", "changes", "fronts"}
    assert (tmp_path / "r" / "study.json").read_text() == "{}"


def _front(front, gradients=()):
    expected = front.to_dict()
    for point, gradient in zip(expected["points"], gradients, strict=False):
        point |= {
            "elasticities": gradient.elasticities,
            "exchange": gradient.exchange,
            "sentence": gradient.sentence,
        }
    return expected


def _expected(study):
    spin, failed = study.variants
    empty = {"values": {}, "changes": {}, "turned": [], "limits_without_data": [], "front": None}
    empty |= {"best": {}, "values_complete": {}, "allowed_complete": [], "violations_complete": {}}
    best = {}
    for name in study.problem.objectives:
        pick = max if SENSES[name] == "maximise" else min
        best[name] = pick(spin.front.points, key=lambda one: one.objectives[name]).variables
    return {
        "map": {
            "drivers": {
                d.name: {
                    "unit": d.unit,
                    "lower": d.lower,
                    "upper": d.upper,
                    "present": d.present,
                    "values": list(np.linspace(d.lower, d.upper, 3 + i)),
                }
                for i, d in enumerate(DRIVERS)
            },
            "quantities": {
                name: {
                    "unit": UNITS[name],
                    "sense": SENSES.get(name, "minimise"),
                    "limit": name == "max_pressure",
                    "smallest": np.nanmin(study.map.values[name]),
                    "largest": np.nanmax(study.map.values[name]),
                    "present": study.designs.values[name][0],
                    "elasticities_present": dict(
                        zip(NAMES, study.designs.elasticities[name][0], strict=True)
                    ),
                }
                for name in SIZES
            },
            "points": 60,
            "failed": 1,
            "reasons": {"overlapping_rollers": 1},
            "errors": 0,
            "allowed": int(np.nansum(study.map.values["max_pressure"] <= 1.6e9 * (1 + 1e-6))),
        },
        "conflict": [
            {
                "first": one.first,
                "second": one.second,
                "senses": list(one.senses),
                "second_is_limit": one.second == "max_pressure",
                "cosine_present": one.present,
                "cosine_lowest": np.nanmin(one.cosine),
                "cosine_highest": np.nanmax(one.cosine),
                "share": one.share,
                "share_allowed": one.share_allowed,
                "share_by_driver": one.by_driver,
                "lowest_at": one.most,
                "highest_at": one.least,
            }
            for one in study.conflicts
        ],
        "front": _front(study.front, study.gradients),
        "variants": [
            {
                "name": "spin",
                "parts": ["stage.1.friction.spin"],
                "misses": "losses by spin",
                "values": {name: list(v) for name, v in spin.values.items()},
                "changes": {name: list(v) for name, v in spin.changes.items()},
                "turned": [{"quantity": "efficiency", "driver": "lead", "designs": 2}],
                "limits_without_data": ["max_pressure"],
                "front": _front(spin.front),
                "best": best,
                "values_complete": {name: list(v) for name, v in spin.complete.items()},
                "allowed_complete": [True, False, True],
                "violations_complete": {"max_pressure": 0.123},
                "volume_complete": 0.9345,
                "error": None,
            },
            {
                "name": failed.name,
                "parts": list(failed.parts),
                "misses": "sharing",
                **empty,
                "volume_complete": None,
                "error": "it has no mass",
            },
        ],
    }


@reads("verb", "study")
def test_study(run, monkeypatch, tmp_path, study):
    given = {}

    def found_by(mechanism, drivers, quantities, objectives, **options):
        given.update(options, drivers=drivers, quantities=quantities, objectives=objectives)
        return study

    def write(folder, one, *, command, source, origin, attachments, on_fault):
        assert one is study
        # In the order of the options, with those that were given and no other.
        assert shlex.split(command) == [
            *("prsm", "study", "wu2022", "--out", str(folder)),
            *("--set", "load=3 kN", "--set", "lead=12 mm"),
            *words[: words.index("--points")],
            *("--points", "4", "--front-points", "3", "--without", "spin,load_sharing"),
            *("--starts", "2"),
        ]
        assert (source, origin.settings) == ("wu2022", ("load=3 kN", "lead=12 mm"))
        assert origin.sha256 == hashlib.sha256(file.example_text("wu2022").encode()).hexdigest()
        given["attachments"] = attachments
        return folder / "report.html"

    monkeypatch.setattr("prsm_jax.studies.study", found_by)
    monkeypatch.setattr("prsm_jax.report.write_study", write)
    words = (
        *("--driver", "lead=5 mm:15 mm", "--driver", "contact_angle"),
        *("--maximise", "efficiency", "--minimise", "nut_outer_diameter,mass"),
        *("--points", "4", "--without", "spin,load_sharing", "--front-points", "3"),
        *("--starts", "2", "--set", "load=3 kN", "--set", "lead=12 mm"),
        *("--out", tmp_path / "o"),
    )
    found, printed = run("study", "wu2022", *words)
    assert given.pop("drivers") == {
        "lead": (pytest.approx(5e-3), pytest.approx(15e-3)),
        "contact_angle": None,
    }
    assert given.pop("quantities") == SENSES
    assert given.pop("progress") is not None
    attachments = given.pop("attachments")
    store = tmp_path / "o" / "wu2022-study.zarr"
    assert given == {
        "objectives": None,
        "points": 4,
        "front_points": 3,
        "without": ["spin", "load_sharing"],
        "starts": 2,
        "store": store,
    }
    report = tmp_path / "o" / "report.html"
    assert found["assumptions"] == list(study.assumptions)
    expected = _expected(study)
    assert_json(
        without_words(dict(found)), {"report": str(report), "store": str(store), **expected}
    )
    stored = json.loads(attachments["study.json"])
    assert_json(without_words(stored), expected)
    # What is printed are the tables of the report, which are read above.
    text = "\n".join("  ".join(cells) for cells in printed.lines)
    for table in [one for some in study.tables().values() for one in some]:
        assert table.columns[1] in text
    for one in study.gradients:
        assert one.sentence in text
    assert str(report) in text
    assert str(store) in text
