"""The compiled part of a sweep: one chunk of designs, all at once."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..mechanism import Mechanism, Scalar, set_parameters
from ..quantities import compute_coded


@eqx.filter_jit
def evaluate_chunk(
    mechanism: Mechanism,
    names: tuple[str, ...],
    axes: tuple[Float[Array, " _"], ...],
    quantities: tuple[str, ...],
    start: Int[Array, ""],
    chunk: int,
    speed: Scalar | None,
    load: Scalar | None,
) -> tuple[dict[str, Array], Int[Array, " chunk"]]:
    """Quantities of `chunk` neighbouring designs of a grid, the last axis running fastest.

    The coordinates follow from the number of a design, so that no grid is ever held in memory;
    past the end of the grid the last design is repeated.

    **Arguments:**

    - `mechanism`: the mechanism, with the static axes set.
    - `names`, `axes`: parameters and their values [SI].
    - `quantities`: names from the catalogue.
    - `start`: number of the first design.
    - `chunk`: how many.
    - `speed`, `load`: operating point, or `None` for that of the mechanism.

    **Returns:** the quantities, with the designs in front, and a code, 0 for a design that
    can be used (see `prsm_jax.quantities.REASONS`); the others are NaN throughout.
    """
    shape = tuple(axis.shape[0] for axis in axes)
    total = 1
    for length in shape:
        total *= length

    def design(number: Int[Array, ""]):
        place = jnp.unravel_index(number, shape) if shape else ()
        values = {name: axis[index] for name, axis, index in zip(names, axes, place, strict=True)}
        moved = set_parameters(mechanism, values)
        found, code = compute_coded(moved, quantities, speed=speed, load=load)
        good = code == 0
        return {name: jnp.where(good, value, jnp.nan) for name, value in found.items()}, code

    numbers = jnp.minimum(start + jnp.arange(chunk), total - 1)
    return jax.vmap(design)(numbers)
