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

    `jax.grad` and `jax.vjp` outside of any program run two: one for the value, and one for the
    derivative that begins with the arguments. Between them JAX takes some 50 µs for every number.
    """
    program = one_program_where_possible(function)
    in_two = one_program_where_possible(_keeping_arguments(function))

    @functools.wraps(function)
    def run(*args: _Given.args, **kwargs: _Given.kwargs) -> _Found:
        args, kwargs = traceable((args, kwargs))
        leaves, structure = jax.tree.flatten((args, kwargs))
        moving = [leaf if _moves(leaf) else None for leaf in leaves]
        # Inside a program what is new is traced as well, whatever the arguments are.
        if all(leaf is None for leaf in moving) or isinstance(jnp.zeros(()), Tracer):
            return program(*args, **kwargs)
        known = [leaf if one is None else None for leaf, one in zip(leaves, moving, strict=True)]
        return in_two(moving, known, structure)

    return run


def _keeping_arguments(function: Callable[..., _Found]) -> Callable[..., _Found]:
    """A function whose reverse mode keeps nothing but its arguments and calculates the rest anew.

    It takes the leaves of its arguments that are differentiated or mapped, those that are not, with
    `None` in each other's places, and the structure of all.
    """
    anew = eqx.filter_checkpoint(
        lambda given: function(*given[0], **given[1]),
        prevent_cse=False,  # type: ignore[call-arg]
    )

    def run(moving, known, structure) -> _Found:
        # Of a number that does not count JAX makes a derivative of 0 by itself, one by one, unless
        # the program gives it.
        numbers = [leaf for leaf in moving if leaf is not None]
        places = iter(jax.lax.optimization_barrier(numbers))
        leaves = [
            other if leaf is None else next(places)
            for leaf, other in zip(moving, known, strict=True)
        ]
        return anew(jax.tree.unflatten(structure, leaves))

    run.__name__ = run.__qualname__ = function.__name__
    return run


def _moves(leaf) -> bool:
    return isinstance(leaf, Tracer) and jnp.issubdtype(leaf.dtype, jnp.inexact)


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
    return callable(value) and not type(value).__module__.startswith("prsm_jax.")


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
