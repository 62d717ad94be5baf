"""The mechanism: a frozen pytree in SI units. This room imports no other."""

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
    ModalDamping as ModalDamping,
    RayleighDamping as RayleighDamping,
    StructuralDamping as StructuralDamping,
)
from ._design_problem import (
    Constraint as Constraint,
    DesignProblem as DesignProblem,
    Objective as Objective,
    Variable as Variable,
)
from ._fields import Scalar as Scalar, as_scalar as as_scalar
from ._follows import (
    dependents_in_words as dependents_in_words,
    follows_in_words as follows_in_words,
    what_follows as what_follows,
)
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
from ._limits import (
    ANY as ANY,
    NOT_NEGATIVE as NOT_NEGATIVE,
    POSITIVE as POSITIVE,
    Limit as Limit,
    limit_of as limit_of,
)
from ._line_contact import LineContact as LineContact
from ._load_sharing import (
    GAP_LISTS as GAP_LISTS,
    MOUNTINGS as MOUNTINGS,
    LoadSharing as LoadSharing,
    Mounting as Mounting,
    SplitNut as SplitNut,
    ThreadTooth as ThreadTooth,
)
from ._loads import (
    LOADS_OF_MOTION as LOADS_OF_MOTION,
    AerodynamicLoad as AerodynamicLoad,
    FrictionLoad as FrictionLoad,
    HingeLoad as HingeLoad,
    PositionTableLoad as PositionTableLoad,
    SumLoad as SumLoad,
    break_times_of as break_times_of,
    depends_on_motion as depends_on_motion,
)
from ._masses import (
    body_inertia as body_inertia,
    body_mass as body_mass,
    material_of as material_of,
    mean_roller_inertia as mean_roller_inertia,
    mean_roller_mass as mean_roller_mass,
    nut_outer_radius as nut_outer_radius,
    stage_mass as stage_mass,
)
from ._mechanism import (
    CURVATURE_CONVENTIONS as CURVATURE_CONVENTIONS,
    CurvatureConvention as CurvatureConvention,
    DutyCycle as DutyCycle,
    Mechanism as Mechanism,
    OperatingPoint as OperatingPoint,
    Stage as Stage,
)
from ._one_design import (
    check_one_design as check_one_design,
    of_one_design as of_one_design,
    of_one_known_design as of_one_known_design,
)
from ._parameters import (
    DESIGN_VARIABLES as DESIGN_VARIABLES,
    DesignVariable as DesignVariable,
    Parameter as Parameter,
    all_parameters as all_parameters,
    find_parameters as find_parameters,
    get_parameter as get_parameter,
    set_parameter as set_parameter,
)
from ._possible import numbers_possible as numbers_possible
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
from ._sequences import (
    PROFILES as PROFILES,
    Profile as Profile,
    SequenceProfile as SequenceProfile,
    TableProfile as TableProfile,
)
from ._strength import (
    END_CONDITIONS as END_CONDITIONS,
    AxialPlay as AxialPlay,
    EndConditions as EndConditions,
    ScrewShaft as ScrewShaft,
    Strength as Strength,
)
from ._tables import Curve as Curve
from ._thread import Thread as Thread
from ._together import (
    check_independent as check_independent,
    set_parameters as set_parameters,
)
from ._unequal_roller import UnequalRoller as UnequalRoller, total_factor as total_factor
from ._within import Contradiction as Contradiction, check_stage as check_stage
