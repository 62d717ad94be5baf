"""The half-section along the axis, with every thread at its position."""

import numpy as np

from ...text import trimmed
from .._style import INK
from ._canvas import Beside, Canvas
from ._drawing_dimensions import DrawingDimensions
from ._thread_profile import (
    nut_profile,
    nut_shift,
    roller_profile,
    screw_profile,
    screw_shift,
    tooth_centres,
)

#: Space for the dimensions above and below the section, on paper [mm].
ABOVE, BELOW = 8.0, 21.0
#: Width of a letter on paper, in the format with the larger letters [mm].
_LETTER = 2.0
#: How far the screw is drawn beyond the nut [mm, real].
_STUB = 5.0


def drawn_half_length(dims: DrawingDimensions) -> float:
    """Half the length of the drawing along the axis [mm]."""
    inside = dims.drawn_roller_length / 2 + (dims.carrier_length or 0.0)
    return max(dims.drawn_nut_length / 2, inside) + _STUB


def draw_axial_section(sheet: Canvas, dims: DrawingDimensions) -> None:
    """Draw the half-section about the middle of the rollers and dimension it."""
    half = drawn_half_length(dims)
    roller = dims.drawn_roller_length / 2
    gear = min(dims.gear_width or 0.0, roller / 2)
    threaded = roller - gear
    _screw(sheet, dims, half, threaded)
    _nut(sheet, dims, threaded)
    _roller(sheet, dims, roller, threaded)
    _carriers(sheet, dims, roller)
    overhang = half + sheet.paper(2)
    sheet.centre_line((-overhang, overhang), (0, 0))
    sheet.centre_line(
        (-roller - sheet.paper(3), roller + sheet.paper(3)), (dims.centre_distance,) * 2
    )
    _dimensions(sheet, dims, half)


def _screw(sheet: Canvas, dims: DrawingDimensions, half: float, threaded: float) -> None:
    complete = dims.screw_length is not None and dims.screw_length / 2 <= half
    end = dims.screw_length / 2 if complete and dims.screw_length is not None else half
    # A screw that carries its rollers has thread only where they are, and teeth beside it.
    carries = dims.family.carrying == "screw"
    reach = min(end, threaded) if carries else end
    centres = tooth_centres(dims, -reach, reach, shifted=True)
    along, radius = screw_profile(dims, centres + screw_shift(dims))
    bore = dims.bore_radius or 0.0
    root = dims.screw_radius - dims.screw_dedendum
    if complete:
        left = right = np.array([[end, root], [end, bore]])
    else:
        left = right = _break_line(end, root, bore)
    xs = np.concatenate([-left[::-1, 0], along, right[:, 0]])
    ys = np.concatenate([left[::-1, 1], radius, right[:, 1]])
    sheet.area(xs, ys, "screw", hatch="\\\\\\\\")
    if carries and dims.gear_width is not None:
        for sign in (-1, 1):
            inside, outside = sign * threaded, sign * (threaded + dims.gear_width)
            xs = [inside, outside, outside, inside]
            sheet.area(xs, [root, root, dims.screw_radius, dims.screw_radius], "screw")
    if bore:
        sheet.line((-end, end), (bore, bore), body="screw", color=INK)


def _break_line(x: float, top: float, bottom: float):
    """The wavy edge of a part that is broken off."""
    share = np.linspace(0, 1, 25)
    wave = 0.6 * np.sin(2 * np.pi * share)
    return np.column_stack([x + wave, top + (bottom - top) * share])


def _nut(sheet: Canvas, dims: DrawingDimensions, threaded: float) -> None:
    half, outer = dims.drawn_nut_length / 2, dims.drawn_outer_radius
    plain = dims.nut_radius + dims.nut_dedendum
    reach = half if dims.family.carrying == "screw" else min(threaded, half)
    centres = tooth_centres(dims, -reach, reach, shifted=not dims.shifted_at_nut)
    along, radius = nut_profile(dims, centres + nut_shift(dims))
    xs = np.concatenate([[-half], along, [half, half, -half]])
    ys = np.concatenate([[plain], radius, [plain, outer, outer]])
    open_edges = dims.nut_outer_radius is None or dims.nut_length is None
    if open_edges:
        sheet.area(xs, ys, "nut", hatch="////", outlined=False)
        dashed = {"ls": (0, (3, 2)), "color": INK, "lw": 0.6}
        edge = (plain, outer, outer, plain)
        sheet.line((-half, -half, half, half), edge, body="nut", **dashed)
        sheet.line(
            np.concatenate([[-half], along, [half]]),
            np.concatenate([[plain], radius, [plain]]),
            body="nut",
            color=INK,
            lw=0.6,
        )
    else:
        sheet.area(xs, ys, "nut", hatch="////")
    if dims.ring_length is not None and dims.ring_outer_radius is not None:
        edge = dims.drawn_roller_length / 2
        for sign in (-1, 1):
            outside, inside = sign * edge, sign * (edge - dims.ring_length)
            xs = [outside, inside, inside, outside]
            inner, rim = dims.nut_radius, dims.ring_outer_radius
            sheet.area(xs, [inner, inner, rim, rim], "ring_gear", hatch="....")


def _roller(sheet: Canvas, dims: DrawingDimensions, roller: float, threaded: float) -> None:
    a = dims.centre_distance
    outside = tooth_centres(dims, -threaded, threaded, shifted=dims.shifted_at_nut)
    top = roller_profile(dims, outside, 1)
    bottom = roller_profile(dims, tooth_centres(dims, -threaded, threaded, shifted=False), -1)
    high, low = a + dims.roller_radius, a - dims.roller_radius
    end = [threaded, roller, roller, threaded]
    xs = np.concatenate([top[0], end, bottom[0][::-1], [-x for x in end[::-1]]])
    right = [high, high, low, low]
    ys = np.concatenate([top[1], right, bottom[1][::-1], right[::-1]])
    sheet.area(xs, ys, "roller")
    for sign in (-1, 1):
        if threaded < roller:
            sheet.line((sign * threaded,) * 2, (low, high), body="roller", color=INK, lw=0.5)


def _carriers(sheet: Canvas, dims: DrawingDimensions, roller: float) -> None:
    inner, outer, length = dims.carrier_inner_radius, dims.carrier_outer_radius, dims.carrier_length
    if inner is None or outer is None or length is None:
        return
    for sign in (-1, 1)[: dims.carrier_count]:
        xs = [sign * roller, sign * (roller + length), sign * (roller + length), sign * roller]
        sheet.area(xs, [inner, inner, outer, outer], "carrier", hatch="xxxx")


def _dimensions(sheet: Canvas, dims: DrawingDimensions, half: float) -> None:
    top = dims.drawn_outer_radius
    if dims.nut_length is not None:
        nut = dims.nut_length / 2
        sheet.horizontal_dimension(
            -nut, nut, top + sheet.paper(3.5), f"nut {trimmed(dims.nut_length)}", top
        )
    below = -sheet.paper(6.5)
    if dims.roller_length is not None:
        roller = dims.roller_length / 2
        sheet.horizontal_dimension(
            -roller, roller, below, f"roller {trimmed(dims.roller_length)}", dims.centre_distance
        )
    _end_dimensions(sheet, dims)
    _, right = sheet.ends
    sheet.scale_bar(right - sheet.paper(2) - 10, below + sheet.paper(0.9), 10)
    if dims.screw_length is not None and dims.screw_length / 2 > half:
        words = f"screw {trimmed(dims.screw_length)}, broken off"
        sheet.text(0, -sheet.paper(19), words)


def _narrow_dimension(
    sheet: Canvas, ends: tuple[float, float], y: float, words: str, start: float
) -> None:
    """A dimension at an end of the section, with words over its line, or beside it if it is narrow.

    They stand outside if there is room up to the end of the sheet, else under the roller: only
    lines of the two dimensions at the ends pass there.
    """
    x0, x1 = ends
    needed = sheet.paper(_LETTER * len(words) + 1)
    left, right = sheet.ends
    side: Beside = ""
    if x1 - x0 < needed:
        side = "left" if x0 < 0 else "right"
        if (x0 - left if x0 < 0 else right - x1) < needed:
            side = "right" if x0 < 0 else "left"
    sheet.horizontal_dimension(x0, x1, y, words, start, side)


def _end_dimensions(sheet: Canvas, dims: DrawingDimensions) -> None:
    """Dimensions of gear, ring gear and carrier, under that of the roller."""
    roller, below = dims.drawn_roller_length / 2, -sheet.paper(11.5)
    middle = dims.centre_distance
    if dims.gear_width is not None:
        inside = roller - min(dims.gear_width, roller / 2)
        words = f"gear {trimmed(dims.gear_width)}"
        _narrow_dimension(sheet, (-roller, -inside), below, words, middle - dims.roller_radius)
    words = []
    if dims.ring_length is not None and dims.ring_outer_radius is not None:
        words.append(
            f"ring gear {trimmed(dims.ring_length)}, ⌀{trimmed(2 * dims.ring_outer_radius)}"
        )
    inner, outer, length = dims.carrier_inner_radius, dims.carrier_outer_radius, dims.carrier_length
    if inner is not None and outer is not None and length is not None:
        if dims.carrier_count > 1:
            words_of_one = f"carrier {trimmed(length)}"
            _narrow_dimension(sheet, (roller, roller + length), below, words_of_one, inner)
        words.append(f"carrier {trimmed(length)}, ⌀{trimmed(2 * inner)} to ⌀{trimmed(2 * outer)}")
    if words:
        sheet.text(0, -sheet.paper(15.5), "; ".join(words))
