"""Contact mechanics of the threads."""

from ..mechanism import contact_approximation as contact_approximation
from ._contacts import (
    load_of as load_of,
    speed_of as speed_of,
    thread_contacts as thread_contacts,
)
from ._conventions import ContactFrame as ContactFrame, contact_frames as contact_frames
from ._edge_pressure import (
    RoundedEdge as RoundedEdge,
    edge_ratio as edge_ratio,
    largest_pressure as largest_pressure,
    opposite_onset as opposite_onset,
    rounded_edges as rounded_edges,
)
from ._line_contact import (
    LineContactResult as LineContactResult,
    SliceGeometry as SliceGeometry,
    line_contact as line_contact,
    line_contact_under_force as line_contact_under_force,
)
from ._slip_and_spin import (
    EllipseShape as EllipseShape,
    Sliding as Sliding,
    ellipse_shape as ellipse_shape,
    slip_and_spin as slip_and_spin,
)
from ._thread_contact import (
    StageContact as StageContact,
    ThreadContactSide as ThreadContactSide,
    contact_pair as contact_pair,
    contact_side as contact_side,
    engaged_threads as engaged_threads,
    meshing_of as meshing_of,
    side_contact as side_contact,
    stage_contact as stage_contact,
)
from ._truncation import (
    Onsets as Onsets,
    half_extent as half_extent,
    half_extents as half_extents,
    load_beyond as load_beyond,
    onset_pressures as onset_pressures,
    padded_onsets as padded_onsets,
    pressure_ratio as pressure_ratio,
    risk_beyond as risk_beyond,
    risk_ratio as risk_ratio,
    share_within as share_within,
    truncation as truncation,
)
from .hertz import (
    APPROXIMATIONS as APPROXIMATIONS,
    HertzContact as HertzContact,
    HertzMethod as HertzMethod,
    axis_ratio_of as axis_ratio_of,
    contact_modulus as contact_modulus,
    hertz_contact as hertz_contact,
    lisowski_coefficients as lisowski_coefficients,
)
from .special_functions import (
    associated_elliptic_integrals as associated_elliptic_integrals,
    complete_elliptic_integrals as complete_elliptic_integrals,
)
from .stress import (
    AxisMeasure as AxisMeasure,
    StressPeak as StressPeak,
    axis_stress as axis_stress,
    line_subsurface_stress as line_subsurface_stress,
    max_shear_stress as max_shear_stress,
    principal_stresses as principal_stresses,
    stress_peak as stress_peak,
    stress_peak_on_axis as stress_peak_on_axis,
    subsurface_stress as subsurface_stress,
    von_mises_stress as von_mises_stress,
)
