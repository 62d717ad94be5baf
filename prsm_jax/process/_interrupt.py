"""Ctrl-C: the process ends at once, whatever compiled code is doing, and leaves no partial files.

Python runs its signal handlers only between two of its instructions, and compiling or running a
program is one instruction that can take minutes. The number of the signal, however, is written to a
socket at any time. A thread waits for it, removes partial files and ends the process without the
interpreter's shutdown, which would wait for the compiler or crash in it.

Importing JAX takes seconds, too, so the package imports this module before it.
"""

import os
import signal
import socket
import threading
from collections.abc import Callable

from ._files import end_process

_MESSAGES = {signal.SIGINT: "stopped (Ctrl-C)", signal.SIGTERM: "terminated"}
#: Held by the thread that ends the process: the main thread with a result, or that of signals.
_ending = threading.Lock()
#: Set when the result is complete, so that a signal can no longer interrupt it.
_complete = threading.Event()
#: Functions that return a text to be written before the message, to clear the terminal.
_clearing: list[Callable[[], str]] = []
#: Both ends of the socket that announces signals; if it were closed, they would be lost.
_sockets: list[socket.socket] = []


def end_on_signals() -> None:
    """Make SIGINT and SIGTERM end the process with one line and exit status 130 or 143.

    A signal that is ignored (a job in the background of a script) stays ignored. Call it only in
    a process that is the command line, not in one that calls the command line.
    """
    if _sockets or threading.current_thread() is not threading.main_thread():
        return
    _open_standard_files()
    numbers = [n for n in _MESSAGES if signal.getsignal(n) is not signal.SIG_IGN]
    if not numbers:
        return
    reader, writer = socket.socketpair()
    writer.setblocking(False)
    _sockets.extend((reader, writer))
    signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    for number in numbers:
        # The number is announced only if Python has a handler.
        signal.signal(number, lambda *_: None)
    threading.Thread(target=_wait, args=(reader,), name="signals", daemon=True).start()


def _open_standard_files() -> None:
    """Open closed standard files as the null device, so that no other file gets their numbers.

    Printed text would go into that file.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            # Takes the lowest free number, which is this one.
            os.open(os.devnull, os.O_RDWR)


def clear_first(clear: Callable[[], str]) -> None:
    """Register a function whose text is written before the message of a signal.

    The text clears the line of progress on the terminal.
    """
    _clearing.append(clear)


def keep_result() -> None:
    """Declare the result complete: from now on a signal ends the process and removes nothing.

    Does not return if a signal is ending the process already.
    """
    with _ending:
        _complete.set()


def _wait(reader: socket.socket) -> None:
    while True:
        for number in reader.recv(64):
            if number in _MESSAGES:
                _end(number)


def _end(number: int) -> None:
    _ending.acquire()
    erase = "".join(clear() for clear in _clearing)
    try:
        os.write(2, f"{erase}prsm: {_MESSAGES[signal.Signals(number)]}\n".encode())
    finally:
        if _complete.is_set():
            os._exit(128 + number)
        end_process(128 + number)
