"""The three methods agree on a real mechanism, and the verb prints what the function returns."""

import functools
import json

import pytest

import prsm_jax as prsm
from prsm_jax import cli
from prsm_jax.uncertainty import allocate_tolerances

TABLE = """
[tolerances]
lead = "±0.02 mm"
contact_angle = { lower = "-0.5 deg", upper = "0.5 deg", distribution = "uniform" }
roller_radius = { lower = "-5 um", upper = "5 um", distribution = "triangular" }
"thread.coefficient" = "±0.002"

[optimise]
maximise = "efficiency"

[[optimise.variable]]
name = "lead"
lower = "5 mm"
upper = "20 mm"

[[optimise.constraint]]
quantity = "efficiency"
lower = 0.904

[[optimise.constraint]]
quantity = "max_pressure"
upper = "2.135 GPa"
"""


@pytest.fixture(scope="module")
def file_with_tolerances(tmp_path_factory):
    path = tmp_path_factory.mktemp("tolerance") / "toleranced.toml"
    path.write_text(prsm.file.example_text("wu2022") + TABLE, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def analysis(file_with_tolerances):
    return prsm.tolerance(prsm.load(str(file_with_tolerances)), samples=1024, findings=False)


def test_first_and_second_order_agree_with_monte_carlo(analysis):
    """Five standard errors, and what an expansion leaves out, as a share of a deviation.

    First order leaves out the curvature (3e-3), second order the third derivatives (1e-4).
    """
    assert list(analysis.methods) == ["first_order", "second_order", "monte_carlo"]
    for name in ("efficiency", "max_pressure"):
        best = analysis[name]
        for method, share in (("first_order", 3e-3), ("second_order", 1e-4)):
            one = analysis.methods[method].estimates[name]
            spread = best.standard_deviation
            assert one.mean == pytest.approx(best.mean, abs=5 * best.mean_error + share * spread)
            assert one.standard_deviation == pytest.approx(
                spread, abs=5 * best.standard_deviation_error + share * spread
            )
        second = analysis.methods["second_order"].estimates[name]
        assert second.yield_share == pytest.approx(best.yield_share, abs=5 * best.yield_error)
        assert best.standard_deviation_error < 5e-3 * best.standard_deviation
    assert 0.05 < analysis.best.yield_share < 0.95
    assert analysis.ranked("efficiency")[0][0] == "thread.coefficient"
    assert analysis.ranked("max_pressure")[0][0] == "contact_angle"


def test_first_order_is_the_gradient_of_the_sensitivity_table(analysis):
    names = [one.name for one in analysis.tolerances]
    mechanism = prsm.load("wu2022")
    table = prsm.sensitivity(mechanism, ["max_pressure"], names, kinks=False)
    parts = [
        float(table["max_pressure", one.name]) * one.standard_deviation
        for one in analysis.tolerances
    ]
    first = analysis.methods["first_order"].estimates["max_pressure"]
    variance = sum(part**2 for part in parts)
    assert first.standard_deviation == pytest.approx(variance**0.5, rel=1e-10)
    shares = [part**2 / variance for part in parts]
    assert first.contributions == pytest.approx(shares, rel=1e-8, abs=1e-14)


def test_the_verb_prints_the_analysis(file_with_tolerances, analysis, capsys, monkeypatch):
    monkeypatch.setattr("prsm_jax.cli.verbs._tolerance.checked", lambda mechanism: ())
    arguments = ["tolerance", str(file_with_tolerances), "--method", "first_order"]
    assert cli.main([*arguments, "--json", "-"]) == 0
    results = json.loads(capsys.readouterr().out)
    first = analysis.methods["first_order"]
    assert results["method"] == "first_order"
    assert results["yield"] == pytest.approx(first.yield_share, abs=1e-12)
    for name in ("efficiency", "max_pressure"):
        row, one = results["quantities"][name], first.estimates[name]
        assert row["mean"] == pytest.approx(one.mean, rel=1e-12)
        assert row["standard_deviation"] == pytest.approx(one.standard_deviation, rel=1e-9)
        assert row["yield"] == pytest.approx(one.yield_share, rel=1e-9)
        assert list(row["quantiles"].values()) == pytest.approx(one.quantiles, rel=1e-9)
        shares = [entry["share"] for entry in row["contributions"]]
        assert shares == sorted(shares, reverse=True)
        assert {entry["tolerance"] for entry in row["contributions"]} == {
            one.name for one in analysis.tolerances
        }
    assert results["assumptions"]


def test_the_text_has_engineering_units(analysis):
    text = analysis.text()
    best = analysis["max_pressure"]
    line = next(one for one in text.splitlines() if one.startswith("max_pressure [MPa]  Monte"))
    cells = line.split()
    assert float(cells[4]) == pytest.approx(best.mean / 1e6, rel=1e-5)
    assert float(cells[7]) == pytest.approx(best.standard_deviation / 1e6, rel=1e-5)
    assert f"within all limits (Monte Carlo): {100 * analysis.best.yield_share:.5g}" in text
    assert "1024 designs, 0 failed" in text


def test_the_verb_finds_the_tolerances_of_least_cost(
    file_with_tolerances, capsys, monkeypatch, tmp_path
):
    """`--wanted-yield` gives what `allocate_tolerances` returns, as JSON and as text."""
    monkeypatch.setattr("prsm_jax.cli.verbs._tolerance.checked", lambda mechanism: ())
    mechanism = prsm.load(str(file_with_tolerances))
    expected = allocate_tolerances(mechanism, 0.97, verify=False)
    monkeypatch.setattr(
        "prsm_jax.uncertainty.allocate_tolerances",
        functools.partial(allocate_tolerances, verify=False),
    )
    arguments = ["tolerance", str(file_with_tolerances), "--method", "first_order"]
    arguments += ["--wanted-yield", "0.97"]
    assert cli.main([*arguments, "--json", "-"]) == 0
    results = json.loads(capsys.readouterr().out)
    found = results["allocation"]
    assert found["wanted_yield"] == 0.97
    assert found["yield_first_order"] == pytest.approx(0.97, abs=1e-6)
    assert results["yield"] < 0.97
    # Of a search that stops at a relative change of 1e-12.
    assert found["cost"] == pytest.approx(expected.cost, rel=1e-9)
    widths = [row["upper"] - row["lower"] for row in found["tolerances"]]
    assert widths == pytest.approx([2 * one.half_width for one in expected.tolerances], rel=1e-6)
    folder = tmp_path / "out"
    assert cli.main([*arguments, "--out", str(folder)]) == 0
    assert "in place of 4; yield wanted 97 %" in capsys.readouterr().out
    # One method has no samples to scatter.
    names = ["contributions", "cost", "distributions", "yield"]
    names += [f"tornado-{name}" for name in ("efficiency", "max_pressure")]
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        f"tolerance-{name}.{kind}" for name in names for kind in ("png", "svg")
    )


def test_a_file_without_tolerances_is_refused_in_one_line(capsys):
    assert cli.main(["tolerance", "wu2022"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "[tolerances] table" in error
