"""Loads that depend on where the nut is and how fast it moves."""

import equinox as eqx
import jax.numpy as jnp

from ..mechanism import Scalar, as_scalar


class HingeLoad(eqx.Module):
    """Load of a driven structure: constant, spring, damper and mass at the last nut.

    `F = constant + stiffness z + damping ż + mass z̈`, against positive travel z of the nut (that
    of a positively turning screw).
    """

    #: [N]
    constant: Scalar = eqx.field(converter=as_scalar, default=0.0)
    #: [N/m]
    stiffness: Scalar = eqx.field(converter=as_scalar, default=0.0)
    #: [N·s/m]
    damping: Scalar = eqx.field(converter=as_scalar, default=0.0)
    #: [kg]
    mass: Scalar = eqx.field(converter=as_scalar, default=0.0)

    def __call__(
        self, time: Scalar, position: Scalar, speed: Scalar, acceleration: Scalar
    ) -> Scalar:
        """Load at a time, position [m], speed [m/s] and acceleration [m/s²] of the nut [N]."""
        held = self.constant + self.stiffness * position
        return held + self.damping * speed + self.mass * acceleration


class LoadOfTime(eqx.Module):
    """A load that is a number or a function of time, seen as one of the nut's motion."""

    load: object

    def __call__(self, time, position, speed, acceleration):
        value = self.load(time) if callable(self.load) else self.load
        return jnp.asarray(value, time.dtype)
