"""Published contact pressures as data: maps of the true flanks, with the printed values."""

import dataclasses
from collections.abc import Callable, Iterator

from ..halfspace import FlankContact
from ._figures import chosen, registered


@dataclasses.dataclass(frozen=True)
class PrintedEllipse:
    """The Hertz ellipse of a paper's own curvatures, in the tangent plane."""

    #: [m]
    semi_major: float
    #: [m]
    semi_minor: float
    #: Direction of its major axis, from that of the computed ellipse [rad].
    angle: float


@dataclasses.dataclass(frozen=True)
class PrintedPressure:
    """A largest pressure as a paper prints it."""

    #: Method, for example "Hertz".
    name: str
    #: [Pa]; None where none is printed.
    value: float | None
    #: The correct value if it is a misprint [Pa].
    correct: float | None = None


@dataclasses.dataclass(frozen=True)
class PressurePanel:
    """One contact, solved on the true flanks, and the values that a paper prints for it."""

    #: Which contact it is, for example "screw side, 25 N".
    name: str
    contact: FlankContact
    printed: tuple[PrintedPressure, ...] = ()
    ellipse: PrintedEllipse | None = None


@dataclasses.dataclass(frozen=True)
class PressureFigure:
    """Contacts of a paper to be drawn side by side, to one scale."""

    source: str
    name: str
    caption: str
    #: Rows of equal length.
    rows: tuple[tuple[PressurePanel, ...], ...]

    @property
    def file_name(self) -> str:
        """Name of its picture, without a suffix."""
        return f"{self.source}-{self.name}"


PressureFigureFunction = Callable[[int], Iterator[PressureFigure]]
_FIGURES: dict[str, PressureFigureFunction] = {}


def pressure_figures_of(name: str) -> Callable[[PressureFigureFunction], PressureFigureFunction]:
    """Register the function that yields the pressure maps of one source for a number of cells."""
    return registered(_FIGURES, name)


def published_pressures(
    source: str | None = None, *, cells: int = 96
) -> tuple[PressureFigure, ...]:
    """Contacts whose pressures papers print, solved on the true flanks.

    **Arguments:**

    - `source`: one of `sources()`; default all of them. A source may have none.
    - `cells`: cells along each axis of the grids.

    **Raises:** `UnknownNameError` for a source that is not covered.
    """
    return tuple(one for function in chosen(_FIGURES, source) for one in function(cells))
