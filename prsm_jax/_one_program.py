"""Public functions that are compiled as a whole, wherever they are called from."""

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

_Given = ParamSpec("_Given")
_Found = TypeVar("_Found")
_Tree = TypeVar("_Tree")


def one_program(function: Callable[_Given, _Found]) -> Callable[_Given, _Found]:
    """Have a public function run as one compiled program.

    Called operation by operation it takes hundreds of times as long. Under `jax.jit`, `jax.vmap`
    and `jax.grad` of a user the program is part of his.

    Numbers are traced, Python's floats and NumPy's arrays too, so that a new one does not compile
    anew; whatever else is given (integers, words, functions) is static and must be hashable.
    """
    program = one_program_where_possible(function)

    @functools.wraps(function)
    def run(*args: _Given.args, **kwargs: _Given.kwargs) -> _Found:
        args, kwargs = traceable((args, kwargs))
        return program(*args, **kwargs)

    return run


def traceable(tree: _Tree) -> _Tree:
    """With arrays of one kind in place of all numbers that a program is to take as its input.

    Numbers in a user's own function stay what they are: an array where he has given a float could
    be one that his function cannot take.
    """
    return jax.tree.map(_traceable, tree, is_leaf=_is_of_a_user)


def is_known(tree) -> bool:
    """Whether numbers may be looked at: none is traced, nor would what is calculated of them be."""
    leaves = (*jax.tree.leaves(tree), jnp.zeros(()))
    return not any(isinstance(leaf, Tracer) for leaf in leaves)


def one_program_where_possible(function: Callable[_Given, _Found]) -> Callable[_Given, _Found]:
    """A part of a public function as one compiled program, of arguments that are `traceable`.

    Functions among them are told apart by what they are, not by what they do: they have to be pure.
    With one that cannot be told apart, the part runs operation by operation.
    """
    program = eqx.filter_jit(function)

    @functools.wraps(function)
    def run(*args: _Given.args, **kwargs: _Given.kwargs) -> _Found:
        return (program if _can_be_kept((args, kwargs)) else function)(*args, **kwargs)

    return run


def _can_be_kept(tree) -> bool:
    leaves, structure = jax.tree.flatten(tree)
    try:
        hash((structure, *(leaf for leaf in leaves if not eqx.is_array(leaf))))
    except TypeError:
        return False
    return True


def _is_of_a_user(value) -> bool:
    return callable(value) and not type(value).__module__.startswith(f"{__package__}.")


def _traceable(value):
    if _is_of_a_user(value):
        return jax.tree.map(_strong, value)
    if isinstance(value, float):
        return jnp.asarray(value, jnp.result_type(float))
    if isinstance(value, np.ndarray | np.floating):
        return jnp.asarray(value)
    return _strong(value)


def _strong(value):
    # An array of JAX that was made of a Python number has a weak type, which is another program.
    if isinstance(value, jax.Array) and value.weak_type:
        return jax.lax.convert_element_type(value, value.dtype)
    return value
