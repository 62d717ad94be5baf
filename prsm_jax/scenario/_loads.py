"""Loads on the last nut that depend on its position and motion.

A load is called with time [s], position [m], speed [m/s] and acceleration [m/s²] of the nut, and
returns the force against positive travel, i.e. the travel at positive screw speed [N]. Functions of
time alone and plain numbers are loads, too: `load_value` accepts them all.
"""

import inspect
from collections.abc import Callable
from typing import ClassVar, TypeAlias, get_args

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import (
    ANY,
    NOT_NEGATIVE,
    POSITIVE,
    Limited,
    Scalar,
    as_scalar,
    choice,
    driven,
    number,
    numbers,
)
from ._sequences import Profile
from ._tables import Curve, Interpolation


class HingeLoad(Limited):
    """Load of a driven structure: constant, spring, damper and mass at the last nut.

    `F = constant + stiffness z + damping ż + mass z̈`.
    """

    kind: ClassVar[str] = "hinge"
    constant: Scalar = number("N", "load at rest at position 0", default=0.0)
    stiffness: Scalar = number("N/m", "stiffness of the spring", default=0.0, limit=ANY)
    damping: Scalar = number("N·s/m", "damping", default=0.0, limit=ANY)
    mass: Scalar = number("kg", "mass that moves with the nut", default=0.0, limit=NOT_NEGATIVE)

    def __call__(
        self, time: Scalar, position: Scalar, speed: Scalar, acceleration: Scalar
    ) -> Scalar:
        """Load at a time, position [m], speed [m/s] and acceleration [m/s²] of the nut [N]."""
        static_load = self.constant + self.stiffness * position
        return static_load + self.damping * speed + self.mass * acceleration


class AerodynamicLoad(Limited):
    """A surface in a flow, such as a rudder driven through a horn.

    `F = constant + q̄ (k z + c ż) + c₂ ż |ż| + mass z̈`, with the dynamic pressure q̄ a number or a
    function of time: the hinge moment grows with the deflection and with the flow.
    """

    kind: ClassVar[str] = "aerodynamic"
    stiffness_per_pressure: Scalar = number("m", "force per deflection and pressure, k", limit=ANY)
    dynamic_pressure: Scalar | Profile | Callable = driven("Pa", "dynamic pressure of the flow, q̄")
    constant: Scalar = number("N", "load at rest at position 0", default=0.0)
    damping_per_pressure: Scalar = number("m·s", "force per speed and pressure, c", default=0.0)
    quadratic_damping: Scalar = number("N·s²/m²", "force per speed squared, c₂", default=0.0)
    mass: Scalar = number("kg", "mass that moves with the nut", default=0.0, limit=NOT_NEGATIVE)

    def __call__(
        self, time: Scalar, position: Scalar, speed: Scalar, acceleration: Scalar
    ) -> Scalar:
        """Load at a time, position [m], speed [m/s] and acceleration [m/s²] of the nut [N]."""
        pressure = self.dynamic_pressure
        pressure = pressure(time) if callable(pressure) else pressure
        streaming = self.stiffness_per_pressure * position + self.damping_per_pressure * speed
        force = self.constant + pressure * streaming
        return force + self.quadratic_damping * speed * jnp.abs(speed) + self.mass * acceleration

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """Break times of the dynamic pressure [s]."""
        return break_times_of(self.dynamic_pressure, self.constant.dtype)


class PositionTableLoad(Limited):
    """A table over the position of the nut, interpolated; constant outside of it."""

    kind: ClassVar[str] = "position_table"
    positions: Float[Array, " points"] = numbers(
        "m", "increasing positions of the nut", limit=ANY, least=2, increasing=True
    )
    values: Float[Array, " points"] = numbers(
        "N", "loads at these positions", least=2, length="positions"
    )
    interpolation: Interpolation = choice("between the points", default="linear")

    def _curve(self) -> Curve:
        return Curve(self.positions, self.values, self.interpolation)

    def __call__(
        self, time: Scalar, position: Scalar, speed: Scalar, acceleration: Scalar
    ) -> Scalar:
        """Load at a position [N]."""
        return self._curve()(position)


class FrictionLoad(Limited):
    """Friction of a guide: `F = force ż / √(ż² + width²)`."""

    kind: ClassVar[str] = "friction"
    force: Scalar = number("N", "friction force of the guide", limit=NOT_NEGATIVE)
    width: Scalar = number("m/s", "speed over which the force changes its sign", limit=POSITIVE)

    def __call__(
        self, time: Scalar, position: Scalar, speed: Scalar, acceleration: Scalar
    ) -> Scalar:
        """Load at a speed [N]."""
        return self.force * speed / jnp.sqrt(speed**2 + self.width**2)


class SumLoad(Limited):
    """Sum of several loads: loads of motion, functions of time and numbers."""

    kind: ClassVar[str] = "sum"
    part: tuple["PartLoad | Callable", ...] = eqx.field(
        converter=lambda parts: tuple(p if callable(p) else as_scalar(p) for p in parts)
    )

    def __check_init__(self):
        if not self.part:
            raise ValueError("SumLoad: part is empty; give at least one load")

    def __call__(
        self, time: Scalar, position: Scalar, speed: Scalar, acceleration: Scalar
    ) -> Scalar:
        """Sum of all parts [N]."""
        total = jnp.zeros_like(time)
        for part in self.part:
            total = total + load_value(part, time, lambda: (position, speed, acceleration))
        return total

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """Break times of all parts [s]."""
        dtype = jnp.result_type(float)
        return jnp.concatenate([break_times_of(part, dtype) for part in self.part])


LoadOfMotion: TypeAlias = HingeLoad | AerodynamicLoad | PositionTableLoad | FrictionLoad | SumLoad
PartLoad: TypeAlias = Scalar | Profile | LoadOfMotion


def depends_on_motion(load) -> bool:
    """Whether a load is a function of the nut's motion, and not of time alone."""
    if isinstance(load, SumLoad):
        return any(map(depends_on_motion, load.part))
    if not callable(load):
        return False
    try:
        parameters = inspect.signature(load).parameters.values()
    except ValueError:
        return False
    positional = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return sum(p.default is p.empty and p.kind in positional for p in parameters) > 1


def load_value(load, time: Scalar, motion: Callable[[], tuple[Scalar, Scalar, Scalar]]) -> Scalar:
    """Load at an instant [N].

    **Arguments:**

    - `load`: a number, a function of time, or one of time, position, speed and acceleration.
    - `time`: [s].
    - `motion`: returns position, speed and acceleration of the nut; called only if needed.
    """
    if not callable(load):
        return jnp.asarray(load, time.dtype)
    if depends_on_motion(load):
        return jnp.asarray(load(time, *motion()), time.dtype)
    return jnp.asarray(load(time), time.dtype)


def break_times_of(function, dtype) -> Float[Array, " breaks"]:
    """Times at which a number or function has a jump or a kink, from its `break_times` [s]."""
    times = getattr(function, "break_times", None)
    return jnp.zeros(0, dtype) if times is None else jnp.asarray(times, dtype)


#: Loads of motion by the name of their kind.
LOADS_OF_MOTION: dict[str, type[eqx.Module]] = {cls.kind: cls for cls in get_args(LoadOfMotion)}
