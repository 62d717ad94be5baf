"""Editing: changes numbers of a file, and keeps the order and the comments of the other lines."""

import tomllib
from collections.abc import Iterator, Mapping, MutableMapping
from typing import Any, TypeGuard

from .._errors import FileError, missing_extra
from ..mechanism import Mechanism
from ._comments import comment_lines
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


def edit(
    text: str,
    mechanism: Mechanism,
    quantity_units: Mapping[str, str] | None = None,
    *,
    by: str | None = None,
) -> str:
    """The text of a file, changed where `mechanism` differs from what it says.

    The comment at the end of a changed line is removed, because it described the former number.
    The rest stays as it is, other comments and the order of keys included; if the text cannot be
    changed key by key, the mechanism is written anew.

    **Arguments:**

    - `text`: TOML text of a mechanism.
    - `mechanism`: the mechanism that the new text describes, exactly.
    - `quantity_units`: as for `dumps`.
    - `by`: what changes it, such as `"prsm optimise"`, for a comment above everything that names
      the changed numbers; without it there is no such comment.

    **Raises:** as `loads` and `dumps` do.
    """
    anew = dumps(mechanism, quantity_units)
    try:
        import tomlkit
        from tomlkit.exceptions import TOMLKitError
    except ModuleNotFoundError as error:
        raise missing_extra("file", "editing mechanism files", error) from error
    before = tomllib.loads(unread_text(loads(text), quantity_units))
    after = tomllib.loads(anew)
    try:
        # Versions before 0.15.1 cannot read a stage whose tables are not next to one another.
        document = tomlkit.parse(text)
        _change(document, before, after)
        edited = tomlkit.dumps(document)
        # The edited text must describe the same mechanism.
        same = unread_text(loads(edited), quantity_units) == anew
    except (FileError, KeyError, IndexError, TypeError, TOMLKitError):
        same = False
    new = edited if same else anew
    changed = tuple(_changed(before, after, ""))
    return new if by is None or not changed else _headed(new, by, changed, kept=same)


def _headed(text: str, by: str, changed: tuple[str, ...], *, kept: bool) -> str:
    """The text below a comment that says what changed it, and that comments may be out of date."""
    comments = (
        "The comments of the changed lines were removed; other comments may describe the former "
        "numbers."
        if kept
        else "The file was written anew, without the comments that it had."
    )
    head = comment_lines([f"Changed by {by}: {', '.join(changed)}.", comments])
    return "\n".join([*head, "", text])


def _changed(before: Mapping[str, Any], after: Mapping[str, Any], table: str) -> Iterator[str]:
    """Names of what differs between two tables, in the order of the second."""
    for key in [*after, *(key for key in before if key not in after)]:
        old, new, name = before.get(key), after.get(key), f"{table}{key}"
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            yield from _changed(old, new, f"{name}.")
        elif _tables(old) and _tables(new) and len(old) == len(new):
            for number, (was, is_now) in enumerate(zip(old, new, strict=True), start=1):
                # As --set names them: the number of an only stage is left out, and a row with a
                # number of its own (a roller's place) has that one.
                only = key == "stage" and len(new) == 1
                row = name if only else f"{name}.{is_now.get('number', number)}"
                yield from _changed(was, is_now, f"{row}.")
        else:
            yield name


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
        elif _tables(value) and _tables(old) and len(value) == len(old):
            for index, (was, is_now) in enumerate(zip(old, value, strict=True)):
                if was != is_now:
                    _change(document[key][index], was, is_now)
        else:
            document[key] = value
        # `document[key]` is the bare value of a truth value, without its comment.
        item = getattr(document, "item", None)
        _drop_comment(document[key] if item is None else item(key))


def _drop_comment(item: Any) -> None:
    """Remove the comment at the end of the line of a value or an inline table.

    That of the head of a table stays: it says what the table is.
    """
    from tomlkit.items import AbstractTable, AoT, InlineTable, Item

    heads = isinstance(item, AbstractTable | AoT) and not isinstance(item, InlineTable)
    if isinstance(item, Item) and not heads:
        item.trivia.comment_ws = item.trivia.comment = ""


def _tables(value: Any) -> TypeGuard[list[dict[str, Any]]]:
    return isinstance(value, list) and bool(value) and all(isinstance(x, dict) for x in value)
