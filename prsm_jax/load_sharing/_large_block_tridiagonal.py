"""Linear response of chains with many classes of rollers, with the batch in the last axis.

The elimination of `_block_tridiagonal`, for matrices too large to be written out number by number.
A segment in series is added port by port: compliance γ in port j turns f = A q + p into

`A ← A − γ a aᵀ/(1 + γ a_j)`, `p ← p − a (γ p_j + z_j)/(1 + γ a_j)`,

a is column j of A and z the mesh error. The same updates, applied to the unit matrix, give the
unknowns below from those above. Each update is one sweep over all numbers. The problems of a batch
lie in the last axis, so that a sweep is vectorised for any number of rollers.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap
from jaxtyping import Array, Float

Column = Float[Array, "size rights batch"]

#: Loops over rows up to this size are written out; beyond, the program would grow with the number
#: of rollers, and its compile time faster still.
_WRITTEN_OUT = 16


class BlockTridiagonal(NamedTuple):
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
    """Stiffness and force across a segment, and the map from unknowns above to those below it."""
    size = matrix.shape[0]
    unit = jnp.broadcast_to(jnp.eye(size, dtype=matrix.dtype)[:, :, None], matrix.shape)
    above = jnp.concatenate([matrix, carried], axis=1)
    rows_of_both = jnp.concatenate(
        [above, jnp.concatenate([unit, jnp.zeros_like(carried)], axis=1)]
    )
    gaps = jnp.concatenate([jnp.zeros_like(matrix), mesh], axis=1)
    rows, columns = (
        jnp.arange(2 * size)[:, None, None],
        jnp.arange(rows_of_both.shape[1])[None, :, None],
    )

    def port(j, rows_of_both):
        row, column = _row(rows_of_both, j), _row(rows_of_both, j, 1)
        compliance, gap, own = _row(gamma, j), _row(gaps, j), _row(row, j)
        divisor = 1 / (1 + compliance * own)
        removed = divisor[None] * (compliance[None] * row + gap)
        # The port's own row and column, without the difference of two nearly equal numbers.
        own_row = divisor[None] * (row - own[None] * gap)
        updated = rows_of_both - column[:, None] * removed[None]
        updated = jnp.where(columns == j, rows_of_both * divisor[None, None], updated)
        return jnp.where(rows == j, own_row[None], updated)

    # A loop: written out, the compiler fuses the sweeps and recomputes them for each number.
    rows_of_both = jax.lax.fori_loop(0, size, port, rows_of_both)
    row, column = jnp.sum(rows_of_both[:size], axis=0), jnp.sum(rows_of_both[:, :size], axis=1)
    share = segment / (1 + segment * jnp.sum(row[:size], axis=0))
    rows_of_both = rows_of_both - (share[None] * column)[:, None] * row[None]
    return (
        rows_of_both[:size, :size],
        rows_of_both[:size, size:],
        rows_of_both[size:, :size],
        rows_of_both[size:, size:],
    )


def gauss_jordan(matrix, column):
    """Solve `matrix @ x = column` without pivoting; further axes are a batch."""
    size = matrix.shape[0]
    augmented = jnp.concatenate([matrix, column], axis=1)
    rows = jnp.arange(size).reshape((-1, *(1,) * (augmented.ndim - 1)))

    def pivot(k, augmented):
        row = _row(augmented, k)
        row = row / _row(row, k)[None]
        return jnp.where(
            rows == k, row[None], augmented - _row(augmented, k, 1)[:, None] * row[None]
        )

    if size > _WRITTEN_OUT:
        return jax.lax.fori_loop(0, size, pivot, augmented)[:, size:]
    for k in range(size):
        augmented = pivot(k, augmented)
    return augmented[:, size:]


@custom_vmap
def eliminate(system: BlockTridiagonal) -> tuple[Array, Array]:
    """Changes (d₁ …, D) of every thread, and of the forces in (R₁ …, N) above all but the last.

    Both are thread, number, right-hand side, batch.
    """
    size = system.gamma.shape[1]
    matrix = jnp.zeros((size, size, system.segment.shape[-1]), system.gamma.dtype)
    carried = jnp.zeros_like(system.forces[0])

    def add_thread(matrix, carried, screw, nut, force):
        return matrix + _thread(screw, nut), carried - force

    def up(below, thread):
        screw, nut, force, mesh, gamma, segment = thread
        matrix, carried = add_thread(below[0], below[1], screw, nut, force)
        reduced, above, turned, moved = _series(matrix, carried, mesh, gamma, segment)
        return (reduced, above), (matrix, carried, turned, moved)

    def down(above, eliminated):
        matrix, carried, turned, moved = eliminated
        change = _times(turned, above) + moved
        return change, (change, _times(matrix, change) + carried)

    rows = (system.screw[:-1], system.nut[:-1], system.forces[:-1], system.meshes)
    last, eliminated = jax.lax.scan(up, (matrix, carried), (*rows, system.gamma, system.segment))
    matrix, carried = add_thread(
        last[0], last[1], system.screw[-1], system.nut[-1], system.forces[-1]
    )
    end = gauss_jordan(matrix, -carried)
    _, (changes, inner) = jax.lax.scan(down, end, eliminated, reverse=True)
    return jnp.concatenate([changes, end[None]]), inner


@eliminate.def_vmap
def _side_by_side(axis_size, in_batched, system: BlockTridiagonal):
    """A further batch is appended to the last axis."""

    def flattened(values, batched):
        if not batched:
            values = jnp.broadcast_to(values, (axis_size, *values.shape))
        moved = jnp.moveaxis(values, 0, -1)
        return moved.reshape((*moved.shape[:-2], -1))

    solution = eliminate(jax.tree.map(flattened, system, in_batched[0]))
    return jax.tree.map(
        lambda values: jnp.moveaxis(values.reshape((*values.shape[:-1], -1, axis_size)), -1, 0),
        solution,
    ), (True, True)
