"""Editing: changes numbers of a file, and keeps its comments and order."""

import tomllib
from collections.abc import Mapping, MutableMapping
from typing import Any

from .._errors import FileError, missing_extra
from ..mechanism import Mechanism
from ._examples import example_bytes, example_names, example_text
from ._read import bytes_of, loads, text_of
from ._write import dumps, unread_text


def source_text(source: str) -> str:
    """The text of an example or of the file at a path.

    **Raises:** `FileError` if it cannot be read.
    """
    return example_text(source) if source in example_names() else text_of(source)


def source_bytes(source: str) -> bytes:
    """What is in the file of an example, or in the file at a path.

    **Raises:** `FileError` if it cannot be read.
    """
    return example_bytes(source) if source in example_names() else bytes_of(source)


def edit(text: str, mechanism: Mechanism, quantity_units: Mapping[str, str] | None = None) -> str:
    """The text of a file, changed where `mechanism` differs from what it says.

    The rest stays as it is, comments and the order of keys included; if the text cannot be changed
    key by key, the mechanism is written anew.

    **Arguments:**

    - `text`: TOML text of a mechanism.
    - `mechanism`: the mechanism that the new text describes, exactly.
    - `quantity_units`: as for `dumps`.

    **Raises:** as `loads` and `dumps` do.
    """
    anew = dumps(mechanism, quantity_units)
    try:
        import tomlkit
    except ModuleNotFoundError as error:
        raise missing_extra("file", "editing mechanism files", error) from error
    before = tomllib.loads(unread_text(loads(text), quantity_units))
    document = tomlkit.parse(text)
    try:
        _change(document, before, tomllib.loads(anew))
        edited = tomlkit.dumps(document)
        # The edited text must describe the same mechanism.
        same = unread_text(loads(edited), quantity_units) == anew
    except (FileError, KeyError, IndexError, TypeError):
        same = False
    return edited if same else anew


def _change(
    document: MutableMapping[str, Any], before: Mapping[str, Any], after: Mapping[str, Any]
) -> None:
    """Apply the differences between two tables to a document that is equivalent to the first."""
    for key in before.keys() - after.keys():
        document.pop(key, None)
    for key, value in after.items():
        old = before.get(key)
        if value == old:
            continue
        if isinstance(value, dict) and isinstance(old, dict):
            _change(document[key], old, value)
        elif old is not None and _tables(value) and _tables(old) and len(value) == len(old):
            for index, (was, is_now) in enumerate(zip(old, value, strict=True)):
                if was != is_now:
                    _change(document[key][index], was, is_now)
        else:
            document[key] = value


def _tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(x, dict) for x in value)
