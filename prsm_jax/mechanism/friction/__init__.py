"""The numbers of friction laws."""

from ._friction import (
    CoulombFriction as CoulombFriction,
    Friction as Friction,
    LuGreFriction as LuGreFriction,
    RegularisedCoulombFriction as RegularisedCoulombFriction,
    RollingHysteresis as RollingHysteresis,
    SpinFriction as SpinFriction,
    StribeckFriction as StribeckFriction,
    ThreadFriction as ThreadFriction,
    ViscousFriction as ViscousFriction,
)
from ._screw_friction import (
    Drag as Drag,
    RegularisedSplineFriction as RegularisedSplineFriction,
    RegularisedThrustBearingFriction as RegularisedThrustBearingFriction,
    SplineFriction as SplineFriction,
    SplineLaw as SplineLaw,
    StribeckSplineFriction as StribeckSplineFriction,
    StribeckThrustBearingFriction as StribeckThrustBearingFriction,
    ThrustBearingFriction as ThrustBearingFriction,
    ThrustBearingLaw as ThrustBearingLaw,
    ViscousSplineFriction as ViscousSplineFriction,
    ViscousThrustBearingFriction as ViscousThrustBearingFriction,
)
