"""Words of a result inside a trace, where there are no values to take them from."""

import jax
import jax.numpy as jnp
import pytest

import prsm_jax as prsm

_MECHANISM = prsm.load("wu2022")


def test_words_of_a_code_inside_a_trace():
    expected = (
        r"^SteadyState\.result depends on values, which are not known inside a trace; use \.code "
        r"inside a trace, or read \.result from the result, outside of jax\.jit, jax\.vmap and "
        r"jax\.grad"
    )
    with pytest.raises(TypeError, match=expected):
        jax.jit(lambda m: prsm.steady_state(m).result)(_MECHANISM)
    with pytest.raises(TypeError, match=r"^SteadyState\.result_name depends on values"):
        jax.vmap(lambda load: prsm.steady_state(_MECHANISM, load=load).result_name)(jnp.ones(2))


def test_families_inside_a_trace():
    expected = (
        r"^Modes\.families depends on values, which are not known inside a trace; read \.families "
        r"from the result, outside of jax\.jit"
    )
    with pytest.raises(TypeError, match=expected):
        jax.jit(lambda m: prsm.modal(m).families)(_MECHANISM)
