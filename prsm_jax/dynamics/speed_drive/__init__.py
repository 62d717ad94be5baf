"""Transients whose screw speed is prescribed."""

from ._bristle_transient import (
    BristleState as BristleState,
    bristle_history as bristle_history,
    deflection_scales as deflection_scales,
    states_with_bristles as states_with_bristles,
)
from ._carrier_motion import (
    Problem as Problem,
    carrier_acceleration as carrier_acceleration,
    driven_states as driven_states,
    error_weight as error_weight,
    moves_nut as moves_nut,
    sample_times as sample_times,
    scaled_rate as scaled_rate,
    standstills as standstills,
    states_at as states_at,
)
from ._choose_method import (
    MethodChoice as MethodChoice,
    choose_method as choose_method,
    chosen_method as chosen_method,
    scene_problem as scene_problem,
)
from ._closed_form import closed_form_history as closed_form_history
from ._quasi_steady import (
    quasi_steady_at as quasi_steady_at,
    quasi_steady_report as quasi_steady_report,
)
from ._two_sides_transient import (
    slides_on_both_sides as slides_on_both_sides,
    two_sides_history as two_sides_history,
)
