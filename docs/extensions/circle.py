"""An approximation of the contact ellipse: a circle, for contacts that are nearly circular."""

import jax.numpy as jnp

from prsm_jax.contact import contact_approximation


@contact_approximation("circle")
def circle(anisotropy):
    """κ = 1 and K = E = π/2 for any curvatures: exact for a ball on a plane only."""
    one = jnp.ones_like(anisotropy)
    return one, jnp.pi / 2 * one, jnp.pi / 2 * one
