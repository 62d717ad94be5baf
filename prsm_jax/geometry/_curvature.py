"""Relative curvature of two flanks that touch, from the second derivatives of their heights."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp

from ..fields import Scalar
from ..numerics import inverse_root
from ._flanks import Slope, SymmetricTensor


class RelativeCurvature(eqx.Module):
    """The gap A x² + B y² (A ≤ B) between two surfaces, measured along their common normal.

    Stored as symmetric functions of A and B, which stay smooth when the contact becomes circular.
    """

    #: A + B, half the sum of the four principal curvatures [1/m].
    total: Scalar
    #: (B − A)² [1/m²].
    difference_squared: Scalar
    #: Gap coefficient in the rolling direction, between A and B [1/m].
    rolling: Scalar
    #: Mixed gap coefficient of the rolling direction and the tangent across it, which is at a right
    #: angle to it about the normal; 0 where both are principal [1/m].
    twist: Scalar


class FlankPoint(NamedTuple):
    """A point of a flank z = f(r) + (lead/2π) θ, by its numbers about the axis of the flank."""

    #: Slope f' of the profile.
    slope: Scalar
    #: Slope along the helix, (lead/2π)/r.
    helix: Scalar
    #: 1/r [1/m].
    inverse_radius: Scalar
    #: f'', the bend of the profile; `None` for a straight one [1/m].
    bend: Scalar | None


def along_gradient(point: FlankPoint, square: Scalar) -> SymmetricTensor:
    """|∇z|² ∇∇z of a flank, in the direction of its gradient and at a right angle to it [1/m].

    Radially and tangentially, ∇z is (f', k) with k = (lead/2π)/r, and ∇∇z has the entries f'',
    −k/r and f'/r. Turned into the direction of ∇z,

        |∇z|² ∇∇z = (f'' f'² − f' k²/r, k³/r − f'' f' k, f'' k² + f' (|∇z|² + k²)/r).

    **Arguments:**

    - `point`: the point.
    - `square`: |∇z|².
    """
    slope, helix, inverse, bend = point
    squared = helix**2
    turn = squared * inverse
    first, mixed = -slope * turn, helix * turn
    second = slope * inverse * (square + squared)
    if bend is None:
        return SymmetricTensor(first, mixed, second)
    along = bend * slope
    return SymmetricTensor(first + along * slope, mixed - along * helix, second + bend * squared)


def relative_curvature(
    bend: SymmetricTensor, square: Scalar, flatness: Scalar
) -> tuple[RelativeCurvature, Scalar]:
    """Curvature of the gap between two flanks that touch, about their common normal.

    No small-lead approximation is made. The tangent plane is steeper than the transverse one in
    the direction of the common gradient g only: with cos γ = 1/√(1 + |g|²), lengths along g are
    longer by 1/cos γ, and the gap along the normal is the axial gap times cos γ. So the curvature
    tensor S of the gap, in the direction of g and across it, is cos γ ∇∇z times cos²γ, cos γ and 1.

    The rolling direction is the tangent across g, which lies in the transverse plane, because the
    bodies turn about axes normal to that plane.

    **Arguments:**

    - `bend`: |g|² ∇∇z of the gap, in the direction of g and at a right angle to it [1/m].
    - `square`, `flatness`: |g|² and 1/|g|².

    **Returns:** the curvature of the gap, and cos γ.
    """
    cosine = inverse_root(1 + square)
    steep = cosine**2
    scale = cosine * flatness
    along = scale * steep * bend.xx
    mixed = scale * cosine * bend.xy
    across = scale * bend.yy
    curvature = RelativeCurvature(
        total=(along + across) / 2,
        difference_squared=((along - across) / 2) ** 2 + mixed**2,
        rolling=across / 2,
        twist=mixed / 2,
    )
    return curvature, cosine


def direction_coefficient(curvature: RelativeCurvature, rolling: Scalar, across: Scalar) -> Scalar:
    """Coefficient of the gap along a tangent of unit length, between A and B [1/m].

    For a tangent of any other length, times the square of that length.

    **Arguments:**

    - `curvature`: of the gap.
    - `rolling`, `across`: parts of the tangent in the rolling direction, and across it about the
      normal of the screw side.
    """
    return (
        curvature.rolling * rolling**2
        + 2 * curvature.twist * rolling * across
        + (curvature.total - curvature.rolling) * across**2
    )


def tangent_tensor(
    slope: Slope, hessian: SymmetricTensor
) -> tuple[SymmetricTensor, SymmetricTensor]:
    """Curvature tensor S of the gap in the tangent plane, and the orientation of this plane.

    For any point and any Hessian; `relative_curvature` is for flanks, in half the operations.

    **Arguments:**

    - `slope`: the common gradient of both surfaces over the transverse plane.
    - `hessian`: the Hessian of the axial gap over the transverse plane [1/m].

    **Returns:** S = cos γ G^{-1/2} H G^{-1/2} [1/m], and G^{-1/2}, which maps orthonormal
    coordinates of the tangent plane to transverse ones.
    """
    x, y = slope
    cosine = 1 / jnp.sqrt(1 + x**2 + y**2)
    # G^{-1/2} = I − g gᵀ (1 − cos γ)/|g|², and (1 − cos γ)/|g|² = cos²γ/(1 + cos γ).
    share = cosine**2 / (1 + cosine)
    whitening = SymmetricTensor(1 - share * x**2, -share * x * y, 1 - share * y**2)
    bent = SymmetricTensor(*(cosine * entry for entry in hessian))
    return _congruent(whitening, bent), whitening


def _congruent(outer: SymmetricTensor, inner: SymmetricTensor) -> SymmetricTensor:
    """The symmetric 2×2 product W H W."""
    first_x = outer.xx * inner.xx + outer.xy * inner.xy
    first_y = outer.xx * inner.xy + outer.xy * inner.yy
    second_x = outer.xy * inner.xx + outer.yy * inner.xy
    second_y = outer.xy * inner.xy + outer.yy * inner.yy
    return SymmetricTensor(
        first_x * outer.xx + first_y * outer.xy,
        first_x * outer.xy + first_y * outer.yy,
        second_x * outer.xy + second_y * outer.yy,
    )
