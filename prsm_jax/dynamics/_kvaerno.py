"""The implicit Runge–Kutta method of Kvaerno, 5th order with an embedded 4th, for diffrax.

Its tableau, interpolation and steps are those of `diffrax.Kvaerno5`. The stages are solved by this
package's own Newton iteration, in values and in derivatives: the linear solves of diffrax go to
LAPACK, whose batched calls deadlock between threads of one process.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from collections.abc import Callable
from typing import ClassVar

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array

from ._small_newton import find_roots

_TABLEAU = diffrax.Kvaerno5.tableau
_STAGES = len(_TABLEAU.b_sol)
assert _TABLEAU.a_diagonal is not None
_GAMMA = float(_TABLEAU.a_diagonal[-1])
#: Weights of the stages before, a row for each implicit stage.
_BEFORE = np.zeros((_STAGES - 1, _STAGES))
for _row, _weights in enumerate(_TABLEAU.a_lower):
    _BEFORE[_row, : len(_weights)] = _weights
#: Newton steps in a stage; a step that needs more is taken again, and shorter.
_MOST_ITERATIONS = 10


class Kvaerno(diffrax.AbstractAdaptiveSolver):
    """Kvaerno 5/4 with Newton's iteration in every stage, for problems with few states.

    `tolerance` is that of the last change of a stage beside one, and increments of a step may be
    far smaller than one: it has to be well below the tolerance of the step.
    """

    tolerance: float | Array

    term_structure: ClassVar = diffrax.AbstractTerm
    interpolation_cls: ClassVar[Callable] = diffrax.ThirdOrderHermitePolynomialInterpolation.from_k

    def order(self, terms) -> int:
        return 5

    def init(self, terms, t0, t1, y0, args) -> None:
        return None

    def func(self, terms, t0, y0, args):
        return terms.vf(t0, y0, args)

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        flat, unflatten = ravel_pytree(y0)
        length, dtype = t1 - t0, flat.dtype
        least = 100 * float(jnp.finfo(dtype).eps)
        tolerance = jnp.maximum(jnp.asarray(self.tolerance, dtype), least)

        def rate(time, state):
            return ravel_pytree(terms.vf(time, unflatten(state), args))[0]

        def stage(carry, row):
            stages, index, converged = carry
            weights, share = row
            point, time = flat + weights @ stages, t0 + share * length
            found, settled = find_roots(
                lambda k: k - length * rate(time, point + _GAMMA * k),
                stages[index],
                tolerance=tolerance,
                max_steps=_MOST_ITERATIONS,
            )
            return (stages.at[index + 1].set(found), index + 1, converged & settled), None

        stages = jnp.zeros((_STAGES, flat.size), dtype).at[0].set(length * rate(t0, flat))
        rows = (jnp.asarray(_BEFORE, dtype), jnp.asarray(_TABLEAU.c, dtype))
        start = (stages, 0, jnp.asarray(True))
        (stages, _, converged), _ = jax.lax.scan(stage, start, rows)
        end = unflatten(flat + jnp.asarray(_TABLEAU.b_sol, dtype) @ stages)
        error = jnp.asarray(_TABLEAU.b_error, dtype) @ stages
        slopes = jax.vmap(unflatten)(stages[jnp.array([0, -1])])
        dense = {"y0": y0, "y1": end, "k": slopes}
        # A stage without a root: the step is rejected.
        error = unflatten(jnp.where(converged, error, jnp.inf))
        return end, error, dense, None, diffrax.RESULTS.successful


__all__ = ["Kvaerno"]
