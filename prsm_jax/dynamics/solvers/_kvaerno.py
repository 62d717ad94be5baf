"""Kvaerno's implicit method of order 5(4), its stages by Newton's iteration in plain JAX.

The tableau is that of diffrax. The stages of diffrax call LAPACK, and so do their derivatives with
any solver for the root finder; batched LAPACK calls from several Python threads deadlock. Here all
systems are solved by elimination with partial pivoting and a step of refinement, without which
carriers a million times heavier than others leave few digits.

A. Kværnø, Singly diagonally implicit Runge–Kutta methods with an explicit first stage, BIT 44
(2004). Imports diffrax, so it is itself imported only where something is integrated.
"""

from collections.abc import Callable
from typing import Any, ClassVar

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import PyTree

from ...fields import Scalar
from ...numerics import all_few, dot_few, solver
from ._dense_output import OneStep, StepInterpolation

_TABLEAU: Any = diffrax.Kvaerno5.tableau
_STAGES = 7
_GAMMA = float(_TABLEAU.a_diagonal[1])
_MOST_ITERATIONS = 10
#: Change at which an iteration stops, over the step tolerance; the next change would be its square.
_SETTLED = 1e-2
#: Change at which it stops in any case, over the rounding of a state.
_ROUNDINGS = 4


def _padded(rows) -> np.ndarray:
    table = np.zeros((_STAGES - 1, _STAGES))
    for index, row in enumerate(rows):
        table[index, : len(row)] = row
    return table


_WEIGHTS, _PREDICTED = _padded(_TABLEAU.a_lower), _padded(_TABLEAU.a_predictor)


def _dense_weights() -> np.ndarray:
    """Weights of the stages by powers of the share θ of a step: row j is that of θ^(j + 1).

    The second stage is of lower order and has none. Those of the others integrate quartics exactly,
    which is order 4 (slopes are known to third order), and keep their sum finite for a state that
    decays within the step: there the slopes grow with `h λ`. For large `h λ` the cubic with
    the values and slopes of both ends has an error of 4/27 `h λ` times the state at the start of
    the step, at a third of the step; these weights have an error of at most 6.7 times that state.
    At θ = 1 they are those of the method.
    """
    known = np.array([0, 2, 3, 4, 5, 6])
    times = np.concatenate([[0.0], _TABLEAU.c])
    table = _WEIGHTS.copy()
    table[:, 1:] += _GAMMA * np.eye(_STAGES - 1)
    # Slopes over `h λ` in the limit of large `h λ`, where the states of the stages vanish.
    growing = np.concatenate([[1.0], -np.linalg.solve(table[:, 1:], table[:, 0])])
    powers = np.vander(times[known], 5, increasing=True).T
    integrals = np.concatenate([np.diag(1 / np.arange(1.0, 6.0)), np.zeros((1, 5))])
    weights = np.zeros((5, _STAGES))
    weights[:, known] = np.linalg.solve(np.vstack([powers, growing[known]]), integrals).T
    return weights


_DENSE = _dense_weights()


class KvaernoInterpolation(StepInterpolation):
    """Between two steps: `y₀ + s (c₁ + s (c₂ + …))`, locally of order 5."""

    #: c₁ to c₅ along the first axis.
    powers: PyTree

    def at_share(self, share: Scalar) -> PyTree:
        def at(y0, y1, powers):
            total = powers[-1]
            for power in powers[-2::-1]:
                total = power + share * total
            # Exactly the end, without the rounding of the weights.
            return jnp.where(share == 1, y1, y0 + share * total)

        return jax.tree.map(at, self.y0, self.y1, self.powers)


def _refined(matrix):
    """A function that solves with a matrix, with one step of iterative refinement."""
    solve = solver(matrix)

    def solved(right):
        first = solve(right)
        return first + solve(right - dot_few(matrix, first))

    return solved


class Kvaerno(OneStep):
    """Kvaerno 5(4): A-L-stable, stiffly accurate, dense output of order 4.

    A stage whose iteration does not converge makes the error of its step infinite, so that the step
    is repeated, shorter.
    """

    #: Tolerances of a step.
    rtol: float | Scalar
    atol: float | Scalar

    interpolation_cls: ClassVar[Callable[..., KvaernoInterpolation]] = KvaernoInterpolation

    def order(self, terms) -> int:
        return 5

    def _stage(self, rate, length, time, known, guess):
        """k with `k = f(t, known + γ h k)`, and whether the iteration converged."""

        def residual(k):
            return k - rate(time, known + _GAMMA * length * k)

        def search(function, start):
            def advance(carry):
                k, _, count = carry
                change = _refined(jax.jacfwd(function)(k))(function(k))
                k = k - change
                size = jnp.abs(known + _GAMMA * length * k)
                allowed = _SETTLED * (self.atol + self.rtol * size)
                allowed = jnp.maximum(allowed, _ROUNDINGS * jnp.finfo(k.dtype).eps * size)
                small = jnp.abs(_GAMMA * length * change) <= allowed
                return k, all_few(small), count + 1

            def goes_on(carry):
                _, settled, count = carry
                return jnp.logical_not(settled) & (count < _MOST_ITERATIONS)

            first = (start, jnp.asarray(False), jnp.asarray(0))
            k, settled, _ = jax.lax.while_loop(goes_on, advance, first)
            return k, settled.astype(start.dtype)

        def solve_linear(linear, right):
            identity = jnp.eye(len(right), dtype=right.dtype)
            return _refined(jax.vmap(linear, out_axes=1)(identity))(right)

        return jax.lax.custom_root(residual, guess, search, solve_linear, has_aux=True)

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        flat, unflatten = ravel_pytree(y0)
        length = t1 - t0

        def rate(time, state):
            return ravel_pytree(terms.vf(time, unflatten(state), args))[0]

        def stage(carry, row):
            slopes, index, converged = carry
            weights, predicted, share = row
            # Exactly the end, without rounding: a jump at the end has not happened yet.
            time = jnp.where(share == 1, t1, t0 + share * length)
            known = flat + length * (weights @ slopes)
            guess = jax.lax.stop_gradient(predicted @ slopes)
            slope, settled = self._stage(rate, length, time, known, guess)
            return (slopes.at[index].set(slope), index + 1, converged & (settled > 0.5)), None

        slopes = jnp.zeros((_STAGES, flat.size), flat.dtype).at[0].set(rate(t0, flat))
        rows = tuple(jnp.asarray(x, flat.dtype) for x in (_WEIGHTS, _PREDICTED, _TABLEAU.c))
        (slopes, _, converged), _ = jax.lax.scan(stage, (slopes, 1, jnp.asarray(True)), rows)
        end = unflatten(flat + length * (jnp.asarray(_TABLEAU.b_sol, flat.dtype) @ slopes))
        error = length * (jnp.asarray(_TABLEAU.b_error, flat.dtype) @ slopes)
        error = unflatten(jnp.where(converged, jnp.abs(error), jnp.inf))
        powers: Any = length * (jnp.asarray(_DENSE, flat.dtype) @ slopes)
        powers = jax.vmap(unflatten)(powers)
        dense = {"y0": y0, "y1": end, "powers": powers}
        return end, error, dense, None, diffrax.RESULTS.successful


__all__ = ["Kvaerno", "KvaernoInterpolation"]
