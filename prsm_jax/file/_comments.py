"""The text of a mechanism with a comment for every number."""

import dataclasses
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import equinox as eqx
import jax

from .._errors import FileError
from ..fields import declared, values_of
from ..mechanism import Mechanism
from ._read import loads
from ._write import dumps
from .numbers import round_in_unit

_WIDTH = 99
#: Column at which comments begin.
_COLUMN = 34


def rounded(mechanism: Mechanism, digits: int = 6) -> Mechanism:
    """A mechanism with every number rounded in the unit in which a file has it.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `digits`: significant digits.
    """
    return _rounded(mechanism, digits)


def _rounded(part: Any, digits: int) -> Any:
    changes: dict[str, Any] = {}
    for one in declared(type(part)):
        value = getattr(part, one.name)
        if isinstance(value, eqx.Module):
            changes[one.name] = _rounded(value, digits)
        elif isinstance(value, tuple) and all(isinstance(row, eqx.Module) for row in value):
            changes[one.name] = tuple(_rounded(row, digits) for row in value)
        elif one.unit is not None and isinstance(value, jax.Array) and value.ndim == 0:
            changes[one.name] = round_in_unit(float(value), one.unit, digits)
    return dataclasses.replace(part, **changes)


def commented(mechanism: Mechanism, reasons: Mapping[str, str], head: Iterable[str]) -> str:
    """A mechanism as TOML text in which each number has a comment.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `reasons`: comments by table and key, such as `stage.thread.lead`, and of tables; other
      numbers get the description of their field.
    - `head`: sentences above everything.

    **Returns:** the text.

    **Raises:** `FileError` as `dumps`.
    """
    known = dict(_descriptions(mechanism, ""))
    for stage in mechanism.stages:
        known.update(_descriptions(stage, "stage"))
    known |= reasons
    lines: list[str] = [*comment_lines(head), ""]
    table = ""
    for line in dumps(mechanism).splitlines():
        key = line.partition(" = ")[0]
        if line.startswith("["):
            table = line.strip("[]")
            lines += [*comment_lines([known[table]] if table in known else []), line]
            continue
        comment = known.get(f"{table}.{key}" if table else key, "")
        if not line or not comment:
            lines.append(line)
        elif max(len(line), _COLUMN) + len(comment) + 4 <= _WIDTH:
            lines.append(f"{line.ljust(_COLUMN)}  # {comment}")
        else:
            lines += [*comment_lines([comment]), line]
    text = "\n".join(lines) + "\n"
    if not eqx.tree_equal(loads(text), loads(dumps(mechanism))):
        raise FileError("the comments change the mechanism; a comment has a line break")
    return text


def comment_lines(sentences: Iterable[str]) -> list[str]:
    """Sentences as lines of comments of a file."""
    return [f"# {line}" for words in sentences for line in textwrap.wrap(words, _WIDTH - 2)]


def _descriptions(part: Any, header: str) -> Iterator[tuple[str, str]]:
    """Descriptions of the numbers and choices of a part, by table and key."""
    for one, value in values_of(part):
        path = f"{header}.{one.name}" if header else one.name
        if isinstance(value, eqx.Module):
            yield from _descriptions(value, path)
        elif value is not None and one.description:
            yield path, one.description
