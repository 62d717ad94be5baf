"""Bending–torsional vibration of one stage."""

from ._assembly import (
    dense_matrices as dense_matrices,
    torsional_block as torsional_block,
    torsional_springs as torsional_springs,
    transverse_block as transverse_block,
    transverse_springs as transverse_springs,
)
from ._block import (
    SpringBlock as SpringBlock,
    block_modes as block_modes,
    mesh_energy_share as mesh_energy_share,
)
from ._eigen import generalised_eigen as generalised_eigen, symmetric_eigen as symmetric_eigen
from ._modal import modal as modal
from ._modes import (
    ModeGroup as ModeGroup,
    Modes as Modes,
    carrier_mode as carrier_mode,
    roller_modes as roller_modes,
    symmetric_modes as symmetric_modes,
    torsional_modes as torsional_modes,
    transverse_modes as transverse_modes,
)
from ._system import (
    CarrierBody as CarrierBody,
    CentralBody as CentralBody,
    VibrationSystem as VibrationSystem,
    vibration_system as vibration_system,
)
