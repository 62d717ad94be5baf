"""Rigid-body dynamics with friction: steady state and transients."""

from ..mechanism import (
    HingeLoad as HingeLoad,
    Scenario as Scenario,
    TorqueScenario as TorqueScenario,
)
from ._automatic import MethodChoice as MethodChoice, choose_method as choose_method
from ._body_forces import (
    BodyForces as BodyForces,
    Instant as Instant,
    body_forces as body_forces,
)
from ._carrier_motion import states_at as states_at
from ._contact_losses import has_contact_losses as has_contact_losses
from ._kinematics import (
    StageKinematics as StageKinematics,
    free_carrier_ratio as free_carrier_ratio,
    ideal_carrier_ratio as ideal_carrier_ratio,
    slip_velocity as slip_velocity,
    stage_kinematics as stage_kinematics,
    travel_per_turn as travel_per_turn,
)
from ._loads import bound_scenario as bound_scenario
from ._locking import (
    jamming_coefficient as jamming_coefficient,
    jamming_margin as jamming_margin,
    locking_coefficient as locking_coefficient,
    self_locking_margin as self_locking_margin,
)
from ._scenario import default_scenario as default_scenario
from ._stage_forces import axial_inertia as axial_inertia, carrier_inertia as carrier_inertia
from ._steady import (
    STEADY_RESULTS as STEADY_RESULTS,
    SteadyState as SteadyState,
    all_kinematics as all_kinematics,
    steady_meaning as steady_meaning,
    steady_state as steady_state,
)
from ._transient import simulate as simulate
from ._transient_quantities import (
    energy as energy,
    integral as integral,
    mean_efficiency as mean_efficiency,
    peak as peak,
    settling_time as settling_time,
)
from ._transient_result import Phase as Phase, SolverReport as SolverReport, Transient as Transient
from .solvers import Gradient as Gradient, Method as Method
