"""The Jacobian of quantities with respect to named parameters, in one differentiation."""

from collections.abc import Sequence
from typing import Literal, TypeAlias

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import Scalar
from ..mechanism import Mechanism, Parameter, directions_of, move_alone
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
    moves = [move_alone(mechanism, (parameter,)) for parameter in parameters]
    points, directions, placed = directions_of(mechanism, moves, parameters)
    if shift is not None:
        points = [
            point + jnp.tensordot(shift, along, 1).astype(point.dtype)
            for point, along in zip(points, directions, strict=True)
        ]

    def evaluate(points: list[Array]):
        values, valid = compute_checked(placed(points), quantities, speed=speed, load=load)
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
