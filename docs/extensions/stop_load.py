"""A load that depends on the nut's motion: a stop with a spring and a damper."""

import equinox as eqx
import jax.numpy as jnp

from prsm_jax.fields import Scalar, number


class StopLoad(eqx.Module):
    """A constant load and, beyond a position, a stop of rubber."""

    load: Scalar = number("N", "load before the stop")
    position: Scalar = number("m", "position of the nut at which it meets the stop")
    stiffness: Scalar = number("N/m", "stiffness of the stop")
    damping: Scalar = number("N·s/m", "damping of the stop")

    def __call__(self, time, position, speed, acceleration):
        deflection = jnp.maximum(position - self.position, 0.0)
        pressed = self.stiffness * deflection + self.damping * speed
        return self.load + jnp.where(deflection > 0, jnp.maximum(pressed, 0.0), 0.0)
