"""`plot` of every result that has a chart: which chart, of what, with which options."""

import dataclasses
import inspect
import sys
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax
from prsm_jax import report
from prsm_jax.contact import HertzContact, LineContactResult, StageContact
from prsm_jax.results import _charts
from prsm_jax.sensitivities import Sensitivity

_MODULE = sys.modules["prsm_jax.report._charts_of_results"]
#: Charts that take the result and nothing else.
_DIRECT = {
    "Calibration": report.calibration_chart,
    "CostCurve": report.cost_chart,
    "DriverStudy": report.study_maps,
    "FrequencyLoci": report.frequency_loci_chart,
    "LoadDistribution": report.thread_load_chart,
    "SubsurfaceStress": report.stress_section,
    "Transient": report.transient_chart,
    "YieldCurve": report.yield_chart,
}


def _kinds() -> dict[str, Any]:
    return {kind.__name__: chart for kind, chart in _charts._charts.items()}


def test_results_with_one_chart_are_drawn_by_it():
    kinds = _kinds()
    assert {name: kinds[name] for name in _DIRECT} == _DIRECT


@pytest.fixture
def drawn(monkeypatch):
    """Charts are replaced by what they are called with."""
    for name in vars(_MODULE):
        if name.endswith(("_chart", "_bars", "_ellipses", "_map", "_section", "_histograms")):
            call = lambda *args, _name=name, **kwargs: (_name, args, kwargs)  # noqa: E731
            monkeypatch.setattr(_MODULE, name, call)
    # Without the checks of types: what stands for a result is no result.
    return {name: inspect.unwrap(chart) for name, chart in _kinds().items()}


#: Options, and the chart and its arguments, where the result is `R`.
_CASES = {
    "SteadyState": [({}, "loss_chart", ({"operating point": "R"},))],
    "Modes": [({"label": "a"}, "frequency_chart", ({"a": "R"},))],
    "ForceDeflection": [({}, "force_deflection_chart", ({"nut": "R"},))],
    "StageContact": [({}, "contact_ellipses", ({"threads": "R"},))],
    "HertzContact": [({"friction": 0.2}, "subsurface_chart", ("R", 0.3))],
    "FlankContact": [({"label": "b"}, "pressure_map", ({"b": "R"},))],
    "LineContactResult": [({"contact": 7}, "line_contact_chart", (7, "R"))],
    "LoadSpectrum": [({"capacity": 5.0}, "life_chart", (5.0, "R"))],
    "ParetoFront": [({}, "front_chart", ("R",)), ({"kind": "parallel"}, "parallel_chart", ("R",))],
    "ToleranceAnalysis": [
        ({}, "tolerance_histograms", ("R",)),
        ({"kind": "contributions"}, "contribution_bars", ("R",)),
        ({"quantity": "mass"}, "tornado_chart", ("R", "mass")),
    ],
}


@pytest.mark.parametrize("name", _CASES)
def test_options_of_plots(drawn, name):
    for options, chart, arguments in _CASES[name]:
        found, given, _ = drawn[name]("R", **options)
        assert (found, given) == (chart, arguments)


def test_plots_that_look_into_the_result(drawn):
    table = SimpleNamespace(
        quantities=("a", "b"),
        parameters=("p",),
        elasticity=np.array([[0.5], [0.0]]),
        elasticity_defined=np.array([True, False]),
    )
    name, (quantities, parameters, values), _ = drawn["Sensitivity"](table)
    assert (name, quantities, parameters) == ("sensitivity_bars", ("a", "b"), ("p",))
    np.testing.assert_array_equal(values, [[0.5], [np.nan]])
    response = SimpleNamespace(response="nut u", excitation="screw u")
    _, (curves, modes), _ = drawn["FrequencyResponse"](response, modes=3)
    assert (list(curves), modes) == (["nut u per screw u"], 3)
    diagram = SimpleNamespace(critical_speeds=np.array([[0.0, 7.0, 12.0]]))
    assert drawn["Campbell"](diagram)[1] == (diagram, 21.0)
    assert drawn["Campbell"](diagram, max_speed=5.0)[1] == (diagram, 5.0)
    mechanism = dataclasses.replace(prsm_jax.load("wu2022"), title="")
    assert drawn["Mechanism"](mechanism, stage=1)[1] == ({"mechanism": mechanism},)


def test_every_chart_of_a_result_is_tested_here():
    looked_into = {"Sensitivity", "FrequencyResponse", "Campbell", "Mechanism", "Optimum"}
    assert set(_kinds()) == {*_DIRECT, *_CASES, *looked_into}


def test_plot_gives_a_figure_and_no_window():
    state = prsm_jax.steady_state(prsm_jax.load("wu2022"))
    figure = state.plot()
    assert [
        text
        for axes in figure.axes
        for text in axes.get_yticklabels()
        if "point" in text.get_text()
    ]
    assert (
        "matplotlib.pyplot" not in sys.modules or not sys.modules["matplotlib.pyplot"].get_fignums()
    )
    assert state.plot(kind="power").axes


def test_a_batch_and_a_result_without_a_chart_say_what_to_do():
    hertz = HertzContact(*(jnp.asarray(0.1 * k) for k in range(1, 8)))
    batch = jax.tree.map(lambda leaf: jnp.stack([leaf, leaf]), hertz)
    with pytest.raises(ValueError, match=r"batch of shape \(2,\), and a chart shows one design"):
        batch.plot()
    with pytest.raises(
        ValueError, match=r"RatingLife has no chart of its own; these .*Calibration"
    ):
        prsm_jax.strength.RatingLife(*(jnp.ones(()),) * 3).plot()
    assert issubclass(Sensitivity, prsm_jax.results.Shown)
    assert all(
        issubclass(one, prsm_jax.results.Result) for one in (StageContact, LineContactResult)
    )
