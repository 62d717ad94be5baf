"""Steady states, and the limits of self-locking and jamming."""

from ._carrier_balance import (
    balanced_carrier_ratio as balanced_carrier_ratio,
    carrier_balance as carrier_balance,
    steady_motion as steady_motion,
)
from ._locking import (
    friction_needs_load as friction_needs_load,
    friction_sets_motion as friction_sets_motion,
    jamming_coefficient as jamming_coefficient,
    jamming_margin as jamming_margin,
    jams as jams,
    locking_coefficient as locking_coefficient,
    self_locking_margin as self_locking_margin,
)
from ._root_search import find_roots as find_roots
from ._sliding_contact import SlidingContact as SlidingContact, sliding_contact as sliding_contact
from ._steady import all_kinematics as all_kinematics, steady_state as steady_state
from ._steady_result import (
    STEADY_RESULTS as STEADY_RESULTS,
    SteadyState as SteadyState,
    steady_meaning as steady_meaning,
)
from ._two_sliding_sides import (
    SideSlips as SideSlips,
    SlidingSide as SlidingSide,
    check_losses as check_losses,
    losses_of_both_sides as losses_of_both_sides,
    sliding_side as sliding_side,
    slips_of_both_sides as slips_of_both_sides,
    torque_on_screw as torque_on_screw,
)
