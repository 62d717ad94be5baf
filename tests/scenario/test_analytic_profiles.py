"""Drives over time: limits kept, integrals and derivatives right, tables as SciPy's."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate
from scenes import array

import prsm_jax as prsm
from prsm_jax.scenario import (
    AerodynamicLoad,
    ConstantProfile,
    FrictionLoad,
    HingeLoad,
    PositionTableLoad,
    Scenario,
    SCurveMoveProfile,
    SequenceProfile,
    SineProfile,
    SumLoad,
    TableProfile,
    TorqueScenario,
    TrapezoidalMoveProfile,
    TrapezoidalProfile,
    depends_on_motion,
)

TRAPEZOID = TrapezoidalProfile(100.0, 0.1, 0.2, 0.05, 0.15)
#: Long enough for all seven stretches; never at the limit of speed; nor at that of acceleration.
CURVES = (
    SCurveMoveProfile(50.0, 100.0, 2e3, 1e5, 0.1),
    SCurveMoveProfile(-4.0, 100.0, 2e3, 1e5),
    SCurveMoveProfile(0.1, 100.0, 2e3, 1e5),
    SCurveMoveProfile(15.0, 10.0, 2e3, 1e5),
)
TIMES, VALUES = np.array([0.0, 0.1, 0.15, 0.4, 0.5, 0.8]), np.array([0.0, 9, 10, -3, -3, 7])


def _table(interpolation):
    return TableProfile(TIMES, VALUES, interpolation)


PROFILES = {
    "sine": SineProfile(30.0, 2.0, 5.0, 0.3),
    "constant": ConstantProfile(3.0, 0.5),
    "trapezoidal": TRAPEZOID,
    "triangular move": TrapezoidalMoveProfile(2.0, 100.0, 1e3, 3e3),
    "move": TrapezoidalMoveProfile(-20.0, 100.0, 1e3, 3e3, 0.1),
    **{f"s-curve {index}": curve for index, curve in enumerate(CURVES)},
    "linear": _table("linear"),
    "cubic": _table("cubic"),
    "monotone": _table("monotone"),
    "sequence": SequenceProfile((TRAPEZOID, CURVES[1], _table("cubic"))),
    "reversing": SequenceProfile((TRAPEZOID, ConstantProfile(2.0, 0.1)), 3, True),
}


@pytest.fixture(scope="module")
def curves():
    """Value, derivative and integral of every profile at many times, by one program."""
    # No break falls on one of them.
    times = jnp.linspace(0.0, 1.99937, 4001)

    @jax.jit
    def evaluate(profiles):
        def at(profile):
            value = jax.vmap(profile)(times)
            slope = jax.vmap(lambda t: jax.jvp(profile, (t,), (jnp.ones_like(t),))[1])(times)
            return value, slope, jax.vmap(profile.angle)(times)

        return {name: at(profile) for name, profile in profiles.items()}

    found = evaluate(PROFILES)
    return np.asarray(times), {k: tuple(map(np.asarray, v)) for k, v in found.items()}


@pytest.mark.parametrize("name", PROFILES)
def test_integral_and_derivative(name, curves):
    """The value is the derivative of the angle and the integral of its slope, past the breaks.

    By Simpson's rule over steps that hold no break, which is exact for cubics.
    """
    times, found = curves
    value, slope, angle = found[name]
    assert angle[0] == 0
    breaks = np.asarray(PROFILES[name].break_times)[:, None]
    start, end = times[:-2:2], times[2::2]
    smooth = ~np.any((breaks >= start) & (breaks < end) & (breaks > 0), axis=0)
    assert np.sum(smooth) > 1950

    def integrals(curve):
        return (curve[:-2:2] + 4 * curve[1:-1:2] + curve[2::2]) * (end - start) / 6

    for curve, whole in ((value, angle), (slope, value)):
        error = np.diff(whole[::2]) - integrals(curve)
        # Rounding, and for the sine its fourth derivative, h⁵ (2πf)⁴ A/2880 of the slope.
        assert np.max(np.abs(error[smooth])) < 1e-11


@pytest.mark.parametrize("index", range(len(CURVES)))
def test_s_curve_keeps_its_limits(index, curves):
    """And meets one of them at every time, which makes it the fastest."""
    times, found = curves
    value, slope, angle = found[f"s-curve {index}"]
    move = CURVES[index]
    assert angle[-1] == pytest.approx(float(move.angle_moved), rel=1e-12)
    assert np.max(np.abs(value)) <= float(move.speed_limit) * (1 + 1e-12)
    assert np.max(np.abs(slope)) <= float(move.acceleration_limit) * (1 + 1e-12)
    moving = times < float(move.duration - move.dwell_time) - 1e-3
    jerk = np.abs(np.diff(slope) / np.diff(times))[moving[1:]]
    assert np.max(jerk) <= float(move.jerk_limit) * (1 + 1e-9)
    full = np.abs(value[1:]) > (1 - 1e-9) * float(move.speed_limit)
    steep = np.abs(slope[1:]) > (1 - 1e-9) * float(move.acceleration_limit)
    bent = np.append(jerk, np.zeros(len(full) - len(jerk))) > (1 - 1e-6) * float(move.jerk_limit)
    # Steps in which one stretch ends and the next begins meet neither limit fully.
    assert np.sum(~(full | steep | bent) & moving[1:]) <= 8
    assert np.all(value[times > float(move.duration)] == 0)


def test_what_is_not_given_takes_no_time():
    """No dwell unless asked for, and a fall as long as the rise: the durations of three shapes."""
    up_and_down = TrapezoidalProfile(100.0, 0.1, 0.2)
    assert float(up_and_down.duration) == pytest.approx(0.4, rel=1e-15)
    # A triangle of height 60 and an area of 12; seven stretches of which four are 0.1 s long.
    triangle = TrapezoidalMoveProfile(12.0, 100.0, 300.0)
    assert float(triangle.duration) == pytest.approx(0.4, rel=1e-14)
    curve = SCurveMoveProfile(6.0, 100.0, 300.0, 3000.0)
    assert float(curve.duration) == pytest.approx(0.4, rel=1e-14)
    for profile, dwell in ((up_and_down, 0.3), (triangle, 0.7), (curve, 0.2)):
        longer = dataclasses.replace(profile, dwell_time=array(dwell))
        assert float(longer.duration) == pytest.approx(0.4 + dwell, rel=1e-14)


def test_moves_travel_their_angle(curves):
    _, found = curves
    for name in ("triangular move", "move"):
        value, slope, angle = found[name]
        move = PROFILES[name]
        assert angle[-1] == pytest.approx(float(move.angle_moved), rel=1e-12)
        assert np.max(np.abs(slope)) == pytest.approx(3e3, rel=1e-12)
        # At rest exactly, so that a mechanism at rest is seen as such.
        assert value[-1] == 0
    assert np.max(np.abs(found["move"][0])) == 100
    # 2 rad at 1000 and 3000 rad/s²: v = √(2 s a d/(a + d)).
    # Its peak lies between two samples, half a millisecond of 3000 rad/s² apart.
    assert np.max(found["triangular move"][0]) == pytest.approx(np.sqrt(3000), abs=1.5)


def test_tables_are_those_of_scipy(curves):
    times, found = curves
    inside = times <= TIMES[-1]
    slopes = np.gradient(VALUES, TIMES, edge_order=2)
    references = {
        "linear": lambda t: np.interp(t, TIMES, VALUES),
        "cubic": scipy.interpolate.CubicHermiteSpline(TIMES, VALUES, slopes),
        "monotone": scipy.interpolate.PchipInterpolator(TIMES, VALUES),
    }
    for name, reference in references.items():
        value = found[name][0]
        np.testing.assert_allclose(value[inside], reference(times[inside]), atol=1e-12)
        assert np.all(value[~inside] == VALUES[-1])
        whole, _ = scipy.integrate.quad(reference, 0, TIMES[-1], points=TIMES[1:-1])
        at_end = PROFILES[name].angle(array(TIMES[-1]))
        assert float(at_end) == pytest.approx(whole, rel=1e-9)
    for start, end, low, high in zip(TIMES, TIMES[1:], VALUES, VALUES[1:], strict=False):
        between = (times >= start) & (times <= end)
        value = found["monotone"][0][between]
        assert value.min() >= min(low, high) - 1e-12
        assert value.max() <= max(low, high) + 1e-12


def test_sequences(curves):
    """Parts in their turn, and every second run the other way."""
    _, found = curves
    period = 0.6
    reversing = PROFILES["reversing"]
    for time in (0.02, 0.25, 0.33, 0.55):
        value = float(reversing(array(time)))
        assert value != 0
        assert float(reversing(array(time + period))) == pytest.approx(-value, rel=1e-12)
        assert float(reversing(array(time + 2 * period))) == pytest.approx(value, rel=1e-12)
    # Once forth and once back is no angle at all.
    assert float(reversing.angle(array(2 * period))) == pytest.approx(0.0, abs=1e-12)
    breaks = np.asarray(reversing.break_times)
    assert len(breaks) == 3 * (4 + 1 + 2)
    assert np.max(breaks) == pytest.approx(3 * period)
    in_turn = found["sequence"][0]
    np.testing.assert_allclose(in_turn[:1000], found["trapezoidal"][0][:1000], atol=1e-12)


def test_derivatives_by_the_numbers_of_a_profile():
    """Forward, reverse and finite differences, away from breaks."""
    times = array(np.array([0.013, 0.05, 0.21, 0.37, 0.411]))

    @jax.jit
    def everything(values):
        def evaluate(v):
            curve = SCurveMoveProfile(v[0], v[1], v[2], v[3])
            straight = TrapezoidalMoveProfile(v[0], v[1], v[2])
            table = TableProfile(TIMES, v[0] * VALUES, "monotone")
            both = SequenceProfile((straight, curve), 2, True)
            found = [
                jax.vmap(f)(times) for p in (curve, straight, both, table) for f in (p, p.angle)
            ]
            return jnp.concatenate(found)

        moved = [
            (evaluate(values + h * e) - evaluate(values - h * e)) / (2 * h)
            for e, h in zip(jnp.eye(4), 1e-6 * values, strict=True)
        ]
        return jax.jacfwd(evaluate)(values), jax.jacrev(evaluate)(values), jnp.stack(moved, -1)

    found = everything(array(np.array([20.0, 90.0, 1.5e3, 8e4])))
    forward, reverse, difference = map(np.asarray, found)
    np.testing.assert_allclose(reverse, forward, atol=1e-10 * np.abs(forward).max())
    scale = np.max(np.abs(forward), axis=0)
    np.testing.assert_allclose(forward / scale, difference / scale, atol=1e-6)


def test_break_times_of_a_scenario():
    """Those of drive and load, in order, none past the end."""
    table = PositionTableLoad([0.0, 0.1], [1.0, 2.0])
    gust = AerodynamicLoad(1e-3, TableProfile([0.0, 0.25], [0.0, 1e3]))
    found = Scenario(TRAPEZOID, SumLoad((table, gust, 3.0)), 0.3).break_times
    np.testing.assert_allclose(found, [0.0, 0.1, 0.25, 0.3, 0.3, 0.3], atol=1e-15)
    assert Scenario(100.0, 7e3, 1.0).break_times.shape == (0,)
    assert len(TorqueScenario(TRAPEZOID, 7e3, 1.0).break_times) == 4


def test_loads_are_told_apart_by_what_they_take():
    assert depends_on_motion(HingeLoad(1.0))
    assert depends_on_motion(lambda t, z, v, a: z)
    assert depends_on_motion(SumLoad((1.0, FrictionLoad(1.0, 1.0))))
    for load in (7.0, TRAPEZOID, lambda t: t, jnp.sin, SumLoad((1.0, TRAPEZOID))):
        assert not depends_on_motion(load)
    with pytest.raises(ValueError, match="known only with a mechanism"):
        Scenario(100.0, HingeLoad(1.0), 1.0).load_at(array(0.0))


def test_values_of_loads():
    at = (array(0.5), array(0.05), array(-0.2), array(3.0))
    assert float(HingeLoad(1.0, 100.0, 10.0, 2.0)(*at)) == pytest.approx(1 + 5 - 2 + 6)
    stream = AerodynamicLoad(2.0, SineProfile(0.0, 1.0, 100.0), 1.0, 0.5, 25.0)
    assert float(stream(*at)) == pytest.approx(1 + 100 * (0.1 - 0.1) - 25 * 0.04)
    table = PositionTableLoad([0.0, 0.1], [1.0, 2.0])
    assert float(table(*at)) == pytest.approx(1.5)
    assert float(FrictionLoad(10.0, 0.2)(*at)) == pytest.approx(-10 / np.sqrt(2))
    ramp = TrapezoidalProfile(10.0, 1.0, 1.0)
    assert float(SumLoad((table, ramp, 4.0))(*at)) == pytest.approx(1.5 + 5 + 4)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: TrapezoidalProfile(1.0, 0.0, 1.0), "rise_time is 0 s; it must be more than 0"),
        (lambda: TrapezoidalProfile(1.0, 1.0, -1.0), "hold_time is -1 s; it must be 0 or more"),
        (lambda: TrapezoidalMoveProfile(0.0, 1.0, 1.0), "angle_moved is 0 rad; .* not 0"),
        (
            lambda: SCurveMoveProfile(1.0, 1.0, 1.0, -1.0),
            "jerk_limit is -1 rad/s³; it must be more",
        ),
        (lambda: TableProfile([0.0, 0.0], [1.0, 2.0]), "values that increase"),
        (
            lambda: TableProfile([0.0, 1.0], [1.0]),
            "values has 1 number, but times has 2; give as many",
        ),
        (lambda: TableProfile([-1.0, 1.0], [0.0, 2.0]), "times is -1 s; it must be 0 or more"),
        (lambda: TableProfile([0.0, 1.0], [1.0, 2.0], "quintic"), "choose one of linear"),  # pyright: ignore[reportArgumentType]
        (lambda: SequenceProfile(()), "part is empty"),
        (lambda: SequenceProfile((SineProfile(1.0, 1.0),)), "has no end"),  # pyright: ignore[reportArgumentType]
        (lambda: SequenceProfile((TRAPEZOID,), 0), "repeats is 0"),
        (lambda: SumLoad(()), "part is empty"),
        (lambda: Scenario(1.0, 1.0, 1.0, samples=1), "samples is 1"),
    ],
)
@pytest.mark.usefixtures("unchecked")
def test_what_makes_no_sense_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_file_whose_table_begins_before_0_is_refused():
    text = """
[scenario]
load = "1 kN"
duration = "1 s"

[scenario.speed]
kind = "table"
times = ["-0.5 s", "1 s"]
values = ["0 rpm", "60 rpm"]
"""
    with pytest.raises(prsm.FileError, match=r'number 1 of the array, "-0\.5 s": must be 0'):
        prsm.loads(prsm.file.example_text("wu2022") + text)


def test_times_of_a_table_may_be_traced():
    """∫₀¹ of a line from 0 to 2 over (0, T) is 1/T for T above 1, with the derivative −1/T²."""

    def angle(end):
        times = jnp.stack([jnp.zeros_like(end), end])
        return TableProfile(times, array([0.0, 2.0])).angle(array(1.0))

    value, slope = jax.jit(jax.value_and_grad(angle))(array(4.0))
    assert float(value) == pytest.approx(1 / 4, rel=1e-15)
    assert float(slope) == pytest.approx(-1 / 16, rel=1e-14)


@pytest.mark.parametrize("share", np.linspace(0.9, 1.1, 7))
def test_a_stretch_begins_exactly_where_the_one_before_ends(share):
    """Lengths whose running sums round: at no end of a stretch is there a gap between two."""
    move = SCurveMoveProfile(6 * np.pi * share, 50 * np.pi, 3000.0, 1e5, 0.3)
    ends = move.break_times[:-2]
    there = jax.vmap(move)(ends)
    after = jax.vmap(move)(ends + 1e-9)
    # Within the nanosecond the speed changes by the acceleration limit at most.
    assert float(jnp.abs(there - after).max()) <= 3000.0 * 1e-9 * (1 + 1e-6)
    held = SequenceProfile([ConstantProfile(5.0, 0.1 * share)], repeats=12)
    starts = jnp.arange(1.0, 12.0) * held.part[0].duration
    np.testing.assert_array_equal(jax.vmap(held)(starts), 5.0)


def _nested(levels, repeats=1, reversing=False):
    profile = SequenceProfile((ConstantProfile(3.0, 0.5), TRAPEZOID), repeats, reversing)
    for _ in range(levels - 1):
        profile = SequenceProfile((profile, ConstantProfile(2.0, 0.1)), repeats, reversing)
    return profile


def test_nested_sequences_cost_what_their_parts_cost():
    """Operations grow with the levels, not with a power of them (which doubled at every level)."""

    def operations(levels):
        def everything(profile, time):
            return profile(time), profile.angle(time), profile.break_times, profile.duration

        return len(jax.make_jaxpr(everything)(_nested(levels), jnp.asarray(0.3)).eqns)

    four, eight, sixteen = map(operations, (4, 8, 16))
    assert eight - four == pytest.approx((sixteen - eight) / 2, rel=0.05)


def test_nested_sequences_are_what_they_would_be_written_out():
    inner = SequenceProfile((ConstantProfile(3.0, 0.5), TRAPEZOID), 2, True)
    outer = SequenceProfile((inner, ConstantProfile(2.0, 0.1)), 3, True)
    once = [ConstantProfile(3.0, 0.5), TRAPEZOID]
    back = [ConstantProfile(-3.0, 0.5), dataclasses.replace(TRAPEZOID, peak=array(-100.0))]
    there = [*once, *back, ConstantProfile(2.0, 0.1)]
    other = [*back, *once, ConstantProfile(-2.0, 0.1)]
    flat = SequenceProfile((*there, *other, *there))
    # No break falls on one of them, and the last is past the end.
    times = jnp.linspace(0.0, 6.31234, 1001)
    for one, two in ((outer, flat), (outer.angle, flat.angle)):
        got, expected = (np.asarray(jax.jit(jax.vmap(f))(times)) for f in (one, two))
        # Sums of the same terms in another order.
        np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-10)
    assert float(outer.duration) == pytest.approx(float(flat.duration), rel=1e-14)
    found, expected = (np.unique(np.round(p.break_times, 9)) for p in (outer, flat))
    np.testing.assert_allclose(found, expected)


def test_sequences_that_are_too_deep_or_too_long():
    assert _nested(16).duration > 0
    with pytest.raises(ValueError, match="nested 17 levels deep; at most 16"):
        _nested(17)
    with pytest.raises(ValueError, match="run through 10000000 times; at most 1000000"):
        _nested(7, repeats=10)


def test_a_long_table_is_the_same_alone_and_in_a_batch():
    """Past 128 points a time is sought by halving, in a batch by another program."""
    random = np.random.default_rng(14)
    points = np.cumsum(random.uniform(0.1, 1.0, 300))
    values = random.normal(size=300)
    times = np.concatenate([points[[0, 1, 150, 298, 299]], np.linspace(-1.0, points[-1] + 1, 20)])
    profile = TableProfile(points, values, "linear")
    expected = np.interp(times, points, values)
    one = jax.jit(jax.value_and_grad(lambda time: profile(time)))
    alone = np.array([one(array(time)) for time in times])
    batch = np.array(jax.jit(jax.vmap(one))(array(times))).T
    np.testing.assert_allclose(alone[:, 0], expected, rtol=0, atol=1e-13)
    np.testing.assert_allclose(batch, alone, rtol=0, atol=1e-13)
    # And with a table for each of the batch.
    tables = array(np.stack([points, points + 0.01]))
    shifted = jax.vmap(lambda own: TableProfile(own, profile.values, "linear")(array(20.0)))(tables)
    twice = [np.interp(20.0, own, values) for own in np.asarray(tables)]
    np.testing.assert_allclose(shifted, twice, rtol=0, atol=1e-13)
