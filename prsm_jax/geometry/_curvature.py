"""Relative curvature of two touching surfaces from the Hessian of their gap."""

import equinox as eqx
import jax.numpy as jnp

from ..fields import Scalar
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


def relative_curvature(slope: Slope, hessian: SymmetricTensor) -> RelativeCurvature:
    """Project the Hessian of an axial gap onto the common tangent plane.

    No small-lead approximation is made. With the common slope g = ∇z the tangent plane has the
    metric G = I + g gᵀ, and the gap along the normal is the axial gap times
    cos γ = 1/√(1 + |g|²); so the curvature tensor is S = cos γ G^{-1/2} H G^{-1/2}.

    The rolling direction is the tangent that lies in the transverse plane, because the bodies
    turn about axes normal to that plane.

    **Arguments:**

    - `slope`: the common gradient of both surfaces over the transverse plane.
    - `hessian`: the Hessian of the gap over the transverse plane [1/m].
    """
    tensor, _ = tangent_tensor(slope, hessian)
    x, y = slope
    # Across g the metric is 1: there S is cos γ H.
    across = y**2 * tensor.xx - 2 * x * y * tensor.xy + x**2 * tensor.yy
    mixed = x * y * (tensor.yy - tensor.xx) + (x**2 - y**2) * tensor.xy
    return RelativeCurvature(
        total=(tensor.xx + tensor.yy) / 2,
        difference_squared=((tensor.xx - tensor.yy) / 2) ** 2 + tensor.xy**2,
        rolling=across / (2 * (x**2 + y**2)),
        twist=mixed / (2 * (x**2 + y**2)),
    )


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
