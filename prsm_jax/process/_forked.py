"""A forked process that cannot calculate says so, instead of waiting for ever.

A fork copies no threads, and JAX's backend is made of them: what it starts in the child waits for
threads that are not there. So in the child of a process that has calculated, every operation of
JAX fails with one line that names the remedy. A child that only starts a program, or that was
forked before anything was calculated, does not notice.
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
    """Have everything that JAX could do in this process raise the error.

    JAX asks for the current trace, and looks up compiled programs by it: a trace that refuses all
    reaches compiled programs as well, and no other can be entered. None of this is public; where it
    is not as it was, JAX's own warning at the fork remains.
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
        # Other threads of the child find it where they have not set one themselves.
        if hasattr(core, "trace_state_strong_ref"):
            core.trace_state.set_global(refusing._weakref)
            core.trace_state_strong_ref.set_global(refusing)
        else:  # JAX 0.7
            older.trace_state.set_global(refusing._weakref)
            setattr(core.TracingContext, "trace", property(lambda _: refusing, _refuse))  # noqa: B010
        core.TracingContext.set_trace = _refuse
    except (ImportError, AttributeError):
        return


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_in_child)
