"""Vibration in space: every body moves along and around its axis, and sideways; the axis too."""

from ._axis import (
    AxisBody as AxisBody,
    AxisSpring as AxisSpring,
    AxisSystem as AxisSystem,
    axis_system as axis_system,
)
from ._bodies import SpatialBody as SpatialBody, nominal_radius as nominal_radius
from ._modes import (
    SpatialMode as SpatialMode,
    SpatialModes as SpatialModes,
    axial_torsional_modes as axial_torsional_modes,
    is_torsional as is_torsional,
    spatial_modes as spatial_modes,
    spatial_spring_modes as spatial_spring_modes,
    spatial_transverse_modes as spatial_transverse_modes,
)
from ._network import (
    spatial_harmonic_network as spatial_harmonic_network,
    spatial_network as spatial_network,
)
from ._spatial_modal import (
    spatial_modal as spatial_modal,
    stage_spatial_system as stage_spatial_system,
    tilts as tilts,
)
from ._spring_words import strain_in_words as strain_in_words
from ._springs import (
    RollerSpring as RollerSpring,
    contact_places as contact_places,
    contact_spring as contact_spring,
    contact_springs as contact_springs,
    tangential_ratio as tangential_ratio,
)
from ._statics import static_compliance as static_compliance
from ._system import (
    SpatialSystem as SpatialSystem,
    spatial_system as spatial_system,
)
from ._tilt import thread_spread as thread_spread
