"""Limits in pictures of sweeps: where their lines lie, what is outside, and the best design.

The quantities are products and sums of the axes, which linear interpolation along each axis gives
exactly, so that every position is known in closed form.
"""

import math
from typing import Any

import numpy as np
import pytest
from matplotlib.patheffects import TickedStroke
from reading_artists import vertices_of, x_data, y_data
from reading_figures import Chart, handles
from reading_units import assert_reads, to_si

from prsm_jax.mechanism import Constraint
from prsm_jax.numerics import sobol_points
from prsm_jax.report import sweep_figure, sweep_map

#: The pressure is `_SLOPE` × lead × angle [Pa].
_SLOPE = 2.2e11
LEAD, ANGLE = np.linspace(5e-3, 20e-3, 7), np.radians([30.0, 34.0, 41.0, 45.0, 52.0, 60.0])
LIMITS = {"max_pressure": (None, 2e9), "mass": (1.1, None), "length": (0.0, 9.0)}


def _values(lead: Any, angle: Any) -> dict[str, Any]:
    """Pressure [Pa], mass [kg], efficiency [1] and a length [m] of designs."""
    flat = 0.0 * (lead + angle)
    return {
        "max_pressure": _SLOPE * lead * angle,
        "mass": 0.4 + 100 * lead + flat,
        "efficiency": 0.6 + 10 * lead + 0.1 * angle,
        "length": 0.07 + flat,
    }


_UNITS = {"max_pressure": "Pa", "mass": "kg", "efficiency": "1", "length": "m"}


def _dataset(axes: dict[str, tuple[np.ndarray, str]], lead, angle):
    """A sweep; `lead` and `angle` of all designs."""
    import xarray

    values = _values(lead, angle)
    dims = tuple(axes)
    variables: dict[str, Any] = {
        name: (dims, one, {"units": _UNITS[name]}) for name, one in values.items()
    }
    variables["code"] = (dims, np.zeros(lead.shape, np.int8))
    coords = {name: (name, one, {"units": unit}) for name, (one, unit) in axes.items()}
    return xarray.Dataset(variables, coords)


def _grid(lead=LEAD, angle=ANGLE):
    axes = {"lead": (lead, "m"), "contact_angle": (angle, "rad")}
    return _dataset(axes, *np.meshgrid(lead, angle, indexing="ij"))


def _points(chart: Chart, axes: Any, path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Leads and angles along a path [SI]."""
    return chart.si(axes, "x", path[:, 0], "m"), chart.si(axes, "y", path[:, 1], "rad")


def _is_outside(lead: Any, angle: Any) -> Any:
    values = _values(lead, angle)
    return (values["max_pressure"] > 2e9) | (values["mass"] < 1.1)


def _tick_angle(artist: Any) -> float:
    (ticks,) = (one for one in artist.get_path_effects() if isinstance(one, TickedStroke))
    # matplotlib keeps it under this name alone.
    return float(vars(ticks)["_angle"])


@pytest.mark.parametrize("turned", [False, True], ids=["ascending", "descending"])
def test_a_map(turned):
    """Lines on the limits, ticks and hatching outside, and the best of the designs within."""
    data = _grid(LEAD[::-1], ANGLE[::-1]) if turned else _grid()
    chart = Chart(sweep_map(data, "efficiency", constraints=LIMITS))
    axes, bar = chart.axes
    chart.ignore([*bar.collections, *bar.patches, *bar.lines])
    filled, white, pressure, mass, hatched = axes.collections
    ends = []
    for lines, of, angle in (
        (pressure, lambda p, a: _SLOPE * p * a / 2e9, "pressure"),
        (mass, lambda p, a: (0.4 + 100 * p) / 1.1 + 0 * a, "mass"),
    ):
        (path,) = (vertices_of(one) for one in lines.get_paths())
        lead, up = _points(chart, axes, path)
        # The interpolation is exact, and so are its contours, to rounding.
        np.testing.assert_allclose(of(lead, up), 1.0, rtol=1e-9)
        ends.append((lead, up))
        # A step to the side of the ticks leads out of the limit.
        assert _tick_angle(lines) > 0, angle
        middle = len(path) // 2
        along = path[middle + 1] - path[middle]
        aside = path[middle] + np.array([-along[1], along[0]])
        beyond = _points(chart, axes, aside[None])
        assert of(*beyond)[0] > 1 if lines is pressure else of(*beyond)[0] < 1
    # From edge to edge: the pressure leaves through the top and the right, the mass crosses.
    (lead, up), (_, across) = ends
    assert up.max() == pytest.approx(ANGLE[-1])
    assert max(lead) == pytest.approx(2e9 / (_SLOPE * ANGLE[0]))
    assert [across.min(), across.max()] == pytest.approx([ANGLE[0], ANGLE[-1]])
    (area,) = hatched.get_paths()
    random = np.random.default_rng(3).uniform([5.1, 30.5], [19.9, 59.5], (400, 2))
    inside = [area.contains_point(one) for one in random]
    np.testing.assert_array_equal(inside, _is_outside(*_points(chart, axes, random)))
    (star,) = chart.lines(axes)
    efficiency = np.where(
        _is_outside(data["lead"].values[:, None], data["contact_angle"].values),
        -1.0,
        data["efficiency"].values,
    )
    best = np.unravel_index(np.argmax(efficiency), efficiency.shape)
    place = data["lead"].values[best[0]], data["contact_angle"].values[best[1]]
    # The best of all designs has the largest lead and angle, whose pressure is too high.
    assert place[0] < LEAD[-1]
    chart.curve(axes, star, *place, ("m", "rad"))
    words = [
        ("largest within all limits: ", efficiency[best], "1"),
        ("max pressure ≤ ", 2e9, "Pa"),
        ("mass ≥ ", 1.1, "kg"),
    ]
    for start, value, unit in words:
        chart.says(start, (value, unit))
    for start, value in (("length ≤ ", 9.0), ("length ≥ ", 0.0)):
        found = chart.text(start)
        assert found.endswith(" (all within)")
        assert_reads(found.removeprefix(start), (value, "m", "whole"))
    assert handles(chart.figure)[-1] == "outside of a limit"
    chart.take(filled, white, pressure, mass, hatched)
    chart.finish()


def test_a_map_on_which_no_design_is_within_all_limits():
    limits = {"max_pressure": (None, 1e8), "mass": (None, 1.1)}
    chart = Chart(sweep_figure(_grid(), "efficiency", constraints=limits))
    axes = chart.axes[0]
    assert chart.lines(axes) == []
    assert handles(chart.figure) == [
        "max pressure ≤ 100.0\u202fMPa (all outside)",
        "mass ≤ 1.100\u202fkg",
        "outside of a limit",
        "no design is within all limits",
    ]


def test_slices():
    """The limits of each panel are those at its value of the third axis."""
    import xarray

    load = np.array([2e3, 4e3, 6e3])
    data = xarray.concat([_grid() for _ in load], "load").transpose("lead", "contact_angle", "load")
    data = data.assign_coords(load=("load", load, {"units": "N"}))
    # Only the pressure depends on the load.
    data["max_pressure"] = data["max_pressure"] * (data["load"] / 4e3).assign_attrs()
    data["max_pressure"].attrs["units"] = "Pa"
    constraints = (Constraint("max_pressure", upper=2e9), Constraint("mass", lower=1.1))
    chart = Chart(sweep_figure(data, "efficiency", constraints=constraints))
    panels = chart.axes[:3]
    values = data["efficiency"].values
    within = (data["max_pressure"].values <= 2e9) & (data["mass"].values >= 1.1)
    best = np.unravel_index(np.argmax(np.where(within, values, -1)), values.shape)
    for index, axes in enumerate(panels):
        _, pressure, mass, _ = axes.collections
        (path,) = (vertices_of(one) for one in pressure.get_paths())
        lead, angle = (to_si(path[:, 0], "mm"), to_si(path[:, 1], "deg"))
        np.testing.assert_allclose(_SLOPE * lead * angle * load[index] / 4e3, 2e9, rtol=1e-9)
        (path,) = (vertices_of(one) for one in mass.get_paths())
        np.testing.assert_allclose(to_si(path[:, 0], "mm"), 7e-3, rtol=1e-9)
        stars = [line for line in chart.lines(axes) if line.get_marker() == "*"]
        assert len(stars) == (index == best[2])
        for star in stars:
            np.testing.assert_allclose(to_si(x_data(star), "mm"), LEAD[[best[0]]])
            np.testing.assert_allclose(to_si(y_data(star), "deg"), ANGLE[[best[1]]])
    chart.says("max pressure ≤ ", (2e9, "Pa"))
    chart.says("mass ≥ ", (1.1, "kg"))
    chart.says("largest within all limits: ", (values[best], "1"))


def _over_lead(angle=ANGLE[3]):
    return _dataset({"lead": (LEAD, "m")}, LEAD, np.full_like(LEAD, angle))


def test_lines_of_other_quantities():
    """Ranges of the lead that are outside, from closed forms."""
    chart = Chart(sweep_figure(_over_lead(), "efficiency", constraints=LIMITS))
    (axes,) = chart.axes
    least, most = (1.1 - 0.4) / 100, 2e9 / (_SLOPE * ANGLE[3])
    assert LEAD[0] < least < most < LEAD[-1]
    for value, side in ((least, 60), (most, -60)):
        # A vertical line has the smaller leads on its left.
        assert _tick_angle(chart.level(axes, value, "m", "x")) == side
    chart.bars(axes, [least - LEAD[0], LEAD[-1] - most], "m", "x", starts=[LEAD[0], most])
    curve, star = chart.lines(axes)
    values = 0.6 + 10 * LEAD + 0.1 * ANGLE[3]
    chart.curve(axes, curve, LEAD, values, ("m", "1"))
    best = np.flatnonzero(most >= LEAD)[-1]
    chart.curve(axes, star, LEAD[best], values[best], ("m", "1"))
    chart.says("largest within all limits: ", (values[best], "1"))
    chart.says("max pressure ≤ ", (2e9, "Pa"))
    chart.says("mass ≥ ", (1.1, "kg"))
    for start, value in (("length ≤ ", 9.0), ("length ≥ ", 0.0)):
        assert_reads(chart.text(start).removeprefix(start), (value, "m", "whole"))
    chart.finish()


def test_a_design_exactly_on_a_limit_is_within():
    """Its line goes through the design, and the design can be the best."""
    data = _over_lead()
    limit = float(data["mass"][3])
    chart = Chart(sweep_figure(data, "efficiency", constraints={"mass": (None, limit)}))
    (axes,) = chart.axes
    chart.level(axes, LEAD[3], "m", "x")
    chart.bars(axes, [LEAD[-1] - LEAD[3]], "m", "x", starts=[LEAD[3]])
    star = chart.lines(axes)[-1]
    chart.curve(axes, star, LEAD[3], float(data["efficiency"][3]), ("m", "1"))


def test_lines_of_the_quantity_itself():
    """A level at its limit; one far from all values is told but not drawn."""
    limits = {"max_pressure": (1e6, 2e9), "efficiency": 0.75}
    chart = Chart(sweep_figure(_over_lead(), "max_pressure", sense="minimise", constraints=limits))
    (axes,) = chart.axes
    upper = chart.level(axes, 2e9, "Pa")
    assert _tick_angle(upper) > 0
    # An equality has a line without ticks, and nothing is outside of it.
    equal = chart.level(axes, (0.75 - 0.6 - 0.1 * ANGLE[3]) / 10, "m", "x")
    assert not any(isinstance(one, TickedStroke) for one in equal.get_path_effects())
    most = 2e9 / (_SLOPE * ANGLE[3])
    chart.bars(axes, [LEAD[-1] - most], "m", "x", starts=[most])
    lower = chart.level(axes, 1e6, "Pa")
    assert _tick_angle(lower) < 0
    far = {"max_pressure": (None, 2e12)}
    chart = Chart(sweep_figure(_over_lead(), "max_pressure", constraints=far))
    (axes,) = chart.axes
    curve, star = chart.lines(axes)
    assert (len(x_data(curve)), len(x_data(star))) == (len(LEAD), 1)
    assert handles(chart.figure)[-1] == "max pressure ≤ 2000000\u202fMPa (all within)"


def _list(lead, angle):
    """A list of designs."""
    import xarray

    values = _values(lead, angle)
    return xarray.Dataset(
        {name: ("design", one, {"units": _UNITS[name]}) for name, one in values.items()},
        {
            "lead": ("design", lead, {"units": "m"}),
            "contact_angle": ("design", angle, {"units": "rad"}),
        },
    ).assign(code=("design", np.zeros(len(lead), np.int8)))


def test_a_list_of_designs():
    """Designs outside are hollow; the star is on the best of the others in each panel."""
    lead, angle = np.random.default_rng(8).uniform([5e-3, 0.5], [20e-3, 1.0], (60, 2)).T
    values, data = _values(lead, angle), _list(lead, angle)
    outside = _is_outside(lead, angle)
    assert 5 < outside.sum() < 55
    best = np.argmax(np.where(outside, -1, values["efficiency"]))
    chart = Chart(sweep_figure(data, "efficiency", constraints=LIMITS))
    for panel, where, unit in zip(chart.axes, (lead, angle), ("m", "rad"), strict=True):
        full, hollow, star = chart.lines(panel)
        assert hollow.get_markerfacecolor() == "white"
        assert full.get_markerfacecolor() != "white"
        for line, which in ((full, ~outside), (hollow, outside), (star, [best])):
            np.testing.assert_allclose(chart.si(panel, "x", x_data(line), unit), where[which])
            np.testing.assert_allclose(to_si(y_data(line), "%"), values["efficiency"][which])
    chart.says("max pressure ≤ ", (2e9, "Pa"))
    chart.says("mass ≥ ", (1.1, "kg"))
    # Filled points have an entry as hollow ones have.
    assert {"within all limits", "outside of a limit"} <= set(handles(chart.figure))


def test_the_best_of_a_long_list_is_drawn():
    """4000 of 20000 designs are drawn, and the best of all, which is none of these."""
    lead, angle = np.random.default_rng(0).uniform([5e-3, 0.5], [20e-3, 1.0], (20000, 2)).T
    values = _values(lead, angle)
    best = int(np.argmax(np.where(_is_outside(lead, angle), -1, values["efficiency"])))
    assert best not in np.random.default_rng(0).permutation(20000)[:4000]
    chart = Chart(sweep_figure(_list(lead, angle), "efficiency", constraints=LIMITS))
    full, hollow, star = chart.lines(chart.axes[0])
    np.testing.assert_allclose(chart.si(chart.axes[0], "x", x_data(star), "m"), lead[best])
    np.testing.assert_allclose(to_si(y_data(star), "%"), values["efficiency"][best])
    chart.says("largest within all limits: ", (values["efficiency"][best], "1"))
    assert len(x_data(full)) + len(x_data(hollow)) == 4001
    assert np.isclose(y_data(full), y_data(star)[0], rtol=1e-12).any()
    assert handles(chart.figure)[-1] == "4001 of 20000 designs drawn"
    few = Chart(sweep_figure(_list(lead[:4000], angle[:4000]), "efficiency"))
    assert not any("designs drawn" in words for words in handles(few.figure))


def _flawed(data, where):
    codes = np.where(where, np.full(data["code"].shape, 2, np.int8), np.int8(0))
    return data.assign(error=(data["code"].dims, codes))


def test_points_of_a_long_sequence_are_drawn_over_the_whole_of_each_axis():
    """Every second point of Sobol's sequence lies in one half of the second axis."""
    places = sobol_points(2, 13, 3)
    assert np.all(places[::2, 1] < 0.5) or np.all(places[::2, 1] >= 0.5)
    lead, angle = (places * [15e-3, 0.5] + [5e-3, 0.5]).T
    chart = Chart(sweep_figure(_list(lead, angle), "efficiency"))
    for panel, unit, (lower, upper) in zip(
        chart.axes, ("m", "rad"), ((5e-3, 20e-3), (0.5, 1.0)), strict=True
    ):
        drawn = chart.si(panel, "x", x_data(chart.lines(panel)[0]), unit)
        # A quarter of the points is in each quarter of the range; the scatter of 4000 is 0.7 %.
        counts, _ = np.histogram(drawn, np.linspace(lower, upper, 5))
        assert counts.sum() in (4000, 4001)  # with the best, if it is none of them
        assert np.abs(counts / 4000 - 0.25).max() < 0.03


@pytest.mark.parametrize(
    ("kind", "limits"),
    [("map", None), ("slices", None), ("map", LIMITS), ("points", LIMITS), ("slices", LIMITS)],
)
def test_of_designs_that_all_have_errors_none_is_the_best(kind, limits):
    if kind == "slices":
        axes = {"lead": (LEAD, "m"), "contact_angle": (ANGLE, "rad"), "load": (LEAD, "m")}
        data = _dataset(axes, *np.meshgrid(LEAD, ANGLE, LEAD, indexing="ij")[:2])
    elif kind == "map":
        data = _grid()
    else:
        data = _list(*np.random.default_rng(8).uniform([5e-3, 0.5], [20e-3, 1.0], (60, 2)).T)
    chart = Chart(sweep_figure(_flawed(data, True), "efficiency", constraints=limits))
    assert not [line for axes in chart.axes for line in axes.lines if line.get_marker() == "*"]
    assert handles(chart.figure)[-1] == "no design without an error of prsm check"


def test_designs_without_errors_that_are_all_outside():
    """Those within all limits have errors, and the legend does not say that there are none."""
    data = _grid()
    outside = _is_outside(*np.meshgrid(LEAD, ANGLE, indexing="ij"))
    chart = Chart(sweep_map(_flawed(data, ~outside), "efficiency", constraints=LIMITS))
    assert not [line for line in chart.axes[0].lines if line.get_marker() == "*"]
    words = "no design without an error of prsm check is within all limits"
    assert handles(chart.figure)[-1] == words


def test_the_component_furthest_beyond_its_limit_counts():
    data = _grid()
    stages = data["max_pressure"].expand_dims(stage=[1, 2]).transpose(..., "stage")
    factors = np.array([1.0, 0.5])
    data["max_pressure"] = (stages * factors).assign_attrs(units="Pa")
    for limit, factor in (((None, 1.5e9), 1.0), ((1.5e9, None), 0.5)):
        chart = Chart(sweep_map(data, "efficiency", constraints={"max_pressure": limit}))
        (path,) = (vertices_of(one) for one in chart.axes[0].collections[2].get_paths())
        lead, angle = _points(chart, chart.axes[0], path)
        np.testing.assert_allclose(factor * _SLOPE * lead * angle, 1.5e9, rtol=1e-9)
    # Of an equality each component has a line.
    chart = Chart(sweep_map(data, "efficiency", constraints={"max_pressure": 1.5e9}))
    for lines, factor in zip(chart.axes[0].collections[2:4], factors, strict=True):
        (path,) = (vertices_of(one) for one in lines.get_paths())
        lead, angle = _points(chart, chart.axes[0], path)
        np.testing.assert_allclose(factor * _SLOPE * lead * angle, 1.5e9, rtol=1e-9)


def test_designs_that_failed_have_no_limits():
    """Hatching and lines end where a design has no value."""
    data = _grid()
    data["max_pressure"][-1, -1] = math.nan
    data["efficiency"][-1, -1] = math.nan
    chart = Chart(sweep_map(data, "efficiency", constraints={"max_pressure": (None, 2e9)}))
    hatched = chart.axes[0].collections[-1]
    reach = np.concatenate([vertices_of(one) for one in hatched.get_paths()])
    # The last cell, whose corner failed, is left out but for its edges.
    inner = reach - [1e3 * LEAD[-2], np.degrees(ANGLE[-2])]
    assert np.all(np.min(inner, axis=1) < 1e-9)
    assert np.any(inner > 0, axis=0).all()


def test_what_makes_no_sense_is_refused():
    data = _grid()
    with pytest.raises(ValueError, match="no 'torque', which has a limit; add it"):
        sweep_map(data, "efficiency", constraints={"torque": (None, 1.0)})
    with pytest.raises(ValueError, match="constraint on 'mass' has the limits 'heavy'"):
        sweep_figure(data, "efficiency", constraints={"mass": "heavy"})
    with pytest.raises(ValueError, match=r"lower limit 2.0 is above upper limit 1.0"):
        sweep_figure(data, "efficiency", constraints={"mass": (2.0, 1.0)})
