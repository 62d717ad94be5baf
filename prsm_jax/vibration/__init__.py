"""Vibration of one stage: bending–torsional, and in space."""

from ._dense import (
    dense_modes as dense_modes,
    directional_derivatives as directional_derivatives,
    family_modes as family_modes,
    stage_modes as stage_modes,
)
from ._distinct import (
    DistinctFrequencies as DistinctFrequencies,
    distinct_frequencies as distinct_frequencies,
)
from ._families import FAMILIES as FAMILIES, family_shares as family_shares
from ._frequency_loci import (
    FrequencyLoci as FrequencyLoci,
    Veering as Veering,
    frequency_loci as frequency_loci,
)
from ._grouped_modes import GroupedModes as GroupedModes, ModeGroup as ModeGroup
from ._modal import modal as modal, stage_system as stage_system
from ._modes import Modes as Modes
from ._spring_modes import (
    RIGID_SHARE as RIGID_SHARE,
    SpringModes as SpringModes,
    clusters as clusters,
    spring_modes as spring_modes,
)
from ._symmetric import (
    carrier_mode as carrier_mode,
    roller_modes as roller_modes,
    symmetric_modes as symmetric_modes,
    torsional_modes as torsional_modes,
    transverse_modes as transverse_modes,
)
from .arrowhead import (
    SpringBlock as SpringBlock,
    block_modes as block_modes,
    mesh_energy_share as mesh_energy_share,
)
from .model import (
    CarrierBody as CarrierBody,
    CentralBody as CentralBody,
    Coordinate as Coordinate,
    RollerScatter as RollerScatter,
    RollerTranslation as RollerTranslation,
    Spring as Spring,
    SpringNetwork as SpringNetwork,
    VibrationSystem as VibrationSystem,
    coordinates as coordinates,
    dense_matrices as dense_matrices,
    harmonic_network as harmonic_network,
    kinetic_energies as kinetic_energies,
    spring_network as spring_network,
    strain_energies as strain_energies,
    torsional_block as torsional_block,
    torsional_springs as torsional_springs,
    transverse_block as transverse_block,
    transverse_springs as transverse_springs,
    vibration_system as vibration_system,
)
from .spatial import (
    AxisBody as AxisBody,
    AxisSpring as AxisSpring,
    AxisSystem as AxisSystem,
    RollerSpring as RollerSpring,
    SpatialBody as SpatialBody,
    SpatialMode as SpatialMode,
    SpatialModes as SpatialModes,
    SpatialSystem as SpatialSystem,
    axial_torsional_modes as axial_torsional_modes,
    axis_system as axis_system,
    contact_places as contact_places,
    contact_spring as contact_spring,
    contact_springs as contact_springs,
    nominal_radius as nominal_radius,
    spatial_harmonic_network as spatial_harmonic_network,
    spatial_modal as spatial_modal,
    spatial_modes as spatial_modes,
    spatial_network as spatial_network,
    spatial_spring_modes as spatial_spring_modes,
    spatial_system as spatial_system,
    spatial_transverse_modes as spatial_transverse_modes,
    stage_spatial_system as stage_spatial_system,
    static_compliance as static_compliance,
    strain_in_words as strain_in_words,
    thread_spread as thread_spread,
    tilts as tilts,
)
