"""Names for every number of a mechanism, and design variables that define what else follows.

One vocabulary serves files, `--set`, sensitivities, sweeps and optimisation. A name is a dotted
path as in the file (`stage.thread.lead`, `operating_point.load`), or any ending of it that is
unambiguous (`lead`, `screw.mass`). `stage.2.lead` means the second stage; without a number it means
every stage that has the field, set together. Unequal rollers are named by their number:
`stage.1.unequal_roller.3.stiffness_factor`. Numbers of a scenario have full names only
(`scenario.speed.part.1.peak`).
"""

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, ArrayLike

from ..._errors import UnknownNameError
from ...fields import (
    ACUTE_ANGLE,
    ANY,
    OF_A_THREAD,
    STARTS,
    Declared,
    Limit,
    Scalar,
    check_number,
    check_stage,
    refuse_complex,
    values_of,
)
from .._mechanism import Mechanism, check_axis
from .._one_design import of_designs
from ..parts import Thread
from ._absent import hint_of
from ._whole_numbers import whole_number


@dataclasses.dataclass(frozen=True)
class Parameter:
    """One number of one stage (or of the operating point), with functions to read and set it.

    `get(mechanism)` and `set(mechanism, value)` are pure and traceable. `static` parameters
    (integers such as `roller_count`) cannot be differentiated: a sweep loops over them. A choice
    such as `curvature` has `words`, and is not a number.
    """

    path: str
    unit: str
    description: str
    get: Callable[[Mechanism], Any]
    set: Callable[[Mechanism, Any], Mechanism]
    static: bool = False
    limit: Limit = ANY
    words: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class DesignVariable:
    """A way to change the thread geometry: which dimension is set, and which follow."""

    name: str
    unit: str
    description: str
    get: Callable[[Thread], Scalar]
    set: Callable[[Thread, Scalar], Thread]
    limit: Limit


def _with(thread: Thread, **changes) -> Thread:
    # Not `dataclasses.replace`: it would run converters, which may reject a batched leaf.
    names = list(changes)
    return eqx.tree_at(
        lambda t: [getattr(t, name) for name in names],
        thread,
        [changes[name] for name in names],
        is_leaf=lambda leaf: leaf is None,
    )


#: Design variables in addition to the thread's numbers. Each states what is fixed and what follows.
DESIGN_VARIABLES: tuple[DesignVariable, ...] = (
    DesignVariable(
        "roller_profile_radius",
        "m",
        "radius of the roller's thread profile; r_R / sin α where the mechanism gives none",
        lambda t: t.profile_radius,
        lambda t, v: _with(t, roller_profile_radius=v),
        OF_A_THREAD,
    ),
    DesignVariable(
        "flank_angle",
        "rad",
        "flank angle α; the contact angle 90° − α follows",
        lambda t: t.flank_angle,
        lambda t, v: _with(t, contact_angle=jnp.pi / 2 - v),
        ACUTE_ANGLE,
    ),
    DesignVariable(
        "pitch",
        "m",
        "thread pitch at fixed starts; the lead n p follows",
        lambda t: t.pitch,
        lambda t, v: _with(t, lead=v * t.starts),
        OF_A_THREAD,
    ),
    DesignVariable(
        "screw_radius",
        "m",
        "nominal screw radius at fixed starts; roller, nut and centre distance follow",
        lambda t: t.screw_radius,
        lambda t, v: _with(t, roller_radius=v / t.screw_ratio),
        OF_A_THREAD,
    ),
    DesignVariable(
        "roller_radius_at_fixed_screw_radius",
        "m",
        "roller radius at fixed screw radius and lead; starts 2 + r_s/r_R follow as a real number",
        lambda t: t.roller_radius,
        lambda t, v: _with(t, roller_radius=v, **t.for_screw_ratio(t.screw_radius / v)),
        OF_A_THREAD,
    ),
    DesignVariable(
        "starts_at_fixed_pitch",
        "1",
        "number of starts at fixed pitch and roller radius; the lead n p follows",
        lambda t: t.starts,
        lambda t, v: _with(t, starts=v, lead=t.pitch * v),
        STARTS,
    ),
)

#: Numbers of starts, whose limit depends on the type of roller screw.
_STARTS = ("starts", "starts_at_fixed_pitch")


def _number_of(element, index: int) -> str:
    """Name of an element of a tuple: its own `number`, or its position from 1."""
    return str(getattr(element, "number", index + 1))


def _walk(
    module: eqx.Module, prefix: tuple[str, ...] = (), unit: str = "1"
) -> Iterator[tuple[tuple[str, ...], Declared]]:
    """Path and declaration of every number and word that is present in a module."""
    for one, value in values_of(module, unit):
        path = (*prefix, one.name)
        if isinstance(value, eqx.Module):
            yield from _walk(value, path, one.unit or unit)
        elif isinstance(value, tuple):
            # An element keeps its own number, independent of its position in the tuple.
            for index, element in enumerate(value):
                if isinstance(element, eqx.Module):
                    inner = _walk(element, (*path, _number_of(element, index)), unit)
                    yield from (entry for entry in inner if not entry[1].static)
        elif value is None or one.is_list or (callable(value) and not one.registered):
            continue
        elif one.unit is not None or one.whole or one.words:
            yield path, one


def _descend(tree, path: tuple[str, ...]):
    for name in path:
        if isinstance(tree, tuple):
            tree = next(e for index, e in enumerate(tree) if _number_of(e, index) == name)
        else:
            tree = getattr(tree, name)
    return tree


def _at(where: Callable[..., Any], static: bool, path: tuple[str, ...]):
    """Getter and setter for the number at `path` below `where(mechanism)`."""

    # No annotations on these: shape checking would decorate them again at every call.
    def get(mechanism):
        return _descend(where(mechanism), path)

    def set_traced(mechanism, value):
        return eqx.tree_at(lambda m: _descend(where(m), path), mechanism, value)

    def set_static(mechanism, value):
        value = value if isinstance(value, str) else whole_number(path[-1], value)

        def rebuild(node, names):
            if len(names) == 1:
                return dataclasses.replace(node, **{names[0]: value})
            return dataclasses.replace(
                node, **{names[0]: rebuild(getattr(node, names[0]), names[1:])}
            )

        return eqx.tree_at(where, mechanism, rebuild(where(mechanism), path))

    return get, set_static if static else set_traced


def _stage_at(index: int) -> Callable[..., Any]:
    return lambda mechanism: mechanism.stages[index]


def _design_parameter(index: int, variable: DesignVariable, thread: Thread) -> Parameter:
    def get(mechanism):
        return variable.get(mechanism.stages[index].thread)

    def set_(mechanism, value):
        moved = variable.set(mechanism.stages[index].thread, value)
        return eqx.tree_at(lambda m: m.stages[index].thread, mechanism, moved)

    return Parameter(
        f"stage.{index + 1}.thread.{variable.name}",
        variable.unit,
        variable.description,
        get,
        set_,
        limit=thread.starts_limit if variable.name in _STARTS else variable.limit,
    )


#: Where several numbers are set together: those that a name waits for, to keep its own value.
SET_AFTER: dict[str, tuple[str, ...]] = {"gear_module": ("roller_teeth",)}


def _gear_module(index: int) -> Parameter:
    """The module of the roller's gear: it sets the roller's radius, and all radii with it."""

    def get(mechanism):
        return mechanism.stages[index].gear_module

    def set_(mechanism, value):
        stage = mechanism.stages[index]
        moved = _with(stage.thread, roller_radius=value * stage.gear.roller_teeth / 2)
        return eqx.tree_at(lambda m: m.stages[index].thread, mechanism, moved)

    return Parameter(
        f"stage.{index + 1}.gear_module",
        "m",
        "module of the roller's gear at fixed teeth and starts; roller radius m z_R / 2 follows",
        get,
        set_,
        limit=OF_A_THREAD,
    )


def _numbers_and_words(mechanism: Mechanism) -> Iterator[Parameter]:
    parts = [
        (f"stage.{index + 1}", _stage_at(index), stage)
        for index, stage in enumerate(mechanism.stages)
    ]
    for name in ("operating_point", "scenario", "axis"):
        if getattr(mechanism, name) is not None:
            parts.append((name, lambda m, name=name: getattr(m, name), getattr(mechanism, name)))
    for index, (name, where, part) in enumerate(parts):
        of_stage = index < len(mechanism.stages)
        variables = []
        if of_stage:
            variables = [_design_parameter(index, v, part.thread) for v in DESIGN_VARIABLES]
        yield from variables
        if of_stage and part.gear_module is not None:
            yield _gear_module(index)
        names = {variable.path for variable in variables}
        for path, one in _walk(part):
            dotted = ".".join((name, *path))
            if dotted not in names:
                get, set_ = _at(where, one.static, path)
                unit, limit = one.unit or "1", one.limit
                if of_stage and path == ("thread", "starts"):
                    limit = part.thread.starts_limit
                yield Parameter(
                    dotted, unit, one.description, get, set_, one.static, limit, one.words
                )


def all_parameters(mechanism: Mechanism) -> tuple[Parameter, ...]:
    """Every number of a mechanism that can be set by name, stage by stage.

    In each stage the design variables, whose descriptions state what follows, come before the
    fields.
    """
    return tuple(one for one in _numbers_and_words(mechanism) if not one.words)


def _without_stage_number(path: str) -> str:
    head, _, rest = path.partition(".")
    return f"stage.{rest.partition('.')[2]}" if head == "stage" else path


def find_parameters(
    mechanism: Mechanism, name: str, *, words: bool = False
) -> tuple[Parameter, ...]:
    """The parameters that match a name: one, or one per stage if no stage is named.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `name`: a dotted path as in the file, or an unambiguous ending of one.
    - `words`: whether the name of a choice of words, such as `curvature`, is meant as well.

    **Raises:** `UnknownNameError` if no field or several different fields match.
    """
    known = tuple(_numbers_and_words(mechanism)) if words else all_parameters(mechanism)
    if not name.startswith("scenario."):
        # Numbers of a scenario match by full names only: `speed` is the operating point's.
        known = tuple(p for p in known if not p.path.startswith("scenario."))
    exact = [p for p in known if p.path == name]
    if exact:
        return tuple(exact)
    head, _, rest = name.partition(".")
    number, _, ending = rest.partition(".")
    if head == "stage" and number.isdigit():
        candidates = [p for p in known if p.path.startswith(f"stage.{number}.")]
        if not candidates:
            raise UnknownNameError(
                f"parameter {name!r}: the mechanism has {len(mechanism.stages)} stage(s)"
            )
    else:
        candidates, ending = list(known), name
    matches = [
        p for p in candidates if ("." + _without_stage_number(p.path)).endswith("." + ending)
    ]
    fields = sorted({_without_stage_number(p.path) for p in matches})
    if len(fields) > 1 and f"stage.{ending}" in fields:
        # `roller_count` is a stage's own field even if a nested field has the same name.
        fields = [f"stage.{ending}"]
        matches = [p for p in matches if _without_stage_number(p.path) == fields[0]]
    if len(fields) > 1:
        raise UnknownNameError(f"parameter {name!r} is ambiguous: {', '.join(fields)}")
    if not matches:
        paths = {_without_stage_number(p.path) for p in known}
        raise UnknownNameError(f"unknown parameter {name!r}; {hint_of(name, paths)}")
    return tuple(matches)


@of_designs
def set_parameter(
    mechanism: Mechanism, name: str, value: ArrayLike | str, *, checked: bool = True
) -> Mechanism:
    """A mechanism with the named number set [SI], in every stage unless the name picks one.

    A choice is set by its word.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `name`: a parameter.
    - `value`: the number, which may be traced, or the word.
    - `checked`: whether to refuse a known number that is out of range or excludes another one (a
      bore wider than its screw), as for files.

    **Raises:** `UnknownNameError` as in `find_parameters`; `ValueError` for a refused number.
    """
    refuse_complex(name, value)
    if checked:
        check_parameter(mechanism, name, value)
    for parameter in find_parameters(mechanism, name, words=isinstance(value, str)):
        if isinstance(value, str) and not parameter.words:
            raise ValueError(
                f"{name} is the text {value!r}; give a number in SI, here in {parameter.unit}"
            )
        if not parameter.static:
            dtype = getattr(parameter.get(mechanism), "dtype", jnp.result_type(float))
            value = jnp.asarray(value, dtype)
        mechanism = parameter.set(mechanism, value)
    if checked:
        check_stages(mechanism)
    return mechanism


def check_parameter(mechanism: Mechanism, name: str, value: Any) -> None:
    """**Raises:** `ValueError` if a known value is out of the range of a parameter."""
    if isinstance(value, str):
        return  # the part that has the choice checks its word
    for parameter in find_parameters(mechanism, name):
        name = parameter.path.rpartition(".")[2]
        check_number("", name, parameter.unit, value, parameter.limit)


def check_stages(mechanism: Mechanism) -> None:
    """**Raises:** `ValueError` if known numbers of a stage, or of an axis, exclude each other."""
    for stage in mechanism.stages:
        check_stage(stage)
    check_axis(mechanism)


@of_designs
def get_parameter(mechanism: Mechanism, name: str) -> Array | int:
    """The value of the named number [SI]; of the first stage when several stages have it."""
    return find_parameters(mechanism, name)[0].get(mechanism)


__all__ = [
    "DESIGN_VARIABLES",
    "DesignVariable",
    "Parameter",
    "all_parameters",
    "find_parameters",
    "get_parameter",
    "set_parameter",
]
