"""Second derivatives of quantities by named parameters."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..fields import Scalar
from ..mechanism import Mechanism, Parameter
from ..quantities import compute_checked


def hessian(
    mechanism: Mechanism,
    quantities: Sequence[str],
    groups: Sequence[Sequence[Parameter]],
    speed: Scalar | None,
    load: Scalar | None,
) -> Float[Array, "quantities parameters parameters"]:
    """Second derivatives of all components by each pair of parameters [SI].

    The steps of the parameters are applied one after the other, in the order of the list. Each step
    is added to the value that the earlier steps have given: a number that follows from an earlier
    parameter keeps the change due to it. Forward over forward differentiation, pair by pair: side
    by side, or in reverse mode, the program would take many times longer to compile.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `quantities`: names from the catalogue.
    - `groups`: the numbers of each parameter, which move by equal steps; none of them static.
    - `speed`, `load`: operating point, or `None` for that of the mechanism.
    """
    count = len(groups)
    steps = jnp.zeros(count, jnp.result_type(float))
    unit = jnp.eye(count, dtype=steps.dtype)

    def evaluate(at: Float[Array, " parameters"]) -> dict[str, Array]:
        moved = mechanism
        for place, group in enumerate(groups):
            for number in group:
                moved = number.set(moved, number.get(moved) + at[place])
        values, _ = compute_checked(moved, quantities, speed=speed, load=load)
        return {name: jnp.ravel(values[name]) for name in quantities}

    def second(pair: tuple[Int[Array, ""], Int[Array, ""]]) -> dict[str, Array]:
        def slope(at: Float[Array, " parameters"]) -> dict[str, Array]:
            return jax.jvp(evaluate, (at,), (unit[pair[0]],))[1]

        return jax.jvp(slope, (steps,), (unit[pair[1]],))[1]

    left, right = np.triu_indices(count)
    columns = jax.lax.map(second, (jnp.asarray(left), jnp.asarray(right)))
    # Outside of the loop: a concatenation inside could compute the physics again.
    rows = jnp.concatenate([columns[name] for name in quantities], axis=1)
    place = np.zeros((count, count), dtype=int)
    place[left, right] = place[right, left] = np.arange(len(left))
    return jnp.moveaxis(rows[place], -1, 0)
