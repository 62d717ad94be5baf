"""Check that a public function receives one design, and numbers that are scalars."""

import dataclasses
import functools
import inspect
import sys
import types
import typing
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, ParamSpec, TypeVar

import equinox as eqx
import jax
import numpy as np

from ..fields import Limited, members, refuse_complex

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


class _Declared(NamedTuple):
    """An array field of a module: its number of axes, and whether it may be absent."""

    axes: int
    required: bool


@functools.cache
def _axes_of(kind: type) -> dict[str, _Declared | None]:
    """The array fields of a module; `None` for all other fields."""
    try:
        hints = typing.get_type_hints(kind)
    except NameError:
        # A class of a user, whose annotations name what is not there at run time.
        return {}
    axes: dict[str, _Declared | None] = {}
    for field in dataclasses.fields(kind):
        if field.metadata.get("static", False):
            continue
        among = members(hints[field.name])
        words = [getattr(one, "dim_str", None) for one in among]
        declared = [w.split() for w in words if w is not None]
        fixed = len(declared) == 1 and not any("*" in w or "..." in w for w in declared[0])
        required = types.NoneType not in among
        axes[field.name] = _Declared(len(declared[0]), required) if fixed else None
    return axes


def _declared(module: eqx.Module, path: str) -> Iterator[tuple[int | None, int, str]]:
    """Leaf, number of axes and path of every array of a module whose leaves are their indices.

    The leaf is `None` where a number that must be there is absent.
    """
    for name, declared in _axes_of(type(module)).items():
        value = getattr(module, name)
        if value is None and declared is not None and declared.required:
            yield None, declared.axes, f"{path}{name}"
        for at, one in _items(value, f"{path}{name}"):
            if isinstance(one, eqx.Module):
                yield from _declared(one, f"{at}.")
            elif declared is not None and isinstance(one, int):
                yield one, declared.axes, at


def _misplaced(module: eqx.Module, path: str = "") -> Iterator[str]:
    """Parts of another class than their field declares, which `eqx.tree_at` has put there."""
    try:
        hints = typing.get_type_hints(type(module))
    except NameError:
        return
    for field in dataclasses.fields(module):
        among = members(hints[field.name])
        classes = [m for m in among if isinstance(m, type) and issubclass(m, eqx.Module)]
        only = classes and all(m in classes or m is types.NoneType for m in among)
        for at, one in _items(getattr(module, field.name), f"{path}{field.name}"):
            # Leaves are indices here.
            leaf = isinstance(one, int) and not field.metadata.get("static", False)
            if (
                only
                and (leaf or isinstance(one, eqx.Module))
                and not isinstance(one, tuple(classes))
            ):
                wanted = " or ".join(c.__name__ for c in classes)
                kind = "number" if leaf else type(one).__name__
                yield f"{at} is a {kind}, and must be a {wanted}"
            if isinstance(one, eqx.Module):
                yield from _misplaced(one, f"{at}.")


@functools.lru_cache(maxsize=256)
def _first_misplaced(structure: Any) -> str:
    return next(_misplaced(jax.tree.unflatten(structure, range(structure.num_leaves))), "")


def _items(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, tuple | list):
        for index, one in enumerate(value):
            yield f"{path}[{index}]", one
    else:
        yield path, value


@functools.lru_cache(maxsize=256)
def _axes(structure: Any) -> tuple[tuple[int | None, int, str], ...]:
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
    kind = type(module).__name__.lower()

    def remedy() -> str:
        if not mappable:
            return "call it with each design, one after the other"
        return f"map it over the batch: jax.vmap(prsm.{where})({kind})"

    _check_numbers(module, where, "", "designs", kind, remedy)


def _check_numbers(
    module: eqx.Module,
    where: str,
    owner: str,
    batch: str,
    kind: str,
    remedy: Callable[[], str],
) -> None:
    leaves, structure = jax.tree.flatten(module)
    if wrong := _first_misplaced(structure):
        raise ValueError(f"{where}: {owner}{wrong}; derive its class from that one")
    for index, axes, path in _axes(structure):
        leaf = None if index is None else leaves[index]
        if leaf is None or isinstance(leaf, str | bytes):
            raise ValueError(
                f"{where}: {owner}{path} is {leaf!r}, and must be a number in SI units, such as "
                "12e-3 for 12 mm"
            )
        if np.ndim(leaf) > axes:
            raise ValueError(
                f"{where}: {owner}{path} has the shape {np.shape(leaf)}, so this is a batch of "
                f"{batch}, and {where} takes one {kind}; {remedy()}"
            )


class _Door:
    """What a public function takes: one design, other parts of one scene, and single numbers.

    **Arguments:**

    - `function`: the function; the annotations of its arguments say what it takes.
    - `mappable`: whether it can be mapped by `jax.vmap`.
    - `batched`: whether it takes batches as well, so that only kinds are checked.
    """

    def __init__(self, function: Callable[..., Any], *, mappable: bool, batched: bool):
        self.name = getattr(function, "__name__", "this function")
        self.module = getattr(function, "__module__", "")
        self.mappable, self.batched = mappable, batched
        arguments = inspect.signature(function).parameters
        self.arguments = tuple(arguments)
        self.needed = tuple(n for n, one in arguments.items() if one.default is one.empty)
        among_of = {name: members(one.annotation) for name, one in arguments.items()}
        #: Arguments that are single numbers.
        self.numbers = frozenset(
            name for name, among in among_of.items() if any(map(_is_scalar, among))
        )
        #: Classes of the arguments that are modules.
        self.modules = {
            name: classes
            for name, among in among_of.items()
            if (classes := tuple(one for one in among if one is not types.NoneType))
            and all(isinstance(one, type) and issubclass(one, eqx.Module) for one in classes)
        }

    def check(self, args: tuple[Any, ...], kwargs: dict[str, Any]) -> None:
        """Refuse arguments of another kind, and those with an axis too many.

        **Raises:** `ValueError`, naming the argument and the first number that does not fit.
        """
        for name, value in (*zip(self.arguments, args, strict=False), *kwargs.items()):
            if name in self.numbers:
                self._check_number(name, value)
            elif name in self.modules:
                if not isinstance(value, self.modules[name]):
                    # The function itself decides whether it does without.
                    if value is None and name not in self.needed:
                        continue
                    self._refuse_kind(name, value)
                elif not self.batched:
                    self._check_one(name, value)
            elif isinstance(value, Limited) and not self.batched:
                self._check_one(name, value)

    def _check_number(self, name: str, value: Any) -> None:
        """An argument that is a single number must not be a list, a text or an array with axes."""
        shape = _shape(value)
        if shape:
            raise ValueError(
                f"{self.name}: {name} has the shape {shape}, and {self.name} takes one {name}; "
                f"{self._remedy(name)}"
            )
        if isinstance(value, str | bytes):
            raise ValueError(
                f"{self.name}: {name} is the text {value!r}, and must be a number in SI units"
            )
        refuse_complex(f"{self.name}: {name}", value)

    def _refuse_kind(self, name: str, value: Any) -> None:
        classes = " or ".join(f"a {_words(one)}" for one in self.modules[name])
        given = f"the text {value!r}" if isinstance(value, str) else _short(value)
        remedy = ""
        if isinstance(value, str) and "mechanism" in classes:
            remedy = f"; load it: prsm.load({value!r})"
        where = self.name if name == self.arguments[0] else f"{self.name}: {name}"
        verb = "takes" if name == self.arguments[0] else "must be"
        raise ValueError(f"{where} {verb} {classes}, not {given}{remedy}")

    def _check_one(self, name: str, module: eqx.Module) -> None:
        first = name == self.arguments[0]
        kind = type(module).__name__.lower() if first else name
        batch = "designs" if first else f"{name}s"
        path = "" if first else f"{name}."
        _check_numbers(module, self.name, path, batch, kind, lambda: self._remedy(name, kind))

    def _remedy(self, name: str, kind: str = "") -> str:
        """How to call the function for each one of several `name`."""
        first = name == self.arguments[0]
        if not self.mappable:
            return f"call it with each {'design' if first else name}, one after the other"
        place = _place(self.module, self.name)
        if first and self.needed == (name,):
            return f"map it over the batch: jax.vmap({place})({kind})"
        given = ", ".join(
            one if one in self.needed else f"{one}={one}"
            for one in self.arguments
            if one in self.needed or one == name
        )
        return f"map it over the batch: jax.vmap(lambda {name}: {place}({given}))({name}s)"


def _is_scalar(hint: Any) -> bool:
    """Whether the annotation of an argument is that of an array without axes."""
    return getattr(hint, "dim_str", None) == ""


def _shape(value: Any) -> tuple[int, ...]:
    """Shape of a number, an array, or a list of numbers, which may be traced."""
    if isinstance(value, list | tuple):
        return (len(value), *(_shape(value[0]) if value else ()))
    return np.shape(value) if hasattr(value, "shape") else ()


def _words(kind: type) -> str:
    """`Scenario`, but `mechanism`, `stage`, `thread`: what is read from a file."""
    return kind.__name__.lower() if kind.__module__.startswith(_ROOM) else kind.__name__


_ROOM = __name__.rpartition(".")[0]


def _short(value: object) -> str:
    words = repr(value)
    if "\n" in words or len(words) > _LONGEST:
        words = f"{type(value).__module__}.{type(value).__name__}"
    return words


#: Longest text of a value in a message.
_LONGEST = 60


def _place(module: str, name: str) -> str:
    """How a user calls a public function: `prsm.modal`, or `prsm.load_sharing.force_deflection`."""
    package, room, *_ = f"{module}..".split(".")
    if name in dir(sys.modules.get(package)):
        return f"prsm.{name}"
    return f"prsm.{room}.{name}"


def of_one_design(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """A public function whose first argument, a mechanism or a part, must not be a batch."""
    return _checked(function, mappable=True)


def of_one_known_design(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """As `of_one_design`, for a function that reads values: `jax.vmap` cannot map it."""
    return _checked(function, mappable=False)


def of_designs(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """A public function whose first argument is a mechanism or a part, or a batch of them."""
    return _checked(function, mappable=True, batched=True)


def _checked(
    function: Callable[_Parameters, _Result], *, mappable: bool, batched: bool = False
) -> Callable[_Parameters, _Result]:
    door = _Door(function, mappable=mappable, batched=batched)

    @functools.wraps(function)
    def run(*args: _Parameters.args, **kwargs: _Parameters.kwargs) -> _Result:
        door.check(args, kwargs)
        return function(*args, **kwargs)

    return run
