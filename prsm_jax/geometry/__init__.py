"""Thread geometry: where the flanks touch, how they are curved, and whether parts fit."""

from ._curvature import RelativeCurvature as RelativeCurvature
from ._meshing import Meshing as Meshing, ThreadContact as ThreadContact, mesh as mesh
