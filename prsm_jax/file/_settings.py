"""Settings from the command line: `--set KEY=VALUE`, with the names and units of a file."""

import dataclasses
from collections.abc import Iterable

from .._errors import FileError, UnknownNameError, missing_extra
from ..mechanism import CURVATURE_CONVENTIONS, Mechanism, find_parameters, set_parameter
from ._checks import check_dimensions
from .numbers import Misplaced, is_plain_number, one_line, read_integer, read_number, table_name

#: Settings that are words rather than numbers, with the allowed words.
_CHOICES = {"curvature": CURVATURE_CONVENTIONS}


def _apply_choice(mechanism: Mechanism, key: str, text: str) -> Mechanism:
    """Set a word in all stages, or in the one that `stage.N.…` names."""
    *place, name = key.split(".")
    allowed = _CHOICES[name]
    if text not in allowed:
        raise ValueError(f"{text!r} is not one of {', '.join(allowed)}")
    number = place[1] if len(place) == 2 else None
    if place[:1] not in ([], ["stage"]) or len(place) > 2:
        raise UnknownNameError(f"unknown parameter {key!r}; did you mean {name}?")
    if number is not None and number not in {str(i + 1) for i in range(len(mechanism.stages))}:
        raise UnknownNameError(
            f"parameter {key!r}: the mechanism has {len(mechanism.stages)} stage(s)"
        )
    stages = tuple(
        dataclasses.replace(stage, **{name: text}) if number in (None, str(index)) else stage
        for index, stage in enumerate(mechanism.stages, start=1)
    )
    return dataclasses.replace(mechanism, stages=stages)


def _apply(mechanism: Mechanism, key: str, text: str) -> Mechanism:
    if key.rsplit(".", 1)[-1] in _CHOICES:
        return _apply_choice(mechanism, key, text)
    parameter = find_parameters(mechanism, key)[0]
    limit = parameter.limit
    if parameter.static:
        is_integer = text.removeprefix("+").isascii() and text.removeprefix("+").isdigit()
        value = read_integer(int(text) if is_integer and len(text) < 20 else text, limit)
    else:
        bare = float(text) if is_plain_number(text) else text
        value = read_number(bare, parameter.unit, limit)
    # Unchecked: settings that are valid only together are applied one after the other.
    return set_parameter(mechanism, key, value, checked=False)


def apply_settings(
    mechanism: Mechanism, settings: Iterable[str], *, option: str | None = None
) -> Mechanism:
    """A mechanism with some numbers set by name, in order.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `settings`: texts `KEY=VALUE`: a parameter or design variable as `find_parameters` takes it,
      and a value with a unit (`"lead=12 mm"`) or bare in SI.
    - `option`: what the user wrote, for messages; default `--set KEY=VALUE`.

    **Returns:** the mechanism with all settings.

    **Raises:** `FileError`, with one line that names the setting and what is allowed.
    """
    shown = ""
    for setting in settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        shown = one_line(option or f"--set {setting}", 106)
        if not (key and equals and text):
            raise FileError(f'{shown}: must be KEY=VALUE, such as "lead=12 mm"')
        try:
            mechanism = _apply(mechanism, key, text)
        except ModuleNotFoundError as error:
            raise missing_extra("file", "reading units", error) from error
        except (UnknownNameError, ValueError) as error:
            raise FileError(one_line(f"{shown}: {error}", 700)) from error
    try:
        # After the last one: two settings may fit each other, but neither fits the old mechanism.
        check_dimensions(mechanism)
    except Misplaced as error:
        place = f"{table_name(error.place[:-1])}: {error.place[-1]}"
        raise FileError(f"after {shown}: {place} {error.message}") from error
    return mechanism
