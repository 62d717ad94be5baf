"""Rules that complete a size of a catalogue: radii, what fits, columns that are used."""

import math
from typing import Any

import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.catalogue_sizes import (
    catalogue_mechanism,
    catalogue_rows,
    plain_catalogue_mechanism,
)

#: One size, all columns that are dimensions.
GIVEN = {
    "crest_diameter_mm": 30.6,
    "root_diameter_mm": 29.0,
    "nut_outer_diameter_mm": 64.0,
    "nut_length_mm": 85.0,
    "roller_circle_diameter_mm": 40.0,
}


def _stage(mechanism: prsm.Mechanism) -> Any:
    # Fields that may be absent are given here.
    (stage,) = mechanism.stages
    return stage


def test_dimensions_of_one_size():
    """30 × 10 mm with 5 starts: pitch 2 mm, rollers of 10 mm on a circle of 40 mm."""
    mechanism = plain_catalogue_mechanism(0.03, 0.01, 5, **GIVEN)
    stage = _stage(mechanism)
    thread = stage.thread
    found = [thread.screw_radius, thread.roller_radius, thread.centre_distance, thread.nut_radius]
    np.testing.assert_allclose(found, [15e-3, 5e-3, 20e-3, 25e-3], rtol=1e-12)
    # Crest and root: 0.3 mm and 0.5 mm from the nominal radius; 0.1 mm of tip clearance.
    np.testing.assert_allclose(thread.screw_addendum, 0.3e-3, rtol=1e-9)
    np.testing.assert_allclose(thread.roller_addendum, 0.4e-3, rtol=1e-9)
    np.testing.assert_allclose(stage.nut.wall_thickness, 7e-3, rtol=1e-9)
    # 0.6 · 85 mm of thread over 2 mm.
    np.testing.assert_allclose(stage.engaged_threads, 25.5, rtol=1e-12)
    # π/asin(5.5/20) = 11.28.
    assert stage.roller_count == 11
    assert stage.thread.roller_profile_radius is None
    assert stage.strength.fatigue_rule == "lundberg_palmgren"
    assert stage.strength.play is None
    assert mechanism.title == "Roller screw 30 × 10 mm, 5 starts"


def test_fitted_rules_of_one_size():
    """The same size: what the fitted rules change."""
    stage = _stage(catalogue_mechanism(0.03, 0.01, 5, **GIVEN))
    # 12 pitch circles fit on 40 mm, 2·20·sin(π/12) = 10.35 mm; one is left out.
    assert stage.roller_count == 11
    np.testing.assert_allclose(stage.roller.length, (85 - 14) * 1e-3, rtol=1e-12)
    np.testing.assert_allclose(stage.engaged_threads, (85 - 20) / 2, rtol=1e-12)
    np.testing.assert_allclose(stage.thread.roller_profile_radius, 3.7 * 2e-3, rtol=1e-12)
    np.testing.assert_allclose(stage.thread.roller_addendum, 0.4e-3, rtol=1e-9)
    coarse = _stage(catalogue_mechanism(0.03, 0.02, 5, **GIVEN))
    np.testing.assert_allclose(coarse.thread.roller_profile_radius, 4.6 * 4e-3, rtol=1e-12)
    assert stage.strength.fatigue_rule == "equivalent_balls"
    np.testing.assert_allclose(stage.strength.material_factor, 0.81)
    np.testing.assert_allclose(stage.friction.thread.coefficient, 0.027 * 4, rtol=1e-12)


def test_capacities_of_one_size():
    """30 × 5 mm: printed are 280 and 123 kN; the rules are within 5 % there."""
    size = catalogue_mechanism(
        0.03, 0.005, 5, **(GIVEN | {"crest_diameter_mm": 30.3, "root_diameter_mm": 29.5})
    )
    found = prsm.compute(size, ["static_capacity", "dynamic_capacity"])
    np.testing.assert_allclose(found["static_capacity"], [280e3], rtol=0.05)
    np.testing.assert_allclose(found["dynamic_capacity"], [123e3], rtol=0.05)


@pytest.mark.parametrize(("lead", "play"), [(8e-3, 20e-6), (10e-3, 40e-6), (15e-3, 70e-6)])
def test_play_follows_from_the_pitch(lead, play):
    """As the table prints it for pitches of 1.6, 2 and 3 mm; a play that is given holds."""
    estimated = _stage(catalogue_mechanism(0.03, lead, 5))
    np.testing.assert_allclose(estimated.strength.play.axial_backlash, play, rtol=1e-12)
    given = _stage(catalogue_mechanism(0.03, lead, 5, largest_axial_play_mm=0.0))
    assert float(given.strength.play.axial_backlash) == 0


def test_coarse_rollers_get_lower_teeth_or_are_fewer():
    """42 mm with 6 starts: pitch 7 mm, 14 rollers of 15 mm, whose crests would overlap."""
    stage = _stage(catalogue_mechanism(0.06, 0.042, 6, crest_diameter_mm=61.8))
    assert stage.roller_count == 14
    room = 37.5e-3 * math.sin(math.pi / 14) - 1.01 * 7.5e-3
    np.testing.assert_allclose(stage.thread.roller_addendum, room, rtol=1e-9)
    assert 0.1 < room / 7e-3 < 0.2
    fewer = _stage(catalogue_mechanism(0.06, 0.072, 6, crest_diameter_mm=61.8))
    assert fewer.roller_count == 13


def test_small_nuts_keep_some_thread():
    stage = _stage(catalogue_mechanism(0.0035, 0.001, 3, nut_length_mm=20.0))
    np.testing.assert_allclose(stage.roller.length, 0.65 * 20e-3, rtol=1e-12)
    np.testing.assert_allclose(stage.engaged_threads, 0.45 * 20 * 3, rtol=1e-12)
    # Six pitch circles fit with three starts; a roller of 3.5 mm has 17.5 teeth of 0.2 mm.
    assert stage.roller_count == 5
    assert stage.gear.roller_teeth == 18
    # Rollers of 2.5 mm are too small for 16 teeth of a usual module.
    tiny = _stage(catalogue_mechanism(0.005, 0.001, 4, nut_length_mm=31.0))
    assert tiny.gear.roller_teeth == 25


def test_what_is_missing_follows_from_rules():
    stage = _stage(catalogue_mechanism(0.03, 0.01, 5))
    np.testing.assert_allclose(stage.thread.roller_radius, 5e-3, rtol=1e-12)
    np.testing.assert_allclose(stage.thread.screw_addendum, 0.15 * 2e-3, rtol=1e-12)
    # Fits of 90 sizes: within a third of the printed 7 mm and 85 mm.
    assert float(stage.nut.wall_thickness) == pytest.approx(7e-3, rel=1 / 3)
    assert float(stage.nut.length) == pytest.approx(85e-3, rel=1 / 3)


def test_given_masses_are_used():
    mechanism = catalogue_mechanism(
        0.03,
        0.01,
        5,
        **GIVEN,
        nut_mass_kg=1.3,
        nut_inertia_kg_mm2=667.0,
        shaft_mass_kg_per_m=5.5,
        shaft_inertia_kg_mm2_per_m=620.0,
        largest_axial_play_mm=0.04,
    )
    stage = _stage(mechanism)
    assert float(stage.screw.mass) == 5.5
    np.testing.assert_allclose(
        [stage.screw.inertia, stage.nut.inertia], [620e-6, 667e-6], rtol=1e-12
    )
    # The printed mass of a nut includes 11 rollers of 10 mm and 71 mm, and the carriers.
    rollers = 11 * 7850 * math.pi * 5e-3**2 * 71e-3
    carriers = 2 * 7850 * math.pi * (22.5e-3**2 - 17.5e-3**2) * 0.02 * 85e-3
    np.testing.assert_allclose(stage.nut.mass, 1.3 - rollers - carriers, rtol=1e-9)
    np.testing.assert_allclose(stage.strength.play.axial_backlash, 40e-6, rtol=1e-12)


@pytest.mark.parametrize(
    "row", catalogue_rows()[::9], ids=lambda r: f"{r['nominal_diameter_mm']}x{r['lead_mm']}"
)
def test_rollers_fit_and_one_more_does_not(row):
    dimensions = {name: row[name] for name in GIVEN if name in row}
    mechanism = plain_catalogue_mechanism(
        row["nominal_diameter_mm"] * 1e-3, row["lead_mm"] * 1e-3, row["starts"], **dimensions
    )
    stage = _stage(mechanism)
    crest = float(stage.thread.roller_radius + stage.thread.roller_addendum)
    distance = float(stage.thread.centre_distance)
    assert 2 * distance * math.sin(math.pi / stage.roller_count) > 2 * crest
    more = stage.roller_count + 1
    gap = 0.02 * float(stage.thread.roller_radius)
    assert 2 * distance * math.sin(math.pi / more) < 2 * (crest + gap)


def test_errors_name_the_column():
    with pytest.raises(prsm.UnknownNameError, match=r"nut_lenght_mm.*nut_length_mm"):
        catalogue_mechanism(0.03, 0.01, 5, nut_lenght_mm=85.0)
    with pytest.raises(ValueError, match="static_capacity_kn is a result"):
        catalogue_mechanism(0.03, 0.01, 5, static_capacity_kn=278.0)
    with pytest.raises(ValueError, match="nut_length_mm is nan"):
        catalogue_mechanism(0.03, 0.01, 5, nut_length_mm=math.nan)
    with pytest.raises(ValueError, match="lead is 10 m"):
        catalogue_mechanism(0.03, 10, 5)
    with pytest.raises(ValueError, match="starts is 2"):
        catalogue_mechanism(0.03, 0.01, 2)
    with pytest.raises(ValueError, match="nut_outer_diameter_mm is 40"):
        catalogue_mechanism(0.03, 0.01, 5, nut_outer_diameter_mm=40.0)
    with pytest.raises(ValueError, match=r"roller_circle_diameter_mm is 44; .* has 40"):
        catalogue_mechanism(0.03, 0.01, 5, roller_circle_diameter_mm=44.0)
    for column, value in {"root_diameter_mm": 40.0, "crest_diameter_mm": 29.0}.items():
        with pytest.raises(ValueError, match=f"{column} (is )?{value:g}.* must lie between"):
            catalogue_mechanism(0.03, 0.01, 5, **{column: value})
    with pytest.raises(ValueError, match="nut_length_mm is 0; it must be above 0"):
        catalogue_mechanism(0.03, 0.01, 5, nut_length_mm=0)
    for starts in (4.5, math.inf):
        with pytest.raises(ValueError, match=f"starts is {starts}"):
            catalogue_mechanism(0.03, 0.01, starts)
    with pytest.raises(ValueError, match="rollers are too small for a gear of 16 teeth"):
        catalogue_mechanism(0.002, 0.0005, 5)
    with pytest.raises(ValueError, match=r"lead is 0.2 m: threads"):
        catalogue_mechanism(0.03, 0.2, 3)
    with pytest.raises(ValueError, match=r"lead is 0.5 m: rollers"):
        catalogue_mechanism(0.03, 0.5, 3, root_diameter_mm=29.0)
