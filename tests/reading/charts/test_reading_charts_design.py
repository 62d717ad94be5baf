"""Pictures of designs: drawings, limits, lives, sweeps, sensitivities read back in SI."""

import math
import re
from types import SimpleNamespace
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
import scenes
from expectations import reads
from matplotlib.patches import Arc, Circle
from present import present
from reading_artists import box_of, levels_of, vertices_of, x_data, y_data
from reading_figures import Chart, handles
from reading_units import assert_reads, label_unit, numbers, same_dimension, to_si

import prsm_jax as prsm
from prsm_jax.report import (
    cross_section,
    life_chart,
    optimisation_chart,
    sensitivity_bars,
    shaft_limits_chart,
    sweep_figure,
    sweep_map,
)
from prsm_jax.strength import LoadSpectrum, buckling_load, permissible_speed


@pytest.fixture(scope="module")
def actuator():
    return scenes.example("actuator")


@reads("chart", "optimisation_chart")
def test_the_way_to_an_optimum():
    history, violations = (0.851, 0.883, 0.879), (0.0, 0.1, 0.0)
    limits = [
        SimpleNamespace(
            quantity="max_pressure", unit="Pa", value=2.91e9, limit=3e9, active=True, sense="upper"
        ),
        SimpleNamespace(
            quantity="mass", unit="kg", value=1.31, limit=1.21, active=False, sense="lower"
        ),
        SimpleNamespace(
            quantity="lead", unit="m", value=0.0121, limit=0.0121, active=True, sense="equal"
        ),
    ]
    chart = Chart(
        optimisation_chart(history, limits, objective="efficiency", violations=violations)
    )
    left, right = chart.axes
    path, inside, outside = chart.lines(left)
    np.testing.assert_allclose(x_data(path), [0, 1, 2])
    assert label_unit(left.get_xlabel()) == ""
    chart.curve(left, path, None, history, ("", "1"))
    np.testing.assert_allclose(x_data(inside), [0, 2])
    chart.curve(left, inside, None, (0.851, 0.879), ("", "1"))
    np.testing.assert_allclose(x_data(outside), [1])
    chart.curve(left, outside, None, 0.883, ("", "1"))
    assert outside.get_markerfacecolor() == "white"
    chart.bars(right, [2.91 / 3, 1.21 / 1.31, 1.0], "1", "x")
    chart.level(right, 1.0, "1", "x")
    for one, sign in zip(limits, "≤≥=", strict=True):
        words = chart.text(one.quantity.replace("_", " ") + ": ")
        assert words.endswith(", active") == one.active
        assert f" {sign} " in words
        value, limit = words.split(f" {sign} ")
        (limit_number,) = numbers(limit)
        assert limit_number.is_near(one.limit, one.unit)
        # The value has the limit's unit, which is written once.
        assert_reads(f"{value.split(': ')[1]} {limit_number.label}", (one.value, one.unit))
    chart.finish()


@reads("chart", "sensitivity_bars")
def test_elasticities():
    values = np.array([[0.123, -0.412, 0.0], [-2.2e-4, np.nan, 1.7]])
    chart = Chart(sensitivity_bars(["efficiency", "mass"], ["lead", "pitch", "bore"], values))
    (axes,) = chart.axes
    assert chart.ticks(axes) == ["efficiency", "mass"]
    assert axes.get_xlabel() == "elasticity in % of the quantity per % of the parameter"
    for row, column in np.ndindex(2, 3):
        value = values[row, column]
        bar = axes.patches[3 * row + column]
        # Per cent over per cent: the ratio itself.
        assert bar.get_width() == pytest.approx(0.0 if np.isnan(value) else value)
        middle = bar.get_y() + bar.get_height() / 2
        assert abs(middle - row) < 0.5
        if column == 1:
            assert middle == pytest.approx(row)
        chart.take(bar)
        if np.isnan(value):
            chart.text("not defined")
        elif 0 < abs(value) < 5e-4:
            chart.text("≈ 0")
        elif value == 0:
            chart.text("0")
        else:
            words = chart.text(f"{value:+.3f}".replace("-", "\N{MINUS SIGN}"))
            assert_reads(words, (value, "", "whole"))
    chart.take(*chart.lines(axes))
    assert handles(chart.figure) == ["lead", "pitch", "bore"]
    chart.finish()


def _dataset():
    import xarray

    lead, angle = np.linspace(5e-3, 20e-3, 7), np.radians(np.linspace(30, 60, 6))
    load = np.array([3e3, 9e3])
    size = np.sin(100 * lead)[:, None, None] * np.cos(angle)[None, :, None]
    values = 1.9e9 + 1e9 * size + 1e4 * load
    values[0, :2] = np.nan
    return xarray.Dataset(
        {"max_pressure": (("lead", "contact_angle", "load"), values, {"units": "Pa"})},
        {
            "lead": ("lead", lead, {"units": "m"}),
            "contact_angle": ("contact_angle", angle, {"units": "rad"}),
            "load": ("load", load, {"units": "N"}),
        },
    )


@reads("chart", "sweep_map")
def test_sweeps():
    data = _dataset()
    values = data["max_pressure"].values
    chart = Chart(sweep_map(data, "max_pressure", sense="minimise"))
    axes, bar = chart.axes
    chart.ignore([*bar.collections, *bar.patches, *bar.lines])
    assert axes.get_xlabel().startswith("lead in")
    assert axes.get_ylabel().startswith("contact angle in")
    best = np.unravel_index(np.nanargmin(values), values.shape)
    crosses, star = chart.lines(axes)
    angle = data["contact_angle"].values
    chart.curve(axes, crosses, 5e-3, angle[:2], ("m", "rad"))
    chart.curve(axes, star, data["lead"].values[best[0]], angle[best[1]], ("m", "rad"))
    chart.says("smallest: ", (values[best], "Pa"))
    chart.says("at load ", (data["load"].values[best[2]], "N"))
    label = label_unit(bar.get_ylabel())
    assert same_dimension(label, "Pa")
    filled, lines = axes.collections
    plane = values[:, :, best[2]]
    levels = to_si(levels_of(filled), label)
    assert levels[0] <= np.nanmin(plane) <= levels[1]
    assert levels[-2] <= np.nanmax(plane) <= levels[-1]
    # A contour passes where the plane, linear between the designs, has its value.
    from scipy.interpolate import RegularGridInterpolator

    plane_at = RegularGridInterpolator((data["lead"].values, angle), plane)
    middle = len(levels_of(lines)) // 2
    path = vertices_of(lines.get_paths()[middle])
    points = np.stack(
        [chart.si(axes, "x", path[:, 0], "m"), chart.si(axes, "y", path[:, 1], "rad")], axis=1
    )
    found = plane_at(np.clip(points, [5e-3, angle[0]], [20e-3, angle[-1]]))
    known = np.isfinite(found)
    assert known.sum() > 3
    # On an edge between two designs exactly; inside of a cell matplotlib joins these points.
    np.testing.assert_allclose(found[known], to_si(levels_of(lines)[middle], label), rtol=1e-6)
    chart.take(filled, lines)
    chart.finish()


def test_a_map_of_one_value_ends_where_the_sweep_ends():
    """A panel of a constant quantity has the axes of its neighbours with contours."""
    data = _dataset().isel(load=0, drop=True)
    data["max_pressure"] = data["max_pressure"] * 0 + 2e9
    ends = {"x": (5e-3, 20e-3, "m"), "y": (math.pi / 6, math.pi / 3, "rad")}
    pieces = data["max_pressure"].expand_dims(mode=3, axis=-1).copy()
    pieces[..., 1] = pieces[..., 1] + np.arange(6)[None, :] * 1e7
    several = _coded(data.assign(max_pressure=pieces), "max_pressure")
    alone, panels = sweep_map(data, "max_pressure"), sweep_figure(several, "max_pressure")
    for figure, count in ((alone, 1), (panels, 3)):
        chart = Chart(figure)
        maps = [one for one in chart.axes if one.get_title() or one.get_title("left")]
        assert len(maps) == count
        for axes in maps:
            for way, limits in (("x", axes.get_xlim()), ("y", axes.get_ylim())):
                lower, upper, unit = ends[way]
                found = chart.si(axes, way, np.array(limits), unit)
                assert found == pytest.approx([lower, upper], rel=1e-12)


def test_sweeps_name_no_design_with_an_error_the_best():
    """Dots where `check` finds an error; the star on the best of the others."""
    data = _dataset().isel(load=[0])
    values = data["max_pressure"].values[..., 0]
    flawed = values < np.nanquantile(values, 0.4)
    data["error"] = (("lead", "contact_angle"), flawed.astype(np.int8))
    chart = Chart(sweep_map(data, "max_pressure", sense="minimise"))
    axes = chart.axes[0]
    _, dots, star = chart.lines(axes)
    lead, angle = data["lead"].values, data["contact_angle"].values
    row, column = np.nonzero(flawed.T)
    assert len(column) > 3
    chart.curve(axes, dots, lead[column], angle[row], ("m", "rad"))
    assert dots.get_label() == "error of prsm check"
    best = np.unravel_index(np.nanargmin(np.where(flawed, np.nan, values)), values.shape)
    chart.curve(axes, star, lead[best[0]], angle[best[1]], ("m", "rad"))
    chart.says("smallest: ", (values[best], "Pa"))


def _coded(data, quantity):
    """The codes of a sweep: designs without a number failed, one of the others has an error."""
    own = [d for d in data[quantity].dims if d == "mode"]
    first = data[quantity].isel(dict.fromkeys(own, 0))
    error = np.zeros(first.shape, np.int8)
    error.ravel()[np.flatnonzero(np.isfinite(first.values.ravel()))[-1]] = 2
    codes = {"code": (first.dims, np.isnan(first.values).astype(np.int8))}
    return data.assign(codes | {"error": (first.dims, error)})


def _frequencies(dimension, axes):
    import xarray

    length = len(next(iter(axes.values()))[0])
    values = np.outer(np.linspace(1.0, 1.5, length), [210.0, 4300.0])
    values[2] = np.nan
    data = xarray.Dataset(
        {"frequencies": ((dimension, "mode"), values, {"units": "Hz"})},
        {name: (dimension, one, {"units": unit}) for name, (one, unit) in axes.items()},
    )
    return _coded(data, "frequencies")


def _crosses(chart, axes, line, expected, unit):
    """Crosses on the lower edge."""
    np.testing.assert_allclose(chart.si(axes, "x", x_data(line), unit), expected)
    np.testing.assert_array_equal(np.asarray(line.get_ydata()), np.zeros(len(expected)))
    assert line.get_transform() == axes.get_xaxis_transform()
    chart.take(line)


@reads("chart", "sweep_figure")
def test_sweeps_over_one_axis():
    """A line for each mode."""
    lead = np.linspace(5e-3, 20e-3, 6)
    data = _frequencies("lead", {"lead": (lead, "m")})
    chart = Chart(sweep_figure(data, "frequencies"))
    (axes,) = chart.axes
    first, second, crosses, dots = chart.lines(axes)
    for line, mode in ((first, 0), (second, 1)):
        values = data["frequencies"].values[:, mode]
        known = np.isfinite(values)
        assert list(np.isfinite(np.asarray(line.get_ydata(), float))) == list(known)
        x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
        np.testing.assert_allclose(chart.si(axes, "x", x, "m"), lead)
        np.testing.assert_allclose(chart.si(axes, "y", y[known], "Hz"), values[known])
        assert line.get_label() == f"mode {mode + 1}"
        chart.take(line)
    _crosses(chart, axes, crosses, lead[[2]], "m")
    chart.curve(axes, dots, lead[[5, 5]], data["frequencies"].values[5], ("m", "Hz"))
    assert handles(chart.figure) == ["mode 1", "mode 2", "failed", "error of prsm check"]
    chart.text("mode 1")
    chart.text("mode 2")
    chart.finish()


def test_sweeps_over_a_list_of_designs():
    """Each mode against each axis."""
    axes = {
        "lead": (np.array([9e-3, 5e-3, 7e-3, 6e-3, 8e-3]), "m"),
        "contact_angle": (np.radians([40.0, 45.0, 30.0, 60.0, 50.0]), "rad"),
    }
    data = _frequencies("design", axes)
    chart = Chart(sweep_figure(data, "frequencies"))
    known = [0, 1, 3, 4]
    for panel, (name, (values, unit)) in zip(chart.axes, axes.items(), strict=True):
        first, second, crosses, dots = chart.lines(panel)
        for line, mode in ((first, 0), (second, 1)):
            x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
            np.testing.assert_allclose(chart.si(panel, "x", x, unit), values)
            label = label_unit(chart.axes[0].get_ylabel())
            expected = data["frequencies"].values[known, mode]
            np.testing.assert_allclose(to_si(y[known], label), expected)
            assert np.isnan(y[2])
        assert panel.get_xlabel().startswith(name.replace("_", " "))
        _crosses(chart, panel, crosses, values[[2]], unit)
        np.testing.assert_allclose(chart.si(panel, "x", x_data(dots), unit), values[[4, 4]])


def test_sweeps_over_three_axes():
    """Panels at six of nine loads; the star in that of the best design without an error."""
    import xarray

    lead, angle = np.linspace(5e-3, 20e-3, 7), np.radians(np.linspace(30, 60, 6))
    load = np.linspace(3e3, 11e3, 9)
    size = np.multiply.outer(np.sin(100 * lead), np.cos(angle))[..., None]
    values = 1.9e9 + 1e9 * size + 2e8 * (load / 1e3 - 7) ** 2
    values[0, :2] = np.nan
    data = xarray.Dataset(
        {"max_pressure": (("lead", "contact_angle", "load"), values, {"units": "Pa"})},
        {
            "lead": ("lead", lead, {"units": "m"}),
            "contact_angle": ("contact_angle", angle, {"units": "rad"}),
            "load": ("load", load, {"units": "N"}),
        },
    )
    flawed = np.unravel_index(np.nanargmin(values), values.shape)
    error = np.zeros(values.shape, np.int8)
    error[flawed] = 2
    dimensions = data["max_pressure"].dims
    data["code"] = (dimensions, np.isnan(values).astype(np.int8))
    data["error"] = (dimensions, error)
    best = np.unravel_index(np.nanargmin(np.where(error > 0, np.nan, values)), values.shape)
    assert load[best[2]] == 7e3
    chart = Chart(sweep_figure(data, "max_pressure", sense="minimise"))
    *panels, bar = chart.axes
    label = label_unit(bar.get_ylabel())
    # Six equal steps miss the best load; the nearest of them gives way to it.
    shown = [float(numbers(panel.get_title(loc="left"))[0].value) for panel in panels]
    assert len(shown) == 6
    assert {3.0, 7.0, 11.0} <= set(shown)
    for panel, kilonewtons in zip(panels, shown, strict=True):
        index = int(np.flatnonzero(np.isclose(load, 1e3 * kilonewtons))[0])
        assert_reads(panel.get_title(loc="left").removeprefix("load "), (load[index], "N"))
        filled, plane = panel.collections[0], values[..., index]
        levels = to_si(levels_of(filled), label)
        # All panels have one scale.
        assert levels[0] <= np.nanmin(values) <= levels[1]
        assert levels[-2] <= np.nanmax(values) <= levels[-1]
        for i, k in np.ndindex(5, 3):
            i, k = i + 1, k + 2
            band = int(np.searchsorted(levels, plane[i, k])) - 1
            place = 1e3 * float(lead[i]), math.degrees(float(angle[k]))
            assert filled.get_paths()[band].contains_point(place)
        marks = {line.get_marker(): line for line in chart.lines(panel)}
        assert ("*" in marks, "." in marks) == (index == best[2], index == flawed[2])
        np.testing.assert_allclose(to_si(x_data(marks["x"]), "mm"), [5e-3, 5e-3])
        np.testing.assert_allclose(to_si(np.sort(marks["x"].get_ydata()), "deg"), angle[:2])
        for mark, where in (("*", best), (".", flawed)):
            if mark in marks:
                x, y = x_data(marks[mark]), np.asarray(marks[mark].get_ydata())
                np.testing.assert_allclose(to_si(x, "mm"), lead[[where[0]]])
                np.testing.assert_allclose(to_si(y, "deg"), angle[[where[1]]])
    (star,) = [word for word in handles(chart.figure) if word.startswith("smallest: ")]
    assert_reads(star.removeprefix("smallest: "), (values[best], "Pa"))


def test_sweeps_of_many_designs_are_thinned():
    """Every third lead and every third angle, and the last ones, which are those of the best."""
    import xarray

    lead, angle = np.linspace(5e-3, 20e-3, 1200), np.linspace(0.6, 1.0, 1300)
    values = np.multiply.outer(lead, angle)
    data = xarray.Dataset(
        {"mass": (("lead", "contact_angle"), values, {"units": "kg"})},
        {"lead": ("lead", lead, {"units": "m"}), "contact_angle": ("contact_angle", angle)},
    )
    data["code"] = (("lead", "contact_angle"), np.zeros(values.shape, np.int8))
    chart = Chart(sweep_figure(data, "mass"))
    star = chart.axes[0].lines[-1]
    np.testing.assert_allclose(x_data(star), [1e3 * lead[1199]])
    chart.says("largest: ", (lead[-1] * angle[-1], "kg"))
    # Places 0, 3, … 1197 and 1199; 0, 3, … 1299, the last of which is that of the best.
    assert handles(chart.figure)[-1] == f"{401 * 434} of {1200 * 1300} designs drawn"


@reads("chart", "life_chart")
def test_life():
    load = jnp.asarray([3e3, -18e3, 9e3])
    turned = jnp.asarray([300.0, 40.0, 160.0])
    spectrum = LoadSpectrum(load, turned, jnp.asarray([1.0, 2.0, 3.0]))
    capacity, static = 61e3, 94e3
    chart = Chart(life_chart(capacity, spectrum, static))
    bars, damage, line = chart.axes
    force, share = np.abs([18e3, 9e3, 3e3]), np.array([40, 160, 300]) / 500
    harm = share * force**3
    mean = harm.sum() ** (1 / 3)
    starts = np.array([0, 0.08, 0.4])
    for axes, heights, unit in ((bars, force, "N"), (damage, harm / harm.sum(), "1")):
        places = [(box_of(p).get_x(), box_of(p).get_width()) for p in axes.patches]
        found = chart.si(axes, "x", places, "1")
        np.testing.assert_allclose(found, np.stack([starts, share], axis=1), atol=1e-12)
        chart.bars(axes, heights, unit)
    chart.level(bars, mean, "N")
    chart.says("equivalent ", (mean, "N"))
    # The phases as the file has them: the second is the largest.
    for centre, value, name in zip(starts + share / 2, harm / harm.sum(), "231", strict=True):
        text = next(t for t in damage.texts if t.get_text() == name)
        place = text.get_position()
        assert chart.si(damage, "x", place[0], "1") == pytest.approx(centre)
        assert chart.si(damage, "y", place[1], "1") == pytest.approx(value)
        chart.take(text)
    life, down, point, rated = chart.lines(line)[:4]
    forces = chart.si(line, "x", life.get_xdata(), "N")
    chart.curve(line, life, None, 1e6 * (capacity / forces) ** 3, ("N", "turns"))
    assert forces.max() == pytest.approx(static)
    turns = 1e6 * (capacity / mean) ** 3
    chart.curve(line, down, mean, [1e5, turns], ("N", "turns"))
    chart.curve(line, point, mean, turns, ("N", "turns"))
    chart.curve(line, rated, capacity, 1e6, ("N", "turns"))
    chart.level(line, static, "N", "x")
    chart.says("", (turns, "turns"), (mean, "N"), within="turns\nat")
    chart.says("dynamic capacity\n", (capacity, "N"))
    chart.says("static capacity\n", (static, "N"))
    assert label_unit(line.get_ylabel()) == "turns"
    chart.finish()


def test_a_narrow_phase_that_does_most_damage_has_its_number():
    """18 kN for 1.6 % of the revolutions do 68 % of the damage; beside them 9 kN have no room."""
    spectrum = LoadSpectrum(
        jnp.asarray([3e3, -18e3, 9e3]), jnp.asarray([480.0, 8.0, 12.0]), jnp.ones(3)
    )
    _, damage, _ = Chart(life_chart(61e3, spectrum)).axes
    assert [one.get_text() for one in damage.texts] == ["2", "1"]
    assert damage.texts[0].get_position()[0] == pytest.approx(0.8)


@reads("chart", "shaft_limits_chart")
def test_limits_of_the_shaft(actuator):
    stage = actuator.stages[0]
    chart = Chart(shaft_limits_chart(stage, load=18.2e3, speed=260.0))
    buckling, speed = chart.axes
    assert chart.unit(buckling, "y") == "kN"
    ends = ["fixed–free", "supported–supported", "fixed–supported", "fixed–fixed"]
    given = stage.strength.shaft.end_conditions.replace("_", "–")
    words = [f"{e} (as given)" if e == given else e for e in ends]
    assert sorted(handles(chart.figure)) == sorted(words)
    for axes, law, unit in ((buckling, buckling_load, "N"), (speed, permissible_speed, "rad/s")):
        for line in chart.lines(axes, lambda line: len(line.get_xdata()) > 2):
            name = str(line.get_label()).removesuffix(" (as given)")
            lengths = chart.si(axes, "x", line.get_xdata(), "m")
            shaft = stage.strength.shaft
            held = eqx.tree_at(
                lambda s: s.strength.shaft,
                stage,
                type(shaft)(**(vars(shaft) | {"end_conditions": name.replace("–", "_")})),
            )
            few = lengths[[10, 100]]
            expected = [float(law(held, jnp.asarray(length))) for length in few]
            found = chart.si(axes, "y", np.asarray(line.get_ydata())[[10, 100]], unit)
            np.testing.assert_allclose(found, expected, rtol=1e-9)
            chart.take(line)
    lengths = prsm.strength.loaded_length(stage), prsm.strength.unsupported_length(stage)
    demands = ((18.2e3, "N", "largest load\n"), (260.0, "rad/s", "largest speed\n"))
    for axes, length, (value, unit, words) in zip((buckling, speed), lengths, demands, strict=True):
        chart.level(axes, float(length), "m", "x")
        (dot,) = chart.lines(axes)
        chart.curve(axes, dot, float(length), value, ("m", unit))
        chart.says(words, (value, unit))
    limit = float(stage.strength.shaft.dn_limit)
    text: Any = next(t for t in speed.texts if "DN limit" in t.get_text())
    chart.says("DN limit ", (limit, "m*rad/s"))
    # D N: the screw's diameter times its speed.
    at = chart.si(speed, "y", text.xy[1], "rad/s")
    assert at * 2 * float(stage.thread.screw_radius) == pytest.approx(limit)
    chart.finish()


def _circles(axes):
    found = {}
    for patch in axes.patches:
        if isinstance(patch, Circle):
            found.setdefault(patch.get_label(), []).append((*patch.center, patch.radius))
    return found


@reads("chart", "cross_section")
def test_drawing(actuator):
    """Every dimension in words, and the circles, spans and points that they belong to."""
    stage = actuator.stages[0]
    thread = stage.thread
    chart = Chart(cross_section({"design": actuator}))
    across, along, detail = chart.axes
    screw, roller, nut, centre = (
        float(v)
        for v in (
            thread.screw_radius,
            thread.roller_radius,
            thread.nut_radius,
            thread.centre_distance,
        )
    )
    wall, bore = float(stage.nut.wall_thickness), float(stage.screw.bore_radius)
    outside = nut + wall
    circles = _circles(across)
    for name, radius in (
        ("screw", screw), ("bore", bore), ("nut", outside), ("nut outside", outside),
        ("nut thread", nut),
    ):  # fmt: skip
        assert circles[name] == [(0, 0, pytest.approx(1e3 * radius))]
    count = int(stage.roller_count)
    assert len(circles["roller"]) == count
    for k, (x, y, r) in enumerate(circles["roller"]):
        angle = 2 * math.pi * k / count
        expected = (centre * math.cos(angle), centre * math.sin(angle), roller)
        assert (x, y, r) == pytest.approx([1e3 * v for v in expected])
    if stage.carrier.radial_width is not None:
        half = float(stage.carrier.radial_width) / 2
        radii = sorted(r for *_, r in circles["carrier"])
        assert radii == pytest.approx([1e3 * (centre - half), 1e3 * (centre + half)])
    meshing = scenes.mesh(thread)
    r, angle = (
        float(v) for v in (meshing.screw.contact_radius, meshing.screw.contact_angle_position)
    )
    dots = [line for line in across.lines if line.get_marker() == "o"]
    for line, radius, turn in ((dots[0], r, angle), (dots[1], nut, 0.0)):
        x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        np.testing.assert_allclose(np.hypot(x, y), 1e3 * radius)
        turns = np.unwrap(np.arctan2(y, x)) - turn
        np.testing.assert_allclose(
            np.mod(turns + 1e-9, 2 * np.pi), np.arange(count) * 2 * np.pi / count, atol=1e-7
        )

    def says(axes, start, end, value, unit="m"):
        words = chart.text(start, within=end, place=axes)
        plain = words.removeprefix(start).removesuffix(end).strip()
        shown = numbers(plain)[0]
        if unit == "m":
            # Drawings are in millimetres, without saying so at every number.
            assert "Dimensions in mm" in foot
            assert shown.value == pytest.approx(1e3 * value, abs=5.001e-4)
        else:
            assert_reads(plain, (value, unit, "whole"))

    foot = chart.text("Dimensions in mm")
    says(across, "Ø", " roller", 2 * roller)
    says(across, "a = ", "", centre)
    says(across, "Ø", " screw", 2 * screw)
    says(across, "Ø", " nut and gear", 2 * nut)
    says(across, "Ø", " outside", 2 * outside)
    says(across, "bore Ø", "", 2 * bore)
    says(along, "nut ", "", float(stage.nut.length))
    says(along, "roller ", "", float(stage.roller.length))
    says(along, "screw ", ", broken off", float(stage.screw.length))
    ring, half = stage.ring_gear, float(present(stage.carrier.radial_width)) / 2
    says(along, "gear ", "", float(present(stage.gear.face_width)))
    says(along, "carrier ", "", float(present(stage.carrier.length)))
    ends = chart.text("ring gear ", place=along)
    # Length and diameter of the ring gear; length and both diameters of the carrier.
    assert [one.value for one in numbers(ends)] == pytest.approx(
        [
            1e3 * float(present(ring.length)),
            2e3 * (nut + float(present(ring.wall_thickness))),
            1e3 * float(present(stage.carrier.length)),
            2e3 * (centre - half),
            2e3 * (centre + half),
        ],
        abs=5.001e-4,
    )
    # Extension lines stand at the ends of what a dimension names.
    for axes, half in (
        (along, float(stage.nut.length) / 2),
        (along, float(stage.roller.length) / 2),
    ):
        at = [x_data(line)[0] for line in axes.lines if len(set(x_data(line))) == 1]
        assert any(x == pytest.approx(1e3 * half) for x in at)
        assert any(x == pytest.approx(-1e3 * half) for x in at)
    for axes, length in ((along, 10.0), (detail, 1.0)):
        words = chart.text(f"{length:g} mm", place=axes)
        (bar,) = [
            line for line in axes.lines
            if len(x_data(line)) == 2 and line.get_linewidth() == 1.2
            and np.ptp(line.get_ydata()) == 0
        ]  # fmt: skip
        assert np.ptp(bar.get_xdata()) == pytest.approx(length)
        assert words
    pitch = chart.text("pitch ")
    found = [one.value for one in numbers(pitch)]
    starts = float(thread.starts)
    lead = float(thread.lead)
    assert found == pytest.approx([1e3 * lead / starts, 1e3 * lead, starts], abs=5e-4)
    assert "lead" in pitch.split("(")[1]
    says(detail, "flank α = ", "", float(thread.flank_angle), "rad")
    says(detail, "ρ = ", "", float(thread.profile_radius))
    (arc,) = [p for p in detail.patches if isinstance(p, Arc)]
    assert arc.theta2 - arc.theta1 == pytest.approx(math.degrees(float(thread.flank_angle)))
    heading = chart.text("N = ")
    assert numbers(heading)[0].value == count
    # One scale for both views, and another for the detail, as the foot says.
    ratios = [float(a) / float(b) for a, b in re.findall(r"([\d.]+) : ([\d.]+)[,.]", foot)]
    width = chart.figure.get_size_inches()[0] * 25.4
    for axes, ratio in ((across, ratios[0]), (along, ratios[0]), (detail, ratios[1])):
        on_paper = axes.get_position().width * width
        assert on_paper / np.ptp(axes.get_xlim()) == pytest.approx(ratio, rel=5e-3)
    # Threads: crests and roots in the detail lie about the nominal radii.
    outlines = [line for line in detail.lines if len(x_data(line)) > 40]
    middles = [np.mean([min(y_data(line)), max(y_data(line))]) for line in outlines]
    nominal = [screw, nut, centre + roller, centre - roller]
    for height, radius in zip(middles, nominal, strict=True):
        assert height == pytest.approx(1e3 * radius, abs=0.25 * 1e3 * lead / starts)
    for axes in chart.axes:
        chart.ignore([*axes.lines, *axes.patches, *axes.collections])
    chart.finish()


def test_the_reader_of_figures_sees_what_was_left_out():
    chart = Chart(sensitivity_bars(["efficiency"], ["lead"], [[0.5]]))
    left = chart.unread()
    assert any(words.startswith("Patch") for words in left)
    assert "'+0.500'" in left
