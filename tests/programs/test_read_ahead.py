"""A run reads the programs that the last run of the same command used, before it needs them."""

import os
import subprocess
import sys
import threading
from collections import deque
from concurrent.futures import Future

import jax.numpy as jnp
import pytest

from prsm_jax.programs import (
    _files,
    _one_verb,
    _read_ahead,
    _stored,
    keep_list,
    one_program_where_possible,
)
from prsm_jax.programs._read_ahead import read_ahead

COMMAND = ("steady", "wu2022", "--json", "-")


def _sine(angle):
    return jnp.sin(angle)


def _cosine(angle):
    return jnp.cos(angle)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """As in a new process that is `prsm`, with an empty folder of programs; nothing begun."""
    import jax

    before = getattr(jax.config, "jax_compilation_cache_dir")  # noqa: B009
    module = _sine.__module__.partition(".")[0]
    monkeypatch.setattr(_stored, "_KNOWN", {*_stored._KNOWN, module})
    monkeypatch.setattr(_one_verb, "_one_verb", True)
    monkeypatch.setenv("PRSM_JAX_CACHE", str(tmp_path))
    tmp_path.chmod(0o700)
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    _start_again(monkeypatch)
    yield tmp_path / "programs"
    jax.config.update("jax_compilation_cache_dir", before)


def _start_again(monkeypatch):
    monkeypatch.setattr(_one_verb, "_begun", [])
    monkeypatch.setattr(_stored, "_used", {})
    monkeypatch.setattr(_stored, "_asked", set())
    monkeypatch.setattr(_stored, "_prepared", {})
    monkeypatch.setattr(_read_ahead, "_used", {})
    monkeypatch.setattr(_read_ahead, "_reading", {})
    monkeypatch.setattr(_read_ahead, "_waiting", deque())


@pytest.fixture
def reads(monkeypatch):
    """Names of the files that have been read, and whether the main thread read them."""
    found = {}
    read = _read_ahead._read

    def record(path):
        found[path.name] = threading.current_thread() is threading.main_thread()
        return read(path)

    monkeypatch.setattr(_read_ahead, "_read", record)
    return found


def _wait():
    for future in _one_verb._begun:
        future.result(timeout=60)


def _run():
    sine, cosine = map(one_program_where_possible, (_sine, _cosine))
    return float(sine(jnp.asarray(0.3))), float(cosine(jnp.asarray(0.3)))


def test_the_next_run_reads_in_another_thread(folder, reads, monkeypatch):
    first = _run()
    programs = list(_read_ahead._used)
    assert len(programs) == 2
    keep_list(COMMAND)
    kept = {path.name for path in folder.iterdir()}
    assert len(kept) == 3
    # In the order in which they were asked for.
    (names,) = kept - {path.name for path in programs}
    assert _files.read(folder / names).decode().split() == [path.name for path in programs]
    _start_again(monkeypatch)
    reads.clear()
    # Options after the file do not count.
    read_ahead((*COMMAND[:2], "--out", "elsewhere"))
    _wait()
    # In the same order.
    assert list(reads.items()) == [(path.name, False) for path in programs]
    assert _run() == first
    # Not read again by the main thread.
    assert reads == {path.name: False for path in programs}
    assert not _read_ahead._reading
    # The list is the same: it is not written again.
    monkeypatch.setattr(_files, "write", lambda *_: pytest.fail("written again"))
    keep_list(COMMAND)


def test_another_command_reads_nothing_ahead(folder, reads, monkeypatch):
    _run()
    keep_list(COMMAND)
    _start_again(monkeypatch)
    reads.clear()
    read_ahead(("steady", "actuator"))
    _wait()
    assert not reads
    _run()
    assert set(reads.values()) == {True}


def test_a_program_that_waits_is_read_where_it_is_needed(folder, reads, monkeypatch):
    """Before the thread has come to it; the thread then leaves it out."""
    first = _run()
    programs = list(_read_ahead._used)
    _start_again(monkeypatch)
    reads.clear()
    _read_ahead._waiting.extend(programs)
    assert _run() == first
    assert reads == {path.name: True for path in programs}
    assert not _read_ahead._waiting


def test_a_program_that_cannot_be_read_ahead_is_compiled(folder, monkeypatch):
    first = _run()
    keep_list(COMMAND)
    programs = list(_read_ahead._used)
    programs[0].write_bytes(programs[0].read_bytes()[:-1])
    programs[1].unlink()
    _start_again(monkeypatch)
    read_ahead(COMMAND)
    _wait()
    assert _run() == first
    assert all(_files.read(path) for path in programs)


def test_a_thread_that_is_at_work_is_waited_for(folder, reads):
    first = _run()
    (path, _) = _read_ahead._used
    ready = _read_ahead._read(path)
    at_work = _read_ahead._reading[path] = Future()
    threading.Timer(0.2, at_work.set_result, [ready]).start()
    _stored._used.clear()
    reads.clear()
    assert _run() == first
    assert path.name not in reads


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_nothing_is_read_ahead_where_others_can_write(folder, reads, monkeypatch):
    _run()
    keep_list(COMMAND)
    _start_again(monkeypatch)
    reads.clear()
    folder.parent.chmod(0o777)
    read_ahead(COMMAND)
    _wait()
    assert not reads


def test_without_a_folder_nothing_is_read_ahead(monkeypatch):
    monkeypatch.setenv("PRSM_JAX_CACHE", "")
    monkeypatch.setattr(_one_verb, "_begun", [])
    read_ahead(COMMAND)
    assert not _one_verb._begun


SCRIPT = """
import sys
sys.argv = ["prsm", "steady", "wu2022", "--json", "numbers.json"]
from prsm_jax.programs import _call, _one_verb, _read_ahead
for begun in _one_verb._begun:
    begun.result(timeout=60)
before = _call.executable
def executable(path):
    sys.stderr.write(f"{'ahead' if path in _read_ahead._reading else 'now'} {path.name}\\n")
    return before(path)
_call.executable = executable
from prsm_jax.cli import main
sys.exit(main())
"""


def test_the_command_line_reads_ahead(tmp_path):
    """It begins with the import of the package, by the list that the first run has kept."""
    environment = os.environ | {"PRSM_JAX_CACHE": str(tmp_path / "cache")}

    def run():
        command = [sys.executable, "-c", SCRIPT]
        done = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
        )
        return [line.split() for line in done.stderr.splitlines()]

    first = run()
    assert [when for when, _ in first] == ["now", "now"]
    assert run() == [["ahead", name] for _, name in first]
