"""Thread contact stiffness of one roller: given, or from contacts that share the load."""

import contextlib
from collections.abc import Callable, Generator
from typing import Annotated

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._errors import MissingDataError
from ..contact import StageContact, ThreadContactSide, stage_contact
from ..fields import In, Scalar
from ..geometry import Meshing
from ..load_sharing import LoadDistribution, SideLoads, stage_load_distribution
from ..mechanism import Stage, total_factor
from ..numerics import above_or_nan, apart
from ..results import Result


class ThreadStiffness(Result):
    """Thread contact stiffness of one roller, all its engaged threads in parallel [N/m]."""

    screw_roller: Annotated[Scalar, In("N/m")]
    nut_roller: Annotated[Scalar, In("N/m")]
    #: Of each roller present, if a load distribution has unlike rollers; no further factor then
    #: applies, and `screw_roller` and `nut_roller` are those of its first class.
    screw_each: Annotated[Float[Array, " rollers"] | None, In("N/m")] = None
    nut_each: Annotated[Float[Array, " rollers"] | None, In("N/m")] = None


def loaded_threads(
    stage: Stage, load: Scalar, meshing: Meshing | None = None
) -> StageContact | LoadDistribution:
    """The threads of a stage under an axial load [N], with the load sharing of the stage.

    In equal parts, or as a load distribution if the stage has `load_sharing`; both give the
    stiffness of one roller on each side (`.screw.roller_stiffness`, `.nut.roller_stiffness`).

    **Arguments:**

    - `stage`: the stage.
    - `load`: axial load [N].
    - `meshing`: its meshing, if already known.

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

    Given numbers are used unchanged. Missing ones are the axial secant stiffness of a Hertz contact
    times the number of engaged threads (Wu et al. 2022, equations 36 to 47), or the sum over the
    threads of a load distribution, including their teeth. If that has unlike rollers
    (`stiffness_factor`, `tooth_thinning`, errors of parts), each has the stiffness at the load that
    it carries.

    **Arguments:**

    - `stage`: the stage.
    - `contact`: gives the threads under load (see `loaded_threads`); called only if a stiffness
      has to be derived.
    - `tangent`: tangent stiffness df/dδ instead of the secant; given numbers are used for both.
    """
    given, specified = _given(stage), stage.stiffness
    if given is not None:
        return given
    screw = None if specified is None else specified.screw_roller
    nut = None if specified is None else specified.nut_roller
    with _also_by_stiffness():
        derived = contact()
    unlike = stage.rollers_carry_otherwise
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


def stiffness_under_load(
    stage: Stage,
    load: Callable[[], Scalar],
    meshing: Meshing | None = None,
    *,
    tangent: bool = False,
) -> ThreadStiffness:
    """`thread_stiffness` under an axial load, compiled as a separate part of larger programs.

    The Hessian of a frequency compiles in less than half the time.

    **Arguments:**

    - `stage`: the stage.
    - `load`: gives the axial load [N], of either sign; called only if a stiffness has to be
      derived.
    - `meshing`: its meshing, if already known.
    - `tangent`: as in `thread_stiffness`.

    **Raises:** `MissingDataError` if data are missing.
    """
    given = _given(stage)
    if given is not None:
        return given
    with _also_by_stiffness():
        value = load()
    # The flanks of both directions differ in load sharing alone.
    signed = value if stage.load_sharing is not None else jnp.abs(value)
    return apart(_under_load, whole=True)(stage, signed, meshing, tangent)


def _under_load(
    stage: Stage, load: Scalar, meshing: Meshing | None, tangent: bool
) -> ThreadStiffness:
    return thread_stiffness(stage, lambda: loaded_threads(stage, load, meshing), tangent=tangent)


def _given(stage: Stage) -> ThreadStiffness | None:
    """Stiffnesses that are given; `None` if one has to be derived."""
    specified = stage.stiffness
    if specified is None or specified.screw_roller is None or specified.nut_roller is None:
        return None
    return ThreadStiffness(specified.screw_roller, specified.nut_roller)


@contextlib.contextmanager
def _also_by_stiffness() -> Generator[None, None, None]:
    """Add to a message on missing data that stiffnesses may be given."""
    try:
        yield
    except MissingDataError as error:
        raise MissingDataError(
            f"thread contact stiffness: {error} — or give stage.stiffness.screw_roller and "
            "stage.stiffness.nut_roller"
        ) from error


def _by_roller(derived: LoadDistribution, side: SideLoads, tangent: bool) -> Array:
    stiffness = side.tangent if tangent else side.stiffness
    assert stiffness is not None
    return derived.by_roller(stiffness)[1]


def _of_roller(side: ThreadContactSide | SideLoads, tangent: bool) -> Scalar:
    return side.roller_tangent_stiffness if tangent else side.roller_stiffness


def _each(stage: Stage, stiffness: Scalar) -> Float[Array, " rollers"]:
    """A given stiffness of one roller, times the factor of each roller present [N/m]."""
    unequal = {roller.number: roller for roller in stage.unequal_roller}
    stiffnesses = []
    for number in range(1, stage.roller_count + 1):
        roller = unequal.get(number)
        if roller is None or not roller.missing:
            factor = None if roller is None else roller.stiffness_factor
            stiffnesses.append(stiffness if factor is None else stiffness * factor)
    return jnp.stack(stiffnesses)


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
