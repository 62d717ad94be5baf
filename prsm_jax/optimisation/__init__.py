"""Gradient-based optimisation of a mechanism over named parameters."""

from ._optimise import optimise as optimise
from .results import (
    ConstraintReport as ConstraintReport,
    Design as Design,
    Optimality as Optimality,
    Optimum as Optimum,
    Run as Run,
    optimality as optimality,
    rounded_variables as rounded_variables,
)
from .search import (
    Adam as Adam,
    Lbfgs as Lbfgs,
    Optax as Optax,
    Scipy as Scipy,
    SearchFunctions as SearchFunctions,
    SearchMethod as SearchMethod,
    SearchResult as SearchResult,
    Slsqp as Slsqp,
    TrustConstr as TrustConstr,
)
