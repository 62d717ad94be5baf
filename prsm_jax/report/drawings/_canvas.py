"""What views are drawn on, in real millimetres."""

from typing import Any, Literal, Protocol, TypeAlias, runtime_checkable

#: A length on the drawing or on paper [mm].
Length: TypeAlias = float | int
#: Where the words of a dimension stand: over its line, or beside it.
Beside: TypeAlias = Literal["", "left", "right"]
CONTACT_COLOURS = {"screw": "#d55e00", "nut": "#0072b2"}


@runtime_checkable
class Canvas(Protocol):
    """What a view is drawn on: a `Sheet` of a figure, or a drawing of another format.

    Lengths and places are in real millimetres. A style has the words of matplotlib; a format
    without them ignores it, but for dashes (`ls`).
    """

    @property
    def ends(self) -> tuple[float, float]:
        """The abscissae at which the canvas ends on the left and on the right."""
        ...

    def paper(self, millimetres: Length) -> float:
        """A length on paper as a length on the drawing."""
        ...

    def text(self, x: Length, y: Length, words: str, **style: Any) -> None:
        """Words at a point."""
        ...

    def line(self, xs: Any, ys: Any, *, body: str = "", **style: Any) -> None:
        """A line through points, an edge of a body if it is named."""
        ...

    def centre_line(self, xs: Any, ys: Any) -> None:
        """A chain line: an axis or a pitch circle."""
        ...

    def area(self, xs: Any, ys: Any, body: str, hatch: str = "", outlined: bool = True) -> None:
        """A closed area of a body, cut if it is hatched."""
        ...

    def circle(
        self, radius: Length, name: str, at: tuple[Length, Length] = (0, 0), **style: Any
    ) -> None:
        """A circle; its name begins with the body: "nut outside"."""
        ...

    def marks(self, xs: Any, ys: Any, side: str) -> None:
        """Contact points with the screw or the nut."""
        ...

    def horizontal_dimension(
        self, x0: Length, x1: Length, y: Length, words: str, start: Length, beside: Beside = ""
    ) -> None:
        """A dimension between two abscissae at height y, with extension lines from `start`.

        The words stand over the line, or beside it on the left or right where there is no room.
        """
        ...

    def leader(
        self, x: Length, y: Length, words_x: Length, words_y: Length, words: str, **style: Any
    ) -> None:
        """Words with an arrow to a point."""
        ...

    def scale_bar(self, x: Length, y: Length, length: Length) -> None:
        """A bar of a real length."""
        ...
