"""Stored programs of verbs, announced on the progress line."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax

from ..mechanism import Mechanism
from ..programs import has_stored, run_stored as run_kept
from ._plugins import has_plugins
from ._progress import expect_programs


def run_stored(
    name: str,
    function: Callable[..., Any],
    mechanism: Mechanism,
    *more: jax.Array,
    announced: bool = False,
) -> Any:
    """Evaluate `function(mechanism, *more)` compiled, keeping the program for the next run.

    **Arguments:**

    - `name`: names the function in the key.
    - `function`: a pure function of the mechanism and arrays.
    - `mechanism`: the mechanism.
    - `more`: arrays.
    - `announced`: whether the progress line counts the program already.
    """
    # Results of a plugin depend on its own files, which are not part of the key.
    if has_plugins():
        return eqx.filter_jit(function)(mechanism, *more)
    if not (announced or has_stored(name, mechanism, *more)):
        expect_programs("call")
    return run_kept(name, function, mechanism, *more)
