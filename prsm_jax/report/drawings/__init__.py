"""Drawings of a mechanism, with dimensions."""

from ._cross_section import cross_section as cross_section
from ._drawing_dimensions import (
    DrawingDimensions as DrawingDimensions,
    drawing_dimensions as drawing_dimensions,
    roller_places as roller_places,
)
from ._section_svg import section_svg as section_svg
