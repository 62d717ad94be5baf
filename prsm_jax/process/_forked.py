"""A forked process that cannot calculate raises an error instead of waiting for ever.

A fork copies no threads, and JAX's backend uses threads: a calculation in the child would wait for
threads that do not exist. In the child of a process that has calculated, every operation of JAX
therefore fails with one line that names the remedy. A child that only starts a program, or that was
forked before the first calculation, is not affected.
"""

import os
from typing import Any, NoReturn

from .._errors import PrsmError

_REASON = (
    "this process was forked after JAX had calculated, and has none of its threads: it would wait "
    "for ever. Start processes with multiprocessing.get_context('spawn'), or fork before the first "
    "calculation"
)


def _refuse(*args: Any, **options: Any) -> NoReturn:
    raise PrsmError(_REASON)


def _in_child() -> None:
    """Make every operation of JAX in this process raise the error.

    JAX uses the current trace for operations, and to look up compiled programs. A trace that
    refuses everything therefore stops compiled programs, too, and no other can be entered. None of
    this is public; in a version of JAX that differs, only its own warning at the fork remains.
    """
    try:
        from jax._src import config, core, xla_bridge

        older: Any = config
        if not xla_bridge.backends_are_initialized():
            return
        names = ("process_primitive", "process_call", "stage_value")
        names += ("process_custom_jvp_call", "process_custom_vjp_call")
        refusing = type("RefusingTrace", (core.Trace,), dict.fromkeys(names, _refuse))()
        core.trace_ctx.set_trace(refusing)
        # Other threads of the child use it unless they have set their own.
        if hasattr(core, "trace_state_strong_ref"):
            core.trace_state.set_global(refusing._weakref)  # pyright: ignore[reportPrivateUsage]
            core.trace_state_strong_ref.set_global(refusing)
        else:  # JAX 0.7
            older.trace_state.set_global(refusing._weakref)  # pyright: ignore[reportPrivateUsage]
            setattr(core.TracingContext, "trace", property(lambda _: refusing, _refuse))  # noqa: B010
        core.TracingContext.set_trace = _refuse
    except (ImportError, AttributeError):
        return


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_in_child)
