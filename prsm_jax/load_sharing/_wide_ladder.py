"""Linear response of chains with many classes of rollers, with a batch of them side by side.

The elimination of `_ladder`, for matrices too large to be written out number by number. A segment
in series is taken port by port: compliance γ in port j turns f = A q + p into

`A ← A − γ a aᵀ/(1 + γ a_j)`, `p ← p − a (γ p_j + z_j)/(1 + γ a_j)`,

a the column j of A and z the closing of the mesh, and what is below follows from what is above by
the same updates of a matrix that starts as unity. Each of them is one sweep over all numbers.
Problems that are solved at once lie side by side in the last axis, so that a sweep runs along them
whatever the number of rollers is.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap
from jaxtyping import Array, Float

Column = Float[Array, "size rights batch"]

#: Up to here what is done row by row is written out; beyond, the program would grow with the
#: number of rollers, and the time to compile it faster still.
_WRITTEN_OUT = 16


class Ladder(NamedTuple):
    """Springs and right-hand sides thread by thread; all with the batch as their last axis."""

    #: Slopes of all rollers of a class, screw and nut side [N/m].
    screw: Float[Array, "threads classes batch"]
    nut: Float[Array, "threads classes batch"]
    #: Compliances of roller classes and nut, and of the screw that all of them share [m/N].
    gamma: Float[Array, "segments size batch"]
    segment: Float[Array, "segments batch"]
    #: Right-hand sides: forces on (d₁ …, D), and closing of the meshes.
    forces: Float[Array, "threads size rights batch"]
    meshes: Float[Array, "segments size rights batch"]


def _times(matrix, column: Column) -> Column:
    if len(column) > _WRITTEN_OUT:

        def add(k, total):
            return total + _row(matrix, k, 1)[:, None] * _row(column, k)[None]

        return jax.lax.fori_loop(0, len(column), add, jnp.zeros_like(column))
    terms = [matrix[:, k, None] * column[k][None] for k in range(matrix.shape[1])]
    return sum(terms[1:], terms[0])


def _row(matrix, k, axis: int = 0):
    return jax.lax.dynamic_index_in_dim(matrix, k, axis, keepdims=False)


def _thread(screw, nut):
    """Stiffness matrix of one thread on (d₁ …, D)."""
    count = screw.shape[0]
    unit = jnp.eye(count, dtype=screw.dtype)[:, :, None]
    inner = unit * (screw + nut)[:, None]
    below = jnp.concatenate([-nut, jnp.sum(nut, axis=0, keepdims=True)])
    beside = jnp.concatenate([inner, -nut[:, None]], axis=1)
    return jnp.concatenate([beside, below[None]], axis=0)


def _series(matrix, carried: Column, mesh: Column, gamma, segment):
    """Stiffness and force as seen across a segment; and what is below it from what is above."""
    size = matrix.shape[0]
    unit = jnp.broadcast_to(jnp.eye(size, dtype=matrix.dtype)[:, :, None], matrix.shape)
    above = jnp.concatenate([matrix, carried], axis=1)
    whole = jnp.concatenate([above, jnp.concatenate([unit, jnp.zeros_like(carried)], axis=1)])
    opened = jnp.concatenate([jnp.zeros_like(matrix), mesh], axis=1)
    rows, columns = jnp.arange(2 * size)[:, None, None], jnp.arange(whole.shape[1])[None, :, None]

    def port(j, whole):
        row, column = _row(whole, j), _row(whole, j, 1)
        compliance, gap, own = _row(gamma, j), _row(opened, j), _row(row, j)
        divisor = 1 / (1 + compliance * own)
        taken = divisor[None] * (compliance[None] * row + gap)
        # What would be a difference of two like numbers in the port's own row and column.
        kept = divisor[None] * (row - own[None] * gap)
        changed = whole - column[:, None] * taken[None]
        changed = jnp.where(columns == j, whole * divisor[None, None], changed)
        return jnp.where(rows == j, kept[None], changed)

    # Written out, sweeps would become one that does the others again for each number it needs.
    whole = jax.lax.fori_loop(0, size, port, whole)
    row, column = jnp.sum(whole[:size], axis=0), jnp.sum(whole[:, :size], axis=1)
    share = segment / (1 + segment * jnp.sum(row[:size], axis=0))
    whole = whole - (share[None] * column)[:, None] * row[None]
    return whole[:size, :size], whole[:size, size:], whole[size:, :size], whole[size:, size:]


def gauss_jordan(matrix, column):
    """Solve `matrix @ x = column` without pivoting; behind both axes there may be a batch."""
    size = matrix.shape[0]
    whole = jnp.concatenate([matrix, column], axis=1)
    rows = jnp.arange(size).reshape((-1, *(1,) * (whole.ndim - 1)))

    def pivot(k, whole):
        row = _row(whole, k)
        row = row / _row(row, k)[None]
        return jnp.where(rows == k, row[None], whole - _row(whole, k, 1)[:, None] * row[None])

    if size > _WRITTEN_OUT:
        return jax.lax.fori_loop(0, size, pivot, whole)[:, size:]
    for k in range(size):
        whole = pivot(k, whole)
    return whole[:, size:]


@custom_vmap
def eliminate(ladder: Ladder) -> tuple[Array, Array]:
    """Changes (d₁ …, D) of every thread, and of the forces in (R₁ …, N) above all but the last.

    Both are thread, number, right-hand side, batch.
    """
    size = ladder.gamma.shape[1]
    matrix = jnp.zeros((size, size, ladder.segment.shape[-1]), ladder.gamma.dtype)
    carried = jnp.zeros_like(ladder.forces[0])

    def joined(matrix, carried, screw, nut, force):
        return matrix + _thread(screw, nut), carried - force

    def up(below, thread):
        screw, nut, force, mesh, gamma, segment = thread
        matrix, carried = joined(below[0], below[1], screw, nut, force)
        reduced, above, turned, moved = _series(matrix, carried, mesh, gamma, segment)
        return (reduced, above), (matrix, carried, turned, moved)

    def down(above, kept):
        matrix, carried, turned, moved = kept
        here = _times(turned, above) + moved
        return here, (here, _times(matrix, here) + carried)

    rows = (ladder.screw[:-1], ladder.nut[:-1], ladder.forces[:-1], ladder.meshes)
    last, kept = jax.lax.scan(up, (matrix, carried), (*rows, ladder.gamma, ladder.segment))
    matrix, carried = joined(last[0], last[1], ladder.screw[-1], ladder.nut[-1], ladder.forces[-1])
    end = gauss_jordan(matrix, -carried)
    _, (changes, inner) = jax.lax.scan(down, end, kept, reverse=True)
    return jnp.concatenate([changes, end[None]]), inner


@eliminate.def_vmap
def _side_by_side(axis_size, in_batched, ladder: Ladder):
    """A batch joins those that lie side by side already."""

    def joined(values, batched):
        if not batched:
            values = jnp.broadcast_to(values, (axis_size, *values.shape))
        moved = jnp.moveaxis(values, 0, -1)
        return moved.reshape((*moved.shape[:-2], -1))

    found = eliminate(jax.tree.map(joined, ladder, in_batched[0]))
    return jax.tree.map(
        lambda values: jnp.moveaxis(values.reshape((*values.shape[:-1], -1, axis_size)), -1, 0),
        found,
    ), (True, True)
