"""What a transient simulation is asked to do."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp

from .._errors import MissingDataError
from ..mechanism import Mechanism, Scalar, as_scalar


def _number_or_function(value):
    return value if callable(value) else as_scalar(value)


class Scenario(eqx.Module):
    """Prescribed screw speed and load over a time.

    Speed and load are numbers, or pure functions of time (an `eqx.Module` with a `__call__` keeps
    its numbers differentiable). A constant speed leaves all inertia but the carriers' untraced.

    Static: `samples`, and whether speed and load are functions.
    """

    #: Screw speed Ω [rad/s].
    speed: Scalar | Callable = eqx.field(converter=_number_or_function)
    #: Load on the last nut, against its motion at positive speed [N].
    load: Scalar | Callable = eqx.field(converter=_number_or_function)
    #: Length of the simulation [s].
    duration: Scalar = eqx.field(converter=as_scalar)
    #: Carrier ratio ω/Ω at the start, of every stage; 0 is a mechanism whose rollers stand still.
    initial_carrier_ratio: Scalar = eqx.field(converter=as_scalar, default=0.0)
    #: Number of equally spaced times in the result.
    samples: int = eqx.field(static=True, default=201)

    def __check_init__(self):
        if self.samples < 2:
            raise ValueError(f"samples is {self.samples}; a history needs at least 2")

    def speed_at(self, time: Scalar) -> Scalar:
        """Screw speed at a time [rad/s]."""
        return jnp.asarray(self.speed(time)) if callable(self.speed) else self.speed

    def motion_at(self, time: Scalar) -> tuple[Scalar, Scalar | None]:
        """Screw speed [rad/s] and, unless it is constant, its derivative [rad/s²]."""
        if not callable(self.speed):
            return self.speed, None
        return jax.jvp(self.speed_at, (time,), (jnp.ones_like(time),))

    def load_at(self, time: Scalar) -> Scalar:
        """Load at a time [N]."""
        return jnp.asarray(self.load(time)) if callable(self.load) else self.load


def default_scenario(mechanism: Mechanism) -> Scenario:
    """The scenario of a mechanism's operating point: a step of the speed from rollers at rest.

    **Raises:** `MissingDataError` if the operating point or its duration is not given.
    """
    point = mechanism.operating_point
    if point is None or point.duration is None:
        raise MissingDataError(
            "no scenario: pass one, or give [operating_point] with speed, load and duration"
        )
    return Scenario(point.speed, point.load, point.duration)
