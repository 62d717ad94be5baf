"""A process that runs one verb and ends: what it does beside, in other threads."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, ParamSpec, TypeVar

_Params = ParamSpec("_Params")
_Return = TypeVar("_Return")

_one_verb = False
_begun: list[Future[Any]] = []
_while_compiling: list[Callable[[], None]] = []


def run_one_verb() -> None:
    """Declare that this process runs one verb and ends, on code of this package alone.

    It then reads programs that an earlier process has compiled instead of tracing its own, and
    compiles in several threads.
    """
    global _one_verb
    _one_verb = True


def runs_one_verb() -> bool:
    """Whether this process runs one verb and ends; stored programs are then faster.

    A process that runs longer reuses the programs that it has traced itself.
    """
    return _one_verb


def beside(
    function: Callable[_Params, _Return], *args: _Params.args, **kwargs: _Params.kwargs
) -> Callable[[], _Return]:
    """Begin a calculation in another thread, beside the work of this one.

    It saves time where both compile, since the compiler works outside Python. Only in a process
    that runs one verb; elsewhere the calculation is made when its result is asked for.

    **Arguments:**

    - `function`, `args`, `kwargs`: the calculation; it must not change what others use.

    **Returns:** a function that waits for the result; it raises what the calculation raises.
    """
    if not runs_one_verb():
        return lambda: function(*args, **kwargs)
    return begun(lambda: function(*args, **kwargs)).result


def begun(function: Callable[[], _Return]) -> Future[_Return]:
    """The future result of a function that runs in another thread from now on."""
    found: Future[_Return] = Future()
    _begun.append(found)

    def work() -> None:
        try:
            found.set_result(function())
        except BaseException as error:
            # Raised again where the result is needed.
            found.set_exception(error)

    threading.Thread(target=work, name="beside", daemon=True).start()
    return found


def while_compiling(begin: Callable[[], None]) -> None:
    """Call a function when the first program of this process has been traced.

    What it begins in another thread is traced while the compiler, which works outside Python, is
    busy with the first program. Only in a process that runs one verb; where all programs are read
    from files it is not called.

    **Arguments:**

    - `begin`: begins the work and returns at once.
    """
    if runs_one_verb():
        _while_compiling.append(begin)


def compiler_begins() -> None:
    """Begin what `while_compiling` has been told."""
    while _while_compiling:
        _while_compiling.pop()()


def works_beside() -> bool:
    """Whether another thread is at work; Python must not end meanwhile."""
    return not all(found.done() for found in _begun)
