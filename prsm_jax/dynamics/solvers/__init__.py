"""Solvers and step-size control that diffrax does not have; independent of any mechanism.

Modules that import diffrax are imported only where something is integrated, so not here.
"""

from ._driven_rate import (
    DrivenRate as DrivenRate,
    converted as converted,
)
from ._gradient_modes import (
    BothModes as BothModes,
    ForwardMode as ForwardMode,
    Gradient as Gradient,
    GradientMode as GradientMode,
    ReverseMode as ReverseMode,
    gradient_of as gradient_of,
)
from ._method_objects import (
    ATOL as ATOL,
    MAX_STEPS as MAX_STEPS,
    METHOD_WORDS as METHOD_WORDS,
    RTOL as RTOL,
    Auto as Auto,
    ClosedForm as ClosedForm,
    Diffrax as Diffrax,
    Explicit as Explicit,
    Implicit as Implicit,
    Integrating as Integrating,
    Method as Method,
    QuasiSteady as QuasiSteady,
    Rodasp as Rodasp,
    method_of as method_of,
    options_of as options_of,
)
from ._methods import (
    MethodName as MethodName,
    breaks_inside as breaks_inside,
    code_of as code_of,
    controller_of as controller_of,
    is_concrete as is_concrete,
    is_short as is_short,
    still as still,
    with_tolerances as with_tolerances,
)
