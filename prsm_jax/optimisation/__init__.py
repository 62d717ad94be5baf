"""Gradient-based optimisation of a mechanism over named parameters."""

from ..mechanism import operating_range as operating_range
from ._limits import (
    LIMIT_ROOM as LIMIT_ROOM,
    LimitReading as LimitReading,
    limit_readings as limit_readings,
    limit_scale as limit_scale,
    with_limits as with_limits,
)
from ._optimise import optimise as optimise
from ._pareto import pareto as pareto
from ._problem import constraints_of as constraints_of
from .front import (
    FrontPoint as FrontPoint,
    ParetoFront as ParetoFront,
    hypervolume as hypervolume,
    non_dominated as non_dominated,
)
from .results import (
    ConstraintReport as ConstraintReport,
    Design as Design,
    Optimum as Optimum,
    Run as Run,
    Trial as Trial,
    optimality as optimality,
    rounded_variables as rounded_variables,
)
from .search import (
    Adam as Adam,
    Lbfgs as Lbfgs,
    MultiStart as MultiStart,
    Optax as Optax,
    Scipy as Scipy,
    SearchFunctions as SearchFunctions,
    SearchMethod as SearchMethod,
    SearchResult as SearchResult,
    Slsqp as Slsqp,
    TrustConstr as TrustConstr,
)
