"""Every key, line and picture of a calibration, against SI numbers."""

import numpy as np
import pytest
import scenes
from expectations import reads
from reading_figures import Chart
from reading_tables import column_unit
from reading_units import to_si

from prsm_jax.calibration import Calibration, FittedParameter, Residuals, Undetermined
from prsm_jax.report import calibration_chart

MEASURED, COMPUTED = np.array([3.1e-6, 5.2e-6, 8.05e-6]), np.array([3.0e-6, 5.3e-6, 8.0e-6])
SHARES, EXPECTED = np.array([0.71, 0.78]), np.array([0.70, 0.80])
LEAD = FittedParameter("lead", "m", 0.010, 0.0103, 0.0002, 0.0098, 0.0108)
ANGLE = FittedParameter(
    "contact_angle", "rad", 0.785, 0.9, float("nan"), float("nan"), float("nan"), "upper"
)
SENTENCE = "The data determine only a sum."


def _fit():
    return Calibration(
        mechanism=scenes.example("wu2022"),
        parameters=(LEAD, ANGLE),
        correlation=np.array([[1.0, np.nan], [np.nan, np.nan]]),
        residual_rms=0.031,
        undetermined=(Undetermined(("lead",), (1.0,), 0.7, SENTENCE),),
        residuals=(
            Residuals("axial_deflection", "m", ("axial_deflection",) * 3, MEASURED, COMPUTED, {}),
            Residuals("efficiency", "1", ("efficiency",) * 2, SHARES, EXPECTED, {}),
        ),
        scales={"axial_deflection": 5e-6, "efficiency": 0.8},
        loss="squared",
        degrees_of_freedom=4,
        code="converged",
        message="fitted",
        steps=7,
    )


@reads("chart", "calibration_chart")
def test_measured_against_computed_and_residuals():
    chart = Chart(calibration_chart(_fit()))
    for row, (measured, computed, unit) in enumerate(
        [(MEASURED, COMPUTED, "m"), (SHARES, EXPECTED, "1")]
    ):
        left, right = chart.axes[2 * row : 2 * row + 2]
        residuals = measured - computed
        equal, points = chart.lines(left)
        ends = [min(*measured, *computed), max(*measured, *computed)]
        chart.curve(left, equal, ends, ends, (unit, unit))
        chart.curve(left, points, computed, measured, (unit, unit))
        rms = np.sqrt(np.mean(residuals**2))
        for level in (0.0, -2 * rms, 2 * rms):
            chart.level(right, level, unit)
        (points,) = chart.lines(right)
        chart.curve(right, points, computed, residuals, (unit, unit))
        assert chart.text("Residuals", place=right).endswith("(dotted: ± 2 r.m.s.)")
    assert chart.axes[0].get_xlabel() == "computed axial deflection in µm"
    assert chart.axes[2].get_ylabel() == "measured efficiency in %"
    chart.finish()


@reads("verb", "calibrate")
def test_calibrate(run, monkeypatch):
    monkeypatch.setattr("prsm_jax.calibration.calibrate", lambda *_, **__: _fit())
    found, printed = run("calibrate", "wu2022", "--data", "wu2022_torque")
    lead, angle = found["parameters"]["lead"], found["parameters"]["contact_angle"]
    assert [lead[key] for key in ("value", "standard_deviation", "lower", "upper", "start")] == [
        0.0103,
        0.0002,
        0.0098,
        0.0108,
        0.010,
    ]
    assert (angle["value"], angle["lower"], angle["active_bound"]) == (0.9, None, "upper")
    assert found["correlation"] == [[1.0, None], [None, None]]
    assert (found["residual_rms"], found["code"], found["valid"]) == (0.031, "converged", True)
    assert found["undetermined"][0]["sentence"] == SENTENCE
    assert found["residuals"][0]["measured"] == list(MEASURED)
    assert found["residuals"][0]["rms"] == pytest.approx(
        np.sqrt(np.mean((MEASURED - COMPUTED) ** 2))
    )
    head = ["start", "fitted", "standard deviation", "95 % from", "to", "at bound"]
    assert printed.row("start") == head[1:]
    for one in (LEAD, ANGLE):
        cells = next(c for c in printed.lines if c[0].split(" [")[0] == one.name)
        printed.lines.remove(cells)
        numbers = (one.start, one.value, one.standard_deviation, one.lower, one.upper)
        for cell, value in zip(cells[1:-1], numbers, strict=True):
            if np.isnan(value):
                assert cell == "–"
            else:
                assert float(to_si(float(cell), column_unit(cells[0]))) == pytest.approx(
                    value, 1e-5
                )
        assert cells[-1] == (one.active_bound or "–")
    assert printed.row("values") == ["root mean square", "largest"]
    for name, residuals in (
        ("axial_deflection", MEASURED - COMPUTED),
        ("efficiency", SHARES - EXPECTED),
    ):
        cells = next(c for c in printed.lines if c[0].split(" [")[0] == name)
        printed.lines.remove(cells)
        assert cells[1] == str(len(residuals))
        shown = [float(to_si(float(cell), column_unit(cells[0]))) for cell in cells[2:]]
        expected = [np.sqrt(np.mean(residuals**2)), np.max(np.abs(residuals))]
        assert shown == pytest.approx(expected, rel=1e-5)
    title = [line for line in printed.lines if line[0] == SENTENCE]
    assert title
    printed.finish()
