"""Base classes of our own solvers, and of their interpolations.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from abc import abstractmethod
from typing import Any, ClassVar

import diffrax
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PyTree

from ...fields import Scalar


class StepInterpolation(diffrax.AbstractLocalInterpolation):
    """States between the ends of one step."""

    t0: Float[Array, ""]  # pyright: ignore[reportIncompatibleVariableOverride]
    t1: Float[Array, ""]  # pyright: ignore[reportIncompatibleVariableOverride]
    y0: PyTree
    y1: PyTree

    @abstractmethod
    def at_share(self, share: Scalar) -> PyTree:
        """The solution at a share of the step, from 0 to 1."""

    def evaluate(self, t0, t1=None, left: bool = True):
        """The solution at `t0`, or its increment from `t0` to `t1`."""
        if t1 is not None:
            return jax.tree.map(lambda b, a: b - a, self.evaluate(t1), self.evaluate(t0))
        length = self.t1 - self.t0
        # diffrax makes a step of zero length before the first one.
        share = jnp.where(length > 0, (t0 - self.t0) / jnp.where(length > 0, length, 1.0), 0.0)
        return self.at_share(share)

    def at_all(self, times: Float[Array, " times"]) -> PyTree:
        """The solution at several times: for each array, a list of the values of its numbers."""
        length = self.t1 - self.t0
        inverse = 1 / jnp.where(length > 0, length, 1.0)
        # The state at the end of the step is known, without the rounding of the share.
        return self._at_shares(jnp.where(times == self.t1, 1.0, (times - self.t0) * inverse))

    def _at_shares(self, shares: Float[Array, " times"]) -> PyTree:
        return jax.tree.map(
            lambda x: list(x.reshape(-1, shares.size)),
            jax.vmap(self.at_share, out_axes=-1)(shares),
        )


class OneStep(diffrax.AbstractAdaptiveSolver[Any]):
    """A solver without memory from one step to the next."""

    term_structure: ClassVar = diffrax.AbstractTerm

    def init(self, terms, t0, t1, y0, args) -> None:
        return None

    def func(self, terms, t0, y0, args):
        return terms.vf(t0, y0, args)


__all__ = ["OneStep", "StepInterpolation"]
