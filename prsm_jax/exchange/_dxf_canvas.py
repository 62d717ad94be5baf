"""A drawing in DXF that the views of the report draw on: one layer for each body."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ..report.drawings import Beside, Length
from ..text import printable

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts.layout import Modelspace

#: Layer and colour (AutoCAD's index) of each body.
_BODIES = {
    "screw": ("SCREW", 5),
    "roller": ("ROLLER", 30),
    "nut": ("NUT", 3),
    "ring gear": ("RING_GEAR", 6),
    "carrier": ("CARRIER", 8),
}
#: Bodies of circles whose name does not begin with that of their body.
_OTHER_NAMES = {"bore": "screw", "empty place": "roller"}
_CENTRE, _DIMENSIONS, _TEXT = "CENTRE_LINES", "DIMENSIONS", "TEXT"
_HATCHING, _CONTACTS = "HATCHING", "CONTACTS"
_OTHERS = {_CENTRE: 1, _DIMENSIONS: 7, _TEXT: 7, _HATCHING: 9, _CONTACTS: 4}
#: Height of letters on paper [mm].
LETTERS = 2.5
#: Width of a letter over its height.
_WIDTH = 0.9
_STYLE = "PRSM"


def layer_of(name: str) -> str:
    """Layer of a body, or of a part of it, such as "nut outside" or "bore"."""
    words = name.replace("_", " ")
    words = _OTHER_NAMES.get(words, words)
    return next(layer for body, (layer, _) in _BODIES.items() if words.startswith(body))


class DxfCanvas:
    """A part of the model space of a DXF file, in real millimetres; see `Canvas`.

    Lines, areas and circles lie on the layers of their bodies; styles are ignored, but for dashes.
    """

    def __init__(
        self, space: "Modelspace", place: tuple[Length, Length], half: Length, scale: Length
    ):
        """
        **Arguments:**

        - `space`: the model space.
        - `place`: where the origin of the view lies in it [mm].
        - `half`: half the width of the canvas [mm].
        - `scale`: millimetres on paper for each millimetre of the drawing, for sizes of letters.
        """
        self._space, self._place, self._half, self._scale = space, place, half, scale

    def _at(self, x: Any, y: Any) -> tuple[float, float]:
        return self._place[0] + float(x), self._place[1] + float(y)

    def _points(self, xs: Any, ys: Any) -> list[tuple[float, float]]:
        return [self._at(x, y) for x, y in np.broadcast(np.asarray(xs), np.asarray(ys))]

    @property
    def ends(self) -> tuple[float, float]:
        """The abscissae at which the canvas ends on the left and on the right."""
        return -self._half, self._half

    def paper(self, millimetres: Length) -> float:
        """A length on paper as a length on the drawing."""
        return millimetres / self._scale

    def text(self, x: Length, y: Length, words: str, **style: Any) -> None:
        """Words at a point, one entity for each line."""
        from ezdxf.enums import TextEntityAlignment

        across = {"left": "LEFT", "right": "RIGHT"}.get(style.get("ha", "center"), "CENTER")
        along = {"bottom": "BOTTOM_", "top": "TOP_"}.get(style.get("va", "center"), "MIDDLE_")
        for number, line in enumerate(words.split("\n")):
            place = self._at(x, y - number * self.paper(1.5 * LETTERS))
            # Two signs of per cent would begin a code: "%%c" is a diameter.
            entity = self._space.add_text(
                printable(line).replace("%%", "% %"),
                height=self.paper(LETTERS),
                dxfattribs={"layer": _TEXT},
            )
            entity.set_placement(place, align=TextEntityAlignment[along + across])

    def line(self, xs: Any, ys: Any, *, body: str = "", **style: Any) -> None:
        """A line through points, an edge of a body if it is named."""
        attributes = {"layer": layer_of(body) if body else _TEXT}
        if "ls" in style:
            attributes["linetype"] = "DASHED"
        self._space.add_lwpolyline(self._points(xs, ys), dxfattribs=attributes)

    def centre_line(self, xs: Any, ys: Any) -> None:
        """A chain line: an axis or a pitch circle."""
        self._space.add_lwpolyline(self._points(xs, ys), dxfattribs={"layer": _CENTRE})

    def area(self, xs: Any, ys: Any, body: str, hatch: str = "", outlined: bool = True) -> None:
        """The outline of a body, and its hatching if it is cut."""
        points = self._points(xs, ys)
        if outlined:
            self._space.add_lwpolyline(points, close=True, dxfattribs={"layer": layer_of(body)})
        if hatch:
            pattern = self._space.add_hatch(dxfattribs={"layer": _HATCHING})
            angle = 90.0 if "\\" in hatch else 0.0
            name = "ANSI37" if "x" in hatch else "ANSI31"
            pattern.set_pattern_fill(name, scale=self.paper(0.5), angle=angle)
            pattern.paths.add_polyline_path(points, is_closed=True)

    def circle(
        self, radius: Length, name: str, at: tuple[Length, Length] = (0, 0), **style: Any
    ) -> None:
        """A circle; none where the picture has only a filled disc, whose edge has its own name."""
        if style.get("linewidth") == 0:
            return
        attributes = {"layer": layer_of(name)}
        if "linestyle" in style:
            attributes["linetype"] = "DASHED"
        self._space.add_circle(self._at(*at), float(radius), dxfattribs=attributes)

    def marks(self, xs: Any, ys: Any, side: str) -> None:
        """Contact points with the screw or the nut."""
        for point in self._points(xs, ys):
            self._space.add_point(point, dxfattribs={"layer": _CONTACTS})

    def horizontal_dimension(
        self, x0: Length, x1: Length, y: Length, words: str, start: Length, beside: Beside = ""
    ) -> None:
        """A linear dimension, whose measured length the reading program finds again.

        The words stand over the line, or beside it on the left or right where there is no room.
        """
        dimension = self._space.add_linear_dim(
            self._at((x0 + x1) / 2, y),
            self._at(x0, start),
            self._at(x1, start),
            text=printable(words) or "<>",
            dimstyle=_STYLE,
            dxfattribs={"layer": _DIMENSIONS},
        )
        if beside:
            away = self.paper(1.2 + _WIDTH * LETTERS * len(words) / 2)
            middle = x1 + away if beside == "right" else x0 - away
            dimension.set_location(self._at(middle, y))
        dimension.render()

    def leader(
        self, x: Length, y: Length, words_x: Length, words_y: Length, words: str, **style: Any
    ) -> None:
        """Words with a line to a point."""
        ends = self._points((words_x, x), (words_y, y))
        self._space.add_lwpolyline(ends, dxfattribs={"layer": _DIMENSIONS})
        self.text(words_x, words_y, words, **style)

    def scale_bar(self, x: Length, y: Length, length: Length) -> None:
        """Nothing: a file in millimetres needs none."""


def new_document(scale: Length) -> "Drawing":
    """An empty drawing in millimetres with the layers of all bodies.

    **Arguments:**

    - `scale`: millimetres on paper for each millimetre of the drawing.
    """
    from ezdxf.filemanagement import new

    document = new("R2010", setup=True, units=4)
    document.header["$LTSCALE"] = 5 / scale
    document.header["$PDMODE"] = 3
    document.header["$PDSIZE"] = 1 / scale
    for layer, colour in (*_BODIES.values(), *_OTHERS.items()):
        kind = "CENTER" if layer == _CENTRE else "Continuous"
        document.layers.add(layer, color=colour, linetype=kind)
    style = document.dimstyles.duplicate_entry("EZDXF", _STYLE)
    # Lengths are measured in drawing units, and sizes are those on paper.
    style.dxf.dimlfac, style.dxf.dimdec = 1.0, 3
    style.dxf.dimtxt, style.dxf.dimgap = LETTERS / scale, 0.6 / scale
    style.dxf.dimexe, style.dxf.dimexo, style.dxf.dimasz = 0.8 / scale, 0.0, 2.0 / scale
    style.dxf.dimblk, style.dxf.dimtxsty = "", "Standard"
    return document
