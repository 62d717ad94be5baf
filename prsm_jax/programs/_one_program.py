"""Public functions that run as one compiled program, wherever they are called from."""

import functools
import inspect
import typing
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array

from ._one_verb import runs_one_verb
from ._origin import origin_of
from ._stored import is_foreign, nothing, prepare, run_stored, used_program

_Params = ParamSpec("_Params")
_Return = TypeVar("_Return")
_Tree = TypeVar("_Tree")
#: Functions whose programs run often.
_repeated: set[Callable[..., Any]] = set()


def one_program(function: Callable[_Params, _Return]) -> Callable[_Params, _Return]:
    """Run a public function as one compiled program.

    Operation by operation it takes hundreds of times as long. Under `jax.jit`, `jax.vmap` and
    `jax.grad` of a user the program is part of the user's program.

    Numbers are traced, including Python floats and NumPy arrays, so that a new value does not
    compile again; other arguments (integers, words, functions) are static and must be hashable.
    An argument whose annotation is that of a number (`Scalar`) is one in whatever type it is given:
    an integer does not compile again either.

    `jax.grad` and `jax.vjp` outside of a program run two: one for the value, and one for the
    derivative, which begins with the arguments. Between them JAX takes some 50 µs for every number.
    """
    program = one_program_where_possible(function)
    in_two = one_program_where_possible(_keeping_arguments(function))
    places, names = _numbers_of(function)

    @functools.wraps(function)
    def run(*args: _Params.args, **kwargs: _Params.kwargs) -> _Return:
        given = [_as_number(one) if place in places else one for place, one in enumerate(args)]
        named = {name: _as_number(one) if name in names else one for name, one in kwargs.items()}
        numbers: Any = (tuple(given), named)
        args, kwargs = traceable(numbers)
        leaves, structure = jax.tree.flatten((args, kwargs))
        moving = [leaf if _moves(leaf) else None for leaf in leaves]
        # Inside a program new arrays are traced as well, whatever the arguments are.
        if all(leaf is None for leaf in moving) or isinstance(jnp.zeros(()), Tracer):
            return program(*args, **kwargs)
        known = [leaf if one is None else None for leaf, one in zip(leaves, moving, strict=True)]
        return in_two(moving, known, structure)

    return run


def _keeping_arguments(function: Callable[..., _Return]) -> Callable[..., _Return]:
    """A function whose reverse mode stores only its arguments and calculates the rest again.

    It takes the leaves that are differentiated or mapped, the other leaves (each list has `None` in
    the places of the other), and the structure of all arguments.
    """
    anew = eqx.filter_checkpoint(
        lambda arguments: function(*arguments[0], **arguments[1]),
        prevent_cse=False,
    )

    def run(moving, known, structure) -> _Return:
        # JAX itself makes the derivative 0 of each number without influence, one by one, unless the
        # program returns it.
        numbers = [leaf for leaf in moving if leaf is not None]
        places = iter(jax.lax.optimization_barrier(numbers))
        leaves = [
            other if leaf is None else next(places)
            for leaf, other in zip(moving, known, strict=True)
        ]
        return anew(jax.tree.unflatten(structure, leaves))

    run.__name__ = run.__qualname__ = function.__name__
    return run


def _numbers_of(function: Callable[..., Any]) -> tuple[frozenset[int], frozenset[str]]:
    """Places and names of the arguments of a function that are single numbers."""
    found = [
        (place, name)
        for place, (name, one) in enumerate(inspect.signature(function).parameters.items())
        if any(
            getattr(hint, "dim_str", None) == ""
            for hint in (one.annotation, *typing.get_args(one.annotation))
        )
    ]
    return frozenset(place for place, _ in found), frozenset(name for _, name in found)


def _as_number(value: Any) -> Any:
    """A known number of any type as an array of the default type; by NumPy, without compiling.

    **Raises:** `ValueError` for a complex number, whose imaginary part would be lost.
    """
    single = isinstance(value, int | float | np.number | np.ndarray | jax.Array)
    kind = "c" if isinstance(value, complex) else getattr(getattr(value, "dtype", None), "kind", "")
    if kind == "c" and not isinstance(value, Tracer):
        raise ValueError(f"a number is complex: {value}; give real numbers")
    if not single or isinstance(value, bool | Tracer) or np.ndim(value):
        return value
    dtype = jnp.result_type(float)
    if isinstance(value, jax.Array) and value.dtype == dtype:
        return value
    return jnp.asarray(np.asarray(value, dtype))


def _moves(leaf) -> bool:
    return isinstance(leaf, Tracer) and jnp.issubdtype(leaf.dtype, jnp.inexact)


def traceable(tree: _Tree) -> _Tree:
    """A copy with strongly typed arrays in place of all numbers that are input of a program.

    Floats in a user's own function stay floats: the function may not accept arrays.
    """
    return jax.tree.map(_traceable, tree, is_leaf=_is_of_a_user)


def is_known(tree: object) -> bool:
    """Whether all numbers are known: neither they nor results calculated from them are traced."""
    leaves = (*jax.tree.leaves(tree), jnp.zeros(()))
    return not any(isinstance(leaf, Tracer) for leaf in leaves)


def one_program_where_possible(
    function: Callable[_Params, _Return], *, repeated: bool = False
) -> Callable[_Params, _Return]:
    """A part of a public function as one compiled program; its arguments must be `traceable`.

    Functions among them are compared by hash and equality, not by what they do: they must be pure.
    With one that is not hashable, the part runs operation by operation.

    **Arguments:**

    - `function`: the part.
    - `repeated`: whether a process that runs one verb runs it often, or for long.
    """
    program = eqx.filter_jit(function)
    name = _name_of(function)
    foreign = is_foreign(function)
    of_pair = _of_pair(function)

    @functools.wraps(function)
    def run(*args: _Params.args, **kwargs: _Params.kwargs) -> _Return:
        if not _can_be_kept((args, kwargs)):
            return function(*args, **kwargs)
        if runs_one_verb() and not foreign and is_known((args, kwargs)):
            words = function.__name__
            return run_stored(name, of_pair, args, kwargs, words=words, repeated=repeated)
        return program(*args, **kwargs)

    if repeated:
        _repeated.add(function)
    return run


def repeated_program(function: Callable[_Params, _Return]) -> Callable[_Params, _Return]:
    """As `one_program_where_possible`, for a part that runs often, or for long, after compiling."""
    return one_program_where_possible(function, repeated=True)


def _of_pair(function: Callable[..., _Return]) -> Callable[..., _Return]:
    def run(args, kwargs) -> _Return:
        return function(*args, **kwargs)

    return run


def _name_of(function: Callable[..., Any]) -> str:
    return ".".join(origin_of(function))


def prepare_program(
    function: Callable[..., Any], *args: Any, **kwargs: Any
) -> Callable[[], object]:
    """Begin to read or compile the stored program of a public function, beside other work.

    Only in a process that runs one verb; elsewhere nothing is done.

    **Arguments:**

    - `function`: made by `one_program_where_possible`.
    - `args`, `kwargs`: `traceable` arguments, as those of the later call.

    **Returns:** a function that waits until the program has been traced or read.
    """
    if not (runs_one_verb() and _can_be_kept((args, kwargs)) and is_known((args, kwargs))):
        return nothing
    plain = inspect.unwrap(function)
    words, repeated = plain.__name__, plain in _repeated
    return prepare(_name_of(plain), _of_pair(plain), args, kwargs, words=words, repeated=repeated)


def bind_program(function: Callable[..., Any], *given: Any) -> Callable[[Array], Any]:
    """A function whose program is called again and again with other numbers in the last place.

    To look at a mechanism for each call takes longer than the call of a compiled program.

    **Arguments:**

    - `function`: made by `one_program_where_possible`; returns arrays.
    - `given`: its `traceable` arguments but the last one.

    **Returns:** the function of its last argument, an array.
    """
    usual = functools.partial(function, *given)
    if not _can_be_kept(given):
        return usual
    plain = inspect.unwrap(function)
    if not runs_one_verb():
        leaves, structure = jax.tree.flatten(given)
        static = tuple(_ARRAY if eqx.is_array(leaf) else leaf for leaf in leaves)
        # `True` equals 1.
        program = _of_arrays(plain, structure, static, tuple(map(type, static)))
        return functools.partial(program, [leaf for leaf in leaves if eqx.is_array(leaf)])
    quick: Callable[[Array], Any] | None = None

    def run(last: Array) -> Any:
        nonlocal quick
        if quick is not None:
            return quick(last)
        found = usual(last)
        # What cannot be stored is called as usual.
        quick = used_program(_name_of(plain), (*given, last), {}) or usual
        return found

    return run


#: Stands for an array among static leaves.
_ARRAY = object()


@functools.lru_cache(maxsize=256)
def _of_arrays(
    function: Callable[..., Any], structure: Any, static: tuple[Any, ...], _: tuple[type, ...]
) -> Callable[..., Any]:
    """A compiled function of the arrays in a tree, and of a last argument."""

    def run(arrays: list[Array], last: Array) -> Any:
        rest = iter(arrays)
        leaves = [next(rest) if leaf is _ARRAY else leaf for leaf in static]
        return function(*jax.tree.unflatten(structure, leaves), last)

    return jax.jit(run)


def _can_be_kept(tree) -> bool:
    leaves, structure = jax.tree.flatten(tree)
    # JAX would keep the traced number of a function with the program, after its trace has ended.
    if any(getattr(leaf, "holds_traced", False) for leaf in leaves):
        return False
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
    # A JAX array made of a Python number has a weak type, which needs another program.
    if isinstance(value, jax.Array) and value.weak_type:
        return jax.lax.convert_element_type(value, value.dtype)
    return value
