"""Solvers and step-size control that diffrax does not have; independent of any mechanism.

Modules that import diffrax are imported only where something is integrated, so not here.
"""

from ._driven_rate import (
    DrivenRate as DrivenRate,
    converted as converted,
)
from ._method_objects import (
    ATOL as ATOL,
    MAX_STEPS as MAX_STEPS,
    RTOL as RTOL,
    Auto as Auto,
    ClosedForm as ClosedForm,
    Diffrax as Diffrax,
    Explicit as Explicit,
    Implicit as Implicit,
    Method as Method,
    OwnSolver as OwnSolver,
    QuasiSteady as QuasiSteady,
    Rodasp as Rodasp,
    method_of as method_of,
    options_of as options_of,
)
from ._methods import (
    NAMES as NAMES,
    Gradient as Gradient,
    MethodName as MethodName,
    adjoint_of as adjoint_of,
    breaks_inside as breaks_inside,
    code_of as code_of,
    controller_of as controller_of,
    is_concrete as is_concrete,
    is_short as is_short,
    solver_of as solver_of,
    still as still,
    with_tolerances as with_tolerances,
)
