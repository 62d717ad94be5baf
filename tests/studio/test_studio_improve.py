"""A search in the background: its way, its end, and how it is stopped."""

import threading
from types import SimpleNamespace

import pytest

import prsm_jax as prsm
from prsm_jax.optimisation import Design
from prsm_jax.studio import Improvement, _improve


@pytest.fixture
def search(monkeypatch):
    """`search(body)` replaces `optimise` by a function of its `watch`."""

    def replace(body):
        monkeypatch.setattr(_improve, "optimise", lambda _, problem, watch: body(watch))

    return replace


def _design(radius: float, objective: float, violation: float = 0.0, usable: bool = True) -> Design:
    return Design({"roller_radius": radius}, objective, {}, usable, violation)


def test_the_best_design_keeps_all_limits(session, search):
    def body(watch):
        watch(1, 1, 0, _design(3e-3, 2.0))
        watch(1, 1, 1, _design(3.3e-3, 1.0))
        # Better, but it breaks a limit, or could not be evaluated.
        watch(1, 1, 2, _design(3.6e-3, 0.5, violation=1e-3))
        watch(1, 1, 3, _design(3.7e-3, 0.4, usable=False))
        raise RuntimeError("no <luck>")

    search(body)
    told = []
    job = Improvement(session.mechanism(), told=lambda: told.append(1))
    assert job.wait(10)
    assert (job.state, job.message, len(job.steps)) == ("failed", "no <luck>", 4)
    assert job.best == {"roller_radius": 3.3e-3}
    assert len(told) == 5


def test_a_finished_search_is_taken_as_one_step_of_six_digits(session, search):
    def body(watch):
        watch(1, 1, 0, _design(3e-3, 2.0))
        end = SimpleNamespace(variables={"roller_radius": 2.798765432e-3})
        return SimpleNamespace(feasible=True, optimum=end, message="KKT residual 0")

    search(body)
    job = session.improve()
    assert job.wait(10)
    assert (job.state, job.message) == ("finished", "KKT residual 0")
    before = session.design
    session.take_improvement()
    assert session.design["roller_radius"] == pytest.approx(2.79877e-3, rel=1e-15)
    session.undo()
    assert session.design == before


def test_a_stopped_search_ends_and_the_page_lives(session, search):
    reached, go = threading.Event(), threading.Event()

    def body(watch):
        for iteration in range(1000):
            watch(1, 1, iteration, _design(3e-3, 1.0, violation=1.0))
            reached.set()
            go.wait(10)
        raise AssertionError("not stopped")

    search(body)
    job = session.improve()
    assert reached.wait(10)
    with pytest.raises(prsm.PrsmError, match="a search runs already"):
        session.improve()
    # Meanwhile the design can be moved and computed.
    session.set("contact_angle", 48.0)
    assert session.numbers().valid
    assert job.running
    job.stop()
    assert job.state == "stopping"
    go.set()
    assert job.wait(10)
    assert (job.state, len(job.steps)) == ("stopped", 1)
    with pytest.raises(prsm.PrsmError, match="no design that keeps all limits"):
        session.take_improvement()


def test_a_search_that_ends_while_it_is_stopped_has_ended(session, search):
    reached, go = threading.Event(), threading.Event()

    def body(watch):
        reached.set()
        assert go.wait(10)
        return SimpleNamespace(feasible=False, message="no design keeps all limits")

    class Running(str):
        """A state that lets the search end between its test and its change."""

        __hash__ = str.__hash__

        def __eq__(self, other):
            if not go.is_set():
                go.set()
                job.wait(0.3)
            return str.__eq__(self, other)

    search(body)
    job = Improvement(session.mechanism())
    assert reached.wait(10)
    job.state = Running("running")  # pyright: ignore[reportAttributeAccessIssue]
    job.stop()
    assert job.wait(10)
    assert (job.state, job.running) == ("finished", False)
    assert job.message == "no design keeps all limits"


def test_without_a_table_there_is_no_search():
    with pytest.raises(prsm.PrsmError, match=r"has no \[optimise\] table"):
        Improvement(prsm.load("wu2022"))


def test_every_iteration_of_a_search_is_watched(small):
    seen = []
    best = prsm.optimise(prsm.load(small), starts=2, watch=lambda *step: seen.append(step))
    for number, one in enumerate(best.runs, start=1):
        own = [step for step in seen if step[0] == number]
        assert [step[1:3] for step in own] == [(2, i) for i in range(len(own))]
        # The history ends with the best design that was evaluated, which may be no iterate.
        designs = [step[3] for step in own]
        assert len(one.objective_history) - len(designs) in (0, 1)
        history = zip(designs, one.objective_history, one.variable_history, strict=False)
        for design, objective, variables in history:
            assert (design.objective, design.variables) == (objective, variables)
    assert best.feasible
