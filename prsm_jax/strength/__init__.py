"""Strength and life of a stage: capacities, rating life, buckling, critical speed, play."""

from ._contacts import (
    is_preloaded as is_preloaded,
    preload_of as preload_of,
    reference_contact as reference_contact,
    split_nut_of as split_nut_of,
    strength_of as strength_of,
)
from ._edges import (
    EndReach as EndReach,
    edge_pressure as edge_pressure,
    end_reaches as end_reaches,
    side_edges as side_edges,
)
from ._equivalent_balls import (
    equivalent_ball_capacity as equivalent_ball_capacity,
    equivalent_ball_diameter as equivalent_ball_diameter,
)
from ._fatigue import (
    cuts_fatigue as cuts_fatigue,
    cycles_per_turn as cycles_per_turn,
    dynamic_capacity as dynamic_capacity,
    fatigue_sharing_factor as fatigue_sharing_factor,
    truncated_fatigue as truncated_fatigue,
)
from ._life import (
    RatingLife as RatingLife,
    damage as damage,
    largest_flank_load as largest_flank_load,
    modified_life as modified_life,
    rating_life as rating_life,
)
from ._load_spectrum import (
    LoadSpectrum as LoadSpectrum,
    constant_load as constant_load,
    equivalent_load as equivalent_load,
    largest_demand as largest_demand,
    load_spectrum as load_spectrum,
    spectrum_of as spectrum_of,
)
from ._play import (
    backlash as backlash,
    lost_motion as lost_motion,
    needs_meshing_for_backlash as needs_meshing_for_backlash,
    preload_force as preload_force,
    preloaded_load as preloaded_load,
    preloaded_stiffness as preloaded_stiffness,
    thins_teeth as thins_teeth,
)
from ._preload import (
    flank_loads as flank_loads,
    preload_opening_load as preload_opening_load,
    preload_torque as preload_torque,
    preloaded_pair_loads as preloaded_pair_loads,
    preloaded_pair_stiffness as preloaded_pair_stiffness,
    relative_displacement as relative_displacement,
)
from ._reliability import (
    life_factor as life_factor,
    minimum_oscillation_amplitude as minimum_oscillation_amplitude,
    oscillation_factor as oscillation_factor,
    reliability_factor as reliability_factor,
)
from ._shaft import (
    buckling_load as buckling_load,
    buckling_stress as buckling_stress,
    critical_speed as critical_speed,
    dn_value as dn_value,
    loaded_length as loaded_length,
    permissible_speed as permissible_speed,
    root_radius as root_radius,
    shaft_axial_stiffness as shaft_axial_stiffness,
    slenderness_ratio as slenderness_ratio,
    unsupported_length as unsupported_length,
)
from ._static import (
    permanent_deformation as permanent_deformation,
    static_capacity as static_capacity,
    static_safety as static_safety,
)
from ._truncation import (
    SideOnset as SideOnset,
    ThreadShares as ThreadShares,
    TruncatedFatigue as TruncatedFatigue,
    contact_truncation as contact_truncation,
    pressure_at as pressure_at,
    side_onsets as side_onsets,
    truncated_pressure as truncated_pressure,
    truncation_load as truncation_load,
)
