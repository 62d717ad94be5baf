"""Friction of threads, spinning contact ellipses, splines and bearings."""

from ._bristles import (
    bristle_power as bristle_power,
    bristle_rate as bristle_rate,
    bristles_of as bristles_of,
    has_bristles as has_bristles,
    in_tangent_plane as in_tangent_plane,
)
from ._contact_losses import (
    ResistingMoment as ResistingMoment,
    has_contact_losses as has_contact_losses,
    resisting_moments as resisting_moments,
    with_resistance as with_resistance,
)
from ._flank import loaded_flank_sign as loaded_flank_sign, turned as turned
from ._law_inputs import Slip as Slip, law_inputs_of as law_inputs_of
from ._rubbing import (
    Rubbing as Rubbing,
    ScrewContact as ScrewContact,
    deflected as deflected,
    friction_on_roller as friction_on_roller,
    has_unknown_share as has_unknown_share,
    rubbing as rubbing,
    rubbing_of as rubbing_of,
    screw_contact as screw_contact,
    unknown_shares as unknown_shares,
)
from ._screw_friction import (
    bearing_torque as bearing_torque,
    drag_torque as drag_torque,
    spline_force as spline_force,
)
from ._thread_friction import (
    friction_coefficient as friction_coefficient,
    slip_direction as slip_direction,
    thread_friction as thread_friction,
)
