"""The result of an optimisation, and its optimality."""

from .._optimality import (
    Optimality as Optimality,
    optimality as optimality,
    worst_case_optimality as worst_case_optimality,
)
from ._optimum import (
    ConstraintReport as ConstraintReport,
    Design as Design,
    Optimum as Optimum,
    Run as Run,
    Trial as Trial,
)
from ._reporting import (
    Reporter as Reporter,
    optimum_of as optimum_of,
    run_report as run_report,
)
from ._rounding import rounded_variables as rounded_variables
