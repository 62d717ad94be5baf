"""Stress below a Hertz line contact with Coulomb friction, in closed form."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...programs import physics


@physics("line_stress")
def line_subsurface_stress(
    point: Float[Array, "2"],
    half_width: Scalar,
    max_pressure: Scalar,
    poisson_ratio: Scalar,
    traction: Scalar | None = None,
) -> Float[Array, "3 3"]:
    """Stress tensor in plane strain under the pressure p₀ √(1 − x²/B²) of a line contact.

    The closed form of McEwen 1949 (Johnson 1985, section 4.2 and 7.1): with `m n = x z` and
    `m² − n² = B² − x² + z²`. Without friction the largest shear stress is 0.300 p₀ at 0.786 B.

    **Arguments:**

    - `point`: (x, z) across the line and into the body, z ≥ 0 [m].
    - `half_width`: B [m].
    - `max_pressure`: p₀ [Pa].
    - `poisson_ratio`: ν of this body.
    - `traction`: shear traction per pressure that acts on this body in x. Without it no friction
      is traced.

    **Returns:** the symmetric stress tensor in (x, y, z), y along the line [Pa]; 0 without a load
    (half-width 0).
    """
    unloaded = half_width <= 0
    half_width = jnp.where(unloaded, 1.0, half_width)
    max_pressure = jnp.where(unloaded, 0.0, max_pressure)
    x, z = point[0] / half_width, point[1] / half_width
    real = 1 - x**2 + z**2
    # The floors keep derivatives finite at the edges of the contact, where the derivatives of the
    # stress are infinite.
    floor = jnp.finfo(x.dtype).eps ** 2
    size = jnp.sqrt(jnp.maximum(real**2 + (2 * x * z) ** 2, floor**2))
    over = real > 0
    # The larger of m and n first, the smaller from their product: no root of zero.
    larger = jnp.sqrt((size + jnp.abs(real)) / 2)
    m = jnp.where(over, larger, jnp.abs(x) * z / larger)
    n = jnp.where(over, x * z / larger, jnp.sign(x) * larger)
    # At the edges m = n = 0, and their factors stay finite.
    below = m**2 + n**2 + floor
    share = (z**2 + n**2) / below
    xx = -(m * (1 + share) - 2 * z)
    zz = -m * (1 - share)
    xz = -n * (m**2 - z**2) / below
    if traction is not None:
        pulled_xx = n * (2 - (z**2 - m**2) / below) - 2 * x
        xx, zz, xz = xx + traction * pulled_xx, zz + traction * xz, xz + traction * xx
    yy = poisson_ratio * (xx + zz)
    zero = jnp.zeros_like(xx)
    parts = jnp.stack([xx, zero, xz, zero, yy, zero, xz, zero, zz])
    return max_pressure * parts.reshape(3, 3)
