"""Contact curvatures and normal force by three named conventions."""

import equinox as eqx
import jax.numpy as jnp

from ..fields import Scalar
from ..geometry import Meshing, RelativeCurvature
from ..mechanism import CurvatureConvention, Thread
from ..numerics import inverse


class ContactFrame(eqx.Module):
    """Geometry on one side of the roller, as needed by a Hertz contact."""

    curvature: RelativeCurvature
    #: Normal force per axial force of the contact, F_n/F_a.
    normal_per_axial: Scalar


def _from_principal_sums(first: Scalar, second: Scalar, factor: Scalar) -> ContactFrame:
    """Frame from curvature sums in two aligned principal planes; rolling in the second."""
    curvature = RelativeCurvature(
        total=(first + second) / 2,
        difference_squared=((first - second) / 2) ** 2,
        rolling=second / 2,
        twist=jnp.zeros_like(second),
    )
    return ContactFrame(curvature, factor)


def _lisowski2014(thread: Thread) -> tuple[ContactFrame, ContactFrame]:
    """Lisowski 2014, equations 1 to 3 and 7 (corrected signs), φ = 0.

    The source prints the radii in the rolling plane helix-like, `((d/2)² + p²)/p`; they are
    reproduced, not recommended.
    """
    pitch, sine = thread.pitch, jnp.sin(thread.flank_angle)

    def helix_curvature(radius: Scalar) -> Scalar:
        return pitch / (radius**2 + pitch**2)

    # φ = 0 puts R₁₁ (roller profile) in one plane with R₂₁ (screw or nut helix).
    profile = sine / thread.roller_radius
    roller_helix = helix_curvature(thread.roller_radius)
    factor = 1 / jnp.cos(thread.flank_angle)
    screw = profile + helix_curvature(thread.screw_radius)
    nut = profile - helix_curvature(thread.nut_radius)
    return (
        _from_principal_sums(screw, roller_helix, factor),
        _from_principal_sums(nut, roller_helix, factor),
    )


def _wu2022(thread: Thread) -> tuple[ContactFrame, ContactFrame]:
    """Wu et al. 2022, equations 36 to 45: the roller as a ball of radius r_R / cos λ."""
    cosine = jnp.cos(thread.contact_angle)
    ball = cosine / thread.roller_radius
    factor = 1 / (jnp.cos(thread.roller_helix_angle) * jnp.sin(thread.contact_angle))
    # 2 cos λ/(d_c ∓ 2 R cos λ) = cos λ / r_s and cos λ / r_n, because R cos λ = r_R.
    screw = ball + cosine / thread.screw_radius
    nut = ball - cosine / thread.nut_radius
    return _from_principal_sums(ball, screw, factor), _from_principal_sums(ball, nut, factor)


def _exact(meshing: Meshing) -> tuple[ContactFrame, ContactFrame]:
    """Curvatures of the true flanks and the true common normals, from the meshing."""
    screw, nut = (
        ContactFrame(side.curvature, inverse(jnp.abs(side.normal_parts[2])))
        for side in (meshing.screw, meshing.nut)
    )
    return screw, nut


def contact_frames(
    thread: Thread, meshing: Meshing | None, convention: CurvatureConvention
) -> tuple[ContactFrame, ContactFrame]:
    """Curvatures and force factors of the screw and the nut side.

    **Arguments:**

    - `thread`: the thread geometry.
    - `meshing`: the meshing of that thread; only `"exact"` needs it.
    - `convention`: `"exact"`, `"lisowski2014"` or `"wu2022"`.

    **Raises:** `ValueError` for `"exact"` without a meshing.
    """
    if convention == "lisowski2014":
        return _lisowski2014(thread)
    if convention == "wu2022":
        return _wu2022(thread)
    if meshing is None:
        raise ValueError("curvature is 'exact' but meshing is None; pass mesh(thread)")
    return _exact(meshing)
