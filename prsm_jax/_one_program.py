"""Public functions that are compiled as a whole, wherever they are called from."""

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

_Given = ParamSpec("_Given")
_Found = TypeVar("_Found")


def one_program(function: Callable[_Given, _Found]) -> Callable[_Given, _Found]:
    """Have a public function run as one compiled program.

    Called operation by operation it takes hundreds of times as long. Under `jax.jit`, `jax.vmap`
    and `jax.grad` of a user the program is part of his.

    Numbers are traced, Python's floats and NumPy's arrays too, so that a new one does not compile
    anew; whatever else is given (integers, words, functions) is static and must be hashable.
    """
    program = eqx.filter_jit(function)

    @functools.wraps(function)
    def run(*args: _Given.args, **kwargs: _Given.kwargs) -> _Found:
        args, kwargs = jax.tree.map(_traceable, (args, kwargs))
        return program(*args, **kwargs)

    return run


def _traceable(value):
    if isinstance(value, float):
        return jnp.asarray(value, jnp.result_type(float))
    if isinstance(value, np.ndarray | np.floating):
        return jnp.asarray(value)
    # An array of JAX that was made of a Python number has a weak type, which is another program.
    if isinstance(value, jax.Array) and value.weak_type:
        return jax.lax.convert_element_type(value, value.dtype)
    return value
