"""Standard output and error that may be closed, full, or a pipe without a reader."""

import io
import os
import sys
from typing import TextIO


class _Sink(io.FileIO):
    """A descriptor that stores its first failure and discards everything after it."""

    failure: OSError | None = None
    closed_before = False

    def write(self, data) -> int:
        if self.failure is None:
            try:
                return super().write(data)
            except OSError as error:
                self.failure = error
        return memoryview(data).nbytes


def ignore_failed_output() -> None:
    """Make printing raise no exception if stdout or stderr of this process fails."""
    if os.name != "posix":
        return  # a Windows console is not a file of bytes
    sys.stdout, sys.stderr = _patient(sys.stdout, 1), _patient(sys.stderr, 2)


def _patient(stream: TextIO | None, number: int) -> TextIO:
    sink = _Sink(number, "wb", closefd=False)
    sink.closed_before = stream is None
    return io.TextIOWrapper(
        io.BufferedWriter(sink),
        encoding=getattr(stream, "encoding", None) or "utf-8",
        # A substitute for characters that the terminal does not have, instead of no result.
        errors="replace" if number == 1 else "backslashreplace",
        line_buffering=number == 2 or sink.isatty(),
        write_through=False,
    )


def stdout_failure() -> OSError | None:
    """Flush stdout, and return the error that prevented output, if any.

    A reader that closes the pipe early (`head`, a pager) is not a failure.
    """
    sys.stdout.flush()
    sink = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    failure = sink.failure if isinstance(sink, _Sink) else None
    return None if isinstance(failure, BrokenPipeError) else failure


def stdout_is_closed() -> bool:
    """Whether the process was started without a stdout."""
    sink = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    return isinstance(sink, _Sink) and sink.closed_before
