"""Inverses whose derivatives are products of themselves, without another division.

A division takes as long as eight multiplications, and JAX's derivative of one divides again, once
for each direction.
"""

import jax
from jaxtyping import Array, Float


# Compiled as one function, so that all calls are the same operation.
@jax.jit
@jax.custom_jvp
def inverse(value: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """`1/x`."""
    return 1 / value


@inverse.__wrapped__.defjvp
def _inverse_jvp(primals, tangents):
    found = inverse(*primals)
    return found, -found * found * tangents[0]


@jax.jit
@jax.custom_jvp
def inverse_root(value: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """`1/√x` of a number above 0."""
    return jax.lax.rsqrt(value)


@inverse_root.__wrapped__.defjvp
def _inverse_root_jvp(primals, tangents):
    found = inverse_root(*primals)
    return found, -0.5 * found * found * found * tangents[0]


__all__ = ["inverse", "inverse_root"]


@jax.jit
@jax.custom_jvp
def quotient(dividend: Float[Array, "*batch"], divisor: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """`a/b`."""
    return dividend / divisor


@quotient.__wrapped__.defjvp
def _quotient_jvp(primals, tangents):
    found = quotient(*primals)
    return found, (tangents[0] - found * tangents[1]) * inverse(primals[1])
