"""The mechanism drawn to scale: across and along its axis, and its threads enlarged."""

from collections.abc import Mapping
from typing import Any

from ...mechanism import Mechanism
from .._parts import body_patches, dense_legend
from .._style import (
    BODY_COLOURS,
    INK,
    MUTED,
    PAGE_WIDTH,
    SMALL,
    TITLE,
    Figure,
    drawn,
    page_figure,
)
from . import _thread_detail
from ._axial_section import (
    ABOVE as ABOVE_SECTION,
    BELOW as BELOW_SECTION,
    draw_axial_section,
    drawn_half_length,
)
from ._canvas import CONTACT_COLOURS
from ._drafting import place_sheet
from ._drawing_dimensions import DrawingDimensions, drawing_dimensions
from ._transverse_view import (
    ABOVE as ABOVE_VIEW,
    BELOW as BELOW_VIEW,
    draw_transverse_view,
)

_MARGIN, _GUTTER, _HEADING, _FOOT = 2.0, 5.0, 12.0, 16.0
#: Height between screw and nut in the enlarged detail of the largest mechanism, on paper [mm].
_DETAIL = 38.0
#: Room for words beside a view, on paper [mm].
_WORDS = 17.0


@drawn
def cross_section(mechanisms: Mapping[str, Mechanism], *, stage: int = 1) -> Figure:
    """Draw one or two mechanisms to the same scale, side by side.

    Each has a view along the axis (screw with its bore, rollers at their places, nut, pitch circle
    of the gear, carriers, contact points from the meshing), a half-section along the axis and a
    few pitches enlarged: straight flanks of screw and nut, convex arcs of the roller. Bodies are
    drawn at their nominal radii. Parts without given dimensions are drawn broken off and named.

    **Arguments:**

    - `mechanisms`: by label, for example `{"before": …, "after": …}`; up to two.
    - `stage`: which stage, counted from 1.

    **Returns:** a matplotlib figure, A4 wide; dimensions in mm.

    **Raises:** `ValueError` without a mechanism, with more than two, or for a stage that does not
    exist; `MissingExtraError` without matplotlib.
    """
    if not 1 <= len(mechanisms) <= 2:
        raise ValueError(
            f"cross_section draws one or two mechanisms, not {len(mechanisms)}; draw the others "
            "in a second picture"
        )
    dims = {label: drawing_dimensions(m, stage) for label, m in mechanisms.items()}
    every = list(dims.values())
    # One mechanism fills the page: its axial section lies beside its transverse view.
    width = (PAGE_WIDTH - 2 * _MARGIN - _GUTTER) / 2
    widest = max(max(2 * d.drawn_outer_radius, 2 * drawn_half_length(d)) for d in every)
    # Beside the nut there must be room for words.
    room = (width / 2 - _WORDS) / max(d.nut_radius for d in every)
    scale = min(width / (widest + 4.0), room, 4.0)
    outer = max(d.drawn_outer_radius for d in every)
    detail_scale = _DETAIL / max(_thread_detail.detail_height(d) for d in every)
    across = 2 * scale * outer + ABOVE_VIEW + BELOW_VIEW
    along = scale * outer + ABOVE_SECTION + BELOW_SECTION
    detail = max(_thread_detail.paper_height(d, detail_scale) for d in every)
    single = len(dims) == 1
    heights = max(across, along + detail + _GUTTER) if single else across + along + detail + _GUTTER
    figure = page_figure(heights + _HEADING + _FOOT, layout=None)
    top = heights + _FOOT
    for column, (label, d) in enumerate(dims.items()):
        left = _MARGIN + column * (width + _GUTTER)
        _heading(figure, left, top, label, d)
        lowest = -outer - BELOW_VIEW / scale
        sheet = place_sheet(figure, left, top - across, width, across, scale, lowest)
        draw_transverse_view(sheet, d)
        if single:
            left, below = left + width + _GUTTER, top
        else:
            below = top - across
        lowest = -BELOW_SECTION / scale
        sheet = place_sheet(figure, left, below - along, width, along, scale, lowest)
        draw_axial_section(sheet, d)
        bottom = below - along - _GUTTER - detail
        lowest = d.centre_distance - detail / detail_scale / 2
        sheet = place_sheet(figure, left, bottom, width, detail, detail_scale, lowest)
        _thread_detail.draw_thread_detail(sheet, d)
    _legend(figure, scale, detail_scale, every)
    return figure


def _at(figure: Figure, x: float, y: float) -> tuple[float, float]:
    width, height = figure.get_size_inches() * 25.4
    return x / width, y / height


def _heading(figure: Figure, left: float, top: float, label: str, dims: DrawingDimensions) -> None:
    figure.text(
        *_at(figure, left, top + 8.5), label, fontsize=TITLE, fontweight="bold", va="center"
    )
    words = f"N = {dims.roller_count} rollers"
    if dims.empty_angles:
        words += f" in {dims.roller_count + len(dims.empty_angles)} places"
    if dims.not_given:
        words += f"\nnot given: {', '.join(dims.not_given)}"
    figure.text(*_at(figure, left, top + 5.5), words, fontsize=SMALL, color=INK, va="top")


def _legend(
    figure: Figure, scale: float, detail_scale: float, every: list[DrawingDimensions]
) -> None:
    from matplotlib.lines import Line2D

    shown = {
        "ring_gear": any(d.ring_outer_radius is not None for d in every),
        "carrier": any(d.carrier_outer_radius is not None for d in every),
    }
    handles: list[Any] = body_patches(body for body in BODY_COLOURS if shown.get(body, True))
    dot = {"ls": "", "marker": "o", "ms": 3.5}
    handles += [
        Line2D([], [], color=CONTACT_COLOURS["screw"], label="contact with screw", **dot),
        Line2D([], [], color=CONTACT_COLOURS["nut"], label="contact with nut", **dot),
    ]
    dense_legend(figure, handles, _at(figure, PAGE_WIDTH / 2, 8.5))
    figure.text(
        *_at(figure, PAGE_WIDTH / 2, 4.0),
        f"Dimensions in mm; bodies at their nominal radii. On A4: views {_ratio(scale)}, detail "
        f"{_ratio(detail_scale)}.\n{_gears_and_contacts(every)}",
        fontsize=SMALL,
        color=MUTED,
        ha="center",
        va="center",
    )


def _gears_and_contacts(every: list[DrawingDimensions]) -> str:
    """What the drawing shows of gears, and of contacts outside of its plane, in words."""
    gears = sorted({str(d.gear_body) for d in every if d.gear_body is not None})
    sliding = sorted({side for d in every for side in d.family.sliding}, reverse=True)
    contacts = f"contacts with the {' and the '.join(sliding)} are projected into the detail."
    if not gears:
        return contacts.capitalize()
    bodies = " or ".join(gears)
    return f"The pitch circle of the gear is the nominal circle of the {bodies}; {contacts}"


def _ratio(scale: float) -> str:
    return f"{scale:.3g} : 1" if scale >= 1 else f"1 : {1 / scale:.3g}"
