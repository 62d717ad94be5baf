"""The Jacobian of quantities with respect to named parameters, in one differentiation."""

from collections.abc import Sequence
from typing import Literal, TypeAlias

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import Scalar
from ..mechanism import Mechanism, Parameter, written_out
from ..quantities import compute_checked

Mode: TypeAlias = Literal["auto", "forward", "reverse"]


def jacobian(
    mechanism: Mechanism,
    quantities: Sequence[str],
    parameters: Sequence[Parameter],
    speed: Scalar | None,
    load: Scalar | None,
    mode: Mode,
    shift: Float[Array, " parameters"] | None = None,
) -> tuple[dict[str, Float[Array, "..."]], Float[Array, "quantities parameters"], Bool[Array, ""]]:
    """Values of all quantities, and derivatives of all components by each parameter alone.

    Each parameter is a direction in the space of the numbers of the mechanism. The physics is
    therefore traced and differentiated once for any number of parameters, and only along numbers
    that a parameter moves: derivatives along the others would be compiled as well, and be
    multiplied by 0. A derivative does not change if the list has another parameter that depends on
    the first.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `quantities`: names from the catalogue.
    - `parameters`: single numbers of the mechanism, none of them static.
    - `speed`, `load`: operating point, or `None` for that of the mechanism.
    - `mode`: forward costs one pass per parameter, reverse one per quantity; `"auto"` takes the
      smaller number.
    - `shift`: offset from the present design along each parameter [SI]; default none.

    **Returns:** the values by name, the Jacobian with the components of all quantities as rows, and
    whether the values are usable.
    """

    kept = {id(leaf) for leaf in jax.tree.leaves(mechanism)}
    moves: list[bool] = []
    structure = jax.tree.structure(mechanism)
    added = [
        parameter.path
        for parameter in parameters
        if jax.tree.structure(parameter.set(mechanism, parameter.get(mechanism))) != structure
    ]

    def direction(parameter: Parameter):
        def moved_to(value: Scalar) -> Mechanism:
            moved = written_out(parameter.set(mechanism, value), added)
            # A number that the parameter does not touch is the same object as before.
            here = [id(leaf) not in kept for leaf in jax.tree.leaves(moved)]
            moves[:] = map(max, moves, here) if moves else here
            return moved

        value = parameter.get(mechanism)
        return jax.jvp(moved_to, (value,), (jnp.ones_like(value),))

    pairs = [direction(parameter) for parameter in parameters]
    leaves, structure = jax.tree.flatten(pairs[0][0])
    points = [leaf for leaf, one in zip(leaves, moves, strict=True) if one]
    tangents = zip(*(jax.tree.leaves(along) for _, along in pairs), strict=True)
    directions = [jnp.stack(along) for along, one in zip(tangents, moves, strict=True) if one]
    if shift is not None:
        points = [
            point + jnp.tensordot(shift, along, 1).astype(point.dtype)
            for point, along in zip(points, directions, strict=True)
        ]

    def evaluate(points: list[Array]):
        rest = iter(points)
        placed = [next(rest) if one else leaf for leaf, one in zip(leaves, moves, strict=True)]
        complete = jax.tree.unflatten(structure, placed)
        values, valid = compute_checked(complete, quantities, speed=speed, load=load)
        return jnp.concatenate([jnp.ravel(values[name]) for name in quantities]), (values, valid)

    if mode == "auto":
        # A quantity has at least one component; counting them costs a trace of the physics.
        few = len(parameters) <= len(quantities)
        few = few or len(parameters) <= jax.eval_shape(evaluate, points)[0].shape[0]
        mode = "forward" if few else "reverse"
    if mode == "forward":
        _, push, (values, valid) = jax.linearize(evaluate, points, has_aux=True)
        return values, jax.vmap(push, out_axes=1)(directions), valid
    flat, pull, (values, valid) = jax.vjp(evaluate, points, has_aux=True)
    count = flat.shape[0]
    (cotangents,) = jax.vmap(pull)(jnp.eye(count, dtype=flat.dtype))
    products = [
        cotangent.reshape(count, -1) @ along.reshape(len(parameters), -1).T
        for cotangent, along in zip(cotangents, directions, strict=True)
    ]
    derivatives = jnp.sum(jnp.stack(products), axis=0)
    return values, derivatives, valid
