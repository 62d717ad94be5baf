"""Every key, cell and picture of a tolerance analysis, against SI numbers."""

import dataclasses
import itertools

import numpy as np
import pytest
from expectations import reads
from matplotlib.container import ErrorbarContainer
from reading_artists import box_of
from reading_figures import Chart, handles
from reading_units import assert_reads, to_si
from scipy.stats import chi2, norm

from prsm_jax.mechanism import Tolerance
from prsm_jax.report import (
    contribution_bars,
    cost_chart,
    tolerance_histograms,
    tolerance_scatter,
    tornado_chart,
    yield_chart,
)
from prsm_jax.uncertainty import CostCurve, ToleranceAnalysis, YieldCurve, ZoneEnds
from prsm_jax.uncertainty._estimates import PROBABILITIES, Estimate
from prsm_jax.uncertainty._result import MethodResult

#: Pressures in Pa: mean, deviation, quantiles.
FIRST = Estimate(2.1e9, 8e6, (2.076e9, 2.0868e9, 2.1e9, 2.1132e9, 2.124e9), 0.97, (0.75, 0.25))
SAMPLED = Estimate(
    mean=2.104e9,
    standard_deviation=7.5e6,
    quantiles=(2.07e9, 2.09e9, 2.105e9, 2.117e9, 2.128e9),
    yield_share=0.955,
    contributions=(0.2, 0.7),
    mean_error=3e5,
    standard_deviation_error=2e4,
    yield_error=0.004,
    contribution_errors=(0.01, 0.02),
)
#: The lead and the contact angle at the ends of their zones; the last design fails.
ENDS = ZoneEnds(2.1e9, np.array([2.094e9, 2.13e9]), np.array([2.107e9, np.nan]))


def _analysis():
    methods = {
        "first_order": MethodResult({"max_pressure": FIRST}, 0.97, None),
        "monte_carlo": MethodResult(
            {"max_pressure": SAMPLED},
            0.95,
            0.005,
            reasons={"no_meshing": 3},
            errors={"backlash": 2},
            samples=4096,
            ends={"max_pressure": ENDS},
        ),
    }
    return ToleranceAnalysis(
        quantities=("max_pressure",),
        units=("Pa",),
        limits=((-float("inf"), 2.12e9),),
        tolerances=(Tolerance("lead", -2e-5, 2e-5), Tolerance("contact_angle", -0.01, 0.01)),
        tolerance_units=("m", "rad"),
        methods=methods,
    )


@reads("verb", "tolerance")
def test_tolerance(run, monkeypatch):
    monkeypatch.setattr("prsm_jax.uncertainty.tolerance", lambda *_, **__: _analysis())
    found, printed = run("tolerance", "wu2022")
    row = found["quantities"]["max_pressure"]
    assert (row["unit"], row["limits"]) == ("Pa", [None, 2.12e9])
    assert (row["mean"], row["standard_deviation"], row["yield"]) == (2.104e9, 7.5e6, 0.955)
    assert list(row["quantiles"].values()) == list(SAMPLED.quantiles)
    assert [float(p) for p in row["quantiles"]] == list(PROBABILITIES)
    # Ranked: the angle first.
    shares = [(one["tolerance"], one["share"]) for one in row["contributions"]]
    assert shares == [("contact_angle", 0.7), ("lead", 0.2)]
    assert row["methods"]["first_order"]["mean"] == 2.1e9
    assert row["zone_ends"] == {
        "nominal": 2.1e9,
        "tolerances": [
            {"tolerance": "lead", "lower": 2.094e9, "upper": 2.107e9},
            {"tolerance": "contact_angle", "lower": 2.13e9, "upper": None},
        ],
    }
    assert (found["yield"], found["samples"], found["failed"]) == (0.95, 4096, 3)
    assert (found["reasons"], found["errors"]) == ({"no_meshing": 3}, {"backlash": 2})
    assert [one["unit"] for one in found["tolerances"]] == ["m", "rad"]
    # Three standard deviations lie between the middle and a limit.
    deviations = [one["standard_deviation"] for one in found["tolerances"]]
    assert deviations == pytest.approx([2e-5 / 3, 0.01 / 3])

    lines = [" ".join(line) for line in printed.lines]
    for method, one in (("first order", FIRST), ("Monte Carlo", SAMPLED)):
        line = next(words for words in lines if words.startswith(f"max_pressure [MPa] {method}"))
        cells = line.removeprefix(f"max_pressure [MPa] {method}").replace("±", " ").split()
        shown = [float(to_si(float(cell), "MPa")) for cell in cells[: 9 if one.mean_error else 7]]
        expected = [one.mean, one.standard_deviation, *one.quantiles]
        if one.mean_error:
            expected = [one.mean, one.mean_error, one.standard_deviation]
            expected += [one.standard_deviation_error, *one.quantiles]
        assert shown == pytest.approx(expected, rel=1e-4)
    # Means differ by 4 MPa of 7.5 MPa, deviations by 8/7.5 − 1.
    first = next(words for words in lines if "first order" in words)
    assert first.endswith("97 % mean -0.533 σ, σ +6.67 %")
    assert any("95.5 ± 0.4 %" in words for words in lines)
    assert "max_pressure contact_angle 70.0" in lines
    assert "max_pressure lead 20.0" in lines
    assert "within all limits (Monte Carlo): 95 ± 0.5 %" in lines
    assert "4096 designs, 3 failed" in lines
    assert "no meshing (3)" in lines
    assert "prsm check: backlash (2)" in lines


#: Pressures [Pa] and ratios of 400 designs, of which the first failed.
_GENERATOR = np.random.default_rng(5)
PRESSURES = 2.1e9 + 8e6 * _GENERATOR.standard_normal(400)
RATIOS = 0.85 + 0.01 * _GENERATOR.standard_normal(400)
PRESSURES[0] = RATIOS[0] = np.nan
#: Changes for one standard deviation of each tolerance: no multiples of each other.
SLOPES = {"max_pressure": np.array([7e6, 4e6]), "efficiency": np.array([-0.004, 0.009])}
SECOND = Estimate(2.103e9, 8.5e6, FIRST.quantiles, 0.96, (0.7, 0.2))


def _two_quantities():
    ratio = Estimate(0.85, 0.00985, (0.82, 0.83, 0.85, 0.86, 0.88), None, (0.165, 0.835))
    still = Estimate(0.85, 0.0, (0.85,) * 5, None, (0.0, float("nan")))
    methods = {
        "first_order": MethodResult(
            {"max_pressure": FIRST, "efficiency": ratio}, 0.97, None, slopes=SLOPES
        ),
        "second_order": MethodResult({"max_pressure": SECOND, "efficiency": ratio}, 0.96, None),
        "monte_carlo": MethodResult(
            {"max_pressure": SAMPLED, "efficiency": still},
            0.95,
            0.005,
            reasons={"no_meshing": 1},
            samples=400,
            values={"max_pressure": PRESSURES, "efficiency": RATIOS},
        ),
    }
    return ToleranceAnalysis(
        quantities=("max_pressure", "efficiency"),
        units=("Pa", "1"),
        limits=((-float("inf"), 2.12e9), (0.83, float("inf"))),
        tolerances=(Tolerance("lead", -2e-5, 2e-5), Tolerance("contact_angle", -0.01, 0.01)),
        tolerance_units=("m", "rad"),
        methods=methods,
    )


@reads("chart", "tolerance_histograms")
def test_distributions():
    analysis = _two_quantities()
    chart = Chart(tolerance_histograms(analysis))
    for axes, name, unit, samples, limit in (
        (chart.axes[0], "max_pressure", "Pa", PRESSURES, 2.12e9),
        (chart.axes[1], "efficiency", "1", RATIOS, 0.83),
    ):
        good = samples[1:]
        edges = np.linspace(good.min(), good.max(), 41)
        counts = [np.sum((good >= a) & (good < b)) for a, b in itertools.pairwise(edges)]
        counts[-1] += 1
        left = [box_of(bar).get_x() for bar in axes.patches]
        np.testing.assert_allclose(chart.si(axes, "x", left, unit), edges[:-1], rtol=1e-9)
        assert axes.get_ylabel() == "mechanisms in %"
        # Of all 400 designs: the one that failed is missing in every bar.
        chart.bars(axes, np.array(counts) / 400, "1")
        chart.level(axes, limit, unit, "x")
        width = edges[1] - edges[0]
        for method in ("first_order", "second_order"):
            one = analysis.methods[method].estimates[name]
            line = chart.lines(axes)[0]
            at = np.linspace(edges[0], edges[-1], 201)
            share = width * norm.pdf(at, one.mean, one.standard_deviation)
            chart.curve(axes, line, at, share, (unit, "1"))
    assert chart.axes[0].get_xlabel() == "max pressure in MPa"
    assert chart.axes[1].get_title("left") == "Efficiency"
    assert handles(chart.figure) == ["Monte Carlo", "first order", "second order", "limit"]
    chart.finish()


@reads("chart", "contribution_bars")
def test_contributions_are_ranked():
    chart = Chart(contribution_bars(_two_quantities()))
    first, second = chart.axes
    assert chart.text("Contributions").endswith("(Monte Carlo)")
    # 0.2 and 0.7 of the variance of the pressure.
    assert chart.ticks(first) == ["contact angle", "lead"]
    chart.bars(first, [0.7, 0.2], "1", "x", starts=[0, 0])
    assert [chart.text("70"), chart.text("20")] == ["70.0", "20.0"]
    # One share of the efficiency is not known; it is last.
    assert chart.ticks(second) == ["lead", "contact angle"]
    chart.bars(second, [0.0, 0.0], "1", "x", starts=[0, 0])
    assert chart.text("0.0")
    chart.text("not known")
    for axes in chart.axes:
        assert axes.get_xlabel() == "share of the variance in %"
        assert axes.get_ylim()[0] > axes.get_ylim()[1]
    chart.finish()


@reads("chart", "tolerance_scatter")
def test_two_quantities_with_their_ellipse():
    chart = Chart(tolerance_scatter(_two_quantities(), "max_pressure", "efficiency"))
    (axes,) = chart.axes
    chart.level(axes, 2.12e9, "Pa", "x")
    chart.level(axes, 0.83, "1")
    points, ellipse = chart.lines(axes)
    keep = slice(1, None)
    at = [np.asarray(data, float)[keep] for data in (points.get_xdata(), points.get_ydata())]
    np.testing.assert_allclose(chart.si(axes, "x", at[0], "Pa"), PRESSURES[1:], rtol=1e-9)
    np.testing.assert_allclose(chart.si(axes, "y", at[1], "1"), RATIOS[1:], rtol=1e-9)
    chart.take(points)
    # Every point of the ellipse has the squared distance of which chi-squared has 95 %.
    x = chart.si(axes, "x", np.asarray(ellipse.get_xdata(), float), "Pa") - FIRST.mean
    y = chart.si(axes, "y", np.asarray(ellipse.get_ydata(), float), "1") - 0.85
    moved = np.stack([x, y])
    slopes = np.stack([SLOPES["max_pressure"], SLOPES["efficiency"]])
    distance = np.sum(moved * np.linalg.solve(slopes @ slopes.T, moved), axis=0)
    np.testing.assert_allclose(distance, chi2.ppf(0.95, 2), rtol=1e-8)
    # It goes all the way round: its reach in x is that of one quantity.
    reach = np.sqrt(chi2.ppf(0.95, 2)) * np.linalg.norm(SLOPES["max_pressure"])
    assert x.max() == pytest.approx(reach, rel=1e-3)
    assert x.min() == pytest.approx(-reach, rel=1e-3)
    chart.take(ellipse)
    assert chart.text("95 % ellipse") == "95 % ellipse (first order)"
    chart.finish()


def test_what_cannot_be_drawn_is_said():
    one = _analysis()
    with pytest.raises(ValueError, match='compute the analysis with method="all"'):
        tolerance_scatter(one, "max_pressure", "max_pressure")
    with pytest.raises(KeyError, match="mass; the analysis has max_pressure, efficiency"):
        tolerance_scatter(_two_quantities(), "mass", "efficiency")
    failed = dataclasses.replace(
        one, methods={"first_order": MethodResult({}, None, None, reasons={"no_meshing": 1})}
    )
    for chart in (tolerance_histograms, contribution_bars):
        with pytest.raises(ValueError, match="not valid, so there is nothing to draw"):
            chart(failed)
    with pytest.raises(ValueError, match="no tolerances reach one of the yields"):
        cost_chart(CostCurve(np.array([0.9]), np.array([np.nan]), 0.8, 3.0))


def _ended(ends: ZoneEnds, method: str = "monte_carlo") -> ToleranceAnalysis:
    """The analysis by one method, with these values at the ends of the zones."""
    one = MethodResult({"max_pressure": FIRST}, 0.97, None, ends={"max_pressure": ends})
    return dataclasses.replace(_analysis(), methods={method: one})


@reads("chart", "tornado_chart")
def test_ends_of_the_tolerance_zones():
    chart = Chart(tornado_chart(_analysis(), "max_pressure"))
    (axes,) = chart.axes
    assert axes.get_xlabel() == "max pressure in MPa"
    # The angle moves the pressure more, although one of its ends fails.
    names, zones = zip(*(label.split("\n") for label in chart.ticks(axes)), strict=True)
    assert names == ("contact angle", "lead")
    for zone, (value, unit) in zip(zones, ((0.01, "rad"), (2e-5, "m")), strict=True):
        assert zone.startswith("±")
        assert_reads(zone.removeprefix("±"), (value, unit))
    heights = [box_of(bar).get_y() + box_of(bar).get_height() / 2 for bar in axes.patches]
    assert heights == pytest.approx([0, 1, 1])
    colours = [bar.get_facecolor() for bar in axes.patches]
    assert colours[0] == colours[1] != colours[2]
    # Lower end of the angle; lower and upper end of the lead.
    chart.bars(axes, [3e7, -6e6, 7e6], "Pa", "x", starts=[2.1e9] * 3)
    for value in (2.13e9, 2.094e9, 2.107e9):
        words = chart.text(f"{value / 1e6:.1f}")
        assert float(to_si(float(words), "MPa")) == pytest.approx(value)
    chart.text("fails at its upper end")
    chart.level(axes, 2.1e9, "Pa", "x")
    chart.level(axes, 2.12e9, "Pa", "x")
    chart.says("nominal: ", (2.1e9, "Pa"))
    chart.says("limit: ", (2.12e9, "Pa"))
    assert chart.text("One number").endswith("(every end analysed)")
    assert handles(chart.figure)[:2] == ["lower end of the zone", "upper end of the zone"]
    chart.finish()


def test_both_ends_on_one_side_have_bars_of_half_the_height():
    ends = ZoneEnds(2.1e9, np.array([2.11e9, 2.1e9]), np.array([2.104e9, 2.1e9]))
    chart = Chart(tornado_chart(_ended(ends, "first_order"), "max_pressure"))
    (axes,) = chart.axes
    boxes = [box_of(bar) for bar in axes.patches]
    first, second = boxes[:2]
    # The one above the other.
    assert first.get_y() + first.get_height() <= second.get_y() + 1e-12
    half = boxes[2].get_height() / 2
    assert [first.get_height(), second.get_height()] == pytest.approx([half, half])
    chart.bars(axes, [1e7, 4e6, 0, 0], "Pa", "x", starts=[2.1e9] * 4)
    assert chart.text("One number").endswith("(from first derivatives at the middle of the zones)")
    # A tolerance that changes nothing has its value once.
    chart.text("2110")
    chart.text("2104")
    chart.text("2100")
    assert not [words for words in chart.words() if words.get_text() == "2100.0"]


def test_a_limit_far_away_and_a_nominal_design_that_fails():
    near = ZoneEnds(2.1e9, np.array([2.0999e9, 2.1e9]), np.array([2.1001e9, 2.1e9]))
    chart = Chart(tornado_chart(_ended(near), "max_pressure"))
    # The limit of 2120 MPa is a hundred times as far away as the bars are long.
    chart.level(chart.axes[0], 2.1e9, "Pa", "x")
    assert chart.lines(chart.axes[0]) == []
    assert len(handles(chart.figure)) == 3
    failed = dataclasses.replace(near, nominal=float("nan"))
    with pytest.raises(ValueError, match="max_pressure has no nominal value"):
        tornado_chart(_ended(failed), "max_pressure")
    with pytest.raises(KeyError, match="mass; the analysis has max_pressure"):
        tornado_chart(_analysis(), "mass")


def _narrow():
    """An efficiency of 80.4918 % with a standard deviation of 1.5·10⁻⁵ %."""
    deviation = 1.5e-7
    level = 0.804918
    quantiles = tuple(level + k * deviation for k in (-3.0, -1.6, 0.0, 1.6, 3.0))
    one = Estimate(level, deviation, quantiles, None, (0.9, 0.1))
    ends = ZoneEnds(level, np.array([level - 4e-7, level]), np.array([level + 5e-7, level + 2e-8]))
    values = level + deviation * np.random.default_rng(2).standard_normal(200)
    slopes = {"efficiency": np.array([1.4e-7, 0.5e-7]), "max_pressure": np.array([2e3, 1e3])}
    pressure = Estimate(2.1e9, 2.2e3, (2.1e9,) * 5, None, (0.8, 0.2))
    both = {"efficiency": one, "max_pressure": pressure}
    samples = {"efficiency": values, "max_pressure": 2.1e9 + 1e10 * (values - level)}
    methods = {
        "first_order": MethodResult(both, None, None, slopes=slopes),
        "monte_carlo": MethodResult(
            both, None, None, samples=200, values=samples, ends={"efficiency": ends}
        ),
    }
    return dataclasses.replace(
        _two_quantities(), methods=methods, limits=(None, None)
    ), ends, quantiles  # fmt: skip


def test_a_scatter_far_below_the_value_can_be_read():
    """Numbers differ in the picture and in the table, and axes have no addend at their end."""
    analysis, ends, quantiles = _narrow()
    figures = [
        tornado_chart(analysis, "efficiency"),
        tolerance_scatter(analysis, "efficiency", "max_pressure"),
        tolerance_histograms(analysis),
    ]
    for figure in figures:
        for axes in figure.axes:
            for axis in (axes.xaxis, axes.yaxis):
                assert axis.get_offset_text().get_text() == ""
            boxes = [
                one.get_window_extent()
                for one, at in zip(axes.get_xticklabels(), axes.get_xticks(), strict=True)
                if one.get_text() and axes.get_xlim()[0] <= at <= axes.get_xlim()[1]
            ]
            assert len(boxes) >= 2
            assert all(a.x1 < b.x0 for a, b in itertools.pairwise(boxes))
    chart = Chart(figures[0])
    found = [float(chart.text(start)) for start in ("80.49176", "80.49185", "80.491802")]
    expected = [100 * value for value in (ends.lower[0], ends.upper[0], ends.upper[1])]
    # To a tenth of the bar.
    assert found == pytest.approx(expected, abs=1e-7)
    assert "nominal: 80.49180" in chart.text("nominal: ")
    row = next(line for line in analysis.text().split("\n") if "efficiency" in line)
    cells = row.split("first order")[1].split()
    assert [float(cell) for cell in cells[2:7]] == pytest.approx(
        [100 * one for one in quantiles], abs=1.5e-6
    )
    assert len(set(cells[2:7])) == 5


@reads("chart", "yield_chart")
def test_yield_against_the_width_of_all_tolerances():
    factors = np.array([0.5, 1.0, 2.0])
    yields = {"first_order": np.array([0.99, 0.9, 0.6]), "monte_carlo": np.array([1.0, 0.88, 0.55])}
    errors = {"first_order": np.zeros(3), "monte_carlo": np.array([0.001, 0.004, 0.01])}
    chart = Chart(yield_chart(YieldCurve(factors, yields, errors)))
    (axes,) = chart.axes
    assert axes.get_xlabel() == "width of all tolerances relative to the given ones"
    assert axes.get_ylabel() == "within all limits in %"
    chart.level(axes, 1.0, "1", "x")
    line, points = chart.lines(axes)
    chart.curve(axes, line, factors, yields["first_order"], ("1", "1"))
    chart.curve(axes, points, factors, yields["monte_carlo"], ("1", "1"))
    assert line.get_label() == "first order"
    (bars,) = [one for one in axes.containers if isinstance(one, ErrorbarContainer)]
    assert bars.get_label() == "Monte Carlo"
    (segments,) = bars.lines[2]
    for ends, factor, share, error in zip(
        segments.get_segments(), factors, yields["monte_carlo"], errors["monte_carlo"], strict=True
    ):
        assert ends[:, 0] == pytest.approx(factor)
        # Two standard errors to each side.
        reach = chart.si(axes, "y", ends[:, 1], "1")
        assert reach == pytest.approx([share - 2 * error, share + 2 * error])
    chart.take(segments)
    chart.finish()


@reads("chart", "cost_chart")
def test_cost_against_yield():
    curve = CostCurve(np.array([0.8, 0.9, 0.99]), np.array([3.0, 4.5, np.nan]), 0.85, 5.0)
    chart = Chart(cost_chart(curve))
    (axes,) = chart.axes
    assert axes.get_xlabel() == "within all limits in % (first order)"
    line, given = chart.lines(axes)
    # 99 % cannot be reached.
    for found, shares, costs in ((line, [0.8, 0.9], [3.0, 4.5]), (given, [0.85], [5.0])):
        x, y = (np.asarray(data, float) for data in (found.get_xdata(), found.get_ydata()))
        assert to_si(x, "%") == pytest.approx(shares)
        assert y == pytest.approx(costs)
        chart.take(found)
    chart.text("given tolerances")
    chart.finish()
