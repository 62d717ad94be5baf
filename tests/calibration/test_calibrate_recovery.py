"""Recovery of known parameters from data that the model itself generates, with noise."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scenes
from calibration_scenes import (
    LOAD,
    NUT,
    SCREW,
    STRIBECK,
    TRUTH,
    conditions,
    plain,
    stribeck,
    torques,
)
from sharing_scenes import sharing_stage

import prsm_jax as prsm
from prsm_jax.calibration import (
    Measurements,
    Repetitions,
    calibrate,
    calibration_problem,
    repeat_fits,
)
from prsm_jax.calibration._losses import LOSSES, influence
from prsm_jax.calibration._problem import solve_one
from tests.calibration import example_data

PRELOAD, TOOTH = "split_nut.preload", "tooth.effective_length"


def test_a_stribeck_curve_from_torque_against_speed_and_load():
    columns, torque = torques()
    noise = 0.01 * np.random.default_rng(3).normal(size=torque.shape)
    exact = calibrate(stribeck(), {**columns, "drive_torque": torque}, STRIBECK)
    assert exact.converged, str(exact)
    # The search stops at a relative change of 1e-10; the data are exact.
    assert list(exact.values.values()) == pytest.approx(TRUTH, rel=1e-9)
    noisy = calibrate(stribeck(), {**columns, "drive_torque": torque * (1 + noise)}, STRIBECK)
    assert noisy.converged, str(noisy)
    for one, truth in zip(noisy.parameters, TRUTH, strict=True):
        # 4 standard deviations with 15 degrees of freedom: exceeded by chance in 1 of 860 draws;
        # the seed is fixed.
        assert abs(one.value - truth) < 4 * one.standard_deviation
        assert 0 < one.standard_deviation < 0.2 * truth
    assert noisy.undetermined == ()


def test_derivatives_of_the_fit_against_central_differences():
    columns, torque = torques()
    problem = calibration_problem(
        stribeck(), Measurements.from_columns({**columns, "drive_torque": torque}), STRIBECK
    )
    fixed = jnp.zeros(3, bool)
    # Nothing is free, so the derivatives are those at the start.
    solved = solve_one(problem, problem.measured, fixed, problem.start, problem.start)
    computed = eqx.filter_jit(problem.computed)
    for i in range(3):
        step = 1e-5 * problem.magnitude[i] * jnp.eye(3)[i]
        change = computed(problem.start + step) - computed(problem.start - step)
        expected = change / 2e-5 / problem.scale
        # Rounding of 1e-16 over a relative step of 1e-5 is 1e-11, truncation less.
        np.testing.assert_allclose(solved.jacobian[:, i], expected, rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize("loss", ["squared", "huber"])
def test_limits_contain_the_truth_in_95_of_100_repetitions(loss):
    columns = conditions(np.array([5.0, 40.0, 80.0, 120.0, 300.0]), np.array([2e3, 5e3, 8e3]))
    data = Measurements.from_columns({**columns, "own_curve": np.ones(15)})
    # 0.45 % of the largest value, 0.14 · 8.
    deviations = {"own_curve": 0.005}
    problem = calibration_problem(
        stribeck(), data, STRIBECK, loss=loss, standard_deviations=deviations
    )
    found = repeat_fits(problem, TRUTH, 1.0, repetitions=1000, seed=5)
    assert found.converged.all()
    coverage = found.coverage(TRUTH)
    # One standard deviation of the share is 0.7 %.
    assert ((coverage >= 0.93) & (coverage <= 0.97)).all(), coverage
    scatter = found.values.std(axis=0)
    # The scatter of 1,000 repetitions has a standard deviation of 2.2 %; three of them.
    assert found.standard_deviations.mean(axis=0) == pytest.approx(scatter, rel=0.07)


def test_limits_of_a_curve_from_torques_contain_the_truth():
    """The whole chain: drive torque at 7 speeds and 3 loads, with noise of 0.05 N·m.

    The torques are 3.6 to 19 N·m; most of their fall is between 20 and 120 rad/s.
    """
    speeds, loads = np.array([2.0, 20.0, 40.0, 60.0, 80.0, 120.0, 300.0]), np.array([2e3, 5e3, 9e3])
    data = Measurements.from_columns({**conditions(speeds, loads), "drive_torque": np.ones(21)})
    problem = calibration_problem(
        stribeck(), data, STRIBECK, standard_deviations={"drive_torque": 0.05}
    )
    found = repeat_fits(problem, TRUTH, 1.0, repetitions=1000, seed=6)
    assert found.converged.all()
    coverage = found.coverage(TRUTH)
    # One standard deviation of the share is 0.7 %.
    assert ((coverage >= 0.93) & (coverage <= 0.97)).all(), coverage
    scatter = found.values.std(axis=0)
    # Three standard deviations of 2.2 %, and the mean of s is 1.4 % below σ at 18 degrees of
    # freedom.
    assert found.standard_deviations.mean(axis=0) == pytest.approx(scatter, rel=0.08)


@pytest.mark.parametrize("loss", LOSSES)
def test_a_search_that_ends_in_rounding_has_converged(loss):
    """At the optimum the decrease of the sum of losses is less than its rounding."""
    load = np.linspace(1e3, 9e3, 21)
    data = Measurements.from_columns({LOAD: load, "own_curve": np.ones(21)})
    problem = calibration_problem(
        stribeck(), data, [STRIBECK[0]], standard_deviations={"own_curve": 0.005}, loss=loss
    )
    arrays, static = eqx.partition(problem, eqx.is_array)

    def solve(arrays, measured):
        one = eqx.combine(arrays, static)
        return jax.vmap(lambda data: one.solve(data, jnp.ones(1, bool), one.start, one.start))(
            measured
        )

    # The settings that users have. Those of the tests compile each operation alone, and the same
    # value then always gives the same sum.
    settings = {"xla_backend_optimization_level": 2, "xla_cpu_use_fusion_emitters": True}
    program = jax.jit(solve, compiler_options=settings)
    computed = jax.jit(jax.vmap(lambda values: problem.computed(values)))
    true = np.asarray(computed(jnp.array([[TRUTH[0]]])))[0]
    measured = true + np.random.default_rng(0).normal(0, 0.005, (100, 21))
    solved = program(arrays, jnp.asarray(measured))
    assert solved.converged.all(), np.flatnonzero(~np.asarray(solved.converged))
    # The search itself ends, after the refused steps that show that no further one helps.
    assert int(solved.steps.max()) < 60
    # Newton's step that is left, from derivatives of the losses in closed form and of the torques
    # by central differences, in standard deviations of the fitted value.
    step = 1e-5
    before, at, after = (np.asarray(computed(solved.values + k * step)) for k in (-1, 0, 1))
    slope = (after - before) / (2 * step) / 0.005
    first, _ = influence((measured - at) / 0.005, loss)
    left = np.sum(first * slope, axis=1) / np.linalg.norm(slope, axis=1)
    assert np.abs(left).max() < 1e-4


def test_coverage_counts_what_lies_within():
    data = Measurements.from_columns({LOAD: np.linspace(1e3, 9e3, 6), "own_straight": np.ones(6)})
    problem = calibration_problem(plain(), data, [SCREW, NUT])
    found = repeat_fits(problem, [1.5, 2.5], 0.01, repetitions=20)
    assert found.coverage([1.5, 99.0])[1] == 0.0
    assert found.coverage([1.5, 2.5])[0] > 0.6
    with pytest.raises(ValueError, match="give one number for each of"):
        repeat_fits(problem, [1.5], 0.01)


def test_repeated_fits_want_the_number_of_each_mode():
    """Frequencies of the modes 4, 7, 10 and 13: without their numbers all counted as mode 1."""
    name, modes = "natural_frequencies", (4, 7, 10, 13)
    true = np.asarray(prsm.compute(plain(), [name])[name])
    parameter = "stage.screw.support.radial_stiffness"
    together = Measurements.from_columns({name: true[[one - 1 for one in modes]]})
    problem = calibration_problem(plain(), together, [parameter])
    words = rf"{name} has {true.size} components, .* from {name}\[1\] to {name}\[{true.size}\]"
    with pytest.raises(ValueError, match=words):
        repeat_fits(problem, problem.start, 1e-6, repetitions=2)
    # With a number for each, every row is computed as its own mode.
    columns = {f"{name}[{one}]": true[[one - 1]] for one in modes}
    problem = calibration_problem(plain(), Measurements.from_columns(columns), [parameter])
    computed = problem.computed(problem.start)
    np.testing.assert_allclose(computed, true[[one - 1 for one in modes]], rtol=1e-12)


def test_conditions_are_set_in_their_order():
    """v = ω n p / 2π: the pitch after the number of starts, although p comes before s."""
    starts, pitch = np.array([5.0, 6.0, 7.0]), np.array([2e-3, 2e-3, 3e-3])
    columns = {"starts": starts, "pitch": pitch, "nut_speed": np.ones(3)}
    problem = calibration_problem(plain(), Measurements.from_columns(columns), [SCREW])
    turns = float(plain().operating_point.speed) / (2 * np.pi)
    computed = problem.computed(problem.start)
    np.testing.assert_allclose(computed, turns * starts * pitch, rtol=1e-13)


def test_coverage_is_that_of_the_fits_that_converged():
    nan = np.nan
    lower, upper = np.array([[1.0, 0.0], [nan, nan], [2.5, 0.0]]), np.array([[3.0] * 2] * 3)
    upper[1] = nan
    converged = np.array([True, False, True])
    found = Repetitions(("a", "b"), lower, lower, lower, upper, converged)
    assert found.coverage([2.0, 1.0]).tolist() == [0.5, 1.0]
    none = Repetitions(("a", "b"), lower, lower, lower, upper, np.zeros(3, bool))
    assert np.isnan(none.coverage([2.0, 1.0])).all()


def test_preload_and_tooth_stiffness_from_a_force_deflection_curve():
    """The shipped curve: above about 12 kN a half of the nut is free, which tells both apart."""
    mechanism = prsm.load("actuator_load_sharing")
    fit = calibrate(mechanism, "actuator_deflection", [PRELOAD, TOOTH])
    assert fit.converged, str(fit)
    truth = (example_data.PRELOAD, example_data.TOOTH_LENGTH)
    for one, value in zip(fit.parameters, truth, strict=True):
        # 95 % limits; the seed is fixed.
        assert one.lower < value < one.upper
        assert one.standard_deviation < 0.02 * value
    assert fit.undetermined == ()
    # The scatter of 20 values around 0.05 µm: three standard deviations of 16 %.
    assert fit.residuals[0].rms == pytest.approx(example_data.DEFLECTION_NOISE, rel=0.5)


def test_one_curve_does_not_tell_the_modulus_from_the_teeth():
    """Without preload both only make the nut stiffer: the combination is named."""
    mechanism = scenes.mechanism(sharing_stage())
    load = 1e3 * np.array([-8.0, -6.0, -4.0, -2.0, 2.0, 4.0, 6.0, 8.0])
    deflection = jax.vmap(lambda one: prsm.compute(mechanism, ["axial_deflection"], load=one))(
        load
    )["axial_deflection"]
    noise = example_data.DEFLECTION_NOISE * np.random.default_rng(2022).normal(size=load.size)
    columns = {LOAD: load, "axial_deflection": np.asarray(deflection) + noise}
    names = ["material.youngs_modulus", TOOTH]
    bounds = {names[0]: (100e9, 400e9), TOOTH: (0.1e-3, 2e-3)}
    fit = calibrate(mechanism, columns, names, bounds=bounds, undetermined_limit=0.1)
    assert fit.converged, str(fit)
    (left_open,) = fit.undetermined
    assert left_open.parameters == tuple(names)
    # A higher modulus and shorter teeth give the same curve.
    assert left_open.changes[0] * left_open.changes[1] < 0
    assert left_open.sentence in str(fit)


def test_a_support_from_frequencies_that_are_paired_with_modes():
    name, mass = "stage.nut.support.torsional_stiffness", "stage.nut.inertia"
    truth = prsm.set_parameter(plain(), name, 2.5e7)
    truth = prsm.set_parameter(truth, mass, 6e-4)
    computed = np.asarray(prsm.compute(truth, ["torsional_frequencies"])["torsional_frequencies"])
    # Measured in no order, the highest not at all.
    order = np.random.default_rng(0).permutation(len(computed) - 1)
    data = {"torsional_frequencies": computed[order] * (1 + 1e-5)}
    fit = calibrate(plain(), data, [name, mass])
    assert fit.converged, str(fit)
    assert fit.values[name] == pytest.approx(2.5e7, rel=1e-3)
    assert fit.values[mass] == pytest.approx(6e-4, rel=1e-3)
    assert fit.residuals[0].labels == tuple(f"torsional_frequencies[{i + 1}]" for i in order)


def test_repeated_measurements_of_frequencies_have_a_column_for_each_mode():
    """In one column they are too many for the modes; the message names what to write."""
    mechanism = plain()
    (computed,) = prsm.compute(mechanism, ["torsional_frequencies"]).values()
    repeats = np.asarray(computed) * np.array([[0.999], [1.0], [1.001]])
    with pytest.raises(ValueError, match=r"12 values of .* has 4; remove") as caught:
        calibrate(mechanism, {"torsional_frequencies": repeats.ravel()}, [SCREW])
    assert str(caught.value).endswith("in a column per mode, such as torsional_frequencies[2]")
    columns = {f"torsional_frequencies[{i + 1}]": repeats[:, i] for i in range(4)}
    fit = calibrate(mechanism, columns, [SCREW])
    assert fit.converged, fit.message
    assert sorted(fit.residuals[0].labels) == sorted([*columns] * 3)


def test_a_numbered_frequency_keeps_its_mode_beside_unnumbered_ones():
    """Measured above the next mode, so that the other order would be nearer."""
    mechanism = plain()
    (found,) = prsm.compute(mechanism, ["torsional_frequencies"]).values()
    computed = np.asarray(found)
    second, third = computed[1:3]
    name = "torsional_frequencies"
    columns = {
        f"{name}[2]": np.array([third * 1.01, np.nan, np.nan]),
        name: np.array([computed[0], third * 0.99, computed[3]]),
    }
    fit = calibrate(mechanism, columns, [SCREW])
    assert second < 0.9 * third
    pairs = dict(zip(fit.residuals[0].labels, fit.residuals[0].measured, strict=True))
    expected = [computed[0], third * 1.01, third * 0.99, computed[3]]
    assert [float(pairs[f"{name}[{k}]"]) for k in (1, 2, 3, 4)] == pytest.approx(expected)


def test_more_frequencies_than_modes_are_refused():
    with pytest.raises(ValueError, match="99 values of torsional_frequencies were measured"):
        calibrate(plain(), {"torsional_frequencies": np.linspace(1e3, 9e3, 99)}, [SCREW])
