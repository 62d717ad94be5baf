"""The torque-driven mechanism as a functional mock-up unit (FMI 3.0, co-simulation)."""

from ._motion import (
    DrivenState as DrivenState,
    advance as advance,
    check_exchangeable as check_exchangeable,
    values_at_start as values_at_start,
)
from ._variables import (
    OUTPUTS as OUTPUTS,
    UNITS as UNITS,
    Output as Output,
    described as described,
)
from ._write import write_fmu as write_fmu
