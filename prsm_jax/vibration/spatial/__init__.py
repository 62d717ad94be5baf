"""Vibration in space of one stage: every body moves along and around its axis, and sideways."""

from ._modes import SpatialModes as SpatialModes, spatial_modes as spatial_modes
from ._network import (
    spatial_harmonic_network as spatial_harmonic_network,
    spatial_network as spatial_network,
)
from ._spatial_modal import spatial_modal as spatial_modal
from ._springs import (
    RollerSpring as RollerSpring,
    contact_spring as contact_spring,
    tangential_ratio as tangential_ratio,
)
from ._system import (
    SpatialBody as SpatialBody,
    SpatialSystem as SpatialSystem,
    spatial_system as spatial_system,
)
