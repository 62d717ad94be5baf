"""`make test` and `make slow`: which sessions of pytest they start, and with which status they end.

The Python that `make` starts is replaced by a script that writes its words down.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="there is no make")

_SCRIPT = """#!{python}
import os, pathlib, sys
if "tests.of_room" in sys.argv:
    os.execv({python!r}, [{python!r}, *sys.argv[1:]])
told = pathlib.Path({told!r})
before = told.read_text().splitlines() if told.exists() else []
told.write_text("\\n".join([*before, " ".join(sys.argv[1:])]))
sys.exit({statuses!r}[len(before)])
"""


def _made(folder: Path, target: str, *statuses: int, room: str = ""):
    """Status and output of `make`, and the words of each session; its sessions end as told."""
    told = folder / "told"
    python = folder / "bin" / "python"
    python.parent.mkdir()
    python.write_text(
        _SCRIPT.format(python=sys.executable, told=str(told), statuses=list(statuses))
    )
    python.chmod(0o755)
    for stamp in ("demo", "test"):
        (folder / f".installed-{stamp}").touch()
    words = ["make", target, f"VENV={folder}", "ALLOCATOR=", f"ROOM={room}"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=120)
    sessions = told.read_text().splitlines() if told.exists() else []
    return done.returncode, done.stdout + done.stderr, sessions


def test_every_session_of_slow_tests_runs_and_all_pass(tmp_path):
    status, _, sessions = _made(tmp_path, "slow", 0, 0, 0, 0)
    assert status == 0
    assert len(sessions) == 4
    folders = [word for one in sessions for word in one.split() if word.startswith("tests/")]
    assert folders == sorted(set(folders))
    assert {"tests/benchmarks", "tests/dynamics", "tests/vibration"} <= set(folders)
    assert all(" -m slow " in one for one in sessions)


@pytest.mark.parametrize("failing", range(4))
def test_a_session_that_fails_fails_all_and_the_others_run(tmp_path, failing):
    statuses = [int(k == failing) for k in range(4)]
    status, _, sessions = _made(tmp_path, "slow", *statuses)
    assert status != 0
    assert len(sessions) == 4


@pytest.mark.parametrize(("ends", "expected"), [(0, 0), (1, 2), (5, 2)])
def test_quick_tests_are_one_session(tmp_path, ends, expected):
    status, _, sessions = _made(tmp_path, "test", ends)
    assert status == expected
    (only,) = sessions
    assert only.endswith("-m not slow tests")


@pytest.mark.parametrize("target", ["test", "slow"])
def test_a_room_without_such_tests_is_no_failure(tmp_path, target):
    status, output, sessions = _made(tmp_path, target, 5, room="numerics")
    assert status == 0
    assert "ROOM=numerics: no such tests" in output
    (only,) = sessions
    assert "tests/numerics" in only


def test_a_room_that_there_is_not_is_refused_before_any_session(tmp_path):
    status, output, sessions = _made(tmp_path, "slow", room="attic")
    assert status != 0
    assert "ROOM is 'attic'; choose one of " in output
    assert sessions == []
