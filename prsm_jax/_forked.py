"""A process that was forked while JAX was running gets an error instead of waiting for ever.

`fork` copies the memory of a process but only one of its threads. A calculation in the copy waits
for JAX's other threads, which are not there. `multiprocessing` forks by default on Linux up to
Python 3.13.
"""

import os
import sys

import jax

_MESSAGE = (
    "this process was forked from one in which JAX was running, so its calculations would wait for "
    "threads that do not exist here; start processes with "
    'multiprocessing.get_context("spawn"), or fork before anything is calculated'
)
#: Whether JAX was running at the last fork, and whether this process is the copy.
_state = {"running": False, "forked": False}


def _before() -> None:
    # Asked in the parent: its lock might be held, for good, in the copy.
    bridge = sys.modules.get("jax._src.xla_bridge")
    started = getattr(bridge, "backends_are_initialized", None)
    _state["running"] = True if started is None else bool(started())


def _in_child() -> None:
    if _state["running"]:
        _state["forked"] = True
        # Programs that the parent compiled are traced again, and meet the error.
        jax.config.update("jax_disable_jit", True)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before, after_in_child=_in_child)


def refuse_forked() -> None:
    """Called whenever a law is traced, which every calculation does first.

    **Raises:** `RuntimeError` in a process that was forked while JAX was running.
    """
    if _state["forked"]:
        raise RuntimeError(_MESSAGE)
