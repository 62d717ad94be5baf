"""Several parameters at once: set together, or refused because they set the same number."""

from collections.abc import Iterable, Mapping

import jax
import numpy as np
from jaxtyping import ArrayLike

from ...fields import refuse_complex
from .._mechanism import Mechanism
from ._parameters import SET_AFTER, check_parameter, check_stages, find_parameters, set_parameter

#: Setting one number may change another by rounding; a larger change is a conflict.
_ROUNDING = 1e-6
#: Relative change of the values in the test: the present values would hide a conflict.
_PROBE = 1e-2


def set_parameters(
    mechanism: Mechanism, values: Mapping[str, ArrayLike], *, checked: bool = True
) -> Mechanism:
    """A mechanism with several named numbers set [SI], one after the other.

    `gear_module` is set after `roller_teeth`, whichever is named first.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `values`: the value of each name, as `set_parameter` takes them.

    - `checked`: as in `set_parameter`; whether they exclude each other is checked when all are set.

    **Raises:** `UnknownNameError` as in `find_parameters`; `ValueError` for a refused number.
    """
    for name in _in_order(values):
        value = values[name]
        refuse_complex(name, value)
        if checked:
            check_parameter(mechanism, name, value)
        mechanism = set_parameter(mechanism, name, value, checked=False)
    if checked:
        check_stages(mechanism)
    return mechanism


def _in_order(names: Iterable[str]) -> list[str]:
    """The names in their order, but each after those on which its meaning depends."""
    fields = {name: name.rpartition(".")[2] for name in names}
    given = set(fields.values())
    return sorted(fields, key=lambda name: not given.isdisjoint(SET_AFTER.get(fields[name], ())))


def written_out(mechanism: Mechanism, names: Iterable[str]) -> Mechanism:
    """The same mechanism, in which all named numbers are its own.

    A number that follows from others while it is absent (the roller's profile radius) is set to the
    expression that it follows from: its value and derivatives stay the same. A mechanism in which
    such a number has been changed is then evaluated by the same compiled programs.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `names`: names of numbers, as `find_parameters` takes them.
    """
    for name in names:
        for parameter in find_parameters(mechanism, name):
            written = parameter.set(mechanism, parameter.get(mechanism))
            if jax.tree.structure(written) != jax.tree.structure(mechanism):
                mechanism = written
    return mechanism


def check_independent(mechanism: Mechanism, *groups: Iterable[str]) -> None:
    """Check that parameters can be set together, each to its own value.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `groups`: names of parameters that are set together; static ones (`roller_count`) may be
      among them. Those of a further group are set after the first.

    **Raises:** `UnknownNameError` as in `find_parameters`; `ValueError` if two of them are the same
    number, or if setting a later one moves an earlier one (`pitch` before `starts`).
    """
    owner: dict[str, str] = {}
    probes: dict[str, float] = {}
    listed = [list(names) for names in groups]
    for index, name in enumerate(name for names in listed for name in names):
        if name in probes:
            raise ValueError(f"parameter {name!r} is given twice; remove one")
        parameters = find_parameters(mechanism, name)
        for parameter in parameters:
            if parameter.path in owner:
                raise ValueError(
                    f"parameters {owner[parameter.path]!r} and {name!r} both set "
                    f"{parameter.path}; remove one"
                )
            owner[parameter.path] = name
        current = float(parameters[0].get(mechanism))
        if parameters[0].static:
            probes[name] = current + 1
        else:
            probes[name] = current * (1 + _PROBE * (index + 1)) if current else _PROBE
    moved = mechanism
    for names in listed:
        moved = set_parameters(moved, {name: probes[name] for name in names}, checked=False)
    for name, value in probes.items():
        for parameter in find_parameters(moved, name):
            # False for NaN: a probe may be infeasible, which is not a conflict.
            if np.abs(float(parameter.get(moved)) - value) > _ROUNDING * abs(value):
                later = [other for other in probes if other != name]
                raise ValueError(
                    f"parameter {name!r} moves again when {' and '.join(map(repr, later))} "
                    "is set after it; choose parameters that do not determine each other, or "
                    f"name {name!r} last"
                )


__all__ = ["check_independent", "set_parameters"]
