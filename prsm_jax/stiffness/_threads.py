"""Thread contact stiffness of one roller: given, or from contacts that share the load."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._errors import MissingDataError
from ..contact import StageContact, ThreadContactSide, stage_contact
from ..geometry import Meshing
from ..load_sharing import LoadDistribution, SideLoads, stage_load_distribution
from ..mechanism import Scalar, Stage, total_factor
from ..numerics import above_or_nan


class ThreadStiffness(eqx.Module):
    """Thread contact stiffness of one roller, all its engaged threads in parallel [N/m]."""

    screw_roller: Scalar
    nut_roller: Scalar
    #: Of each roller that is there, where a load distribution has unlike rollers; then without
    #: any further factor, and `screw_roller` and `nut_roller` are those of its first class.
    screw_each: Float[Array, " rollers"] | None = None
    nut_each: Float[Array, " rollers"] | None = None


def loaded_threads(
    stage: Stage, load: Scalar, meshing: Meshing | None = None
) -> StageContact | LoadDistribution:
    """The threads of a stage under an axial load [N], as the stage says that they share it.

    In equal parts, or as a load distribution where the stage has `load_sharing`; both know the
    stiffness of one roller on either side (`.screw.roller_stiffness`, `.nut.roller_stiffness`).

    **Arguments:**

    - `stage`: the stage.
    - `load`: axial load [N].
    - `meshing`: its meshing, if known already.

    **Raises:** `MissingDataError` if data are missing.
    """
    if stage.load_sharing is not None:
        return stage_load_distribution(stage, load, meshing)
    return stage_contact(stage, load, meshing)


def thread_stiffness(
    stage: Stage,
    contact: Callable[[], StageContact | LoadDistribution],
    *,
    tangent: bool = False,
) -> ThreadStiffness:
    """Thread contact stiffness of one roller with screw and nut [N/m].

    Given numbers are taken as they are; what is not given is the axial secant stiffness of a
    Hertz contact times the number of engaged threads (Wu et al. 2022, equations 36 to 47), or the
    sum over the threads of a load distribution, their teeth included. Where that tells rollers
    apart (`stiffness_factor`, `tooth_thinning`) each has the stiffness at the load that it carries.

    **Arguments:**

    - `stage`: the stage.
    - `contact`: gives the threads under load (see `loaded_threads`); called only if a stiffness
      has to be derived.
    - `tangent`: that of a small further load instead, df/dδ; given numbers are both.
    """
    given = stage.stiffness
    screw = None if given is None else given.screw_roller
    nut = None if given is None else given.nut_roller
    if screw is not None and nut is not None:
        return ThreadStiffness(screw, nut)
    try:
        derived = contact()
    except MissingDataError as error:
        raise MissingDataError(
            f"thread contact stiffness: {error} — or give stage.stiffness.screw_roller and "
            "stage.stiffness.nut_roller"
        ) from error
    unlike = any(roller.carries_otherwise for roller in stage.unequal_roller)
    each: list[Array | None] = [None, None]
    if unlike and isinstance(derived, LoadDistribution):
        each = [
            _by_roller(derived, side, tangent) if number is None else _each(stage, number)
            for side, number in ((derived.screw, screw), (derived.nut, nut))
        ]
    return ThreadStiffness(
        _of_roller(derived.screw, tangent) if screw is None else screw,
        _of_roller(derived.nut, tangent) if nut is None else nut,
        *each,
    )


def _by_roller(derived: LoadDistribution, side: SideLoads, tangent: bool) -> Array:
    found = side.tangent if tangent else side.stiffness
    assert found is not None
    return derived.by_roller(found)[1]


def _of_roller(side: ThreadContactSide | SideLoads, tangent: bool) -> Scalar:
    return side.roller_tangent_stiffness if tangent else side.roller_stiffness


def _each(stage: Stage, given: Scalar) -> Float[Array, " rollers"]:
    """A given stiffness of one roller, times the factor of each that is there [N/m]."""
    unequal = {roller.number: roller for roller in stage.unequal_roller}
    found = []
    for number in range(1, stage.roller_count + 1):
        roller = unequal.get(number)
        if roller is None or not roller.missing:
            factor = None if roller is None else roller.stiffness_factor
            found.append(given if factor is None else given * factor)
    return jnp.stack(found)


def in_series(first: Scalar, second: Scalar) -> Scalar:
    """Stiffness of two springs in series; without load both are 0, and so is the result [N/m]."""
    total = first + second
    stiff = above_or_nan(total)
    return first * jnp.where(stiff, second / jnp.where(stiff, total, 1.0), 0.0)


def axial_stiffness(stage: Stage, threads: ThreadStiffness) -> Scalar:
    """Axial contact stiffness between screw and nut: both contacts in series, rollers in parallel.

    Shafts and teeth are taken as rigid [N/m].
    """
    if threads.screw_each is not None and threads.nut_each is not None:
        return jnp.sum(jax.vmap(in_series)(threads.screw_each, threads.nut_each))
    count = total_factor(stage.unequal_roller, stage.roller_count, "stiffness_factor")
    return count * in_series(threads.screw_roller, threads.nut_roller)
