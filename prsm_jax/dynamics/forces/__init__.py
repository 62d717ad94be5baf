"""Forces of one stage and of the chain of stages at one instant."""

from ._chain import (
    ScrewForces as ScrewForces,
    StageState as StageState,
    all_push as all_push,
    carrier_drives as carrier_drives,
    chain_forces as chain_forces,
    screw_forces as screw_forces,
)
from ._loads import bound_scenario as bound_scenario
from ._power import losses as losses, stored_power as stored_power
from ._reduced_chain import (
    ReducedChain as ReducedChain,
    reduced_chain as reduced_chain,
    reduced_rates as reduced_rates,
    screw_of as screw_of,
)
from ._reduced_stage import (
    ReducedForces as ReducedForces,
    ReducedStage as ReducedStage,
    is_reducible as is_reducible,
    reduced_forces as reduced_forces,
    reduced_stage as reduced_stage,
)
from ._roller_balance import (
    forces_by_stage as forces_by_stage,
    roller_support_forces as roller_support_forces,
)
from ._scenario import (
    Drive as Drive,
    Scenario as Scenario,
    default_scenario as default_scenario,
    drive_at as drive_at,
    drive_once as drive_once,
)
from ._sliding_motion import sense_of as sense_of, sliding_motion as sliding_motion
from ._stage_forces import (
    Motion as Motion,
    axial_inertia as axial_inertia,
    carrier_inertia as carrier_inertia,
    held_mass as held_mass,
)
