"""Check that a public function receives one design, whose numbers are scalars."""

import dataclasses
import functools
import types
import typing
from collections.abc import Callable, Iterator
from typing import Any, ParamSpec, TypeVar

import equinox as eqx
import jax
import numpy as np

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


@functools.cache
def _axes_of(kind: type) -> dict[str, int | None]:
    """Number of axes of each array field of a module; `None` for all other fields."""
    hints = typing.get_type_hints(kind)
    axes: dict[str, int | None] = {}
    for field in dataclasses.fields(kind):
        if field.metadata.get("static", False):
            continue
        hint = hints[field.name]
        union = typing.get_origin(hint) in (typing.Union, types.UnionType)
        among = typing.get_args(hint) if union else (hint,)
        words = [getattr(one, "dim_str", None) for one in among]
        declared = [w.split() for w in words if w is not None]
        fixed = len(declared) == 1 and not any("*" in w or "..." in w for w in declared[0])
        axes[field.name] = len(declared[0]) if fixed else None
    return axes


def _declared(module: eqx.Module, path: str) -> Iterator[tuple[int, int, str]]:
    """Leaf, number of axes and path of every array of a module whose leaves are their indices."""
    for name, axes in _axes_of(type(module)).items():
        for at, one in _items(getattr(module, name), f"{path}{name}"):
            if isinstance(one, eqx.Module):
                yield from _declared(one, f"{at}.")
            elif axes is not None and isinstance(one, int):
                yield one, axes, at


def _items(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, tuple | list):
        for index, one in enumerate(value):
            yield f"{path}[{index}]", one
    else:
        yield path, value


@functools.lru_cache(maxsize=256)
def _axes(structure: Any) -> tuple[tuple[int, int, str], ...]:
    # Walking through the modules takes ten times as long as listing their leaves.
    return tuple(_declared(jax.tree.unflatten(structure, range(structure.num_leaves)), ""))


def check_one_design(module: eqx.Module, where: str, *, mappable: bool = True) -> None:
    """Refuse a batch of designs where one design is required.

    **Arguments:**

    - `module`: a mechanism or a part of one.
    - `where`: the name of the function that received it.
    - `mappable`: whether that function can be mapped by `jax.vmap`.

    **Raises:** `ValueError`, naming the first number that has too many axes.
    """
    leaves, structure = jax.tree.flatten(module)
    for index, axes, path in _axes(structure):
        if np.ndim(leaves[index]) > axes:
            kind = type(module).__name__.lower()
            remedy = "call it with each design, one after the other"
            if mappable:
                remedy = f"map it over the batch: jax.vmap(prsm.{where})({kind})"
            raise ValueError(
                f"{where}: {path} has the shape {np.shape(leaves[index])}, so this is a batch of "
                f"designs, and {where} takes one {kind}; {remedy}"
            )


def of_one_design(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """A public function whose first argument, a mechanism or a part, must not be a batch."""
    return _checked(function, mappable=True)


def of_one_known_design(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """As `of_one_design`, for a function that reads values: `jax.vmap` cannot map it."""
    return _checked(function, mappable=False)


def _checked(
    function: Callable[_Parameters, _Result], *, mappable: bool
) -> Callable[_Parameters, _Result]:
    name = getattr(function, "__name__", "this function")

    @functools.wraps(function)
    def run(*args: _Parameters.args, **kwargs: _Parameters.kwargs) -> _Result:
        module = args[0] if args else next(iter(kwargs.values()), None)
        if isinstance(module, eqx.Module):
            check_one_design(module, name, mappable=mappable)
        return function(*args, **kwargs)

    return run
