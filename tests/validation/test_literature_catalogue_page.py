"""Numbers of `docs/catalogue_witness.md`: its tables of errors and of hypotheses."""

import re
from pathlib import Path

import numpy as np
import pytest

from prsm_jax.catalogue_sizes import FITTED
from prsm_jax.validation import PREDICTED, compare_catalogue
from prsm_jax.validation.catalogue._fit import CapacityModel, fitted_rules
from prsm_jax.validation.catalogue._hypotheses import hypotheses

PAGE = (Path(__file__).parents[2] / "docs" / "catalogue_witness.md").read_text(encoding="utf-8")
COLUMNS = ("static_capacity_kn", "dynamic_capacity_kn")


def _numbers(start):
    """Percentages and other numbers of the one line of a table that begins so."""
    (line,) = [line for line in PAGE.splitlines() if line.startswith(f"| {start}")]
    cells = [cell.strip() for cell in line.strip("| ").split("|")][1:]
    return [[float(x) for x in re.findall(r"\d+(?:\.\d+)?", cell)] for cell in cells]


def _percents(errors):
    return [100 * float(np.median(errors)), 100 * float(np.percentile(errors, 90))]


@pytest.fixture(scope="module")
def comparison():
    return compare_catalogue()


def test_errors_of_both_halves(comparison):
    half = comparison.predicted_half
    rules = fitted_rules(comparison, half)
    exchanged = CapacityModel(comparison, FITTED.fatigue_rule).capacities(rules)
    for column, computed in zip(COLUMNS, exchanged, strict=True):
        found = comparison.summary(column, half)
        other = np.abs(computed / comparison.printed[column] - 1)[~half]
        expected = [100 * found.median, 100 * found.percentile_90, *_percents(other)]
        printed = [x for cell in _numbers(PREDICTED[column].name) for x in cell if x]
        # One decimal; the symbol C_0a in the name of the row is not among the cells.
        np.testing.assert_allclose(printed, expected, atol=0.051)
    # "With the halves exchanged the numbers are 3.8 and 4.6 p, 22 mm, 0.82, 13 mm and 0.028."
    numbers = rules.profile_ratio, rules.coarse_profile_ratio, 1e3 * rules.thread_ends
    assert [round(float(x or 0), 1) for x in numbers[:2]] == [3.8, 4.6]
    assert [round(x) for x in (numbers[2], 1e3 * rules.roller_ends)] == [22, 13]
    assert round(rules.material_factor, 2) == 0.82
    assert round(rules.friction_by_starts, 3) == 0.028
    assert "3.8 and\n4.6 p, 22 mm, 0.82, 13 mm and 0.028" in PAGE


def test_errors_of_masses_and_inertias(comparison):
    for column in ("nut_mass_kg", "nut_inertia_kg_mm2", "rollers_inertia_at_screw_kg_mm2"):
        found = comparison.summary(column)
        expected = [found.median, found.percentile_90, found.beyond_rounding_90]
        printed = [cell[0] for cell in _numbers(PREDICTED[column].name)]
        np.testing.assert_allclose(printed, 100 * np.array(expected), atol=0.051)


def test_hypotheses(comparison):
    """Each is fitted to one half of the diameters and predicts the other half."""
    half = comparison.predicted_half
    lines = [line for line in PAGE.partition("| hypothesis |")[2].splitlines()[2:9] if line]
    found = list(hypotheses(comparison, ~half))
    assert len(found) == len(lines) == 7
    for one, line in zip(found, lines, strict=True):
        *_, static, dynamic = (cell.strip() for cell in line.strip("| ").split("|"))
        for cell, column, computed in zip(
            (static, dynamic), COLUMNS, (one.static, one.dynamic), strict=True
        ):
            errors = np.abs(computed / comparison.printed[column] - 1)[half]
            printed = [float(x) for x in re.findall(r"\d+\.\d+", cell)]
            np.testing.assert_allclose(printed, _percents(errors), atol=0.051)
    # What speaks for the rules: less than half of the next best error of the dynamic capacity.
    printed = comparison.printed["dynamic_capacity_kn"]
    medians = [float(np.median(np.abs(one.dynamic / printed - 1)[half])) for one in found]
    assert medians[5] < 0.5 * min(medians[:5] + medians[6:])
