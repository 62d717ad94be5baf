"""Li et al. 2020 and 2021: efficiencies, carrier ratios, settling times and forces.

The papers print curves; the numbers here are an independently computed reference that lies on
those curves, with the papers' own statements where they make one.
"""

import numpy as np
import pytest
from scenes import array, example, simulate, steady_state

import prsm_jax as prsm
from prsm_jax.dynamics import stage_kinematics

#: 0.5 µs between samples: settling times are then good to 0.1 % after interpolation.
_SCENARIO = {"duration": 1e-3, "samples": 2001}


def _run(name, load):
    return simulate(example(name), prsm.Scenario(array(100.0), array(load), **_SCENARIO))


@pytest.fixture(scope="module")
def li2020():
    return _run("li2020_two_stage", 7000.0)


@pytest.fixture(scope="module")
def li2021():
    return _run("li2021_two_stage", 5000.0)


def test_li_2020_efficiency_and_carrier_ratios():
    """Li et al. 2020, figure 8: efficiency 0.87 in the end, stage 2 slightly faster."""
    steady = steady_state(example("li2020_two_stage"))
    assert steady.valid
    assert steady.efficiency == pytest.approx(0.8708, abs=6e-5)
    np.testing.assert_allclose(steady.carrier_ratio, [0.373694, 0.374538], rtol=0, atol=5.1e-7)


@pytest.mark.parametrize(
    ("name", "value", "efficiency", "half_digit"),
    [("spline.coefficient", 0.2, 0.8640, 5e-5), ("thrust_bearing.coefficient", 0.105, 0.536, 5e-4)],
)
def test_li_2020_friction_studies(name, value, efficiency, half_digit):
    """Li et al. 2020, figures 9 and 10: more friction in spline or thrust bearing."""
    changed = prsm.set_parameter(example("li2020_two_stage"), name, value)
    assert steady_state(changed).efficiency == pytest.approx(efficiency, abs=1.1 * half_digit)


def test_li_2020_transient(li2020):
    """From 0.606 at the start (paper: 0.60) to 0.871 (paper: 0.87), in two steps."""
    assert int(li2020.solver.code) == 0
    assert li2020.efficiency[0] == pytest.approx(0.60624, abs=6e-6)
    steady = steady_state(example("li2020_two_stage"))
    # The slowest carrier is e^-14 away from its end after a millisecond.
    assert li2020.efficiency[-1] == pytest.approx(float(steady.efficiency), abs=2e-6)
    np.testing.assert_allclose(li2020.carrier_ratio[:, -1], steady.carrier_ratio, rtol=2e-6)
    # Two steps: one as each carrier comes up to speed, so its slope peaks twice.
    slope = np.diff(li2020.efficiency)
    peaks = (slope[1:-1] > slope[:-2]) & (slope[1:-1] >= slope[2:]) & (slope[1:-1] > 1e-6)
    assert np.count_nonzero(peaks) == 2
    assert np.all(li2020.carrier_ratio[:, 0] == 0)


def test_li_2020_forces_on_ring_gear_and_carriers(li2020):
    """Figures 6 and 7: the ring gear force falls through zero, then rises to a smaller value.

    Its magnitude is given, so falling through zero shows as a minimum that samples come close to.
    The carriers' force rises quickly and stays.
    """
    for force in np.asarray(li2020.ring_gear_force):
        lowest = int(np.argmin(force))
        assert 0 < lowest < len(force) - 1
        assert force[lowest] < 0.01 * force[0]
        assert np.all(np.diff(force[: lowest - 1]) < 0)
        # It settles from slightly above.
        assert force[lowest:].max() < 1.05 * force[-1]
        assert force[lowest] < force[-1] < 0.4 * force[0]
    for force in np.asarray(li2020.carrier_force):
        assert force[-1] > 1.2 * force[0]


def test_newton_and_lagrange_agree(li2020, li2021):
    """The carrier acceleration of Lagrange's equations satisfies Newton's on every roller.

    Li et al. 2020 and 2021 derive the two forms. Rounding: each moment sums about ten terms.
    """
    for run in (li2020, li2021):
        assert np.max(run.newton_residual) < 1e-14
        assert np.max(run.power_balance_residual) < 1e-12


def _settling_time(run, stage, share):
    """First time after which a carrier stays within a share of its steady ratio [s]."""
    ratio, time = np.asarray(run.carrier_ratio[stage]), np.asarray(run.time)
    steady = steady_state(example("li2021_two_stage")).carrier_ratio[stage]
    distance = np.abs(ratio / float(steady) - 1)
    last = int(np.nonzero(distance > share)[0][-1])
    around = slice(last, last + 2)
    return float(np.interp(-np.log(share), -np.log(distance[around]), time[around]))


def test_li_2021_transient(li2021):
    """Li et al. 2021, figure 4: below 0.45 at the start, nearly 0.80 in the end."""
    assert int(li2021.solver.code) == 0
    assert li2021.efficiency[0] == pytest.approx(0.4417, abs=5.1e-5)
    assert li2021.efficiency[-1] == pytest.approx(0.8060, abs=5.1e-5)
    steady = steady_state(example("li2021_two_stage"))
    assert steady.efficiency == pytest.approx(0.8060, abs=5.1e-5)


def test_li_2021_settling_times(li2021):
    """Paper: carrier 1 after 0.14 ms, carrier 2 after 0.46 ms; it does not say how close.

    Within 0.1 %: 0.134 and 0.39 ms; within 0.01 %, carrier 2: 0.46 ms.
    """
    assert _settling_time(li2021, 0, 1e-3) == pytest.approx(0.134e-3, abs=0.6e-6)
    assert _settling_time(li2021, 1, 1e-3) == pytest.approx(0.39e-3, abs=5e-6)
    assert _settling_time(li2021, 1, 1e-4) == pytest.approx(0.46e-3, abs=6e-6)


def test_li_2021_more_thread_friction():
    """Li et al. 2021, figure 5, μ_SR 0.2: 0.2782 at the start, 0.6541 in the end."""
    changed = prsm.set_parameter(example("li2021_two_stage"), "friction.thread.coefficient", 0.2)
    scenario = prsm.Scenario(array(100.0), array(5000.0), **_SCENARIO)
    run = simulate(changed, scenario)
    assert run.efficiency[0] == pytest.approx(0.2782, abs=5.1e-5)
    assert steady_state(changed).efficiency == pytest.approx(0.6541, abs=5.1e-5)


@pytest.mark.parametrize(
    ("first", "second", "efficiency", "force"),
    [(5, 15, 0.8090, 224.5), (10, 10, 0.8060, 149.6), (15, 5, 0.8087, 74.8)],
)
def test_li_2021_leads_of_the_stages(first, second, efficiency, force):
    """Li et al. 2021, figures 8 to 10: leads [mm] of both stages, their sum kept."""
    changed = prsm.set_parameter(example("li2021_two_stage"), "stage.1.lead", first * 1e-3)
    changed = prsm.set_parameter(changed, "stage.2.lead", second * 1e-3)
    steady = steady_state(changed)
    assert steady.efficiency == pytest.approx(efficiency, abs=5.1e-5)
    assert steady.spline_friction[0] == 0
    assert steady.spline_friction[1] == pytest.approx(force, abs=0.051)


def test_single_stage_with_viscous_friction():
    """Li et al. 2020, section 3.1: 25 N·s/m, 1 rad/s, 100 N; the ratio settles at 0.373694."""
    one = example("li2020_single_stage_viscous")
    steady = steady_state(one)
    assert steady.carrier_ratio[0] == pytest.approx(0.373694, abs=5.1e-7)
    run = simulate(one)
    assert int(run.solver.code) == 0
    # Eleven time constants: e^-11 is 1e-5.
    assert run.carrier_ratio[0, -1] == pytest.approx(0.373694, abs=1e-5)
    # Linear, so exponential in time: the ratio of successive distances is one number.
    distance = float(steady.carrier_ratio[0]) - np.asarray(run.carrier_ratio[0, :100])
    decay = distance[1:] / distance[:-1]
    # With the time constant I/(N c |d|²); the solver's 1e-8 over a distance that decays to 1e-3.
    stage, step = one.stages[0], float(run.time[1])
    drive = np.asarray(stage_kinematics(stage).drive)
    constant = 2 * 2.95e-6 + 7 * (0.077e-6 * 4**2 + 0.014 * 13e-3**2)
    constant = constant / (7 * 25.0 * drive @ drive)
    np.testing.assert_allclose(decay, np.exp(-step / constant), rtol=1e-4)


def test_wu_2022_geometry_carrier_ratio():
    """r_s 12, r_R 4, n 5, L 10 mm: ζ = 0.374132; independently computed reference."""
    steady = steady_state(example("wu2022"))
    assert steady.carrier_ratio[0] == pytest.approx(0.374132, abs=5.1e-7)
