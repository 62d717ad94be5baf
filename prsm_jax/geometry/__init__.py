"""Thread geometry: contact points and curvatures of the flanks, and whether parts fit."""

from ._checks import (
    Finding as Finding,
    Severity as Severity,
    axis_possible as axis_possible,
    bore_margins as bore_margins,
    carrier_clearance as carrier_clearance,
    dimension_margins as dimension_margins,
    dimension_names as dimension_names,
    dimensions_possible as dimensions_possible,
    roller_clearance as roller_clearance,
    roller_major_radius as roller_major_radius,
    rollers_fit as rollers_fit,
)
from ._curvature import RelativeCurvature as RelativeCurvature, tangent_tensor as tangent_tensor
from ._flank_ends import (
    FlankEnd as FlankEnd,
    Way as Way,
    end_names as end_names,
    flank_ends as flank_ends,
    flanks_end as flanks_end,
)
from ._flanks import (
    flanks_of as flanks_of,
    nut_side_heights as nut_side_heights,
    nut_side_hessian as nut_side_hessian,
    past_roller_arc as past_roller_arc,
    screw_side_heights as screw_side_heights,
    screw_side_hessian as screw_side_hessian,
)
from ._meshing import Meshing as Meshing, ThreadContact as ThreadContact, mesh as mesh
from ._ring_flanks import (
    contact_zone as contact_zone,
    fit_parabola as fit_parabola,
    lead_per_radian as lead_per_radian,
    matched_profile_angle as matched_profile_angle,
    ring_gap as ring_gap,
    ring_vertex as ring_vertex,
)
