"""Reading: TOML text to a mechanism in SI, or one clear error."""

import tomllib
from pathlib import Path
from typing import Any

from .._errors import FileError, closest, missing_extra
from ..mechanism import Mechanism
from ._examples import example_names, example_text
from ._schema import mechanism_of
from .numbers import Misplaced, file_error, one_line, utf8_text

_LARGEST_FILE = 1_000_000
# A dotted key of thousands of parts takes tomllib seconds: its time grows with their square.
_MOST_DOTS_IN_A_LINE = 100


def load(source: str | Path) -> Mechanism:
    """Read a mechanism.

    **Arguments:**

    - `source`: the name of a shipped example, or the path of a TOML file.

    **Returns:** the mechanism, in SI units.

    **Raises:** `FileError`, with one line that names file, table, key, value and what is allowed;
    `MissingExtraError` if pint is not installed.
    """
    if isinstance(source, str) and source in example_names():
        return loads(example_text(source), name=source)
    return loads(text_of(source), name=str(source))


def text_of(source: str | Path) -> str:
    return utf8_text(bytes_of(source), one_line(str(source), 300))


def bytes_of(source: str | Path) -> bytes:
    """What is in a file.

    **Raises:** `FileError` if there is none, it cannot be read, or it is too large.
    """
    name = one_line(str(source), 300)
    try:
        path = Path(source)
        if path.is_dir():
            raise FileError(f"{name}: is a folder; give a TOML file or the name of an example")
        if not path.is_file():
            hint = closest(name, example_names())
            raise FileError(f"{name}: there is no such file, nor an example of that name; {hint}")
        with path.open("rb") as file:
            data = file.read(_LARGEST_FILE + 1)
    except FileError:
        raise
    except (OSError, ValueError, TypeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise FileError(f"{name}: cannot be read: {reason}") from error
    if len(data) > _LARGEST_FILE:
        raise FileError(f"{name}: is larger than {_LARGEST_FILE} bytes; this cannot be a mechanism")
    return data


def loads(text: str, name: str = "<string>") -> Mechanism:
    """Read a mechanism from TOML text.

    **Arguments:**

    - `text`: the text.
    - `name`: its name in error messages.

    **Returns:** the mechanism, in SI units.

    **Raises:** `FileError`, with one line that names table, key, value and what is allowed;
    `MissingExtraError` if pint is not installed.
    """
    data = _parse(text, name)
    try:
        return mechanism_of(data)
    except ModuleNotFoundError as error:
        raise missing_extra("file", "reading mechanism files", error) from error
    except Misplaced as error:
        raise file_error(name, data, error.problems) from error
    except RecursionError as error:
        raise file_error(name, data, [((), "is nested too deeply")]) from error


def _parse(text: str, name: str) -> dict[str, Any]:
    try:
        # A lone surrogate cannot be in a file, but it can be in a Python string.
        size = len(text.encode("utf-8"))
    except UnicodeEncodeError as error:
        raise file_error(name, {}, [((), "contains characters that are not text")]) from error
    if size > _LARGEST_FILE:
        message = f"is larger than {_LARGEST_FILE} bytes; this cannot be a mechanism"
        raise file_error(name, {}, [((), message)])
    for number, line in enumerate(text.split("\n"), start=1):
        if line.count(".") > _MOST_DOTS_IN_A_LINE:
            message = f"line {number} has more than {_MOST_DOTS_IN_A_LINE} dots; split it"
            raise file_error(name, {}, [((), message)])
    try:
        return tomllib.loads(text.removeprefix("\ufeff"))
    except RecursionError as error:
        raise file_error(name, {}, [((), "is nested too deeply")]) from error
    except ValueError as error:
        raise file_error(name, {}, [((), f"is not valid TOML: {error}")]) from error
