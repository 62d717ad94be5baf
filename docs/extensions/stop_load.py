"""A load that depends on the nut's motion: a stop with a spring and a damper."""

import equinox as eqx
import jax.numpy as jnp

from prsm_jax.fields import Number, number


class StopLoad(eqx.Module):
    """A constant load and, beyond a position, a stop of rubber."""

    load: Number = number("N", "load before the stop")
    position: Number = number("m", "position of the nut at which it meets the stop")
    stiffness: Number = number("N/m", "stiffness of the stop")
    damping: Number = number("N·s/m", "damping of the stop")

    def __call__(self, time, position, speed, acceleration):
        deflection = jnp.maximum(position - self.position, 0.0)
        pressed = self.stiffness * deflection + self.damping * speed
        return self.load + jnp.where(deflection > 0, jnp.maximum(pressed, 0.0), 0.0)
