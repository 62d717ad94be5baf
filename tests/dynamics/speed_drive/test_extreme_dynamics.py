"""Scenes at the edges of what is asked for, against a reference of their own.

The reference is the same physics written once more in NumPy, for one instant and nothing else, and
integrated by SciPy: DOP853 at a tolerance of 1e-12, Radau at 1e-9 where the scene is stiff.
Only the geometry of the contacts is taken from the package.
"""

import dataclasses
import functools
import itertools
import time

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scenes
from scenes import array, example, simulate
from scipy.integrate import solve_ivp

import prsm_jax as prsm
from prsm_jax.dynamics import choose_method, stage_kinematics
from prsm_jax.scenario import SequenceProfile, TrapezoidalProfile
from tests.present import present

#: Any method that integrates, whatever the scene.
INTEGRATORS = ("implicit", "rosenbrock")
#: And at constant speed and load the closed form, which `auto` chooses.
METHODS = (*INTEGRATORS, "auto")
#: Largest error of a carrier ratio, over that of steady turning. Steps are held to 1e-8, samples
#: between them are interpolated. The closed form is exact, and what is left is the reference's.
BOUND = {"implicit": 2e-6, "rosenbrock": 1e-6, "auto": 1e-8}

_kinematics = eqx.filter_jit(stage_kinematics)


class Reference:
    """Carriers under Coulomb friction, in NumPy."""

    def __init__(self, mechanism, speed, load, rate=lambda t: 0.0):
        self.speed, self.load, self.rate = speed, load, rate
        self.stages = []
        travel = 0.0
        for stage in mechanism.stages:
            thread, geometry, friction = stage.thread, _kinematics(stage), stage.friction
            side, count = geometry.meshing.screw, stage.roller_count
            starts, distance = float(thread.starts), float(thread.centre_distance)
            carriers = 0.0 if stage.carrier.mass is None else 2 * float(stage.carrier.mass)
            before, travel = travel, travel + float(thread.lead) / (2 * np.pi)
            angle = float(side.contact_angle_position)
            spline, bearing = friction.spline, friction.thrust_bearing
            self.stages.append(
                {
                    "count": count,
                    "mu": float(friction.thread.coefficient),
                    "normal": np.asarray(side.normal),
                    "per_screw": np.asarray(geometry.slip_per_screw),
                    "drive": np.asarray(geometry.drive),
                    "arm": float(side.contact_radius) * np.array([-np.sin(angle), np.cos(angle)]),
                    "inertia": 2 * float(stage.carrier.inertia)
                    + count * float(stage.roller.inertia) * (starts - 1) ** 2
                    + count * float(stage.roller.mass) * distance**2,
                    "mass": count * float(stage.roller.mass) + float(stage.nut.mass) + carriers,
                    "screw_inertia": float(stage.screw.inertia),
                    "screw_mass": float(stage.screw.mass or 0.0),
                    "spline": float(spline.coefficient / spline.radius) if spline else 0.0,
                    "bearing": float(bearing.coefficient * bearing.radius) if bearing else 0.0,
                    "travel": travel,
                    "travel_before": before,
                }
            )

    def __call__(self, time, carriers):
        speed, rate, axial = self.speed(time), self.rate(time), self.load(time)
        sense, torque, spline = np.sign(speed), 0.0, 0.0
        rates = np.zeros(len(self.stages))
        for k in reversed(range(len(self.stages))):
            s = self.stages[k]
            own = axial + s["mass"] * rate * s["travel"]
            slip = speed * s["per_screw"]
            slip[:2] -= carriers[k] * s["drive"]
            length = np.sqrt(slip @ slip)
            along = slip / length if length else slip
            force = own / s["count"] / (-s["normal"][2] - s["mu"] * along[2])
            on_roller = force * (s["normal"] + s["mu"] * along)
            rates[k] = s["count"] * s["mu"] * force * (along[:2] @ s["drive"]) / s["inertia"]
            torque += s["count"] * (s["arm"] @ on_roller[:2]) + s["screw_inertia"] * rate
            axial = -s["count"] * on_roller[2] - spline
            axial += s["screw_mass"] * rate * s["travel_before"]
            # Spline and bearing wait for each other: the loop contracts by a thousandth.
            alone, pushed = torque, axial
            for _ in range(8):
                torque = alone + s["bearing"] * sense * abs(axial)
                axial = pushed + s["spline"] * sense * abs(torque)
            spline = s["spline"] * sense * abs(torque)
        return rates

    def carrier_ratios(self, times, stiff=False, breaks=(), start=None):
        """Carrier speeds at all times, integrated from break to break."""
        unit = times[-1]
        state = np.zeros(len(self.stages)) if start is None else np.asarray(start)
        found = np.zeros((len(self.stages), len(times)))
        edges = [times[0], *(b for b in breaks if times[0] < b < times[-1]), times[-1]]
        scale = max(abs(self.speed(t)) for t in np.linspace(0, unit, 101))
        for begin, end in itertools.pairwise(edges):
            inside = (times >= begin) & (times <= end)
            # Away from the jump, on the side of the stretch.
            low, high = begin + 1e-12 * unit, end - 1e-12 * unit
            solution = solve_ivp(
                lambda t, y, low=low, high=high: (
                    self(np.clip(t * unit, low, high), y * scale) * unit / scale
                ),
                (begin / unit, end / unit),
                state / scale,
                method="Radau" if stiff else "DOP853",
                rtol=1e-9 if stiff else 1e-12,
                atol=1e-10 if stiff else 1e-13,
                dense_output=True,
            )
            assert solution.success
            if np.any(inside):
                found[:, inside] = solution.sol(times[inside] / unit) * scale
            state = solution.y[:, -1] * scale
        return found


class Swell(eqx.Module):
    """A speed `mean (1 − share cos 2πft)`: for a share of 1 it touches zero."""

    mean: jax.Array
    share: jax.Array
    frequency: jax.Array

    def __call__(self, time):
        return self.mean * (1 - self.share * jnp.cos(2 * jnp.pi * self.frequency * time))


class Pulse(eqx.Module):
    """A load that jumps, and after a while jumps back."""

    base: jax.Array
    height: jax.Array
    start: jax.Array
    width: jax.Array

    def __call__(self, time):
        inside = (time >= self.start) & (time < self.start + self.width)
        return self.base + jnp.where(inside, self.height, 0.0)

    @property
    def break_times(self):
        return jnp.stack([self.start, self.start + self.width])


#: mean speed, share, frequency; load, its jump, when, for how long; duration; stiff.
VARYING = {
    "step of the load": ((100.0, 0.0, 1.0), (100.0, 2e4, 3e-4, 1.0), 1e-3, False),
    "impulse": ((100.0, 0.0, 1.0), (5.0, 1e6, 4.9e-4, 1e-6), 1e-3, False),
    "impulse of a nanosecond": ((100.0, 0.0, 1.0), (5.0, 1e9, 4.9e-4, 1e-9), 1e-3, False),
    "unloaded by a jump": ((100.0, 0.0, 1.0), (2e3, -2e3, 1e-4, 1.0), 1e-3, False),
    # A hundredth of a radian per second where it is slowest: stiff by a factor of 20,000 there.
    "nearly to standstill": ((100.0, 1 - 1e-4, 50.0), (7e3, 0.0, 0.0, 1.0), 0.04, True),
}


@functools.cache
def _varying(name):
    (mean, share, frequency), pulse, duration, stiff = VARYING[name]
    base, height, start, width = pulse
    turn = 2 * np.pi * frequency
    reference = Reference(
        _two(),
        lambda t: mean * (1 - share * np.cos(turn * t)),
        lambda t: base + (height if start <= t < start + width else 0.0),
        lambda t: mean * share * turn * np.sin(turn * t),
    )
    speed = Swell(array(mean), array(share), array(frequency))
    load = Pulse(*map(array, pulse))
    scenario = prsm.Scenario(speed, load, array(duration), samples=81)
    times = np.linspace(0, duration, 81)
    breaks = (start, start + width, *np.arange(1, 3) / frequency)
    return scenario, reference.carrier_ratios(times, stiff, breaks)


@pytest.mark.parametrize("method", INTEGRATORS)
@pytest.mark.parametrize("name", VARYING)
def test_jumps_impulses_and_near_standstill(name, method):
    scenario, expected = _varying(name)
    run = simulate(_two(), scenario, method=method, max_steps=16384)
    error = np.max(np.abs(run.carrier_speed - expected)) / np.max(np.abs(expected))
    assert int(run.solver.code) == 0
    assert error < BOUND[method]
    assert np.max(run.power_balance_residual) < 1e-9
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(run))


def test_a_speed_that_touches_zero():
    """Carriers in balance pass it; an integrator, infinitely stiff there, says that it cannot."""
    _, pulse, duration, _ = VARYING["nearly to standstill"]
    scenarios = [
        prsm.Scenario(
            Swell(array(100.0), array(share), array(50.0)),
            Pulse(*map(array, pulse)),
            array(duration),
            samples=81,
        )
        for share in (1.0, 1 - 1e-9)
    ]
    touching, nearly = scenarios
    assert choose_method(_two(), touching).method == "quasi_steady"
    run = simulate(_two(), touching, method="quasi_steady")
    assert int(run.solver.code) == 0
    assert float(run.screw_speed[0]) == float(run.screw_speed[40]) == 0.0
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(run))
    assert np.max(run.power_balance_residual) < 1e-9
    stuck = simulate(_two(), touching, method="rosenbrock", max_steps=16384)
    assert int(stuck.solver.code) == 1
    integrated = simulate(_two(), nearly, method="rosenbrock", max_steps=16384)
    assert int(integrated.solver.code) == 0
    error = np.max(np.abs(run.carrier_speed - integrated.carrier_speed)) / 200.0
    # The carriers cannot follow the first instants out of standstill.
    assert error < 2 * float(present(run.solver.error_estimate))
    assert float(present(run.solver.error_estimate)) < 5e-4


@pytest.mark.parametrize("method", ["rosenbrock"])
def test_four_stages(method):
    """Two pairs of stages, the load and the torque of each passing through all before it."""
    two = _two()
    four = dataclasses.replace(two, stages=(*two.stages, *two.stages[1:], *two.stages[1:]))
    reference = Reference(four, lambda t: 100.0, lambda t: 7e3)
    times = np.linspace(0, 2e-3, 51)
    run = simulate(
        four, prsm.Scenario(array(100.0), array(7e3), array(2e-3), samples=51), method=method
    )
    assert int(run.solver.code) == 0
    expected = reference.carrier_ratios(times)
    error = np.max(np.abs(run.carrier_speed - expected)) / 37.0
    assert error < BOUND[method]
    assert np.max(run.power_balance_residual) < 1e-9


#: Up, a plateau, down, and a dwell: 0.36 s.
CYCLE = TrapezoidalProfile(200.0, 0.03, 0.24, 0.03, 0.06)


class Moving(eqx.Module):
    """The part of a stroke that moves, forth or back, less its first instant."""

    sign: jax.Array
    late: jax.Array

    def __call__(self, time):
        return self.sign * CYCLE(time + self.late)

    @property
    def break_times(self):
        return CYCLE.break_times - self.late


def test_an_hour_with_ten_thousand_reversals():
    """Every stroke is that which is integrated; the hour takes seconds and little memory."""
    two = _two()
    strokes = SequenceProfile((CYCLE,), repeats=10_000, reversing=True)
    hour = prsm.Scenario(strokes, array(7e3), array(3600.0), samples=120_001)
    simulate(two, hour, method="quasi_steady")
    begin = time.perf_counter()
    run = jax.block_until_ready(simulate(two, hour, method="quasi_steady"))
    elapsed = time.perf_counter() - begin
    size = sum(leaf.nbytes for leaf in jax.tree.leaves(run))
    assert int(run.solver.code) == 0
    # 0.6 s and 35 MB when this was written, on one core.
    assert elapsed < 20
    assert size < 100e6
    assert np.max(run.power_balance_residual) < 1e-9
    speed = np.asarray(run.screw_speed)
    moving = np.sign(speed[np.abs(speed) > 1.0])
    assert np.sum(moving[1:] != moving[:-1]) == 9_999
    # Forth and back, 12 samples each: all five thousand are the same, away from their breaks,
    # which rounding of the time may put on either side of a sample.
    pairs = np.asarray(run.drive_torque)[:-1].reshape(5000, 24)
    plateau = np.r_[2:9, 14:21]
    assert np.ptp(pairs[:, plateau], axis=0) == pytest.approx(0, abs=1e-9)

    for sign, sample in ((1.0, 5), (-1.0, 17)):
        late = array(1e-4)
        stroke = prsm.Scenario(
            Moving(array(sign), late), array(7e3), 0.3 - 2 * late, array(0.3737), samples=121
        )
        exact = simulate(two, stroke, method="rosenbrock", max_steps=16384)
        balanced = simulate(two, stroke, method="quasi_steady")
        assert int(exact.solver.code) == int(balanced.solver.code) == 0
        largest = np.max(np.abs(exact.drive_torque))
        # Past the settling from the initial ratio, and from each bend of the speed.
        since = np.asarray(exact.time) - np.array([[0.0, *stroke.break_times]]).T
        settled = np.all((since < 0) | (since > 2e-3), axis=0)
        error = np.abs(np.asarray(exact.drive_torque - balanced.drive_torque))[settled] / largest
        assert np.sum(settled) > 100
        assert np.max(error) < 1e-4
        on_plateau = float(exact.drive_torque[60])
        assert pairs[0, sample] == pytest.approx(on_plateau, rel=1e-7)


def _two():
    return example("li2020_two_stage")


def _with_friction(one, coefficient):
    return eqx.tree_at(
        lambda m: [s.friction.thread.coefficient for s in m.stages],
        one,
        [array(coefficient)] * len(one.stages),
    )


def _with_inertia(one, *factors):
    """All that the carriers move, stage by stage."""

    def parts(m):
        return [v for s in m.stages for v in (s.roller.mass, s.roller.inertia, s.carrier.inertia)]

    scaled = [
        value * factor for value, factor in zip(parts(one), np.repeat(factors, 3), strict=True)
    ]
    return eqx.tree_at(parts, one, scaled)


def _locking_coefficient(one):
    """Where a normal force no longer lifts anything: steady slip, the steepest one."""
    limits = []
    for stage in one.stages:
        geometry = _kinematics(stage)
        drive, slip = np.asarray(geometry.drive), np.asarray(geometry.slip_per_screw)
        across = slip[:2] - drive * (slip[:2] @ drive) / (drive @ drive)
        steepest = slip[2] / np.sqrt(across @ across + slip[2] ** 2)
        limits.append(-float(geometry.meshing.screw.normal[2]) / steepest)
    return min(limits)


#: Name of a scene: change of the mechanism, speed [rad/s], load [N], whether stiff.
SCENES = {
    "slow": (lambda m: m, 0.01, 7e3, False),
    "fast": (lambda m: m, 1e4, 7e3, False),
    "backward": (lambda m: m, -100.0, 7e3, False),
    "next to no friction": (lambda m: _with_friction(m, 1e-6), 100.0, 7e3, False),
    "half way to locking": (
        lambda m: _with_friction(m, 0.5 * _locking_coefficient(m)),
        100.0,
        7e3,
        False,
    ),
    "about to lock": (
        lambda m: _with_friction(m, 0.999 * _locking_coefficient(m)),
        100.0,
        7e3,
        True,
    ),
    "1 mN": (lambda m: m, 100.0, 1e-3, False),
    "1 MN": (lambda m: m, 100.0, 1e6, False),
    "light": (lambda m: _with_inertia(m, 1e-6, 1e-6), 100.0, 7e3, False),
    "heavy": (lambda m: _with_inertia(m, 1e6, 1e6), 100.0, 7e3, False),
    "light and heavy": (lambda m: _with_inertia(m, 1e-6, 1e6), 100.0, 7e3, True),
}


@functools.cache
def _scene(name):
    """Mechanism, scenario as long as the slowest carrier takes to settle, and the reference."""
    change, speed, load, stiff = SCENES[name]
    one = change(_two())
    reference = Reference(one, lambda t: speed, lambda t: load)
    settling = 0.37 * abs(speed) / np.min(np.abs(reference(0.0, np.zeros(2))))
    scenario = prsm.Scenario(array(speed), array(load), array(3 * settling), samples=51)
    times = np.linspace(0, 3 * settling, 51)
    return one, scenario, reference.carrier_ratios(times, stiff) / speed


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SCENES)
def test_settling(name, method):
    one, scenario, expected = _scene(name)
    run = simulate(one, scenario, method=method)
    assert int(run.solver.code) == 0
    error = np.max(np.abs(run.carrier_ratio - expected)) / np.max(np.abs(expected))
    assert error < BOUND[method]
    assert int(run.solver.steps) < 600
    assert np.max(run.power_balance_residual) < 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_ten_seconds_with_a_transient_of_ten_nanoseconds(method):
    """0.01 rad/s: the carriers settle in a billionth of the scene, in a few hundred steps."""
    one, _, settled = _scene("slow")
    run = simulate(
        one, prsm.Scenario(array(0.01), array(7e3), array(10.0), samples=51), method=method
    )
    assert int(run.solver.code) == 0
    assert int(run.solver.steps) + int(run.solver.rejected) < 600
    assert np.all(run.carrier_ratio[:, 0] == 0)
    ratio = np.asarray(run.carrier_ratio[:, 1:])
    steady = np.asarray(prsm.steady_state(one, array(0.01), array(7e3)).carrier_ratio)
    assert np.max(np.abs(ratio - steady[:, None])) < BOUND[method] * 0.37
    assert np.max(np.abs(settled[:, -1] - steady)) < 0.1


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("coefficient", "load"), [(0.0, 0.0), (0.0, 7e3), (0.05, 0.0)])
def test_nothing_that_drives_the_carriers(coefficient, load, method):
    """Without load or friction they stay as they are, and every number is finite."""
    one = _with_friction(_two(), coefficient)
    scenario = prsm.Scenario(array(100.0), array(load), array(1e-3), array(0.1), samples=51)
    run = simulate(one, scenario, method=method)
    assert int(run.solver.code) == 0
    np.testing.assert_allclose(run.carrier_ratio, 0.1, rtol=1e-12)
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(run))


def test_explicit_steps_of_carriers_at_rest_stay_stable():
    """Settled carriers depend on no friction; through steps that are too long a derivative grows.

    By 4e-6 a unit of the coefficient in 100 time constants, and by ten times that in ten times as
    many, where the exact one is below 1e-20.
    """

    def settled(coefficient):
        one = prsm.set_parameter(
            scenes.mechanism(), "stage.friction.thread.coefficient", coefficient
        )
        scene = prsm.Scenario(100.0, 7e3, 2e-3, samples=5)
        run = prsm.simulate(one, scene, method="explicit", gradient="forward", throw=False)
        return run.carrier_ratio[0, 1:], run.solver.code

    ratios, slopes, code = jax.jvp(settled, (array(0.3),), (array(1.0),), has_aux=True)
    assert int(code) == 0
    np.testing.assert_allclose(ratios, ratios[-1], rtol=1e-9)
    np.testing.assert_allclose(slopes, 0.0, atol=1e-10)
