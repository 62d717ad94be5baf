"""Jacobi elliptic functions sn, cn and dn of the complementary modulus, real and complex."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

Real = Float[Array, "*batch"]

#: Number of Landen transformations; rounding is reached for κ down to 1e-10.
_STEPS = 8


class Jacobi(NamedTuple):
    """sn, cn and dn of one argument."""

    sn: Array
    cn: Array
    dn: Array


def _delta(sn: Array, cn: Array, axis_ratio: Array) -> Array:
    """dn = √(1 − m sn²) without cancellation where it is small."""
    return jnp.sqrt(cn**2 + (axis_ratio * sn) ** 2)


def jacobi_of_fraction(fraction: Real, axis_ratio: Float[Array, ""]) -> Jacobi:
    """sn, cn and dn at the argument f K(m), m = 1 − κ².

    By descending Landen transformations along the arithmetic–geometric mean; DLMF 22.20(ii).

    **Arguments:**

    - `fraction`: argument in quarter periods, 0 to 1.
    - `axis_ratio`: κ in (0, 1].
    """
    arithmetic, geometric = jnp.ones_like(axis_ratio), axis_ratio
    quotients = []
    for _ in range(_STEPS):
        following = (arithmetic + geometric) / 2
        quotients.append((arithmetic - geometric) / (2 * following))
        arithmetic, geometric = following, jnp.sqrt(arithmetic * geometric)
    # K = π/(2 a_N), so the last amplitude, 2^N a_N u, does not need K.
    amplitude = 2.0**_STEPS * (jnp.pi / 2) * fraction
    for quotient in reversed(quotients):
        amplitude = (amplitude + jnp.arcsin(quotient * jnp.sin(amplitude))) / 2
    sn, cn = jnp.sin(amplitude), jnp.cos(amplitude)
    return Jacobi(sn, cn, _delta(sn, cn, axis_ratio))


def jacobi_of_direction(cosine: Real, sine: Real, axis_ratio: Float[Array, ""]) -> Jacobi:
    """sn, cn and dn at the argument whose amplitude has this sine and cosine."""
    return Jacobi(sine, cosine, _delta(sine, cosine, axis_ratio))


def jacobi_sum(first: Jacobi, second: Jacobi, axis_ratio: Float[Array, ""]) -> Jacobi:
    """sn, cn and dn of a sum of two arguments; DLMF 22.8."""
    parameter = (1 - axis_ratio) * (1 + axis_ratio)
    # 1 − m sn² sn², as a sum.
    below = first.cn**2 + (first.sn * second.dn) ** 2
    sn = first.sn * second.cn * second.dn + second.sn * first.cn * first.dn
    cn = first.cn * second.cn - first.sn * first.dn * second.sn * second.dn
    dn = first.dn * second.dn - parameter * first.sn * first.cn * second.sn * second.cn
    return Jacobi(sn / below, cn / below, dn / below)


def jacobi_complex(
    real: Jacobi, imaginary: Jacobi, axis_ratio: Float[Array, ""]
) -> tuple[Complex[Array, "*batch"], Complex[Array, "*batch"], Complex[Array, "*batch"]]:
    """sn, cn and dn of u + i v from those of u (modulus √m) and of v (modulus κ); DLMF 22.8."""
    parameter = (1 - axis_ratio) * (1 + axis_ratio)
    below = imaginary.cn**2 + parameter * (real.sn * imaginary.sn) ** 2
    sn = (real.sn * imaginary.dn, real.cn * real.dn * imaginary.sn * imaginary.cn)
    cn = (real.cn * imaginary.cn, -real.sn * real.dn * imaginary.sn * imaginary.dn)
    dn = (
        real.dn * imaginary.cn * imaginary.dn,
        -parameter * real.sn * real.cn * imaginary.sn,
    )
    first, second, third = (jax.lax.complex(a / below, b / below) for a, b in (sn, cn, dn))
    return first, second, third
