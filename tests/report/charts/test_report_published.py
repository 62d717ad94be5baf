"""Figures of the papers, computed anew: the printed values lie on the curves."""

import numpy as np
import pytest
from report_checks import assert_printable, axis_labels

from prsm_jax._errors import UnknownNameError
from prsm_jax.report import published_figure
from prsm_jax.validation import published_figures
from prsm_jax.validation._examples import knees


@pytest.fixture(scope="module")
def figures():
    return {(figure.source, figure.number): figure for figure in published_figures()}


def test_the_six_figures_can_be_printed(figures):
    assert set(figures) == {("li2020", n) for n in (8, 9, 10)} | {("li2021", n) for n in (3, 4, 5)}
    for figure in figures.values():
        drawn = published_figure(figure)
        assert_printable(drawn)
        labels = axis_labels(drawn)
        assert labels.count("time in ms") == len(figure.panels)
        for panel in figure.panels:
            if panel.unit != "1":
                assert any(label.endswith(f" in {panel.unit}") for label in labels)


def test_printed_values_lie_on_the_curves(figures):
    """To the printed digits: levels at the start or in the end of the first case."""
    for figure in figures.values():
        for panel in figure.panels:
            curve = panel.curves[0].y
            for mark in panel.marks:
                if mark.level is not None:
                    assert min(abs(curve[[0, -1]] - mark.level)) < 0.01


def test_curves_of_2021_end_where_the_figures_do(figures):
    for number in (3, 4, 5):
        figure = figures["li2021", number]
        assert figure.time[-1] == pytest.approx(0.75e-3)
        for panel in figure.panels:
            assert {len(curve.y) for curve in panel.curves} == {len(figure.time)}


def test_an_unknown_source_is_refused():
    with pytest.raises(UnknownNameError, match="li2020"):
        published_figures("li2022")
    assert published_figures("wu2022") == ()


def test_knees_are_where_a_curve_bends_over():
    time = np.linspace(0.0, 10.0, 1001)
    # Two ramps that end at 2 and at 7, rounded; the sum of their lengths is what they rise by.
    ramp = np.clip(time - 1.0, 0, 1) + np.clip(time - 6.0, 0, 1)
    smooth = np.convolve(ramp, np.hanning(31) / np.hanning(31).sum(), mode="same")[50:-50]
    assert knees(time[50:-50], smooth) == pytest.approx([2.0, 7.0], abs=0.1)
