"""Axial play of a stage: backlash, lost motion, and the effect of a preload."""

import jax.numpy as jnp

from .._errors import MissingDataError
from ..contact import StageContact
from ..fields import Scalar
from ..geometry import Meshing, mesh
from ..mechanism import AxialPlay, Stage
from ..programs import physics
from ._contacts import axial_approach, is_preloaded, preload_of, strength_of, thread_share
from ._preload import flank_loads, preloaded_pair_stiffness, relative_displacement


def play_of(stage: Stage) -> AxialPlay:
    """The play data of a stage.

    **Raises:** `MissingDataError` if there are none.
    """
    play = strength_of(stage).play
    if play is None:
        raise MissingDataError("the stage has no play data; give [stage.strength.play]")
    return play


def preload_force(stage: Stage) -> Scalar:
    """The preload of a stage [N].

    **Raises:** `MissingDataError` if its nut is not preloaded.
    """
    preload = preload_of(stage)
    if preload is None:
        raise MissingDataError(
            "the nut is not preloaded; give stage.strength.play.preload_force, or "
            "stage.load_sharing.split_nut"
        )
    return preload


@physics("backlash")
def backlash(stage: Stage, meshing: Meshing | None = None) -> Scalar:
    r"""Axial travel of the unloaded nut relative to a fixed screw [m].

    As measured; or the play between screw and rollers plus that between rollers and nut:
    $2 g + t_s + 2 t_R + t_n$ with the axial gap g per flank that the meshing leaves between teeth
    of half a pitch (it is negative on the screw's side and 0 on the nut's) and the thinning t of
    the teeth of screw, roller and nut; or else the backlash of load sharing. 0 if the nut is
    preloaded. Negative where teeth interfere.

    **Arguments:**

    - `stage`: the stage, with play data or load sharing.
    - `meshing`: its meshing, if already known.

    **Raises:** `MissingDataError` if neither backlash nor thinning nor preload is given.
    """
    play = None if stage.strength is None else stage.strength.play
    if play is not None and play.axial_backlash is not None:
        return play.axial_backlash
    preload = preload_of(stage)
    if preload is not None:
        return jnp.zeros_like(preload)
    thinning = [] if play is None else _thinning(play)
    if not thinning:
        sharing = stage.load_sharing
        if sharing is not None and sharing.backlash is not None:
            return sharing.backlash
        play_of(stage)  # Raises with the name of the table if one is missing.
        raise MissingDataError(
            "the play of the threads is not known; give stage.strength.play.axial_backlash, or "
            "screw_tooth_thinning, roller_tooth_thinning and nut_tooth_thinning"
        )
    meshing = mesh(stage.thread) if meshing is None else meshing
    return 2 * meshing.axial_gap + sum(thinning[1:], thinning[0])


def _thinning(play: AxialPlay) -> list[Scalar]:
    """Contributions of thinned teeth to the play; those of a roller count on both sides."""
    return [
        factor * value
        for factor, value in (
            (1, play.screw_tooth_thinning),
            (2, play.roller_tooth_thinning),
            (1, play.nut_tooth_thinning),
        )
        if value is not None
    ]


def thins_teeth(play: AxialPlay) -> bool:
    """Whether the thinning of some teeth is given."""
    return bool(_thinning(play))


def needs_meshing_for_backlash(stage: Stage) -> bool:
    """Whether the backlash follows from the teeth."""
    play = None if stage.strength is None else stage.strength.play
    if play is None or play.axial_backlash is not None or is_preloaded(stage):
        return False
    return thins_teeth(play)


def _approach(stage: Stage, load: Scalar, contact: StageContact | None) -> Scalar:
    """Approach of one nut, or of one half of a split nut (twice the load per thread)."""
    return axial_approach(stage, load / thread_share(stage), contact=contact)


@physics("lost_motion")
def lost_motion(
    stage: Stage,
    load: Scalar,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
) -> Scalar:
    r"""Travel of the nut when a load reverses from −F to F, with the screw fixed [m].

    Backlash and the approach of the thread contacts in both directions, $j + 2\delta_a(F)$; for a
    preloaded pair $2 s\,\delta_0$. Shafts and teeth are rigid.

    **Arguments:**

    - `stage`: the stage, with play data or load sharing, materials and `engaged_threads`.
    - `load`: F; its sign is ignored [N].
    - `meshing`: its meshing, if already known.
    - `contact`: `reference_contact` of the stage, if already known.

    **Raises:** `MissingDataError` if data are missing.
    """
    preload = preload_of(stage)
    if preload is not None:
        displacement = relative_displacement(jnp.abs(load) / preload)
        return 2 * displacement * _approach(stage, preload, contact)
    if contact is None:
        return backlash(stage, meshing) + 2 * axial_approach(stage, load, meshing)
    return backlash(stage, meshing) + 2 * axial_approach(stage, load, contact=contact)


def preloaded_load(stage: Stage, load: Scalar) -> Scalar:
    """Load of the more loaded of two preloaded nuts, its preload included [N].

    Over the share of the engaged threads that carry it: half of them in a split nut, or those of
    its smaller part. So it is the load that all engaged threads together would carry with the same
    force on each of them.

    **Arguments:**

    - `stage`: the stage, with a preload.
    - `load`: axial load; its sign is ignored [N].

    **Raises:** `MissingDataError` if its nut is not preloaded.
    """
    loaded, _ = flank_loads(jnp.abs(load), preload_force(stage))
    return loaded / thread_share(stage)


def preloaded_stiffness(stage: Stage, load: Scalar, contact: StageContact | None = None) -> Scalar:
    """Tangent stiffness of a preloaded pair under a load, threads only [N/m].

    **Arguments:**

    - `stage`: the stage, with a preload, materials and `engaged_threads`.
    - `load`: axial load [N].
    - `contact`: `reference_contact` of the stage, if already known.

    **Raises:** `MissingDataError` if data are missing.
    """
    preload = preload_force(stage)
    return preloaded_pair_stiffness(load, preload, _approach(stage, preload, contact))
