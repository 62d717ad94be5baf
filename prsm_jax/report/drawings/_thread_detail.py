"""A few pitches of screw, roller and nut, enlarged, with true flanks."""

import math

import numpy as np

from ...text import trimmed
from .._style import BODY_COLOURS, INK, SMALL
from ._canvas import CONTACT_COLOURS
from ._drafting import Sheet
from ._drawing_dimensions import DrawingDimensions
from ._thread_profile import (
    nut_half_thickness,
    nut_profile,
    nut_shift,
    roller_half_thickness,
    roller_profile,
    screw_half_thickness,
    screw_profile,
    screw_shift,
    tooth_centres,
)

#: Material shown under the screw's and over the nut's thread, on paper [mm].
_BODY = 9.5


def detail_height(dims: DrawingDimensions) -> float:
    """Height between the screw's and the nut's nominal radius [mm]."""
    return dims.nut_radius - dims.screw_radius


def paper_height(dims: DrawingDimensions, scale: float) -> float:
    """Height of the drawing on paper [mm]."""
    return scale * detail_height(dims) + 2 * _BODY


def draw_thread_detail(sheet: Sheet, dims: DrawingDimensions) -> None:
    """Draw the threads in the plane of both axes, and dimension pitch, flank angle and arc.

    Teeth are as thin as the file says; their loaded flanks touch, and the play is at the others.
    """
    left, right = sheet.axes.get_xlim()
    reach = right + dims.pitch
    between = {
        shifted: tooth_centres(dims, -reach - dims.pitch, reach + dims.pitch, shifted)
        for shifted in (False, True)
    }
    low, high = sheet.axes.get_ylim()
    screw = screw_profile(dims, between[True] + screw_shift(dims))
    outside = between[dims.shifted_at_nut]
    upper, lower = roller_profile(dims, outside, 1), roller_profile(dims, between[False], -1)
    nut = nut_profile(dims, between[not dims.shifted_at_nut] + nut_shift(dims))
    axes = sheet.axes
    axes.fill_between(*screw, low, facecolor=BODY_COLOURS["screw"], linewidth=0)
    axes.fill_between(*nut, high, facecolor=BODY_COLOURS["nut"], linewidth=0)
    axes.fill(
        np.concatenate([upper[0], lower[0][::-1]]),
        np.concatenate([upper[1], lower[1][::-1]]),
        facecolor=BODY_COLOURS["roller"],
        linewidth=0,
    )
    for outline in (screw, nut, upper, lower):
        axes.plot(*outline, color=INK, lw=0.8)
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)
    for radius in (dims.screw_radius, dims.centre_distance, dims.nut_radius):
        sheet.centre_line((left, right), (radius, radius))
    _contact_marks(sheet, dims, between)
    _pitch(sheet, dims)
    _flank_angle(sheet, dims)
    _profile_radius(sheet, dims)
    edge = left + sheet.paper(1.5)
    sheet.text(edge, low + sheet.paper(1.2), "screw", ha="left", va="bottom")
    sheet.text(edge, high - sheet.paper(1.2), "nut", ha="left", va="top")
    sheet.text(edge, dims.centre_distance + sheet.paper(0.6), "roller", ha="left", va="bottom")
    sheet.scale_bar(right - sheet.paper(4.0) - 1, low + sheet.paper(1.8), 1)


def _contact_marks(sheet: Sheet, dims: DrawingDimensions, between) -> None:
    """Loaded flanks of the roller's teeth: right-hand ones at the screw, left-hand at the nut.

    Contacts with a body on which rollers slide lie outside this plane, and are shown in projection.
    """
    style = {"ls": "", "marker": "o", "ms": 3.2, "mec": "white", "mew": 0.4, "zorder": 5}
    left, right = sheet.axes.get_xlim()
    if dims.nut_contact is not None:
        inwards = dims.nut_radius - dims.nut_contact.x
        xs = between[dims.shifted_at_nut] - dims.pitch / 2 + nut_shift(dims)
        xs = xs + nut_half_thickness(dims, inwards)
        xs = xs[(xs > left) & (xs < right)]
        style["mfc"] = CONTACT_COLOURS["nut"]
        sheet.axes.plot(xs, np.full_like(xs, dims.nut_contact.x), **style)
    if dims.screw_contact is not None:
        height = dims.screw_contact.x - dims.screw_radius
        xs = between[True] + screw_shift(dims) - screw_half_thickness(dims, height)
        xs = xs[(xs > left) & (xs < right)]
        style["mfc"] = CONTACT_COLOURS["screw"]
        sheet.axes.plot(xs, np.full_like(xs, dims.screw_contact.x), **style)


def _pitch(sheet: Sheet, dims: DrawingDimensions) -> None:
    y = dims.nut_radius + sheet.paper(3.4)
    starts = "1 start" if dims.starts == 1 else f"{trimmed(dims.starts)} starts"
    words = f"pitch {trimmed(dims.pitch)}   (lead {trimmed(dims.lead)}, {starts})"
    sheet.horizontal_dimension(0, dims.pitch, y, "", dims.nut_radius)
    sheet.text(dims.pitch / 2, y + sheet.paper(0.9), words, va="bottom")


def _flank_angle(sheet: Sheet, dims: DrawingDimensions) -> None:
    """Angle between transverse plane and flank of a screw tooth, extended into the body."""
    from matplotlib.patches import Arc

    angle = dims.flank_angle
    centre = dims.pitch * (round(-0.25 * sheet.axes.get_xlim()[1] / dims.pitch) + 0.5)
    x = centre + screw_shift(dims) + float(screw_half_thickness(dims, 0.0))
    y = dims.screw_radius
    length = sheet.paper(7.5)
    direction = math.atan2(-math.cos(angle), math.sin(angle))
    for end_x, end_y in ((0.0, -1.0), (math.cos(direction), math.sin(direction))):
        xs, ys = (x, x + length * end_x), (y, y + length * end_y)
        sheet.line(xs, ys, color=INK, ls=(0, (3, 1.5)))
    size = 2 * sheet.paper(5.0)
    sheet.axes.add_patch(
        Arc((x, y), size, size, theta1=-90, theta2=math.degrees(direction), color=INK, lw=0.6)
    )
    sheet.text(
        x + sheet.paper(8.0),
        y - sheet.paper(5.5),
        f"flank α = {trimmed(math.degrees(angle), 2)}°",
        ha="left",
        va="center",
    )


def _profile_radius(sheet: Sheet, dims: DrawingDimensions) -> None:
    """An arrow from the arc's centre, or from the edge of the drawing, to the flank."""
    left, right = sheet.axes.get_xlim()
    radius, angle = dims.profile_radius, dims.flank_angle
    place = 0.5 if dims.shifted_at_nut else 0.0
    tooth = dims.pitch * (math.floor(0.3 * right / dims.pitch) + place)
    tip_x = tooth + float(roller_half_thickness(dims, 0.0))
    tip_y = dims.nut_radius
    direction = (-math.cos(angle), -math.sin(angle))
    drawn = min(radius, (tip_x - left - sheet.paper(4)) / max(math.cos(angle), 1e-6))
    drawn = min(drawn, sheet.paper(42.0))
    start = (tip_x + drawn * direction[0], tip_y + drawn * direction[1])
    arrow = {"arrowstyle": "-|>", "mutation_scale": 6, "shrinkA": 0, "shrinkB": 0}
    arrow |= {"color": INK, "lw": 0.6}
    sheet.axes.annotate("", (tip_x, tip_y), start, arrowprops=arrow)
    if drawn == radius:
        sheet.axes.plot(*start, marker="+", ms=5, mew=0.7, color=INK)
    middle = 0.45 * drawn
    sheet.axes.text(
        tip_x + middle * direction[0] + sheet.paper(1.5),
        tip_y + middle * direction[1] - sheet.paper(0.5),
        f"ρ = {trimmed(radius)}",
        fontsize=SMALL,
        ha="left",
        va="top",
    )
