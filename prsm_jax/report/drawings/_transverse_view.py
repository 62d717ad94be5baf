"""The view along the axis: screw, rollers at their places, nut, gear, carriers, contacts."""

import math

from ...text import trimmed
from .._style import BODY_COLOURS, INK, MUTED
from ._drafting import Length, Sheet
from ._drawing_dimensions import DrawingDimensions

#: Space for the dimensions above and below the view, on paper [mm].
ABOVE, BELOW = 16.0, 23.0
_STEP = 5.5


def draw_transverse_view(sheet: Sheet, dims: DrawingDimensions) -> None:
    """Draw the transverse view about the origin and dimension it."""
    _nut_and_gear(sheet, dims)
    _screw(sheet, dims)
    _rollers(sheet, dims)
    _contacts(sheet, dims)
    _dimensions(sheet, dims)


def _circle(sheet: Sheet, x: Length, y: Length, radius: Length, name: str, **kwargs) -> None:
    from matplotlib.patches import Circle

    style = {"facecolor": "none", "edgecolor": INK, "linewidth": 0.8} | kwargs
    sheet.axes.add_patch(Circle((x, y), radius, label=name, **style))


def _nut_and_gear(sheet: Sheet, dims: DrawingDimensions) -> None:
    open_wall = dims.nut_outer_radius is None
    _circle(
        sheet,
        0,
        0,
        dims.drawn_outer_radius,
        "nut",
        facecolor=BODY_COLOURS["nut"],
        hatch="////",
        edgecolor=MUTED,
        linewidth=0,
    )
    _circle(
        sheet,
        0,
        0,
        dims.drawn_outer_radius,
        "nut outside",
        linewidth=0.6 if open_wall else 0.9,
        linestyle=(0, (3, 2)) if open_wall else "-",
    )
    _circle(sheet, 0, 0, dims.nut_radius, "nut thread", facecolor="white")
    if dims.ring_outer_radius is not None:
        _circle(
            sheet,
            0,
            0,
            dims.ring_outer_radius,
            "ring gear outside",
            edgecolor="#8f5f86",
            linestyle=(0, (4, 1.5)),
        )
    if dims.carrier_inner_radius is not None and dims.carrier_outer_radius is not None:
        for radius in (dims.carrier_inner_radius, dims.carrier_outer_radius):
            _circle(sheet, 0, 0, radius, "carrier", edgecolor=MUTED, linestyle=(0, (1.5, 1.5)))


def _screw(sheet: Sheet, dims: DrawingDimensions) -> None:
    _circle(sheet, 0, 0, dims.screw_radius, "screw", facecolor=BODY_COLOURS["screw"], zorder=2)
    if dims.bore_radius:
        _circle(sheet, 0, 0, dims.bore_radius, "bore", facecolor="white", zorder=2)


def _rollers(sheet: Sheet, dims: DrawingDimensions) -> None:
    cross = 0.35 * dims.roller_radius
    for angle in dims.empty_angles:
        x, y = dims.centre_distance * math.cos(angle), dims.centre_distance * math.sin(angle)
        _circle(
            sheet,
            x,
            y,
            dims.roller_radius,
            "empty place",
            edgecolor=MUTED,
            linestyle=(0, (3, 2)),
        )
    for angle in dims.roller_angles:
        x, y = dims.centre_distance * math.cos(angle), dims.centre_distance * math.sin(angle)
        _circle(
            sheet, x, y, dims.roller_radius, "roller", facecolor=BODY_COLOURS["roller"], zorder=2
        )
        if dims.roller_bore_radius:
            _circle(
                sheet, x, y, dims.roller_bore_radius, "roller bore", facecolor="white", zorder=2
            )
        sheet.line((x - cross, x + cross), (y, y), zorder=3, lw=0.4)
        sheet.line((x, x), (y - cross, y + cross), zorder=3, lw=0.4)
    turn = [math.pi * step / 90 for step in range(181)]
    a = dims.centre_distance
    sheet.centre_line([a * math.cos(t) for t in turn], [a * math.sin(t) for t in turn])
    reach = dims.drawn_outer_radius + sheet.paper(1.5)
    sheet.centre_line((-reach, reach), (0, 0))
    sheet.centre_line((0, 0), (-reach, reach))


def _contacts(sheet: Sheet, dims: DrawingDimensions) -> None:
    for contact, face in ((dims.screw_contact, "#d55e00"), (dims.nut_contact, "#0072b2")):
        if contact is None:
            continue
        xs, ys = [], []
        for angle in dims.roller_angles:
            xs.append(contact.x * math.cos(angle) - contact.y * math.sin(angle))
            ys.append(contact.x * math.sin(angle) + contact.y * math.cos(angle))
        sheet.axes.plot(xs, ys, "o", ms=2.6, mfc=face, mec="white", mew=0.3, zorder=4)


def _dimensions(sheet: Sheet, dims: DrawingDimensions) -> None:
    outer, a, r = dims.drawn_outer_radius, dims.centre_distance, dims.roller_radius

    def level(number: Length, sign: int = 1) -> float:
        return sign * (outer + sheet.paper(3.5 + _STEP * number))

    roller = f"Ø{trimmed(2 * r)} roller"
    sheet.horizontal_dimension(a - r, a + r, level(0), roller, 0.0, beside=True)
    sheet.horizontal_dimension(0, a, level(1), f"a = {trimmed(a)}", 0.0)
    below = [
        (dims.screw_radius, f"Ø{trimmed(2 * dims.screw_radius)} screw"),
        (dims.nut_radius, f"Ø{trimmed(2 * dims.nut_radius)} nut and gear"),
    ]
    if dims.nut_outer_radius is not None:
        below.append((outer, f"Ø{trimmed(2 * outer)} outside"))
    for number, (radius, words) in enumerate(below):
        y = level(number + 0.55, -1)
        sheet.horizontal_dimension(-radius, radius, y, words, 0.0)
    if dims.bore_radius:
        x, y = dims.bore_radius * math.cos(2.3), dims.bore_radius * math.sin(2.3)
        sheet.leader(
            x,
            y,
            -outer * 0.98,
            level(1),
            f"bore Ø{trimmed(2 * dims.bore_radius)}",
            ha="center",
            va="bottom",
        )
