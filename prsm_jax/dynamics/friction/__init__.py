"""Friction of threads, of ellipses that spin, of splines and bearings."""

from ._bristles import (
    breakaway_deflection as breakaway_deflection,
    bristle_friction as bristle_friction,
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
from ._flank import loaded_flank as loaded_flank, turned as turned
from ._rubbing import (
    Rubbing as Rubbing,
    ScrewContact as ScrewContact,
    Slip as Slip,
    rubbed_friction as rubbed_friction,
    rubbing as rubbing,
    rubbing_of as rubbing_of,
    screw_contact as screw_contact,
    spinning_stages as spinning_stages,
)
from ._screw_friction import (
    bearing_torque as bearing_torque,
    drag_torque as drag_torque,
    spline_force as spline_force,
)
from ._thread_friction import slip_direction as slip_direction, thread_friction as thread_friction
