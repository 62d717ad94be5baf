"""Masses and springs of a stage, and its mode shapes and energies."""

from ._assembly import (
    coordinates as coordinates,
    dense_matrices as dense_matrices,
    harmonic_network as harmonic_network,
    is_mesh as is_mesh,
    roller_corner as roller_corner,
    spring_network as spring_network,
    torsional_block as torsional_block,
    torsional_springs as torsional_springs,
    transverse_block as transverse_block,
    transverse_springs as transverse_springs,
)
from ._energy import (
    kinetic_energies as kinetic_energies,
    shares as shares,
    strain_energies as strain_energies,
)
from ._shapes import (
    carrier_shape as carrier_shape,
    expanded_shapes as expanded_shapes,
    harmonic_shapes as harmonic_shapes,
)
from ._spring_network import (
    Coordinate as Coordinate,
    NetworkBuilder as NetworkBuilder,
    Spring as Spring,
    SpringNetwork as SpringNetwork,
)
from ._system import (
    CarrierBody as CarrierBody,
    CentralBody as CentralBody,
    RollerScatter as RollerScatter,
    RollerTranslation as RollerTranslation,
    VibrationSystem as VibrationSystem,
    vibration_system as vibration_system,
)
