"""Fronts whose equation is known, the volume below them, and what a wrong problem says."""

import itertools
import json

import jax.numpy as jnp
import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax.mechanism import DesignProblem, Objective, Variable
from prsm_jax.optimisation import hypervolume, non_dominated, optimise, pareto

#: Every problem below is over these two numbers, in units of millimetres and 0.1 rad.
BOX = {"lead": (4e-3, 14e-3), "contact_angle": (0.3, 1.3)}
#: Centres of the bowls in these units.
A, B, C = np.array([6.0, 8.0]), np.array([11.0, 6.0]), np.array([8.0, 11.0])


def _point(analysis):
    thread = analysis.mechanism.stages[0].thread
    return jnp.stack([thread.lead * 1e3, thread.contact_angle * 10])


def _squared(analysis, centre):
    return jnp.sum((_point(analysis) - centre) ** 2)


@pytest.fixture
def bowls(own_quantities):
    own_quantities("bowl_a", lambda a: _squared(a, A))
    own_quantities("bowl_b", lambda a: _squared(a, B))
    own_quantities("bowl_c", lambda a: _squared(a, C))
    own_quantities("hill_b", lambda a: 100 - _squared(a, B))
    own_quantities("hollow_a", lambda a: 1 - jnp.exp(-_squared(a, A) / 4))
    own_quantities("hollow_b", lambda a: 1 - jnp.exp(-_squared(a, B) / 4))
    own_quantities("first_number", lambda a: _point(a)[0])


def _positions(front):
    rows = [one.variables for one in front.points]
    return np.array([[1e3 * row["lead"], 10 * row["contact_angle"]] for row in rows])


def test_two_bowls(bowls):
    """Squared distances from two points: √f₁ + √f₂ is the distance between them."""
    front = pareto(
        scenes.frictionless(), {"bowl_a": "minimise", "hill_b": "maximise"}, BOX, points=15
    )
    assert front.converged, str(front)
    assert len(front.points) == 15
    first, second = front.values.T
    roots = np.sqrt(first) + np.sqrt(100 - second)
    np.testing.assert_allclose(roots, np.linalg.norm(A - B), rtol=1e-6)
    # The ends are the best of each objective: 1e-4 of the other counts there.
    assert first[0] < 1e-6
    assert 100 - second[-1] < 1e-6
    assert max(one.kkt_residual for one in front.points) <= 1e-6
    # The design divides the distance between the centres as the weights say.
    weights = np.array([list(one.weights.values()) for one in front.points])
    weights /= np.ptp(front.values, axis=0)
    shares = weights[:, 1] / weights.sum(axis=1)
    np.testing.assert_allclose(_positions(front), A + shares[:, None] * (B - A), atol=2e-5)
    # Ordered by the first objective, and evenly spaced along the plane of the reference points.
    assert np.all(np.diff(first) > 0)
    spacing = np.diff(first + second)  # f₁ − f₂, but for a constant
    np.testing.assert_allclose(spacing, spacing.mean(), rtol=0.01)
    # Each point takes a dozen designs or so.
    assert front.evaluations + front.derivative_evaluations < 20 * len(front.points)


def test_a_front_that_is_hollow(bowls):
    """Concave towards the ideal point: no weighted sum has its middle as a minimum."""
    front = pareto(
        scenes.frictionless(), {"hollow_a": "minimise", "hollow_b": "minimise"}, BOX, points=15
    )
    assert front.converged, str(front)
    first, second = front.values.T
    roots = 2 * (np.sqrt(-np.log1p(-first)) + np.sqrt(-np.log1p(-second)))
    # Near an end the argument of the logarithm is the rounding of 1 − f.
    np.testing.assert_allclose(roots, np.linalg.norm(A - B), rtol=1e-6)
    assert len(front.points) >= 13
    # The chord between the ends lies below the middle.
    assert first[7] + second[7] > 1.2


def test_a_front_along_a_limit(bowls):
    """Both centres lie beyond x ≤ 5: the designs are on x = 5, between the two heights."""
    front = pareto(
        scenes.frictionless(),
        {"bowl_a": "minimise", "bowl_b": "minimise"},
        BOX,
        {"first_number": (None, 5.0)},
        points=9,
    )
    assert front.converged, str(front)
    first, second = front.values.T
    # 1e-6 is the tolerance of the constraint, in units of its limit; both slopes are above 1.
    heights = np.sqrt(first - 1.0) + np.sqrt(second - 36.0)
    np.testing.assert_allclose(heights[1:-1], 2.0, atol=1e-4)
    np.testing.assert_allclose(_positions(front)[:, 0], 5.0, atol=1e-5)
    assert all("first_number" in one.active for one in front.points)


def test_three_bowls(bowls):
    """The designs fill the triangle of the centres, and divide it as the weights say."""
    names = ("bowl_a", "bowl_b", "bowl_c")
    front = pareto(scenes.frictionless(), dict.fromkeys(names, "minimise"), BOX, points=28)
    assert front.converged, str(front)
    assert len(front.points) >= 25
    corners = np.stack([A, B, C])
    # Weights are those of objectives over their ranges.
    ranges = np.ptp(front.values, axis=0)
    weights = np.array([[one.weights[name] for name in names] for one in front.points]) / ranges
    weights /= weights.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(_positions(front), weights @ corners, atol=5e-5)
    assert np.all(weights > 0)
    # Spread over the whole triangle: each corner, and a point near its middle.
    for corner in corners:
        assert np.min(np.linalg.norm(_positions(front) - corner, axis=1)) < 1e-2
    middle = corners.mean(axis=0)
    assert np.min(np.linalg.norm(_positions(front) - middle, axis=1)) < 0.7


def test_objectives_without_conflict_have_one_design(own_quantities):
    own_quantities("one_bowl", lambda a: _squared(a, A))
    own_quantities("same_bowl", lambda a: 3 * _squared(a, A) + 7)
    front = pareto(
        scenes.frictionless(), {"one_bowl": "minimise", "same_bowl": "minimise"}, BOX, points=5
    )
    assert len(front.points) == 1
    assert "do not conflict" in front.message
    assert front.points[0].variables["lead"] == pytest.approx(6e-3, abs=1e-6)


def test_no_feasible_design_is_a_report(bowls):
    front = pareto(
        scenes.frictionless(),
        {"bowl_a": "minimise", "bowl_b": "minimise"},
        BOX,
        {"first_number": (None, 3.0)},
    )
    assert front.points == ()
    assert not front.converged
    # The least of the box is 4.
    words = "the design of least violation has first_number = 4 against a limit of 3"
    assert front.message == f"no feasible design found; {words}"
    nearest = front.least_violation
    assert nearest is not None
    assert nearest.variables["lead"] == pytest.approx(4e-3, rel=1e-9)
    (broken,) = nearest.to_dict()["broken"]
    assert broken == {
        "name": "first_number",
        "unit": "1",
        "value": pytest.approx(4.0, rel=1e-9),
        "limit": 3.0,
    }
    lines = str(front).splitlines()
    assert lines[0] == f"NO FEASIBLE DESIGN: {front.message}"
    rows = [line.split("  ")[0] for line in lines]
    assert rows.index("least violation") < rows.index("start")
    assert front.to_dict()["least_violation"] == nearest.to_dict()
    assert front.hypervolume == 0
    assert {one.status for one in front.dropped} == {"infeasible"}
    json.dumps(front.to_dict(), allow_nan=False)
    str(front)


def test_the_start_says_which_limits_it_breaks(bowls):
    """A lead of 10 mm against at most 9 mm; no margin of `check` depends on the box."""
    front = pareto(
        prsm.set_parameter(scenes.frictionless(), "lead", 10e-3),
        {"bowl_a": "minimise", "bowl_b": "minimise"},
        BOX,
        {"first_number": (None, 9.0), "bowl_c": (None, 1e3)},
        points=3,
    )
    assert front.points, str(front)
    (broken,) = front.start.broken
    assert (broken.name, broken.limit) == ("first_number", 9.0)
    assert broken.value == pytest.approx(10.0, rel=1e-12)
    assert "present design, breaks first_number" in str(front)
    assert front.least_violation is None
    assert all(one.broken == () and one.breaks == "" for one in front.points)


def test_the_result_is_plain_and_gives_mechanisms(bowls):
    front = pareto(
        scenes.frictionless(), {"bowl_a": "minimise", "bowl_b": "minimise"}, BOX, points=3
    )
    plain = front.to_dict()
    assert {"points", "hypervolume", "evaluations", "derivative_evaluations"} <= set(plain)
    assert {"variables", "quantities", "kkt_residual"} <= set(plain["points"][0])
    json.dumps(plain, allow_nan=False)
    lead = float(front.design(1).stages[0].thread.lead)
    assert lead == front.points[1].variables["lead"]
    assert float(front.design(-1).stages[0].thread.lead) == front.points[2].variables["lead"]
    for place in (3, 99, -4):
        with pytest.raises(IndexError, match=f"index is {place}; the front has points 0 to 2"):
            front.design(place)
    rows = front.to_table().rows
    assert [row[0] for row in rows] == ["start", "1", "2", "3"]
    # Points at 0, a quarter and the whole of the squared distance; a staircase of three rectangles.
    whole = float(np.sum((A - B) ** 2))
    corner = {"bowl_a": 2 * whole, "bowl_b": 2 * whole}
    expected = (2 * 1 + 1.75 * 0.75 + 1 * 0.25) * whole**2
    # The other objective counts 1e-4 in each search, which moves the points along the front.
    assert front.dominated_volume(corner) == pytest.approx(expected, rel=1e-4)
    with pytest.raises(ValueError, match="no value for bowl_b"):
        front.dominated_volume({"bowl_a": 1.0})


@pytest.mark.parametrize("count", [2, 3])
def test_volume_by_inclusion_and_exclusion(count):
    """The union of boxes by its 2ⁿ − 1 intersections."""
    points = np.random.default_rng(4).random((7, count))
    corner = np.full(count, 0.9)
    expected = 0.0
    for size in range(1, len(points) + 1):
        for chosen in itertools.combinations(points, size):
            sides = np.maximum(corner - np.max(chosen, axis=0), 0.0)
            expected += (-1) ** (size + 1) * np.prod(sides)
    assert hypervolume(points, corner) == pytest.approx(expected, rel=1e-12)
    best = points[non_dominated(points)]
    assert hypervolume(best, corner) == pytest.approx(expected, rel=1e-12)
    assert len(best) < len(points)


def test_dominance_keeps_one_of_equal_points():
    points = np.array([[1, 2], [2, 1], [1, 2], [2, 2], [3, 0]])
    np.testing.assert_array_equal(non_dominated(points), [True, True, False, False, True])
    with pytest.raises(ValueError, match="at most 3"):
        hypervolume(np.zeros((1, 4)), np.ones(4))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"objectives": {"bowl_a": "minimise"}}, "two or three different objectives.*has 1"),
        ({"objectives": {"bowl_a": "smaller", "bowl_b": "minimise"}}, 'write "maximise" or'),
        ({"objectives": ["bowl_a", "bowl_b"]}, "give the sense of each"),
        ({"objectives": {"bowl_a": "minimise", "bowel": "minimise"}}, "unknown quantity"),
        ({"objectives": {"bowl_a": "minimise", "bowl_b": "minimise"}, "points": 2}, "points is 2"),
        (
            {"objectives": {"bowl_a": "minimise", "bowl_b": "minimise"}, "load": np.nan},
            "load is nan; give a finite number",
        ),
        (
            {"objectives": {"bowl_a": "minimise", "bowl_b": "minimise"}, "tolerance": 1.0},
            "tolerance is",
        ),
    ],
)
def test_errors_name_the_thing(unchecked, bowls, arguments, words):
    with pytest.raises(ValueError, match=words):
        pareto(scenes.frictionless(), variables=BOX, **arguments)


def test_the_same_objective_twice_is_refused(bowls):
    problem = DesignProblem(
        (Variable("lead", 4e-3, 14e-3),), (Objective("bowl_a"), Objective("bowl_a", "maximise"))
    )
    with pytest.raises(ValueError, match="different objectives"):
        pareto(scenes.frictionless(), problem=problem)


@pytest.mark.parametrize(("lead", "missed"), [(8.2e-3, ""), (10e-3, "far_a")])
def test_an_objective_whose_search_stays_at_a_broken_limit(own_quantities, lead, missed):
    """sin(2.5 x) + 0.4 (x − 9)² ≤ −0.9 holds in one valley beside others of less depth.

    From 8.2 mm the search for one objective ends in another valley, and finds its optimum from the
    optimum of the other; from 10 mm it does not, and the front says so.
    """
    own_quantities("far_a", lambda a: _squared(a, np.array([4.5, 4.0])))
    own_quantities("far_b", lambda a: _squared(a, np.array([13.5, 12.0])))
    own_quantities("wavy", lambda a: jnp.sin(2.5 * _point(a)[0]) + 0.4 * (_point(a)[0] - 9.0) ** 2)
    start = prsm.set_parameter(scenes.frictionless(), "lead", lead)
    objectives = {"far_a": "minimise", "far_b": "minimise"}
    front = pareto(start, objectives, BOX, {"wavy": (None, -0.9)}, points=3)
    assert front.points, str(front)
    assert max(one.violation for one in front.points) <= 1e-6
    assert front.converged == (not missed)
    assert ("no optimum of far_a was found" in front.message) == bool(missed)
    assert "no feasible design" not in front.message
    assert "do not conflict" not in front.message


def test_a_design_without_derivatives_is_not_optimal(own_quantities):
    """√|x − 9|⁠: at its kink the value is finite and the derivative is not."""
    own_quantities("cusp", lambda a: jnp.sqrt(jnp.abs(_point(a)[0] - 9.0)))
    own_quantities("slope", lambda a: (_point(a)[1] - 8.0) ** 2 + (_point(a)[0] - 9.0) ** 2)
    start = prsm.set_parameter(scenes.frictionless(), "lead", 9e-3)
    front = pareto(start, {"cusp": "minimise", "slope": "minimise"}, BOX, points=3)
    for one in (*front.points, *front.dropped):
        assert one.status != "optimal" or abs(one.variables["lead"] - 9e-3) > 1e-12, str(front)
    best = optimise(start, BOX, minimise="cusp", starts=1)
    assert not best.converged, str(best)
