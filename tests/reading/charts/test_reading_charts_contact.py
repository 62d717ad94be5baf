"""Pictures of contacts: every curve, map, mark and number read back in SI."""

import math

import jax.numpy as jnp
import numpy as np
import pytest
import reading_scenes as scenes
from expectations import reads
from matplotlib.patches import Ellipse
from reading_artists import box_of, levels_of, vertices_of, x_data, y_data
from reading_figures import Chart, handles
from reading_units import assert_reads, label_unit, to_si

from prsm_jax.contact import StressPeak
from prsm_jax.report import (
    contact_ellipses,
    force_deflection_chart,
    line_contact_chart,
    pressure_map,
    pressure_profiles,
    published_pressure,
    stress_section,
    subsurface_chart,
    thread_load_chart,
)
from prsm_jax.report.contact_charts import FlankLine, _subsurface_chart
from prsm_jax.validation import PressureFigure, PressurePanel, PrintedEllipse, PrintedPressure
from tests.present import present

number = jnp.asarray


def _colours(chart, axes, image, values, si_unit="Pa"):
    """The colours of an image stand for these numbers, by the label of the colour bar."""
    (bar,) = [a for a in chart.axes if a.get_label() == "<colorbar>"]
    label = label_unit(bar.get_ylabel())
    assert to_si(1.0, label) == pytest.approx(to_si(1.0, "MPa") if si_unit == "Pa" else 1.0)
    found = to_si(np.ma.filled(image.get_array(), np.nan), label)
    # On the very edge of an ellipse the pressure is the root of a rounding.
    edge = 1e-7 * np.nanmax(np.abs(values))
    np.testing.assert_allclose(found, values, rtol=1e-9, atol=edge)
    chart.take(image)
    chart.ignore([*bar.collections, *bar.patches, *bar.lines, *bar.images])


def _bar(chart):
    (bar,) = [a for a in chart.axes if a.get_label() == "<colorbar>"]
    chart.ignore([*bar.collections, *bar.patches, *bar.lines, *bar.images])
    return bar


def _ellipse(chart, axes, hertz, angle=0.0):
    patch = next(
        p for p in axes.patches if isinstance(p, Ellipse) and p.get_label() not in ("read",)
    )
    patch.set_label("read")
    size = chart.si(axes, "x", patch.width, "m"), chart.si(axes, "y", patch.height, "m")
    assert size == pytest.approx((2 * float(hertz.semi_major), 2 * float(hertz.semi_minor)))
    assert patch.angle == pytest.approx(np.degrees(angle))
    assert tuple(patch.center) == (0, 0)
    chart.take(patch)


def _cross(chart, axes):
    for way in ("y", "x"):
        chart.level(axes, 0.0, "m", way)


@reads("chart", "contact_ellipses")
def test_ellipses():
    pairs = {"before": scenes.contact_pair(), "after": scenes.contact_pair()}
    chart = Chart(contact_ellipses(pairs))
    panels = [a for a in chart.axes if a.get_label() != "<colorbar>"]
    every = [(p, s) for p in pairs for s in ("screw", "nut")]
    assert len(panels) == len(every)
    highest = max(float(getattr(pairs[p], s).hertz.max_pressure) for p, s in every)
    for axes, (label, side) in zip(panels, every, strict=True):
        hertz = getattr(pairs[label], side).hertz
        assert axes.get_title("left") == f"{label}: {side} side"
        _ellipse(chart, axes, hertz)
        words = chart.text("along the major axis in", place=axes)
        chart_words = words.split("\n")[1]
        assert_reads(
            chart_words,
            (hertz.max_pressure, "Pa"),
            (hertz.semi_major, "m"),
            (hertz.semi_minor, "m"),
        )
        (image,) = axes.images
        left, right, low, high = image.get_extent()
        rows, columns = image.get_array().shape
        # Samples lie on the edges of the picture.
        x = chart.si(axes, "x", np.linspace(left, right, columns), "m")
        y = chart.si(axes, "y", np.linspace(low, high, rows), "m")[:, None]
        inside = 1 - (x / float(hertz.semi_major)) ** 2 - (y / float(hertz.semi_minor)) ** 2
        expected = float(hertz.max_pressure) * np.sqrt(np.where(inside > 0, inside, np.nan))
        _colours(chart, axes, image, expected)
        assert to_si(image.get_clim(), "MPa") == pytest.approx([0, highest])
        _cross(chart, axes)
    assert all(label_unit(panels[k].get_ylabel()) == chart.unit(panels[k], "x") for k in (0, 2))
    chart.finish()


def _flanks(chart, axes, contact, crest):
    hertz, surface = contact.hertz, contact.surface
    _ellipse(chart, axes, hertz)
    (image,) = axes.images
    _colours(chart, axes, image, np.where(surface.contact, surface.pressure, np.nan).T)
    edges = chart.si(axes, "x", image.get_extent(), "m")
    half = np.array([24 * 2e-5, 20 * 1.8e-5]) / 2
    assert edges == pytest.approx([-half[0], half[0], -half[1], half[1]])
    _cross(chart, axes)
    assert len(axes.collections) == int(crest)
    if crest:
        (line,) = axes.collections
        (points,) = (chart.si(axes, "x", path.vertices, "m") for path in line.get_paths())
        np.testing.assert_allclose(points[:, 1], -points[:, 0] / 4 - 1e-4, atol=1e-12)
        chart.take(line)


@reads("chart", "pressure_map")
def test_maps():
    contacts = {"cut": scenes.flank_contact(), "whole": scenes.flank_contact(False)}
    chart = Chart(pressure_map(contacts))
    for axes, (label, contact) in zip(chart.axes, contacts.items(), strict=False):
        assert axes.get_title("left") == label
        _flanks(chart, axes, contact, label == "cut")
        chart.says(
            f"along the major axis in {chart.unit(axes, 'x')}",
            (contact.surface.max_pressure, "Pa"),
            (contact.hertz.max_pressure, "Pa"),
            (contact.surface.load, "N"),
            place=axes,
        )
    assert chart.unit(chart.axes[0], "y") == chart.unit(chart.axes[0], "x")
    chart.finish()


@reads("chart", "published_pressure")
def test_published_maps():
    cut, whole = scenes.flank_contact(), scenes.flank_contact(False)
    printed = PrintedPressure("elements", 1.1e9), PrintedPressure("Hertz", 2.3e9, 1.65e9)
    ellipse = PrintedEllipse(3e-4, 1e-4, 0.4)
    panels = (PressurePanel("cut", cut, printed, ellipse), PressurePanel("whole", whole))
    chart = Chart(published_pressure(PressureFigure("lisowski2014", "n", "One row", (panels,))))
    for axes, panel in zip(chart.axes, panels, strict=False):
        _flanks(chart, axes, panel.contact, panel.name == "cut")
        largest = float(panel.contact.surface.max_pressure)
        numbers = [(largest, "Pa")]
        if panel.printed:
            _ellipse(chart, axes, ellipse, 0.4)
            numbers += [(1.1e9, "Pa"), (1.1e9 / largest - 1, "1", "whole")]
            numbers += [(2.3e9, "Pa"), (1.65e9, "Pa"), (1.65e9 / largest - 1, "1", "whole")]
        words = chart.text(f"major axis in {chart.unit(axes, 'x')}", place=axes)
        # "2300 (read 1650) MPa": one unit for both.
        words = words.replace("(read", "MPa").replace(")", "")
        assert_reads(words, *numbers)
    chart.finish()


@reads("chart", "pressure_profiles")
def test_profiles():
    contact = scenes.flank_contact()
    chart = Chart(pressure_profiles({"cut": contact}))
    pressure, hertz = np.asarray(contact.surface.pressure), contact.hertz
    # Even numbers of cells have none on the axis: the mean of both beside it.
    cuts = (pressure[:, 9] + pressure[:, 10]) / 2, (pressure[11] + pressure[12]) / 2
    places = (np.arange(24) - 11.5) * 2e-5, (np.arange(20) - 9.5) * 1.8e-5
    halves = float(hertz.semi_major), float(hertz.semi_minor)
    for axes, cut, place, half in zip(chart.axes, cuts, places, halves, strict=True):
        theory, cells = chart.lines(axes)
        x = chart.si(axes, "x", theory.get_xdata(), "m")
        assert (x.min(), x.max()) == pytest.approx((-half, half))
        expected = float(hertz.max_pressure) * np.sqrt(np.maximum(1 - (x / half) ** 2, 0))
        chart.curve(axes, theory, None, expected, ("m", "Pa"))
        chart.curve(axes, cells, place, np.where(cut > 0, cut, np.nan), ("m", "Pa"))
    assert handles(chart.figure) == ["cut, Hertz", "cut, true flanks"]
    chart.finish()


def test_crests_and_roots_beside_the_ellipses():
    """A line at its distance, at right angles to a direction in which the ellipse is as long."""
    pair = scenes.contact_pair()
    screw, nut = (getattr(pair, side).hertz for side in ("screw", "nut"))
    major, minor = float(screw.semi_major), float(screw.semi_minor)
    long = float(nut.semi_major)
    # At 30 degrees to the major axis, by the ellipse's own equation.
    half = math.hypot(major * math.cos(math.pi / 6), minor * math.sin(math.pi / 6))
    lines = (
        FlankLine("screw", "crest of the screw", 0.9 * half, half, False),
        FlankLine("nut", "crest of the nut", 0.8 * long, long, True),
        FlankLine("nut", "root of the roller", 90 * long, long, True),
    )
    chart = Chart(contact_ellipses({"x": pair}, None, {"x": lines}))
    left, right = (a for a in chart.axes if a.get_label() != "<colorbar>")
    drawn = [line for axes in (left, right) for line in axes.lines if len(x_data(line)) == 2]
    drawn = [line for line in drawn if line.get_color() in ("#d55e00", "#009e73", "#0072b2")]
    # The third lies outside of the picture.
    assert len(drawn) == 2
    for line, wanted, angle, sign in zip(drawn, lines, (math.pi / 6, 0), (-1, 1), strict=False):
        axes = left if wanted.side == "screw" else right
        x, y = (chart.si(axes, way, line.get_data()[k], "m") for k, way in enumerate("xy"))
        normal = sign * np.array([math.cos(angle), math.sin(angle)])
        np.testing.assert_allclose(normal[0] * x + normal[1] * y, wanted.distance, rtol=1e-9)
    assert handles(chart.figure) == ["crest of the screw", "crest of the nut"]


def test_the_hardness_depth_is_drawn_where_it_is():
    chart = Chart(stress_section(scenes.subsurface(), hardness_depth=5e-5))
    axes = chart.axes[0]
    (line,) = [one for one in axes.lines if one.get_label() == "hardness depth"]
    np.testing.assert_allclose(chart.si(axes, "y", line.get_ydata(), "m"), 5e-5)
    words = chart.text("x in")
    assert_reads(words.rpartition("hardness depth")[2], (5e-5, "m"))
    with pytest.raises(ValueError, match="above 0"):
        stress_section(scenes.subsurface(), hardness_depth=0.0)


@reads("chart", "stress_section")
@pytest.mark.parametrize("along", ["x", "y"])
def test_stress_section(along):
    stress = scenes.subsurface()
    chart = Chart(stress_section(stress, along))
    axes = chart.axes[0]
    # Cell 4 of 16 and 7 of 12, each 20 µm wide, at the third depth.
    place = {"x": (4 - 7.5) * 2e-5, "y": (7 - 5.5) * 2e-5}
    (mark,) = chart.lines(axes)
    chart.curve(axes, mark, place[along], 6e-5, ("m", "m"))
    other = "y" if along == "x" else "x"
    words = chart.text(f"section at {other} = ")
    assert_reads(words.split("=")[1], (place[other], "m"))
    words = chart.text(f"{along} in {chart.unit(axes, 'x')}")
    assert_reads(words.split("largest")[1], (9.13e8, "Pa"), (6e-5, "m"))
    bar = _bar(chart)
    assert bar.get_ylabel() == "von Mises stress in MPa"
    filled, lines = axes.collections
    assert filled.get_clim()[1] > 0
    # Steps of the contours hold the largest stress, in the unit of the colour bar.
    levels = to_si(levels_of(filled), label_unit(bar.get_ylabel()))
    assert levels[0] == 0
    assert 9.13e8 <= levels[-1] < 1.3 * 9.13e8
    assert filled.get_array().size == len(levels) - 1
    # Where the stress is largest a filled step is closed around the mark.
    x, y = (float(v[0]) for v in (x_data(mark), y_data(mark)))
    top = max(k for k, path in enumerate(filled.get_paths()) if len(vertices_of(path)))
    vertices = vertices_of(filled.get_paths()[top])
    assert np.hypot(vertices[:, 0] - x, vertices[:, 1] - y).max() < 0.03
    assert levels[top] <= 9.13e8 <= levels[top + 1]
    chart.take(filled, lines)
    chart.finish()


def _hill(points, axes, pressure, ratio, traction):
    """Made up in place of the law, which has tests of its own: one hill, off the middle."""
    top = 0.21 * axes[0] * (1 + traction[0]), 0.63 * axes[1]
    slopes = ((points[:, 0] - top[0]) / axes[0]) ** 2 + ((points[:, 2] - top[1]) / axes[1]) ** 2
    height = 2 * ratio * pressure * (1 + traction[0])
    peak = StressPeak(height, jnp.asarray([top[0], 0.0, top[1]]))
    return height * jnp.exp(-slopes), peak


@reads("chart", "subsurface_chart")
def test_stress_below_a_contact(monkeypatch):
    monkeypatch.setattr(_subsurface_chart, "_program", lambda: _hill)
    hertz = scenes.hertz()
    axes_m = jnp.asarray([hertz.semi_major, hertz.semi_minor])
    given = axes_m, hertz.max_pressure, number(0.3)
    chart = Chart(subsurface_chart(hertz, 0.3, 0.1))
    panels = [a for a in chart.axes if a.get_label() != "<colorbar>"]
    bar = _bar(chart)
    for axes, friction in zip(panels, (0.0, 0.1), strict=True):
        traction = jnp.asarray([friction, 0.0])
        _, peak = _hill(jnp.zeros((1, 3)), *given, traction)
        mark = next(line for line in chart.lines(axes) if line.get_marker() == "x")
        chart.curve(axes, mark, peak.position[0], peak.position[2], ("m", "m"))
        chart.curve(
            axes,
            chart.lines(axes)[0],
            np.array([-1, 1]) * float(hertz.semi_major),
            np.zeros(2),
            ("m", "m"),
        )
        chart.says("", (peak.value, "Pa"), (peak.depth, "m"), within="at depth", place=axes)
        filled, lines = axes.collections
        levels = to_si(levels_of(filled), label_unit(bar.get_ylabel()))
        inside = [k for k, path in enumerate(filled.get_paths()) if len(vertices_of(path))]
        # The field that is drawn ends in the step of the largest stress, grid or not.
        assert levels[max(inside)] <= float(peak.value) * 1.001
        assert levels[max(inside) + 1] >= 0.98 * float(peak.value)
        # A point on a contour has the stress of that contour.
        level, path = next(
            (float(to_si(v, label_unit(bar.get_ylabel()))), p)
            for v, p in zip(levels_of(lines), lines.get_paths(), strict=True)
            if len(vertices_of(p)) and v > 0.5 * levels_of(lines)[-1]
        )
        x = chart.si(axes, "x", vertices_of(path)[0, 0], "m")
        z = chart.si(axes, "y", vertices_of(path)[0, 1], "m")
        point = jnp.asarray([float(x), 0.0, float(z)])
        # Linear interpolation between the points of a grid.
        stress, _ = _hill(point[None], *given, traction)
        assert float(stress[0]) == pytest.approx(level, rel=0.02)
        chart.take(filled, lines)
    assert chart.text("without friction", place=panels[0])
    chart.says("sliding, µ = ", (0.1, "1", "whole"), place=panels[1])
    chart.finish()


@reads("chart", "line_contact_chart")
def test_line_contact():
    flanks, line = scenes.line_contact()
    surface = scenes.flank_contact().surface
    chart = Chart(line_contact_chart(flanks, line, surface))
    above, below = chart.axes
    slices, cells = chart.lines(above)
    chart.curve(above, slices, line.slices.radius, line.pressure, ("m", "Pa"))
    rows = np.asarray(surface.pressure).max(axis=1)
    along = 9e-3 + (np.arange(24) - 11.5) * 2e-5 * np.cos(float(flanks.roller_profile_angle))
    bears = rows > 0
    chart.curve(above, cells, along[bears], rows[bears], ("m", "Pa"))
    words = chart.text("Largest by slices")
    assert_reads(words, (1.07e9, "Pa"), (0.512, "1", "whole"))
    (middle,) = chart.lines(below)
    chart.curve(below, middle, line.slices.radius, line.slices.arc, ("m", "m"))
    (area,) = below.collections
    (path,) = area.get_paths()
    half, arc = np.asarray(line.half_width), np.asarray(line.slices.arc)
    loaded = half > 0
    x = chart.si(below, "x", vertices_of(path)[:, 0], "m")
    y = chart.si(below, "y", vertices_of(path)[:, 1], "m")
    at = np.interp(x, line.slices.radius, arc)
    assert np.abs(y - at).max() == pytest.approx(half.max(), rel=1e-6)
    assert (x.min(), x.max()) == pytest.approx(
        (float(line.slices.radius[loaded].min()), float(line.slices.radius[loaded].max()))
    )
    chart.take(area)
    chart.finish()


@reads("chart", "force_deflection_chart")
def test_force_over_deflection():
    play, single, preloaded = scenes.curve(), scenes.curve(both=False), scenes.curve(play=0.0)
    chart = Chart(force_deflection_chart({"play": play, "single": single, "preloaded": preloaded}))
    above, below = chart.axes
    for one in (play, single, preloaded):
        load, travel, slope = (
            np.asarray(v) for v in (one.load, one.deflection, one.tangent_stiffness)
        )
        whole, tangent = chart.lines(above)[:2]
        chart.curve(above, whole, travel, load, ("m", "N"))
        reach = np.array([0.0, load[-1]])
        chart.curve(above, tangent, travel[-1] - (load[-1] - reach) / slope[-1], reach, ("m", "N"))
        # Between the flanks nothing is drawn; preloaded flanks never part.
        parts = [slice(0, 2), slice(2, 4)] if one is play else [slice(None)]
        for line, part in zip(chart.lines(below)[: len(parts)], parts, strict=True):
            chart.curve(below, line, load[part], slope[part], ("N", "N/m"))
        chart.says("  ", (slope[-1], "N/m"), place=below)
    for way in ("x", "y"):
        chart.level(above, 0.0, "m" if way == "x" else "N", way)
    assert handles(chart.figure) == ["play", "single", "preloaded", "tangent at the largest load"]
    chart.finish()


def _axial(chart, axes, loads, way="y", **more):
    chart.bars(axes, loads, "N", way, **more)


@reads("chart", "thread_load_chart")
def test_loads_of_threads_as_bars():
    found = scenes.distribution()
    chart = Chart(thread_load_chart(found))
    for axes, side, words in zip(
        chart.axes, (found.screw, found.nut), ("screw side", "nut side"), strict=True
    ):
        forward, reverse = np.asarray(side.forward)[0], np.asarray(side.reverse)[0]
        middles = [box_of(p).get_x() + box_of(p).get_width() / 2 for p in axes.patches]
        np.testing.assert_allclose(middles, [1, 2, 3, 4, 5] * 2)
        _axial(chart, axes, forward)
        _axial(chart, axes, -reverse)
        chart.level(axes, 0.0, "N")
        chart.level(axes, (forward - reverse).sum() / 5, "N")
        factor = (forward + reverse).max() / (forward + reverse).mean()
        title = chart.text("Load per thread under", within=words)
        assert_reads(title.replace(f": {words},", ""), (1512.0, "N"), (factor, "1"))
        assert axes.get_ylabel() == "axial load in N"
    chart.finish()


@reads("chart", "thread_load_chart")
def test_loads_of_unlike_rollers_as_maps():
    found = scenes.distribution(classes=2)
    chart = Chart(thread_load_chart(found))
    row = {1: 0, 2: 0, 4: 0, 3: 1}
    pick = [row[n] for n in (1, 2, 3, 4)]
    largest = max(float(f.max()) for s in (found.screw, found.nut) for f in (s.forward, s.reverse))
    named = {axes.get_title("left"): axes for axes in chart.axes}
    (bar,) = [a for a in chart.axes if a.get_label() == "<colorbar>"]
    assert label_unit(bar.get_ylabel()) == "N"
    chart.ignore([*bar.collections, *bar.patches, *bar.lines])
    factors = []
    for side, words in ((found.screw, "screw side"), (found.nut, "nut side")):
        for loads, flank in ((side.forward, "forward"), (side.reverse, "opposite")):
            axes = named[f"{words}, {flank} flanks"]
            (image,) = axes.images
            np.testing.assert_allclose(present(image.get_array()), np.asarray(loads)[pick])
            assert image.get_clim() == pytest.approx((0, largest))
            assert image.get_extent() == [0.5, 5.5, 3.5, -0.5]
            chart.take(image)
        threads = np.asarray(side.forward) + np.asarray(side.reverse)
        weight = np.array([3.0, 1.0])
        mean = (weight[:, None] * threads).sum() / (4 * 5)
        factors.append((threads.max() / mean, "1"))
        assert chart.ticks(named[f"{words}, forward flanks"]) == ["1", "2", "3", "4"]
    sums = [
        axes for axes in chart.axes if axes.get_title() == "sum" or axes.get_title("left") == "sum"
    ]
    assert label_unit(sums[1].get_xlabel()) == "N"
    for axes, side in zip(sums, (found.screw, found.nut), strict=True):
        forward, reverse = (np.asarray(v)[pick].sum(axis=1) for v in (side.forward, side.reverse))
        chart.bars(axes, forward, "N", "x")
        chart.bars(axes, -reverse, "N", "x")
        chart.level(axes, 0.0, "N", "x")
        net = forward - reverse
        chart.level(axes, net.mean(), "N", "x")
        (marks,) = chart.lines(axes)
        np.testing.assert_allclose(x_data(marks), net)
        np.testing.assert_allclose(y_data(marks), [0, 1, 2, 3])
        chart.take(marks)
    words = chart.text("Load per thread under")
    assert_reads(words, (1512.0, "N"), *factors)
    chart.finish()
