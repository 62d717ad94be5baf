"""Linear response of the chains: block-tridiagonal elimination from the first thread to the last.

The threads below a segment act on the next thread like one stiffness matrix A; a segment in series
turns it into (A⁻¹ + C)⁻¹ = A (I + C A)⁻¹, which is regular for any stiffness of the
segments, 0 and infinity included.
All matrices are those of spring networks, so elimination needs no pivoting.
"""

import functools
import operator
from typing import Any

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from ._chains import Chains, Control, State
from ._flanks import Teeth
from ._large_block_tridiagonal import BlockTridiagonal, eliminate as eliminate_large, gauss_jordan
from .part_errors import SideCoupling

#: Largest matrix of a thread that is written out number by number, which is fast in batches.
_LARGEST = 4


def _inverse(matrix: list[list[Any]]) -> list[list[Any]]:
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
    def add(first, second):
        return jax.tree.map(operator.add, first, second)

    @staticmethod
    def less(first, second):
        return jax.tree.map(operator.sub, first, second)

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
        return _eliminate_large(chains, screw, nut, rights)
    gamma = [chains.roller_segment / weight for weight in chains.weight] + [chains.nut_segment]
    # Right-hand sides lie in the last axis, so that the elimination is compiled once for all.
    forces = _numbers(
        [list(one.screw_approach) for one in rights], [one.approach for one in rights]
    )
    meshes = _numbers([list(one.roller_force) for one in rights], [one.nut_force for one in rights])
    zeros = jnp.zeros_like(forces[0][0]), jnp.zeros_like(screw[0, 0])

    def add_thread(below, thread):
        (matrix, carried), (screw_row, nut_row, force) = below, thread
        matrix = _Numbers.add(_Numbers.thread(screw_row, nut_row), matrix)
        return matrix, _Numbers.less(carried, force)

    def up(below, segment_data):
        thread, mesh, gamma_row, segment = segment_data
        matrix, carried = add_thread(below, thread)
        inverse, reduced = _Numbers.series(matrix, gamma_row, segment)
        above = _Numbers.less(carried, _Numbers.times(matrix, mesh))
        return (reduced, _Numbers.times_transposed(inverse, above)), (matrix, inverse, carried)

    def down(above, segment_data):
        (matrix, inverse, carried), mesh, gamma_row, segment = segment_data
        elongation = _Numbers.along(gamma_row, segment, carried)
        change = _Numbers.times(inverse, _Numbers.less(_Numbers.less(above, mesh), elongation))
        return change, (change, _Numbers.add(_Numbers.times(matrix, change), carried))

    threads = list(screw), list(nut), forces
    segments = meshes, gamma, chains.screw_segment
    start = [[zeros[1]] * size] * size, [zeros[0]] * size
    below, eliminated = jax.lax.scan(
        up, start, (jax.tree.map(lambda x: x[:-1], threads), *segments)
    )
    matrix, carried = add_thread(below, jax.tree.map(lambda x: x[-1], threads))
    last = _Numbers.solve(matrix, [-x for x in carried])
    _, (changes, inner) = jax.lax.scan(down, last, (eliminated, *segments), reverse=True)
    ends = [jnp.asarray(x)[None] for x in last]
    with_last = [jnp.concatenate(pair) for pair in zip(changes, ends, strict=True)]
    approaches, shafts = jnp.stack(with_last), jnp.stack(inner)
    return [
        State(approaches[:-1, :, k], approaches[-1, :, k], shafts[:-1, :, k], shafts[-1, :, k])
        for k in range(len(rights))
    ]


def _eliminate_large(chains: Chains, screw: Array, nut: Array, rights: list[State]) -> list[State]:
    """As `_eliminate`, for more classes of rollers than can be written out."""
    gamma = _columns(chains.roller_segment[None, :] / chains.weight[:, None], chains.nut_segment)
    forces = [_columns(right.screw_approach, right.approach) for right in rights]
    meshes = [_columns(right.roller_force, right.nut_force) for right in rights]
    system = BlockTridiagonal(
        screw.T, nut.T, gamma, chains.screw_segment, jnp.stack(forces, -1), jnp.stack(meshes, -1)
    )
    changes, inner = eliminate_large(jax.tree.map(lambda values: values[..., None], system))
    return [
        State(
            changes[:, :-1, i, 0].T, changes[:, -1, i, 0], inner[:, :-1, i, 0].T, inner[:, -1, i, 0]
        )
        for i in range(len(rights))
    ]


def control_column(chains: Chains, state: State, control: Control) -> State:
    """Column of the Jacobian for the unknown load or offset, with its diagonal element."""
    zeros = thread_unknowns(jax.tree.map(jnp.zeros_like, state))
    segment, nut = chains.screw_segment, chains.nut_segment
    if control == "preload":
        assert chains.split is not None
        offset_unknown = chains.offset_unknown
        if offset_unknown is None:
            offset_unknown = jnp.ones_like(chains.regularisation)
        return State(
            zeros.screw_approach,
            zeros.approach,
            zeros.roller_force,
            zeros.nut_force.at[chains.split].set(offset_unknown),
            control=1 - offset_unknown,
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
    both = (jax.tree.leaves(thread_unknowns(state)) for state in (first, second))
    products = [jnp.sum(a * b) for a, b in zip(*both, strict=True)]
    return sum(products[1:], products[0])


def _radial_shift_columns(chains: Chains, teeth: tuple[Teeth, Teeth], like: State):
    """Columns of the Jacobian for the radial shift of each class, and its diagonal elements."""
    screw, nut = teeth
    assert screw.slope_difference is not None
    assert nut.slope_difference is not None
    columns, diagonal = [], []
    for index in range(chains.weight.shape[0]):
        selected = (jnp.arange(chains.weight.shape[0]) == index).astype(like.approach.dtype)
        weight = (chains.weight * selected)[:, None]
        columns.append(
            State(
                -weight * (screw.slope_difference + nut.slope_difference),
                jnp.sum(weight * nut.slope_difference, axis=0),
                jnp.zeros_like(like.roller_force),
                jnp.zeros_like(like.nut_force),
            )
        )
        # Regularising springs depend on the approach of the teeth, not on the radial shift.
        stiffness = jnp.sum(screw.slope[index] + nut.slope[index] - 2 * chains.regularisation)
        diagonal.append(chains.weight[index] * (stiffness + chains.radial_regularisation))
    return columns, diagonal


def _displaced(
    chains: Chains, side: SideCoupling, teeth: Teeth
) -> tuple[Array, Array | None, Array]:
    """Decrease of the forces on one side per displacement.

    **Returns:** along the axis, and those that press outward (`None` where threads have one flank),
    each [displacements, classes, threads]; the stiffness between the displacements.
    """
    weight = chains.weight[:, None]
    slope = (weight * teeth.slope)[None]
    along = slope * side.axial
    both = functools.partial(jnp.tensordot, axes=((1, 2), (1, 2)))
    if side.radial is None:
        return along, None, both(side.axial, along)
    assert teeth.slope_difference is not None
    difference = (weight * teeth.slope_difference)[None]
    along = along + difference * side.radial
    # Regularising springs depend on the approach of the teeth, not on the opening.
    free = slope - (weight * chains.regularisation)[None]
    outward = difference * side.axial + free * side.radial
    return along, outward, both(side.axial, along) + both(side.radial, outward)


def _displacement_columns(chains: Chains, teeth: tuple[Teeth, Teeth], like: State):
    """Columns of the Jacobian for the displacements, and their own rows and columns.

    **Returns:** a column for each displacement; the stiffness between the displacements
    [displacements, displacements]; and that between them and the radial shift of each class
    [classes, displacements], `None` without such shifts.
    """
    coupled = chains.displacements
    assert coupled is not None
    own = chains.displacement_regularisation * jnp.eye(coupled.count, dtype=coupled.load.dtype)
    if coupled.stiffness is not None:
        own = own + coupled.stiffness
    on_nut, outward, stiffness = _displaced(chains, coupled.nut, teeth[1])
    own, on_rollers = own + stiffness, on_nut
    if coupled.screw is not None:
        on_screw, from_screw, stiffness = _displaced(chains, coupled.screw, teeth[0])
        own, on_rollers = own + stiffness, on_nut - on_screw
        if outward is not None and from_screw is not None:
            outward = outward - from_screw
    columns = [
        State(
            roller,
            -jnp.sum(nut, axis=0),
            jnp.zeros_like(like.roller_force),
            jnp.zeros_like(like.nut_force),
        )
        for roller, nut in zip(on_rollers, on_nut, strict=True)
    ]
    return columns, own, None if outward is None else -jnp.sum(outward, axis=2).T


def solve_linear(
    chains: Chains, teeth: tuple[Teeth, Teeth], control: Control, right: State
) -> State:
    """Solve the linearised balance for a right-hand side.

    **Arguments:**

    - `chains`: the chains.
    - `teeth`: slopes of the teeth of one roller per class, screw side and nut side.
    - `control`: the prescribed quantity.
    - `right`: right-hand side, in the layout of the residual.
    """
    columns: list[State] = []
    diagonal: list[Any] = []
    targets: list[Any] = []
    if right.radial_shift is not None:
        columns, diagonal = _radial_shift_columns(chains, teeth, right)
        targets = [right.radial_shift[i] for i in range(right.radial_shift.shape[0])]
    between = None
    if right.displacements is not None:
        more, own, across = _displacement_columns(chains, teeth, right)
        between = _corner(own, across, len(diagonal), control)
        columns, diagonal = [*columns, *more], [*diagonal, *(jnp.zeros_like(own[0]))]
        targets = [*targets, *right.displacements]
    if control != "load":
        column = control_column(chains, right, control)
        columns, diagonal = [*columns, column], [*diagonal, column.control]
        targets = [*targets, right.control]
    plain, *responses = _eliminate(chains, teeth, [right, *columns])
    if not columns:
        return plain
    # Unknowns that couple to all threads: a small dense system after the elimination.
    if len(columns) > _LARGEST or between is not None:
        coupled = _bordered(columns, diagonal, targets, plain, responses, between)
        return _with_coupled_unknowns(plain, responses, coupled, right)
    matrix = [[-_inner_product(one, other) for other in responses] for one in columns]
    for index, value in enumerate(diagonal):
        matrix[index][index] = matrix[index][index] + value
    vector = [
        value - _inner_product(one, plain) for value, one in zip(targets, columns, strict=True)
    ]
    return _with_coupled_unknowns(plain, responses, _Numbers.solve(matrix, vector), right)


def _corner(own: Array, across: Array | None, shifts: int, control: Control) -> Array:
    """Stiffnesses of the displacements in the square matrix of all coupled unknowns."""
    last = shifts + len(own)
    count = last + (control != "load")
    corner = jnp.zeros((count, count), own.dtype).at[shifts:last, shifts:last].set(own)
    if across is None:
        return corner
    corner = corner.at[:shifts, shifts:last].set(across)
    return corner.at[shifts:last, :shifts].set(across.T)


def _bordered(
    columns: list[State],
    diagonal: list[Any],
    targets: list[Any],
    plain: State,
    responses: list[State],
    between: Array | None,
) -> list[Any]:
    """The dense system of many columns by products of matrices.

    A product for each pair of columns would make the program grow with the square of their number.
    """
    border = jnp.stack([_flat(one) for one in columns])
    solutions = jnp.stack([_flat(one) for one in responses])
    square = jnp.diag(jnp.stack(diagonal)) - border @ solutions.T
    if between is not None:
        square = square + between
    vector = jnp.stack(targets) - border @ _flat(plain)
    return list(gauss_jordan(square, vector[:, None])[:, 0])


def _flat(state: State) -> Float[Array, " unknowns"]:
    return ravel_pytree(thread_unknowns(state))[0]


def _with_coupled_unknowns(
    plain: State, responses: list[State], coupled: list[Any], right: State
) -> State:
    """The response with the coupled unknowns, after they are solved for."""
    total = thread_unknowns(plain)
    for share, response in zip(coupled, responses, strict=True):
        total = jax.tree.map(lambda a, b, c=share: a - c * b, total, thread_unknowns(response))
    shifts = 0 if right.radial_shift is None else right.radial_shift.shape[0]
    moved = right.displacements
    if moved is not None:
        moved = jnp.stack(coupled[shifts : shifts + len(moved)])
    return State(
        total.screw_approach,
        total.approach,
        total.roller_force,
        total.nut_force,
        jnp.stack(coupled[:shifts]) if shifts else None,
        None if right.control is None else coupled[-1],
        moved,
    )


def thread_unknowns(state: State) -> State:
    """The unknowns of the threads, without radial shifts and control."""
    return State(state.screw_approach, state.approach, state.roller_force, state.nut_force)
