"""Published figures as data: the toolkit's curves on the paper's axes, with the printed values."""

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

import numpy as np

from .._errors import UnknownNameError, closest
from ._registry import sources


@dataclasses.dataclass(frozen=True)
class Curve:
    """One curve [SI] of a panel.

    `case` is the index of its parameters in the figure's `cases`; `stage` is 0 for the whole
    mechanism.
    """

    y: np.ndarray
    stage: int = 0
    case: int = 0


@dataclasses.dataclass(frozen=True)
class Mark:
    """A value to compare with: a level of the panel, or a time [s]."""

    words: str
    level: float | None = None
    time: float | None = None
    #: Whether the paper's text prints it.
    printed: bool = True


@dataclasses.dataclass(frozen=True)
class Panel:
    """One diagram of a figure, over time; `right` has its own axis on the right."""

    name: str
    symbol: str
    #: SI unit, "1" for a ratio.
    unit: str
    curves: tuple[Curve, ...]
    marks: tuple[Mark, ...] = ()
    right: "Panel | None" = None


@dataclasses.dataclass(frozen=True)
class PublishedFigure:
    """A figure of a paper with computed curves."""

    source: str
    number: int
    caption: str
    #: [s]
    time: np.ndarray
    panels: tuple[Panel, ...]
    #: Description of each case, if there are several.
    cases: tuple[str, ...] = ()

    @property
    def file_name(self) -> str:
        """Name of its picture, without a suffix."""
        return f"{self.source}-figure-{self.number}"


_T = TypeVar("_T")


def chosen(registry: Mapping[str, _T], source: str | None) -> list[_T]:
    """Entries of a registry for one source, or for all sources.

    **Raises:** `UnknownNameError` for a source that is not covered.
    """
    if source is not None and source not in sources():
        raise UnknownNameError(f"unknown source {source!r}; {closest(source, sources())}")
    return [entry for name, entry in registry.items() if source in (None, name)]


def registered(registry: dict[str, _T], source: str) -> Callable[[_T], _T]:
    """A decorator that enters a function of one source into a registry."""

    def register(function: _T) -> _T:
        registry[source] = function
        return function

    return register


FigureFunction = Callable[[], Iterator[PublishedFigure]]
_FIGURES: dict[str, FigureFunction] = {}


def figures_of(name: str) -> Callable[[FigureFunction], FigureFunction]:
    """Register the function that yields the figures of one source."""
    return registered(_FIGURES, name)


def published_figures(source: str | None = None) -> tuple[PublishedFigure, ...]:
    """The figures of the papers that are regenerated.

    **Arguments:**

    - `source`: one of `sources()`; default all of them. A source may have none.

    **Raises:** `UnknownNameError` for a source that is not covered.
    """
    return tuple(figure for function in chosen(_FIGURES, source) for figure in function())
