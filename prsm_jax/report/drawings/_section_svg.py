"""The views of a stage as light SVG, for a page that draws a design anew while it changes."""

from ...mechanism import Mechanism
from ._axial_section import (
    ABOVE as ABOVE_SECTION,
    BELOW as BELOW_SECTION,
    draw_axial_section,
    drawn_half_length,
)
from ._drawing_dimensions import drawing_dimensions
from ._svg_sheet import SvgSheet
from ._transverse_view import ABOVE, BELOW, draw_transverse_view

#: Width of a view on paper [mm].
_WIDTH = 96.0
#: Scales on paper: a design that changes a little keeps its scale.
_SCALES = (4.0, 3.0, 2.5, 2.0, 1.5, 1.2, 1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.25, 0.2, 0.15, 0.1)
#: Room for words beside the nut on both sides, on paper [mm].
_WORDS = 30.0


def section_svg(mechanism: Mechanism, stage: int = 1) -> tuple[str, str, float]:
    """The view along the axis and the half-section, both to one scale, as `cross_section` draws.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `stage`: which stage, counted from 1.

    **Returns:** both views as SVG whose units are millimetres on paper, and the scale on paper.

    **Raises:** `ValueError` for a stage that does not exist.
    """
    dims = drawing_dimensions(mechanism, stage)
    outer = dims.drawn_outer_radius
    widest = max(2 * outer + _WORDS / 4, 2 * drawn_half_length(dims) + 4.0)
    room = min(_WIDTH / widest, (_WIDTH - _WORDS) / (2 * dims.nut_radius))
    scale = next((one for one in _SCALES if one <= room), _SCALES[-1])
    across = SvgSheet(_WIDTH, 2 * scale * outer + ABOVE + BELOW, scale, -outer - BELOW / scale)
    draw_transverse_view(across, dims)
    height = scale * outer + ABOVE_SECTION + BELOW_SECTION
    along = SvgSheet(_WIDTH, height, scale, -BELOW_SECTION / scale)
    draw_axial_section(along, dims)
    words = f"{dims.roller_count} rollers of {2 * dims.roller_radius:.4g} mm in diameter"
    return (
        across.svg(f"View along the axis: {words}"),
        along.svg(f"Half-section along the axis: {words}"),
        scale,
    )
