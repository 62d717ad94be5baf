"""Orthogonal shear stress under a rolling contact, used by Lundberg and Palmgren."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar

_NEWTON_STEPS = 6


@jax.custom_jvp
def shape_parameter(axis_ratio_squared: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """The parameter t ≥ 1 of (t² − 1)(2t − 1) = (b/a)², b along the rolling direction.

    **Arguments:**

    - `axis_ratio_squared`: (b/a)², not negative; 0 is a line contact.
    """
    # The cubic is convex there: from above Newton's method converges without overshooting.
    above = jnp.minimum(axis_ratio_squared / 2, jnp.cbrt(axis_ratio_squared / 2))
    parameter = 1 + jnp.minimum(above, jnp.sqrt(axis_ratio_squared / 5))
    for _ in range(_NEWTON_STEPS):
        error = (parameter**2 - 1) * (2 * parameter - 1) - axis_ratio_squared
        parameter = parameter - error / _cubic_slope(parameter)
    return parameter


def _cubic_slope(parameter):
    return 6 * parameter**2 - 2 * parameter - 2


@shape_parameter.defjvp
def _shape_parameter_jvp(primals, tangents):
    (axis_ratio_squared,), (tangent,) = primals, tangents
    parameter = shape_parameter(axis_ratio_squared)
    return parameter, tangent / _cubic_slope(parameter)


def orthogonal_shear(max_pressure: Scalar, half_length: Scalar, axis_ratio: Scalar):
    r"""Amplitude of the orthogonal shear stress, and its depth.

    $\tau_0 = p_0 \sqrt{2t-1}/(2t(t+1))$ at $z_0 = b/((t+1)\sqrt{2t-1})$ (Lundberg and Palmgren
    1947); for a line contact p₀/4 at b/2.

    **Arguments:**

    - `max_pressure`: p₀ [Pa].
    - `half_length`: semi-axis b along the rolling direction [m].
    - `axis_ratio`: b/a, a across it.

    **Returns:** (τ₀ [Pa], z₀ [m]).
    """
    parameter = shape_parameter(axis_ratio**2)
    root = jnp.sqrt(2 * parameter - 1)
    shear = max_pressure * root / (2 * parameter * (parameter + 1))
    return shear, half_length / ((parameter + 1) * root)
