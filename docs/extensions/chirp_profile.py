"""A profile of the screw speed: a sine whose frequency rises, to find resonances."""

import equinox as eqx
import jax.numpy as jnp

from prsm_jax.fields import Number, number


class ChirpProfile(eqx.Module):
    """Ω(t) = m + a sin(2π (f t + r t²/2)); its angle is found by quadrature."""

    mean: Number = number("rad/s", "mean speed")
    amplitude: Number = number("rad/s", "amplitude")
    frequency: Number = number("Hz", "frequency at the start")
    rate: Number = number("Hz/s", "rise of the frequency")

    def __call__(self, time):
        turns = self.frequency * time + self.rate * time**2 / 2
        return self.mean + self.amplitude * jnp.sin(2 * jnp.pi * turns)
