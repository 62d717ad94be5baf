"""Python threads that calculate at once all return, with the numbers of one thread alone.

With LAPACK's custom calls two threads waited for each other for ever. A deadlock cannot be ended
from inside, so each case is a process of its own with a time limit.
"""

import os
import subprocess
import sys
from pathlib import Path

from tests.compilation_cache import cache_folder

SCRIPT = Path(__file__).with_name("scenes_at_once.py")
#: Compiling seven programs on a busy machine; far from for ever [s].
PATIENCE = 400


def _at_once(seconds):
    environment = os.environ | {
        "JAX_COMPILATION_CACHE_DIR": cache_folder(),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
    }
    done = subprocess.run(
        [sys.executable, "-W", "error", str(SCRIPT), str(seconds)],
        capture_output=True,
        text=True,
        timeout=PATIENCE + seconds,
        env=environment,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    words, *rounds = done.stdout.split()
    assert words == "rounds"
    assert len(rounds) == 8
    # Every thread went round all scenes at least once.
    assert min(int(one) for one in rounds) >= 7


def test_eight_threads_for_fifteen_seconds():
    _at_once(15)
