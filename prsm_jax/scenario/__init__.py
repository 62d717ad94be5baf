"""How a mechanism is driven and loaded over time."""

from ._loads import (
    AerodynamicLoad as AerodynamicLoad,
    FrictionLoad as FrictionLoad,
    HingeLoad as HingeLoad,
    PositionTableLoad as PositionTableLoad,
    SumLoad as SumLoad,
    break_times_of as break_times_of,
    depends_on_motion as depends_on_motion,
)
from ._profiles import (
    ConstantProfile as ConstantProfile,
    SCurveMoveProfile as SCurveMoveProfile,
    SineProfile as SineProfile,
    TrapezoidalMoveProfile as TrapezoidalMoveProfile,
    TrapezoidalProfile as TrapezoidalProfile,
)
from ._scenario import (
    Scenario as Scenario,
    TorqueScenario as TorqueScenario,
    check_scenario as check_scenario,
)
from ._sequences import (
    Profile as Profile,
    SequenceProfile as SequenceProfile,
    TableProfile as TableProfile,
)
from ._tables import Curve as Curve
