"""Friction laws: classes with one method, of this package or of a user's own file."""

from ._coulomb import (
    CoulombFriction as CoulombFriction,
    RegularisedCoulombFriction as RegularisedCoulombFriction,
)
from ._law import (
    Deflected as Deflected,
    FrictionLaw as FrictionLaw,
    Sliding as Sliding,
    StatefulFrictionLaw as StatefulFrictionLaw,
)
from ._losses import (
    Friction as Friction,
    RollingHysteresis as RollingHysteresis,
    SpinFriction as SpinFriction,
)
from ._lugre import LuGreFriction as LuGreFriction
from ._register import friction_law as friction_law, friction_laws as friction_laws
from ._scaled import scaled_friction as scaled_friction
from ._screw_friction import (
    Drag as Drag,
    FrictionAtRadius as FrictionAtRadius,
    SplineFriction as SplineFriction,
    ThrustBearingFriction as ThrustBearingFriction,
)
from ._stribeck import StribeckFriction as StribeckFriction
from ._viscous import ViscousFriction as ViscousFriction
