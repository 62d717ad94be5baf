"""Compiled programs: derivatives along tolerances, and quantities of many designs at once.

Quantities stay separate arrays inside a program: XLA would evaluate the physics again for each
element of a concatenation.
"""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..fields import Scalar
from ..findings import first_error, margins_of, shared_loads
from ..mechanism import Mechanism
from ..quantities import Analysis, Quantity, evaluate_coded
from ._inputs import moved


@eqx.filter_jit
def derivatives_along(
    mechanism: Mechanism,
    paths: tuple[str, ...],
    middle: Float[Array, " numbers"],
    directions: Float[Array, "tolerances numbers"],
    pairs: tuple[Int[Array, " pairs"], Int[Array, " pairs"]] | None,
    selected: tuple[Quantity, ...],
    speed: Scalar | None,
    load: Scalar | None,
) -> tuple[dict[str, Array], dict[str, Array], dict[str, Array] | None, Int[Array, ""]]:
    """Quantities, their first derivatives along directions, and second ones along pairs of them.

    **Returns:** values; first derivatives (directions first); second derivatives (pairs first) or
    `None` without pairs; and the code of the design, 0 if it can be used.
    """
    names = [one.name for one in selected]

    def evaluate(values: Float[Array, " numbers"]):
        return evaluate_coded(Analysis(moved(mechanism, paths, values), speed, load), names)

    def plain(values: Float[Array, " numbers"]):
        return evaluate(values)[0]

    def second(left: Int[Array, ""], right: Int[Array, ""]):
        def slope(values: Float[Array, " numbers"]):
            return jax.jvp(plain, (values,), (directions[left],))[1]

        return jax.jvp(slope, (middle,), (directions[right],))[1]

    values, push, code = jax.linearize(evaluate, middle, has_aux=True)
    first = jax.vmap(push)(directions)
    curved = None if pairs is None else jax.lax.map(lambda pair: second(*pair), pairs)
    return values, first, curved, code


@eqx.filter_jit
def evaluate_designs(
    mechanism: Mechanism,
    paths: tuple[str, ...],
    values: Float[Array, "designs numbers"],
    selected: tuple[Quantity, ...],
    speed: Scalar | None,
    load: Scalar | None,
    sources: tuple[Callable[..., Any], ...] | None,
) -> tuple[dict[str, Array], Int[Array, " designs"], Int[Array, " designs"]]:
    """Quantities of many designs (first axis), NaN for those that cannot be used.

    **Returns:** the quantities; a code, 0 for a usable design (see `prsm_jax.quantities.REASONS`);
    and the first error of `check`, by its place in `error_names` from 1, 0 for none.
    """
    names = [one.name for one in selected]

    def design(numbers: Float[Array, " numbers"]):
        one = moved(mechanism, paths, numbers)
        analysis = Analysis(one, speed, load)
        if sources:
            analysis.expect(shared_loads(margins_of(one), lambda m: m.error_limit is not None))
        results, code = evaluate_coded(analysis, names)
        results = {name: jnp.where(code == 0, value, jnp.nan) for name, value in results.items()}
        return results, code, first_error(analysis) if sources else jnp.zeros_like(code)

    return jax.vmap(design)(values)


@eqx.filter_jit
def gradients_of_designs(
    mechanism: Mechanism,
    paths: tuple[str, ...],
    values: Float[Array, "designs numbers"],
    directions: Float[Array, "tolerances numbers"],
    selected: tuple[Quantity, ...],
    speed: Scalar | None,
    load: Scalar | None,
) -> tuple[dict[str, Array], Int[Array, " designs"]]:
    """Derivatives along directions (designs × directions × …) of many designs, and their codes."""
    names = [one.name for one in selected]

    def design(numbers: Float[Array, " numbers"]):
        def evaluate(at: Float[Array, " numbers"]):
            return evaluate_coded(Analysis(moved(mechanism, paths, at), speed, load), names)

        _, push, code = jax.linearize(evaluate, numbers, has_aux=True)
        return jax.vmap(push)(directions), code

    return jax.vmap(design)(values)
