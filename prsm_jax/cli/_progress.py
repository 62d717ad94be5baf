"""The progress line on the terminal: what the program is doing.

`main` opens the line for every verb. A verb says which programs it compiles (`expect_programs`) and
what it is doing (`doing`, `counted`); JAX's own events count the compiled programs. The line is not
shown if stderr is not a terminal, nor in the first second.
"""

import contextlib
import os
import shutil
import sys
import threading
import time
from collections.abc import Generator

_ERASE = "\r\x1b[K"
_FIRST_S, _EVERY_S = 1.0, 0.2
_PATIENCE_S = 0.2
#: Events that JAX reports at the end of each step of a compilation.
_TRACED = "/jax/core/compile/jaxpr_trace_duration"
_LOWERED = "/jax/core/compile/jaxpr_to_mlir_module_duration"
_COMPILED = "/jax/core/compile/backend_compile_duration"
#: A program that was not announced is counted if lowering it takes at least this long [s].
_LONG_S = 0.2


class _Line:
    """The line of one verb."""

    def __init__(self, verb: str):
        self.verb, self.words = verb, ""
        self.began = time.monotonic()
        self.programs: set[str] = set()
        self.total = self.compiled = 0
        self.compiling = False
        #: Which step of a compilation is under way.
        self.step = "tracing"
        self.lock = threading.Lock()
        self.shown = False
        #: Whether a result was printed since the last step began: the line would follow it.
        self.printed = False
        self.over = threading.Event()

    def text(self) -> str:
        """The current text of the line."""
        words, programs = self.words, f"{self.total} program{'s' * (self.total > 1)}"
        if self.compiling:
            number = min(self.compiled + 1, self.total)
            words = f"compiling {number} of {programs}: {self.step}"
        elif not words and self.compiled:
            words = f"working, {self.compiled} of {programs} compiled"
        seconds = time.monotonic() - self.began
        text = f"prsm {self.verb}: {words or 'working'} ({seconds:.0f} s)"
        # A line that wraps could not be erased.
        most = shutil.get_terminal_size((80, 24)).columns - 1
        return text if len(text) <= most else text[: most - 1] + "…"

    def draw(self) -> None:
        with self.lock:
            if not self.over.is_set() and not self.printed:
                sys.stderr.write(_ERASE + self.text())
                sys.stderr.flush()
                self.shown = True

    def erase(self) -> None:
        """Erase the line; the next `draw` shows it again."""
        with self.lock:
            if self.shown:
                sys.stderr.write(_ERASE)
                sys.stderr.flush()
                self.shown = False

    def keep_drawing(self) -> None:
        wait = _FIRST_S
        while not self.over.wait(wait):
            self.draw()
            wait = _EVERY_S

    def event(self, event: str, name: str, duration: float) -> None:
        """Count the end of one step of compiling one program."""
        self.printed = False
        if name not in self.programs:
            if event != _LOWERED or duration < _LONG_S:
                return
            self.programs.add(name)
            self.total += 1
        if event == _COMPILED:
            self.compiled += 1
            self.total = max(self.total, self.compiled)
            self.compiling, self.step = False, "tracing"
        else:
            self.compiling = True
            self.step = "lowering" if event == _TRACED else "machine code"


_current: _Line | None = None
_listening = False


def _listen() -> None:
    """Register for JAX's compilation events, once per process."""
    global _listening
    if _listening:
        return
    import jax.monitoring

    def heard(event: str, duration_secs: float, **about: str | int) -> None:
        if _current is not None and event in (_TRACED, _LOWERED, _COMPILED):
            name = str(about.get("fun_name", "")).removeprefix("jit(").removesuffix(")")
            _current.event(event, name, duration_secs)

    jax.monitoring.register_event_duration_secs_listener(heard)
    _listening = True


@contextlib.contextmanager
def progress(verb: str) -> Generator[None, None, None]:
    """Show the progress line while the verb runs, if stderr is a terminal that can erase a line."""
    global _current
    if not sys.stderr.isatty() or os.environ.get("TERM") == "dumb":
        yield
        return
    _listen()
    line = _current = _Line(verb)
    thread = threading.Thread(target=line.keep_drawing, name="progress", daemon=True)
    thread.start()
    try:
        yield
    finally:
        line.over.set()
        line.erase()
        _current = None


def expect_programs(*names: str, times: int = 1) -> None:
    """Announce functions that will be compiled; each is counted once it is compiled.

    **Arguments:**

    - `names`: names of the jitted functions.
    - `times`: how often each is compiled.
    """
    if _current is not None:
        _current.programs.update(names)
        _current.total += times * len(names)
        # Only before the first: later, tracing cannot be distinguished from running.
        _current.compiling = _current.compiled == 0


def doing(words: str) -> None:
    """Set the text of the line; programs compiled later are still announced by themselves."""
    if _current is not None:
        _current.words, _current.compiling, _current.printed = words, False, False


def counted(done: int, total: int, what: str) -> None:
    """Show how far a loop is, such as `counted(4096, 12000, "designs")`."""
    doing(f"{done} of {total} {what}")


class Counter:
    """Shows how far a long loop is, its rate, and the time left."""

    def __init__(self, what: str):
        self._what = what
        self._first: tuple[int, float] | None = None

    def __call__(self, done: int, total: int) -> None:
        """Say that `done` of `total` are finished."""
        now = time.monotonic()
        words = f"{done} of {total} {self._what}"
        if self._first is None:
            # What was there before, or came with the program's compilation, has no rate.
            self._first = done, now
        else:
            before, began = self._first
            if now - began > _FIRST_S and done > before:
                rate = (done - before) / (now - began)
                words += f", {rate:.3g}/s, {_duration((total - done) / rate)} left"
        doing(words)


def _duration(seconds: float) -> str:
    """A time with one unit: seconds, minutes or hours."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


def clear() -> None:
    """Erase the line before something else is printed; the next step shows it again."""
    if _current is not None:
        _current.printed = True
        _current.erase()


def tell(text: str) -> None:
    """Print to stdout while the line is shown."""
    clear()
    print(text, flush=True)
    if _current is not None:
        _current.printed = False


def erase_for_good() -> str:
    """Stop drawing because the process ends; returns the characters that erase the line."""
    line = _current
    if line is None:
        return ""
    line.over.set()
    line.lock.acquire(timeout=_PATIENCE_S)
    return _ERASE if line.shown else ""
