"""Cut ellipses in split nuts, among threads that share unequally, and over duty cycles.

Everything is summed up thread by thread and lamina by lamina, with quadrature and root searches;
of the package only whole ellipses, distances of the ends and how threads share are used.
"""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from laminae import lamina_risk, pressure_ratio_by_bisection, sides_of
from scenes import array, example, stage_contact
from truncation_scenes import NUT_LENGTH, screw_of_30_mm, without_addenda

import prsm_jax as prsm
from prsm_jax import strength
from prsm_jax.contact import half_extent, half_extents, rounded_edges
from prsm_jax.mechanism import AxialPlay, DutyCycle, LoadSharing, SplitNut, Strength
from prsm_jax.quantities import Analysis, find_quantity
from tests.roots import root_between

_PERMISSIBLE, _FACTOR, _LEAD = 4.2e9, 1.1, 3e-3
_RATED = np.log(1 / 0.9)
_compute = eqx.filter_jit(prsm.compute)


def _strength(play=None):
    return Strength(permissible_pressure=_PERMISSIBLE, material_factor=_FACTOR, play=play)


def _with_cycle(one, loads, turned):
    cycle = DutyCycle(jnp.ones(len(loads)), jnp.asarray(turned), jnp.asarray(loads))
    return eqx.tree_at(lambda m: m.duty_cycle, one, cycle, is_leaf=lambda x: x is None)


@functools.cache
def _unit(lead) -> list[tuple[float, tuple[float, ...], float]]:
    """Of either side under 10 kN in equal shares: Hertz pressure, reaches, risk of fatigue."""
    one = screw_of_30_mm(lead).stages[0]
    risks = strength.truncated_fatigue(one).risks
    found = []
    for (hertz, frame, ends, _), risk in zip(sides_of(one, 1e4), risks, strict=True):
        reaches = tuple(float(e.distance / half_extent(hertz, frame.curvature, e)) for e in ends)
        found.append((float(hertz.max_pressure), reaches, float(risk)))
    return found


def _pressures(lead, load):
    """Largest pressures of both sides under a load in equal shares of all threads."""
    scale = (load / 1e4) ** (1 / 3)
    return [
        p * scale * pressure_ratio_by_bisection([t / scale for t in reaches])
        for p, reaches, _ in _unit(lead)
    ]


def _risk(lead, load, loads=None, share=1.0, factor=None):
    """ln(1/S) of 10⁶ turns, summed over threads that bear `loads` (of each side) times the mean.

    `share`: how many threads there are, over those of the unit scene; `factor`: of the fatigue of
    both sides, where it is not that of their own threads.
    """
    total = 0.0
    for side, (_, reaches, risk) in enumerate(_unit(lead) if load > 0 else ()):
        shares = np.ones(1) if loads is None else loads[side]
        mean = 0.0
        for q in shares:
            scale = (load * q / share / 1e4) ** (1 / 3)
            ratio = pressure_ratio_by_bisection([t / scale for t in reaches])
            kept = 1 - sum(lamina_risk(min(t / scale / ratio, 1.0)) for t in reaches)
            mean += q ** (10 / 3) * ratio**10 * kept / len(shares)
        if factor is not None:
            mean *= factor ** (10 / 3) / np.mean(shares ** (10 / 3))
        # A track's risk goes with the 10/3 power of its load, and of the material's.
        total += risk * (load / share / 1e4 / _FACTOR) ** (10 / 3) * mean
    return total * share


def _life(risk):
    return 1e6 * (_RATED / risk) ** 0.9


def _rates(phases, **more):
    """Lives used up by a turn, 0 without load."""
    risks = [_risk(load=load, **more) for load in phases]
    return np.array([1 / _life(risk) if risk > 0 else 0.0 for risk in risks])


def _capacity(lead, **more):
    return root_between(
        lambda load: _life(_risk(lead, load, **more)) / 1e6 - 1, 1e3, 1e7, rtol=1e-13
    )


def _on_flanks(load, preload):
    """Loads of two nuts preloaded against each other, from F/F_p = (1 + s)^1.5 − (1 − s)^1.5."""
    shift = root_between(
        lambda s: (1 + s) ** 1.5 - np.maximum(1 - s, 0.0) ** 1.5 - abs(load) / preload, 0, 500
    )
    both = preload * (1 + shift) ** 1.5, preload * max(1 - shift, 0.0) ** 1.5
    return both if load >= 0 else both[::-1]


_SPLIT = {
    # The halves alike, by strength alone.
    "half": (0.5, AxialPlay(preload_force=8e4, arrangement="split_nut"), {}),
    # The smaller half, by load sharing.
    "smaller": (
        60 / 142,
        None,
        {"split_nut": SplitNut(60, preload=8e4), "backlash": 1e-5}
        | {f"{body}_segment_stiffness": 4e9 for body in ("screw", "roller", "nut")},
    ),
}


@pytest.mark.parametrize("name", _SPLIT)
def test_a_split_nut(name):
    """Half the threads each way, the preload on both flanks at all times."""
    share, play, sharing = _SPLIT[name]
    # As many threads as a nut of 85 mm has pitches of 0.6 mm, rounded.
    one = screw_of_30_mm(_LEAD, load=1e5, strength=_strength(play), engaged_threads=142.0)
    if sharing:
        one = eqx.tree_at(
            lambda m: m.stages[0].load_sharing,
            one,
            LoadSharing(142, **sharing),
            is_leaf=lambda x: x is None,
        )
    scale = 142 / (NUT_LENGTH / (_LEAD / 5)) * share
    loads, turned = [2.5e5, -1e5, 4e4], [1.0, 30.0, 400.0]
    names = ["static_capacity", "dynamic_capacity", "rating_life", "phase_damage"]
    names += ["contact_truncation", "truncation_load", "static_safety"]
    found = {k: np.ravel(v) for k, v in _compute(_with_cycle(one, loads, turned), names).items()}

    onset = min(1e4 * min(t) ** 3 for _, t, _ in _unit(_LEAD)) * scale
    np.testing.assert_allclose(found["truncation_load"], onset, rtol=1e-9)
    static = root_between(
        lambda load: max(_pressures(_LEAD, load / scale)) / _PERMISSIBLE - 1, 1e3, 1e7, rtol=1e-13
    )
    np.testing.assert_allclose(found["static_capacity"], static, rtol=1e-9)
    # Ellipses are cut under both capacities, and under the larger phases.
    assert static > onset
    dynamic = _capacity(_LEAD, share=scale)
    np.testing.assert_allclose(found["dynamic_capacity"], dynamic, rtol=1e-8)
    assert dynamic > onset

    flanks = np.array([_on_flanks(load, 8e4) for load in loads])
    assert flanks.max() > onset > flanks.min()
    np.testing.assert_allclose(found["static_safety"], static / flanks.max(), rtol=1e-9)
    pressed = _on_flanks(1e5, 8e4)[0]
    np.testing.assert_allclose(
        found["contact_truncation"], 1 - (onset / pressed) ** (1 / 3), rtol=1e-9
    )
    # Miner's rule on either flank, and both flanks as parts in series.
    rates = np.array([_rates(row, lead=_LEAD, share=scale) for row in flanks])
    weights = np.asarray(turned) / np.sum(turned)
    each = weights @ rates
    both = np.sum(each ** (10 / 9)) ** -0.9
    np.testing.assert_allclose(found["rating_life"], both, rtol=1e-8)
    turns = np.asarray(turned) / (2 * np.pi)
    np.testing.assert_allclose(np.sum(found["phase_damage"]), np.sum(turns) / both, rtol=1e-8)
    # Each flank counts by (L/L_±)^{1/9}.
    used = turns * (rates @ (both * each) ** (1 / 9))
    np.testing.assert_allclose(found["phase_damage"], used, rtol=1e-8)


#: Soft shafts: the first thread bears much more than the last.
_THREADS = 24
_SHAFTS = LoadSharing(
    _THREADS,
    screw_segment_stiffness=3e9,
    roller_segment_stiffness=1e9,
    nut_segment_stiffness=6e9,
)


def _shared(load, cycle=None):
    lead = 5e-3
    one = screw_of_30_mm(
        lead,
        load=load,
        strength=_strength(),
        engaged_threads=float(_THREADS),
        load_sharing=_SHAFTS,
    )
    return one if cycle is None else _with_cycle(one, *cycle)


@eqx.filter_jit
def _distribution(one, load):
    found = prsm.load_sharing.load_distribution(one, load)
    return [side.thread_load[0] for side in (found.screw, found.nut)]


def _part():
    """Threads of this nut over those of the unit scene."""
    return _THREADS / (NUT_LENGTH / 1e-3)


def test_threads_that_share_unequally():
    """Under the largest load, thread by thread: pressure, truncation and static capacity."""
    load = 1.6e5
    one = _shared(load)
    names = ["max_pressure_shared", "max_pressure", "static_capacity", "truncation_load"]
    names += ["contact_truncation", "permanent_deformation"]
    found = {k: float(np.ravel(v)[0]) for k, v in _compute(one, names).items()}
    sides = [np.asarray(x) for x in _distribution(one, jnp.asarray(load))]
    mean = load / (10 * _THREADS)
    pressures = [
        _pressures(5e-3, q * load / _part())[k]
        for k, side in enumerate(sides)
        for q in (side.max() / mean,)
    ]
    np.testing.assert_allclose(found["max_pressure_shared"], max(pressures), rtol=1e-9)
    np.testing.assert_allclose(
        found["max_pressure"], max(_pressures(5e-3, load / _part())), rtol=1e-9
    )
    assert found["max_pressure_shared"] > 1.05 * found["max_pressure"]
    worst = max(side.max() for side in sides) / mean
    capacity = root_between(
        lambda x: max(_pressures(5e-3, x * worst / _part())) / _PERMISSIBLE - 1, 1e3, 1e7,
        rtol=1e-13,
    )  # fmt: skip
    np.testing.assert_allclose(found["static_capacity"], capacity, rtol=1e-9)
    onset = min(1e4 * min(t) ** 3 for _, t, _ in _unit(5e-3)) * _part() / worst
    np.testing.assert_allclose(found["truncation_load"], onset, rtol=1e-9)
    np.testing.assert_allclose(
        found["contact_truncation"], 1 - (onset / load) ** (1 / 3), rtol=1e-8
    )
    # The dent is that of the force which presses a whole ellipse as much: pressures cubed, squared.
    whole = _compute(without_addenda(one), ["permanent_deformation"])["permanent_deformation"]
    scale = (load * worst / _part() / 1e4) ** (1 / 3)
    ratio = [pressure_ratio_by_bisection([t / scale for t in r]) for _, r, _ in _unit(5e-3)]
    dents = found["permanent_deformation"] / float(whole)
    assert min(ratio) ** 6 - 1e-9 <= dents <= max(ratio) ** 6 + 1e-9
    assert min(ratio) > 1.01


def test_fatigue_of_threads_that_share_unequally():
    """Duty cycle, under whose equivalent load they share: thread by thread, each by its own cut."""
    loads, turned = [2.2e5, 1.2e5, 4e4], [2.0, 40.0, 400.0]
    one = _shared(1e5, (loads, turned))
    names = ["dynamic_capacity", "rating_life", "phase_damage"]
    found = {k: np.ravel(v) for k, v in _compute(one, names).items()}
    weights = np.asarray(turned) / np.sum(turned)
    equivalent = float((weights @ np.asarray(loads) ** 3) ** (1 / 3))
    sides = [np.asarray(x) for x in _distribution(one, jnp.asarray(equivalent))]
    shares = [side / side.mean() for side in sides]
    factors = [np.mean(side ** (10 / 3)) ** 0.3 for side in shares]
    given = {"loads": shares, "share": _part()}
    truly = _capacity(5e-3, **given)
    # Both sides count as the worse one shares: slightly less than the sum over all threads.
    np.testing.assert_allclose(found["dynamic_capacity"], truly, rtol=0.03)
    assert float(found["dynamic_capacity"][0]) <= truly * (1 + 1e-9)
    given["factor"] = max(factors)
    np.testing.assert_allclose(found["dynamic_capacity"], _capacity(5e-3, **given), rtol=1e-8)
    rates = _rates(loads, lead=5e-3, **given)
    np.testing.assert_allclose(found["rating_life"], 1 / (weights @ rates), rtol=1e-8)
    turns = np.asarray(turned) / (2 * np.pi)
    np.testing.assert_allclose(found["phase_damage"], turns * rates, rtol=1e-8)
    # Whole ellipses would have another life.
    plain = _compute(without_addenda(one), ["rating_life"])["rating_life"]
    assert abs(found["rating_life"][0] / float(plain[0]) - 1) > 0.05


def test_each_load_is_shared_as_its_own_size_makes_it():
    """What is cut at the operating point does not depend on larger loads elsewhere in the cycle."""
    low, high = 1.2e5, 2.4e5
    names = ["contact_truncation", "contact_truncation_largest"]
    alone = {load: _compute(_shared(load), names) for load in (low, high)}
    found = _compute(_with_cycle(_shared(low), [high, 1e3], [1.0, 1.0]), names)
    np.testing.assert_allclose(found[names[0]], alone[low][names[0]], rtol=1e-10)
    np.testing.assert_allclose(found[names[1]], alone[high][names[0]], rtol=1e-10)
    # Larger loads are shared more evenly: with the sharing of the larger one less would be cut.
    shares = []
    for load in (low, high):
        sides = [np.asarray(x) for x in _distribution(_shared(load), jnp.asarray(load))]
        shares.append(max(side.max() for side in sides) / load)
    assert abs(shares[1] / shares[0] - 1) > 1e-3
    assert float(found[names[0]][0]) > 0.01


_FACTORS = (0.0, 1e-33, 1e-7, -1.0, 1.0, 25.0)


@pytest.mark.parametrize("factor", _FACTORS)
def test_the_largest_pressure_is_that_of_a_contact_under_the_load_itself(factor):
    """`max_pressure` scales the contact under the reference load; values and slopes, 0 included.

    Of both sides, and the largest.
    """
    one, load = example("actuator"), array(20e3 * factor)

    def found(load):
        sides = prsm.compute(one, ["max_pressure_screw", "max_pressure_nut"], load=load)
        largest = prsm.compute(one, ["max_pressure"], load=load)["max_pressure"]
        return (*(pressure[0] for pressure in sides.values()), largest)

    def expected(load):
        stage = one.stages[0]
        contact = stage_contact(stage, jnp.abs(load))
        onsets = strength.side_onsets(stage)
        assert onsets is not None
        screw, nut = (
            strength.truncated_pressure(onset, side.hertz.max_pressure)
            for onset, side in zip(onsets, (contact.screw, contact.nut), strict=True)
        )
        return screw, nut, jnp.maximum(screw, nut)

    values, slopes = jax.jit(lambda load: jax.jvp(found, (load,), (array(1.0),)))(load)
    of_contact, its_slopes = jax.jit(lambda load: jax.jvp(expected, (load,), (array(1.0),)))(load)
    # Rounding of two cube roots and of the closed form of a cut ellipse.
    np.testing.assert_allclose(values, of_contact, rtol=1e-14)
    np.testing.assert_allclose(slopes, its_slopes, rtol=3e-14)
    assert all((np.asarray(values) > 0) == (factor != 0))
    assert factor == 0 or abs(float(values[0]) / float(values[1]) - 1) > 0.1


def test_the_largest_pressure_needs_one_contact_of_each_side():
    analysis = Analysis(example("actuator"))
    jax.eval_shape(lambda: find_quantity("max_pressure").function(analysis))
    assert "contacts" not in vars(analysis)


def test_extents_of_all_ends_are_those_of_each():
    """Ends in equal directions and in others, in any order."""
    hertz, frame, ends, _ = next(iter(sides_of(screw_of_30_mm(_LEAD).stages[0], 1e4)))
    total = frame.curvature.total
    mixed = [
        *ends,
        dataclasses.replace(ends[0], coefficient=total * 0.3),
        dataclasses.replace(ends[0], coefficient=None),
        ends[0],
    ]
    found = half_extents(hertz, frame.curvature, mixed)
    each = [half_extent(hertz, frame.curvature, end) for end in mixed]
    np.testing.assert_array_equal(found, each)
    assert len({float(extent) for extent in found}) >= 3


def test_each_rounded_crest_has_the_extent_towards_it():
    """s of onset g p₀/s, steepness E* s/(p₀ ρ) and aspect a b/s²; a root is no edge."""
    hertz, frame, ends, _ = next(iter(sides_of(screw_of_30_mm(_LEAD).stages[0], 1e4)))
    other = dataclasses.replace(ends[0], coefficient=frame.curvature.total * 0.3)
    root = dataclasses.replace(ends[0], kind="root")
    modulus, radius = 1.15e11, 0.2e-3
    edges = rounded_edges(
        hertz, frame.curvature, (root, ends[0], other), array(modulus), array(radius)
    )
    pressure = float(hertz.max_pressure)
    assert len(edges) == 2
    extents = [float(half_extent(hertz, frame.curvature, end)) for end in (ends[0], other)]
    assert abs(extents[0] / extents[1] - 1) > 0.05
    for edge, extent in zip(edges, extents, strict=True):
        expected = (
            float(ends[0].distance) * pressure / extent,
            modulus * extent / (pressure * radius),
            float(hertz.semi_major * hertz.semi_minor) / extent**2,
        )
        np.testing.assert_allclose((edge.onset, edge.steepness, edge.aspect), expected, rtol=1e-14)


def test_a_life_is_that_of_the_capacity_with_cut_ellipses():
    """(C_a/F′)³ with the capacity of the root search, from which the life itself does not follow.

    The capacity of full ellipses is C_a g(C_a).
    """
    one = screw_of_30_mm(_LEAD).stages[0]
    fatigue = strength.truncated_fatigue(one)
    assert fatigue is not None
    capacity = fatigue.capacity()
    factor = float(fatigue.load_factor(capacity))
    assert factor > 1.001
    assert float(capacity) * factor == pytest.approx(float(fatigue.untruncated), rel=1e-12)
    assert float(strength.dynamic_capacity(one)) == pytest.approx(float(capacity), rel=1e-14)
    whole = without_addenda(screw_of_30_mm(_LEAD)).stages[0]
    assert float(fatigue.untruncated) == pytest.approx(
        float(strength.dynamic_capacity(whole)), rel=1e-14
    )
    shared = strength.truncated_fatigue(one, sharing_factor=1.2)
    assert shared is not None
    assert float(shared.untruncated) == pytest.approx(float(fatigue.untruncated) / 1.2, rel=1e-14)
    for load in (1e3, 3e4, float(capacity), 3 * float(capacity)):
        spectrum = strength.constant_load(array(10.0), array(load))
        life = strength.rating_life(one, None, spectrum, fatigue).revolutions
        comparable = float(fatigue.comparable_load(array(load), capacity))
        # Three times the tolerance of the root.
        assert float(life) == pytest.approx(1e6 * (float(capacity) / comparable) ** 3, rel=1e-12)


def test_a_life_needs_no_search_for_the_capacity():
    """The roots of a life's program are those of meshing and of the load sharing."""
    scene = screw_of_30_mm(_LEAD)

    def searches(name):
        program = jax.make_jaxpr(lambda m: prsm.compute(m, [name])[name])(scene)
        return str(program).count("while[")

    assert searches("dynamic_capacity") == searches("rating_life") + 1


def test_a_life_without_capacity_and_fatigue_names_the_remedy():
    one = screw_of_30_mm(_LEAD).stages[0]
    spectrum = strength.constant_load(array(10.0), array(1e4))
    for of in (strength.rating_life, strength.damage):
        with pytest.raises(
            ValueError, match=r"pass dynamic_capacity\(stage\), or truncated_fatigue"
        ):
            of(one, None, spectrum)


def test_damage_by_ends_that_are_not_a_number_is_none():
    """The flank without load would have a damage of 0."""
    one = screw_of_30_mm(_LEAD).stages[0]
    fatigue = strength.truncated_fatigue(one)
    unknown = eqx.tree_at(lambda f: f.sides[0].onsets[0], fatigue, array(np.nan))
    for load in (1e5, -1e5):
        spectrum = strength.constant_load(array(10.0), array(load))
        assert np.all(np.isfinite(strength.damage(one, None, spectrum, fatigue)))
        assert np.all(np.isnan(strength.damage(one, None, spectrum, unknown)))


@pytest.mark.parametrize("present", [(True, True), (True, False), (False, True), (False, False)])
def test_sides_with_different_numbers_of_ends(present):
    """One end on the screw side, two on the nut side, or no end: as each side by itself."""
    sides = [
        strength.SideOnset(array(1.5e9), (array(1.1e9),)),
        strength.SideOnset(array(1.2e9), (array(1.3e9), array(0.9e9))),
    ]
    risks, loads = (array(2e-3), array(3e-3)), np.asarray([0.0, 5e3, 2e4, 8e4])
    given = sides[0] if present[0] else None, sides[1] if present[1] else None
    fatigue = strength.TruncatedFatigue(given, risks, 1.1, array(5e4))

    def factor(load):
        return fatigue.load_factor(load)

    grown = 0.0
    for side, risk in zip(given, risks, strict=True):
        if side is not None:
            scale = 1.1 * loads / 1e4
            ratios = [
                1.0
                if load == 0
                else _risk_by_bisection(
                    [float(o) / (float(side.reference) * k ** (1 / 3)) for o in side.onsets]
                )
                for load, k in zip(loads, scale, strict=True)
            ]
            grown = grown + float(risk / (risks[0] + risks[1])) * (np.asarray(ratios) - 1)
    expected = (1 + grown) ** 0.3 * np.ones(4)
    np.testing.assert_allclose(factor(jnp.asarray(loads)), expected, rtol=1e-12)
    # No derivative of an end that is not there is infinite or not a number.
    second = jax.vmap(jax.hessian(factor))(jnp.asarray(loads))
    assert np.all(np.isfinite(second))


def _risk_by_bisection(reaches):
    """σ¹⁰ (1 − Σ w(t/σ)) with σ by bisection and w by quadrature."""
    ratio = pressure_ratio_by_bisection(reaches)
    return ratio**10 * (1 - sum(lamina_risk(min(t / ratio, 1.0)) for t in reaches))
