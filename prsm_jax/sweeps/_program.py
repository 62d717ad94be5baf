"""The compiled part of a sweep: one chunk of designs, all at once."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..fields import Scalar
from ..findings import first_error, margins_of, shared_loads
from ..mechanism import Mechanism, set_parameters
from ..quantities import Analysis, evaluate_coded


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
    sources: tuple[Any, ...] | None,
) -> tuple[dict[str, Array], Int[Array, " chunk"], Int[Array, " chunk"]]:
    """Quantities of `chunk` neighbouring designs of a grid, with the last axis varying fastest.

    The coordinates are computed from the number of a design, so the grid is never stored. Beyond
    the end of the grid the last design is repeated.

    **Arguments:**

    - `mechanism`: the mechanism, with the static axes set.
    - `names`, `axes`: parameters and their values [SI].
    - `quantities`: names from the catalogue.
    - `start`: number of the first design.
    - `chunk`: number of designs.
    - `speed`, `load`: operating point, or `None` for that of the mechanism.
    - `sources`: sources of margins whose errors are looked for, or `None`.

    **Returns:** the quantities, with the designs as first axis, all NaN for an unusable design; a
    code, 0 for a usable design (see `prsm_jax.quantities.REASONS`); and the first error of
    `check`, by its place in `error_names` from 1, 0 for none.
    """
    shape = tuple(axis.shape[0] for axis in axes)
    total = 1
    for length in shape:
        total *= length

    def design(number: Int[Array, ""]):
        place = jnp.unravel_index(number, shape) if shape else ()
        values = {name: axis[index] for name, axis, index in zip(names, axes, place, strict=True)}
        moved = set_parameters(mechanism, values)
        analysis = Analysis(moved, speed, load)
        if sources:
            analysis.expect(shared_loads(margins_of(moved), lambda m: m.error_limit is not None))
        results, code = evaluate_coded(analysis, quantities)
        good = code == 0
        results = {name: jnp.where(good, value, jnp.nan) for name, value in results.items()}
        return results, code, first_error(analysis) if sources else jnp.zeros_like(code)

    numbers = jnp.minimum(start + jnp.arange(chunk), total - 1)
    return jax.vmap(design)(numbers)
