"""Static capacity: the load that leaves a permanent deformation nobody notices."""

import jax.numpy as jnp

from .._errors import MissingDataError
from .._physics import physics
from ..contact import StageContact, contact_frames, engaged_threads
from ..geometry import Meshing
from ..mechanism import Scalar, Stage
from ._contacts import REFERENCE_LOAD, meshing_of, reference_contact, strength_of, thread_share
from ._powers import ratio_or_infinity

#: Palmgren's permanent deformation of two hardened steel bodies, δ D/(Q² Σ₁ Σ₂) [m²/N²]: 1.3e-7
#: in newtons and millimetres; the sums of curvatures have the product Σ₁ Σ₂ = 4 A B.
_PERMANENT = 1.3e-7 * 1e-12


@physics("static_capacity")
def static_capacity(
    stage: Stage,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
    sharing_factor: Scalar | float = 1.0,
) -> Scalar:
    r"""Static axial capacity $C_{0a}$ of a stage [N]: as given, or from a permissible pressure.

    At $C_{0a}$ the larger Hertz pressure of screw and nut side is the permissible one. Pressures
    go with the cube root of the load, so $C_{0a} = F\,(p_\text{perm}/p_0(F))^3$ exactly, for any
    F. ISO 76 sets the pressure so that roller and thread together keep a dent of 1e-4 of the
    rolling element's diameter: 4200 MPa in ball bearings, 4600 MPa in self-aligning ones, 4000 MPa
    for lines. No standard exists for roller screws; threads are point contacts of hardened bearing
    steel, for which 4200 MPa is the nearest.

    Of one nut of a braced pair; half as much for the half of a split nut. Range: hardened steel
    (58 HRC and more), all threads alike, no friction.

    **Arguments:**

    - `stage`: the stage, with strength data.
    - `meshing`: its meshing, if known already.
    - `contact`: `reference_contact` of the stage, if known already.
    - `sharing_factor`: load of the most loaded thread over the mean, at least 1; a capacity that
        is given holds as it is.

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
    if contact is None:
        contact = reference_contact(stage, meshing)
    pressure = jnp.maximum(contact.screw.hertz.max_pressure, contact.nut.hertz.max_pressure)
    whole = REFERENCE_LOAD * (strength.permissible_pressure / pressure) ** 3
    return whole * thread_share(stage) / sharing_factor


def static_safety(capacity: Scalar, load: Scalar) -> Scalar:
    """Static safety factor s₀ = C_0a/F; ∞ without load."""
    return ratio_or_infinity(capacity, jnp.abs(load))


@physics("permanent_deformation")
def permanent_deformation(
    stage: Stage,
    load: Scalar,
    meshing: Meshing | None = None,
    sharing_factor: Scalar | float = 1.0,
) -> Scalar:
    r"""Dent that a load leaves, over the diameter of the rolling element, of the worse side.

    $\delta/D = 1.3\cdot10^{-7} Q^2 (\rho_{I1}+\rho_{II1})(\rho_{I2}+\rho_{II2})/D^2$ in newtons
    and millimetres (Palmgren 1959; Harris and Kotzalas 2006, chapter on permanent deformation),
    D twice the radius of the roller's profile. The bearing standards accept 1e-4.

    Range: bearing steel of 63.5 to 65.5 HRC, pressures near 4 GPa.

    **Arguments:**

    - `stage`: the stage, with strength data and `engaged_threads`.
    - `load`: axial load, on one nut of a braced pair [N].
    - `meshing`: its meshing, if known already.
    - `sharing_factor`: load of the most loaded thread over the mean.

    **Raises:** `MissingDataError` if engaged threads or strength data are not given.
    """
    strength_of(stage)
    frames = contact_frames(stage.thread, meshing_of(stage, meshing), stage.curvature)
    threads = engaged_threads(stage) * thread_share(stage)
    axial = jnp.abs(load) / (stage.present_roller_count * threads) * sharing_factor
    diameter = 2 * stage.thread.profile_radius
    sides = []
    for frame in frames:
        curvature = frame.curvature
        product = curvature.total**2 - curvature.difference_squared
        sides.append((axial * frame.normal_per_axial / diameter) ** 2 * product)
    return _PERMANENT * jnp.maximum(*sides)
