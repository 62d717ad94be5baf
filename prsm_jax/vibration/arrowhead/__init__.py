"""Eigenvalues of one family of modes: arrowhead matrices."""

from ._arrowhead import arrowhead_modes as arrowhead_modes
from ._block import (
    SpringBlock as SpringBlock,
    block_modes as block_modes,
    mesh_energy_share as mesh_energy_share,
)
