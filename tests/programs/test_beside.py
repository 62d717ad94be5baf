"""Calculations in other threads, of a process that runs one verb."""

import dataclasses
import threading

import pytest
from scenes import example

from prsm_jax.programs import _one_verb, beside, works_beside
from prsm_jax.report import analyse
from prsm_jax.report.results import _analyse


@pytest.fixture(params=[True, False])
def one_verb(monkeypatch, request):
    monkeypatch.setattr(_one_verb, "_one_verb", request.param)
    monkeypatch.setattr(_one_verb, "_begun", [])
    return request.param


def test_work_begins_at_once_where_a_process_runs_one_verb(one_verb):
    """Elsewhere it is done by the thread that asks for the result."""
    go, threads = threading.Event(), []

    def work(number, *, more):
        threads.append(threading.current_thread() is threading.main_thread())
        if one_verb:
            assert go.wait(60)
        return number + more

    result = beside(work, 2, more=3)
    assert works_beside() == one_verb
    go.set()
    assert result() == 5
    assert not works_beside()
    assert threads == [not one_verb]


def test_what_the_work_raises_is_raised_where_its_result_is_needed(one_verb):
    def work():
        raise ValueError("no such number")

    result = beside(work)
    with pytest.raises(ValueError, match="no such number"):
        result()
    assert not works_beside()


def test_an_analysis_by_two_threads_is_that_of_one(monkeypatch):
    """Also the order of the parts that are left out."""

    def analysed(by_two):
        monkeypatch.setattr(_one_verb, "_one_verb", by_two)
        return analyse(example("wu2022"))

    one, two = analysed(False), analysed(True)
    assert two.left_out == one.left_out
    assert two.faults == one.faults == ()
    assert two.transient is not None
    assert one.transient is not None
    assert float(two.transient.solver.steps) == float(one.transient.solver.steps)
    assert [c.to_dict() for c in two.checks or ()] == [c.to_dict() for c in one.checks or ()]


def test_what_the_other_thread_leaves_out_is_told(one_verb, monkeypatch):
    """Missing data as left out, in the order of the parts; faults of both designs as faults."""
    mechanism = dataclasses.replace(example("wu2022"), operating_point=None)
    told = [part for part, _ in analyse(mechanism, transient=True).left_out]
    assert told.index("steady state") < told.index("transient")

    def fails(_):
        raise ZeroDivisionError("no time")

    monkeypatch.setattr(_analyse, "_history", fails)
    found = analyse(example("wu2022"), improved=example("wu2022"))
    assert [part for part, _ in found.faults] == ["transient", "transient after the optimisation"]
    assert all("no time" in words for _, words in found.faults)
    assert found.transient is None
    assert found.steady is not None


def test_what_waits_for_the_compiler_begins_once(one_verb):
    """After the first trace of a process that runs one verb, and in no other process."""
    begun = []
    _one_verb.while_compiling(lambda: begun.append("check"))
    assert begun == []
    _one_verb.compiler_begins()
    assert begun == ["check"] * one_verb
    _one_verb.compiler_begins()
    assert begun == ["check"] * one_verb
