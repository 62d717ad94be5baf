"""Scatter against closed forms: linear and quadratic quantities of normal and other numbers."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.special import ndtr, ndtri
from uncertainty_scenes import MECHANISM, TOLERANCES

import prsm_jax as prsm
from prsm_jax.findings import Margin, _margin
from prsm_jax.mechanism import Constraint, DesignProblem, Objective, Tolerance, Variable
from prsm_jax.uncertainty import PROBABILITIES, Estimate, MethodResult, ToleranceAnalysis

LINEAR, QUADRATIC, PAIR = "uncertainty_linear", "uncertainty_quadratic", "uncertainty_pair"
EPS = float(np.finfo(float).eps)


def _run(quantities, **kwargs):
    kwargs = {"tolerances": TOLERANCES, "findings": False, "samples": 2048} | kwargs
    return prsm.tolerance(MECHANISM, quantities, **kwargs)


def test_a_linear_quantity_is_exactly_normal():
    """σ² = (2·0.1)² + (4·0.05)² + 0.2² = 0.12: each tolerance has a third of it."""
    analysis = _run([LINEAR], limits={LINEAR: (None, 3.5)})
    deviation = math.sqrt(0.12)
    share = ndtr(0.5 / deviation)
    quantiles = 3.0 + deviation * ndtri(np.array(PROBABILITIES))
    for method in ("first_order", "second_order"):
        one = analysis.methods[method].estimates[LINEAR]
        # Rounding of millimetres and kilonewtons.
        assert one.mean == pytest.approx(3.0, rel=1e-12)
        assert one.standard_deviation == pytest.approx(deviation, rel=1e-12)
        assert one.contributions == pytest.approx([1 / 3] * 3, rel=1e-10)
    first = analysis.methods["first_order"].estimates[LINEAR]
    assert first.yield_share == pytest.approx(share, rel=1e-12)
    assert first.quantiles == pytest.approx(quantiles, rel=1e-12)
    best = analysis[LINEAR]
    assert analysis.method == "monte_carlo"
    assert best.mean == pytest.approx(3.0, abs=5 * best.mean_error)
    assert best.standard_deviation == pytest.approx(
        deviation, abs=5 * best.standard_deviation_error
    )
    assert best.yield_error is not None
    assert best.yield_share == pytest.approx(share, abs=5 * best.yield_error)
    for found, expected, error in zip(best.quantiles, quantiles, best.quantile_errors, strict=True):
        assert found == pytest.approx(expected, abs=5 * error)
    assert best.contributions == pytest.approx([1 / 3] * 3, abs=2e-3)
    # A standard error that is far too large would make these checks idle.
    assert best.mean_error < 1e-3
    assert best.yield_error < 1e-2
    assert analysis.best.yield_share == best.yield_share


def _moments(kurtosis):
    """1 + x + 2x² + 3xy − y²/2 with variances 0.01 and 0.0025 and a common kurtosis."""
    vx, vy = 0.01, 0.0025
    mean = 1 + 2 * vx - 0.5 * vy
    variance = vx + 4 * vx**2 * (kurtosis - 1) + 9 * vx * vy + 0.25 * vy**2 * (kurtosis - 1)
    return mean, math.sqrt(variance)


@pytest.mark.parametrize(
    ("distribution", "kurtosis", "width"),
    [("normal", 3.0, 3.0), ("uniform", 1.8, 3**0.5), ("triangular", 2.4, 6**0.5)],
)
def test_second_order_is_exact_for_a_quadratic_quantity(distribution, kurtosis, width):
    rows = tuple(
        Tolerance(name, -width * deviation, width * deviation, distribution)
        for name, deviation in (("lead", 1e-4), ("contact_angle", 0.05))
    )
    analysis = _run([QUADRATIC], tolerances=rows, samples=4096)
    mean, deviation = _moments(kurtosis)
    second = analysis.methods["second_order"].estimates[QUADRATIC]
    # Closed forms of exact derivatives: rounding alone, of numbers such as 10 mm plus 0.1 mm.
    assert second.mean == pytest.approx(mean, rel=1e-11)
    assert second.standard_deviation == pytest.approx(deviation, rel=1e-11)
    own = 0.01 + 4e-4 * (kurtosis - 1)
    assert second.contributions[0] == pytest.approx(own / deviation**2, rel=1e-11)
    # The share that is left belongs to both numbers together.
    assert 1 - sum(second.contributions) == pytest.approx(9 * 2.5e-5 / deviation**2, rel=1e-10)
    best = analysis[QUADRATIC]
    assert best.mean == pytest.approx(mean, abs=5 * best.mean_error)
    assert best.standard_deviation == pytest.approx(
        deviation, abs=5 * best.standard_deviation_error
    )
    assert best.contributions == pytest.approx(second.contributions, abs=0.01)
    first = analysis.methods["first_order"].estimates[QUADRATIC]
    assert first.mean == pytest.approx(1.0, abs=1e-12)
    # The curvature's part that first order leaves out, 2 · 0.01 − 0.5 · 0.0025.
    assert best.mean - first.mean == pytest.approx(0.01875, abs=5 * best.mean_error)


def test_one_sided_tolerances_move_the_mean_to_the_middle():
    rows = (Tolerance("lead", 0.1e-3, 0.3e-3), TOLERANCES[1])
    for method in ("first_order", "second_order"):
        # Exact for a linear quantity, but for the rounding of millimetres.
        found = _run([LINEAR], tolerances=rows, method=method)[LINEAR]
        assert found.mean == pytest.approx(3.4, rel=1e-11)
    found = _run([LINEAR], tolerances=rows, method="monte_carlo")[LINEAR]
    assert found.mean == pytest.approx(3.4, abs=5 * found.mean_error)
    assert found.mean_error < 5e-4


def test_the_ends_of_the_tolerance_zones():
    """q = 1 + x + 2 x² + 3 x y − y²/2 with one of x and y at an end and the other nominal, 0."""
    given = (Tolerance("lead", -0.1e-3, 0.3e-3), Tolerance("contact_angle", -0.2, 0.1))
    analysis = _run([QUADRATIC], tolerances=given, samples=16)
    ends = {name: one.ends[QUADRATIC] for name, one in analysis.methods.items()}
    for exact in ("monte_carlo", "second_order"):
        one = ends[exact]
        # Rounding of the lead in millimetres.
        assert one.nominal == pytest.approx(1.0, rel=1e-11)
        assert one.lower == pytest.approx([1 - 0.1 + 0.02, 1 - 0.02], rel=1e-11)
        assert one.upper == pytest.approx([1 + 0.3 + 0.18, 1 - 0.005], rel=1e-11)
    # The tangent at the middle, x = 0.1 and y = −0.05.
    middle = 1 + 0.1 + 0.02 - 0.015 - 0.00125
    by_x, by_y = 1 + 0.4 - 0.15, 0.3 + 0.05
    nominal = middle - 0.1 * by_x + 0.05 * by_y
    one = ends["first_order"]
    assert one.nominal == pytest.approx(nominal, rel=1e-11)
    assert one.lower == pytest.approx([nominal - 0.1 * by_x, nominal - 0.2 * by_y], rel=1e-11)
    assert one.upper == pytest.approx([nominal + 0.3 * by_x, nominal + 0.1 * by_y], rel=1e-11)
    # They are no samples.
    assert analysis.best.samples == len(analysis.best.values[QUADRATIC]) == 16


def test_an_end_that_fails_is_not_a_number():
    """The first component is NaN for x above 0."""
    given = (Tolerance("lead", -0.3e-3, 0.1e-3), Tolerance("contact_angle", -0.1, 0.1))
    analysis = _run([PAIR], tolerances=given, samples=64, method="monte_carlo")
    one = analysis.best.ends[f"{PAIR}[2]"]
    assert math.isnan(one.upper[0])
    assert [one.nominal, one.lower[0]] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert [one.lower[1], one.upper[1]] == pytest.approx([-0.1, 0.1])


def test_designs_that_fail_are_counted_and_have_no_place_in_the_yield():
    """x is not defined above 0: half of the designs, and the yield is that of x > −0.1 below it."""
    limits = {f"{PAIR}[1]": (-0.1, None)}
    analysis = _run([PAIR], method="monte_carlo", limits=limits, tolerances=TOLERANCES[:2])
    assert analysis.best.reasons == {"not_finite": 1024}
    assert analysis.best.failed == 1024
    assert analysis.valid
    share = ndtr(0.0) - ndtr(-1.0)
    assert analysis[f"{PAIR}[1]"].yield_share == pytest.approx(share, abs=2e-3)
    assert analysis[f"{PAIR}[2]"].yield_share is None
    assert analysis[f"{PAIR}[1]"].mean == pytest.approx(-0.1 * math.sqrt(2 / math.pi), abs=1e-3)
    assert analysis.best.yield_share == analysis[f"{PAIR}[1]"].yield_share


def test_a_design_that_fails_in_the_middle_is_not_valid():
    rows = (Tolerance("lead", 0.1e-3, 0.3e-3),)
    analysis = _run([PAIR], method="first_order", tolerances=rows)
    assert not analysis.valid
    assert analysis.to_dict()["valid"] is False
    middle = "not valid: the design in the middle of the tolerances fails"
    assert middle in analysis.text()
    # By Monte Carlo the middle is no design; the mean of 6 standard deviations lies above 0.
    sampled = _run([PAIR], method="monte_carlo", tolerances=rows)
    assert not sampled.valid
    assert "Monte Carlo is not valid: each of the 2048 designs fails" in sampled.text()
    assert "in the middle" not in sampled.text()


def test_errors_of_check_count_against_the_yield(monkeypatch):
    """1 + x + 2x² below its value at one deviation of x; the load below 5 kN is an error."""

    def margins(mechanism, index):
        yield Margin(
            "small_load",
            index + 1,
            lambda analysis: analysis.mechanism.operating_point.load,
            (("error", 5000.0),),
            lambda reading: "the load is small",
            "N",
        )

    monkeypatch.setattr(_margin, "_SOURCES", [margins])
    rows, limits = (TOLERANCES[0], TOLERANCES[2]), {QUADRATIC: (None, 1.12)}
    analysis = _run([QUADRATIC], limits=limits, tolerances=rows, findings=True)
    best = analysis.best
    # Half of Sobol's points, balanced in each number, lie below the middle.
    assert best.errors == {"small_load": 1024}
    assert "prsm check: small_load (1024)".replace("_", " ") in analysis.text()
    assert best.yield_error is not None
    assert best.yield_error < 2e-3
    assert best.yield_share == pytest.approx(0.5 * ndtr(1.0), abs=5 * best.yield_error)
    # The share of a quantity and the propagated ones see the limits alone.
    for share in (analysis[QUADRATIC].yield_share, analysis.methods["second_order"].yield_share):
        assert share == pytest.approx(ndtr(1.0), abs=5e-3)


def test_the_joint_yield_of_two_limits():
    """3 + 2x − 4y above 3, and y below one of its standard deviations."""
    limits = {LINEAR: (3.0, None), f"{PAIR}[2]": (None, 0.05)}
    rows = (TOLERANCES[0], TOLERANCES[1])
    analysis = _run([LINEAR, PAIR], limits=limits, tolerances=rows, method="first_order")
    # u = x/σx and v = y/σy: 2·0.1 u − 4·0.05 v > 0, so u > v, and v < 1.
    expected = ndtr(1.0) - 0.5 * ndtr(1.0) ** 2
    best = analysis.best
    assert best.yield_error is not None
    assert best.yield_share == pytest.approx(expected, abs=5 * best.yield_error)
    assert best.yield_error < 1e-3


def _uniform_and_normal(limit, half_width, deviation):
    """Share of a uniform number of ± half_width plus a normal number that lies below a limit.

    The integral of Φ from 0 is z Φ(z) + φ(z), up to a constant.
    """

    def integral(z):
        return z * ndtr(z) + math.exp(-0.5 * z**2) / math.sqrt(2 * math.pi)

    ends = ((limit + half_width) / deviation, (limit - half_width) / deviation)
    return deviation / (2 * half_width) * (integral(ends[0]) - integral(ends[1]))


def test_first_order_keeps_the_distributions_of_the_tolerances():
    """3 + 2 x + z with x uniform within ±0.3 and z normal: no normal distribution."""
    rows = (dataclasses.replace(TOLERANCES[0], distribution="uniform"), TOLERANCES[2])
    limits = {LINEAR: (None, 3.5), f"{PAIR}[1]": (-0.25, None)}
    analysis = _run([LINEAR], tolerances=rows, limits=limits, method="first_order")
    found = analysis[LINEAR]
    # Mean, deviation and contributions do not depend on the distributions: 0.6²/3 + 0.2².
    assert found.mean == pytest.approx(3.0, rel=1e-12)
    assert found.standard_deviation == pytest.approx(0.4, rel=1e-12)
    assert found.contributions == pytest.approx([0.75, 0.25], rel=1e-10)
    expected = _uniform_and_normal(0.5, 0.6, 0.2)
    # A normal distribution of the same deviation has 0.8944 there, 0.01 more.
    assert abs(expected - ndtr(0.5 / 0.4)) > 0.01
    assert found.yield_share is not None
    assert found.yield_error is not None
    assert 0 < found.yield_error < 1e-3
    assert found.yield_share == pytest.approx(expected, abs=5 * found.yield_error)
    for probability, quantile, error in zip(
        PROBABILITIES, found.quantiles, found.quantile_errors, strict=True
    ):
        # The share below the quantile, with the density of about 1 / 1.2 at most.
        below = _uniform_and_normal(quantile - 3.0, 0.6, 0.2)
        assert below == pytest.approx(probability, abs=5 * error / 1.2 + 1e-4)
    # One uniform number above a limit within its zone: (0.3 + 0.25) / 0.6.
    other, whole = analysis[f"{PAIR}[1]"].yield_share, analysis.best.yield_share
    assert other == pytest.approx(0.55 / 0.6, abs=1e-3)
    assert other is not None
    assert whole is not None
    # Bonferroni: the shares outside of each limit add up at most.
    assert found.yield_share + other - 1 - 1e-12 <= whole <= min(found.yield_share, other)


@pytest.mark.parametrize(
    ("label", "known"),
    [
        (f"{LINEAR}[1]", f"give limits of {LINEAR}$"),
        (f"{LINEAR}[2]", f"give limits of {LINEAR}$"),
        (f"{PAIR}[0]", r"give limits of uncertainty_pair, uncertainty_pair\[1\], uncert"),
        (f"{PAIR}[3]", r"uncertainty_pair\[2\]$"),
        (f"{PAIR}[1", r"uncertainty_pair\[2\]$"),
    ],
)
def test_limits_of_a_component_that_is_not_there_are_refused(label, known):
    for limits, problem in (({label: (0.0, 1.0)}, None), (None, label)):
        mechanism = MECHANISM
        if problem:
            objective, variable = Objective(LINEAR, "maximise"), Variable("lead", 9e-3, 11e-3)
            design = DesignProblem(
                objectives=(objective,),
                variables=(variable,),
                constraints=(Constraint(problem, upper=1.0),),
            )
            mechanism = dataclasses.replace(MECHANISM, design_problem=design)
        for method in (prsm.tolerance, allocated):
            with pytest.raises(prsm.UnknownNameError, match=known):
                method(mechanism, limits=limits, tolerances=TOLERANCES)


def allocated(mechanism, limits, tolerances):
    return prsm.uncertainty.allocate_tolerances(
        mechanism, 0.9, limits=limits, tolerances=tolerances, verify=False
    )


def test_limits_of_the_design_problem_hold_unless_the_argument_has_others():
    problem = DesignProblem(
        (Variable("lead", 5e-3, 20e-3),),
        (Objective(LINEAR),),
        (Constraint(LINEAR, upper=3.5), Constraint(QUADRATIC, equal=1.0)),
    )
    mechanism = dataclasses.replace(MECHANISM, design_problem=problem, tolerances=TOLERANCES)
    analysis = prsm.tolerance(mechanism, method="first_order")
    assert analysis.quantities == (LINEAR,)
    assert analysis.limits == ((-math.inf, 3.5),)
    assert analysis.to_dict()["quantities"][LINEAR]["limits"] == [None, 3.5]
    analysis = prsm.tolerance(mechanism, limits={LINEAR: (2.5, None)}, method="first_order")
    assert analysis.limits == ((2.5, math.inf),)


def test_the_same_seed_gives_the_same_samples():
    one, two, other = (_run([LINEAR], method="monte_carlo", seed=s)[LINEAR] for s in (1, 1, 2))
    assert one == two
    assert one.mean != other.mean


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"tolerances": ()}, "the mechanism has no tolerances"),
        ({"tolerances": None}, "the mechanism has no tolerances"),
        ({"method": "third"}, "method is 'third'; choose one of first_order"),
        ({"samples": 3}, "samples is 3; it must be at least 16"),
        ({"limits": {LINEAR: 3.0}}, r"give \(lower, upper\)"),
        ({"limits": {LINEAR: (3.0, 2.0)}}, "lower 3 is not below upper 2"),
        ({"quantities": "efficiency"}, "give a list of names"),
        ({"quantities": ["effficiency"]}, "unknown quantity"),
        ({"tolerances": (Tolerance("leed", -1.0, 1.0),)}, "unknown parameter 'leed'"),
        ({"tolerances": (Tolerance("roller_count", -1.0, 1.0),)}, "whole number has no tolerance"),
        ({"tolerances": (Tolerance("lead", -1.0, 1.0),)}, "at its lower limit stage.1.thread.lead"),
        ({"tolerances": (TOLERANCES[0], Tolerance("pitch", -1e-5, 1e-5))}, "moves again"),
    ],
)
def test_what_is_wrong_is_said_before_anything_is_computed(kwargs, message):
    with pytest.raises((ValueError, prsm.PrsmError), match=message) as error:
        _run(kwargs.pop("quantities", [LINEAR]), **kwargs)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("sampled", "deviation", "cell"),
    [
        # The mean of 4096 times 0.064, rounded, and the root mean square of those roundings.
        (
            Estimate(0.064 * (1 + EPS), 0.064 * EPS, (0.064,) * 5, None, (), 4e-18, 2e-18),
            0.0,
            "equal",
        ),
        (Estimate(0.064, 0.0, (0.064,) * 5, None, ()), 0.0, "equal"),
        # Differences that are more than rounding are shown.
        (Estimate(0.0641, 0.064 * EPS, (0.064,) * 5, None, ()), 0.0, "–"),
        (Estimate(0.064, 0.064 * EPS, (0.064,) * 5, None, ()), 1e-6, "–"),
        (Estimate(0.064, 1e-9, (0.064,) * 5, None, ()), 0.0, "mean +0.000 σ, σ -100.00 %"),
        (Estimate(math.nan, math.nan, (math.nan,) * 5, None, ()), 0.0, "–"),
    ],
)
def test_rounding_of_the_samples_is_no_scatter(sampled, deviation, cell):
    first = Estimate(0.064, deviation, (0.064,) * 5, None, ())
    methods = {
        "first_order": MethodResult({"nut_outer_diameter": first}, None, None),
        "monte_carlo": MethodResult({"nut_outer_diameter": sampled}, None, None, samples=4096),
    }
    text = ToleranceAnalysis(("nut_outer_diameter",), ("m",), (None,), (), (), methods).text()
    rows = [line for line in text.splitlines() if line.startswith("nut_outer_diameter")]
    assert rows[0].endswith(cell)
    if cell == "equal":
        assert "±" not in rows[1]
        assert rows[1].split()[4:6] == ["64", "0"]
