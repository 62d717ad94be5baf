"""`.ci/run` with stand-ins for `make` and `git`: what runs, in which order, and what it says."""

import os
import subprocess
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / ".ci" / "run"
pytestmark = pytest.mark.skipif(not SCRIPT.exists(), reason="source archives have no .ci/run")
_MAKE = '#!/bin/sh\necho "make $*"\ntest "$*" != "$FAILS"\n'
_GIT = "#!/bin/sh\necho 6\n"
_CHECKS = [
    "allocator",
    "test",
    ".venv/.installed-docs",
    "--jobs 2 --output-sync=target versions lint docs",
    "guard",
    "browser",
]


def _run(folder, **environment):
    for name, text in (("make", _MAKE), ("git", _GIT)):
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    path = f"{folder}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", str(SCRIPT)],
        env=os.environ | {"PATH": path, "FAILS": ""} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout.splitlines()


def _made(*words):
    return [f"make {one}" for one in (*_CHECKS, *words)]


def test_all_parts_run_and_each_commit_begins_with_another(tmp_path):
    parts = [f"slow PARTS={k}/4" for k in (3, 4, 1, 2)]
    assert _run(tmp_path, PRSM_CI_SECONDS="600") == (0, _made(*parts))


def test_parts_for_which_no_time_is_left_are_named(tmp_path):
    code, lines = _run(tmp_path, PRSM_CI_SECONDS="-1")
    assert (code, lines[:-1]) == (0, _made())
    assert lines[-1].startswith("NOT RUN: slow tests, part 3/4 4/4 1/4 2/4, for want of time")


@pytest.mark.parametrize("fails", ["test", "guard"])
def test_what_fails_ends_it(tmp_path, fails):
    code, lines = _run(tmp_path, PRSM_CI_SECONDS="600", FAILS=fails)
    assert code != 0
    assert lines[-1] == f"make {fails}"


def test_a_part_that_fails_does_not_hide_the_others(tmp_path):
    code, lines = _run(tmp_path, PRSM_CI_SECONDS="600", FAILS="slow PARTS=4/4")
    assert code != 0
    assert lines == [
        *_made(*(f"slow PARTS={k}/4" for k in (3, 4, 1, 2))),
        "FAILED: slow tests, part 4/4",
    ]
