"""What a stage would carry without its errors of parts, and without each of them."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from ..fields import Scalar
from ..geometry import Meshing
from ..mechanism import Stage
from ..programs import physics
from ._distribution import balanced
from ._stage_chains import sharing_of, stage_chains
from .part_errors import error_names


class LargestLoads(NamedTuple):
    """The most loaded roller and the most loaded thread of a stage."""

    #: Largest load of a roller over the mean of all.
    roller_sharing_factor: Scalar
    #: Largest axial load of a thread, either side [N].
    thread_load: Scalar


@physics("left_out")
def without_each_error(
    stage: Stage, load: Scalar, meshing: Meshing | None = None
) -> tuple[LargestLoads, dict[str, LargestLoads]]:
    """Largest loads without any error of parts, and without each one, the others present.

    Each is a balance of its own, so this is exact for errors of any size, also where threads lose
    contact; a gradient would hold for small changes only. Loads across the axis of a free nut count
    as errors. Errors act together, so what each one causes does not add up to the whole.

    **Arguments:**

    - `stage`: the stage; needs `load_sharing` with errors of parts or loads on a free nut.
    - `load`: axial load [N].
    - `meshing`: its meshing, if known already.

    **Returns:** the largest loads without any, and without each by its name in `load_sharing`
    (`part_errors.nut_tilt`); NaN where there is no balance.

    **Raises:** `MissingDataError` if data are missing.
    """
    if not sharing_of(stage).has_reverse_flanks:
        load = jnp.abs(load)
    names = error_names(sharing_of(stage))

    def amounts(stage: Stage):
        sharing = sharing_of(stage)
        return [getattr(getattr(sharing, part), field) for part, field in map(_split, names)]

    def balance(kept) -> LargestLoads:
        left = [kept[i] * amount for i, amount in enumerate(amounts(stage))]
        changed = eqx.tree_at(amounts, stage, left)
        found = balanced(stage_chains(changed, meshing), changed, load, tangent=False)
        loads = jnp.stack([jnp.max(side.thread_load) for side in (found.screw, found.nut)])
        return LargestLoads(found.nut.roller_sharing_factor, jnp.max(loads))

    # The first row keeps none; each further one leaves one out.
    kept = jnp.concatenate([jnp.zeros((1, len(names))), 1 - jnp.eye(len(names))])
    rows = jax.vmap(balance)(kept.astype(load.dtype))
    one = [jax.tree.map(lambda x, k=k: x[k], rows) for k in range(len(names) + 1)]
    return one[0], dict(zip(names, one[1:], strict=True))


def _split(name: str) -> tuple[str, str]:
    part, field = name.split(".")
    return part, field
