"""Stress below uniformly loaded rectangles: pressure (Love 1929) and shear traction, closed form.

Each function gives antiderivatives of the six stresses due to a point load; their differences over
the four corners are the stresses due to a rectangle. They follow from the potentials of Boussinesq
and Cerruti (Johnson 1985, section 3.2). z points into the body, tension is positive. X and Y are
never 0, and differences over opposite corners are free of the logarithms' singular parts.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar

#: Coordinates X or Y relative to the corners [m], one axis each.
Corners = Float[Array, "#cx #cy"]
#: Antiderivatives of σ_xx, σ_yy, σ_zz, σ_xy, σ_yz, σ_zx, unit load.
Components = tuple[Array, Array, Array, Array, Array, Array]


def _radii(x: Array, y: Array, depth: Scalar) -> tuple[Array, Array, Array]:
    """R, X² + z² and Y² + z², broadcast."""
    across_x, across_y = x**2 + depth**2, y**2 + depth**2
    return jnp.sqrt(across_x + y**2), across_x, across_y


def _solid_angle(x: Array, y: Array, depth: Scalar, radius: Array) -> Array:
    """−∂/∂z of ∬ 1/R: the angle under which the rectangle is seen, and 2π inside at the surface."""
    return jnp.arctan2(x * y, depth * radius)


def pressure_stress(x: Corners, y: Corners, depth: Scalar, poisson_ratio: Scalar) -> Components:
    """Stresses due to pressure, at a depth z ≥ 0."""
    radius, across_x, across_y = _radii(x, y, depth)
    slope = -_solid_angle(x, y, depth, radius)
    bend_xx = -x * y / (radius * across_x)
    bend_yy = -x * y / (radius * across_y)
    # Second derivatives of ∬ ln(R + z).
    log_xx = jnp.arctan(y / x) - jnp.arctan(depth * y / (x * radius))
    log_yy = jnp.arctan(x / y) - jnp.arctan(depth * x / (y * radius))
    log_xy = jnp.log(radius + depth)
    factor = 1 - 2 * poisson_ratio
    along_x = 2 * poisson_ratio * slope - depth * bend_xx - factor * log_xx
    along_y = 2 * poisson_ratio * slope - depth * bend_yy - factor * log_yy
    downwards = slope + depth * (bend_xx + bend_yy)
    in_plane = -(factor * log_xy + depth / radius)
    shear_yz = depth**2 * x / (radius * across_y)
    shear_zx = depth**2 * y / (radius * across_x)
    parts = (along_x, along_y, downwards, in_plane, shear_yz, shear_zx)
    return tuple(part / (2 * jnp.pi) for part in parts)  # type: ignore[return-value]


def shear_stress(x: Corners, y: Corners, depth: Scalar, poisson_ratio: Scalar) -> Components:
    """Stresses due to traction on the body in the direction of x, at a depth z ≥ 0."""
    radius, across_x, across_y = _radii(x, y, depth)
    below = radius + depth
    # φ = ∬ 1/R, F = ∬ ln(R + z), F₁ = ∬ (z ln(R + z) − R), differentiated as named.
    phi_x = jnp.arcsinh(y / jnp.sqrt(across_x))
    phi_y = jnp.arcsinh(x / jnp.sqrt(across_y))
    phi_z = -_solid_angle(x, y, depth, radius)
    phi_xx = -x * y / (radius * across_x)
    phi_xz = -depth * y / (radius * across_x)
    phi_xy = 1 / radius
    f_xyy = y / (radius * below)
    f_xxx = -f_xyy - phi_xz
    f_xxy = x / (radius * below)
    first_xyy = -y / below
    first_xxx = y / below - phi_x
    first_xxy = -x / below
    nu = poisson_ratio
    along_x = 2 * (1 + nu) * phi_x + 2 * nu * first_xxx - depth * f_xxx
    along_y = 2 * nu * (phi_x + first_xyy) - depth * f_xyy
    downwards = -depth * phi_xz
    in_plane = phi_y + 2 * nu * first_xxy - depth * f_xxy
    shear_yz = -depth * phi_xy
    shear_zx = phi_z - depth * phi_xx
    parts = (along_x, along_y, downwards, in_plane, shear_yz, shear_zx)
    return tuple(part / (2 * jnp.pi) for part in parts)  # type: ignore[return-value]
