"""Capacities, buckling, whirling and preload against closed forms, and each other."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from ball_bearings import published, ring
from hypothesis import given, strategies as st
from scenes import STEEL, array, mechanism, stage, stage_contact, steady_state, thread

import prsm_jax as prsm
from prsm_jax import strength
from prsm_jax.contact import contact_frames
from prsm_jax.friction import CoulombFriction, Friction
from prsm_jax.mechanism import (
    AxialPlay,
    DutyCycle,
    LoadSharing,
    Mechanism,
    OperatingPoint,
    Screw,
    ScrewShaft,
    SplitNut,
    Strength,
)
from prsm_jax.quantities import _analysis
from prsm_jax.strength import _fatigue, _static, _subsurface

PRESSURE = 4.2e9


def screwed(data, radius=4e-3, lead=10e-3, **more):
    """A stage with closed-form curvatures, so that nothing needs to mesh."""
    given = {"curvature": "wu2022", "engaged_threads": 20.0, "strength": data}
    return stage(geometry=thread(radius, lead), **(given | more))


def column(end_conditions, length=1.0, root=10e-3, bore=None, **more):
    shaft = ScrewShaft(end_conditions, unsupported_length=length, root_radius=root, **more)
    screw = Screw(mass=1.0, inertia=1.0, bore_radius=bore)
    return screwed(Strength(shaft=shaft), screw=screw)


static_capacity = eqx.filter_jit(strength.static_capacity)
dynamic_capacity = eqx.filter_jit(strength.dynamic_capacity)
buckling_load = eqx.filter_jit(strength.buckling_load)
critical_speed = eqx.filter_jit(strength.critical_speed)
displacement = eqx.filter_jit(strength.relative_displacement)
ESTIMATED = screwed(Strength(permissible_pressure=PRESSURE, material_factor=1.0))


@pytest.mark.parametrize("curvature", ["exact", "wu2022"])
def test_the_static_capacity_gives_the_permissible_pressure(curvature):
    one = eqx.tree_at(lambda s: s.strength, screwed(None), ESTIMATED.strength, is_leaf=_absent)
    one = stage(
        geometry=one.thread, strength=one.strength, curvature=curvature, engaged_threads=20.0
    )
    contact = stage_contact(one, static_capacity(one))
    pressures = [contact.screw.hertz.max_pressure, contact.nut.hertz.max_pressure]
    np.testing.assert_allclose(max(pressures), PRESSURE, rtol=1e-12)
    assert min(pressures) < 0.95 * PRESSURE


def _absent(leaf):
    return leaf is None


def test_a_capacity_that_is_given_holds():
    given = screwed(Strength(PRESSURE, static_capacity=9e4, dynamic_capacity=6e4))
    assert static_capacity(given) == 9e4
    assert dynamic_capacity(given) == 6e4


def test_unequal_sharing_lowers_capacities():
    whole, shared = static_capacity(ESTIMATED), static_capacity(ESTIMATED, sharing_factor=1.6)
    np.testing.assert_allclose(shared, whole / 1.6, rtol=1e-14)
    # Half of the threads with all of the load, each with twice the mean: 2^{7/3 · 3/10}.
    factor = strength.fatigue_sharing_factor(jnp.asarray([2.0, 2.0, 0.0, 0.0]))
    np.testing.assert_allclose(factor, 2**0.7, rtol=1e-14)
    half = eqx.tree_at(lambda s: s.engaged_threads, ESTIMATED, array(10.0))
    np.testing.assert_allclose(
        dynamic_capacity(half), dynamic_capacity(ESTIMATED) / factor, rtol=1e-13
    )


def test_threads_that_share_unequally_lower_the_quantities():
    """By the factors of the distribution itself; one thread is alone with its load."""
    data = Strength(permissible_pressure=PRESSURE, material_factor=1.0)
    sharing = LoadSharing(
        6, screw_segment_stiffness=4e8, roller_segment_stiffness=1e8, nut_segment_stiffness=8e8
    )
    names = ["static_capacity", "dynamic_capacity", "static_safety"]
    factors = ["thread_sharing_factor_screw", "thread_sharing_factor_nut"]
    program = eqx.filter_jit(lambda m, wanted: prsm.compute(m, wanted))
    one = mechanism(screwed(data, engaged_threads=6.0, load_sharing=sharing))
    shared = program(one, [*names, *factors])
    equal = program(mechanism(screwed(data, engaged_threads=6.0)), names)
    largest = max(float(shared[name][0]) for name in factors)
    assert largest > 1.2
    for name in ("static_capacity", "static_safety"):
        np.testing.assert_allclose(shared[name], equal[name] / largest, rtol=1e-12)
    lowered = float(equal["dynamic_capacity"][0] / shared["dynamic_capacity"][0])
    assert 1 < lowered < largest


#: Three threads with errors and wear as large as their approaches: how they share depends on the
#: load and, with both flanks, on its sense.
UNEVEN = LoadSharing(
    3,
    screw_segment_stiffness=4e8,
    roller_segment_stiffness=1e8,
    nut_segment_stiffness=8e8,
    backlash=2e-5,
    screw_pitch_error=jnp.asarray([0.0, 4e-6, -3e-6]),
    screw_wear=jnp.asarray([3e-6, 0.0, 0.0]),
)
_borne = eqx.filter_jit(
    lambda m: prsm.compute(m, ["static_capacity", "static_safety", "dynamic_capacity"])
)


def _uneven(point, cycle=None, sharing=UNEVEN, play=None):
    data = Strength(permissible_pressure=PRESSURE, material_factor=1.0, play=play)
    one = screwed(data, engaged_threads=3.0, load_sharing=sharing)
    operating = None if point is None else OperatingPoint(100.0, point)
    turning = None
    if cycle is not None:
        turning = DutyCycle(*(jnp.asarray(x) for x in ([1.0, 1.0], [10.0, 30.0], cycle)))
    return Mechanism((one,), operating, duty_cycle=turning)


def test_threads_share_as_under_the_load_that_strength_looks_at():
    """Static strength at the largest load, fatigue at the equivalent one, whatever the point."""
    at = {load: _borne(_uneven(load)) for load in (-3e3, 3e3)}
    cubes = 0.25 * 1e3**3 + 0.75 * 3e3**3
    mean = _borne(_uneven(float(np.cbrt(cubes))))
    # Wear is on the forward flanks: the sense of the load makes a difference.
    assert abs(at[3e3]["static_capacity"][0] / at[-3e3]["static_capacity"][0] - 1) > 0.02
    assert abs(mean["dynamic_capacity"][0] / at[3e3]["dynamic_capacity"][0] - 1) > 0.01
    for point in (0.0, 2e2, 2.9e3):
        found = _borne(_uneven(point, [1e3, 3e3]))
        for name in ("static_capacity", "static_safety"):
            np.testing.assert_allclose(found[name], at[3e3][name], rtol=1e-12)
        np.testing.assert_allclose(found["dynamic_capacity"], mean["dynamic_capacity"], rtol=1e-12)
    back = _borne(_uneven(1e3, [1e3, -3e3]))
    np.testing.assert_allclose(back["static_safety"], at[-3e3]["static_safety"], rtol=1e-12)
    # The operating point is borne too, if it is larger than all phases.
    above = _borne(_uneven(-3e3, [1e3, 2e3]))
    np.testing.assert_allclose(above["static_safety"], at[-3e3]["static_safety"], rtol=1e-12)


def test_without_load_nothing_is_shared_unequally():
    """One tooth would be the first to touch; what it bears is rounding."""
    idle = _borne(_uneven(0.0))
    whole = static_capacity(screwed(ESTIMATED.strength, engaged_threads=3.0))
    np.testing.assert_allclose(idle["static_capacity"], whole[None], rtol=1e-12)
    assert np.isinf(idle["static_safety"])
    # However small, a load is one: one tooth bears all of it.
    hardly = _borne(_uneven(1e-6))
    np.testing.assert_allclose(hardly["static_capacity"], whole[None] / 3, rtol=1e-3)


def test_a_preload_of_two_nuts_is_shared_too():
    """Without a load each nut bears the preload, and its threads share that."""
    preloaded = _borne(_uneven(0.0, play=AxialPlay(preload_force=3e3)))
    alone = _borne(_uneven(3e3))
    for name in ("static_capacity", "static_safety", "dynamic_capacity"):
        np.testing.assert_allclose(preloaded[name], alone[name], rtol=1e-12)


def test_one_load_is_shared_once(monkeypatch):
    """Balances in the program: one where the operating point is all, three with a duty cycle."""
    solved = []
    one_stage = _analysis.stage_load_distributions
    monkeypatch.setattr(
        _analysis,
        "stage_load_distributions",
        lambda stage, loads, *more: solved.extend(loads) or one_stage(stage, loads, *more),
    )

    def balances(one, names=("static_safety", "rating_life", "largest_thread_load"), **given):
        solved.clear()
        eqx.filter_eval_shape(lambda m: prsm.compute(m, names, **given), one)
        return len(solved)

    assert balances(_uneven(3e3)) == 1
    assert balances(_uneven(3e3, [1e3, 2e3])) == 3
    assert balances(_uneven(3e3, [1e3, 2e3]), load=5e3) == 1
    # What lacks an operating point has a strength all the same.
    assert balances(_uneven(None, [1e3, 2e3]), ("static_safety", "rating_life")) == 2
    # A preload is not on the flanks of the operating point.
    assert balances(_uneven(3e3, play=AxialPlay(preload_force=1e3))) == 2


def test_permanent_deformation_in_newtons_and_millimetres():
    load = 5e4
    screw, nut = contact_frames(ESTIMATED.thread, None, "wu2022")
    diameter = 2e3 * float(ESTIMATED.thread.profile_radius)
    dents = []
    for frame in (screw, nut):
        force = load / 200 * float(frame.normal_per_axial)
        first = (
            float(frame.curvature.total) - float(frame.curvature.difference_squared) ** 0.5
        ) / 2
        second = float(frame.curvature.total) - first
        dents.append(1.3e-7 * force**2 / diameter**2 * (2e-3 * first) * (2e-3 * second))
    found = _static.permanent_deformation(ESTIMATED, array(load))
    np.testing.assert_allclose(found, max(dents), rtol=1e-13)


def test_orthogonal_shear_of_lines_and_circles():
    """A line has p₀/4 at b/2. At a circle the cubic is t (2t² − t − 2) = 0: t = (1 + √17)/4."""
    shear = eqx.filter_jit(_subsurface.orthogonal_shear)
    np.testing.assert_allclose(shear(array(1.0), array(1.0), array(0.0)), (0.25, 0.5), rtol=1e-15)
    t = (1 + np.sqrt(17)) / 4
    root = np.sqrt(2 * t - 1)
    np.testing.assert_allclose(
        shear(array(1.0), array(1.0), array(1.0)),
        (root / (2 * t * (t + 1)), 1 / ((t + 1) * root)),
        rtol=1e-15,
    )
    ratios = jnp.logspace(-6, 6, 40)
    parameter = _subsurface.shape_parameter(ratios)
    residual = (parameter**2 - 1) * (2 * parameter - 1) / ratios - 1
    # t − 1 ≈ (b/a)²/2 loses digits against 1 where the ellipse is long.
    np.testing.assert_allclose(residual, 0, atol=1e-9)


def test_the_constant_is_that_of_ball_bearings():
    found, balls = ring(0.52, 0.2, 1)
    np.testing.assert_allclose(found, published(0.52, 0.2, 1, balls), rtol=1e-7)


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("conformity", [0.515, 0.53])
@pytest.mark.parametrize("ratio", [0.05, 0.3])
def test_other_ball_bearings_follow(conformity, ratio, sense):
    """Their printed formula is a fit, made of powers, of the theory that is used here."""
    found, balls = ring(conformity, ratio, sense)
    assert found == pytest.approx(published(conformity, ratio, sense, balls), rel=0.04)


def test_stress_cycles_roll_without_slip():
    """As much of a track passes on the roller as on the screw, and as on the nut."""
    screw, roller, nut = (float(cycles) for cycles in strength.cycles_per_turn(ESTIMATED))
    rollers, geometry = ESTIMATED.roller_count, ESTIMATED.thread
    rolled = roller * float(geometry.roller_radius)
    np.testing.assert_allclose(screw / rollers * float(geometry.screw_radius), rolled, rtol=1e-14)
    np.testing.assert_allclose(nut / rollers * float(geometry.nut_radius), rolled, rtol=1e-14)


@given(st.floats(0.1, 10), st.floats(0.1, 10), st.floats(0.5, 3))
def test_capacities_scale_as_bearings_do(size, threads, factor):
    """C_a with D^1.8, z^0.7 and the steel; C_0a with D² and z."""
    scaled = screwed(
        Strength(PRESSURE, material_factor=factor),
        4e-3 * size,
        10e-3 * size,
        engaged_threads=20 * threads,
    )
    dynamic = dynamic_capacity(scaled) / dynamic_capacity(ESTIMATED)
    np.testing.assert_allclose(dynamic, factor * size**1.8 * threads**0.7, rtol=1e-11)
    static = static_capacity(scaled) / static_capacity(ESTIMATED)
    np.testing.assert_allclose(static, size**2 * threads, rtol=1e-11)


def test_each_track_fails_by_the_pressure_of_its_own_side():
    """Risks go with F^(10/3), each with the load of its own side alone."""
    risks = eqx.filter_jit(lambda contact: _fatigue.side_risks(ESTIMATED, None, contact))
    light, heavy = (stage_contact(ESTIMATED, array(load)) for load in (10e3, 20e3))
    screw, nut = risks(light)
    uneven = risks(eqx.tree_at(lambda c: c.nut, light, heavy.nut))
    np.testing.assert_allclose(uneven, (screw, 2 ** (10 / 3) * nut), rtol=1e-11)
    uneven = risks(eqx.tree_at(lambda c: c.screw, light, heavy.screw))
    np.testing.assert_allclose(uneven, (2 ** (10 / 3) * screw, nut), rtol=1e-11)
    # One million turns at the capacity fail one in ten.
    both = risks(stage_contact(ESTIMATED, dynamic_capacity(ESTIMATED)))
    np.testing.assert_allclose(sum(both), -np.log(0.9), rtol=1e-11)


def test_quantities_without_shared_loads_are_the_laws_themselves():
    """Nothing is taken off a capacity where all threads bear alike, split nut or not."""
    found = _borne(Mechanism((ESTIMATED,), OperatingPoint(100.0, 5e3)))
    np.testing.assert_allclose(
        found["dynamic_capacity"][0], dynamic_capacity(ESTIMATED), rtol=1e-12
    )
    np.testing.assert_allclose(found["static_capacity"][0], static_capacity(ESTIMATED), rtol=1e-12)


def test_rolling_along_either_axis_joins_at_the_circle():
    total = array(100.0)
    slants = jnp.asarray([-0.3, -1.1e-5, -0.9e-5, 0.0, 0.9e-5, 1.1e-5, 0.3])
    found = jax.vmap(lambda s: _fatigue._rolling_ratio(total, total * (1 + s) / 2, "exact"))(slants)
    np.testing.assert_allclose(found * found[::-1], 1, rtol=1e-12)
    # d log κ/dτ = −4/3 at the circle, from κ ≈ (A/B)^{2/3}.
    np.testing.assert_allclose(np.log(found[1:-1]), -4 / 3 * slants[1:-1], rtol=1e-8, atol=1e-16)
    assert found[-1] < 1 < found[0]


# Steel of the catalogues: 206 GPa, 7850 kg/m³.
CATALOGUE_STEEL = eqx.tree_at(lambda m: m.youngs_modulus, STEEL, array(206e9))


def _catalogue(one):
    return eqx.tree_at(lambda s: s.material, one, CATALOGUE_STEEL)


@pytest.mark.parametrize(
    ("ends", "buckling", "whirling"),
    [
        ("fixed_free", 1.25, 3.4),
        ("supported_supported", 5.0, 9.7),
        ("fixed_supported", 10.2, 15.1),
        ("fixed_fixed", 20.0, 21.9),
    ],
)
def test_factors_of_ball_screw_catalogues(ends, buckling, whirling):
    """Euler/2 = m d⁴/l² 10⁴ N and 0.8 of the critical speed = f d/l² 10⁷ rpm, in mm: m and f."""
    one = _catalogue(column(ends, length=1.0, root=10e-3))
    force = 0.5 * float(buckling_load(one))
    assert force / (20**4 / 1000**2 * 1e4) == pytest.approx(buckling, rel=5e-3)
    rpm = 0.8 * float(critical_speed(one)) * 30 / np.pi
    assert rpm / (20 / 1000**2 * 1e7) == pytest.approx(whirling, abs=0.06)


def test_short_columns_yield_and_slender_ones_bend():
    strong = 600e6
    short = column("supported_supported", yield_strength=strong)
    area = np.pi * 1e-4
    join = np.pi * np.sqrt(2 * 210e9 / strong) * 10e-3 / 2
    load = eqx.filter_jit(jax.value_and_grad(lambda length: strength.buckling_load(short, length)))
    below, slope_below = load(array(join * (1 - 1e-9)))
    above, slope_above = load(array(join * (1 + 1e-9)))
    np.testing.assert_allclose([below, above], strong / 2 * area, rtol=1e-8)
    np.testing.assert_allclose(slope_below, slope_above, rtol=1e-7)
    np.testing.assert_allclose(load(array(1e-9))[0], strong * area, rtol=1e-12)
    euler = np.pi**2 * 210e9 * np.pi / 4 * 1e-8
    np.testing.assert_allclose(load(array(3.0))[0], euler / 9, rtol=1e-13)
    assert np.isfinite(load(array(0.0))[1])


def test_a_bore_weakens_the_column_and_quickens_the_shaft():
    solid, hollow = column("fixed_fixed"), column("fixed_fixed", bore=6e-3)
    ratio = 1 - 0.6**4
    np.testing.assert_allclose(buckling_load(hollow) / buckling_load(solid), ratio, rtol=1e-13)
    faster = critical_speed(hollow) / critical_speed(solid)
    np.testing.assert_allclose(faster, np.sqrt(1 + 0.36), rtol=1e-13)


def test_the_dn_limit_may_come_first():
    one = column("fixed_fixed", dn_limit=5.0)
    np.testing.assert_allclose(strength.permissible_speed(one), 5.0 / 24e-3, rtol=1e-14)
    free = column("fixed_free", length=3.0, dn_limit=1e6)
    np.testing.assert_allclose(
        strength.permissible_speed(free), 0.8 * strength.critical_speed(free), rtol=1e-14
    )


@given(st.floats(0, 20))
def test_preloaded_nuts_balance_the_load(ratio):
    """F₁ − F₂ = F always; both follow Hertz' law from one displacement while they touch."""
    preload = 1300.0
    first, second = _preloaded(array(ratio * preload), array(preload))
    np.testing.assert_allclose(first - second, ratio * preload, atol=1e-11 * preload)
    s = float(displacement(array(ratio)))
    touching = max(1 - s, 0.0)
    np.testing.assert_allclose(second, preload * touching**1.5, atol=1e-12 * preload)
    np.testing.assert_allclose(displacement(array(-ratio)), -s, rtol=1e-15)


_preloaded = eqx.filter_jit(strength.preloaded_pair_loads)


def test_a_preloaded_nut_opens_at_two_to_the_three_halves():
    np.testing.assert_allclose(strength.preload_opening_load(array(1.0)), 2**1.5, rtol=1e-15)
    first, second = _preloaded(array(2**1.5), array(1.0))
    np.testing.assert_allclose((first, second), (2**1.5, 0.0), atol=1e-14)
    # The usual approximation takes the displacement as linear in the load.
    loads = jnp.linspace(0, 2**1.5, 400)
    exact, _ = _preloaded(loads, array(1.0))
    high = np.max((1 + np.asarray(loads) / 2**1.5) ** 1.5 / np.asarray(exact) - 1)
    assert 0.024 < high < 0.025


@pytest.mark.parametrize("ratio", [0.0, 1.0, 2**1.5 - 1e-9, 2**1.5, 2**1.5 + 1e-9, 10.0, -2.0])
def test_derivatives_of_a_preloaded_pair(ratio):
    forward = _preloaded_slope(array(ratio))
    reverse = _preloaded_gradient(array(ratio))
    # Not across the opening, where the slope itself has a root's corner.
    step = 1e-5 if abs(ratio - 2**1.5) > 1e-6 else 1e-9
    s = [float(displacement(array(ratio + x))) for x in (step, -step)]
    np.testing.assert_allclose(forward, reverse, rtol=1e-14)
    np.testing.assert_allclose(forward, (s[0] - s[1]) / (2 * step), rtol=5e-5)


_preloaded_slope = jax.jit(
    lambda f: jax.jvp(strength.relative_displacement, (f,), (jnp.ones_like(f),))[1]
)
_preloaded_gradient = jax.jit(jax.grad(strength.relative_displacement))


def test_stiffness_of_a_preloaded_pair():
    """Twice one nut's tangent stiffness without load, one nut's own after the opening."""
    preload, approach = array(1000.0), array(5e-6)
    one = 1.5 * 1000.0 / 5e-6
    np.testing.assert_allclose(
        strength.preloaded_pair_stiffness(array(0.0), preload, approach), 2 * one, rtol=1e-14
    )
    opened = strength.preloaded_pair_stiffness(array(2**1.5 * 1000.0), preload, approach)
    np.testing.assert_allclose(opened, np.sqrt(2) * one, rtol=1e-7)


@pytest.mark.parametrize(
    ("arrangement", "share"), [("double_nut", 1.0), ("split_nut", 0.5)], ids=["nuts", "halves"]
)
@pytest.mark.parametrize("load", [0.0, 1.2e3, -1.2e3, 9e3])
def test_pressure_of_preloaded_nuts_is_that_of_the_nut_that_carries_more(arrangement, share, load):
    """Two springs k x^{3/2} in balance, by bisection; Hertz under the load of the stiffer-pressed.

    Half of a split nut has half of the threads, so twice the force on each.
    """
    preload = 1e3
    play = Strength(play=AxialPlay(preload_force=preload, arrangement=arrangement))
    found = _pressure(mechanism(screwed(play), load=load))["preloaded_pressure"]
    lower, upper = 0.0, 10.0
    for _ in range(60):
        moved = (lower + upper) / 2
        balance = (1 + moved) ** 1.5 - max(1 - moved, 0.0) ** 1.5
        lower, upper = (moved, upper) if balance < abs(load) / preload else (lower, moved)
    carried = preload * (1 + lower) ** 1.5 / share
    contact = stage_contact(screwed(None), array(carried))
    expected = max(one.hertz.max_pressure for one in (contact.screw, contact.nut))
    np.testing.assert_allclose(found, [expected], rtol=1e-12)
    with pytest.raises(prsm.MissingDataError, match="not preloaded"):
        prsm.compute(mechanism(screwed(Strength()), load=load), ["preloaded_pressure"])


_pressure = eqx.filter_jit(lambda m: prsm.compute(m, ["preloaded_pressure"]))


def test_preload_torque_is_that_of_both_senses():
    """The quantity solves both nuts' balance; efficiencies of the same threads give the same."""
    friction = Friction(thread=CoulombFriction(0.05))
    play = Strength(play=AxialPlay(preload_force=1000.0))
    preloaded = mechanism(stage(strength=play, friction=friction))
    found = eqx.filter_jit(lambda m: prsm.compute(m, ["preload_torque"]))(preloaded)
    forward = steady_state(mechanism(stage(friction=friction)), 100.0, 1000.0)
    backward = steady_state(mechanism(stage(friction=friction)), -100.0, 1000.0)
    expected = strength.preload_torque(
        array(1000.0), array(10e-3), forward.efficiency, backward.efficiency
    )
    np.testing.assert_allclose(found["preload_torque"], expected[None], rtol=1e-10)


def test_backlash_adds_up_the_teeth():
    def play(**given):
        return stage(strength=Strength(play=AxialPlay(**given)), geometry=thread())

    gap = float(prsm.mesh(thread()).axial_gap)
    thinned = play(screw_tooth_thinning=9e-5, roller_tooth_thinning=3e-5, nut_tooth_thinning=2e-5)
    np.testing.assert_allclose(strength.backlash(thinned), 2 * gap + 1.7e-4, rtol=1e-12)
    assert strength.backlash(play(axial_backlash=4e-5)) == 4e-5
    assert strength.backlash(play(preload_force=100.0)) == 0
    with pytest.raises(prsm.MissingDataError, match="axial_backlash"):
        strength.backlash(play())
    with pytest.raises(ValueError, match="remove one"):
        AxialPlay(axial_backlash=1e-5, preload_force=1.0)


def test_two_preloads_for_one_force_are_found():
    def found(stated, spacer, arrangement: Any = "split_nut"):
        one = stage(
            strength=Strength(play=AxialPlay(preload_force=stated, arrangement=arrangement)),
            load_sharing=LoadSharing(20, split_nut=SplitNut(10, preload=spacer)),
        )
        return [f for f in prsm.check(mechanism(one)) if f.name == "preload"]

    assert found(3e3, 3.01e3) == []
    (finding,) = found(3e3, 2e3)
    assert (finding.value, finding.limit) == (3e3, 2e3)
    assert "is 3000 N" in finding.message
    assert "preload 2000 N" in finding.message
    (finding,) = found(3e3, 3e3, "double_nut")
    assert 'arrangement is "double_nut"' in finding.message


def test_contradictions_of_strength_and_load_sharing_are_found():
    """Each by its name and both numbers; what has a reason is none."""

    def found(play=None, engaged=20.0, **sharing):
        data = None if play is None else Strength(play=AxialPlay(**play))
        one = stage(strength=data, engaged_threads=engaged, load_sharing=LoadSharing(20, **sharing))
        names = {"preload", "engaged_threads", "axial_backlash"}
        return [(f.name, f.value, f.limit) for f in prsm.check(mechanism(one)) if f.name in names]

    assert found() == found(engaged=19.6) == found({"axial_backlash": 5e-6}, backlash=5e-6) == []
    assert found(engaged=10.0) == [("engaged_threads", 10.0, 20.0)]
    halves, apart = SplitNut(10, preload=1e3), SplitNut(10, offset=2e-5)
    assert found(engaged=10.0, split_nut=halves) == [("engaged_threads", 10.0, 20.0)]
    # Both nuts of a pair in one chain, and the threads of one.
    pair = found({"preload_force": 1e3}, 10.0, split_nut=halves)
    assert [name for name, *_ in pair] == ["preload"]
    assert found({"axial_backlash": 5e-6}, backlash=8e-6) == [("axial_backlash", 5e-6, 8e-6)]
    assert found({"axial_backlash": 5e-6}, split_nut=halves) == [("axial_backlash", 5e-6, 0.0)]
    # Thinned teeth leave a play that nobody has measured.
    ((name, play, _),) = found({"screw_tooth_thinning": 2e-4}, backlash=8e-6)
    gap = float(prsm.mesh(thread()).axial_gap)
    assert name == "axial_backlash"
    np.testing.assert_allclose(play, 2 * gap + 2e-4, rtol=1e-12)
    assert found(split_nut=apart) == []
    assert found({}, split_nut=apart) == [("preload", 2e-5, 0.0)]
    stated = {"preload_force": 1e3, "arrangement": "split_nut"}
    assert found(stated, split_nut=apart) == []


def test_the_preload_of_a_split_nut_counts_in_strength():
    """Given for load sharing only, it is that which strength could have been given itself."""
    names = ["static_safety", "rating_life", "axial_backlash", "lost_motion", "preload_torque"]
    data: dict[str, Any] = {"static_capacity": 9e4, "dynamic_capacity": 6e4}
    stated = AxialPlay(preload_force=3e3, arrangement="split_nut")
    program = eqx.filter_jit(lambda m: prsm.compute(m, names))

    def computed(play=None, **split):
        sharing = LoadSharing(20, split_nut=SplitNut(**split)) if split else None
        one = screwed(Strength(**data, play=play), load_sharing=sharing)
        return program(mechanism(one, load=0.0))

    expected = computed(stated)
    assert expected["static_safety"] == 9e4 / 3e3
    spacer = computed(after_thread=10, preload=3e3)
    for name in names:
        np.testing.assert_allclose(spacer[name], expected[name], rtol=1e-14, err_msg=name)
    # Its halves need not be alike: the smaller one bears the load with fewer threads.
    uneven = screwed(ESTIMATED.strength, load_sharing=LoadSharing(20, split_nut=SplitNut(5, 3e3)))
    np.testing.assert_allclose(static_capacity(uneven), static_capacity(ESTIMATED) / 4, rtol=1e-14)
    # A preload that results from the spacer's length is no number of the file.
    assert computed(stated, after_thread=10, offset=2e-5)["static_safety"] == 9e4 / 3e3
    for name in ("static_safety", "rating_life", "lost_motion"):
        with pytest.raises(prsm.MissingDataError, match="results from its offset"):
            prsm.compute(
                mechanism(
                    screwed(
                        Strength(**data),
                        load_sharing=LoadSharing(20, split_nut=SplitNut(10, offset=2e-5)),
                    )
                ),
                [name],
            )


def test_lost_motion_with_and_without_preload():
    """Both ways by one nut's approach; half as far and less when a second nut braces it."""
    loose = screwed(Strength(play=AxialPlay(axial_backlash=3e-5)))
    load, moved = array(5000.0), eqx.filter_jit(strength.lost_motion)
    contact = stage_contact(loose, load)
    per_thread = 5000.0 / 200
    approach = per_thread / contact.screw.axial_stiffness + per_thread / contact.nut.axial_stiffness
    np.testing.assert_allclose(moved(loose, load), 3e-5 + 2 * approach, rtol=1e-12)
    preloaded = screwed(Strength(play=AxialPlay(preload_force=5000.0 / 2**1.5)))
    # At the opening s = 1, and one nut carries the load: (2^{3/2} F_p) on δ = 2 δ₀.
    np.testing.assert_allclose(moved(preloaded, load), approach, rtol=1e-12)
    halves = AxialPlay(preload_force=5000.0 / 2**1.5, arrangement="split_nut")
    np.testing.assert_allclose(
        moved(screwed(Strength(play=halves)), load), approach * 2 ** (2 / 3), rtol=1e-12
    )
