"""While tests run, the package's functions refuse shapes and classes that they do not name."""

import jax.numpy as jnp
import jaxtyping
import pytest
from jaxtyping import Array, Float

from prsm_jax.contact.hertz import _approximations
from tests.shape_checks import checked


def _one_number(x: Float[Array, ""], name: str = "x") -> Float[Array, ""]:
    return x


def _products(x: Float[Array, " n"], y: Float[Array, " n"]) -> Float[Array, "n n"]:
    return x[:, None] * y[None, :] if x.shape[0] < 5 else x


def test_a_wrong_class_shape_or_size_is_refused():
    one, two = checked(_one_number), checked(_products)
    assert one(jnp.zeros(()), name="y") == 0.0
    assert two(jnp.ones(3), jnp.ones(3)).shape == (3, 3)
    for call in (
        lambda: one(1.0),
        lambda: one(jnp.zeros(2)),
        lambda: one(jnp.zeros(()), name=3),
        lambda: two(jnp.ones(3), jnp.ones(4)),
        lambda: two(jnp.ones(5), jnp.ones(5)),
    ):
        with pytest.raises(jaxtyping.TypeCheckError):
            call()


def test_functions_of_the_package_are_checked():
    with pytest.raises(jaxtyping.TypeCheckError):
        _approximations.power(jnp.zeros(3))


def test_checks_can_be_switched_off(unchecked):
    assert checked(_one_number)(1.0) == 1.0
