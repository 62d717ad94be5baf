"""Drawings of a mechanism, with dimensions."""

from ._axial_section import (
    draw_axial_section as draw_axial_section,
    drawn_half_length as drawn_half_length,
)
from ._canvas import Beside as Beside, Canvas as Canvas, Length as Length
from ._cross_section import cross_section as cross_section
from ._drawing_dimensions import (
    DrawingDimensions as DrawingDimensions,
    drawing_dimensions as drawing_dimensions,
    roller_places as roller_places,
)
from ._section_svg import section_svg as section_svg
from ._thread_profile import (
    nut_half_thickness as nut_half_thickness,
    roller_half_thickness as roller_half_thickness,
    screw_half_thickness as screw_half_thickness,
)
from ._transverse_view import draw_transverse_view as draw_transverse_view
