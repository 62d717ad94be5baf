"""`.ci/run` with stand-ins for `make` and `git`: what runs, in which order, and what it says."""

import os
import subprocess
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / ".ci" / "run"
pytestmark = pytest.mark.skipif(not SCRIPT.exists(), reason="source archives have no .ci/run")
_MAKE = '#!/bin/sh\necho "make $*"\ntest "$*" != "$FAILS" -a "$*" != "$FAILS_TOO"\n'
_GIT = "#!/bin/sh\necho 6\n"
_CHECKS = [
    "allocator",
    "test",
    ".venv/.installed-docs",
    "--keep-going --jobs 2 --output-sync=target versions lint docs",
    "guard",
    "browser",
]
_PARTS = [f"slow PARTS={k}/4" for k in (3, 4, 1, 2)]


def _run(folder, **environment):
    for name, text in (("make", _MAKE), ("git", _GIT)):
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    path = f"{folder}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", str(SCRIPT)],
        env=os.environ | {"PATH": path, "FAILS": "", "FAILS_TOO": ""} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout.splitlines()


def _made(*words):
    return [f"make {one}" for one in (*_CHECKS, *words)]


def test_all_parts_run_and_each_commit_begins_with_another(tmp_path):
    assert _run(tmp_path, PRSM_CI_SECONDS="600") == (0, _made(*_PARTS))


def test_parts_for_which_no_time_is_left_are_named(tmp_path):
    code, lines = _run(tmp_path, PRSM_CI_SECONDS="-1")
    assert (code, lines[:-1]) == (0, _made())
    assert lines[-1].startswith("NOT RUN: slow tests, part 3/4 4/4 1/4 2/4, for want of time")


@pytest.mark.parametrize(
    ("fails", "name"),
    [
        ("test", "test"),
        ("guard", "guard"),
        (_CHECKS[3], "versions, lint or docs"),
        ("slow PARTS=4/4", "slow tests, part 4/4"),
    ],
)
def test_a_step_that_fails_does_not_hide_the_others(tmp_path, fails, name):
    code, lines = _run(tmp_path, PRSM_CI_SECONDS="6000", FAILS=fails)
    assert code == 1
    assert lines == [*_made(*_PARTS), f"FAILED: {name}"]


def test_all_steps_that_fail_are_named(tmp_path):
    code, lines = _run(tmp_path, PRSM_CI_SECONDS="-1", FAILS_TOO="test", FAILS="guard")
    assert code == 1
    assert lines[-2:] == ["FAILED: test", "FAILED: guard"]
