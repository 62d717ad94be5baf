"""Settings from the command line: `--set KEY=VALUE`, with the names and units of a file."""

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np

from .._errors import FileError, UnknownNameError, missing_extra
from ..fields import Contradiction, check_distances, check_stage
from ..mechanism import Mechanism, Parameter, find_parameters, set_parameter
from .numbers import is_plain_number, one_line, read_integer, read_number, table_name

#: Setting one number may change another by rounding; a larger change is a contradiction.
_ROUNDING = 1e-6


@dataclasses.dataclass(frozen=True)
class _Given:
    """A number that a setting has set: its key as the user wrote it, and its value then."""

    shown: str
    key: str
    parameter: Parameter
    value: Any

    def holds(self, mechanism: Mechanism) -> bool:
        """Whether a mechanism still has this value, but for rounding."""
        now = self.parameter.get(mechanism)
        if self.parameter.static:
            return bool(now == self.value)
        return np.allclose(now, self.value, rtol=_ROUNDING, atol=0.0, equal_nan=True)


def _apply(
    mechanism: Mechanism, key: str, text: str, shown: str, before: list[_Given]
) -> tuple[Mechanism, list[_Given]]:
    """One setting after those `before`, and what it sets.

    **Raises:** `ValueError` for a value that is refused, and if the setting sets a number that one
    of them has set, or changes it.
    """
    parameters = find_parameters(mechanism, key, words=True)
    parameter = parameters[0]
    if parameter.words:
        if text not in parameter.words:
            raise ValueError(f"{text!r} is not one of {', '.join(parameter.words)}")
        value = text
    elif parameter.static:
        is_integer = text.removeprefix("+").isascii() and text.removeprefix("+").isdigit()
        value = read_integer(int(text) if is_integer and len(text) < 20 else text, parameter.limit)
    else:
        bare = float(text) if is_plain_number(text) else text
        value = read_number(bare, parameter.unit, parameter.limit)
    # Unchecked: settings that are valid only together are applied one after the other.
    moved = set_parameter(mechanism, key, value, checked=False)
    paths = {one.path for one in parameters}
    for one in before:
        if one.parameter.path in paths and not one.holds(moved):
            same = {other.parameter.path for other in before if other.shown == one.shown} == paths
            remedy = "leave one of them out" if same else "name the number of a stage in each"
            raise ValueError(f"sets the same number as {one.shown}; {remedy}")
    given = [_Given(shown, key, one, one.get(moved)) for one in parameters]
    for one in before:
        if not one.holds(moved):
            remedy = "leave one of them out"
            again = one.parameter.set(moved, one.value)
            if all(other.holds(again) for other in [*before, *given]):
                remedy += ", or write that one after this one"
            raise ValueError(f"changes {one.key} again, which {one.shown} sets; {remedy}")
    return moved, given


def apply_settings(
    mechanism: Mechanism, settings: Iterable[str], *, option: str | None = None
) -> Mechanism:
    """A mechanism with some numbers set by name, in order, each to its own value.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `settings`: texts `KEY=VALUE`: a parameter or design variable as `find_parameters` takes it,
      and a value with a unit (`"lead=12 mm"`) or bare in SI.
    - `option`: what the user wrote, for messages; default `--set KEY=VALUE`.

    **Returns:** the mechanism with all settings.

    **Raises:** `FileError`, with one line that names the setting and what is allowed; and if two
    settings give a number different values, or a later one (`pitch`) changes the number of an
    earlier one (`lead`).
    """
    shown = ""
    before: list[_Given] = []
    for setting in settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        shown = one_line(option or f"--set {setting}", 106)
        if not (key and equals and text):
            raise FileError(f'{shown}: must be KEY=VALUE, such as "lead=12 mm"')
        try:
            mechanism, given = _apply(mechanism, key, text, shown, before)
        except ModuleNotFoundError as error:
            raise missing_extra("file", "reading units", error) from error
        except (UnknownNameError, ValueError) as error:
            raise FileError(one_line(f"{shown}: {error}", 700)) from error
        before += given
    # After the last one: two settings may fit each other, but neither fits the old mechanism.
    for index, stage in enumerate(mechanism.stages):
        try:
            check_stage(stage)
        except Contradiction as error:
            place = f"{table_name(('stage', index, *error.place[:-1]))}: {error.place[-1]}"
            raise FileError(f"after {shown}: {place} {error.message}") from error
    if mechanism.axis is not None:
        try:
            check_distances(mechanism.axis, mechanism.stages[0].screw)
        except Contradiction as error:
            raise FileError(f"after {shown}: {error}") from error
    return mechanism
