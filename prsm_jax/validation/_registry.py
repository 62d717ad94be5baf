"""The registry of sources: a paper is one module whose functions yield its rows."""

import dataclasses
from collections.abc import Callable, Iterable

from .._errors import UnknownNameError, closest
from ._row import Row

RowFunction = Callable[[], Iterable[Row]]


@dataclasses.dataclass
class _Source:
    citation: str
    functions: list[RowFunction]


_SOURCES: dict[str, _Source] = {}


def rows_of(name: str, citation: str = "") -> Callable[[RowFunction], RowFunction]:
    """Register a function that yields rows of one source; their `source` is filled in.

    A new source is a new module with such functions, and its import in `__init__`.

    **Arguments:**

    - `name`: name of the source, as in `validate(source=name)`.
    - `citation`: authors, title or journal, year; given once per source.
    """

    def register(function: RowFunction) -> RowFunction:
        source = _SOURCES.setdefault(name, _Source("", []))
        source.citation = citation or source.citation
        source.functions.append(function)
        return function

    return register


def sources() -> dict[str, str]:
    """Names of the sources covered, each with its citation."""
    return {name: source.citation for name, source in _SOURCES.items()}


def validate(source: str | None = None) -> tuple[Row, ...]:
    """Compare published numbers with those of the toolkit.

    **Arguments:**

    - `source`: one of `sources()`; default all of them.

    **Returns:** one row per published number, in the order of the sources.

    **Raises:** `UnknownNameError` for a source that is not covered.
    """
    if source is not None and source not in _SOURCES:
        raise UnknownNameError(f"unknown source {source!r}; {closest(source, _SOURCES)}")
    names = _SOURCES if source is None else (source,)
    return tuple(
        dataclasses.replace(row, source=name)
        for name in names
        for function in _SOURCES[name].functions
        for row in function()
    )
