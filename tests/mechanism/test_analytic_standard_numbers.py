"""Standard modules, leads and preferred numbers, and the module as a number of a mechanism."""

import dataclasses

import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.mechanism import (
    Gear,
    check_independent,
    preferred_numbers,
    set_parameters,
    standard_leads,
    standard_modules,
    what_follows,
)


@pytest.mark.parametrize("per_decade", [5, 10, 20, 40])
def test_preferred_numbers_are_a_rounded_geometric_series(per_decade):
    """ISO 3: the rounded numbers are within 1.26 % of 10^(k/n)."""
    found = np.array(preferred_numbers(1e-3, 1.0, f"R{per_decade}"))
    exact = 10.0 ** (np.arange(3 * per_decade + 1) / per_decade - 3)
    assert len(found) == len(exact)
    np.testing.assert_allclose(found, exact, rtol=1.27e-2)
    # Every second number of a series is one of the series with half as many.
    if per_decade > 5:
        assert tuple(found[::2]) == preferred_numbers(1e-3, 1.0, f"R{per_decade // 2}")


def test_numbers_of_the_tables():
    """R10 of ISO 3, modules of DIN 780 and leads of ISO 3408-2, as the standards print them."""
    assert preferred_numbers(1.0, 10.0) == (1, 1.25, 1.6, 2, 2.5, 3.15, 4, 5, 6.3, 8, 10)
    printed = "1.00 1.06 1.12 1.18 1.25 1.32 1.40 1.50 1.60 1.70 1.80 1.90 2.00 2.12 2.24 2.36 "
    printed += "2.50 2.65 2.80 3.00 3.15 3.35 3.55 3.75 4.00 4.25 4.50 4.75 5.00 5.30 5.60 6.00 "
    printed += "6.30 6.70 7.10 7.50 8.00 8.50 9.00 9.50"
    assert preferred_numbers(1.0, 9.9, "R40") == tuple(map(float, printed.split()))
    assert standard_modules(0.3e-3, 0.6e-3) == (3e-4, 3.5e-4, 4e-4, 4.5e-4, 5e-4, 5.5e-4, 6e-4)
    assert standard_leads(8e-3, 16e-3) == (8e-3, 9e-3, 10e-3, 12e-3, 15e-3, 16e-3)


@pytest.mark.parametrize("numbers", [standard_modules, standard_leads, preferred_numbers])
def test_limits_are_included_however_they_are_rounded(numbers):
    for millimetres in (1, 5, 10):
        one = millimetres * 1e-3
        for rounded in (one, np.nextafter(one, 0), np.nextafter(one, 1)):
            assert numbers(rounded, rounded) == (float(f"{millimetres}e-3"),)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: standard_modules(2e-3, 1e-3), "standard modules are 0.002 and 0.001; give two"),
        (lambda: standard_leads(0.0, 1e-3), "standard leads are 0 and 0.001"),
        (lambda: preferred_numbers(1.0, np.inf), "preferred numbers R10 are 1 and inf"),
        (lambda: standard_modules(np.nan, 1e-3), "standard modules are nan"),
        (lambda: standard_modules(0.3, 0.5), "no standard module from 0.3 to 0.5 m; .* to 0.01 m"),
        (lambda: preferred_numbers(1.3, 1.5), "no preferred number of R10 from 1.3 to 1.5"),
        (lambda: preferred_numbers(1.0, 2.0, "R7"), "series is 'R7'; choose one of R5, R10, R20"),
    ],
)
def test_limits_that_are_no_range(made, words):
    with pytest.raises(ValueError, match=words):
        made()


def _geared(teeth=16.0):
    return scenes.mechanism(scenes.stage(gear=Gear(np.radians(20), roller_teeth=teeth)))


def test_the_module_sets_the_roller_and_what_follows_from_it():
    """r_R = m z_R / 2, r_s = (n − 2) r_R, r_n = n r_R, with n = 5 and z_R = 16 unless set too."""
    before = _geared()
    assert prsm.get_parameter(before, "gear_module") == pytest.approx(0.5e-3, rel=1e-15)
    for names, radius, teeth in (
        ({"gear_module": 0.6e-3}, 4.8e-3, 16),
        ({"stage.1.gear_module": 0.4e-3, "roller_teeth": 25.0}, 5e-3, 25),
        ({"roller_teeth": 25.0, "gear_module": 0.4e-3}, 5e-3, 25),
    ):
        (stage,) = set_parameters(before, names).stages
        thread = stage.thread
        radii = [thread.roller_radius, thread.screw_radius, thread.nut_radius]
        np.testing.assert_allclose(radii, np.array([1, 3, 5]) * radius, rtol=1e-15)
        assert stage.gear.roller_teeth == teeth
        assert stage.gear_module == pytest.approx(2 * radius / teeth, rel=1e-15)
        assert (thread.lead, thread.starts) == (10e-3, 5)
    assert file.apply_settings(before, ["gear_module=0.6 mm"]).stages[0].thread.roller_radius == (
        pytest.approx(4.8e-3, rel=1e-15)
    )
    follows, stays = what_follows(before, "gear_module")
    assert {"roller_radius", "screw_radius", "nut_radius"} <= set(follows)
    assert {"lead", "starts", "pitch", "ring gear teeth"} <= set(stays)


def test_the_module_and_what_determines_it():
    mechanism = _geared()
    check_independent(mechanism, ["gear_module", "roller_teeth", "lead"])
    for other in ("roller_radius", "screw_radius"):
        with pytest.raises(ValueError, match=f"{other!r} moves again when 'gear_module'"):
            check_independent(mechanism, [other, "gear_module"])
    # Teeth that vary after the module has been set would change it.
    with pytest.raises(ValueError, match="'gear_module' moves again when 'roller_teeth'"):
        check_independent(mechanism, ["gear_module"], ["roller_teeth"])


def test_without_teeth_there_is_no_module():
    mechanism = scenes.mechanism()
    bare = dataclasses.replace(scenes.stage(), gear=None)
    for one in (mechanism, scenes.mechanism(bare)):
        assert one.stages[0].gear_module is None
        with pytest.raises(prsm.UnknownNameError, match="unknown parameter 'gear_module'"):
            prsm.get_parameter(one, "gear_module")
        with pytest.raises(prsm.MissingDataError, match="no gear teeth; give roller_teeth in"):
            prsm.compute(one, ["gear_module"])
    both = scenes.mechanism(_geared().stages[0], _geared(20.0).stages[0])
    found = prsm.compute(both, ["gear_module"])["gear_module"]
    np.testing.assert_allclose(found, [0.5e-3, 0.4e-3], rtol=1e-15)
    with pytest.raises(ValueError, match="must be more than 0"):
        prsm.set_parameter(both, "gear_module", -1e-3)
