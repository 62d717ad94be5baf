"""Results of one design and of a batch of them: the same properties for both.

`jax.vmap` of a public function gives a result whose arrays all have the axes of the batch in front.
Properties derived from these arrays are written for one design, and mapped here over those axes.
"""

import abc
import contextlib
import functools
from collections.abc import Callable, Generator, Iterator
from typing import Any, Concatenate, ParamSpec, TypeVar

import equinox as eqx
import jax
import numpy as np

_Params = ParamSpec("_Params")
_Return = TypeVar("_Return")
_Own = TypeVar("_Own", bound="AbstractResult")


class AbstractResult(eqx.Module):
    """What an analysis returns: for one design, or under `jax.vmap` for a batch of them."""

    @property
    @abc.abstractmethod
    def batch_shape(self) -> tuple[int, ...]:
        """Shape of the batch of designs; empty for a single design."""


def mapped(
    method: Callable[Concatenate[_Own, _Params], _Return],
) -> Callable[Concatenate[_Own, _Params], _Return]:
    """A method or property of one design that returns arrays, mapped over a batch of them."""

    @functools.wraps(method)
    def run(result: _Own, /, *args: _Params.args, **kwargs: _Params.kwargs) -> _Return:
        def of_one(one: _Own) -> _Return:
            return method(one, *args, **kwargs)

        call: Callable[[_Own], _Return] = of_one
        for _ in result.batch_shape:
            call = jax.vmap(call)
        return call(result)

    return run


def listed(
    method: Callable[Concatenate[_Own, _Params], Any],
) -> Callable[Concatenate[_Own, _Params], Any]:
    """A method or property of one design that returns words or Python numbers.

    For a batch it gives a NumPy array of them, whose first axes are those of the batch.
    """

    @functools.wraps(method)
    def run(result: _Own, /, *args: _Params.args, **kwargs: _Params.kwargs) -> Any:
        shape = result.batch_shape
        with _known(result, method.__name__):
            if not shape:
                return method(result, *args, **kwargs)
            values = [method(one, *args, **kwargs) for _, one in _designs(result)]
        return np.reshape(np.asarray(values), shape + np.shape(values[0]))

    return run


def each(
    method: Callable[Concatenate[_Own, _Params], Any],
) -> Callable[Concatenate[_Own, _Params], Any]:
    """A method of one design that returns an object whose length depends on the design.

    For a batch it gives a NumPy array of objects, one for each design.
    """

    @functools.wraps(method)
    def run(result: _Own, /, *args: _Params.args, **kwargs: _Params.kwargs) -> Any:
        with _known(result, method.__name__):
            if not result.batch_shape:
                return method(result, *args, **kwargs)
            objects = np.empty(result.batch_shape, object)
            for index, one in _designs(result):
                objects[index] = method(one, *args, **kwargs)
            return objects

    return run


@contextlib.contextmanager
def _known(result: AbstractResult, name: str) -> Generator[None, None, None]:
    """Say what to do inside a trace, where there are no values to take words from.

    **Raises:** `TypeError`.
    """
    try:
        yield
    except (jax.errors.ConcretizationTypeError, jax.errors.TracerArrayConversionError) as error:
        kind = type(result).__name__
        remedy = f"read .{name} from the result, outside of jax.jit, jax.vmap and jax.grad"
        if getattr(result, "code", None) is not None:
            remedy = f"use .code inside a trace, or {remedy}"
        raise TypeError(
            f"{kind}.{name} depends on values, which are not known inside a trace; {remedy}"
        ) from error


def _designs(result: _Own) -> Iterator[tuple[tuple[int, ...], _Own]]:
    """Every design of a batch and its place."""
    numbers, rest = eqx.partition(result, eqx.is_array)
    numbers = jax.device_get(numbers)
    for index in np.ndindex(*result.batch_shape):
        yield index, _one(numbers, rest, index)


def _one(numbers, rest, index: tuple[int, ...]):
    return eqx.combine(jax.tree.map(lambda array: array[index], numbers), rest)
