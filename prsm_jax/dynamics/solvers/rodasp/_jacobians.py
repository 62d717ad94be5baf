"""Jacobians of equations of motion, and the linear equation that derivatives of states follow.

In a chain the rate of a state depends on that state and on those after it. The Jacobian is then a
triangle, and linear equations with it are solved one state after the other.

A derivative z of the states follows `ż = J(t) z + g(t)`, the variational equation: J = ∂f/∂y along
the solution, and g the derivative of the rates at fixed states. Over a step it is integrated by
Lobatto's method IIIC with three nodes: of order 4, algebraically stable, and exact at the end of a
step for stiff states in balance (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II,
second edition, 1996, sections IV.5 and IV.12).
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ....fields import Scalar
from ....numerics import dot_few, solve_small

#: Shares of the step at which the linear equation needs J and g: nodes of Lobatto's method.
NODES = (0.0, 0.5, 1.0)
_MATRIX = ((1 / 6, -1 / 3, 1 / 6), (1 / 6, 5 / 12, -1 / 12), (1 / 6, 2 / 3, 1 / 6))


def _sum(values: Sequence[Scalar]) -> Scalar:
    return functools.reduce(jnp.add, values)


class ChainJacobian(NamedTuple):
    """∂f_i/∂y_j of a chain, which is zero where j < i."""

    #: The entries of each row from the diagonal on.
    rows: list[list[Scalar]]

    @property
    def diagonal(self) -> list[Scalar]:
        """∂f_i/∂y_i."""
        return [row[0] for row in self.rows]

    def after(self, index: int, later: Sequence[Scalar]) -> list[Scalar]:
        """Products of the entries of a row after the diagonal with as many numbers."""
        row = self.rows[index][1:]
        return [entry * value for entry, value in zip(row, later, strict=True)]

    def times(self, vector: Float[Array, " states"]) -> Float[Array, " states"]:
        """The product with a vector."""
        values = list(vector)
        products = [
            _sum([row[0] * values[k], *self.after(k, values[k + 1 :])])
            for k, row in enumerate(self.rows)
        ]
        return jnp.stack(products)

    def shifted_solve(
        self, shift: Scalar
    ) -> Callable[[Float[Array, " states"]], Float[Array, " states"]]:
        """A function that solves `(shift I − J) x = right`."""
        inverses = [1 / (shift - entry) for entry in self.diagonal]

        def solve(right: Float[Array, " states"]) -> Float[Array, " states"]:
            values = list(right)
            for k in reversed(range(len(values))):
                values[k] = _sum([values[k], *self.after(k, values[k + 1 :])]) * inverses[k]
            return jnp.stack(values)

        return solve


class FullJacobian(NamedTuple):
    """∂f_i/∂y_j of any states."""

    matrix: Float[Array, "states states"]

    @property
    def diagonal(self) -> list[Scalar]:
        """∂f_i/∂y_i."""
        return [self.matrix[k, k] for k in range(self.matrix.shape[0])]

    def times(self, vector: Float[Array, " states"]) -> Float[Array, " states"]:
        """The product with a vector."""
        return dot_few(self.matrix, vector)

    def shifted_solve(
        self, shift: Scalar
    ) -> Callable[[Float[Array, " states"]], Float[Array, " states"]]:
        """A function that solves `(shift I − J) x = right`."""
        identity = jnp.eye(self.matrix.shape[0], dtype=self.matrix.dtype)
        return solve_small(identity * shift - self.matrix)


def full_jacobian(
    rate: Callable[[Float[Array, " states"]], Float[Array, " states"]],
    state: Float[Array, " states"],
) -> FullJacobian:
    """The Jacobian of a function of the states at one instant."""
    directions = jnp.eye(state.size, dtype=state.dtype)
    return FullJacobian(
        jax.vmap(lambda one: jax.jvp(rate, (state,), (one,))[1], out_axes=-1)(directions)
    )


def chain_jacobian(
    chain: Callable[[Any, Sequence[Scalar], Any], Sequence[Scalar]],
    drive: Any,
    state: Sequence[Scalar],
    args: Any,
) -> ChainJacobian:
    """The Jacobian of a chain at one instant.

    **Arguments:**

    - `chain`: function of (drive, states, args) to the rates, as in `DrivenRate`.
    """
    columns: list[Sequence[Scalar]] = []
    for k, value in enumerate(state):

        def along(value, k=k):
            return chain(drive, [*state[:k], value, *state[k + 1 :]], args)[: k + 1]

        columns.append(jax.jvp(along, (value,), (jnp.ones_like(value),))[1])
    count = len(state)
    return ChainJacobian([[columns[j][i] for j in range(i, count)] for i in range(count)])


def _own_rates(jacobians: Sequence[ChainJacobian], index: int, length: Scalar) -> list[Scalar]:
    """`h ∂f_i/∂y_i` at the nodes, at most 1; in the middle at most 0 between damped ends.

    With faster growth inside a step the equations of the method can be singular. Steps with such
    growth at their start are rejected; growth that begins within a step has no such check.
    """
    first, middle, last = (length * jacobian.rows[index][0] for jacobian in jacobians)
    damped = jnp.minimum(first, 0.0) * jnp.minimum(last, 0.0) > 1.0
    most = jnp.where(damped, 0.0, 1.0)
    return [jnp.minimum(first, 1.0), jnp.minimum(middle, most), jnp.minimum(last, 1.0)]


def node_inverses(jacobians: Sequence[ChainJacobian], length: Scalar) -> list[list[list[Scalar]]]:
    """For each state, the inverse of `I − h diag(J) A` at the nodes of Lobatto's method.

    **Arguments:**

    - `jacobians`: J at the nodes.
    - `length`: h.
    """
    nodes = range(len(NODES))
    inverses = []
    for k in range(len(jacobians[0].rows)):
        rates = _own_rates(jacobians, k, length)
        m = [[(1.0 if i == j else 0.0) - _MATRIX[i][j] * rates[i] for j in nodes] for i in nodes]
        # By cofactors, with one division.
        cofactors = [
            [
                m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3]
                - m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3]
                for i in nodes
            ]
            for j in nodes
        ]
        factor = 1 / _sum([m[0][j] * cofactors[j][0] for j in nodes])
        inverses.append([[factor * entry for entry in row] for row in cofactors])
    return inverses


def node_slopes(
    jacobians: Sequence[ChainJacobian],
    inverses: Sequence[Sequence[Sequence[Scalar]]],
    forcing: Sequence[Sequence[Scalar]],
    length: Scalar,
    start: Sequence[Scalar],
) -> list[list[Scalar]]:
    """`h ż` at the nodes of a step of Lobatto's method: for each state, three numbers.

    **Arguments:**

    - `jacobians`, `inverses`: J at the nodes, and the result of `node_inverses`.
    - `forcing`: `h g` at the nodes, for each state.
    - `length`: h.
    - `start`: z at the start of the step.
    """
    nodes = range(len(NODES))
    # h ż of the states from the last on, and for each node z of them in order.
    slopes: list[list[Scalar]] = []
    later: list[list[Scalar]] = [[] for _ in nodes]
    for k in reversed(range(len(start))):
        right = [
            given[k] + own * start[k] + sum(length * other for other in jacobian.after(k, rest))
            for given, own, jacobian, rest in zip(
                forcing, _own_rates(jacobians, k, length), jacobians, later, strict=True
            )
        ]
        found = [_sum([row[j] * right[j] for j in nodes]) for row in inverses[k]]
        slopes.append(found)
        if k > 0:
            values = [start[k] + _sum([_MATRIX[i][j] * found[j] for j in nodes]) for i in nodes]
            later = [[value, *rest] for value, rest in zip(values, later, strict=True)]
    return slopes[::-1]


__all__ = [
    "NODES",
    "ChainJacobian",
    "FullJacobian",
    "chain_jacobian",
    "full_jacobian",
    "node_inverses",
    "node_slopes",
]
