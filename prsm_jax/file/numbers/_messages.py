"""One line for a problem in a file: the file, the table, the key, the value, what is allowed."""

from collections.abc import Sequence

from ..._errors import FileError
from ._numbers import show

_SHOWN = 3
Place = tuple[str | int, ...]


class Misplaced(Exception):
    """Problems, each with its place in the file, before the file's name is known."""

    def __init__(self, *problems: tuple[Place, str]):
        super().__init__(*(message for _, message in problems))
        self.problems = problems


def utf8_text(data: bytes, name: str) -> str:
    """The text of a file.

    **Raises:** `FileError`, with the name of the file and the place, if it is not UTF-8.
    """
    try:
        # Windows editors put a byte order mark first.
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        message = f"{name}: is not UTF-8 text (byte {error.start}); save it as UTF-8"
        raise FileError(message) from error


def one_line(text: str, longest: int) -> str:
    """A text without line breaks and control characters, shortened."""
    text = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return text if len(text) <= longest else text[: longest - 1] + "…"


def table_name(place: Sequence[str | int]) -> str:
    """A place as a reader of the file finds it: `[[stage]] 1 thread`, `[operating_point]`."""
    numbered = [i for i, part in enumerate(place) if isinstance(part, int)]
    if not numbered:
        return f"[{'.'.join(map(str, place))}]" if place else ""
    words = []
    for at in numbered:
        header = ".".join(str(part) for part in place[:at] if isinstance(part, str))
        words.append(f"[[{header}]] {int(place[at]) + 1}")
    words.append(".".join(map(str, place[numbered[-1] + 1 :])))
    return " ".join(words).rstrip()


def _follow(data, place: Place) -> tuple[list[str | int], object]:
    """The part of a place that is in the file, and the value there; `...` if there is none."""
    path: list[str | int] = []
    for index, part in enumerate(place):
        inside = (
            part in data
            if isinstance(data, dict)
            else isinstance(data, list) and isinstance(part, int) and part < len(data)
        )
        if inside:
            data = data[part]  # type: ignore[index]
            path.append(part)
        elif index == len(place) - 1:
            return [*path, part], ...
    return path, data


def _sentence(data, place: Place, message: str) -> str:
    path, value = _follow(data, place)
    if not path:
        return message
    # An error of a whole table names the table; an error of a key names table and key.
    if isinstance(path[-1], int) or isinstance(value, dict):
        return f"{one_line(table_name(path), 120)}: {message}"
    table = one_line(table_name(path[:-1]), 120)
    key = one_line(str(path[-1]), 60)
    assignment = "" if value is ... else f" = {show(value)}"
    return f"{table + ': ' if table else ''}{key}{assignment}: {message}"


def file_error(name: str, data: object, problems: Sequence[tuple[Place, str]]) -> FileError:
    """The error for one or several problems in a file, on one line.

    **Arguments:**

    - `name`: the file's name.
    - `data`: what was read from it, to show the values at fault.
    - `problems`: place and message of each.
    """
    sentences = [_sentence(data, place, message) for place, message in problems[:_SHOWN]]
    if len(problems) > _SHOWN:
        sentences.append(f"and {len(problems) - _SHOWN} more")
    text = "; ".join(dict.fromkeys(one_line(sentence, 600) for sentence in sentences))
    return FileError(f"{one_line(name, 300)}: {text}")
