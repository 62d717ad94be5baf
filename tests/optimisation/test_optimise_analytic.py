"""Optimisation of problems whose answer is known: quadratics, bounds, constraints, failures."""

import json

import jax.numpy as jnp
import numpy as np
import pytest
import scenes

from prsm_jax.mechanism import Constraint, DesignProblem, Objective, Variable
from prsm_jax.optimisation import optimality, optimise

#: Every problem below is over these two numbers, in units of millimetres and radians.
BOX = {"lead": (4e-3, 14e-3), "contact_angle": (0.3, 1.3)}


def _point(analysis):
    thread = analysis.mechanism.stages[0].thread
    return thread.lead * 1e3, thread.contact_angle


@pytest.fixture
def bowl(own_quantities):
    """(x − 7)² + 10 (y − 0.9)² + 2, x + 10 y, and a bowl centred outside the box."""
    own_quantities("bowl", lambda a: (_point(a)[0] - 7) ** 2 + 10 * (_point(a)[1] - 0.9) ** 2 + 2)
    own_quantities("outer_bowl", lambda a: (_point(a)[0] - 20) ** 2 + (_point(a)[1] - 0.9) ** 2)
    own_quantities("sum_of_both", lambda a: _point(a)[0] + 10 * _point(a)[1])


@pytest.mark.parametrize("method", ["lbfgs", "adam", "slsqp", "trust-constr"])
def test_minimum_of_a_bowl(bowl, method):
    best = optimise(scenes.frictionless(), BOX, minimise="bowl", method=method)
    assert best.converged, str(best)
    assert best.kkt_residual < 1e-6
    assert best.method == method
    # A scaled gradient below 1e-6 of a unit curvature: positions to about 1e-6 of the box.
    np.testing.assert_allclose(list(best.optimum.variables.values()), [7e-3, 0.9], rtol=1e-5)
    assert best.optimum.objective == pytest.approx(2.0, abs=1e-9)
    assert best.objective_history[0] == pytest.approx(best.start.objective)
    assert best.objective_history[-1] == best.optimum.objective


def test_auto_takes_optax_without_constraints_and_slsqp_with(bowl):
    assert optimise(scenes.frictionless(), BOX, minimise="bowl").method == "lbfgs"
    limited = optimise(scenes.frictionless(), BOX, None, "bowl", {"sum_of_both": (None, 100.0)})
    assert limited.method == "slsqp"
    # The limit is far away: reported, not active, free of charge.
    assert not limited.constraints[0].active
    assert limited.constraints[0].multiplier == 0
    assert limited.optimum.objective == pytest.approx(2.0, abs=1e-9)


@pytest.mark.parametrize("method", ["lbfgs", "slsqp"])
def test_minimum_at_a_bound(bowl, method):
    best = optimise(scenes.frictionless(), BOX, minimise="outer_bowl", method=method)
    assert best.converged, str(best)
    assert best.bounds_active == {"lead": "upper"}
    # d/dx (x − 20)² at 14 mm, per metre: what raising the bound gains.
    assert best.bound_multipliers["lead"] == pytest.approx(-12e3, rel=1e-5)


def test_maximum_is_reported_in_its_own_sense(own_quantities):
    own_quantities("hill", lambda a: 5 - (_point(a)[0] - 9) ** 2)
    best = optimise(scenes.frictionless(), {"lead": (4e-3, 14e-3)}, maximise="hill")
    assert best.optimum.objective == pytest.approx(5.0, abs=1e-9)
    assert best.start.objective == pytest.approx(4.0)


@pytest.mark.parametrize("method", ["slsqp", "trust-constr"])
@pytest.mark.parametrize("equality", [False, True])
def test_constrained_bowl_and_its_price(bowl, method, equality):
    """Nearest point of x + 10 y = 10 in the metric of the bowl: λ = 2 d/(1 + 10)."""
    limit = 10.0 if equality else (None, 10.0)
    best = optimise(
        scenes.frictionless(),
        BOX,
        minimise="bowl",
        constraints={"sum_of_both": limit},
        method=method,
    )
    assert best.converged, str(best)
    # Stationarity 2 (x − 7) = λ, 20 (y − 0.9) = 10 λ gives x − 7 = λ/2, y − 0.9 = λ/2.
    price = -2 * 6 / 11
    np.testing.assert_allclose(
        list(best.optimum.variables.values()),
        [(7 + price / 2) * 1e-3, 0.9 + price / 2],
        rtol=1e-5,
    )
    (report,) = best.constraints
    assert report.active
    assert report.satisfied
    assert report.limit == 10.0
    assert report.multiplier == pytest.approx(price, rel=1e-4)


def test_infeasible_is_reported_with_what_is_violated(bowl):
    best = optimise(
        scenes.frictionless(),
        BOX,
        minimise="bowl",
        constraints={"sum_of_both": (None, 5.0), "nut_speed": (0.0, None)},
        starts=2,
    )
    assert not best.converged
    assert best.violated == ("sum_of_both",)
    assert "no feasible design" in best.message
    assert "sum_of_both" in best.message
    assert "VIOLATED" in str(best)
    # The least violation of x + 10 y <= 5 is in the corner (4, 0.3), where it is 7.
    assert best.constraints[0].value == pytest.approx(7.0, rel=1e-3)


def test_contradicting_constraints_keep_the_report(own_quantities):
    own_quantities("contradiction", lambda a: _point(a)[0])
    problem = DesignProblem(
        (Variable("lead", 4e-3, 14e-3),),
        (Objective("contradiction"),),
        (Constraint("contradiction", lower=12.0), Constraint("contradiction", upper=6.0)),
    )
    best = optimise(scenes.frictionless(), problem=problem)
    assert not best.converged
    assert best.violated


@pytest.mark.parametrize("method", ["lbfgs", "slsqp", "trust-constr"])
def test_search_steps_back_from_designs_that_fail(own_quantities, method):
    """−x with a wall of NaN at 11 in the way of the first long step, optimum at 10.9."""
    name = f"walled_{method}"
    own_quantities(
        name,
        lambda a: jnp.where(_point(a)[0] < 11, (_point(a)[0] - 10.9) ** 4 - 0.1, jnp.nan),
    )
    # The bowl of fourth order is flat at the optimum: asked to be found to 0.1 only.
    start = scenes.mechanism(scenes.stage(geometry=scenes.thread(lead=5e-3)))
    best = optimise(start, {"lead": (4e-3, 14e-3)}, minimise=name, method=method)
    assert best.optimum.usable
    assert best.optimum.variables["lead"] == pytest.approx(10.9e-3, abs=1e-4)
    assert all(run.end is not None for run in best.runs)


def test_a_start_that_fails_does_not_stop_the_others(own_quantities):
    own_quantities(
        "half_missing", lambda a: jnp.where(_point(a)[0] > 11, (_point(a)[0] - 12) ** 2, jnp.nan)
    )
    best = optimise(
        scenes.frictionless(), {"lead": (4e-3, 14e-3)}, minimise="half_missing", starts=6
    )
    assert best.runs[0].end is None
    assert "start fails" in best.runs[0].message
    assert best.converged
    assert best.optimum.variables["lead"] == pytest.approx(12e-3, rel=1e-5)
    assert best.to_dict()["start"]["objective"] is None


def test_no_usable_start_is_a_report(own_quantities):
    own_quantities("never", lambda a: _point(a)[0] * jnp.nan)
    given = scenes.frictionless()
    best = optimise(given, {"lead": (4e-3, 14e-3)}, minimise="never", starts=2)
    assert not best.converged
    assert "none of 2 starts" in best.message
    assert best.mechanism is given
    json.dumps(best.to_dict(), allow_nan=False)


def test_designs_that_do_not_mesh_are_no_designs(own_quantities):
    """A roller profile of 0.25 m touches nowhere; the search starts there and leaves it."""
    own_quantities("profile", lambda a: a.mechanism.stages[0].thread.profile_radius * 1e3)
    flat = scenes.mechanism(
        scenes.stage(geometry=scenes.thread(lead=20e-3, roller_profile_radius=0.25))
    )
    box = {"roller_profile_radius": (4e-3, 0.3)}
    best = optimise(flat, box, minimise="profile", starts=3)
    assert best.runs[0].end is None
    assert best.optimum.usable
    assert not best.start.usable
    assert bool(scenes.mesh(best.mechanism.stages[0].thread).converged)


def test_several_starts_find_the_deeper_valley(own_quantities):
    """cos has its minima at 5 and 11 (in mm); a tilt makes the second one deeper."""

    def valleys(analysis):
        x = _point(analysis)[0]
        return jnp.cos(jnp.pi * (x - 2) / 3) - 0.05 * x

    own_quantities("valleys", valleys)
    near_first = scenes.frictionless(geometry=scenes.thread(lead=5e-3))
    box = {"lead": (4e-3, 13e-3)}
    one = optimise(near_first, box, minimise="valleys", starts=1)
    many = optimise(near_first, box, minimise="valleys", starts=6, seed=1)
    assert one.optimum.variables["lead"] < 6e-3
    assert many.optimum.variables["lead"] > 10e-3
    assert many.converged
    assert many.best_run > 0


def test_weights_form_one_sum(own_quantities):
    own_quantities("towards_six", lambda a: (_point(a)[0] - 6) ** 2)
    own_quantities("away_from_ten", lambda a: -((_point(a)[0] - 10) ** 2))
    best = optimise(
        scenes.frictionless(),
        {"lead": (4e-3, 14e-3)},
        {"away_from_ten": 1.0},
        {"towards_six": 3.0},
    )
    assert best.optimum.variables["lead"] == pytest.approx(7e-3, rel=1e-5)
    assert best.optimum.objective == pytest.approx(3 * 1 + 9)


def test_optimality_tells_right_from_wrong():
    """min (x − 0.8)² over x + y <= 1, 0 <= x, y <= 1: optimal for every y <= 0.2."""
    jacobian = np.ones((1, 2))
    limits = np.array([-np.inf]), np.array([1.0])

    def check(x, y):
        gradient = np.array([2 * (x - 0.8), 0.0])
        return optimality(np.array([x, y]), gradient, np.array([x + y]), jacobian, *limits)

    assert check(0.8, 0.1).residual < 1e-15
    # On the active limit, the multiplier that x needs is one that y refutes.
    assert check(0.5, 0.5).stationarity > 0.2
    assert check(0.7, 0.1).stationarity == pytest.approx(0.2)
    assert check(0.8, 0.5).violation == pytest.approx(0.3)
    # An active limit cannot pull: the sign of a multiplier counts.
    pulled = optimality(np.array([0.5, 0.5]), np.ones(2), np.array([1.0]), jacobian, *limits)
    assert pulled.stationarity == pytest.approx(1.0)


def test_result_prints_and_is_plain(bowl):
    best = optimise(scenes.frictionless(), BOX, None, "bowl", {"sum_of_both": (None, 10.0)})
    text = str(best)
    assert "minimise bowl" in text
    assert "active" in text
    plain = best.to_dict()
    assert {"start", "optimum", "objective_history", "constraints", "converged"} <= set(plain)
    assert plain["kkt_residual"] < 1e-6
    assert {"value", "limit", "active"} <= set(plain["constraints"][0])
    json.dumps(plain, allow_nan=False)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"variables": {"lead": (1e-3, 2e-3)}}, "no design problem"),
        ({"variables": {}, "minimise": "bowl"}, "no variables"),
        ({"variables": {"leed": (1e-3, 2e-3)}, "minimise": "bowl"}, "did you mean lead"),
        ({"variables": {"lead": (2e-3, 1e-3)}, "minimise": "bowl"}, "swap or widen"),
        ({"variables": {"lead": 1e-3}, "minimise": "bowl"}, "give .lower, upper."),
        ({"variables": {"roller_count": (8, 12)}, "minimise": "bowl"}, "sweep over it"),
        ({"variables": {"lead": (0.0, np.inf)}, "minimise": "bowl"}, "must be finite"),
        ({"variables": {"lead": (-1e-3, 1e-3)}, "minimise": "bowl"}, "lower bound is -0.001 m; it"),
        ({"variables": {**BOX, "pitch": (1e-3, 2e-3)}, "minimise": "bowl"}, "moves again"),
        ({"variables": {**BOX, "thread.lead": (1e-3, 2e-3)}, "minimise": "bowl"}, "both set"),
        ({"variables": BOX, "minimise": "bowel"}, "unknown quantity"),
        ({"variables": BOX, "minimise": "torsional_frequencies"}, "components"),
        ({"variables": BOX, "minimise": "bowl", "method": "magic"}, "method is 'magic'"),
        ({"variables": BOX, "minimise": "bowl", "starts": 0}, "starts is 0"),
        ({"variables": BOX, "minimise": "bowl", "tolerance": 0.0}, "tolerance is"),
        (
            {
                "variables": BOX,
                "minimise": "bowl",
                "constraints": {"sum_of_both": (None, 1.0)},
                "method": "adam",
            },
            "bounds only",
        ),
        ({"variables": BOX, "minimise": "duty_efficiency"}, "no duty cycle"),
        (
            {"variables": BOX, "minimise": "bowl", "starts": 1.5},
            "starts is 1.5; give a whole number of 1 or more",
        ),
        (
            {"variables": BOX, "minimise": "bowl", "starts": 2, "seed": -1},
            "seed is -1; give a whole number of 0 or more",
        ),
        (
            {"variables": BOX, "minimise": "bowl", "seed": 0.5},
            "seed is 0.5; give a whole number of 0 or more",
        ),
        (
            {"variables": BOX, "minimise": "bowl", "constraints": {"sum_of_both": (np.nan, None)}},
            "constraint on 'sum_of_both': lower is nan; give a number",
        ),
        (
            {"variables": BOX, "minimise": "bowl", "constraints": {"sum_of_both": np.nan}},
            "constraint on 'sum_of_both': equal is nan; give a number",
        ),
        ({"variables": BOX, "minimise": "bowl", "load": np.nan}, "load is nan; give a finite"),
        ({"variables": BOX, "minimise": "bowl", "speed": np.inf}, "speed is inf; give a finite"),
        (
            {"variables": BOX, "minimise": "bowl", "maximise": "bowl"},
            "'bowl' is both maximised and minimised",
        ),
    ],
)
def test_errors_name_the_thing(unchecked, bowl, arguments, words):
    wu = scenes.example("wu2022") if arguments.get("minimise") == "torsional_frequencies" else None
    with pytest.raises(ValueError, match=words):
        optimise(scenes.frictionless() if wu is None else wu, **arguments)


def test_stages_that_differ_have_no_common_start(bowl):
    two = scenes.mechanism(scenes.stage(), scenes.stage(geometry=scenes.thread(lead=6e-3)))
    with pytest.raises(ValueError, match=r"differs between the stages.*stage\.2\.thread\.lead"):
        optimise(two, {"lead": (4e-3, 14e-3)}, minimise="bowl")
    one = optimise(two, {"stage.1.lead": (4e-3, 14e-3)}, minimise="bowl")
    assert one.optimum.variables["stage.1.lead"] == pytest.approx(7e-3, rel=1e-5)
