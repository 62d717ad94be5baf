"""Thread contact stiffness of one roller: given, or from contacts that share the load."""

from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp

from .._errors import MissingDataError
from ..contact import StageContact, stage_contact
from ..geometry import Meshing
from ..load_sharing import LoadDistribution, stage_load_distribution
from ..mechanism import Scalar, Stage, total_factor


class ThreadStiffness(eqx.Module):
    """Thread contact stiffness of one roller, all its engaged threads in parallel [N/m]."""

    screw_roller: Scalar
    nut_roller: Scalar


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
    stage: Stage, contact: Callable[[], StageContact | LoadDistribution]
) -> ThreadStiffness:
    """Thread contact stiffness of one roller with screw and nut [N/m].

    Given numbers are taken as they are; what is not given is the axial secant stiffness of a
    Hertz contact times the number of engaged threads (Wu et al. 2022, equations 36 to 47), or the
    sum over the threads of a load distribution, their teeth included.

    **Arguments:**

    - `stage`: the stage.
    - `contact`: gives the threads under load (see `loaded_threads`); called only if a stiffness
      has to be derived.
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
    return ThreadStiffness(
        derived.screw.roller_stiffness if screw is None else screw,
        derived.nut.roller_stiffness if nut is None else nut,
    )


def in_series(first: Scalar, second: Scalar) -> Scalar:
    """Stiffness of two springs in series; without load both are 0, and so is the result [N/m]."""
    total = first + second
    stiff = total > 0
    return first * jnp.where(stiff, second / jnp.where(stiff, total, 1.0), 0.0)


def axial_stiffness(stage: Stage, threads: ThreadStiffness) -> Scalar:
    """Axial contact stiffness between screw and nut: both contacts in series, rollers in parallel.

    Shafts and teeth are taken as rigid [N/m].
    """
    count = total_factor(stage.unequal_roller, stage.roller_count, "stiffness_factor")
    return count * in_series(threads.screw_roller, threads.nut_roller)
