"""Rigid-body dynamics with friction: steady state and transients."""

from ._kinematics import (
    StageKinematics as StageKinematics,
    free_carrier_ratio as free_carrier_ratio,
    ideal_carrier_ratio as ideal_carrier_ratio,
    roller_migration as roller_migration,
    slip_velocity as slip_velocity,
    stage_kinematics as stage_kinematics,
    travel_per_radian as travel_per_radian,
    travel_per_turn as travel_per_turn,
    travel_share as travel_share,
    turned_contact as turned_contact,
)
from ._transient import simulate as simulate
from .forces import (
    axial_inertia as axial_inertia,
    bound_scenario as bound_scenario,
    carrier_inertia as carrier_inertia,
    default_scenario as default_scenario,
)
from .friction import has_contact_losses as has_contact_losses
from .histories import (
    Phase as Phase,
    SolverReport as SolverReport,
    Transient as Transient,
    coarse_samples as coarse_samples,
    energy as energy,
    error_in_words as error_in_words,
    integral as integral,
    known_efficiency as known_efficiency,
    mean_efficiency as mean_efficiency,
    neglected_inertia as neglected_inertia,
    peak as peak,
    settling_time as settling_time,
)
from .newton_euler import (
    BodyForces as BodyForces,
    Instant as Instant,
    body_forces as body_forces,
)
from .solvers import (
    Auto as Auto,
    BothModes as BothModes,
    ClosedForm as ClosedForm,
    Diffrax as Diffrax,
    Explicit as Explicit,
    ForwardMode as ForwardMode,
    Gradient as Gradient,
    GradientMode as GradientMode,
    Implicit as Implicit,
    Integrating as Integrating,
    Method as Method,
    MethodName as MethodName,
    QuasiSteady as QuasiSteady,
    ReverseMode as ReverseMode,
    Rodasp as Rodasp,
)
from .speed_drive import (
    MethodChoice as MethodChoice,
    choose_method as choose_method,
    states_at as states_at,
)
from .steady import (
    STEADY_RESULTS as STEADY_RESULTS,
    SlidingContact as SlidingContact,
    SteadyState as SteadyState,
    all_kinematics as all_kinematics,
    friction_needs_load as friction_needs_load,
    friction_sets_motion as friction_sets_motion,
    jamming_coefficient as jamming_coefficient,
    jamming_margin as jamming_margin,
    locking_coefficient as locking_coefficient,
    self_locking_margin as self_locking_margin,
    sliding_contact as sliding_contact,
    steady_meaning as steady_meaning,
    steady_state as steady_state,
)
from .torque_drive import has_smooth_threads as has_smooth_threads
