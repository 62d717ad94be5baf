"""Numbers that a single fault could change unseen: each has a test that sees it.

Found by putting one fault at a time into the package and running the tests.
"""

import dataclasses
from types import SimpleNamespace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scenes
from scenes import array, mechanism, stage, thread
from scipy.integrate import dblquad
from sharing_scenes import chains, load_distribution, sharing_stage

import prsm_jax as prsm
from prsm_jax import strength
from prsm_jax.contact import HertzContact
from prsm_jax.dynamics import bound_scenario
from prsm_jax.dynamics.friction._contact_losses import rolling_moment
from prsm_jax.dynamics.histories import _transient_result
from prsm_jax.friction import RollingHysteresis
from prsm_jax.geometry import RelativeCurvature, carrier_clearance
from prsm_jax.load_sharing import equilibrium, stage_load_distribution
from prsm_jax.mechanism import (
    AxialPlay,
    Carrier,
    LoadSharing,
    Screw,
    ScrewShaft,
    SplitNut,
    Strength,
    UnequalRoller,
)
from prsm_jax.optimisation._searches import Searches
from prsm_jax.scenario import Scenario
from prsm_jax.vibration.model._energy import kinetic_energies, strain_energies
from tests.present import present

_dynamic = eqx.filter_jit(strength.dynamic_capacity)
_static = eqx.filter_jit(strength.static_capacity)


def _threaded(count, play=None, sharing=None):
    """A stage with estimated capacities; curvatures in closed form, so that nothing has to mesh."""
    data = Strength(permissible_pressure=4.2e9, material_factor=1.0, play=play)
    return stage(
        strength=data, engaged_threads=float(count), load_sharing=sharing, curvature="wu2022"
    )


def test_capacities_grow_with_the_threads_and_a_split_nut_has_half_of_them():
    """L^{-10/9} = n L₁^{-10/9} at n-th parts of the load: C ∝ n^{0.7}; C₀ ∝ n."""
    whole, half, few = _threaded(20), _threaded(10), _threaded(5)
    dynamic = [float(_dynamic(one)) for one in (whole, half, few)]
    np.testing.assert_allclose(dynamic[0] / dynamic[1], 2**0.7, rtol=1e-12)
    static = [float(_static(one)) for one in (whole, half, few)]
    np.testing.assert_allclose(static[0] / static[1], 2.0, rtol=1e-12)
    # Threads of one direction: those of one half, or of the smaller half. The same nut cut in two.
    split = _threaded(20, AxialPlay(preload_force=3e3, arrangement="split_nut"))
    np.testing.assert_allclose(float(_dynamic(split)), dynamic[1], rtol=1e-12)
    np.testing.assert_allclose(float(_static(split)), static[1], rtol=1e-12)
    uneven = _threaded(20, sharing=LoadSharing(20, split_nut=SplitNut(5, preload=3e3)))
    np.testing.assert_allclose(float(_dynamic(uneven)), dynamic[2], rtol=1e-12)
    double = _threaded(20, AxialPlay(preload_force=3e3, arrangement="double_nut"))
    np.testing.assert_allclose(float(_dynamic(double)), dynamic[0], rtol=1e-12)


def test_a_history_is_weighted_by_the_trapezoidal_rule():
    """A speed that rises evenly turns by ½ Ω T, exactly; the first and last sample count half."""
    time = jnp.linspace(0.0, 2.0, 11)
    history: Any = SimpleNamespace(time=time, screw_speed=-50.0 * time, load=1e3 + 500.0 * time)
    spectrum = strength.load_spectrum(history)
    np.testing.assert_allclose(jnp.sum(spectrum.turned_angle), 100.0, rtol=1e-14)
    steps = np.array([0.1, *[0.2] * 9, 0.1])
    np.testing.assert_allclose(spectrum.duration, steps, rtol=1e-14)
    np.testing.assert_allclose(spectrum.mean_speed, 50.0, rtol=1e-14)
    # Of the other way round as well: what comes first counts no more than what comes last.
    back: Any = SimpleNamespace(time=time, screw_speed=50.0 * (2 - time), load=1e3 + 500.0 * time)
    np.testing.assert_allclose(jnp.sum(strength.load_spectrum(back).turned_angle), 100.0)


@pytest.mark.parametrize("along", ["major", "minor"])
def test_hysteresis_is_the_moment_of_the_pressure_in_front(along):
    """Johnson 1985, 9.2: the pressure ahead of the middle, ∫ p x dA over half the ellipse."""
    a, b, peak, loss = 3e-4, 1.1e-4, 1.7e9, 0.02
    force = 2 / 3 * np.pi * a * b * peak
    length, other = (a, b) if along == "major" else (b, a)

    def front(y, x):
        return x * peak * np.sqrt(max(1 - (x / length) ** 2 - (y / other) ** 2, 0.0))

    def edge(x):
        return other * np.sqrt(max(1 - (x / length) ** 2, 0.0))

    moment, _ = dblquad(front, 0, length, lambda x: -edge(x), edge)  # pyright: ignore[reportAssignmentType]
    one = array(1.0)
    hertz = HertzContact(array(a), array(b), array(peak), one, one, one, one)
    # The flatter direction, with the smaller coefficient of the gap, is that of the major axis.
    rolling = 50.0 if along == "major" else 150.0
    curvature = RelativeCurvature(array(200.0), array(100.0**2), array(rolling), array(0.0))
    found = rolling_moment(RollingHysteresis(array(loss)), hertz, curvature, array(force))
    # The quadrature itself is good to 1e-8.
    np.testing.assert_allclose(found, loss * moment, rtol=1e-6)


def test_the_balance_of_moments_is_relative_to_force_times_radius(monkeypatch):
    """A hundredth of the contact force at the roller's radius is reported as a hundredth."""
    original = _transient_result.roller_support_forces

    def disturbed(part, geometry, state, acceleration):
        found = original(part, geometry, state, acceleration)
        arm = part.thread.roller_radius
        return eqx.tree_at(
            lambda f: f.moment_residual, found, 0.01 * state.forces.contact_force * arm
        )

    monkeypatch.setattr(_transient_result, "roller_support_forces", disturbed)
    scenario = Scenario(100.0, 7000.0, 1e-3, samples=3)
    run = eqx.filter_jit(lambda m: prsm.simulate(m, scenario, method="closed_form"))(mechanism())
    np.testing.assert_allclose(run.newton_residual, 0.01, rtol=1e-12)


class _Spring(eqx.Module):
    """A load that grows with the position of the nut."""

    stiffness: jax.Array

    def __call__(self, time, position, speed, acceleration):
        return self.stiffness * position + 3.0 * speed + 0.0 * (time + acceleration)


def test_a_load_of_the_motion_starts_where_the_nut_starts():
    """x = x₀ + L Ω t / 2π; the load is that of the position, at the start and later."""
    start, speed, lead = 0.013, 100.0, 10e-3
    travel = lead / (2 * np.pi)
    scenario = Scenario(speed, _Spring(array(2e5)), 0.5, initial_position=start, samples=5)
    bound: Any = bound_scenario(mechanism(), scenario)
    for time in (0.0, 0.2, 0.5):
        position = start + travel * speed * time
        np.testing.assert_allclose(bound.load.position(array(time)), position, rtol=1e-14)
        expected = 2e5 * position + 3.0 * travel * speed
        np.testing.assert_allclose(bound.load_at(array(time)), expected, rtol=1e-14)


def test_clearance_of_the_carrier():
    """a − r_s − w/2 − addendum = 16 − 12 − 1.5 − 0.4 mm, each of them where it is given."""
    bare = thread(roller_radius=4e-3)
    crested = dataclasses.replace(bare, screw_addendum=array(0.4e-3))
    wide = Carrier(inertia=1e-5, radial_width=3e-3)
    for geometry, carrier, expected in (
        (bare, Carrier(inertia=1e-5), 4e-3),
        (bare, wide, 2.5e-3),
        (crested, wide, 2.1e-3),
        (crested, None, 3.6e-3),
    ):
        one = stage(geometry=geometry, carrier=carrier)
        np.testing.assert_allclose(carrier_clearance(one), expected, rtol=1e-12)


def test_load_sharing_says_when_it_has_no_balance():
    """Out of steps, not finite, or held by the film alone: none of them has converged."""
    bare = chains()
    good = equilibrium(bare, array(1200.0))
    assert bool(good.converged)
    short = equilibrium(bare, array(1200.0), max_steps=1)
    assert (int(short.result), bool(short.converged)) == (1, False)
    wrong = equilibrium(bare, array(np.nan))
    assert (int(wrong.result), bool(wrong.converged)) == (2, False)


def test_a_distribution_does_not_converge_without_a_meshing():
    """A flank so round that screw and roller have no common normal; and a search that gave up."""
    geometry = thread(lead=20e-3, roller_profile_radius=0.3)
    assert not bool(scenes.mesh(geometry).converged)
    one = dataclasses.replace(sharing_stage(), thread=geometry, curvature="exact")
    assert not bool(load_distribution(mechanism(one), array(1200.0)).converged)
    # Numbers that are finite are not enough.
    sound = dataclasses.replace(sharing_stage(), curvature="exact")
    meshing = scenes.mesh(sound.thread)
    program = eqx.filter_jit(stage_load_distribution)
    for converged in (True, False):
        given = dataclasses.replace(meshing, converged=jnp.asarray(converged))
        assert bool(program(sound, array(1200.0), given).converged) == converged


@pytest.mark.parametrize("load", [900.0, -900.0, 4000.0])
def test_force_in_the_spacer_balances_the_half_that_it_holds(load):
    """Free body of the half beyond the spacer: its threads against the spacer, nothing else."""
    one = mechanism(sharing_stage(split_nut=SplitNut(10, preload=3e3)))
    found = load_distribution(one, array(load))
    assert bool(found.converged)
    nut = found.nut
    net = np.asarray(nut.weight) @ (np.asarray(nut.forward) - np.asarray(nut.reverse))
    near, far = net[:10].sum(), net[10:].sum()
    np.testing.assert_allclose(near + far, load, rtol=1e-9)
    np.testing.assert_allclose(float(present(found.spacer_force)), -far, rtol=1e-9)


def _findings(load, speed):
    shaft = ScrewShaft("fixed_supported", unsupported_length=1.0, root_radius=10e-3)
    one = stage(
        strength=Strength(shaft=shaft), screw=Screw(mass=1.0, inertia=1.0), curvature="wu2022"
    )
    found = prsm.check(mechanism(one, load=load, speed=speed))
    return {f.name: f.severity for f in found if f.name in ("buckling", "screw_speed")}


def test_thresholds_of_buckling_and_of_whirling():
    """Euler and the beam on its supports, by hand: just inside and just outside of each limit."""
    modulus, density, radius = 210e9, 7850.0, 10e-3
    inertia, area = np.pi * radius**4 / 4, np.pi * radius**2
    # Fixed and supported: 0.6992 of the length buckles; the first mode has k l = 3.9266.
    buckling = np.pi**2 * modulus * inertia / 0.699156**2
    critical = 3.926602**2 * np.sqrt(modulus * inertia / (density * area))
    slow, light = 0.5 * critical, 0.1 * buckling
    for share, severity in ((0.99, None), (1.01, "warning")):
        expected = {} if severity is None else {"buckling": severity}
        assert _findings(share * buckling / 2, slow) == expected
        expected = {} if severity is None else {"screw_speed": severity}
        assert _findings(light, share * 0.8 * critical) == expected
    for share, severity in ((0.99, "warning"), (1.01, "error")):
        assert _findings(share * buckling, slow) == {"buckling": severity}
        assert _findings(light, share * critical) == {"screw_speed": severity}


@pytest.mark.parametrize("unequal", [False, True])
def test_energies_of_a_mode_add_up(unequal):
    """Of mass-normalised shapes: the kinetic energies to 1, the strain energies to ω²."""
    one = scenes.example("wu2022")
    if unequal:
        rollers = (UnequalRoller(2, stiffness_factor=array(0.7)),)
        one = eqx.tree_at(lambda m: m.stages[0].unequal_roller, one, rollers)
    modes = scenes.modal(one, shapes=True)
    network, shapes = modes.network, modes.shapes
    kinetic = sum(kinetic_energies(present(network), shapes).values())
    np.testing.assert_allclose(kinetic, 1.0, rtol=1e-9)
    squares = (2 * np.pi * np.asarray(modes.frequencies)) ** 2
    strain = sum(strain_energies(present(network), shapes).values())
    np.testing.assert_allclose(strain, squares, rtol=1e-7, atol=1e-9 * squares.max())
    # Each roller, and each spring, by itself adds up to its kind.
    by_roller = kinetic_energies(present(network), shapes, each_roller=True)
    rollers = sum(v for k, v in by_roller.items() if k.startswith("roller "))
    np.testing.assert_allclose(
        rollers, kinetic_energies(present(network), shapes)["roller"], rtol=1e-12
    )


@pytest.mark.usefixtures("unchecked")
def test_the_best_of_several_runs():
    """Feasible before infeasible, cheaper before dearer, then converged, then the first start."""
    tolerance = 1e-6

    class _Evaluator:
        def violation(self, point):
            return point[1]

        def cost(self, point):
            return point[0]

    evaluator: Any = _Evaluator()
    report: Any = None

    def run(cost, violation=0.0, residual=0.0):
        return (cost, violation), SimpleNamespace(residual=residual)

    def best(*ends):
        searches: Any = Searches(evaluator, report, tolerance, len(ends))
        searches._ends = list(ends)
        searches.runs = [
            SimpleNamespace(end=None if end is None else SimpleNamespace(violation=end[0][1]))
            for end in ends
        ]
        return searches._best()

    assert best(run(3.0), run(1.0), run(2.0)) == 1
    assert best(run(3.0), run(1.0, violation=1e-3), run(2.0)) == 2
    assert best(run(3.0), run(2.0, violation=0.5 * tolerance)) == 1
    assert best(run(1.0, violation=0.3), run(2.0, violation=0.1), None) == 1
    assert best(None, None) == 0
    assert best(None, run(5.0)) == 1
    # As good as each other: the one that converged; if both did, the first.
    assert best(run(1.0, residual=1e-2), run(1.0 + 0.5 * tolerance)) == 1
    assert best(run(1.0 + 0.5 * tolerance), run(1.0)) == 0
    assert best(run(1.0, residual=1e-9), run(1.0, residual=1e-12)) == 0
    # Clearly dearer is not as good, however well it converged.
    assert best(run(1.0, residual=1e-2), run(1.1)) == 0


def test_failures_in_the_last_chunk_which_is_not_full():
    """8 designs by threes: the last two are a chunk that is filled up with copies of the last."""
    base = mechanism(stage(geometry=thread(lead=20e-3)))
    radii = np.array([4e-3, 4.5e-3, 5e-3, 5.5e-3, 6e-3, 4.2e-3, 0.3, 4.4e-3])
    for order in (radii, np.roll(radii, 1)):
        data = prsm.sweep(base, {"roller_profile_radius": order}, ["efficiency"], chunk=3)
        np.testing.assert_array_equal(data.failed, order == 0.3)
        assert data.attrs["failed"] == 1
        np.testing.assert_array_equal(np.isnan(data.efficiency), order == 0.3)
        whole = prsm.sweep(base, {"roller_profile_radius": order}, ["efficiency"])
        np.testing.assert_allclose(data.efficiency, whole.efficiency, rtol=1e-12)


def test_rows_that_differ_have_their_numbers():
    """Values are those given, the difference is relative to what is printed, bounds hold."""
    from prsm_jax.validation import differs

    def row(computed=13.75, evidence=12.47):
        return differs(
            "item", "12.5", computed, "mm", between=(13.6, 13.9), because="a reason",
            evidence=evidence, evidence_between=(12.4, 12.6),
        )  # fmt: skip

    found = row()
    assert (found.published, found.computed, found.unit) == (12.5, 13.75, "mm")
    assert found.relative_difference == pytest.approx(0.1)
    assert (found.verdict, found.note, found.evidence) == ("differs because", "a reason", 12.47)
    for other in (row(13.59), row(13.91), row(evidence=12.39), row(evidence=12.61)):
        assert other.verdict == "not reproduced"
