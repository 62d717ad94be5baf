"""Scenario of a simulation: drive of the first screw, and load on the nut.

Speed, torque and load are numbers, or pure functions (an `eqx.Module` with a `__call__` keeps its
numbers differentiable): the profiles of `_profiles` and `_sequences`, the loads of `_loads`, or any
other. Those read from a file can be written to a file.
"""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import (
    ANY,
    MANY,
    POSITIVE,
    SAMPLES,
    Limited,
    Number,
    Scalar,
    check_fields,
    choice,
    driven,
    number,
)
from ._loads import DrivenLoad, break_times_of, check_function, load_value, value_at
from ._sequences import Driven


def check_scenario(scenario: "Scenario | TorqueScenario") -> None:
    """Refuse an invalid scenario; traced numbers, and values of functions, are not checked.

    **Arguments:**

    - `scenario`: the scenario.

    **Raises:** `ValueError` for a duration that is not above 0, for NaN or infinite numbers, and
    for a function with another number of arguments.
    """
    check_fields(scenario, to_come=False)
    kind = type(scenario).__name__
    drive = "speed" if isinstance(scenario, Scenario) else "torque"
    check_function(f"{kind}: {drive}", getattr(scenario, drive), of_motion=False)
    check_function(f"{kind}: load", scenario.load, of_motion=True)


def _needs_motion():
    raise ValueError(
        "the load depends on the motion of the nut, so it is known only with a mechanism; "
        "simulate the scenario, or bind it with prsm_jax.dynamics.bound_scenario first"
    )


class Scenario(Limited):
    """Prescribed screw speed and load over time.

    Speed is a number or a function of time. Load is a number, a function of time, or a function of
    time, position, speed and acceleration of the nut. With a constant speed no inertia except that
    of the carriers is traced.

    Static: `samples`, and whether speed and load are functions.
    """

    to_come: ClassVar[bool] = False
    #: Speed Ω of the body that turns, screw or nut [rad/s].
    speed: Driven = driven("rad/s", "speed of the body that turns")
    #: Load on the last nut, against its motion at positive speed [N].
    load: DrivenLoad = driven("N", "load on the last nut")
    #: Length of the simulation [s].
    duration: Number = number("s", "length of the simulation", limit=POSITIVE)
    #: Carrier ratio ω/Ω at the start, of every stage; 0 if the rollers do not orbit.
    initial_carrier_ratio: Number = number("1", "carrier ratio at the start", default=0.0)
    #: Number of equally spaced times in the result.
    samples: int = choice("number of times in the result", default=201, limit=SAMPLES)
    #: Position of the nut at the start [m].
    initial_position: Number = number(
        "m", "position of the nut at the start", default=0.0, limit=ANY
    )

    def speed_at(self, time: Scalar) -> Scalar:
        """Screw speed at a time [rad/s]."""
        return value_at(self.speed, time)

    def motion_at(self, time: Scalar) -> tuple[Scalar, Scalar | None]:
        """Screw speed [rad/s] and, unless it is constant, its derivative [rad/s²]."""
        if not callable(self.speed):
            return self.speed, None
        return jax.jvp(self.speed_at, (time,), (jnp.ones_like(time),))

    def load_at(self, time: Scalar) -> Scalar:
        """Load at a time [N]."""
        return load_value(self.load, time, _needs_motion)

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """Times at which speed or load have a jump or a kink, in order, none after the end [s]."""
        return _breaks(self.duration, self.speed, self.load)


class TorqueScenario(Limited):
    """Prescribed torque at the first screw, or the nut that turns, and load on the last nut.

    Static: `samples`, `most_phases`, and whether torque is a function.
    """

    to_come: ClassVar[bool] = False
    #: Torque at the body that turns: a number, or a pure function of time [N·m].
    torque: Driven = driven("N·m", "torque at the body that turns")
    #: Load on the last nut [N]: a number, a function of time, or one of time, position, speed and
    #: acceleration of the nut, such as a `HingeLoad`.
    load: DrivenLoad = driven("N", "load on the last nut")
    #: [s]
    duration: Number = number("s", "length of the simulation", limit=POSITIVE)
    #: Speed of the body that turns at the start [rad/s]. The carriers start in the ratio in which
    #: they settle with this motion. If they do not settle, because the body is braked harder than
    #: friction in the threads can brake them, they start in the ratio of rolling.
    initial_speed: Number = number(
        "rad/s", "speed of the body that turns at the start", default=0.0
    )
    #: Position of the nut at the start [m].
    initial_position: Number = number(
        "m", "position of the nut at the start", default=0.0, limit=ANY
    )
    samples: int = choice("number of times in the result", default=201, limit=SAMPLES)
    #: Maximum number of phases of stick or slip; exceeding it is reported.
    most_phases: int = choice("maximum number of phases of stick or slip", default=32, limit=MANY)

    def torque_at(self, time: Scalar) -> Scalar:
        """Torque at a time [N·m]."""
        return value_at(self.torque, time)

    def load_at(
        self, time: Scalar, position: Scalar, speed: Scalar, acceleration: Scalar
    ) -> Scalar:
        """Load at a time, position [m], speed [m/s] and acceleration [m/s²] of the nut [N]."""
        return load_value(self.load, time, lambda: (position, speed, acceleration))

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """Times at which torque or load have a jump or a kink, in order, none after the end [s]."""
        return _breaks(self.duration, self.torque, self.load)


def _breaks(duration: Scalar, *functions) -> Float[Array, " breaks"]:
    times = [break_times_of(function, duration.dtype) for function in functions]
    return jnp.minimum(jnp.sort(jnp.concatenate(times)), duration)
