"""Linear response of the chains: elimination from the first thread to the last.

What hangs below a segment acts on the next thread like one stiffness matrix A; a segment in series
turns it into (A⁻¹ + C)⁻¹ = A (I + C A)⁻¹, which is regular from rigid segments to no shaft at all.
All matrices are those of spring networks, so elimination needs no pivoting.
"""

from typing import Any

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from ._chains import Chains, Control, State, Teeth
from ._wide_ladder import Ladder, eliminate as wide_eliminate, gauss_jordan

#: Up to here a thread's matrix is written out number by number, which is fast in batches.
_LARGEST = 4


def _inverse(matrix: list[list]) -> list[list]:
    """Inverse of a small matrix by Gauss and Jordan, in place and without pivoting."""
    size = range(len(matrix))
    rows = [list(row) for row in matrix]
    for k in size:
        pivot = 1 / rows[k][k]
        rows[k] = [pivot if j == k else rows[k][j] * pivot for j in size]
        for i in size:
            if i != k:
                factor = rows[i][k]
                rows[i] = [
                    -factor * pivot if j == k else rows[i][j] - factor * rows[k][j] for j in size
                ]
    return rows


class _Numbers:
    """Matrices as lists of numbers: each operation runs over the whole batch."""

    @staticmethod
    def thread(screw, nut):
        """Stiffness matrix of one thread on (d₁ …, D)."""
        count = len(screw)
        zero = jnp.zeros_like(nut[0])
        rows = [[screw[i] + nut[i] if i == j else zero for j in range(count)] for i in range(count)]
        rows = [[*row, -nut[i]] for i, row in enumerate(rows)]
        return [*rows, [*(-b for b in nut), sum(nut[1:], nut[0])]]

    @staticmethod
    def plus(first, second):
        return [
            [a + b for a, b in zip(x, y, strict=True)] for x, y in zip(first, second, strict=True)
        ]

    @staticmethod
    def add(first, second):
        return [a + b for a, b in zip(first, second, strict=True)]

    @staticmethod
    def less(first, second):
        return [a - b for a, b in zip(first, second, strict=True)]

    @staticmethod
    def times(matrix, vector):
        return [
            sum((a * b for a, b in zip(row[1:], vector[1:], strict=True)), row[0] * vector[0])
            for row in matrix
        ]

    @staticmethod
    def times_transposed(matrix, vector):
        return _Numbers.times([list(column) for column in zip(*matrix, strict=True)], vector)

    @staticmethod
    def along(gamma, screw, vector):
        """C x = c_s 1 (1·x) + Γ x."""
        total = screw * sum(vector[1:], vector[0])
        return [g * x + total for g, x in zip(gamma, vector, strict=True)]

    @staticmethod
    def solve(matrix, vector):
        return _Numbers.times(_inverse(matrix), vector)

    @staticmethod
    def series(matrix, gamma, screw):
        """(I + C A)⁻¹ and A (I + C A)⁻¹."""
        size = range(len(matrix))
        ones = [[gamma[i] * matrix[i][j] + (1.0 if i == j else 0.0) for j in size] for i in size]
        inverse = _inverse(ones)
        reduced: Any = [[None] * len(matrix) for _ in size]
        for i in size:
            for j in range(i, len(matrix)):
                column = [inverse[k][j] for k in size]
                reduced[i][j] = reduced[j][i] = _Numbers.times([matrix[i]], column)[0]
        ground = [sum(row[1:], row[0]) for row in reduced]
        widened = [sum(row[1:], row[0]) for row in inverse]
        share = screw / (1 + screw * sum(ground[1:], ground[0]))
        inverse = [[inverse[i][j] - share * widened[i] * ground[j] for j in size] for i in size]
        reduced = [[reduced[i][j] - share * ground[i] * ground[j] for j in size] for i in size]
        return inverse, reduced


def _columns(per_class: Float[Array, "classes n"], last: Float[Array, " n"]):
    """Rows per thread from rows per class: (d₁ …, D) at every thread [threads, classes + 1]."""
    return jnp.concatenate([per_class, last[None, :]], axis=0).T


def _numbers(per_class: list[list[Array]], last: list[Array]) -> list[Array]:
    """(d₁ …, D) of several right-hand sides, number by number [n, rights]."""
    return [jnp.stack(values, axis=-1) for values in (*zip(*per_class, strict=True), last)]


def _eliminate(chains: Chains, teeth: tuple[Teeth, Teeth], rights: list[State]) -> list[State]:
    """Solve K Δq_i − ΔQ_i + ΔQ_{i−1} = y_i, Δq_{i+1} − Δq_i − C ΔQ_i = z_i without control."""
    screw, nut = (chains.weight[:, None] * side.slope for side in teeth)
    size = screw.shape[0] + 1
    if size > _LARGEST:
        return _eliminate_wide(chains, screw, nut, rights)
    gamma = [chains.roller_segment / weight for weight in chains.weight] + [chains.nut_segment]
    # A number of each right-hand side lies beside those of the others, so that all of them are
    # written out once.
    forces = _numbers(
        [list(one.screw_approach) for one in rights], [one.approach for one in rights]
    )
    meshes = _numbers([list(one.roller_force) for one in rights], [one.nut_force for one in rights])
    nothing = jnp.zeros_like(forces[0][0]), jnp.zeros_like(screw[0, 0])

    def joined(below, thread):
        (matrix, carried), (screw_row, nut_row, force) = below, thread
        matrix = _Numbers.plus(_Numbers.thread(screw_row, nut_row), matrix)
        return matrix, _Numbers.less(carried, force)

    def up(below, given):
        thread, mesh, gamma_row, segment = given
        matrix, carried = joined(below, thread)
        inverse, reduced = _Numbers.series(matrix, gamma_row, segment)
        above = _Numbers.less(carried, _Numbers.times(matrix, mesh))
        return (reduced, _Numbers.times_transposed(inverse, above)), (matrix, inverse, carried)

    def down(above, given):
        (matrix, inverse, carried), mesh, gamma_row, segment = given
        along = _Numbers.along(gamma_row, segment, carried)
        here = _Numbers.times(inverse, _Numbers.less(_Numbers.less(above, mesh), along))
        return here, (here, _Numbers.add(_Numbers.times(matrix, here), carried))

    threads = list(screw), list(nut), forces
    segments = meshes, gamma, chains.screw_segment
    start = [[nothing[1]] * size] * size, [nothing[0]] * size
    below, kept = jax.lax.scan(up, start, (jax.tree.map(lambda x: x[:-1], threads), *segments))
    matrix, carried = joined(below, jax.tree.map(lambda x: x[-1], threads))
    last = _Numbers.solve(matrix, [-x for x in carried])
    _, (changes, inner) = jax.lax.scan(down, last, (kept, *segments), reverse=True)
    ends = [jnp.asarray(x)[None] for x in last]
    whole = [jnp.concatenate(pair) for pair in zip(changes, ends, strict=True)]
    approaches, shafts = jnp.stack(whole), jnp.stack(inner)
    return [
        State(approaches[:-1, :, k], approaches[-1, :, k], shafts[:-1, :, k], shafts[-1, :, k])
        for k in range(len(rights))
    ]


def _eliminate_wide(chains: Chains, screw: Array, nut: Array, rights: list[State]) -> list[State]:
    """As `_eliminate`, for more classes of rollers than can be written out."""
    gamma = _columns(chains.roller_segment[None, :] / chains.weight[:, None], chains.nut_segment)
    forces = [_columns(right.screw_approach, right.approach) for right in rights]
    meshes = [_columns(right.roller_force, right.nut_force) for right in rights]
    ladder = Ladder(
        screw.T, nut.T, gamma, chains.screw_segment, jnp.stack(forces, -1), jnp.stack(meshes, -1)
    )
    changes, inner = wide_eliminate(jax.tree.map(lambda values: values[..., None], ladder))
    return [
        State(
            changes[:, :-1, i, 0].T, changes[:, -1, i, 0], inner[:, :-1, i, 0].T, inner[:, -1, i, 0]
        )
        for i in range(len(rights))
    ]


def control_column(chains: Chains, state: State, control: Control) -> State:
    """Derivative of the balance to the unknown load or offset; its own row as well."""
    zeros = bare(jax.tree.map(jnp.zeros_like, state))
    segment, nut = chains.screw_segment, chains.nut_segment
    if control == "preload":
        assert chains.split is not None
        sought = jnp.ones_like(chains.film) if chains.sought is None else chains.sought
        return State(
            zeros.screw_approach,
            zeros.approach,
            zeros.roller_force,
            zeros.nut_force.at[chains.split].set(sought),
            control=1 - sought,
        )
    closing = segment + nut if chains.same_end else segment
    return State(
        zeros.screw_approach,
        zeros.approach.at[-1].set(-1.0),
        jnp.broadcast_to(segment, zeros.roller_force.shape),
        closing,
        control=-jnp.sum(closing),
    )


def _inner_product(first: State, second: State) -> Array:
    pairs = (
        (first.screw_approach, second.screw_approach),
        (first.approach, second.approach),
        (first.roller_force, second.roller_force),
        (first.nut_force, second.nut_force),
    )
    return sum((jnp.sum(a * b) for a, b in pairs[1:]), jnp.sum(pairs[0][0] * pairs[0][1]))


def _wedge_columns(chains: Chains, teeth: tuple[Teeth, Teeth], like: State):
    """Derivatives of the balance to the wedge of each class, and of the wedges to themselves."""
    screw, nut = teeth
    assert screw.lean is not None
    assert nut.lean is not None
    columns, own = [], []
    for index in range(chains.weight.shape[0]):
        here = (jnp.arange(chains.weight.shape[0]) == index).astype(like.approach.dtype)
        weight = (chains.weight * here)[:, None]
        columns.append(
            State(
                -weight * (screw.lean + nut.lean),
                jnp.sum(weight * nut.lean, axis=0),
                jnp.zeros_like(like.roller_force),
                jnp.zeros_like(like.nut_force),
            )
        )
        # The film moves with the teeth, not with their flanks.
        stiff = jnp.sum(screw.slope[index] + nut.slope[index] - 2 * chains.film) + chains.guide
        own.append(chains.weight[index] * stiff)
    return columns, own


def solve_linear(
    chains: Chains, teeth: tuple[Teeth, Teeth], control: Control, right: State
) -> State:
    """Solve the linearised balance for a right-hand side.

    **Arguments:**

    - `chains`: the chains.
    - `teeth`: slopes of the teeth of one roller per class, screw side and nut side.
    - `control`: what is prescribed.
    - `right`: right-hand side, in the layout of the residual.
    """
    columns: list[State] = []
    own: list[Any] = []
    wanted: list[Any] = []
    if right.wedge is not None:
        columns, own = _wedge_columns(chains, teeth, right)
        wanted = [right.wedge[i] for i in range(right.wedge.shape[0])]
    if control != "load":
        column = control_column(chains, right, control)
        columns, own = [*columns, column], [*own, column.control]
        wanted = [*wanted, right.control]
    plain, *responses = _eliminate(chains, teeth, [right, *columns])
    if not columns:
        return plain
    # What couples to everything at once: a small dense system after the elimination.
    if len(columns) > _LARGEST:
        extra = _bordered(columns, own, wanted, plain, responses)
        return _without(plain, responses, extra, control)
    matrix = [[-_inner_product(one, other) for other in responses] for one in columns]
    for index, value in enumerate(own):
        matrix[index][index] = matrix[index][index] + value
    vector = [
        value - _inner_product(one, plain) for value, one in zip(wanted, columns, strict=True)
    ]
    return _without(plain, responses, _Numbers.solve(matrix, vector), control)


def _bordered(
    columns: list[State], own: list[Any], wanted: list[Any], plain: State, responses: list[State]
) -> list[Any]:
    """The dense system of many columns by products of matrices: a product for each pair of them
    would be a program that grows with their square."""
    border = jnp.stack([_flat(one) for one in columns])
    found = jnp.stack([_flat(one) for one in responses])
    square = jnp.diag(jnp.stack(own)) - border @ found.T
    vector = jnp.stack(wanted) - border @ _flat(plain)
    return list(gauss_jordan(square, vector[:, None])[:, 0])


def _flat(state: State) -> Float[Array, " unknowns"]:
    return ravel_pytree(bare(state))[0]


def _without(plain: State, responses: list[State], extra: list[Any], control: Control) -> State:
    """The response less those to what couples to everything, which is then known."""
    moved = bare(plain)
    for share, response in zip(extra, responses, strict=True):
        moved = jax.tree.map(lambda a, b, c=share: a - c * b, moved, bare(response))
    wedges = len(extra) - (control != "load")
    return State(
        moved.screw_approach,
        moved.approach,
        moved.roller_force,
        moved.nut_force,
        jnp.stack(extra[:wedges]) if wedges else None,
        None if control == "load" else extra[-1],
    )


def bare(state: State) -> State:
    """The unknowns of the chains alone."""
    return State(state.screw_approach, state.approach, state.roller_force, state.nut_force)
