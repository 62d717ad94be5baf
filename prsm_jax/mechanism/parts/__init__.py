"""The parts of a stage, and the axis around it."""

from ._axis import (
    Axis as Axis,
    AxisLoad as AxisLoad,
    AxisShaft as AxisShaft,
    FarBearing as FarBearing,
    Motor as Motor,
    PositionController as PositionController,
)
from ._bodies import (
    Carrier as Carrier,
    Gear as Gear,
    GivenStiffness as GivenStiffness,
    Material as Material,
    Nut as Nut,
    RingGear as RingGear,
    Roller as Roller,
    Screw as Screw,
    Support as Support,
)
from ._damping import (
    Damping as Damping,
    DampingLaw as DampingLaw,
    MassAndStiffness as MassAndStiffness,
    ModalDamping as ModalDamping,
    RayleighDamping as RayleighDamping,
    StructuralDamping as StructuralDamping,
)
from ._design_problem import (
    DUTY_CYCLE as DUTY_CYCLE,
    Choice as Choice,
    Constraint as Constraint,
    DesignProblem as DesignProblem,
    Objective as Objective,
    OperatingCase as OperatingCase,
    Variable as Variable,
    operating_range as operating_range,
)
from ._family import (
    FAMILIES as FAMILIES,
    ROLLER_SCREW_TYPES as ROLLER_SCREW_TYPES,
    Family as Family,
    RollerScrewType as RollerScrewType,
    Side as Side,
)
from ._line_contact import LineContact as LineContact
from ._load_sharing import (
    LoadSharing as LoadSharing,
    RollerBending as RollerBending,
    SplitNut as SplitNut,
    ThreadTooth as ThreadTooth,
)
from ._part_errors import (
    FreeNut as FreeNut,
    PartErrors as PartErrors,
    check_part_errors as check_part_errors,
)
from ._strength import (
    END_CONDITIONS as END_CONDITIONS,
    AxialPlay as AxialPlay,
    EndConditions as EndConditions,
    FatigueRule as FatigueRule,
    ScrewShaft as ScrewShaft,
    Strength as Strength,
)
from ._thread import Thread as Thread
from ._tolerance import (
    DISTRIBUTIONS as DISTRIBUTIONS,
    Distribution as Distribution,
    Tolerance as Tolerance,
)
from ._unequal_roller import (
    UnequalRoller as UnequalRoller,
    check_unequal_rollers as check_unequal_rollers,
    total_factor as total_factor,
)
