"""What all tests share: strict JAX, checked shapes, one compilation cache, quiet hypothesis."""

import contextlib
import ctypes
import gc
import importlib.metadata
import json
import os
import random
import sys
import tempfile
import unittest.mock
from pathlib import Path

# Of a list, an entry at random is checked: by a generator of its own, because strategies of
# hypothesis must not use the global one.
with unittest.mock.patch("random.getrandbits", random.Random(0).getrandbits):
    import beartype.door as _door  # noqa: F401

import jaxtyping

from tests import shape_checks

# The allocator that the Makefile loads is for workers, which compile: the browser has its own, and
# the command line runs as for a user.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.pop("LD_PRELOAD", None)
    os.environ.pop("MALLOC_CONF", None)

# Before the package is imported.
shape_checks.install()

# Half of the run is the compiler, of programs that mostly run once: its older code generator for
# fused loops takes half the time, and code that is not optimised three quarters. Golden numbers are
# also computed with the settings that users have, which are those of benchmarks and of notebooks.
_FLAGS = os.environ.get("XLA_FLAGS", "")
# And a program in one piece a fifth less than in pieces for cores that another worker has.
_QUICK = "--xla_backend_optimization_level=0 --xla_cpu_parallel_codegen_split_count=1"
# The compiler's own preset for fast compilation is no help: it leaves selections outside of fused
# loops, and for every operation outside it walks through the whole program. Large programs take
# twice as long with it.
# A flag that the compiler does not know ends the process without a word.
_JAXLIB = tuple(int(part) for part in importlib.metadata.version("jaxlib").split(".")[:2])
if _JAXLIB <= (0, 10):
    _QUICK += " --xla_cpu_use_fusion_emitters=false"
os.environ["XLA_FLAGS"] = f"{_FLAGS} {_QUICK}".strip()

# Source lines of every operation are carried through all passes of the compiler: a twentieth of
# its time. Errors of a trace name their lines all the same.
os.environ.setdefault("JAX_TRACEBACK_IN_LOCATIONS_LIMIT", "0")

# Processes that tests start take memory in large pieces too; see `_take_memory_in_large_pieces`.
_TRIM_THRESHOLD, _TOP_PAD = 256 << 20, 64 << 20
os.environ.setdefault("MALLOC_TRIM_THRESHOLD_", str(_TRIM_THRESHOLD))
os.environ.setdefault("MALLOC_TOP_PAD_", str(_TOP_PAD))
# And look for cycles as rarely as this one.
_STARTED = str(Path(__file__).parent / "started")
_PATHS = os.environ.get("PYTHONPATH", "").split(os.pathsep)
if _STARTED not in _PATHS:
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [*_PATHS, _STARTED]))

# As in the command line: diffrax's checks of sample times give NaN. What raises from inside a
# program calls Python, and JAX does not keep such a program for the next run.
os.environ.setdefault("EQX_ON_ERROR", "nan")

import hypothesis  # noqa: E402
import jax  # noqa: E402
import pytest  # noqa: E402

jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_numpy_dtype_promotion", "strict")

# Workers of one run compile many of the same programs, and so does the next run.
_CACHE = Path(
    os.environ.get("PRSM_TEST_CACHE", Path(tempfile.gettempdir()) / f"prsm-jax-tests-{os.getuid()}")
)
jax.config.update("jax_compilation_cache_dir", str(_CACHE))
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)

from prsm_jax.cli._compiled import write_whole_entries  # noqa: E402

# Two workers compile the same programs at the same time: neither may read half a file.
write_whole_entries()

# Compiling dwarfs a deadline, and failures must be the same on every machine.
hypothesis.settings.register_profile(
    "prsm",
    deadline=None,
    max_examples=30,
    derandomize=True,
    database=None,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
hypothesis.settings.load_profile("prsm")


# Tracing makes millions of objects that live as long as their program: looking through them for
# cycles every few hundred allocations is a tenth of the run.
gc.set_threshold(100_000, 20, 50)

#: Linux allows a process 65,530 mapped regions, and a compiled program takes up to a dozen: past
#: that the compiler aborts.
_MAPPED_REGIONS = 25_000
#: Compiled programs fill a worker's memory long before; two workers share a machine [bytes].
#: Between modules, and between the tests of one: 0.7 GiB are taken before the first test, and a
#: test takes up to 1 GiB more.
_MEMORY, _MEMORY_INSIDE = (5 << 30) // 4, (3 << 30) // 2
#: What is left after dropping may be above these: then dropping again frees nothing before so much
#: has come on top, and every test would compile its programs anew [bytes].
_GROWTH = 1 << 28
_left_after_dropping = 0
#: No worker may ever have taken more [bytes], or the session has failed, and the summary says so in
#: red; only that with PRSM_TEST_MEMORY=told in the environment.
_MOST_MEMORY = 3 << 30


def _pages(path: str = "/proc/self/statm") -> int:
    return int(Path(path).read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def _take_memory_in_large_pieces() -> None:
    """The compiler asks for memory in small pieces and gives it back: a tenth of its time."""
    with contextlib.suppress(OSError, AttributeError):
        library = ctypes.CDLL("libc.so.6")
        trim_threshold, top_pad = -1, -2
        library.mallopt(trim_threshold, _TRIM_THRESHOLD)
        library.mallopt(top_pad, _TOP_PAD)


_take_memory_in_large_pieces()


#: jemalloc's name of all its arenas together is 4096 (MALLCTL_ARENAS_ALL).
_PURGE_ALL_ARENAS = b"arena.4096.purge"


def _trim() -> None:
    # The C library keeps what was freed in small pieces unless it is asked to give it back.
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL("libc.so.6").malloc_trim(0)
    with contextlib.suppress(OSError, AttributeError):
        # So does jemalloc, which the Makefile loads where it is installed.
        ctypes.CDLL(None).mallctl(_PURGE_ALL_ARENAS, None, None, None, ctypes.c_size_t(0))


@pytest.fixture(autouse=True, scope="module")
def _few_compiled_programs():
    """Drop compiled programs between modules where a worker has gathered too many of them."""
    regions = Path("/proc/self/maps")
    if not regions.exists():
        return
    if regions.read_bytes().count(b"\n") > _MAPPED_REGIONS or _takes_more_than(_MEMORY):
        _drop_compiled_programs()


def _takes_more_than(memory: int) -> bool:
    return _pages() > max(memory, _left_after_dropping + _GROWTH)


def _drop_compiled_programs() -> None:
    global _left_after_dropping
    jax.clear_caches()
    gc.collect()
    _trim()
    if Path("/proc/self/statm").exists():
        _left_after_dropping = _pages()


@pytest.fixture
def memory_for_large_programs():
    """Drop compiled programs before a test whose own take more than a gigabyte."""
    _drop_compiled_programs()


def pytest_runtest_teardown():
    """Drop them inside a module only where it has to be: its programs are compiled again."""
    if Path("/proc/self/statm").exists() and _takes_more_than(_MEMORY_INSIDE):
        _drop_compiled_programs()


#: Of every worker, the most memory that it ever took [bytes].
_peaks: dict[str, int] = {}


def _peak() -> int:
    """The most memory that this process ever took [bytes]; 0 where the system does not say."""
    try:
        import resource
    except ImportError:
        return 0
    # In kilobytes, but on macOS.
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """A worker of pytest-xdist has ended and says how much memory it took."""
    _peaks[node.gateway.id] = getattr(node, "workeroutput", {}).get("peak_memory", 0)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session):
    """Gather how much memory every worker took."""
    config = session.config
    if hasattr(config, "workeroutput"):
        config.workeroutput["peak_memory"] = _peak()
        return
    if not _peaks:
        _peaks["this process"] = _peak()
    if _SECONDS:
        Path(_SECONDS).write_text(json.dumps(_seconds, indent=1), encoding="utf-8")
    strict = os.environ.get("PRSM_TEST_MEMORY", "strict") != "told"
    if strict and max(_peaks.values()) > _MOST_MEMORY and session.exitstatus == 0:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter):
    """Memory of every worker, and in red that of one that took too much."""
    for name, peak in sorted(_peaks.items()):
        words = f"most memory of {name}: {peak / 2**30:.2f} GiB"
        if peak > _MOST_MEMORY:
            words += f", more than the {_MOST_MEMORY / 2**30:g} GiB that a worker may take"
            terminalreporter.write_line(words, red=True, bold=True)
        elif len(_peaks) > 1:
            terminalreporter.write_line(words)


#: Slow tests, one name in each line (`python -m tests.slow` writes it from measured times).
_SLOW = Path(__file__).with_name("slow.txt")
#: Where the seconds of every test of this run are written, for `python -m tests.slow`.
_SECONDS = os.environ.get("PRSM_TEST_SECONDS")
_seconds: dict[str, float] = {}


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Mark slow tests, before tests are chosen by their marks."""
    slow = set(_SLOW.read_text(encoding="utf-8").splitlines())
    for item in items:
        if item.nodeid in slow:
            item.add_marker(pytest.mark.slow)
    if not any("::" in argument for argument in config.args):
        files = {item.nodeid.partition("::")[0] for item in items}
        names = {item.nodeid for item in items}
        unknown = sorted(n for n in slow - names if n.partition("::")[0] in files)
        if unknown:
            raise pytest.UsageError(
                f"{_SLOW.name} names tests that do not exist: {', '.join(unknown)}; take them out"
            )


def pytest_runtest_logreport(report):
    """Add up the seconds of set-up, test and take-down."""
    if _SECONDS:
        _seconds[report.nodeid] = _seconds.get(report.nodeid, 0.0) + report.duration


@pytest.fixture
def unchecked():
    """Annotations are not checked, as in a user's session, so the package's own errors show."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


@pytest.fixture
def own_quantities(monkeypatch):
    """Adds quantities to the catalogue for one test: a name of its own and a function.

    Compiled programs are kept by name, so a name must not mean two things in one session.
    """
    from prsm_jax.quantities import _catalogue, quantity

    monkeypatch.setattr(_catalogue, "_CATALOGUE", dict(_catalogue._CATALOGUE))

    def add(name, function):
        quantity(name, "q", "1", "a quantity of one test")(function)

    return add
