"""Settings of a process that is `prsm` itself, made before JAX is imported."""

import gc
import importlib.metadata
import os
import sys
from pathlib import Path

from ._interrupt import end_on_signals


def _is_command_line() -> bool:
    """Whether this process was started as `prsm` or `python -m prsm_jax`."""
    name = Path(sys.argv[0]).stem if sys.argv else ""
    return name == "prsm" or (name == "-m" and "prsm_jax" in sys.orig_argv)


def own_command() -> list[str]:
    """Words after `prsm` if this process was started as `prsm`; none in any other process."""
    return list(sys.argv[1:]) if _is_command_line() else []


#: Verbs whose programs run once or a few times, each in milliseconds.
_BRIEF_VERBS = frozenset(
    (
        *("campbell", "check", "contact", "explain", "modal", "response", "sensitivity"),
        *("steady", "strength"),
    )
)


def _compiler_flags() -> str:
    """Flags of XLA's CPU compiler for programs that run once or a few times.

    Its older code generator for fused loops compiles in two thirds of the time, and its code runs
    as fast here (sweeps, optimisations). JAX 0.10 is the last that is known to have it; a flag
    that the compiler does not know would end the process.

    For verbs that analyse one design, a program runs for a millisecond and compiles for seconds:
    code that is not optimised, in one piece, takes half to three quarters of the time, running
    included. Sweeps, searches and transients keep optimised code.
    """
    flags = []
    version = importlib.metadata.version("jaxlib").split(".")[:2]
    if tuple(int(part) for part in version) <= (0, 10):
        flags.append("--xla_cpu_use_fusion_emitters=false")
    if sys.argv[1:] and sys.argv[1] in _BRIEF_VERBS:
        flags.append("--xla_backend_optimization_level=0")
        flags.append("--xla_cpu_parallel_codegen_split_count=1")
    return " ".join(flags)


if _is_command_line():
    end_on_signals()
    # Modules and traces are millions of objects that live until the end: looking through them for
    # cycles every few hundred allocations is a tenth of the time of a verb.
    gc.set_threshold(100_000, 20, 50)
    # Read when equinox is imported. Impossible sample times give NaN, not an exception from inside
    # a program: JAX does not store a program that calls Python for the next run.
    os.environ.setdefault("EQX_ON_ERROR", "nan")
    # Read when JAX is imported. XLA logs an alarm ("Very slow compile?") when a compilation takes
    # minutes, which the progress line shows anyway; failures still raise exceptions.
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    if sys.argv[1:] and sys.argv[1] in _BRIEF_VERBS:
        # pint imports dask where it finds it, which takes a tenth of the time of such a verb. Only
        # sweeps use dask.
        sys.modules.setdefault("dask", None)  # type: ignore[arg-type]
    # If a flag occurs twice, the last one counts: the user's.
    os.environ["XLA_FLAGS"] = f"{_compiler_flags()} {os.environ.get('XLA_FLAGS', '')}".strip()
