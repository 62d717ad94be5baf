"""Standard output and error that may be closed, full, or a pipe that nobody reads any more."""

import io
import os
import sys
from typing import TextIO


class _Sink(io.FileIO):
    """A descriptor whose first failure is kept, after which the rest is thrown away."""

    failure: OSError | None = None
    closed_before = False

    def write(self, data) -> int:  # type: ignore[override]
        if self.failure is None:
            try:
                return super().write(data)
            except OSError as error:
                self.failure = error
        return memoryview(data).nbytes


def make_patient() -> None:
    """Let stdout and stderr of this process fail without an exception where text is printed."""
    if os.name != "posix":
        return  # a console of Windows is no file of bytes
    sys.stdout, sys.stderr = _patient(sys.stdout, 1), _patient(sys.stderr, 2)


def _patient(stream: TextIO | None, number: int) -> TextIO:
    sink = _Sink(number, "wb", closefd=False)
    sink.closed_before = stream is None
    return io.TextIOWrapper(
        io.BufferedWriter(sink),
        encoding=getattr(stream, "encoding", None) or "utf-8",
        # A sign for a letter that the terminal does not have, instead of no result.
        errors="replace" if number == 1 else "backslashreplace",
        line_buffering=number == 2 or sink.isatty(),
        write_through=False,
    )


def stdout_failure() -> OSError | None:
    """Why text did not arrive on stdout, after writing out what is left of it.

    A reader that has seen enough (`head`, a pager) is no failure.
    """
    sys.stdout.flush()
    sink = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    failure = sink.failure if isinstance(sink, _Sink) else None
    return None if isinstance(failure, BrokenPipeError) else failure


def stdout_is_closed() -> bool:
    """Whether the process was started without a stdout."""
    sink = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    return isinstance(sink, _Sink) and sink.closed_before
