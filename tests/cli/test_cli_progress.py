"""What a user sees while waiting: counts on a terminal, nothing in a pipe, no alarm of XLA."""

import os
import pty
import re
import select
import subprocess
import sys
import textwrap

import pytest

from prsm_jax.cli import _progress

_TRACED, _LOWERED, _COMPILED = _progress._TRACED, _progress._LOWERED, _progress._COMPILED


@pytest.fixture
def line(monkeypatch):
    """A line that is not drawn, as wide as most terminals."""
    monkeypatch.setenv("COLUMNS", "80")
    line = _progress._Line("optimise")
    monkeypatch.setattr(_progress, "_current", line)
    return line


def _says(line, words):
    assert line.text() == f"prsm optimise: {words} (0 s)"


def test_each_step_of_compiling_is_named_and_counted(line):
    _says(line, "working")
    _progress.expect_programs("first", "second")
    _says(line, "compiling 1 of 2 programs: tracing")
    line.event(_TRACED, "first", 3.0)
    _says(line, "compiling 1 of 2 programs: lowering")
    line.event(_LOWERED, "first", 1.0)
    _says(line, "compiling 1 of 2 programs: machine code")
    line.event(_COMPILED, "first", 9.0)
    # It may be running now, or the next one traced.
    _says(line, "working, 1 of 2 programs compiled")
    _progress.doing("checking the design")
    _says(line, "checking the design")
    line.event(_TRACED, "second", 3.0)
    _says(line, "compiling 2 of 2 programs: lowering")
    line.event(_COMPILED, "second", 3.0)
    _says(line, "checking the design")


def test_programs_that_were_not_announced_count_if_they_take_long(line):
    _progress.expect_programs("first")
    for step in (_TRACED, _LOWERED, _COMPILED):
        line.event(step, "convert_element_type", 0.01)
    # Part of a program, which is never compiled by itself.
    line.event(_TRACED, "part", 3.0)
    _says(line, "compiling 1 of 1 program: tracing")
    line.event(_COMPILED, "first", 3.0)
    line.event(_LOWERED, "other", 1.0)
    _says(line, "compiling 2 of 2 programs: machine code")
    line.event(_COMPILED, "other", 1.0)
    line.event(_COMPILED, "first", 1.0)
    _says(line, "working, 3 of 3 programs compiled")


def _start(words, stdout, stderr, tmp_path, columns=80):
    return subprocess.Popen(
        [
            sys.executable,
            "-c",
            f"import sys; sys.argv = ['prsm', *{words!r}]\n"
            "from prsm_jax.cli import main\nsys.exit(main())",
        ],
        cwd=tmp_path,
        env=os.environ
        | {"PRSM_JAX_CACHE": str(tmp_path / "cache"), "TERM": "xterm", "COLUMNS": str(columns)},
        stdin=subprocess.DEVNULL,
        stdout=stdout,
        stderr=stderr,
    )


def _seen(words, tmp_path):
    """Exit status, and everything that reached a terminal, in order."""
    ours, theirs = pty.openpty()
    process = _start(words, theirs, theirs, tmp_path)
    os.close(theirs)
    text = b""
    while True:
        select.select([ours], [], [], 200)
        try:
            more = os.read(ours, 65536)
        except OSError:
            # Linux says so where the other end is closed.
            break
        if not more:
            break
        text += more
    os.close(ours)
    return process.wait(timeout=60), text.decode().replace("\r\n", "\n")


def test_on_a_terminal_and_in_a_pipe(tmp_path):
    """An empty folder of programs: both compile. Steps are shown, and erased at the end."""
    words = ["steady", "actuator"]
    piped = _start(words, subprocess.PIPE, subprocess.PIPE, tmp_path)
    plain, errors = piped.communicate(timeout=200)
    assert (piped.returncode, errors) == (0, b"")
    (tmp_path / "cache").rename(tmp_path / "old")
    status, text = _seen(words, tmp_path)
    assert status == 0
    *drawn, left = text.split("\r\x1b[K")
    # What is left is the result alone.
    assert left == plain.decode()
    shown = [one for one in drawn if one]
    assert shown
    for one in shown:
        assert re.fullmatch(r"prsm steady: .+ \(\d+ s\)", one), one
        assert len(one) < 80
    every = "\n".join(shown)
    # A step of less than a second may not be seen.
    assert re.search(r"compiling [12] of 2 programs: (tracing|lowering|machine code) ", every)


#: Constants that XLA folds for seconds, of which it warns by the alarm of slow compilations.
_SLOW = """
import sys

sys.argv = ["prsm"]
import prsm_jax
import jax


@jax.jit
def folds():
    ones = jax.numpy.ones((120, 120))
    return jax.lax.reduce_window(ones, 0.0, jax.lax.add, (9, 9), (1, 1), "SAME").sum()


folds().block_until_ready()
jax.numpy.zeros((10**7, 10**7)).block_until_ready()
"""


def test_slow_compilation_raises_no_alarm_and_errors_of_xla_arrive(tmp_path):
    def process(**more):
        environment = {k: v for k, v in os.environ.items() if k != "TF_CPP_MIN_LOG_LEVEL"}
        environment |= {"JAX_COMPILATION_CACHE_DIR": str(tmp_path / "none")} | more
        return subprocess.Popen(
            [sys.executable, "-c", textwrap.dedent(_SLOW)],
            env=environment,
            stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    # Beside the other, one who asks for XLA's log gets it.
    ours, verbose = process(), process(TF_CPP_MIN_LOG_LEVEL="0")
    (_, said), (_, logged) = (one.communicate(timeout=200) for one in (ours, verbose))
    assert "slow_operation_alarm" in logged
    assert "slow_operation_alarm" not in said
    assert "XLA_FLAGS" not in said
    for text in (said, logged):
        assert "RESOURCE_EXHAUSTED" in text


def test_the_line_does_not_follow_a_result(monkeypatch, capsys):
    """However long the process takes to end after it has printed the result."""
    line = _progress._Line("steady")
    monkeypatch.setattr(_progress, "_current", line)
    line.draw()
    _progress.clear()
    capsys.readouterr()
    line.draw()
    assert capsys.readouterr().err == ""
    _progress.tell("a picture")
    line.draw()
    assert "prsm steady" in capsys.readouterr().err
    _progress.clear()
    _progress.doing("another step")
    line.draw()
    assert "another step" in capsys.readouterr().err
