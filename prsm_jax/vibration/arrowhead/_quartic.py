"""Four real roots of a quartic in closed form, each with relative accuracy of about 1e-9."""

import jax.numpy as jnp

from ...fields import Scalar
from ...numerics import polynomial

#: Polynomial in u = √((1 + r)/2) of cos(arccos(r)/3), by Chebyshev interpolation: 5e-10. In u
#: the function has no root singularity at r = −1, and no arccosine is needed.
_COSINE_OF_THIRD = (
    0.500000000546,
    0.577350159555,
    -0.111107417671,
    0.0534091939,
    -0.0325814710028,
    0.0214679647606,
    -0.0133677688567,
    0.00671727328208,
    -0.00224476682743,
    0.000356832615216,
)


def quartic_roots(
    first: Scalar, second: Scalar, third: Scalar, fourth: Scalar
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Roots, ascending, of `x⁴ − e₁ x³ + e₂ x² − e₃ x + e₄` with four real roots ≥ 0.

    The quartic is split into the factors of its two large and its two small roots (Ferrari). The
    larger product of a pair is found from the largest root of the resolvent cubic (Viète), in
    which nothing cancels; the rest follows from the products and sums of all roots. So a small
    root is as accurate, relative to itself, as a large one. Where roots nearly coincide,
    accuracy falls to 1e-7, or to 1e-4 for four roots.

    **Arguments:**

    - `first` to `fourth`: the elementary symmetric functions e₁ … e₄ of the roots; each must be
      accurate relative to itself.
    """
    linear = first * third - 4 * fourth
    constant = third * third + fourth * (first * first - 4 * second)
    spread = jnp.maximum(second * second - 3 * linear, 0.0) / 9
    skew = (second * (2 * second * second - 9 * linear) + 27 * constant) / 54
    root = jnp.sqrt(spread)
    cube = spread * root
    ratio = jnp.clip(skew / jnp.where(cube > 0, cube, 1.0), -1.0, 1.0)
    half = jnp.sqrt((1 + ratio) / 2)
    cosine = polynomial(_COSINE_OF_THIRD, half)
    # The sum of the products of both pairs.
    products = second / 3 + 2 * root * cosine

    large_product = (products + _root(products * products - 4 * fourth)) / 2
    large_product = jnp.where(large_product > 0, large_product, 1.0)
    small_product = fourth / large_product
    difference = large_product - small_product
    distinct = difference > 1e-7 * large_product
    small_sum = (third - small_product * first) / jnp.where(distinct, difference, 1.0)
    small_sum = jnp.clip(jnp.where(distinct, small_sum, first / 2), 0.0, first / 2)
    large_sum = first - small_sum

    highest = (large_sum + _root(large_sum * large_sum - 4 * large_product)) / 2
    high = large_product / jnp.where(highest > 0, highest, 1.0)
    low = (small_sum + _root(small_sum * small_sum - 4 * small_product)) / 2
    lowest = small_product / jnp.where(low > 0, low, 1.0)
    return lowest, low, high, highest


def _root(square: Scalar) -> Scalar:
    return jnp.sqrt(jnp.maximum(square, 0.0))
