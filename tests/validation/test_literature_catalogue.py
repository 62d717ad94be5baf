"""A maker's catalogue: computed against printed numbers of 90 sizes.

Limits are the reached errors, rounded up; goals are 20 % in the median and 35 %
at the 90th percentile for the capacities of the diameters that no number was fitted to, and 10 %
for masses and inertias.
"""

import dataclasses

import pytest

from prsm_jax.catalogue_sizes import FITTED
from prsm_jax.validation import compare_catalogue
from prsm_jax.validation.catalogue._fit import fitted_rules
from tests.present import present

#: Median and 90th percentile of the sizes that were not fitted.
CAPACITIES = {"static_capacity_kn": (0.06, 0.11), "dynamic_capacity_kn": (0.025, 0.07)}
#: Median of all sizes, and 90th percentile beyond the rounding of the printed number.
BODIES = {
    "nut_mass_kg": (0.055, 0.07),
    "nut_inertia_kg_mm2": (0.035, 0.08),
    "rollers_inertia_at_screw_kg_mm2": (0.035, 0.05),
    "shaft_mass_kg_per_m": (0.008, 0.006),
    "shaft_inertia_kg_mm2_per_m": (0.007, 0.007),
}


@pytest.fixture(scope="module")
def comparison():
    return compare_catalogue()


@pytest.mark.parametrize("column", CAPACITIES)
def test_capacities_of_the_half_that_was_not_fitted(comparison, column):
    found = comparison.summary(column, comparison.predicted_half)
    median, most = CAPACITIES[column]
    assert found.sizes == 49
    assert 0.9 * median - 0.01 < found.median < median
    assert 0.9 * most - 0.01 < found.percentile_90 < most


@pytest.mark.parametrize("column", BODIES)
def test_masses_and_inertias(comparison, column):
    found = comparison.summary(column)
    assert found.sizes == 90
    median, beyond = BODIES[column]
    assert found.median < median
    assert found.beyond_rounding_90 < beyond


def test_efficiencies_and_play(comparison):
    for column in ("efficiency_screw_drives", "efficiency_load_drives"):
        found = comparison.summary(column)
        assert found.median < 0.02
        assert found.largest < 0.04
    assert comparison.summary("largest_axial_play_mm").largest < 1e-12


def test_the_shipped_rules_are_the_rounded_fit_of_the_first_half(comparison):
    fit = fitted_rules(comparison, ~comparison.predicted_half)
    assert round(present(fit.profile_ratio), 1) == FITTED.profile_ratio
    coarse = round(present(fit.coarse_profile_ratio), 1)
    assert coarse == FITTED.coarse_profile_ratio
    assert round(fit.thread_ends, 3) == FITTED.thread_ends
    assert round(fit.roller_ends, 3) == FITTED.roller_ends
    assert round(fit.material_factor, 2) == FITTED.material_factor
    assert round(fit.friction_by_starts, 3) == FITTED.friction_by_starts
    # Nothing else was fitted.
    ratios, ends = ("profile_ratio", "coarse_profile_ratio"), ("thread_ends", "roller_ends")
    names = (*ratios, *ends, "material_factor", "friction_by_starts")
    own = {name: getattr(FITTED, name) for name in names}
    assert dataclasses.replace(fit, **own) == FITTED
