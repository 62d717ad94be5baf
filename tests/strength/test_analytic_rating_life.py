"""Equivalent load, rating life and its factors by hand, and what must not change them."""

import dataclasses
import re
from types import SimpleNamespace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st
from scenes import array, example, mechanism, stage, thread

import prsm_jax as prsm
from prsm_jax import strength
from prsm_jax.mechanism import AxialPlay, DutyCycle, Strength
from prsm_jax.quantities import catalogue
from prsm_jax.strength import LoadSpectrum
from tests.present import present

CAPACITY = 50e3
ONE = stage(strength=Strength(dynamic_capacity=CAPACITY))
#: 1000 N at 600 rpm for 30 s, 3000 N at 300 rpm for 20 s, 500 N at 1200 rpm for 50 s.
BY_HAND = DutyCycle(
    duration=np.array([30.0, 20.0, 50.0]),
    speed=np.array([600.0, -300.0, 1200.0]) * np.pi / 30,
    load=np.array([1000.0, 3000.0, 500.0]),
)

life = eqx.filter_jit(strength.rating_life)
damage = eqx.filter_jit(strength.damage)
equivalent_load = eqx.filter_jit(strength.equivalent_load)


def spectrum(load, turns, duration):
    turned = 2 * np.pi * np.asarray(turns, float)
    return LoadSpectrum(jnp.asarray(load, float), jnp.asarray(turned), jnp.asarray(duration, float))


def test_a_duty_cycle_by_hand():
    """300, 100 and 1000 turns: F_m³ = (300·1 + 100·27 + 1000·0.125)/1400 kN³ = 3125/1400."""
    mean = np.cbrt(3125 / 1400) * 1e3
    np.testing.assert_allclose(equivalent_load(BY_HAND), mean, rtol=1e-14)
    found = life(ONE, array(CAPACITY), strength.load_spectrum(BY_HAND))
    turns = 1e6 * (CAPACITY / mean) ** 3
    np.testing.assert_allclose(found.revolutions, turns, rtol=1e-13)
    np.testing.assert_allclose(found.time, turns / (1400 / 100), rtol=1e-13)
    np.testing.assert_allclose(found.distance, turns * 10e-3, rtol=1e-13)
    shares = damage(ONE, array(CAPACITY), strength.load_spectrum(BY_HAND))
    by_hand = np.array([300 * 1, 100 * 27, 1000 * 0.125]) * 1e9 / CAPACITY**3 / 1e6
    np.testing.assert_allclose(shares, by_hand, rtol=1e-13)
    np.testing.assert_allclose(jnp.sum(shares), 1400 / turns, rtol=1e-13)


def test_quantities_take_the_spectrum_that_there_is():
    """The duty cycle, the operating point without one, and what is asked for before both."""
    one = mechanism(ONE, speed=100.0, load=2000.0)
    with_duty = eqx.tree_at(lambda m: m.duty_cycle, one, BY_HAND, is_leaf=lambda leaf: leaf is None)
    names = ["rating_life", "rating_life_time", "rating_life_distance"]
    of_point = prsm.compute(one, names)
    np.testing.assert_allclose(of_point["rating_life"], 1e6 * 25**3, rtol=1e-13)
    np.testing.assert_allclose(
        of_point["rating_life_time"], 1e6 * 25**3 * 2 * np.pi / 100, rtol=1e-13
    )
    by_hand = 1e6 * CAPACITY**3 / (3125e9 / 1400)
    np.testing.assert_allclose(prsm.compute(with_duty, names)["rating_life"], by_hand, rtol=1e-13)
    asked = prsm.compute(with_duty, ["rating_life"], load=5000.0)
    np.testing.assert_allclose(asked["rating_life"], 1e9, rtol=1e-13)
    with pytest.raises(prsm.MissingDataError, match="no duty cycle"):
        prsm.compute(one, ["duty_cycle_damage"])


_LOADS = st.lists(st.floats(-4e4, 4e4), min_size=3, max_size=3)
_TURNS = st.lists(st.floats(0.01, 1e4), min_size=3, max_size=3)


@given(_LOADS, _TURNS, st.permutations([0, 1, 2]), st.floats(0.05, 0.95))
def test_order_and_splitting_of_phases_do_not_matter(load, turns, order, share):
    load = np.asarray(load) + 1.0
    one = spectrum(load, turns, np.ones(3))
    expected = life(ONE, array(CAPACITY), one).revolutions
    shuffled = spectrum(load[order], np.asarray(turns)[order], np.ones(3))
    np.testing.assert_allclose(
        life(ONE, array(CAPACITY), shuffled).revolutions, expected, rtol=1e-11
    )
    split = spectrum(
        [*load, load[-1]],
        [*turns[:2], share * turns[2], (1 - share) * turns[2]],
        [1.0, 1.0, share, 1 - share],
    )
    found = life(ONE, array(CAPACITY), split)
    np.testing.assert_allclose(found.revolutions, expected, rtol=1e-11)


@given(_LOADS, _TURNS, st.floats(1e-3, 1e3))
def test_life_goes_with_the_third_power_of_capacity_over_load(load, turns, factor):
    load = np.asarray(load) + 1.0
    before = life(ONE, array(CAPACITY), spectrum(load, turns, np.ones(3))).revolutions
    more = life(ONE, array(CAPACITY), spectrum(factor * load, turns, np.ones(3))).revolutions
    np.testing.assert_allclose(more, before * factor**-3, rtol=1e-11)
    stronger = life(ONE, array(CAPACITY * factor), spectrum(load, turns, np.ones(3))).revolutions
    np.testing.assert_allclose(stronger, before * factor**3, rtol=1e-11)


def test_two_flanks_share_the_turning():
    """Half the turns on either: each lasts twice as long, both together 2 · 2^{−9/10} times."""
    both = spectrum([5e3, -5e3, 0.0], [10, 10, 0], np.ones(3))
    found = life(ONE, array(CAPACITY), both).revolutions
    np.testing.assert_allclose(found, 1e9 * 2**0.1, rtol=1e-13)
    # 20 turns use up their share of that life; both phases alike.
    np.testing.assert_allclose(
        damage(ONE, array(CAPACITY), both), np.array([10.0, 10.0, 0.0]) / 1e9 * 2**-0.1, rtol=1e-13
    )


@given(_LOADS, _TURNS)
def test_damages_of_both_flanks_add_up_to_the_turns_over_the_life(load, turns):
    """And a small phase more lowers the life by its damage: both are derivatives of the life."""
    load = np.asarray(load) + np.where(np.abs(load) < 10, 100.0, 0.0)
    one = spectrum(load, turns, np.ones(3))
    shares = np.asarray(damage(ONE, array(CAPACITY), one))
    lasts = float(life(ONE, array(CAPACITY), one).revolutions)
    np.testing.assert_allclose(shares.sum(), np.sum(turns) / lasts, rtol=1e-11)

    def used(factor):
        more = np.asarray(turns) * np.array([factor, 1.0, 1.0])
        lived = life(ONE, array(CAPACITY), spectrum(load, more, np.ones(3))).revolutions
        return float(np.sum(more) / lived)

    slope = (used(1 + 1e-4) - used(1 - 1e-4)) / 2e-4
    # Of second order in a step of 1e-4, and rounding of 1e-16 of the sum over it.
    np.testing.assert_allclose(shares[0], slope, rtol=1e-6, atol=1e-10 * shares.sum())


def test_derivatives_of_the_damage_where_one_flank_or_none_is_loaded():
    def total(load):
        loads = array(load) * array([1.0, 1.0, 0.0])
        return jnp.sum(damage(ONE, array(CAPACITY), spectrum(loads, [10, 10, 1], np.ones(3))))

    assert float(jax.grad(total)(0.0)) == 0
    np.testing.assert_allclose(jax.grad(total)(5e3), 3 * total(5e3) / 5e3, rtol=1e-12)


def test_a_preload_loads_both_flanks_always():
    preloaded = stage(strength=Strength(play=AxialPlay(preload_force=2e3)))
    idle = life(preloaded, array(CAPACITY), spectrum([0.0, 0.0, 0.0], [1, 2, 3], np.ones(3)))
    np.testing.assert_allclose(idle.revolutions, 1e6 * 25**3 * 2**-0.9, rtol=1e-13)
    first, second = strength.preloaded_pair_loads(array(3e3), array(2e3))
    loaded = life(preloaded, array(CAPACITY), spectrum(3 * [3e3], [1, 2, 3], np.ones(3)))
    risk = sum((float(load) / CAPACITY) ** (10 / 3) for load in (first, second))
    np.testing.assert_allclose(loaded.revolutions, 1e6 * risk**-0.9, rtol=1e-13)


@pytest.mark.parametrize(
    ("load", "turns"),
    [
        ([0.0, 0.0, 0.0], [1.0, 2.0, 3.0]),
        ([1e3, 2e3, 0.0], [0.0, 0.0, 0.0]),
        ([1e3, 1e3, 1e3], [1.0, 0.0, 1.0]),
        ([1e3, 0.0, -1e3], [1.0, 0.0, 1.0]),
        ([1e-120, 0.0, 0.0], [1.0, 1.0, 1.0]),
        ([1e90, 1.0, 0.0], [1.0, 1.0, 1.0]),
    ],
)
def test_extreme_spectra_have_a_life_and_finite_derivatives(load, turns):
    """Nothing turns: weighted by time, and lasts for ever in time; nothing loads: for ever."""
    one = spectrum(load, turns, np.ones(3))
    found = life(ONE, array(CAPACITY), one)
    values, slopes = _value_and_slopes(one, array(CAPACITY))
    assert not np.isnan(values).any()
    assert np.isinf(found.revolutions) == (max(np.abs(load)) < 1e-90)
    assert np.isinf(found.time) == (np.isinf(found.revolutions) or sum(turns) == 0)
    for forward, backward in zip(*slopes, strict=True):
        np.testing.assert_allclose(forward, backward, rtol=1e-10, atol=1e-16)
        assert np.isfinite(forward).all()


@eqx.filter_jit
def _value_and_slopes(given, capacity):
    """Logarithms of life and mean load, with derivatives forward and in reverse."""

    def values(load, turned, c):
        one = LoadSpectrum(load, turned, given.duration)
        found = strength.rating_life(ONE, c, one)
        safe = jnp.where(jnp.isfinite(found.revolutions), found.revolutions, 1.0)
        return jnp.stack([jnp.log(safe), strength.equivalent_load(one)])

    point = (given.load, given.turned_angle, capacity)
    return values(*point), (
        jax.jacfwd(values, argnums=(0, 1, 2))(*point),
        jax.jacrev(values, argnums=(0, 1, 2))(*point),
    )


def test_derivatives_of_the_life_by_differences():
    one = spectrum([1e3, 3e3, -2e3], [30.0, 10.0, 5.0], np.ones(3))
    _, (slopes, _) = _value_and_slopes(one, array(CAPACITY))
    for index in range(3):
        step = 1e-5 * np.abs(one.load[index])
        moved = [one.load.at[index].add(sign * step) for sign in (1, -1)]
        ends = [
            _value_and_slopes(eqx.tree_at(lambda s: s.load, one, m), array(CAPACITY))[0]
            for m in moved
        ]
        np.testing.assert_allclose(slopes[0][:, index], (ends[0] - ends[1]) / (2 * step), rtol=1e-6)


def test_equivalent_load_of_histories():
    """|sin|³ has the mean 4/(3π); a speed that turns round weighs its load by |speed|."""
    time = jnp.linspace(0.0, 1.0, 2001)
    swing: Any = SimpleNamespace(
        time=time, screw_speed=jnp.full(2001, 3.0), load=1e3 * jnp.sin(2 * jnp.pi * time)
    )
    # The trapezoidal rule on |sin|³, which is smooth to the second derivative.
    np.testing.assert_allclose(
        equivalent_load(strength.load_spectrum(swing)), 1e3 * np.cbrt(4 / (3 * np.pi)), rtol=1e-9
    )
    to_and_fro: Any = SimpleNamespace(
        time=time, screw_speed=jnp.cos(2 * jnp.pi * time), load=jnp.where(time < 0.5, 1e3, 2e3)
    )
    found = equivalent_load(strength.load_spectrum(to_and_fro))
    # Second order at the kinks of |speed| and the jump of the load.
    np.testing.assert_allclose(found, 1e3 * np.cbrt((1 + 8) / 2), rtol=1e-3)
    assert {"time", "screw_speed", "load"} <= set(prsm.Transient.__dataclass_fields__)


#: ISO 281:2007, table 12.
RELIABILITY = {
    0.9: 1.0,
    0.95: 0.64,
    0.96: 0.55,
    0.97: 0.47,
    0.98: 0.37,
    0.99: 0.25,
    0.992: 0.22,
    0.994: 0.19,
    0.996: 0.16,
    0.998: 0.12,
    0.999: 0.093,
    0.9992: 0.087,
    0.9994: 0.080,
    0.9995: 0.077,
}


@pytest.mark.parametrize("reliability", RELIABILITY)
def test_reliability_factor_rounds_to_the_table(reliability):
    tabled = RELIABILITY[reliability]
    digits = 3 if tabled < 0.1 else 2
    assert round(float(strength.reliability_factor(array(reliability))), digits) == tabled


def test_small_swings_stress_less_material_more_often():
    """Life ∝ s^{1/10} of the share of the narrowest track, and 1 once tracks overlap."""
    factor = eqx.filter_jit(strength.oscillation_factor)
    geometry = thread()
    rolled = geometry.starts * geometry.screw_radius / (2 * geometry.centre_distance)
    critical = float(jnp.pi / rolled)
    np.testing.assert_allclose(factor(ONE, array(critical / 1024)), 0.5, rtol=1e-12)
    np.testing.assert_allclose(factor(ONE, array(critical)), 1.0, rtol=1e-14)
    assert factor(ONE, array(3 * critical)) == 1.0


def test_a_swing_is_judged_under_the_largest_load_on_a_flank():
    """Of the duty cycle and with the preload: the ellipse grows with the cube root of the load."""
    swinging = stage(
        curvature="wu2022",
        strength=Strength(oscillation_amplitude=1e-4, play=AxialPlay(preload_force=4e3)),
    )
    one = mechanism(swinging, load=1e3)
    cycle = DutyCycle(*(jnp.asarray(x) for x in ([1.0, 1.0], [10.0, 10.0], [0.0, 8e3])))
    one = dataclasses.replace(one, duty_cycle=cycle)
    expected = eqx.filter_jit(strength.minimum_oscillation_amplitude)(
        swinging, strength.preloaded_pair_loads(array(8e3), array(4e3))[0]
    )
    name = "minimum_oscillation_amplitude"
    found = eqx.filter_jit(lambda m: prsm.compute(m, [name])[name])(one)
    np.testing.assert_allclose(found, expected[None], rtol=1e-13)
    named = {f.name: f for f in prsm.check(one)}
    np.testing.assert_allclose(named["false_brinelling"].limit, expected, rtol=1e-13)


#: What rests on mechanics alone.
MECHANICS = {
    "buckling_load",
    "slenderness_ratio",
    "critical_speed",
    "axial_backlash",
    "lost_motion",
    "preloaded_pressure",
    "preloaded_stiffness",
    "preload_torque",
}


def test_the_catalogue_says_what_rests_on_other_machines():
    """All else is the practice of bearings and ball screws, and says so by name."""
    files = ("_strength", "_rating_life", "_play")
    known = {q.name: q for q in catalogue() if q.function.__module__.endswith(files)}
    # Those of the screw alone are made in a loop, by functions of the same file.
    assert set(known) > MECHANICS
    for name in set(known) - MECHANICS:
        words = known[name].description
        assert re.search(r"ISO \d+|ball screws|bearings?\b", words), f"{name}: {words}"


def test_factors_multiply():
    both = stage(strength=Strength(reliability=0.95, life_modification_factor=0.5))
    expected = 0.5 * strength.reliability_factor(array(0.95))
    np.testing.assert_allclose(present(strength.life_factor(both)), expected, rtol=1e-15)
    assert strength.life_factor(ONE) is None
    assert strength.life_factor(stage()) is None
    with pytest.raises(prsm.MissingDataError, match="life_modification_factor"):
        prsm.compute(mechanism(ONE), ["modified_rating_life"])


@pytest.mark.parametrize("factors", [{}, {"life_modification_factor": 0.5}])
def test_the_life_over_the_one_that_is_asked_for(factors):
    """10⁶ (C/F)³ turns at 100 rad/s, over 10⁷ s; times a factor where there is one."""
    data = Strength(dynamic_capacity=CAPACITY, required_life=1e7, **factors)
    found = prsm.compute(mechanism(stage(strength=data)), ["life_ratio"])["life_ratio"]
    lasts = 1e6 * (CAPACITY / 7e3) ** 3 * 2 * np.pi / 100
    expected = lasts / 1e7 * factors.get("life_modification_factor", 1.0)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_quantities_without_data_name_the_remedy():
    bare = mechanism(stage())
    for name in ("static_capacity", "rating_life", "buckling_load", "axial_backlash"):
        with pytest.raises(prsm.MissingDataError, match=rf"{name}.*\[stage.strength\]"):
            prsm.compute(bare, [name])
    empty = mechanism(stage(strength=Strength()))
    for name, remedy in {
        "static_capacity": "permissible_pressure",
        "dynamic_capacity": "material_factor",
        "critical_speed": "stage.strength.shaft",
        "lost_motion": "stage.strength.play",
        "life_ratio": "required_life",
    }.items():
        with pytest.raises(prsm.MissingDataError, match=remedy):
            prsm.compute(empty, [name])


def _of_strength(mechanism):
    """Findings on strength, life, speed, play and preload, by name."""
    names = ("static_safety", "rating_life", "buckling", "screw_speed", "false_brinelling")
    names += ("backlash", "preload", "engaged_threads", "axial_backlash", "contact_truncation")
    return {one.name: one for one in prsm.check(mechanism) if one.name in names}


def test_strength_that_is_asked_for_too_much_is_found():
    """The shipped actuator bears its duty; with more load, speed, life and tooth it does not."""
    one = example("actuator")
    names = _of_strength(one).keys()
    assert not names
    for name, value in {
        "operating_point.load": 3e5,
        "operating_point.speed": 5e3,
        "required_life": 1e9,
        "screw_tooth_thinning": 0.0,
    }.items():
        one = prsm.set_parameter(one, name, value)
    found = _of_strength(one)
    assert {name: f.severity for name, f in found.items()} == {
        "static_safety": "error",
        "rating_life": "warning",
        "buckling": "error",
        "screw_speed": "error",
        "backlash": "error",
        "contact_truncation": "warning",
    }
    assert found["rating_life"].value < found["rating_life"].limit
    capacity = prsm.compute(one, ["static_safety"])["static_safety"]
    np.testing.assert_allclose(found["static_safety"].value, capacity, rtol=1e-12)


def test_a_life_limits_a_design():
    """The smallest mechanism that lasts: its life is what was asked for, no more."""
    small = stage(strength=Strength(material_factor=1.0), curvature="wu2022")
    best = prsm.optimise(
        mechanism(small, load=8e3),
        variables={"roller_radius": (3e-3, 6e-3)},
        minimise="centre_distance",
        constraints={"rating_life": (2e8, None)},
        starts=1,
    )
    assert best.converged
    found = prsm.compute(best.mechanism, ["rating_life"])["rating_life"]
    np.testing.assert_allclose(found, 2e8, rtol=1e-5)
