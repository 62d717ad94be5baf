"""Carlson's symmetric elliptic integrals R_F and R_D by duplication."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

#: Each duplication brings the arguments four times closer together; the truncation error of the
#: series below goes with the sixth power of their distance. Sufficient for ratios of the arguments
#: up to 1e60.
_DOUBLINGS = 10


def _doubled(x, y, z):
    """The three arguments after one duplication, and the term that it adds to R_D."""
    roots = jnp.sqrt(x), jnp.sqrt(y), jnp.sqrt(z)
    shift = roots[0] * roots[1] + roots[1] * roots[2] + roots[2] * roots[0]
    return (x + shift) / 4, (y + shift) / 4, (z + shift) / 4, 1 / (roots[2] * (z + shift))


def carlson_rf_and_rd(
    x: Float[Array, "*batch"], y: Float[Array, "*batch"], z: Float[Array, "*batch"]
) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """R_F = ½ ∫₀^∞ dt / √((t + x)(t + y)(t + z)) and R_D = (3/2) ∫₀^∞ dt / ((t + z) √(…)).

    Both from the same duplications. Source: Carlson 1995; DLMF 19.36.1 and 19.36.2.

    **Arguments:**

    - `x`, `y`: not negative, at most one of them zero.
    - `z`: positive.
    """

    def double(_, carry):
        x, y, z, total, scale = carry
        x, y, z, part = _doubled(x, y, z)
        return x, y, z, total + scale * part, scale / 4

    # A loop: if unrolled, the compiler's fusion triples the work with every duplication.
    start = (x, y, z, jnp.zeros_like(z), jnp.ones_like(z))
    x, y, z, total, scale = jax.lax.fori_loop(0, _DOUBLINGS, double, start)
    return _first_kind(x, y, z), 3 * total + scale * _second_kind(x, y, z)


def _first_kind(x, y, z):
    """R_F of nearly equal arguments."""
    mean = (x + y + z) / 3
    first, second = 1 - x / mean, 1 - y / mean
    third = -first - second
    two, three = first * second - third**2, first * second * third
    series = 1 - two / 10 + three / 14 + two**2 / 24 - 3 * two * three / 44
    return series / jnp.sqrt(mean)


def _second_kind(x, y, z):
    """R_D of nearly equal arguments."""
    mean = (x + y + 3 * z) / 5
    first, second = 1 - x / mean, 1 - y / mean
    third = -(first + second) / 3
    product = first * second
    two = product - 6 * third**2
    three = (3 * product - 8 * third**2) * third
    four = 3 * (product - third**2) * third**2
    five = product * third**3
    series = 1 - 3 * two / 14 + three / 6 + 9 * two**2 / 88 - 3 * four / 22
    series = series - 9 * two * three / 52 + 3 * five / 26
    return series / (mean * jnp.sqrt(mean))
