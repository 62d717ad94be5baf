"""The examples that come with the package: mechanisms of the literature and an actuator."""

import functools
import tomllib
from pathlib import Path

from .._errors import FileError, closest

_FOLDER = Path(__file__).parent / "examples"


@functools.cache
def example_names() -> tuple[str, ...]:
    """The names of the shipped examples, in alphabetical order."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def example_summary(name: str) -> str:
    """What a shipped example is, in one line: its title.

    **Arguments:**

    - `name`: one of `example_names()`.

    **Raises:** `FileError` if there is no such example.
    """
    return tomllib.loads(example_text(name))["title"]


def example_text(name: str) -> str:
    """The text of a shipped example, with its comments on where each number comes from.

    **Arguments:**

    - `name`: one of `example_names()`.

    **Raises:** `FileError` if there is no such example.
    """
    if name not in example_names():
        raise FileError(f"there is no example {name!r}; {closest(name, example_names())}")
    return (_FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def example_bytes(name: str) -> bytes:
    """What is in the file of a shipped example, by one of `example_names()`."""
    return (_FOLDER / f"{name}.toml").read_bytes()
