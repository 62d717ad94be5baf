"""Several parameters at once: moved together, or refused because they move the same number."""

from collections.abc import Iterable, Mapping

import numpy as np

from .._mechanism import Mechanism
from ._parameters import check_parameter, check_stages, find_parameters, set_parameter

#: Setting one number may touch another by rounding; anything above is a conflict.
_ROUNDING = 1e-6
#: Values this far from the present ones show a conflict that the present ones would hide.
_PROBE = 1e-2


def set_parameters(mechanism: Mechanism, values: Mapping, *, checked: bool = True) -> Mechanism:
    """A mechanism with several named numbers set [SI], one after the other.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `values`: the value of each name, as `set_parameter` takes them.

    - `checked`: as of `set_parameter`; whether they exclude each other is asked when all are set.

    **Raises:** `UnknownNameError` as `find_parameters`; `ValueError` for a number that is refused.
    """
    for name, value in values.items():
        if checked:
            check_parameter(mechanism, name, value)
        mechanism = set_parameter(mechanism, name, value, checked=False)
    if checked:
        check_stages(mechanism)
    return mechanism


def check_independent(mechanism: Mechanism, names: Iterable[str]) -> None:
    """Check that parameters can be set together, each to a value of its own.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `names`: names of parameters; static ones (`roller_count`) may be among them.

    **Raises:** `UnknownNameError` as `find_parameters`; `ValueError` if two of them are the same
    number, or if setting a later one moves an earlier one (`pitch` before `starts`).
    """
    owner: dict[str, str] = {}
    probes: dict[str, float] = {}
    for index, name in enumerate(names):
        if name in probes:
            raise ValueError(f"parameter {name!r} is given twice; remove one")
        found = find_parameters(mechanism, name)
        for parameter in found:
            if parameter.path in owner:
                raise ValueError(
                    f"parameters {owner[parameter.path]!r} and {name!r} both set "
                    f"{parameter.path}; remove one"
                )
            owner[parameter.path] = name
        current = float(found[0].get(mechanism))
        if found[0].static:
            probes[name] = current + 1
        else:
            probes[name] = current * (1 + _PROBE * (index + 1)) if current else _PROBE
    moved = set_parameters(mechanism, probes, checked=False)
    for name, value in probes.items():
        for parameter in find_parameters(moved, name):
            # Not a comparison of NaN: a probe may leave what is feasible, and that is no conflict.
            if np.abs(float(parameter.get(moved)) - value) > _ROUNDING * abs(value):
                later = [other for other in probes if other != name]
                raise ValueError(
                    f"parameter {name!r} moves again when {' and '.join(map(repr, later))} "
                    "is set after it; choose parameters that do not determine each other, or "
                    f"name {name!r} last"
                )


__all__ = ["check_independent", "set_parameters"]
