"""Test processes that start warm: forks of one that has imported everything but the package."""

import gc
import importlib
import json
import os
import resource
import signal
import sys
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import jaxtyping
import pytest

#: What the package and its tests import and what takes a while.
_LIBRARIES = (
    *("numpy.random", "numpy.testing", "scipy.integrate", "scipy.linalg", "scipy.optimize"),
    *("scipy.sparse.linalg", "scipy.special", "jax", "jax.numpy", "jax.scipy.linalg", "jaxtyping"),
    *("beartype.claw", "equinox", "diffrax", "lineax", "optimistix", "optax", "mpmath"),
    *("hypothesis.strategies", "pint", "tomlkit", "tqdm", "xarray", "zarr"),
)
#: Where a process writes what happens, in its own folder.
_EVENTS = "mutation_events.jsonl"
_OUTPUT = "mutation_output.txt"
#: How long a test may take that takes no time without a fault [s]; four times the usual time
#: doubles it. Generous: other programs run beside it, and what is changed is compiled anew.
_PATIENCE = 90.0
#: What a test takes that is not known [s].
_USUAL = 4.0


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

    def __init__(self, events, first, leave_out, usual: Mapping[str, float]):
        self._events, self._leave_out, self._usual = events, set(leave_out), usual
        self._rank = {name: rank - len(first) for rank, name in enumerate(first)}

    def _write(self, **words) -> None:
        self._events.write(json.dumps({**words, "at": time.time()}) + "\n")
        self._events.flush()

    def pytest_collection_modifyitems(self, items):
        items[:] = [item for item in items if item.nodeid not in self._leave_out]
        items.sort(key=lambda item: self._rank.get(item.nodeid, self._usual.get(item.nodeid, 0.0)))

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


def _inside(folder: Path, tests, first, leave_out, usual, budget: int) -> int:
    """The life of a forked process."""
    os.setsid()
    resource.setrlimit(resource.RLIMIT_CPU, (budget, budget + 5))
    # Checks of types and shapes would take most of the time, and see no physics.
    jaxtyping.install_import_hook = lambda *names: None
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
        return int(
            pytest.main([*words, *tests], plugins=[_Ordered(events, first, leave_out, usual)])
        )


@dataclass
class Process:
    """Tests that run in a folder, and what is known of them so far.

    `usual` are the seconds that tests take without a fault: many times more is a hang. `spent` says
    that the budget ended before the tests did.
    """

    folder: Path
    pid: int
    usual: Mapping[str, float]
    began: float = field(default_factory=time.time)
    failed: str = ""
    hung: str = ""
    spent: bool = False
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
            code = os.waitstatus_to_exitcode(status)
            self.spent = code in (-signal.SIGXCPU, -signal.SIGKILL)
            if not (self.failed or self.spent) and code not in (0, 5):
                self.failed = running or "start"
            return True
        if time.time() - since > _PATIENCE * (1 + self.usual.get(running, _USUAL) / 4):
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
    first: Sequence[str],
    leave_out: Sequence[str],
    usual: Mapping[str, float],
    budget: int,
) -> Process:
    """Quick tests of the given files in a copy of the tree, until one fails.

    `first` are names of tests in the order in which they are tried before all others, `usual` the
    seconds that tests take: short ones come before long ones. `budget` is the processor time that
    all may take [s].
    """
    (folder / _EVENTS).unlink(missing_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pid = os.fork()
    if pid == 0:
        code = 70
        try:
            code = _inside(folder, tests, first, leave_out, usual, budget)
        finally:
            os._exit(code)
    return Process(folder, pid, usual)
