"""Scenes that mean nothing are refused: an error where their numbers are known, else a code."""

import functools
import math
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scenes
from every_number import numbers_of
from scenes import array, example

import prsm_jax as prsm
from benchmarks.method_options import taken
from prsm_jax.dynamics.solvers import METHOD_WORDS
from prsm_jax.halfspace import RESULTS, flank_contact
from prsm_jax.mechanism import DutyCycle, OperatingPoint, Screw, set_parameters
from prsm_jax.quantities import REASONS, compute_coded
from prsm_jax.scenario import Scenario, TorqueScenario

_BAD_DURATIONS = (-1.0, 0.0, math.nan, math.inf)
_NOT_FINITE = (math.nan, math.inf, -math.inf)


@pytest.mark.parametrize("duration", _BAD_DURATIONS)
@pytest.mark.parametrize("scenario", [Scenario, TorqueScenario])
def test_a_duration_that_is_none_is_refused(scenario, duration):
    with pytest.raises(ValueError, match=r"Scenario: duration is .*; it must be"):
        scenario(100.0, 7e3, duration)
    # As `jax.tree` and `eqx.tree_at` set it: past the construction, but not past `simulate`.
    past = eqx.tree_at(lambda s: s.duration, scenario(100.0, 7e3, 1e-3), array(duration))
    methods: tuple[Any, ...] = METHOD_WORDS
    for method in methods:
        with pytest.raises(ValueError, match=r"Scenario: duration is .*; it must be"):
            prsm.simulate(scenes.mechanism(), past, method=method)


@pytest.mark.parametrize("method", METHOD_WORDS)
def test_a_speed_without_end_is_refused_by_every_method(method):
    """Set past the construction, and found before anything is integrated."""
    for scenario, what in ((Scenario, "speed"), (TorqueScenario, "torque")):
        past = eqx.tree_at(lambda s, n=what: getattr(s, n), scenario(1.0, 7e3, 1e-3), array(np.inf))
        with pytest.raises(ValueError, match=rf"Scenario: {what} is inf"):
            prsm.simulate(scenes.mechanism(), past, method=method)


@pytest.mark.parametrize("value", _NOT_FINITE)
def test_a_speed_or_load_that_is_not_finite_is_refused(value):
    with pytest.raises(
        ValueError,
        match=r"Scenario: speed is .*finite; give the speed of the body that turns in rad/s",
    ):
        Scenario(value, 7e3, 1e-3)
    with pytest.raises(
        ValueError, match=r"Scenario: load is .*finite; give the load on the last nut"
    ):
        Scenario(100.0, value, 1e-3)
    with pytest.raises(ValueError, match=r"TorqueScenario: torque is .*finite"):
        TorqueScenario(value, 7e3, 1e-3)
    with pytest.raises(ValueError, match=r"DutyCycle: load is .*finite"):
        DutyCycle([1.0, 1.0], [1.0, 1.0], [1e3, value])
    if not math.isnan(value):
        with pytest.raises(ValueError, match=r"OperatingPoint: speed is .*finite"):
            OperatingPoint(value, 7e3)


def test_an_operating_point_without_time_is_refused():
    with pytest.raises(
        ValueError, match=r"OperatingPoint: duration is -1 s; it must be more than 0"
    ):
        OperatingPoint(100.0, 7e3, -1.0)
    with pytest.raises(ValueError, match=r"DutyCycle: duration is -1 s; it must be more than 0"):
        DutyCycle([1.0, -1.0], [1.0, 1.0], [1e3, 1e3])


@eqx.filter_jit
def _codes(mechanism, speeds, loads, durations, method):
    """Codes and largest efficiencies of many scenes in one program, which knows no number."""

    def one(speed, load, duration):
        run = prsm.simulate(
            mechanism,
            Scenario(speed, load, duration),
            method=method,
            throw=False,
            **taken(method, max_steps=256),
        )
        return run.solver.code, run.efficiency

    return jax.vmap(one)(speeds, loads, durations)


_METHODS = ["closed_form", "quasi_steady", "rosenbrock"]


@pytest.mark.parametrize(
    "method",
    [*_METHODS, "explicit", "implicit"],
)
def test_in_a_trace_every_method_gives_them_a_code(method):
    mechanism = scenes.mechanism()
    scenes_of = [(100.0, 7e3, 2e-3)]
    scenes_of += [(100.0, 7e3, duration) for duration in _BAD_DURATIONS]
    scenes_of += [(value, 7e3, 2e-3) for value in _NOT_FINITE]
    scenes_of += [(100.0, value, 2e-3) for value in _NOT_FINITE]
    columns = [array(column) for column in zip(*scenes_of, strict=True)]
    codes, efficiency = _codes(mechanism, *columns, method=method)
    words = [
        eqx.tree_at(lambda r: r.code, _REPORT, code).result.partition(":")[0] for code in codes
    ]
    impossible = ["impossible duration"] * 4
    assert words == ["successful", *impossible, *["not finite"] * 6]
    # The good one beside them is what it is by itself.
    alone = _codes(mechanism, *(column[:1].repeat(11) for column in columns), method=method)[1]
    assert jnp.allclose(efficiency[0], alone[0], rtol=1e-12, atol=0)


_REPORT = prsm.dynamics.SolverReport(jnp.asarray(0), jnp.asarray(0), jnp.asarray(0), "none")


def test_a_method_that_gives_up_keeps_its_own_code():
    """Steps that run out leave samples that are not finite; that is not the reason."""
    run = scenes.simulate(
        scenes.mechanism(), Scenario(100.0, 7e3, 2e-3), method="explicit", max_steps=2
    )
    assert not bool(jnp.isfinite(run.efficiency).all())
    assert run.solver.result.startswith("out of steps")


@pytest.mark.parametrize(
    ("moved", "method"), [("load", "rosenbrock"), ("speed", "quasi_steady"), ("load", "auto")]
)
def test_a_function_that_becomes_nan_is_the_reason(moved, method):
    """No number of steps, and no other friction, would help."""
    constant = {"speed": 100.0, "load": 7e3}

    def ends(time):
        return jnp.where(time > 1e-3, jnp.nan, constant[moved])

    driven: dict[str, Any] = constant | {moved: ends}
    scenario = Scenario(**driven, duration=2e-3, samples=5)
    with pytest.raises(prsm.PrsmError, match="has invalid input: not finite"):
        prsm.simulate(scenes.mechanism(), scenario, method=method)


def test_a_half_space_under_a_load_that_no_half_space_bears_says_so():
    stage = example("actuator").stages[0]
    solve = eqx.filter_jit(functools.partial(flank_contact, side="screw", shape=(32, 32)))
    assert int(solve(stage, load=array(1e4)).surface.code) == 0
    crushed = solve(stage, load=array(1e9))
    assert RESULTS[int(crushed.surface.code)].startswith("not a half-space")
    assert not bool(crushed.surface.converged)
    # NaN is another matter.
    assert int(solve(stage, load=array(jnp.nan)).surface.code) == 1


def test_a_bore_wider_than_the_screw_is_refused_wherever_it_comes_from():
    mechanism = example("actuator_load_sharing")
    with pytest.raises(ValueError, match=r"screw.bore_radius is 0.5 m; it must be less than"):
        scenes.stage(screw=Screw(mass=1.0, inertia=1e-4, bore_radius=0.5))
    with pytest.raises(ValueError, match=r"bore_radius is 0.5 m; it must be less than"):
        set_parameters(mechanism, {"screw.bore_radius": 0.5})

    @jax.jit
    def traced(bore):
        wide = eqx.tree_at(lambda m: m.stages[0].screw.bore_radius, mechanism, bore)
        return compute_coded(wide, ["max_pressure"])[1]

    assert REASONS[int(traced(array(0.5)))] == "impossible_dimension"
    assert REASONS[int(traced(array(jnp.nan)))] == "impossible_dimension"
    assert int(traced(mechanism.stages[0].screw.bore_radius)) == 0
    wide = eqx.tree_at(lambda m: m.stages[0].screw.bore_radius, mechanism, array(0.5))
    found = [f for f in prsm.check(wide) if f.name == "bore"]
    assert [f.severity for f in found] == ["error"]
    assert "stage.screw.bore_radius is 500 mm" in found[0].message


_PROFILE = prsm.scenario.TrapezoidalProfile(100.0, 1e-2, 2e-2, dwell_time=1e-2)


@pytest.mark.parametrize(
    ("scenario", "method"),
    [
        (Scenario(_PROFILE, 7e3, 5e-2, samples=21), "quasi_steady"),
        (Scenario(100.0, 7e3, 2e-3, samples=5), "closed_form"),
        (TorqueScenario(16.0, 7e3, 2e-3, samples=5, most_phases=4), "quasi_steady"),
    ],
)
def test_nan_in_any_number_of_a_scene_is_told(scenario, method):
    """What moves with a number is NaN, or the code says so, where that number is NaN."""
    mechanism = scenes.mechanism()
    names, values, build = numbers_of((mechanism, scenario))
    options = {"max_steps": 256} if isinstance(scenario, TorqueScenario) else {}

    def follow(numbers):
        run = prsm.simulate(*build(numbers), method=method, throw=False, **options)
        rows = [run.efficiency, run.drive_torque, run.carrier_force, run.ring_gear_force]
        rows += [run.screw_speed, run.carrier_ratio, run.screw_roller_axial_force]
        return jnp.concatenate([jnp.ravel(row) for row in rows]), run.solver.code

    def with_each(changed):
        rows = np.repeat(values[None], len(values), axis=0)
        np.fill_diagonal(rows, changed)
        return rows

    nudged = with_each(np.where(values == 0, 1e-7, values * (1 + 1e-4)))
    rows = np.concatenate([values[None], nudged, with_each(np.nan)])
    found, codes = (np.asarray(x) for x in jax.jit(jax.vmap(follow))(rows))
    base, nudged, bad = found[0], found[1 : 1 + len(values)], found[1 + len(values) :]
    assert codes[0] == 0
    assert np.isfinite(base).all()
    depends = (np.abs(nudged - base) > 1e-12 * np.abs(base)).any(axis=1)
    assert depends.mean() > 0.3
    told = codes[1 + len(values) :] != 0
    silent = [name for name, d, t in zip(names, depends, told, strict=True) if d and not t]
    assert not silent
    # A number that does not matter leaves everything as it was.
    for row, d, t in zip(bad, depends, told, strict=True):
        if not d and not t:
            np.testing.assert_allclose(row, base, rtol=1e-12)
