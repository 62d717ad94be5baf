"""Scatter of quantities due to tolerances, and the contribution of each tolerance."""

from ._allocation import (
    Allocation as Allocation,
    CostCurve as CostCurve,
    allocate_tolerances as allocate_tolerances,
    cost_curve as cost_curve,
)
from ._estimates import PROBABILITIES as PROBABILITIES, Estimate as Estimate
from ._global import (
    GlobalSensitivity as GlobalSensitivity,
    active_subspace as active_subspace,
    morris as morris,
    sobol_indices as sobol_indices,
)
from ._result import (
    METHOD_WORDS as METHOD_WORDS,
    MethodResult as MethodResult,
    ToleranceAnalysis as ToleranceAnalysis,
)
from ._tolerance import DEFAULT_QUANTITIES as DEFAULT_QUANTITIES, tolerance as tolerance
from ._yield_curve import YieldCurve as YieldCurve, yield_curve as yield_curve
from ._zone_ends import ZoneEnds as ZoneEnds
