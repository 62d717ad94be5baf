"""Quotients and inverse roots whose derivatives take one division in all directions.

A division takes as long as several multiplications. The derivative of JAX divides in each
direction, and once more for the square of the divisor.
"""

import jax
from jaxtyping import Array, Float


@jax.custom_jvp
def _quotient(dividend, divisor):
    return dividend / divisor


@_quotient.defjvp
def _quotient_jvp(primals, tangents):
    found = quotient(*primals)
    return found, (tangents[0] - found * tangents[1]) * inverse(primals[1])


@jax.custom_jvp
def _reciprocal(value):
    return 1 / value


@_reciprocal.defjvp
def _reciprocal_jvp(primals, tangents):
    found = inverse(*primals)
    return found, -found * found * tangents[0]


@jax.custom_jvp
def _inverse_root(square):
    return jax.lax.rsqrt(square)


@_inverse_root.defjvp
def _inverse_root_jvp(primals, tangents):
    found = inverse_root(*primals)
    return found, -0.5 * found * found * found * tangents[0]


# As compiled functions all calls are the same operation, which `merged` recognises.


@jax.jit
def inverse(value: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """`1/x`."""
    return _reciprocal(value)


@jax.jit
def quotient(
    dividend: Float[Array, "*batch"], divisor: Float[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """`a/b` of two numbers, or of two arrays of the same shape."""
    return _quotient(dividend, divisor)


@jax.jit
def inverse_root(square: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """`1/√x` of a number above 0."""
    return _inverse_root(square)


__all__ = ["inverse", "inverse_root", "quotient"]
