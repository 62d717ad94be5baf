"""Pictures of forced vibration: readable, with units, marks at their values."""

import jax.numpy as jnp
import numpy as np
import pytest
from report_checks import assert_printable, axis_labels
from scenes import example

import prsm_jax as prsm
from prsm_jax.report import campbell_chart, response_chart
from prsm_jax.report.vibration_charts._campbell_chart import _spread
from prsm_jax.response import FrequencyResponse


@pytest.fixture(scope="module")
def chart():
    """Wu's mechanism with three harmonics of each order."""
    return prsm.campbell(example("wu2022"), carrier_ratio=0.375)


def _response(kind="receptance", loss=0.1, at_pole=False):
    """One oscillator at 100 Hz: made here, so that no program has to be compiled."""
    hertz = np.geomspace(10.1, 1010, 201)
    value = 1e-6 / (1 - (hertz / 100) ** 2 + 1j * loss)
    marks = np.zeros(len(hertz), bool)
    if at_pole:
        marks[100] = True
        value[100] = np.inf
    return FrequencyResponse(
        jnp.asarray(hertz),
        jnp.asarray(value),
        jnp.asarray(marks),
        "screw u",
        "nut u",
        kind,  # pyright: ignore[reportArgumentType]
    )


def test_a_response_is_drawn_in_decibels_and_degrees():
    found = _response()
    figure = response_chart({"structural": found}, prsm.modal(example("wu2022"), shapes=True))
    assert_printable(figure)
    labels = axis_labels(figure)
    assert "receptance in dB re 1 m/N" in labels
    assert "phase in deg" in labels
    assert "frequency in Hz" in labels
    upper, lower = figure.axes
    curve = max(upper.lines, key=lambda line: len(line.get_xdata()))
    np.testing.assert_allclose(curve.get_ydata(), 20 * np.log10(np.abs(found.value)))
    # The stage has modes at 293 and 839 Hz below the end of the axis.
    marked = [line.get_xdata()[0] for line in upper.lines if len(line.get_xdata()) == 2]
    assert marked == pytest.approx([293.26, 839.13], abs=0.01)
    assert {text.get_text() for text in upper.get_legend().get_texts()} == {"torsional", "carrier"}
    assert lower.get_ylim()[0] < -180 < 180 < lower.get_ylim()[1]


def test_several_responses_are_told_apart_and_a_pole_is_a_gap():
    figure = response_chart({"damped": _response(), "undamped": _response(loss=0, at_pole=True)})
    assert_printable(figure)
    curves = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 2]
    assert len({str(line.get_linestyle()) for line in curves}) == 2
    assert np.isnan(curves[1].get_ydata()).sum() == 1


def test_what_cannot_be_drawn_is_refused():
    with pytest.raises(ValueError, match="at least one response"):
        response_chart({})
    with pytest.raises(ValueError, match="draw one kind"):
        response_chart({"one": _response(), "other": _response("mobility")})
    still = _response()
    still = FrequencyResponse(
        still.frequency, 0 * still.value, still.at_pole, "screw u", "nut x", "receptance"
    )
    with pytest.raises(ValueError, match="nothing moves at nut x"):
        response_chart({"still": still})


def test_crossings_are_marked_at_their_speeds(chart):
    figure = campbell_chart(chart, 628.0)
    assert_printable(figure)
    assert axis_labels(figure) == ["screw speed in rpm", "frequency in Hz"]
    axes = figure.axes[0]
    dots = [line for line in axes.lines if line.get_marker() == "o"]
    crossings = chart.crossings(628.0)
    drawn = sorted((line.get_xdata()[0], line.get_ydata()[0]) for line in dots)
    expected = sorted((c.speed_rpm, c.frequency) for c in crossings)
    np.testing.assert_allclose(drawn, expected, rtol=1e-12)
    full = [line for line in dots if line.get_markerfacecolor() != "white"]
    assert len(full) == sum(c.excited for c in crossings)
    words = [text.get_text() for text in figure.texts]
    assert len(words) == len(full)
    first = next(c for c in crossings if c.excited)
    assert words[0].startswith("1  ")
    assert f"{first.frequency:.0f} Hz" in words[0]


def test_many_crossings_still_fit(chart):
    assert_printable(campbell_chart(chart, 6000.0))
    crowded = prsm.campbell(example("wu2022"), carrier_ratio=0.375, harmonics=8)
    assert_printable(campbell_chart(crowded, 3000.0))


def test_a_chart_without_crossings_is_refused(chart):
    with pytest.raises(ValueError, match="no order meets a natural frequency up to"):
        campbell_chart(chart, 1e-3)
    with pytest.raises(ValueError, match="needs a positive end"):
        campbell_chart(chart, 0.0)


def test_names_are_spread_without_leaving_the_chart():
    places = _spread([0.0, 0.01, 0.02, 0.99, 1.2], 0.1, 0.0, 1.0)
    assert places == sorted(places)
    assert min(np.diff(places)) >= 0.1 - 1e-12
    assert (places[0], places[-1]) == (0.0, 1.0)
