"""Static capacity: the load at the permissible permanent deformation of the threads."""

import jax.numpy as jnp

from .._errors import MissingDataError
from ..contact import StageContact, contact_frames, engaged_threads, meshing_of
from ..fields import Scalar
from ..geometry import Meshing
from ..mechanism import Stage
from ..programs import physics
from ._contacts import known_contact, strength_of, thread_share
from ._powers import ratio_or_infinity
from ._truncation import SideOnset, load_at_pressure, load_of_whole_ellipse, side_onsets

#: Palmgren's permanent deformation of two hardened steel bodies, δ D/(Q² Σ₁ Σ₂) [m²/N²]: 1.3e-7
#: in newtons and millimetres; the sums of curvatures have the product Σ₁ Σ₂ = 4 A B.
_PERMANENT = 1.3e-7 * 1e-12


@physics("static_capacity")
def static_capacity(
    stage: Stage,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
    sharing_factor: Scalar | float = 1.0,
    sides: tuple[SideOnset | None, SideOnset | None] | None = None,
) -> Scalar:
    r"""Static axial capacity $C_{0a}$ of a stage [N]: as given, or from a permissible pressure.

    At $C_{0a}$ the larger pressure of screw and nut side is the permissible one. Hertz pressures
    are proportional to the cube root of the load, so $C_{0a} = F\,(p_\text{perm}/p_0(F))^3$
    exactly, for any F, as long as the ellipse lies on the flanks. If it extends beyond the end of a
    flank at this pressure, the load of the part that is cut off is subtracted
    (`contact.share_within`). The pressure is that at the contact point: the concentration at the
    edge, which depends on its rounding, is not included.

    ISO 76 sets the pressure for a total permanent deformation of roller and thread of 1e-4 of the
    rolling element's diameter: 4200 MPa in ball bearings, 4600 MPa in self-aligning ones, 4000 MPa
    for line contacts. No standard exists for roller screws; threads are point contacts of hardened
    bearing steel, for which 4200 MPa is the nearest.

    For one nut of a preloaded pair; half as much for the half of a split nut. Range: hardened steel
    (58 HRC and more), equal threads, no friction.

    **Arguments:**

    - `stage`: the stage, with strength data.
    - `meshing`: its meshing, if already known.
    - `contact`: `reference_contact` of the stage, if already known.
    - `sharing_factor`: load of the most loaded thread over the mean, at least 1; a given capacity
        is not changed.
    - `sides`: `side_onsets` of the stage, if already known.

    **Raises:** `MissingDataError` if neither capacity nor permissible pressure is given, or
    materials or engaged threads are not.
    """
    strength = strength_of(stage)
    if strength.static_capacity is not None:
        return strength.static_capacity
    if strength.permissible_pressure is None:
        raise MissingDataError(
            "the stage has neither static_capacity nor permissible_pressure; give "
            "stage.strength.permissible_pressure (4.2 GPa in ISO 76 for ball bearings), or "
            "stage.strength.static_capacity from a catalogue"
        )
    meshing, contact = known_contact(stage, meshing, contact)
    if sides is None:
        sides = side_onsets(stage, meshing, contact) or (None, None)
    loads = [
        load_at_pressure(side, one.hertz.max_pressure, strength.permissible_pressure)
        for side, one in zip(sides, (contact.screw, contact.nut), strict=True)
    ]
    return jnp.minimum(*loads) * thread_share(stage) / sharing_factor


def static_safety(capacity: Scalar, load: Scalar) -> Scalar:
    """Static safety factor s₀ = C_0a/F (ISO 3408-5); ∞ without load.

    **Arguments:**

    - `capacity`: basic static axial load rating C_0a [N].
    - `load`: axial load F of either sign [N].
    """
    return ratio_or_infinity(capacity, jnp.abs(load))


@physics("permanent_deformation")
def permanent_deformation(
    stage: Stage,
    load: Scalar,
    meshing: Meshing | None = None,
    sharing_factor: Scalar | float = 1.0,
) -> Scalar:
    r"""Permanent deformation over the diameter of the rolling element, on the worse side.

    $\delta/D = 1.3\cdot10^{-7} Q^2 (\rho_{I1}+\rho_{II1})(\rho_{I2}+\rho_{II2})/D^2$ in newtons
    and millimetres (Palmgren 1959; Harris and Kotzalas 2006, chapter on permanent deformation),
    D twice the radius of the roller's profile. The bearing standards accept 1e-4.

    If an end of a flank cuts the ellipse, Q is the force under which a full ellipse has the same
    pressure. Range: bearing steel of 63.5 to 65.5 HRC, pressures near 4 GPa.

    **Arguments:**

    - `stage`: the stage, with strength data and `engaged_threads`.
    - `load`: axial load, on one nut of a preloaded pair [N].
    - `meshing`: its meshing, if already known.
    - `sharing_factor`: load of the most loaded thread over the mean.

    **Raises:** `MissingDataError` if engaged threads or strength data are not given, or if flanks
    have ends and materials are not given.
    """
    strength_of(stage)
    meshing = meshing_of(stage, meshing)
    frames = contact_frames(stage.thread, meshing, stage.curvature)
    ends = side_onsets(stage, meshing) or (None, None)
    threads = stage.present_roller_count * engaged_threads(stage)
    shared = jnp.abs(load) / thread_share(stage) * sharing_factor
    diameter = 2 * stage.thread.profile_radius
    sides = []
    for frame, side in zip(frames, ends, strict=True):
        axial = load_of_whole_ellipse(side, shared) / threads
        curvature = frame.curvature
        product = curvature.total**2 - curvature.difference_squared
        sides.append((axial * frame.normal_per_axial / diameter) ** 2 * product)
    return _PERMANENT * jnp.maximum(*sides)
