"""A process that runs one verb uses stored programs, and finds the same as one that traces."""

import pickle
import subprocess
import sys
import threading
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from alike import same_but_for_rounding
from scenes import example

import prsm_jax as prsm
from prsm_jax.cli._common import Common
from prsm_jax.explanation import _explain
from prsm_jax.findings import _margin
from prsm_jax.mechanism import set_parameters
from prsm_jax.programs import (
    _files,
    _one_verb,
    _stored,
    bind_program,
    one_program_where_possible,
    prepare_program,
    repeated_program,
    works_beside,
)
from prsm_jax.programs._call import Call


def test_a_stored_check_finds_thesame_but_for_rounding(one_verb, usual, traced_again):
    mechanism = example("wu2022")
    expected = usual(lambda: prsm.check(mechanism))
    assert expected
    assert prsm.check(mechanism) == expected
    (stored,) = one_verb.iterdir()
    traced_again()
    assert prsm.check(mechanism) == expected
    assert [stored] == list(one_verb.iterdir())


def test_other_sources_of_margins_need_another_program(one_verb, traced_again, monkeypatch):
    """A source of a user's own is not stored: its code is not in the key."""
    mechanism = example("wu2022")
    prsm.check(mechanism)
    (stored,) = one_verb.iterdir()

    def own(mechanism, index):
        yield from ()

    monkeypatch.setattr(_margin, "_SOURCES", [*_margin._SOURCES, own])
    traced_again()
    prsm.check(mechanism)
    assert [stored] == list(one_verb.iterdir())
    monkeypatch.setattr(_margin, "_SOURCES", _margin._SOURCES[:-2])
    with pytest.raises(pytest.fail.Exception, match="traced again"):
        prsm.check(mechanism)


def test_a_stored_sensitivity_is_that_of_python(one_verb, usual, traced_again):
    mechanism = example("wu2022")
    names, parameters = ["efficiency", "max_pressure"], ["lead", "contact_angle"]

    def run():
        return prsm.sensitivity(mechanism, names, parameters)

    expected, first = usual(run), run()
    (stored,) = one_verb.iterdir()
    traced_again()
    second = run()
    assert [stored] == list(one_verb.iterdir())
    assert first.to_dict() == second.to_dict()
    for found, value in zip(jax.tree.leaves(second), jax.tree.leaves(expected), strict=True):
        # Compiled differently: another order of additions.
        np.testing.assert_allclose(found, value, rtol=1e-10, atol=1e-300)
    # Other names need another program.
    with pytest.raises(pytest.fail.Exception, match="traced again"):
        prsm.sensitivity(mechanism, names, ["lead", "roller_radius"])


def test_a_stored_program_has_no_names_of_functions(one_verb):
    prsm.check(example("wu2022"))
    (stored,) = one_verb.iterdir()
    assert b"physics:" not in _files.read(stored)


def test_the_next_process_reads_what_an_explanation_counted(one_verb, usual, monkeypatch):
    def run(name):
        return prsm.explain(example("wu2022"), programs=[name])

    expected = {name: usual(lambda name=name: run(name)) for name in ("steady_state", "modes")}
    for name, found in expected.items():
        assert run(name) == found
    monkeypatch.setattr(_explain, "traced", lambda *_: pytest.fail("traced again"))
    for name, found in expected.items():
        assert run(name) == found


def test_public_functions_read_their_stored_programs(one_verb, usual, traced_again):
    """Result objects, their static parts included, come back without tracing."""
    mechanism = example("wu2022")

    def run():
        return prsm.steady_state(mechanism), prsm.modal(mechanism, shapes=True)

    expected = usual(run)
    for found, other in zip(run(), expected, strict=True):
        same_but_for_rounding(found, other)
    stored = sorted(one_verb.iterdir())
    assert len(stored) == 2
    traced_again()
    for found, other in zip(run(), expected, strict=True):
        same_but_for_rounding(found, other)
    # Another static argument needs another program; another number does not.
    with pytest.raises(pytest.fail.Exception, match="traced again"):
        prsm.modal(mechanism, shapes=False)
    prsm.steady_state(set_parameters(mechanism, {"lead": 0.011}))
    # Under a transformation nothing is stored.
    jax.grad(lambda m: prsm.steady_state(m).efficiency)(mechanism)
    assert sorted(one_verb.iterdir()) == stored


def test_an_optimisation_reads_its_stored_programs(one_verb, usual, traced_again, monkeypatch):
    def run():
        return prsm.optimise(example("wu2022"), {"lead": (0.006, 0.014)}, "efficiency", starts=1)

    expected, first = usual(run), run()
    traced_again()
    loaded, beside = Call.loaded, {}

    def load(call):
        name = call.question[0].rpartition(".")[2]
        beside[name] = threading.current_thread() is not threading.main_thread()
        return loaded(call)

    monkeypatch.setattr(Call, "loaded", load)
    # Shapes and names of margins are read, too.
    monkeypatch.setattr(eqx, "filter_eval_shape", lambda *_: pytest.fail("shapes traced again"))
    second = run()
    # Both beside other work. A short search has no program for values alone.
    assert beside == {"compiled_derivatives": True, "_numbers_by": True}
    for found in (first, second):
        assert found.converged
        assert found.optimum.variables == pytest.approx(expected.optimum.variables, rel=1e-9)
    assert first.evaluations == second.evaluations


def _sum_of_sine_and_cosine(angle):
    return jnp.sin(angle) + jnp.cos(angle)


@pytest.fixture
def stored_function(monkeypatch):
    """A small function whose program is stored, as those of the package are."""
    module = _sum_of_sine_and_cosine.__module__.partition(".")[0]
    monkeypatch.setattr(_stored, "_KNOWN", {*_stored._KNOWN, module})
    return one_program_where_possible(_sum_of_sine_and_cosine)


@pytest.fixture
def work(monkeypatch):
    """What has been done for programs, and whether the main thread did it."""
    done = []

    def record(name):
        before = getattr(Call, name)

        def run(call):
            found = before(call)
            done.append((name, threading.current_thread() is threading.main_thread()))
            return found

        monkeypatch.setattr(Call, name, run)

    record("loaded")
    record("compiled")
    return done


def test_a_program_is_prepared_beside_other_work(
    one_verb, usual, traced_again, stored_function, work
):
    """By another thread, once, for the call with the same kind of arguments and no other."""
    angle = jnp.asarray(0.3)
    # In a process that runs longer nothing is prepared.
    usual(lambda: prepare_program(stored_function, angle))
    assert not _stored._prepared
    for _ in range(2):
        prepare_program(stored_function, angle)
    first = stored_function(angle)
    assert first == jnp.sin(0.3) + jnp.cos(0.3)
    assert work == [("compiled", False)]
    assert len(list(one_verb.iterdir())) == 1
    # Now there is a stored one.
    traced_again()
    work.clear()
    for _ in range(2):
        prepare_program(stored_function, angle)
    assert stored_function(angle) == first
    assert work == [("loaded", False)]
    assert not _stored._prepared
    # It is in use: nothing is left to prepare.
    prepare_program(stored_function, angle)
    assert not _stored._prepared
    assert not works_beside()
    with pytest.raises(pytest.fail.Exception, match="traced again"):
        stored_function(jnp.asarray([0.3]))


def test_a_bound_program_is_looked_up_once(one_verb, traced_again, stored_function, monkeypatch):
    """A later call only runs it: neither reads, nor asks what the arguments are."""
    bound = bind_program(stored_function)
    first = bound(jnp.asarray(0.3))
    assert len(list(one_verb.iterdir())) == 1
    monkeypatch.setattr(Call, "__init__", lambda *_, **__: pytest.fail("looked up again"))
    assert bound(jnp.asarray(0.3)) == first
    assert bound(jnp.asarray(0.4)) == pytest.approx(np.sin(0.4) + np.cos(0.4), rel=1e-14)


def test_the_check_is_traced_while_the_first_program_is_compiled(one_verb, usual, monkeypatch):
    """Not before it, and not where the verb ends with the findings of another mechanism."""
    monkeypatch.setattr(_one_verb, "_while_compiling", [])
    monkeypatch.setattr(_one_verb, "_begun", [])
    order, compiled = [], Call._compiled

    def record(call):
        order.append(call.question[0].rpartition(".")[2])
        return compiled(call)

    monkeypatch.setattr(Call, "_compiled", record)
    assert usual(lambda: Common().load("wu2022")) is not None
    Common().load("wu2022", is_checked=False)
    assert not _one_verb._while_compiling
    mechanism = Common(settings=["lead=9 mm"]).load("wu2022")
    assert order == []
    prsm.steady_state(mechanism)
    expected = usual(lambda: prsm.check(mechanism))
    assert prsm.check(mechanism) == expected
    # Compiled once, by a thread that the compiler of the first one began.
    assert order == ["steady_state", "_numbers_by"]
    assert len(_one_verb._begun) == 1
    # Not by a thread, too, where it is the first one itself.
    other = Common().load("li2020_two_stage")
    prsm.check(other)
    assert order[2:] == ["_numbers_by"]
    assert len(_one_verb._begun) == 1


def test_programs_that_run_often_are_optimised(one_verb, stored_function, monkeypatch):
    """Others are compiled in less time, unless the user's flags say how to compile."""
    monkeypatch.setenv("XLA_FLAGS", "")
    options, compiled = [], Call._options

    def record(call):
        options.append(compiled(call))
        return options[-1]

    monkeypatch.setattr(Call, "_options", record)
    brief = {"xla_backend_optimization_level": 0, "xla_cpu_parallel_codegen_split_count": 1}
    often = repeated_program(_sum_of_sine_and_cosine)
    stored_function(jnp.asarray(0.3))
    often(jnp.asarray([0.3]))
    prepare_program(often, jnp.asarray([0.3, 0.4]))
    often(jnp.asarray([0.3, 0.4]))
    assert options == [brief, {}, {}]
    monkeypatch.setenv("XLA_FLAGS", "--xla_backend_optimization_level=3")
    stored_function(jnp.asarray([[0.3]]))
    assert options[-1] == {"xla_cpu_parallel_codegen_split_count": 1}


def test_the_process_does_not_wait_for_a_program_that_is_not_needed():
    """Python would destroy what the compiler uses: the process ends at once, with all output."""
    script = """
import atexit, sys
sys.argv = ["prsm", "quantities"]
from prsm_jax.cli import _main
_main.works_beside = lambda: True
atexit.register(print, "Python ended")
sys.exit(_main.main())
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert "self_locking_margin" in run.stdout
    assert "Python ended" not in run.stdout
    other = script.replace("True", "False")
    run = subprocess.run([sys.executable, "-c", other], capture_output=True, text=True)
    assert "Python ended" in run.stdout


def test_a_program_that_cannot_be_read_is_compiled_where_it_is_needed(one_verb, stored_function):
    angle = jnp.asarray(0.3)
    first = stored_function(angle)
    (stored,) = one_verb.iterdir()
    stored.write_bytes(stored.read_bytes()[:-1])
    _stored._used.clear()
    _stored._asked.clear()
    prepare_program(stored_function, angle)
    assert stored_function(angle) == first
    assert _files.read(stored)


def test_programs_that_two_workers_share_are_written_whole(tmp_path):
    """The tests' own cache: a reader sees a complete entry or none."""
    from jax._src.lru_cache import LRUCache

    names = []
    whole = Path.write_bytes
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "pathlib.Path.write_bytes",
            lambda path, data: (names.append(path.name), whole(path, data)),
        )
        LRUCache(str(tmp_path), max_size=-1).put("one", b"entry")
    assert [path.name for path in tmp_path.iterdir()] == ["one-cache"]
    assert (tmp_path / "one-cache").read_bytes() == b"entry"
    # Written under another name, then renamed.
    assert len(names) == 1
    assert names != ["one-cache"]


def test_facts_of_two_functions_with_the_same_arguments_are_kept_apart(one_verb):
    mechanism = example("wu2022")
    counted = []

    def facts(words):
        return _stored.stored_facts(words, lambda _: counted.append(words) or words, mechanism)

    assert [facts("first"), facts("second"), facts("first"), facts("second")] == [
        "first",
        "second",
        "first",
        "second",
    ]
    assert counted == ["first", "second"]
    assert len(list(one_verb.iterdir())) == 2


class _WithoutHash:
    __hash__ = None  # pyright: ignore[reportAssignmentType]


def test_facts_are_found_once_for_each_structure_in_a_process():
    """Another number asks again for nothing; another structure, or what `by` says, asks anew."""
    counted = []

    def facts(mechanism):
        counted.append(jax.tree.structure(mechanism))
        return len(jax.tree.leaves(mechanism))

    one, other = example("wu2022"), example("li2020_two_stage")
    moved = prsm.set_parameter(one, "lead", 9e-3)
    found = [_stored.stored_facts("facts", facts, given) for given in (one, moved, other, one)]
    assert found == [len(jax.tree.leaves(given)) for given in (one, one, other, one)]
    assert counted == [jax.tree.structure(one), jax.tree.structure(other)]
    _stored.stored_facts("facts", facts, one, by="changed")
    assert len(counted) == 3
    # What has no hash cannot be compared with earlier questions.
    for _ in range(2):
        assert _stored.stored_facts("facts", facts, _WithoutHash()) == 1
    assert len(counted) == 5


def test_a_changed_entry_is_not_unpickled(one_verb):
    """Only bytes with the hash that was written beside them reach pickle."""
    mechanism = example("wu2022")
    _stored.stored_facts("first", lambda _: "as computed", mechanism)
    (path,) = one_verb.iterdir()
    kept = path.read_bytes()
    # A valid pickle of another result, behind the hash of the first one.
    path.write_bytes(kept[:32] + pickle.dumps("as changed"))
    assert _stored.stored_facts("first", lambda _: "as computed", mechanism) == "as computed"
    # It has been replaced by what was computed.
    assert path.read_bytes() == kept
