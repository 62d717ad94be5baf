"""Test processes that start warm: forks of one that has imported everything but the package."""

import gc
import importlib
import json
import os
import signal
import sys
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest

#: What the package and its tests import and what takes a while.
_LIBRARIES = (
    *("numpy.random", "numpy.testing", "scipy.integrate", "scipy.linalg", "scipy.optimize"),
    *("scipy.sparse.linalg", "scipy.special", "jax", "jax.numpy", "jax.scipy.linalg", "jaxtyping"),
    *("beartype.claw", "equinox", "diffrax", "lineax", "optimistix", "optax", "mpmath"),
    *("hypothesis.strategies", "pydantic", "pint", "tomlkit", "tqdm", "xarray", "zarr"),
)
#: Where a process writes what happens, in its own folder.
_EVENTS = "mutation_events.jsonl"
_OUTPUT = "mutation_output.txt"


def preload() -> None:
    """Import the libraries once, for all processes that follow."""
    for name in _LIBRARIES:
        importlib.import_module(name)
    from jax._src import xla_bridge

    # A backend has threads, which do not survive a fork.
    assert not xla_bridge.backends_are_initialized()
    gc.collect()
    gc.freeze()


class _Ordered:
    """Runs likely tests first and writes down what happens."""

    def __init__(self, events, first: Sequence[str], leave_out: Sequence[str]):
        self._events, self._leave_out = events, set(leave_out)
        self._rank = {name: rank for rank, name in enumerate(first)}

    def _write(self, **words) -> None:
        self._events.write(json.dumps({**words, "at": time.time()}) + "\n")
        self._events.flush()

    def pytest_collection_modifyitems(self, items):
        items[:] = [item for item in items if item.nodeid not in self._leave_out]
        items.sort(key=lambda item: self._rank.get(item.nodeid, len(self._rank)))

    def pytest_runtest_logstart(self, nodeid):
        self._write(test=nodeid, what="start")

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self._write(test=report.nodeid, what="failed", seconds=report.duration)
        elif report.when == "call":
            self._write(test=report.nodeid, what=report.outcome, seconds=report.duration)

    def pytest_collectreport(self, report):
        if report.failed:
            self._write(test=report.nodeid, what="failed", seconds=0.0)


def _inside(folder: Path, tests, first, leave_out) -> int:
    """The life of a forked process."""
    os.setsid()
    output = os.open(folder / _OUTPUT, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(output, 1)
    os.dup2(output, 2)
    os.chdir(folder)
    here = Path(__file__).parents[2]
    sys.path[:] = [str(folder), *(p for p in sys.path if p and Path(p).resolve() != here)]
    os.environ["PYTHONPATH"] = str(folder)
    # Nothing of the sound package or of its tests has been imported, except for this one.
    for name in [name for name in sys.modules if name.partition(".")[0] in ("tests", "prsm_jax")]:
        del sys.modules[name]
    words = ["-q", "-x", "-m", "not slow", "-p", "no:cacheprovider", "-p", "no:xdist"]
    words += ["-W", "ignore:Module already imported:pytest.PytestAssertRewriteWarning"]
    with open(folder / _EVENTS, "w") as events:
        return int(pytest.main([*words, *tests], plugins=[_Ordered(events, first, leave_out)]))


@dataclass
class Process:
    """Tests that run in a folder, and what is known of them so far.

    `patience` is how long one test may take [s]: more is a hang.
    """

    folder: Path
    pid: int
    patience: float
    began: float = field(default_factory=time.time)
    failed: str = ""
    hung: str = ""
    seconds: dict[str, float] = field(default_factory=dict)

    def finished(self) -> bool:
        """Looks once; stops a process that hangs."""
        done, status = os.waitpid(self.pid, os.WNOHANG)
        running, since = "", self.began
        events = self.folder / _EVENTS
        for line in events.read_text().splitlines() if events.exists() else ():
            try:
                event = json.loads(line)
            except json.JSONDecodeError:  # being written
                continue
            running, since = event["test"], event["at"]
            if event["what"] == "failed":
                self.failed = self.failed or event["test"]
            elif event["what"] == "passed":
                self.seconds[event["test"]] = event["seconds"]
        if done:
            if not self.failed and os.waitstatus_to_exitcode(status) not in (0, 5):
                self.failed = running or "start"
            return True
        if time.time() - since > self.patience:
            os.killpg(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)
            self.hung = running or "start"
            return True
        return False

    def output(self) -> str:
        """What was printed."""
        return (self.folder / _OUTPUT).read_text()


def start(
    folder: Path,
    tests: Sequence[str],
    first: Sequence[str] = (),
    leave_out: Sequence[str] = (),
    patience: float = 150.0,
) -> Process:
    """Quick tests of the given files in a copy of the tree, until one fails.

    `first` are names of tests in the order in which they are tried before all others.
    """
    (folder / _EVENTS).unlink(missing_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pid = os.fork()
    if pid == 0:
        code = 70
        try:
            code = _inside(folder, tests, first, leave_out)
        finally:
            os._exit(code)
    return Process(folder, pid, patience)
