"""Settings from the command line: `--set KEY=VALUE`, with the names and units of a file."""

from collections.abc import Iterable

from .._errors import FileError, UnknownNameError, missing_extra
from ..fields import Contradiction, check_distances, check_stage
from ..mechanism import Mechanism, find_parameters, set_parameter
from .numbers import is_plain_number, one_line, read_integer, read_number, table_name


def _apply(mechanism: Mechanism, key: str, text: str) -> Mechanism:
    parameter = find_parameters(mechanism, key, words=True)[0]
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
