"""Load sharing among many threads and rollers, and whether what is found is a balance."""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from ..references.chains import HERTZ, SEGMENTS, TOOTH, shared

#: Load on one thread contact [N].
_EACH = 60.0


def _imbalance(first, second, gap, load: float) -> float:
    """Largest force and displacement that do not fit, over those of a mean thread.

    Loads of both sides (roller × thread) belong to a balance if every roller is pressed as hard by
    the screw as by the nut, if all together carry the load, and if the shafts that they compress
    leave between neighbouring threads just the difference of their approaches.
    """
    screw, roller, nut = SEGMENTS
    # A real shaft is shared by all rollers: its compliance counts for the sum.
    forces = [first.sum(1) - second.sum(1), np.array([first.sum(), second.sum()]) - load]
    wrong = max(float(np.max(np.abs(force))) for force in forces) / _EACH
    below = np.cumsum(first.sum(0))[:-1]
    of_screw = screw * (load - below)
    of_roller = roller * np.cumsum(first - second, axis=1)[:, :-1]
    of_nut = -nut * (second.sum() - np.cumsum(second.sum(0))[:-1])
    for loads, shaft in ((first, of_screw - of_roller), (second, of_roller - of_nut)):
        approach = HERTZ * loads ** (2 / 3) + TOOTH * loads + gap
        open_ = np.diff(approach, axis=1) + shaft
        pressed = (loads[:, 1:] > 0) & (loads[:, :-1] > 0)
        mean = HERTZ * _EACH ** (2 / 3)
        wrong = max(wrong, float(np.max(np.abs(np.where(pressed, open_, 0.0)))) / mean)
    return wrong


def sharing(threads: int, rollers: int):
    """A nut with so many threads on so many rollers, all unlike.

    **Returns:** the compiled function, its arguments, and the error of what it gives.
    """
    load = _EACH * threads * rollers
    gap = np.random.default_rng(60).normal(size=(rollers, threads)) * 2e-7

    @eqx.filter_jit
    def solve(load, gap) -> Any:
        chains, found = shared(load, gap, jnp.ones(rollers), 1e-12)
        first, _ = chains.screw.loads(found.state.screw_approach, 0.0)
        between = found.state.approach[None] - found.state.screw_approach
        second, _ = chains.nut.loads(between, 0.0)
        return first, second, found.result, found.steps

    inputs = jnp.asarray(load), jnp.asarray(gap)

    def error(found) -> float:
        first, second, result, _ = (np.asarray(x) for x in found)
        return float("nan") if int(result) else _imbalance(first, second, gap, load)

    return solve, inputs, error
