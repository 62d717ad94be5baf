"""The view along the axis: screw, rollers at their places, nut, gear, carriers, contacts."""

import math
from typing import Any

from ...text import trimmed
from .._style import BODY_COLOURS, MUTED
from ._canvas import Canvas, Length
from ._drawing_dimensions import DrawingDimensions

#: Space for the dimensions above and below the view, on paper [mm].
ABOVE, BELOW = 16.0, 23.0
_STEP = 5.5


def draw_transverse_view(sheet: Canvas, dims: DrawingDimensions) -> None:
    """Draw the transverse view about the origin and dimension it."""
    _nut_and_gear(sheet, dims)
    _screw(sheet, dims)
    _rollers(sheet, dims)
    _contacts(sheet, dims)
    _dimensions(sheet, dims)


def _nut_and_gear(sheet: Canvas, dims: DrawingDimensions) -> None:
    outer = dims.drawn_outer_radius
    style: Any = {"facecolor": BODY_COLOURS["nut"], "hatch": "////", "edgecolor": MUTED}
    sheet.circle(outer, "nut", linewidth=0, **style)
    edge: Any = {"linewidth": 0.9}
    if dims.nut_outer_radius is None:
        edge = {"linewidth": 0.6, "linestyle": (0, (3, 2))}
    sheet.circle(outer, "nut outside", **edge)
    sheet.circle(dims.nut_radius, "nut thread", facecolor="white")
    if dims.ring_outer_radius is not None:
        style = {"edgecolor": "#8f5f86", "linestyle": (0, (4, 1.5))}
        sheet.circle(dims.ring_outer_radius, "ring gear outside", **style)
    if dims.carrier_inner_radius is not None and dims.carrier_outer_radius is not None:
        for radius in (dims.carrier_inner_radius, dims.carrier_outer_radius):
            sheet.circle(radius, "carrier", edgecolor=MUTED, linestyle=(0, (1.5, 1.5)))


def _screw(sheet: Canvas, dims: DrawingDimensions) -> None:
    sheet.circle(dims.screw_radius, "screw", facecolor=BODY_COLOURS["screw"], zorder=2)
    if dims.bore_radius:
        sheet.circle(dims.bore_radius, "bore", facecolor="white", zorder=2)


def _rollers(sheet: Canvas, dims: DrawingDimensions) -> None:
    cross, centre = 0.35 * dims.roller_radius, dims.centre_distance
    empty = {"edgecolor": MUTED, "linestyle": (0, (3, 2))}
    for angle in dims.empty_angles:
        at = centre * math.cos(angle), centre * math.sin(angle)
        sheet.circle(dims.roller_radius, "empty place", at, **empty)
    filled = {"facecolor": BODY_COLOURS["roller"], "zorder": 2}
    for angle in dims.roller_angles:
        x, y = at = centre * math.cos(angle), centre * math.sin(angle)
        sheet.circle(dims.roller_radius, "roller", at, **filled)
        if dims.roller_bore_radius:
            sheet.circle(dims.roller_bore_radius, "roller bore", at, facecolor="white", zorder=2)
        sheet.line((x - cross, x + cross), (y, y), body="roller", zorder=3, lw=0.4)
        sheet.line((x, x), (y - cross, y + cross), body="roller", zorder=3, lw=0.4)
    turn = [math.pi * step / 90 for step in range(181)]
    sheet.centre_line([centre * math.cos(t) for t in turn], [centre * math.sin(t) for t in turn])
    reach = dims.drawn_outer_radius + sheet.paper(1.5)
    sheet.centre_line((-reach, reach), (0, 0))
    sheet.centre_line((0, 0), (-reach, reach))


def _contacts(sheet: Canvas, dims: DrawingDimensions) -> None:
    for contact, side in ((dims.screw_contact, "screw"), (dims.nut_contact, "nut")):
        if contact is None:
            continue
        xs, ys = [], []
        for angle in dims.roller_angles:
            xs.append(contact.x * math.cos(angle) - contact.y * math.sin(angle))
            ys.append(contact.x * math.sin(angle) + contact.y * math.cos(angle))
        sheet.marks(xs, ys, side)


def _dimensions(sheet: Canvas, dims: DrawingDimensions) -> None:
    outer, a, r = dims.drawn_outer_radius, dims.centre_distance, dims.roller_radius

    def level(number: Length, sign: int = 1) -> float:
        return sign * (outer + sheet.paper(3.5 + _STEP * number))

    def with_gear(body: str) -> str:
        return f"{body} and gear" if body == dims.gear_body else body

    roller = f"Ø{trimmed(2 * r)} roller"
    sheet.horizontal_dimension(a - r, a + r, level(0), roller, 0.0, beside="right")
    sheet.horizontal_dimension(0, a, level(1), f"a = {trimmed(a)}", 0.0)
    below = [
        (dims.screw_radius, f"Ø{trimmed(2 * dims.screw_radius)} {with_gear('screw')}"),
        (dims.nut_radius, f"Ø{trimmed(2 * dims.nut_radius)} {with_gear('nut')}"),
    ]
    if dims.nut_outer_radius is not None:
        below.append((outer, f"Ø{trimmed(2 * outer)} outside"))
    for number, (radius, words) in enumerate(below):
        y = level(number + 0.55, -1)
        sheet.horizontal_dimension(-radius, radius, y, words, 0.0)
    if dims.bore_radius:
        x, y = dims.bore_radius * math.cos(2.3), dims.bore_radius * math.sin(2.3)
        words = f"bore Ø{trimmed(2 * dims.bore_radius)}"
        sheet.leader(x, y, -outer * 0.98, level(1), words, ha="center", va="bottom")
