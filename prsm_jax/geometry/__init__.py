"""Thread geometry: where the flanks touch, how they are curved, and whether parts fit."""

from ._checks import (
    Finding as Finding,
    geometric_findings as geometric_findings,
    roller_clearance as roller_clearance,
    roller_major_radius as roller_major_radius,
)
from ._curvature import RelativeCurvature as RelativeCurvature
from ._meshing import Meshing as Meshing, ThreadContact as ThreadContact, mesh as mesh
