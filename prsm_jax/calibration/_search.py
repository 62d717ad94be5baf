"""The search of a calibration: Levenberg–Marquardt that ends where rounding ends it."""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Bool


class Search(optx.LevenbergMarquardt[Array, Array, Any]):
    """As in optimistix; also ends after a refused step as short as its tolerance.

    A shorter one follows a refused step. At an optimum the decrease of the sum of squares can be
    less than its rounding: all further steps are then refused.
    """

    def __init__(self, tolerance: float):
        super().__init__(rtol=tolerance, atol=tolerance)

    def step(self, fn, y, args, options, state, tags):
        """One step."""
        after, new, aux = super().step(fn, y, args, options, state, tags)
        short = jnp.abs(state.y_eval - y) < self.atol + self.rtol * jnp.abs(y)
        ended = new.terminate | (short.all() & (new.num_steps_since_acceptance > 0))
        return after, eqx.tree_at(lambda one: one.terminate, new, ended), aux


def ended_by_itself(solution: optx.Solution[Any, Any]) -> Bool[Array, ""]:
    """Whether the last step was accepted, and changed numbers and residuals by the tolerance."""
    successful = solution.result == optx.RESULTS.successful
    return successful & (solution.state.num_steps_since_acceptance == 0)
