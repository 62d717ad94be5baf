"""Writing the `[scenario]` table."""

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import equinox as eqx
import numpy as np

from .._errors import FileError
from ..scenario import LOADS_OF_MOTION, PROFILES, Scenario, TorqueScenario


def scenario_lines(
    scenario: Scenario | TorqueScenario,
    number: Callable[[object, str, str], str],
    string: Callable[[str], str],
) -> Iterator[str]:
    """The lines of a scenario.

    **Arguments:**

    - `scenario`: the scenario.
    - `number`: writes a number of an SI unit; its last argument is the key, for messages.
    - `string`: writes a text.

    **Raises:** `FileError` for a function that a file cannot hold.
    """

    def value_of(field: dataclasses.Field[Any], value, unit: str | None, key: str) -> str:
        if field.metadata.get("list"):
            return f"[{', '.join(number(one, unit or '1', key) for one in np.asarray(value))}]"
        if unit is not None:
            return number(value, unit, key)
        if isinstance(value, bool):
            return str(value).lower()
        return string(value) if isinstance(value, str) else str(value)

    def module(part, header: str, unit: str) -> Iterator[str]:
        kind = getattr(type(part), "kind", None)
        if kind is not None:
            yield f"kind = {string(kind)}"
        inner: list[str] = []
        for field in dataclasses.fields(part):
            value, key = getattr(part, field.name), f"{header}.{field.name}"
            own = field.metadata.get("unit")
            own = unit if own == "*" else own
            if value is None:
                continue
            if field.name == "part":
                for element in value:
                    inner.extend(("", f"[[{key}]]", *function(element, key, unit)))
            elif callable(value):
                inner.extend(("", f"[{key}]", *function(value, key, own or unit)))
            else:
                yield f"{field.name} = {value_of(field, value, own, key)}"
        yield from inner

    def function(part, header: str, unit: str) -> Iterator[str]:
        if not callable(part):
            yield from ('kind = "number"', f"value = {number(part, unit, header)}")
            return
        known = PROFILES | LOADS_OF_MOTION
        if not isinstance(part, eqx.Module) or type(part) not in known.values():
            raise FileError(
                f"{header} is a {type(part).__name__}, which a file cannot hold; use one of "
                f"{', '.join(known)}"
            )
        yield from module(part, header, unit)

    yield from ("", "[scenario]")
    yield from module(scenario, "scenario", "1")
