"""Why the results of a design cannot be used, as a code inside a trace."""

import jax.numpy as jnp
from jaxtyping import Array, Int

from ..dynamics import STEADY_RESULTS
from ..geometry import axis_possible, dimensions_possible, rollers_fit
from ._analysis import Analysis

#: Reasons in the order of their codes; the last is for functions that check values.
REASONS = (
    "successful",
    "impossible_dimension",
    "overlapping_rollers",
    "no_meshing",
    "jammed",
    "no_balance",
    "not_computed",
    "not_finite",
)


def code_of(analysis: Analysis) -> Int[Array, ""]:
    """0 where an analysis is valid, else the index of the reason in `REASONS`.

    As `Analysis.valid`, it checks what has been evaluated so far, and whether the mechanism can
    be built. Of several reasons the most basic counts: dimensions, rollers that overlap, meshing,
    steady state.
    """
    stages = analysis.mechanism.stages
    code = jnp.where(analysis.computed, 0, REASONS.index("not_computed"))
    # `cached_property` stores what has been evaluated under its own name.
    evaluated = analysis.__dict__
    if "steady" in evaluated and analysis.steady.code is not None:
        for name in ("not_finite", "no_balance", "jammed"):
            at = analysis.steady.code == STEADY_RESULTS.index(name)
            code = jnp.where(at, REASONS.index(name), code)
    if "kinematics" in evaluated:
        meshed = jnp.stack([k.meshing.converged for k in analysis.kinematics]).all()
        code = jnp.where(meshed, code, REASONS.index("no_meshing"))
    fit = jnp.stack([rollers_fit(stage) for stage in stages]).all()
    code = jnp.where(fit, code, REASONS.index("overlapping_rollers"))
    possible = jnp.stack([dimensions_possible(stage) for stage in stages]).all()
    if analysis.mechanism.axis is not None:
        possible &= axis_possible(analysis.mechanism.axis, stages[0])
    return jnp.where(possible, code, REASONS.index("impossible_dimension"))
