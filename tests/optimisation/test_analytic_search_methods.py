"""Searches as objects that carry their options: against words, closed forms and known minima."""

import itertools
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import optax
import pytest
import scenes
import scipy.optimize
from extensions import extension

import prsm_jax as prsm
from prsm_jax.mechanism import DesignProblem, Objective, Variable
from prsm_jax.optimisation import (
    Adam,
    Lbfgs,
    MultiStart,
    Optax,
    Scipy,
    SearchMethod,
    SearchResult,
    Slsqp,
    TrustConstr,
    optimise,
)
from prsm_jax.optimisation.search import _constrained, search_of

# What stands in for the functions of a search is none, and errors are those that a user sees.
pytestmark = pytest.mark.usefixtures("unchecked")

BOX = {"lead": (4e-3, 14e-3), "contact_angle": (0.3, 1.3)}
START = np.array([0.8, 0.1])
MIDDLE, WEIGHTS = np.array([0.3, 0.6]), np.array([1.0, 9.0])


def _ignore(position):
    return None


def _point(analysis):
    thread = analysis.mechanism.stages[0].thread
    return thread.lead * 1e3, thread.contact_angle


@pytest.fixture
def hollow(own_quantities):
    """A quantity of third order with its minimum inside the box, and one to be limited."""
    own_quantities(
        "hollow",
        lambda a: (_point(a)[0] - 7) ** 2 + (9 + _point(a)[0]) * (_point(a)[1] - 0.9) ** 2 + 2,
    )
    own_quantities("hollow_limit", lambda a: _point(a)[0] + 10 * _point(a)[1])


def _bowl(lower=None, upper=None) -> Any:
    """9 (y − 0.6)² + (x − 0.3)², with limits on x + y if there are any."""
    count = int(lower is not None)
    slopes = np.ones((count, 2))
    return SimpleNamespace(
        cost=lambda x: float(WEIGHTS @ (x - MIDDLE) ** 2),
        gradient=lambda x: 2 * WEIGHTS * (x - MIDDLE),
        usable=lambda x: True,
        limits=(np.array([lower] * count, float), np.array([upper] * count, float)),
        equality=np.array([lower == upper] * count, bool),
        constraint_values=lambda x: slopes @ x,
        constraint_jacobian=lambda x: slopes,
    )


@pytest.mark.parametrize(
    ("word", "method", "options", "limit"),
    [
        ("slsqp", Slsqp, {}, None),
        ("slsqp", Slsqp, {}, 14.0),
        ("slsqp", Slsqp, {"max_iterations": 2}, 14.0),
        ("trust-constr", TrustConstr, {}, 14.0),
        ("trust-constr", TrustConstr, {"max_iterations": 9}, None),
        ("lbfgs", Lbfgs, {}, None),
        ("adam", Adam, {"max_iterations": 40}, None),
    ],
)
def test_a_word_stands_for_an_object(hollow, word, method, options, limit):
    constraints = {} if limit is None else {"hollow_limit": (None, limit)}
    arguments = {"minimise": "hollow", "constraints": constraints, "starts": 2}
    of_word = optimise(scenes.frictionless(), BOX, method=word, **options, **arguments)
    of_object = optimise(scenes.frictionless(), BOX, method=method(**options), **arguments)
    assert of_word.to_dict() == of_object.to_dict()
    assert of_object.method == word


def test_options_by_name_are_the_fields_of_the_object():
    """Values of a file: a whole number is a real one where the field is."""
    for word, options, made in (
        ("slsqp", {"restarts": 0}, Slsqp(restarts=0)),
        ("auto", {"memory_size": 4}, Lbfgs(memory_size=4)),
        ("adam", {"learning_rate": 1, "max_iterations": 7}, Adam(1.0, 7)),
        ("trust-constr", {}, TrustConstr()),
        (
            "multi-start",
            {"steps": 300, "keep": 4, "restarts": 1},
            MultiStart(300, keep=4, finish=Slsqp(restarts=1)),
        ),
    ):
        assert search_of(word, False, None, options.items()) == made
    assert search_of("slsqp", True, 5, [("max_iterations", 9)]) == Slsqp(max_iterations=5)


def test_the_problem_carries_the_options_of_its_method(hollow):
    """Three steps of Adam; another method does not get them."""
    problem = DesignProblem(
        tuple(Variable(name, *bounds) for name, bounds in BOX.items()),
        (Objective("hollow"),),
        method="adam",
        method_options=(("max_iterations", 3),),
    )
    best = optimise(scenes.frictionless(), problem=problem)
    same = optimise(scenes.frictionless(), BOX, minimise="hollow", method=Adam(max_iterations=3))
    assert [run.iterations for run in best.runs] == [3]
    assert best.optimum.variables == same.optimum.variables
    wrong = replace(problem, method_options=(("steps", 3),))
    with pytest.raises(ValueError, match="'adam' takes learning_rate, max_iterations, but not st"):
        optimise(scenes.frictionless(), problem=wrong)
    assert optimise(scenes.frictionless(), problem=wrong, method=Adam(max_iterations=3)) is not None
    with pytest.raises(ValueError, match="method_options are steps, steps; give each one once"):
        replace(problem, method_options=(("steps", 3), ("steps", 4)))


def test_whole_numbers_by_an_object(own_quantities):
    """Of 5.3 starts the whole number below is better; the object searches for it too."""

    def starts(analysis):
        thread = analysis.mechanism.stages[0].thread
        return thread.lead / thread.pitch

    own_quantities("starts_away", lambda a: (starts(a) - 5.3) ** 2 + 1)
    found = [
        optimise(
            scenes.frictionless(roller_count=5),
            {"starts_at_fixed_pitch": (3.2, 8.7)},
            minimise="starts_away",
            method=method,
        )
        for method in ("slsqp", Slsqp(), Lbfgs(), Scipy("COBYQA"))
    ]
    assert found[0].to_dict() == found[1].to_dict()
    for best in found:
        assert best.optimum.variables["starts_at_fixed_pitch"] == pytest.approx(5.0, abs=1e-6)
    # COBYQA searches with the whole numbers too; after L-BFGS, SLSQP does.
    assert all("trust-region radius" in run.message for run in found[3].runs)
    assert "projected gradient" in found[2].runs[0].message
    assert "projected gradient" not in found[2].runs[-1].message


def test_the_learning_rate_is_the_first_step_of_adam():
    steps = []
    Adam(learning_rate=0.02, max_iterations=5).search(_bowl(), START, 0.0, steps.append)
    # Adam's first step is the learning rate against the sign of each slope.
    np.testing.assert_allclose(steps[0], START + np.array([-0.02, 0.02]), rtol=1e-6)
    assert len(steps) == 5


def test_the_memory_of_lbfgs():
    """In ten variables a memory of one step needs more steps than a memory of ten."""
    weights = np.linspace(1.0, 300.0, 10)
    bowl: Any = SimpleNamespace(
        cost=lambda x: float(weights @ (x - 0.4) ** 2),
        gradient=lambda x: 2 * weights * (x - 0.4),
        usable=lambda x: True,
    )
    start = np.linspace(0.1, 0.9, 10)
    short, long = (
        Lbfgs(memory_size=size).search(bowl, start, 1e-6, _ignore).iterations for size in (1, 10)
    )
    assert short > 1.2 * long


@pytest.mark.parametrize("limits", [(None, None), (-np.inf, 0.7), (0.95, np.inf), (0.8, 0.8)])
def test_slsqp_stops_one_step_after_the_tolerance(limits):
    """Also where rounding of the cost lets SciPy's line search go on."""
    tolerance = 1e-7
    lower, upper = limits
    bowl = _bowl(lower, upper)
    cost, evaluated, iterates = bowl.cost, [], []

    def noisy(x):
        evaluated.append(x)
        return cost(x) + 1e-13 * np.sin(1e10 * x[0])

    # A cost of fourth order, so that no step meets its minimum at once.
    bowl.cost = lambda x: noisy(x) + (x[0] - MIDDLE[0]) ** 4 + (x[1] - MIDDLE[1]) ** 4
    bowl.gradient = lambda x: 2 * WEIGHTS * (x - MIDDLE) + 4 * (x - MIDDLE) ** 3
    found = Slsqp().search(bowl, START, tolerance, iterates.append)
    # On the line of an equality the search ends before a second such iterate.
    assert lower == 0.8 or found.message == "KKT residual below tolerance"
    assert found.iterations == len(iterates)
    assert len(evaluated) < 40

    def residual(x):
        """Along the limit, where there is one; else of the whole gradient."""
        slope = bowl.gradient(x)
        if lower is None:
            return np.max(np.abs(slope))
        ends = [end for end in limits if np.isfinite(end)]
        return max(abs(slope[0] - slope[1]) / 2, abs(np.sum(x) - ends[0]))

    within = [residual(x) <= tolerance for x in iterates]
    assert lower == 0.8 or within[-2:] == [True, True]
    assert not any(one and other for one, other in itertools.pairwise(within[:-1]))
    np.testing.assert_array_equal(found.position, iterates[-1])
    assert residual(found.position) < tolerance / 10


@pytest.mark.parametrize("restarts", [0, 1])
def test_restarts_of_slsqp(restarts, monkeypatch):
    calls, minimise = [], scipy.optimize.minimize

    def counted(*arguments, **options):
        calls.append(options["options"]["maxiter"])
        return minimise(*arguments, **options)

    monkeypatch.setattr(scipy.optimize, "minimize", counted)
    method = Slsqp(restarts=restarts, max_iterations=50)
    monkeypatch.setattr(_constrained, "_residual", lambda *_: 1.0)
    found = method.search(_bowl(), START, 1e-9, _ignore)
    assert len(calls) == 1 + restarts
    # Iterations of the first count for the second.
    assert calls[0] == 50
    assert restarts == 0 or calls[1] < 50
    assert found.iterations <= 50


def test_optax_takes_the_steps_of_the_transformation_within_the_box():
    steps, rate = [], 0.15
    method = Optax(optax.sgd(rate), max_iterations=4)
    method.search(_bowl(), START, 0.0, steps.append)
    position = START
    for step in steps:
        position = np.clip(position - rate * 2 * WEIGHTS * (position - MIDDLE), 0.0, 1.0)
        np.testing.assert_allclose(step, position, rtol=1e-14)
    assert len(steps) == 4
    # The second coordinate met the bound.
    assert steps[0][1] == 1.0


def test_optax_passes_the_cost_to_those_that_ask_for_it():
    """Polyak's step is the cost over the squared gradient, where the least cost is 0."""
    steps = []
    Optax(optax.polyak_sgd(max_learning_rate=10.0), max_iterations=1).search(
        _bowl(), START, 0.0, steps.append
    )
    cost, gradient = WEIGHTS @ (START - MIDDLE) ** 2, 2 * WEIGHTS * (START - MIDDLE)
    expected = START - cost / (gradient @ gradient) * gradient
    np.testing.assert_allclose(steps[0], expected, rtol=1e-12)


def test_optax_stops_before_a_design_that_fails():
    wall = _bowl()
    wall.usable = lambda x: x[0] > 0.5
    found = Optax(optax.sgd(0.05)).search(wall, START, 1e-7, _ignore)
    assert found.message == "stopped before a design that fails"
    assert found.position[0] > 0.5


@pytest.mark.parametrize(
    "transformation",
    [
        optax.sgd(0.05),
        optax.lbfgs(linesearch=None),
        optax.chain(optax.clip_by_global_norm(0.1), optax.adam(0.05)),
    ],
    ids=["sgd", "lbfgs", "chain"],
)
def test_optax_finds_the_minimum(transformation):
    found = Optax(transformation, max_iterations=500).search(_bowl(), START, 1e-6, _ignore)
    assert found.message == "projected gradient below tolerance"
    np.testing.assert_allclose(found.position, MIDDLE, atol=1e-6)


ALL = ("SLSQP", "COBYQA", "L-BFGS-B", "TNC", "Powell")


@pytest.mark.parametrize("start", [START, np.array([0.0, 1.0])], ids=["inside", "corner"])
@pytest.mark.parametrize("name", ALL)
def test_methods_of_scipy_find_the_minimum(name, start):
    found = Scipy(name).search(_bowl(), start, 1e-7, _ignore)
    np.testing.assert_allclose(found.position, MIDDLE, atol=1e-6)


@pytest.mark.parametrize("equality", [False, True])
@pytest.mark.parametrize("name", ["SLSQP", "COBYQA"])
def test_methods_of_scipy_keep_constraints(name, equality):
    """Nearest point of x + y = 0.8 in the metric of the bowl: x − 0.3 = 9 (y − 0.6) = −0.09."""
    bowl = _bowl(0.8 if equality else -np.inf, 0.8)
    found = Scipy(name).search(bowl, START, 1e-8, _ignore)
    np.testing.assert_allclose(found.position, [0.21, 0.59], atol=1e-7)


@pytest.mark.parametrize("name", ALL)
def test_options_of_scipy_are_those_that_scipy_describes(name):
    with pytest.raises(ValueError, match=f"{name}.. takes .*, but not wings; leave it out") as told:
        Scipy(name, {"wings": 2})
    listed = str(told.value).split("takes ")[1].split(", but not")[0].split(", ")
    described = str(scipy.optimize.show_options("minimize", name, disp=False))
    for option in listed:
        assert f"{option} : " in described or f"{option}, " in described, option
        if "tol" in option:
            # SciPy warns of an option that it does not take, which is an error here.
            Scipy(name, {option: 1e-5}).search(_bowl(), START, 1e-7, _ignore)


def test_options_and_iterations_reach_scipy():
    rough, fine = (
        Scipy("COBYQA", {"final_tr_radius": size}).search(_bowl(), START, 1e-7, _ignore)
        for size in (1e-2, 1e-7)
    )
    assert rough.iterations < fine.iterations
    for name in ALL:
        few, all_steps = [], []
        Scipy(name, max_iterations=1).search(_bowl(), START, 1e-7, few.append)
        Scipy(name).search(_bowl(), START, 1e-7, all_steps.append)
        assert len(few) < len(all_steps)


def test_methods_of_scipy_on_a_mechanism(hollow):
    """The judgement is the same for every method, and the result says which it was."""
    limited = {"minimise": "hollow", "constraints": {"hollow_limit": (None, 14.0)}}
    expected = optimise(scenes.frictionless(), BOX, method="slsqp", **limited).optimum
    best = optimise(scenes.frictionless(), BOX, method=Scipy("COBYQA"), **limited)
    assert best.method == "SciPy COBYQA"
    assert best.converged, str(best)
    for name, value in expected.variables.items():
        assert best.optimum.variables[name] == pytest.approx(value, rel=1e-5)
    free = optimise(scenes.frictionless(), BOX, minimise="hollow", method=Optax(optax.adam(0.02)))
    assert free.method == "Optax"
    assert free.optimum.variables["lead"] == pytest.approx(7e-3, rel=1e-4)


@dataclass(frozen=True)
class _Ends(SearchMethod):
    """Looks at some positions, and returns one of its own choice."""

    looks: tuple[tuple[float, ...], ...]
    end: tuple[float, ...]

    def search(self, functions, start, tolerance, report):
        for position in self.looks:
            functions.cost(np.array(position))
        return SearchResult(np.array(self.end), "told to end", 1)


def test_a_search_of_ones_own_ends_within_the_bounds(hollow):
    """Minimum at (0.3, 0.6) of the box; the end outside is moved to the bound, as the KKT see."""
    method = _Ends(((0.3, -0.4), (0.2, 0.6)), (0.3, 1.7))
    best = optimise(scenes.frictionless(), BOX, minimise="hollow", method=method)
    assert best.method == "_Ends"
    assert best.optimum.variables == pytest.approx({"lead": 7e-3, "contact_angle": 1.3})
    assert best.bounds_active == {"contact_angle": "upper"}
    assert not best.converged
    assert "message of the search: told to end" in best.message


@dataclass(frozen=True)
class _OwnStarts(_Ends):
    """Starts where it wants, and ends there."""

    chooses_starts = True

    def chosen(self, evaluator, positions):
        assert len(positions) == 1
        return [np.array(position) for position in self.looks]

    def search(self, functions, start, tolerance, report):
        return SearchResult(start, "", 0)


def test_a_search_of_ones_own_chooses_its_starts(hollow):
    starts = ((0.3, 0.5), (0.3, 0.6), (0.1, 0.6))
    method = _OwnStarts(starts, (0.0, 0.0))
    best = optimise(scenes.frictionless(), BOX, minimise="hollow", method=method)
    assert len(best.runs) == 3
    # The minimum is at the second.
    assert best.optimum.variables == pytest.approx({"lead": 7e-3, "contact_angle": 0.8}, rel=0.2)
    assert best.converged


def test_the_best_design_within_the_bounds_counts_if_the_end_is_no_design(own_quantities):
    """The end is infeasible; of what was looked at, the better design lies outside of the box."""
    own_quantities("hollow_at_seven", lambda a: (_point(a)[0] - 7) ** 2)
    own_quantities("hollow_wall", lambda a: _point(a)[0])

    class Constrained(_Ends):
        accepts_constraints = True

    best = optimise(
        scenes.frictionless(),
        {"lead": (8e-3, 14e-3)},
        minimise="hollow_at_seven",
        constraints={"hollow_wall": (None, 12.0)},
        method=Constrained(((-0.1,), (0.5,)), (0.9,)),
    )
    assert best.optimum.variables["lead"] == pytest.approx(8e-3 + 0.5 * 6e-3)


def test_the_search_of_the_page_finds_the_deeper_valley(own_quantities):
    """Valleys at 5 and 12, the second deeper; from 5.5 SLSQP ends in the first."""
    own_quantities(
        "hollow_valleys",
        lambda a: (_point(a)[0] - 5) ** 2 * (_point(a)[0] - 12) ** 2 / 50 - 0.3 * _point(a)[0],
    )
    own_quantities("hollow_reach", lambda a: _point(a)[0])
    start = scenes.frictionless(geometry=scenes.thread(lead=5.5e-3))
    evolution = extension("differential_evolution").DifferentialEvolution(generations=8)

    def found(method, least):
        limits = {"hollow_reach": (least, 13.0)}
        bounds = {"lead": BOX["lead"]}
        return optimise(start, bounds, None, "hollow_valleys", limits, method=method)

    assert found(Slsqp(), 4.0).optimum.variables["lead"] < 6e-3
    # The slope (x − 5)(x − 12)(2 x − 17)/25 is 0.3 in the valleys and on the ridge.
    deepest = max(np.roots(np.polysub(np.poly([5, 12, 8.5]) * 2 / 25, [0.3])).real)
    for least, expected in ((4.0, deepest), (12.5, 12.5)):
        best = found(evolution, least)
        assert best.converged, str(best)
        assert best.method == "DifferentialEvolution"
        assert best.optimum.variables["lead"] == pytest.approx(expected * 1e-3, rel=1e-6)
        assert best.runs[0].iterations > evolution.generations
    # The same designs in every run; others with another seed.
    histories = [found(replace(evolution, seed=seed), 4.0).objective_history for seed in (0, 0, 1)]
    assert histories[0] == histories[1] != histories[2]


def test_the_search_of_the_page_comes_near_without_derivatives():
    """Before SLSQP finishes it, and on the allowed side of x + y <= 0.8."""
    evolution = extension("differential_evolution").DifferentialEvolution(generations=40)
    for bowl, expected in ((_bowl(), MIDDLE), (_bowl(-np.inf, 0.8), [0.21, 0.59])):
        steps = []
        found = evolution.search(bowl, START, 1e-8, steps.append)
        np.testing.assert_allclose(steps[39], expected, atol=1e-2)
        np.testing.assert_allclose(found.position, expected, atol=1e-7)


class _Guarded(SearchMethod):
    """Tells which of two designs is usable."""

    def search(self, functions, start, tolerance, report):
        return SearchResult(start, str([functions.usable(np.array([x])) for x in (0.0, 1.0)]), 1)


def test_a_design_with_an_error_of_check_fails_for_a_search_without_constraints(own_quantities):
    """Twelve rollers of five starts overlap where their radius is small beside the addendum."""
    own_quantities("hollow_roller", lambda a: a.mechanism.stages[0].thread.roller_radius)
    thread = scenes.thread(roller_radius=10e-3, roller_addendum=0.3e-3)
    one, bounds = scenes.mechanism(scenes.stage(12, geometry=thread)), (4e-3, 12e-3)

    class Constrained(_Guarded):
        accepts_constraints = True

    told = [
        optimise(one, {"roller_radius": bounds}, minimise="hollow_roller", method=method).runs[0]
        for method in (_Guarded(), Constrained())
    ]
    assert [run.message for run in told] == ["[False, True]", "[True, True]"]


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: Slsqp(memory_size=3), "Slsqp takes restarts, max_iterations, but not memory_size"),  # pyright: ignore[reportCallIssue]
        (lambda: Lbfgs(restarts=3), "Lbfgs takes memory_size, max_iterations, but not restarts"),  # pyright: ignore[reportCallIssue]
        (lambda: TrustConstr(xtol=1.0), "TrustConstr takes max_iterations, but not xtol; leave"),  # pyright: ignore[reportCallIssue]
        (lambda: Adam(rate=0.1), "Adam takes learning_rate, max_iterations, but not rate; leave"),  # pyright: ignore[reportCallIssue]
        (lambda: Optax(optax.sgd(0.1), steps=9), "transformation, max_iterations, but not steps"),  # pyright: ignore[reportCallIssue]
        (lambda: Scipy("TNC", {"maxfun": 9}), "maxfun is given by max_iterations"),
        (lambda: Scipy("BFGS"), "method is 'BFGS'; choose one of SLSQP, COBYQA, L-BFGS-B, TNC"),
        (lambda: Scipy("TNC", max_iterations=0), "max_iterations is 0; it must be at least 1"),
        (lambda: Slsqp(max_iterations=2.5), "max_iterations is 2.5; it must be a whole number"),  # pyright: ignore[reportArgumentType]
        (lambda: Slsqp(restarts=-1), "restarts is -1; it must be at least 0"),
        (lambda: Lbfgs(memory_size=0), "memory_size is 0; it must be at least 1"),
        (lambda: Adam(max_iterations=0), "max_iterations is 0"),
        (lambda: Adam(learning_rate=0.0), "learning_rate is 0.0; it must be above 0"),
        (lambda: Adam(learning_rate=np.nan), "learning_rate is nan"),
        (lambda: Optax("adam"), "transformation is 'adam'; give one of optax, such as optax.adam"),
        (lambda: Optax(optax.lbfgs()), r"value_fn.*optax\.lbfgs\(linesearch=None\)"),
        (
            lambda: search_of("slsqp", True, None, (("steps", 3),)),
            "method 'slsqp' takes restarts, max_iterations, but not steps; leave it out",
        ),
        (
            lambda: search_of("multi-start", True, None, (("finish", 3),)),
            "'multi-start' takes steps, learning_rate, keep, restarts, max_iterations, but not fin",
        ),
        (
            lambda: search_of("auto", False, None, (("restarts", 3),)),
            "method 'lbfgs' takes memory_size, max_iterations, but not restarts",
        ),
        (lambda: search_of("adam", False, None, (("max_iterations", 2.5),)), "a whole number"),
        (lambda: search_of("optax", False), "choose one of auto, adam, lbfgs, slsqp, trust-constr"),
        (lambda: search_of(Slsqp, False), "give an object such as prsm_jax.optimisation.Slsqp"),  # pyright: ignore[reportArgumentType]
        (lambda: search_of("adam", True), "'adam' accepts bounds only; .* slsqp or trust-constr"),
        (lambda: search_of(Optax(optax.sgd(0.1)), True), "'Optax' accepts bounds only"),
        (lambda: search_of(Scipy("Powell"), True), "'SciPy Powell' accepts bounds only"),
        (lambda: search_of(_Guarded(), True), "'_Guarded' accepts bounds only"),
        (
            lambda: search_of(Slsqp(), True, 9),
            r"is Slsqp\(…\), .*options, but max_iterations.* write Slsqp\(…, max_iterations=…\)",
        ),
        (lambda: search_of(_Guarded(), False, 9), "max_iterations is passed as well; leave it out"),
    ],
)
def test_what_a_method_does_not_take_is_refused(made, message):
    with pytest.raises(ValueError, match=message):
        made()


def test_an_unknown_word_on_the_command_line(capsys):
    from prsm_jax.cli import main

    assert main(["optimise", "actuator", "--method", "magic"]) == 2
    assert "choose one of auto, adam, lbfgs, slsqp, trust-constr" in capsys.readouterr().err


def test_names_are_those_of_the_room():
    assert not {"Slsqp", "Scipy", "Optax"} & set(dir(prsm))
