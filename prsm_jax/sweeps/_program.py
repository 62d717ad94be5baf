"""The compiled part of a sweep: one block of designs, all at once."""

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..fields import Scalar
from ..findings import first_error, margins_of, shared_loads
from ..mechanism import (
    Directions,
    Mechanism,
    directions_of,
    find_parameters,
    move_alone,
    move_while_others_stay,
    set_parameters,
    with_traced_counts,
)
from ..quantities import Analysis, evaluate_coded


class Question(NamedTuple):
    """What is computed for every design; part of the program."""

    #: Names from the catalogue.
    quantities: tuple[str, ...]
    #: Parameters by which every quantity is differentiated.
    gradients: tuple[str, ...]
    #: Names of the axes, in the order in which they are set: a dictionary of arrays has no order
    #: of its own in a program.
    axes: tuple[str, ...]
    #: Whether axes keep their values in a derivative by another one.
    hold_axes: bool
    #: Sources of margins whose errors are looked for, or `None`.
    sources: tuple[Any, ...] | None
    #: Number of designs in a call.
    size: int


class BlockResults(NamedTuple):
    """Results of a block, with the designs along the first axis of every array."""

    #: All NaN for an unusable design.
    values: dict[str, Array]
    #: Derivatives [SI] by quantity and parameter.
    derivatives: dict[tuple[str, str], Array]
    #: 0 for a usable design (see `prsm_jax.quantities.REASONS`).
    code: Int[Array, " designs"]
    #: First error of `check`, by its place in `error_names` from 1; 0 for none.
    error: Int[Array, " designs"]


def evaluate_block(
    mechanism: Mechanism,
    columns: dict[str, Float[Array, " designs"]],
    point: dict[str, Scalar | None],
    question: Question,
) -> BlockResults:
    """Quantities of designs that differ in the numbers of `columns`.

    **Arguments:**

    - `mechanism`: the mechanism, with the whole numbers that are part of the program set.
    - `columns`: values [SI] of parameters, by name, of all designs; among them numbers of rollers,
      from `FEWEST_TRACED`, that the program takes as numbers.
    - `point`: `speed` and `load`, or `None` for those of the mechanism.
    - `question`: what is computed.
    """
    numbers, static = _separated(mechanism)
    return evaluate_chunk(static, question, numbers, columns, point)


def block_shapes(
    mechanism: Mechanism,
    columns: dict[str, Float[Array, " designs"]],
    point: dict[str, Scalar | None],
    question: Question,
) -> BlockResults:
    """Shapes and types of what `evaluate_block` returns; both share one trace."""
    numbers, static = _separated(mechanism)
    return evaluate_chunk.eval_shape(static, question, numbers, columns, point)


def _separated(mechanism: Mechanism) -> tuple[list[Any], tuple[Any, ...]]:
    """The arrays of a mechanism, and all that is part of the program."""
    leaves, structure = jax.tree.flatten(mechanism)
    numbers = [leaf if eqx.is_array(leaf) else None for leaf in leaves]
    others = tuple(None if eqx.is_array(leaf) else leaf for leaf in leaves)
    return numbers, (structure, others)


@functools.partial(jax.jit, static_argnums=(0, 1))
def evaluate_chunk(
    static: tuple[Any, ...],
    question: Question,
    numbers: list[Any],
    columns: dict[str, Any],
    point: dict[str, Any],
) -> BlockResults:
    """The program of a call; the progress line counts programs of this name."""
    structure, others = static
    leaves = [
        other if number is None else number for number, other in zip(numbers, others, strict=True)
    ]
    mechanism = jax.tree.unflatten(structure, leaves)

    def design(values: dict[str, Scalar]) -> BlockResults:
        given = {name: values[name] for name in question.axes if name in values}
        whole = {n: v for n, v in given.items() if find_parameters(mechanism, n)[0].static}
        numbers = {n: v for n, v in given.items() if n not in whole}
        counted = with_traced_counts(mechanism, whole)
        return _evaluate(set_parameters(counted, numbers), point, question)

    return jax.vmap(design, axis_size=question.size)(columns)


def _evaluate(mechanism: Mechanism, point: dict[str, Any], question: Question) -> BlockResults:
    """What is computed for one design."""
    analysis = Analysis(mechanism, point["speed"], point["load"])
    if question.sources:
        margins = margins_of(mechanism)
        analysis.expect(shared_loads(margins, lambda margin: margin.error_limit is not None))
    values, code = evaluate_coded(analysis, question.quantities)
    derivatives: dict[tuple[str, str], Any] = {}
    if question.gradients:
        directions = _directions(mechanism, question)

        def moved_to(points: Sequence[Array]) -> dict[str, Array]:
            again = Analysis(directions.placed(points), point["speed"], point["load"])
            return evaluate_coded(again, question.quantities)[0]

        _, push = jax.linearize(moved_to, directions.points)
        derivatives = {
            (quantity, name): slopes[place]
            for quantity, slopes in jax.vmap(push)(directions.tangents).items()
            for place, name in enumerate(question.gradients)
        }
    values, derivatives = jax.tree.map(
        lambda value: jnp.where(code == 0, value, jnp.nan), (values, derivatives)
    )
    error = first_error(analysis) if question.sources else jnp.zeros_like(code)
    return BlockResults(values, derivatives, code, error)


def _directions(mechanism: Mechanism, question: Question) -> Directions:
    """The direction of each gradient, which does not depend on the others."""
    found = {name: find_parameters(mechanism, name) for name in question.gradients}
    held: dict[str, Scalar] = {}
    if question.hold_axes:
        axes = {name: find_parameters(mechanism, name)[0] for name in question.axes}
        # All stages have the value of an axis.
        held = {name: one.get(mechanism) for name, one in axes.items() if not one.static}
    moves = [
        move_while_others_stay(mechanism, name, held)
        if name in held
        else move_alone(mechanism, numbers)
        for name, numbers in found.items()
    ]
    numbers = [number for numbers in found.values() for number in numbers]
    return directions_of(mechanism, moves, numbers)
