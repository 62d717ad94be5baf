"""Forced vibration of one stage: frequency responses, excitation by the contacts, Campbell."""

from ._axis_compliance import (
    AxisCompliance as AxisCompliance,
    axis_compliance as axis_compliance,
)
from ._campbell import Campbell as Campbell, Crossing as Crossing, campbell as campbell
from ._creep_friction import CreepFriction as CreepFriction, creep_friction as creep_friction
from ._dissipation import (
    Dissipation as Dissipation,
    dissipation as dissipation,
    spring_damping as spring_damping,
)
from ._frequency_response import (
    FrequencyResponse as FrequencyResponse,
    Kind as Kind,
    frequency_response as frequency_response,
)
from ._mesh_response import (
    MeshResponse as MeshResponse,
    excited_response as excited_response,
    mesh_response as mesh_response,
)
from ._orders import (
    ExcitationOrder as ExcitationOrder,
    excitation_orders as excitation_orders,
    find_order as find_order,
    gear_mesh_order as gear_mesh_order,
    has_gear_teeth as has_gear_teeth,
    phasing as phasing,
    working_carrier_ratio as working_carrier_ratio,
)
from ._receptance import (
    Harmonic as Harmonic,
    Solver as Solver,
    direct_response as direct_response,
    harmonic_response as harmonic_response,
    receptance_matrix as receptance_matrix,
)
from ._spatial_damping import SpatialDamping as SpatialDamping, spatial_damping as spatial_damping
