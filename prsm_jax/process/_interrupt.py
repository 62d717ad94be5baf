"""Ctrl-C: the process ends at once, whatever compiled code is doing, and leaves nothing behind.

Python runs its own signal handlers between two of its instructions, and compiling or running a
program is one instruction of minutes. What reaches the process at any time is the number of the
signal in a socket, which a thread waits for; it removes what is half written and ends the process,
without the interpreter's shutdown, which would wait for the compiler or crash in it.

Importing JAX takes seconds, too, so the package imports this module before it.
"""

import os
import signal
import socket
import threading
from collections.abc import Callable

from ._files import end_process

_MESSAGES = {signal.SIGINT: "stopped (Ctrl-C)", signal.SIGTERM: "terminated"}
#: Held by whoever ends the process: the main thread with a result, or a signal without one.
_ending = threading.Lock()
#: Set where there is nothing any more that a signal could cut in two.
_complete = threading.Event()
#: What clears the terminal: gives the text to be written before the message.
_clearing: list[Callable[[], str]] = []
#: Both ends of the socket that signals are announced in; closed, they would be lost.
_sockets: list[socket.socket] = []


def end_on_signals() -> None:
    """From now on SIGINT and SIGTERM end the process with one line and exit status 130 or 143.

    A signal that is ignored (a job in the background of a script) stays ignored. Only for a process
    that is the command line, not for one that calls it.
    """
    if _sockets or threading.current_thread() is not threading.main_thread():
        return
    _open_standard_files()
    wanted = [n for n in _MESSAGES if signal.getsignal(n) is not signal.SIG_IGN]
    if not wanted:
        return
    reader, writer = socket.socketpair()
    writer.setblocking(False)
    _sockets.extend((reader, writer))
    signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    for number in wanted:
        # A handler of Python's own has to be there for the number to be announced.
        signal.signal(number, lambda *_: None)
    threading.Thread(target=_wait, args=(reader,), name="signals", daemon=True).start()


def _open_standard_files() -> None:
    """Open what the caller closed as the null device, so that no other file takes its number.

    What is printed would go into that file.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            # The lowest number that is free: those below are taken.
            os.open(os.devnull, os.O_RDWR)


def clear_first(clear: Callable[[], str]) -> None:
    """Have this function's text written before the message, to clear the terminal."""
    _clearing.append(clear)


def keep_result() -> None:
    """The result is complete: from now on a signal ends the process and removes nothing.

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
