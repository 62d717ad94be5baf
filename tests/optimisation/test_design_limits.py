"""Limits of the design problem beside the present design, by which reports and the studio judge."""

import dataclasses
import math

import numpy as np
import pytest
import scenes

from prsm_jax.mechanism import Constraint, DesignProblem, Objective, OperatingCase, Variable
from prsm_jax.optimisation import _limits, limit_readings, optimise, with_limits

BOX = (Variable("lead", 4e-3, 14e-3),)
AIM = (Objective("lead_of_limits", "maximise"),)


@pytest.fixture
def lead(own_quantities):
    """The lead in millimetres, and that times the load in kilonewtons or the speed."""

    def millimetres(analysis):
        return analysis.mechanism.stages[0].thread.lead * 1e3

    own_quantities("lead_of_limits", millimetres)
    own_quantities("lead_over_ten", lambda a: millimetres(a) - 10.0)
    own_quantities("lead_times_load", lambda a: millimetres(a) * a.load / 1e3)
    own_quantities("speed_of_limits", lambda a: a.speed + 0 * millimetres(a))


def _mechanism(*constraints, lead=10e-3, **more):
    made = scenes.frictionless(geometry=scenes.thread(lead=lead))
    problem = DesignProblem(BOX, AIM, constraints, **more)
    return dataclasses.replace(made, design_problem=problem)


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ({"upper": 12.5}, [("at most", 12.5, 0.2, "pass")]),
        ({"upper": 8.0}, [("at most", 8.0, -0.25, "fail")]),
        ({"lower": 8.0}, [("at least", 8.0, 0.25, "pass")]),
        ({"lower": 12.5}, [("at least", 12.5, -0.2, "fail")]),
        (
            {"lower": 8.0, "upper": 8.0},
            [("at least", 8.0, 0.25, "pass"), ("at most", 8.0, -0.25, "fail")],
        ),
        ({"equal": 12.5}, [("equal to", 12.5, -0.2, "fail")]),
        ({"equal": 10.0}, [("equal to", 10.0, 0.0, "pass")]),
        # A file and a search are exact to a millionth; a tenth of a thousandth is broken.
        ({"upper": 10.0 - 1e-5}, [("at most", 10.0, -1e-6, "pass")]),
        ({"upper": 10.0 - 1e-3}, [("at most", 10.0, -1e-4, "fail")]),
        ({"lower": 10.0 + 1e-3}, [("at least", 10.0, -1e-4, "fail")]),
        # The scale of a range is its larger end, as in a search.
        ({"lower": 10.003, "upper": 1e3}, [("at least", 10.003, -3e-4, "pass"), None]),
        ({"lower": 10.0, "upper": math.inf}, [("at least", 10.0, 0.0, "pass")]),
    ],
)
def test_value_margin_and_verdict(lead, limits, expected):
    found = limit_readings(_mechanism(Constraint("lead_of_limits", **limits)))
    assert len(found) == len(expected)
    for one, row in zip(found, expected, strict=True):
        assert (one.quantity, one.speed, one.load) == ("lead_of_limits", None, None)
        assert one.value == pytest.approx(10.0, rel=1e-12)
        if row is not None:
            sense, limit, margin, verdict = row
            assert (one.sense, one.verdict) == (sense, verdict)
            assert one.limit == pytest.approx(limit, rel=1e-3)
            assert one.margin == pytest.approx(margin, rel=2e-3, abs=1e-12)


@pytest.mark.parametrize(
    ("millimetres", "verdict"), [(10.001, "fail"), (10.000001, "pass"), (9.0, "pass")]
)
def test_a_limit_of_zero_has_no_share(lead, millimetres, verdict):
    design = _mechanism(Constraint("lead_over_ten", upper=0.0), lead=millimetres * 1e-3)
    (one,) = limit_readings(design)
    assert one.margin == pytest.approx(10 - millimetres, abs=1e-9)
    assert one.verdict == verdict


@pytest.mark.parametrize(("micrometres", "verdict"), [(-0.001, "pass"), (-0.1, "fail")])
def test_a_limit_of_zero_metres(lead, micrometres, verdict):
    """A nanometre is rounding, a tenth of a micrometre is not."""
    design = _mechanism(Constraint("roller_clearance", lower=0.0))
    (one,) = limit_readings(design, {"roller_clearance": 1e-6 * micrometres})
    assert (one.unit, one.verdict) == ("m", verdict)


def test_the_operating_point_with_the_least_margin(lead):
    """12 mm: 5 kN give 60, 8 kN 96, 2 kN 24 against at most 80."""
    cases = tuple(OperatingCase(*one) for one in ((60.0, 5e3), (90.0, 8e3), (40.0, 2e3)))
    upper = Constraint("lead_times_load", upper=80.0)
    design = _mechanism(upper, lead=12e-3, operating_points=cases)
    (one,) = limit_readings(design)
    assert (one.value, one.speed, one.load) == pytest.approx((96.0, 90.0, 8e3), rel=1e-9)
    assert (one.verdict, one.margin) == ("fail", pytest.approx(-0.2))
    # Known values are those of the operating point of the mechanism (7 kN), and no answer here.
    assert limit_readings(design, {"lead_times_load": 1.0}) == (one,)
    lower = Constraint("lead_times_load", lower=12.0)
    (one,) = limit_readings(_mechanism(lower, lead=12e-3, operating_points=cases))
    assert (one.value, one.load, one.verdict) == (pytest.approx(24.0), 2e3, "pass")


def test_the_speed_at_which_the_nut_has_its_own(lead):
    """2π · 0.2 m/s / 10 mm = 125.7 rad/s; the mechanism's own speed is 100 rad/s."""
    design = _mechanism(Constraint("speed_of_limits", upper=120.0), nut_speed=0.2)
    (one,) = limit_readings(design)
    assert one.value == pytest.approx(2 * np.pi * 0.2 / 10e-3, rel=1e-9)
    assert one.speed == pytest.approx(one.value)
    assert one.verdict == "fail"


def test_an_optimum_keeps_its_active_limit(lead):
    """And breaks it a thousandth further."""
    upper = Constraint("lead_times_load", upper=77.0)
    best = optimise(_mechanism(upper, lead=12e-3))
    assert best.converged, str(best)
    assert best.constraints[0].active
    (one,) = limit_readings(best.mechanism)
    assert (one.verdict, one.value) == ("pass", pytest.approx(77.0, rel=1e-6))
    (before,) = limit_readings(_mechanism(upper, lead=12e-3))
    assert (before.verdict, before.value) == ("fail", pytest.approx(84.0, rel=1e-9))
    (beyond,) = limit_readings(_mechanism(upper, lead=11.011e-3))
    assert beyond.verdict == "fail"


def test_known_values_are_not_evaluated_again(lead, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("evaluated")

    monkeypatch.setattr(_limits, "compute_coded", refuse)
    design = _mechanism(Constraint("lead_of_limits", upper=8.0), Constraint("mass", upper=3.0))
    first, second = limit_readings(design, {"lead_of_limits": 9.0})
    assert (first.value, first.verdict) == (9.0, "fail")
    assert (second.unit, second.verdict) == ("kg", "not evaluated")
    assert math.isnan(second.value)
    # What a file does not limit is not evaluated.
    assert limit_readings(_mechanism()) == limit_readings(scenes.frictionless()) == ()


def test_a_quantity_without_data_or_name_is_not_evaluated(lead):
    design = _mechanism(
        Constraint("drive_torque", upper=20.0),
        Constraint("of_a_plugin", upper=1.0),
        Constraint("lead_of_limits", upper=11.0),
    )
    design = dataclasses.replace(design, operating_point=None)
    torque, unknown, kept = limit_readings(design)
    assert (torque.unit, torque.verdict) == ("N·m", "not evaluated")
    assert (unknown.unit, unknown.verdict) == ("1", "not evaluated")
    assert (kept.value, kept.verdict) == (pytest.approx(10.0), "pass")


def test_an_analysis_without_result_has_no_values(lead, monkeypatch):
    monkeypatch.setattr(_limits, "compute_coded", lambda *_, **__: ({"mass": 1.0}, 3))
    (one,) = limit_readings(_mechanism(Constraint("lead_of_limits", upper=11.0)))
    assert one.verdict == "not evaluated"


@pytest.mark.parametrize(
    ("status", "millimetres", "expected"),
    [
        ("pass", 9.0, "pass"),
        ("no checks", 9.0, "pass"),
        ("warning", 9.0, "warning"),
        ("fail", 9.0, "fail"),
        ("pass", 12.0, "fail"),
        ("warning", 12.0, "fail"),
        ("pass", None, "warning"),
        ("fail", None, "fail"),
    ],
)
def test_a_broken_limit_is_a_failure(lead, status, millimetres, expected):
    known = {} if millimetres is None else {"lead_of_limits": millimetres}
    limits = limit_readings(_mechanism(Constraint("lead_of_limits", upper=10.0)), known)
    assert with_limits(status, limits) == expected
    assert with_limits(status, ()) == status
    assert with_limits(status, None) == ("fail" if status == "fail" else "warning")
