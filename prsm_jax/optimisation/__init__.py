"""Gradient-based optimisation of a mechanism over named parameters."""

from ._optimality import Optimality as Optimality, optimality as optimality
from ._optimise import optimise as optimise
from ._optimum import (
    ConstraintReport as ConstraintReport,
    Design as Design,
    Optimum as Optimum,
    Run as Run,
)
from ._rounding import rounded_variables as rounded_variables
