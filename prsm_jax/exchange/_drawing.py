"""Drawings as DXF, for CAD: the views of the report's drawing in real millimetres."""

import os
from pathlib import Path

from .._errors import missing_extra
from ..mechanism import Mechanism, stage_at
from ..process import whole_file
from ..report.document import stage_rows
from ..report.drawings import (
    draw_axial_section,
    draw_transverse_view,
    drawing_dimensions,
    drawn_half_length,
)
from ..text import short_heading
from ._dxf_canvas import LETTERS, DxfCanvas, new_document

#: Width of both views on paper, for sizes of letters: A3 with margins [mm].
_PAPER = 380.0
_LARGEST_SCALE = 4.0
#: Space between two views, on paper [mm].
_GAP = 25.0


def write_dxf(path: str | os.PathLike[str], mechanism: Mechanism, *, stage: int = 1) -> Path:
    """Draw a stage to a DXF file: the view along its axis, its half-section, and its dimensions.

    The model space has millimetres and the scale 1:1. The axis of the screw in the view along it is
    at (0, 0); the half-section lies to the right of it, on the same height. Each body has a layer:
    `SCREW`, `ROLLER`, `NUT`, `RING_GEAR`, `CARRIER`; others are `CENTRE_LINES`, `DIMENSIONS`,
    `HATCHING`, `CONTACTS` (points) and `TEXT`. Bodies without given dimensions are drawn broken off
    and named, as in the report. Convex flanks are polylines with 12 points.

    **Arguments:**

    - `path`: the file; it is complete or, if anything fails, as before.
    - `mechanism`: the mechanism.
    - `stage`: which stage, counted from 1.

    **Returns:** the path.

    **Raises:** `ValueError` for a stage that does not exist; `MissingExtraError` without ezdxf.
    """
    try:
        import ezdxf  # noqa: F401
    except ImportError as error:
        raise missing_extra("dxf", "a drawing as DXF", error) from error
    dims = drawing_dimensions(mechanism, stage)
    outer, half = dims.drawn_outer_radius, drawn_half_length(dims)
    scale = min((_PAPER - _GAP) / (2 * outer + 2 * half), _LARGEST_SCALE)
    document = new_document(scale)
    space = document.modelspace()
    across = DxfCanvas(space, (0.0, 0.0), outer, scale)
    draw_transverse_view(across, dims)
    beside = outer + half + across.paper(_GAP)
    draw_axial_section(DxfCanvas(space, (beside, 0.0), half, scale), dims)
    left, line = -outer, across.paper(1.6 * LETTERS)
    below = -outer - across.paper(30.0)
    rows = [("stage", str(stage))] if len(mechanism.stages) > 1 else []
    rows += list(stage_rows(stage_at(mechanism, stage)))
    if dims.not_given:
        rows.append(("not given", ", ".join(dims.not_given)))
    heading = [short_heading(mechanism.title)] if mechanism.title else []
    heading.append(f"Dimensions in mm; letters for a print {scale:.3g}:1.")
    for number, words in enumerate([*heading, *(f"{name}: {value}" for name, value in rows)]):
        across.text(left, below - number * line, words, ha="left", va="top")
    target = Path(path)
    with whole_file(target) as partial:
        document.saveas(partial)
    return target
