"""Calibration against closed forms: linear least squares, weights, bounds, losses."""

import json
import re
from typing import Any

import hypothesis
import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.stats
from calibration_scenes import LOAD, NUT, SCREW, plain

import prsm_jax as prsm
from prsm_jax.calibration import Measurements, calibrate, calibration_problem
from prsm_jax.calibration._bounds import from_free, to_free
from prsm_jax.calibration._losses import LOSSES, as_squares, influence
from prsm_jax.calibration._optimum import near_optimum


def _line(noise=0.05, seed=0, screw=1.5, nut=2.5, rows=12):
    load = np.linspace(1e3, 9e3, rows)
    rng = np.random.default_rng(seed)
    return {LOAD: load, "own_straight": screw * load / 1e3 + nut + noise * rng.normal(size=rows)}


def test_a_straight_line_is_that_of_the_normal_equations():
    data = _line()
    fit = calibrate(plain(), data, [SCREW, NUT])
    design = np.stack([data[LOAD] / 1e3, np.ones(12)], axis=1)
    values, (squares,), *_ = np.linalg.lstsq(design, data["own_straight"])
    covariance = squares / 10 * np.linalg.inv(design.T @ design)
    deviations = np.sqrt(np.diag(covariance))
    # The search stops at a relative change of 1e-10.
    assert fit.converged
    assert [one.value for one in fit.parameters] == pytest.approx(values, rel=1e-8)
    assert [one.standard_deviation for one in fit.parameters] == pytest.approx(deviations, rel=1e-7)
    away = scipy.stats.t.ppf(0.975, 10) * deviations
    assert [one.lower for one in fit.parameters] == pytest.approx(values - away, rel=1e-7)
    assert [one.upper for one in fit.parameters] == pytest.approx(values + away, rel=1e-7)
    correlation = covariance[0, 1] / np.prod(deviations)
    assert fit.correlation[0, 1] == pytest.approx(correlation, rel=1e-7)
    assert fit.residuals[0].rms == pytest.approx(np.sqrt(squares / 12), rel=1e-8)
    scale = np.sqrt(np.mean(data["own_straight"] ** 2))
    assert fit.residual_rms == pytest.approx(np.sqrt(squares / 12) / scale, rel=1e-8)
    assert fit.undetermined == ()
    assert float(prsm.get_parameter(fit.mechanism, SCREW)) == fit.values[SCREW]
    json.dumps(fit.to_dict(), allow_nan=False)
    assert "95 % from" in str(fit)


def test_standard_deviations_weight_the_columns():
    data = _line()
    data["own_sum_only"] = 7.0 * data[LOAD] / 1e3 + np.random.default_rng(1).normal(size=12)
    given = {"own_straight": 0.05, "own_sum_only": 1.0}
    fit = calibrate(plain(), data, [SCREW, NUT], standard_deviations=given)
    load = data[LOAD] / 1e3
    design = np.concatenate(
        [np.stack([load, np.ones(12)], 1) / 0.05, np.stack([load, 2 * load], 1) / 1.0]
    )
    right = np.concatenate([data["own_straight"] / 0.05, data["own_sum_only"]])
    assert list(fit.values.values()) == pytest.approx(np.linalg.lstsq(design, right)[0], rel=1e-8)
    assert fit.scales == given


def test_a_value_that_was_not_measured_is_left_out():
    data = _line()
    short = {name: column[1:] for name, column in data.items()}
    data["own_straight"][0] = np.nan
    assert calibrate(plain(), data, [SCREW, NUT]).values == pytest.approx(
        calibrate(plain(), short, [SCREW, NUT]).values, rel=1e-9
    )


def test_on_a_bound_the_other_value_is_that_of_its_own_line():
    data = _line()
    fit = calibrate(plain(), data, [SCREW, NUT], bounds={SCREW: (0.5, 1.2)})
    screw, nut = fit.parameters
    assert (screw.value, screw.active_bound, nut.active_bound) == (1.2, "upper", "")
    assert np.isnan(screw.standard_deviation)
    assert nut.value == pytest.approx(np.mean(data["own_straight"] - 1.2 * data[LOAD] / 1e3))
    assert fit.degrees_of_freedom == 11
    assert fit.converged
    written = fit.to_dict()["parameters"][SCREW]
    assert written["standard_deviation"] is None
    assert written["active_bound"] == "upper"


def test_a_lower_bound_and_a_bound_that_is_near_but_not_active():
    data = _line()
    fit = calibrate(plain(), data, [SCREW, NUT], bounds={SCREW: (1.7, None), NUT: (None, 5.0)})
    assert (fit.parameters[0].value, fit.parameters[0].active_bound) == (1.7, "lower")
    free = calibrate(plain(), data, [SCREW, NUT])
    above = free.values[SCREW] + 1e-3
    near = calibrate(plain(), data, [SCREW, NUT], bounds={SCREW: (0.1, above)})
    assert near.parameters[0].active_bound == ""
    assert list(near.values.values()) == pytest.approx(list(free.values.values()), rel=1e-7)


def test_a_limit_far_from_the_start_is_no_bound():
    """A face width of 10 mm may be at most 100 m: the search has no upper bound, and begins."""
    data = Measurements.from_columns(_line())
    problem = calibration_problem(plain(), data, [SCREW, "gear.face_width"])
    assert float(problem.upper[1]) == np.inf
    assert float(problem.lower[1]) == 0.0
    with pytest.raises(ValueError, match="it must be more than 0 and at most 100 m"):
        calibration_problem(
            plain(), data, [SCREW, "gear.face_width"], bounds={"gear.face_width": (1e-3, 101.0)}
        )


@pytest.mark.parametrize(("loss", "most"), [("huber", 0.05), ("soft_l1", 0.05), ("cauchy", 0.02)])
def test_outliers_move_a_robust_fit_little(loss, most):
    data = _line(noise=0.02, rows=40)
    data["own_straight"][[0, 3, 20]] += [9.0, 7.0, 4.0]
    squared = calibrate(plain(), data, [SCREW, NUT])
    robust = calibrate(plain(), data, [SCREW, NUT], loss=loss)
    assert abs(squared.values[NUT] - 2.5) > 0.2
    assert robust.converged
    assert abs(robust.values[NUT] - 2.5) < most
    assert abs(robust.values[SCREW] - 1.5) < most / 4
    # Its limits are those of the bulk, not of the outliers.
    deviation = squared.parameters[1].standard_deviation
    assert robust.parameters[1].standard_deviation < 0.1 * deviation


def test_a_pair_of_which_only_the_sum_counts_is_named():
    load = np.linspace(1e3, 9e3, 9)
    noise = 0.01 * np.random.default_rng(2).normal(size=9)
    data = {LOAD: load, "own_sum_only": 6.0 * load / 1e3 + noise}
    fit = calibrate(plain(), data, [SCREW, NUT])
    (open_,) = fit.undetermined
    assert open_.parameters == (SCREW, NUT)
    assert f"The data determine {SCREW} + 2 × {NUT}, not each alone" in open_.sentence
    assert fit.values[SCREW] + 2 * fit.values[NUT] == pytest.approx(6.0, abs=0.01)
    assert np.isinf([one.standard_deviation for one in fit.parameters]).all()
    assert fit.to_dict()["parameters"][SCREW]["standard_deviation"] is None
    assert open_.sentence in str(fit)


def test_a_parameter_without_influence_is_named():
    fit = calibrate(plain(), _line(), [SCREW, NUT, "stage.roller.mass"])
    (open_,) = fit.undetermined
    assert open_.sentence == (
        "The data do not determine stage.roller.mass (it has no influence on the measured "
        "quantities)."
    )
    closed = calibrate(plain(), _line(), [SCREW, NUT])
    assert fit.parameters[0].value == pytest.approx(closed.parameters[0].value, rel=1e-7)


@pytest.mark.parametrize("loss", ["squared", "huber"])
def test_a_parameter_without_influence_takes_no_degree_of_freedom(loss):
    """The limits are those of a line through 4 points with 2 degrees of freedom."""
    data = _line(rows=4)
    fit = calibrate(plain(), data, [SCREW, NUT, "stage.roller.mass"], loss=loss)
    closed = calibrate(plain(), data, [SCREW, NUT], loss=loss)
    assert fit.degrees_of_freedom == 2
    for one, other in zip(fit.parameters[:2], closed.parameters, strict=True):
        assert (one.lower, one.upper) == pytest.approx((other.lower, other.upper), rel=1e-6)
    if loss == "squared":
        line: Any = scipy.stats.linregress(data[LOAD] / 1e3, data["own_straight"])
        away = scipy.stats.t.ppf(0.975, 2) * line.stderr
        limits = (line.slope - away, line.slope + away)
        assert (fit.parameters[0].lower, fit.parameters[0].upper) == pytest.approx(limits, rel=1e-6)


@pytest.mark.parametrize("noise", [0.0, 1e-17])
def test_a_column_of_rounding_errors_is_no_direction_of_a_fit(noise):
    """A line through points at its optimum, beside a number without influence."""
    rng = np.random.default_rng(3)
    line, values = rng.normal(size=(2, 12))
    residuals = values - line * (line @ values) / (line @ line)
    columns = np.stack([line, noise * rng.normal(size=12)], axis=1)
    still, moved = (residuals, residuals + 1e-3 * line)
    exact = jnp.asarray(0.0)
    assert bool(near_optimum(jnp.asarray(still), jnp.asarray(columns), exact))
    assert not bool(near_optimum(jnp.asarray(moved), jnp.asarray(columns), exact))


def test_a_large_scatter_leaves_a_parameter_open_up_to_the_limit():
    data = _line(noise=4.0)
    fit = calibrate(plain(), data, [SCREW, NUT], undetermined_limit=0.2)
    assert fit.undetermined
    assert "standard deviation" in fit.undetermined[0].sentence
    assert calibrate(plain(), data, [SCREW, NUT], undetermined_limit=1e3).undetermined == ()


def test_a_start_that_cannot_be_computed_has_a_code():
    data = _line()
    wrong = prsm.set_parameter(plain(), "roller_radius", 1e-5, checked=False)
    fit = calibrate(wrong, {**data, "efficiency": np.full(12, 0.5)}, [SCREW, NUT])
    assert (fit.code, fit.converged) == ("start_fails", False)
    assert "cannot be computed at the start in 12 of 12 conditions" in fit.message
    json.dumps(fit.to_dict(), allow_nan=False)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"parameters": []}, "parameters is empty"),
        ({"parameters": "lead"}, "give a list of names"),
        ({"parameters": ["roller_count"]}, "whole number"),
        ({"parameters": [SCREW, SCREW]}, "given twice"),
        ({"parameters": ["masse"]}, "unknown parameter 'masse'"),
        ({"parameters": [LOAD]}, "is a condition of the data and a fitted parameter"),
        ({"loss": "l2"}, "loss is 'l2'; choose one of squared, huber"),
        ({"bounds": {NUT: (0, 1), "lead": (0, 1)}}, "bounds of 'lead', which is not fitted"),
        ({"bounds": {NUT: (2.0, 1.0)}}, "has the bounds (2, 1) kg; reverse them"),
        ({"bounds": {NUT: (1.0, 1.0)}}, "(1, 1) kg; the upper one must be above the lower one"),
        ({"bounds": {NUT: (-2.0, 1.0)}}, "it must be more than 0"),
        ({"bounds": {NUT: 1.0}}, "give (lower, upper)"),
        ({"standard_deviations": {"own_straight": 0.0}}, "it must be positive"),
        (
            {"standard_deviations": {"own_straight": np.array([0.1, 0.1, 1.0])}},
            "standard deviation of 'own_straight' is array([0.1, 0.1, 1. ]); give one number per "
            "column",
        ),
        ({"standard_deviations": {"own_straight": 1j}}, "is 1j; give one number per column"),
        ({"data": _line() | {"own_straight": np.full(12, 1 + 1j)}}, "is complex: (1+1j)"),
        ({"data": _line() | {LOAD: np.full(12, 1 + 1j)}}, f"{LOAD!r} is complex: (1+1j)"),
        ({"standard_deviations": {"efficiency": 0.1}}, "which is not in the data"),
        ({"undetermined_limit": 0.0}, "it must be positive"),
        ({"data": _line(rows=2)}, "2 measured values for 2 parameters"),
        ({"data": {LOAD: [1.0]}}, "no measured quantity"),
        ({"data": {LOAD: [1.0, 2.0], "efficiency": [1.0]}}, "one number per row"),
        ({"data": {LOAD: [np.nan], "efficiency": [1.0]}}, "is nan in row 1"),
        ({"data": {LOAD: [1.0], "efficiency": [np.nan]}}, "NaN in all rows"),
        ({"data": {"carrier_ratio[2]": [0.4, 0.4, 0.4]}}, "has one component; give [1]"),
        (
            {"data": {"torsional_frequencies[0]": [2e3, 2e3, 2e3]}},
            "torsional_frequencies[0]: the quantity has 4 components; give [1] to [4]",
        ),
        ({"data": {"roller_count": [7.0] * 3, "efficiency": [0.4] * 3}}, "whole number"),
    ],
)
def test_wrong_arguments_are_refused(unchecked, arguments, message):
    usual = {"data": _line(), "parameters": [SCREW, NUT]}
    with pytest.raises(ValueError, match=re.escape(message)):
        calibrate(plain(), **(usual | arguments))


def test_measurements_hold_columns_by_kind():
    data = Measurements.from_columns({LOAD: [1.0, 2.0], "efficiency": [0.5, np.nan]})
    assert list(data.values) == ["efficiency"]
    assert list(data.conditions) == [LOAD]
    assert data.rows == 2


@pytest.mark.parametrize("loss", LOSSES)
def test_squares_of_a_loss_have_its_derivatives(loss):
    z = np.array([-8.0, -1.5, -0.4, -1e-4, 0.0, 1e-4, 0.3, 1.2, 2.0, 30.0])

    def value(one):
        return 0.5 * as_squares(one[None], loss)[0] ** 2

    # The formulas of docs/calibration.md.
    size = np.abs(z)
    expected = {
        "squared": z**2 / 2,
        "huber": np.where(size <= 1.345, z**2 / 2, 1.345 * size - 1.345**2 / 2),
        "soft_l1": np.sqrt(1 + z**2) - 1,
        "cauchy": 2.385**2 / 2 * np.log1p((z / 2.385) ** 2),
    }[loss]
    # The root of 1 + z² has lost eight digits at 1e-4.
    assert np.asarray(jax.vmap(value)(z)) == pytest.approx(expected, rel=1e-9, abs=1e-15)
    first = jax.vmap(jax.grad(value))(z)
    second = jax.vmap(jax.grad(jax.grad(value)))(z)
    expected = influence(z, loss)
    assert np.asarray(first) == pytest.approx(expected[0], rel=1e-9, abs=1e-12)
    assert np.asarray(second) == pytest.approx(expected[1], rel=1e-6, abs=1e-9)


_NUMBERS = st.floats(-50, 50)


@hypothesis.given(_NUMBERS, st.floats(0.1, 30), st.floats(0.02, 0.98), st.integers(0, 3))
def test_the_map_to_free_numbers_goes_back(low, width, share, kind):
    lower = low if kind & 1 else -np.inf
    upper = low + width if kind & 2 else np.inf
    value = low + share * width
    arrays = [jnp.array([one]) for one in (value, lower, upper, 3.0)]
    there = to_free(*arrays)
    assert float(from_free(there, *arrays[1:])[0]) == pytest.approx(value, rel=1e-9, abs=1e-9)
    # Whatever the free number is, the value keeps its bounds.
    for free in (-70.0, 0.0, 70.0):
        inside = float(from_free(jnp.array([free]), *arrays[1:])[0])
        assert lower - 1e-9 <= inside <= upper + 1e-9
