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
from ._printing import against_limit as against_limit
from ._reporting import (
    Reporter as Reporter,
    constraint_reports as constraint_reports,
    optimum_of as optimum_of,
    run_report as run_report,
)
from ._rounding import rounded_variables as rounded_variables
