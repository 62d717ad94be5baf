"""The force–deflection curve of a nut, with its backlash or preload."""

from collections.abc import Sequence
from typing import Annotated

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike
from jaxtyping import Array, Bool, Float

from ..fields import In
from ..mechanism import Mechanism, Stage, of_one_design, stage_at
from ..programs import one_program_where_possible
from ..results import DesignResult
from ._chains import Control
from ._distribution import balanced
from ._stage_chains import sharing_of, stage_chains


class ForceDeflection(DesignResult):
    """Axial load over deflection of one stage, point by point."""

    #: [N]
    load: Annotated[Float[Array, " points"], In("N")]
    #: Travel of screw towards nut from where nominal forward flanks touch, with play and the
    #: shift by the preload [m].
    deflection: Annotated[Float[Array, " points"], In("m")]
    #: dF/dx [N/m].
    tangent_stiffness: Annotated[Float[Array, " points"], In("N/m")]
    #: Elastic energy stored in contacts, teeth and shafts [J].
    stored_energy: Annotated[Float[Array, " points"], In("J")]
    converged: Annotated[Bool[Array, " points"], In("1")]

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch that this curve is of; empty for a single design."""
        return self.converged.shape[:-1]


@of_one_design
def force_deflection(
    mechanism: Mechanism,
    loads: ArrayLike | Sequence[float] | None = None,
    *,
    deflections: ArrayLike | Sequence[float] | None = None,
    stage: int = 1,
) -> ForceDeflection:
    """Force–deflection curve of the nut of one stage, at given loads or given deflections.

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs `load_sharing`, and for negative loads
      `backlash` or `split_nut`.
    - `loads`: axial loads [N].
    - `deflections`: travels of screw towards nut instead [m].
    - `stage`: which stage, counted from 1.

    **Raises:** `ValueError` unless exactly one of `loads` and `deflections` is given, or for a
    stage that is not there; `MissingDataError` if data are missing.
    """
    if (loads is None) == (deflections is None):
        raise ValueError("give either loads or deflections")
    chosen = stage_at(mechanism, stage)
    dtype = chosen.thread.lead.dtype
    if loads is not None:
        values = jnp.asarray(loads, dtype)
        if not sharing_of(chosen).has_reverse_flanks:
            values = jnp.abs(values)
        return _curve(chosen, values, "load")
    return _curve(chosen, jnp.asarray(deflections, dtype), "deflection")


@one_program_where_possible
def _curve(stage: Stage, values: Float[Array, " points"], control: Control) -> ForceDeflection:
    distribution = balanced(stage_chains(stage), stage, values, control)
    assert distribution.tangent_stiffness is not None
    energy = jax.vmap(lambda one: one.stored_energy)(distribution)
    return ForceDeflection(
        distribution.load,
        distribution.deflection,
        distribution.tangent_stiffness,
        energy,
        distribution.converged,
    )
