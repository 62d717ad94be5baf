"""Relative curvature of two touching surfaces from the Hessian of their gap."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..mechanism import Scalar


class RelativeCurvature(eqx.Module):
    """The gap A x² + B y² (A ≤ B) between two surfaces, measured along their common normal.

    Held as symmetric functions of A and B, which stay smooth when the contact becomes circular.
    """

    #: A + B, half the sum of the four principal curvatures [1/m].
    total: Scalar
    #: (B − A)² [1/m²].
    difference_squared: Scalar
    #: Gap coefficient in the rolling direction, between A and B [1/m].
    rolling: Scalar


def tangent_tensor(
    slope: Float[Array, "2"], hessian: Float[Array, "2 2"]
) -> tuple[Float[Array, "2 2"], Float[Array, "2 2"]]:
    """Curvature tensor S of the gap in the tangent plane, and how that plane lies.

    With the common slope g = ∇z the tangent plane has the metric G = I + g gᵀ, and the gap along
    the normal is the axial gap times cos γ = 1/√(1 + |g|²); so S = cos γ G^{-1/2} H G^{-1/2}.

    **Arguments:**

    - `slope`: the common gradient of both surfaces over the transverse plane.
    - `hessian`: the Hessian of the axial gap over the transverse plane [1/m].

    **Returns:** S [1/m], and G^{-1/2}, which takes orthonormal coordinates of the tangent plane to
    transverse ones.
    """
    cosine = 1 / jnp.sqrt(1 + jnp.sum(slope**2))
    # G^{-1/2} = I − g gᵀ (1 − cos γ)/|g|², and (1 − cos γ)/|g|² = cos²γ/(1 + cos γ).
    whitening = jnp.eye(2, dtype=slope.dtype) - jnp.outer(slope, slope) * (cosine**2 / (1 + cosine))
    return cosine * whitening @ hessian @ whitening, whitening


def relative_curvature(slope: Float[Array, "2"], hessian: Float[Array, "2 2"]) -> RelativeCurvature:
    """Project the Hessian of an axial gap onto the common tangent plane.

    No small-lead approximation is made.

    The rolling direction is the tangent that lies in the transverse plane, because the bodies
    turn about axes normal to that plane.

    **Arguments:**

    - `slope`: the common gradient of both surfaces over the transverse plane.
    - `hessian`: the Hessian of the gap over the transverse plane [1/m].
    """
    tensor, _ = tangent_tensor(slope, hessian)
    total = (tensor[0, 0] + tensor[1, 1]) / 2
    difference_squared = ((tensor[0, 0] - tensor[1, 1]) / 2) ** 2 + tensor[0, 1] ** 2
    across = jnp.stack([-slope[1], slope[0]])
    rolling = across @ tensor @ across / (2 * jnp.sum(slope**2))
    return RelativeCurvature(total, difference_squared, rolling)
