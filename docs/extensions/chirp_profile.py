"""A profile of the screw speed: a sine whose frequency rises, to find resonances."""

import equinox as eqx
import jax.numpy as jnp

from prsm_jax.fields import Scalar, number


class ChirpProfile(eqx.Module):
    """Ω(t) = m + a sin(2π (f t + r t²/2)); its angle is found by quadrature."""

    mean: Scalar = number("rad/s", "mean speed")
    amplitude: Scalar = number("rad/s", "amplitude")
    frequency: Scalar = number("Hz", "frequency at the start")
    rate: Scalar = number("Hz/s", "rise of the frequency")

    def __call__(self, time):
        turns = self.frequency * time + self.rate * time**2 / 2
        return self.mean + self.amplitude * jnp.sin(2 * jnp.pi * turns)
