"""Every key and cell of a tolerance analysis, against SI numbers."""

import pytest
from expectations import reads
from reading_units import to_si

from prsm_jax.mechanism import Tolerance
from prsm_jax.uncertainty import ToleranceAnalysis
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
