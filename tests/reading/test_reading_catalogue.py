"""The catalogue's chart and the errors that `prsm validate catalogue` prints."""

import dataclasses

import numpy as np
import pytest
from expectations import reads
from reading_figures import Chart
from reading_units import to_si

from prsm_jax.report import catalogue_chart
from prsm_jax.validation import PREDICTED, CatalogueComparison

#: Made-up sizes: of a fitted diameter (30 mm), and of one that is predicted (48 mm).
ROWS = (
    {"nominal_diameter_mm": 30.0, "lead_mm": 5.0, "starts": 5.0},
    {"nominal_diameter_mm": 48.0, "lead_mm": 10.0, "starts": 5.0},
    {"nominal_diameter_mm": 48.0, "lead_mm": 20.0, "starts": 5.0},
)


@pytest.fixture
def comparison():
    """Computed numbers are 1.1, 0.9 and 1.3 times the printed ones; one mass is not printed."""
    printed = {name: np.array([2.0, 30.0, 50.0]) * (i + 1) for i, name in enumerate(PREDICTED)}
    computed = {name: values * [1.1, 0.9, 1.3] for name, values in printed.items()}
    printed["nut_mass_kg"] = np.array([6.0, np.nan, 150.0])
    return CatalogueComparison(ROWS, printed, computed, dict.fromkeys(PREDICTED, 0.5))


@reads("chart", "catalogue_chart")
def test_catalogue_chart(comparison):
    chart = Chart(catalogue_chart(comparison))
    columns = [
        ("static_capacity_kn", "Static capacity", "kN", 0.2),
        ("dynamic_capacity_kn", "Dynamic capacity", "kN", 0.2),
        ("nut_mass_kg", "Mass of nut and rollers", "kg", 0.1),
        ("nut_inertia_kg_mm2", "Inertia of the nut", "kg·mm²", 0.1),
        ("rollers_inertia_at_screw_kg_mm2", "Inertia of rollers at screw", "kg·mm²", 0.1),
        ("shaft_inertia_kg_mm2_per_m", "Inertia of the screw", "kg·mm²/m", 0.1),
    ]
    assert len(chart.axes) == len(columns)
    for axes, (name, title, unit, width) in zip(chart.axes, columns, strict=True):
        assert axes.get_title(loc="left") == title
        assert axes.get_xlabel() == f"printed in {unit}"
        assert axes.get_ylabel() == f"computed in {unit}"
        equal, fitted, predicted = chart.lines(axes)
        np.testing.assert_array_equal(equal.get_xdata(), equal.get_ydata())
        chart.take(equal)
        si = {"kN": "N", "kg": "kg"}.get(unit, unit.replace("mm²", "m²"))
        for line, here in ((fitted, [0]), (predicted, [1, 2])):
            printed = comparison.printed[name][here]
            there = np.isfinite(printed)
            x, y = (
                to_si(v[here][there], unit)
                for v in (comparison.printed[name], comparison.computed[name])
            )
            chart.curve(axes, line, x, y, (si, si))
        for way in ("printed", "computed"):
            if "mm²" in unit:
                assert chart.text(way, within=unit) == f"{way} in {unit}"
        (band,) = axes.collections
        edges = np.asarray(band.get_paths()[0].vertices)
        ratios = edges[:, 1] / edges[:, 0]
        assert ratios.min() == pytest.approx(1 - width)
        assert ratios.max() == pytest.approx(1 + width)
        chart.take(band)
    chart.text("diameters that the rules are fitted to")
    chart.text("diameters that are predicted")
    chart.finish()


def test_only_columns_that_are_printed(comparison):
    none = {name: np.full(3, np.nan) for name in PREDICTED}
    some = none | {"static_capacity_kn": comparison.printed["static_capacity_kn"]}
    chart = catalogue_chart(dataclasses.replace(comparison, printed=some))
    (axes,) = (one for one in chart.axes if one.get_visible())
    assert axes.get_title(loc="left") == "Static capacity"
    with pytest.raises(ValueError, match="nothing to draw"):
        catalogue_chart(dataclasses.replace(comparison, printed=none))


def test_validate_catalogue(run, monkeypatch, comparison):
    from prsm_jax import validation

    monkeypatch.setattr(validation, "validate", lambda *_: ())
    monkeypatch.setattr(validation, "compare_catalogue", lambda *_: comparison)
    found, printed = run("validate", "catalogue", "--all")
    assert found["rows"] == []
    assert set(found["catalogue"]["columns"]) == set(PREDICTED)
    for name, column in found["catalogue"]["columns"].items():
        expected = [0.1, 0.3] if name == "nut_mass_kg" else [0.1, 0.1, 0.3]
        assert column["all"]["sizes"] == len(expected)
        assert column["all"]["median"] == pytest.approx(np.median(expected))
        assert column["all"]["percentile_90"] == pytest.approx(np.percentile(expected, 90))
        assert column["all"]["largest"] == pytest.approx(0.3)
        assert column["predicted_half"]["sizes"] == len(expected) - 1
    sizes = found["catalogue"]["sizes"]
    assert [one["lead_mm"] for one in sizes] == [5, 10, 20]
    assert "nut_mass_kg" not in sizes[1]
    assert sizes[2]["static_capacity_kn"] == {
        "printed": 50.0,
        "computed": pytest.approx(65.0),
        "error": pytest.approx(0.3),
    }
    lines = [" ".join(cells) for cells in printed.lines]
    assert "static capacity 3 10.0 % 26.0 % 30.0 % 24.9 %" in lines
    assert "30 x 5 mm, 5 starts static capacity 2 2.2 kN +10.0 %" in lines
    assert "48 x 20 mm, 5 starts static capacity 50 65 kN +30.0 %" in lines
    found, _ = run("validate", "catalogue")
    assert "sizes" not in found["catalogue"]
