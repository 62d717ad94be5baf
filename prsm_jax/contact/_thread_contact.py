"""Thread contacts of one stage under load."""

import functools
from collections.abc import Callable
from typing import Annotated

import jax
import jax.numpy as jnp

from .._errors import MissingDataError
from ..fields import In, Scalar
from ..geometry import Meshing, mesh
from ..mechanism import Stage, material_of
from ..numerics import apart
from ..results import Result
from ._conventions import ContactFrame, contact_frames
from .hertz import HertzContact, HertzMethod, contact_modulus, hertz_contact


class ThreadContactSide(Result):
    """One thread contact on one side of a roller; all engaged threads share the load equally."""

    hertz: HertzContact
    normal_force: Annotated[Scalar, In("N")]
    #: Axial secant stiffness of one contact, F_a/δ_a with δ_a = δ F_n/F_a [N/m].
    axial_stiffness: Annotated[Scalar, In("N/m")]
    #: Axial stiffness of all engaged threads of one roller in parallel [N/m].
    roller_stiffness: Annotated[Scalar, In("N/m")]

    @property
    def roller_tangent_stiffness(self) -> Scalar:
        """Tangent stiffness dF/dδ of one roller, 3/2 of F/δ for a Hertz contact [N/m]."""
        return 1.5 * self.roller_stiffness


class StageContact(Result):
    """Thread contacts of one stage: screw side and nut side."""

    screw: ThreadContactSide
    nut: ThreadContactSide


def meshing_of(stage: Stage, meshing: Meshing | None = None) -> Meshing | None:
    """Meshing of a stage, if known already or if its curvature convention needs it."""
    return mesh(stage.thread) if meshing is None and stage.curvature == "exact" else meshing


def engaged_threads(stage: Stage) -> Scalar:
    """Number of load-carrying threads of one roller per side.

    **Raises:** `MissingDataError` if the stage does not give it.
    """
    if stage.engaged_threads is None:
        raise MissingDataError(
            "the stage has no engaged_threads; give stage.engaged_threads, the number of threads "
            "of one roller that carry load"
        )
    return stage.engaged_threads


def _hertz_of(stage: Stage, method: HertzMethod | None = None) -> Callable[..., HertzContact]:
    """`hertz_contact` by the method of a stage, or by another one in its place.

    All thread contacts of the package are computed by this function. It is a separate part of a
    program: XLA would fuse its 300 operations, and those of their derivatives, with all that uses
    the results.
    """
    chosen = stage.contact_method if method is None else method
    return apart(functools.partial(hertz_contact, method=chosen), whole=True)


def side_contact(
    stage: Stage,
    side: str,
    frame: ContactFrame,
    normal_force: Scalar,
    method: HertzMethod | None = None,
) -> ThreadContactSide:
    """One contact under its normal force [N], on the `"screw"` or the `"nut"` side."""
    modulus = contact_modulus(material_of(stage, "roller"), material_of(stage, side))
    curvature = frame.curvature
    hertz = _hertz_of(stage, method)(
        normal_force, curvature.total, curvature.difference_squared, modulus
    )
    return contact_side(hertz, normal_force, frame, engaged_threads(stage))


def contact_side(
    hertz: HertzContact, normal_force: Scalar, frame: ContactFrame, threads: Scalar
) -> ThreadContactSide:
    """One contact, with the stiffness of this number of threads of a roller."""
    axial = hertz.stiffness / frame.normal_per_axial**2
    return ThreadContactSide(hertz, normal_force, axial, axial * threads)


def contact_pair(
    stage: Stage,
    frames: tuple[ContactFrame, ContactFrame],
    forces: tuple[Scalar, Scalar],
) -> tuple[HertzContact, HertzContact]:
    """Hertz contacts of the screw and the nut side, in half the program size of two calls.

    For large programs; two calls of `side_contact` are faster in batches of small programs.

    **Arguments:**

    - `stage`: the stage; needs materials.
    - `frames`: of both sides.
    - `forces`: normal forces [N].
    """
    inputs = [
        (
            force,
            frame.curvature.total,
            frame.curvature.difference_squared,
            contact_modulus(material_of(stage, "roller"), material_of(stage, side)),
        )
        for side, frame, force in zip(("screw", "nut"), frames, forces, strict=True)
    ]
    force, total, difference, modulus = (jnp.stack(pair) for pair in zip(*inputs, strict=True))
    both = jax.vmap(_hertz_of(stage))(force, total, difference, modulus)
    screw, nut = (jax.tree.map(lambda leaf, k=k: leaf[k], both) for k in range(2))
    return screw, nut


def stage_contact(
    stage: Stage,
    load: Scalar,
    meshing: Meshing | None = None,
    method: HertzMethod | None = None,
) -> StageContact:
    """Thread contacts of a stage under an axial load, shared equally and without friction.

    Every roller carries `load / N` and every one of its engaged threads an equal part of that, so
    a contact carries the axial force F_a = load/(N z) and the normal force F_a · F_n/F_a of the
    stage's curvature convention.

    **Arguments:**

    - `stage`: the stage; needs materials and `engaged_threads`.
    - `load`: axial load on the nut [N].
    - `meshing`: its meshing, if already known; used only by the `"exact"` convention.
    - `method`: Hertz method in place of that of the stage.

    **Raises:** `MissingDataError` if materials or engaged threads are not given.
    """
    axial_force = load / (stage.present_roller_count * engaged_threads(stage))
    screw, nut = contact_frames(stage.thread, meshing_of(stage, meshing), stage.curvature)
    return StageContact(
        screw=side_contact(stage, "screw", screw, axial_force * screw.normal_per_axial, method),
        nut=side_contact(stage, "nut", nut, axial_force * nut.normal_per_axial, method),
    )
