"""Loads on the last nut that depend on its position and motion.

A load is called with time [s], position [m], speed [m/s] and acceleration [m/s²] of the nut, and
returns the force against positive travel, i.e. the travel at positive screw speed [N]. Functions of
time alone and plain numbers are loads, too: `load_value` accepts them all.
"""

import inspect
from collections.abc import Callable, Iterable
from typing import Any, ClassVar, TypeAlias

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, DTypeLike, Float

from ..fields import (
    ANY,
    NOT_NEGATIVE,
    POSITIVE,
    Converted,
    Limited,
    Number,
    Numbers,
    Scalar,
    as_scalar,
    choice,
    driven,
    number,
    numbers,
)
from ..numerics import with_batched_trigonometry
from ._sequences import Driven, Profile
from ._tables import Curve, Interpolation


class HingeLoad(Limited):
    """Load of a driven structure: constant, spring, damper and mass at the last nut.

    `F = constant + stiffness z + damping ż + mass z̈`.
    """

    kind: ClassVar[str] = "hinge"
    constant: Number = number("N", "load at rest at position 0", default=0.0)
    stiffness: Number = number("N/m", "stiffness of the spring", default=0.0, limit=ANY)
    damping: Number = number("N·s/m", "damping", default=0.0, limit=ANY)
    mass: Number = number("kg", "mass that moves with the nut", default=0.0, limit=NOT_NEGATIVE)

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
    stiffness_per_pressure: Number = number("m", "force per deflection and pressure, k", limit=ANY)
    dynamic_pressure: Driven = driven("Pa", "dynamic pressure of the flow, q̄")
    constant: Number = number("N", "load at rest at position 0", default=0.0)
    damping_per_pressure: Number = number("m·s", "force per speed and pressure, c", default=0.0)
    quadratic_damping: Number = number("N·s²/m²", "force per speed squared, c₂", default=0.0)
    mass: Number = number("kg", "mass that moves with the nut", default=0.0, limit=NOT_NEGATIVE)

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
    positions: Numbers = numbers(
        "m", "increasing positions of the nut", limit=ANY, least=2, increasing=True
    )
    values: Numbers = numbers("N", "loads at these positions", least=2, length="positions")
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
    force: Number = number("N", "friction force of the guide", limit=NOT_NEGATIVE)
    width: Number = number("m/s", "speed over which the force changes its sign", limit=POSITIVE)

    def __call__(
        self, time: Scalar, position: Scalar, speed: Scalar, acceleration: Scalar
    ) -> Scalar:
        """Load at a speed [N]."""
        return self.force * speed / jnp.sqrt(speed**2 + self.width**2)


def _parts(
    parts: Iterable[ArrayLike | Callable[..., Scalar]],
) -> tuple[Scalar | Callable[..., Scalar], ...]:
    return tuple(part if callable(part) else as_scalar(part) for part in parts)


class SumLoad(Limited):
    """Sum of several loads: loads of motion, functions of time and numbers."""

    kind: ClassVar[str] = "sum"
    part: tuple["PartLoad | Callable[..., Scalar]", ...] = eqx.field(converter=_parts)

    def __check_init__(self) -> None:
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
#: Field with a number, a function of time, or one of time and of the motion of the nut.
DrivenLoad: TypeAlias = Converted[
    Scalar | Profile | LoadOfMotion | Callable[..., Scalar], ArrayLike | Callable[..., Scalar]
]


def depends_on_motion(load: ArrayLike | Callable[..., Scalar]) -> bool:
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


def check_function(name: str, function: Any, *, of_motion: bool) -> None:
    """Refuse a function that takes another number of arguments than a scenario gives it.

    **Arguments:**

    - `name`: what it is called in the message.
    - `function`: a number, which passes, or a function.
    - `of_motion`: whether it may be a function of the motion of the nut.

    **Raises:** `ValueError`.
    """
    if isinstance(function, SumLoad):
        for part in function.part:
            check_function(name, part, of_motion=of_motion)
        return
    if not callable(function):
        return
    try:
        signature = inspect.signature(function)
    except ValueError:
        return
    load: Any = function
    given = 4 if of_motion and depends_on_motion(load) else 1
    try:
        signature.bind(*[None] * given)
    except TypeError:
        motion = ", or 4 (time, position, speed and acceleration of the nut)" if of_motion else ""
        words = ", ".join(signature.parameters) or "none"
        raise ValueError(
            f"{name} is a function with the arguments ({words}); it must take 1 (time){motion}"
        ) from None


def _number_at(value: ArrayLike, time: Scalar, what: str) -> Array:
    """What a function of the user returned, which must be one number at each time."""
    if np.ndim(value) > np.ndim(time):
        raise ValueError(
            f"the function for the {what} returns an array of shape {np.shape(value)}; it must "
            "return one number at each time"
        )
    return jnp.asarray(value)


def value_at(driven: Profile | Scalar | Callable[..., Scalar], time: Scalar) -> Scalar:
    """A number, or a function of time at a time [s]."""
    if not callable(driven):
        return driven
    return _number_at(with_batched_trigonometry(driven)(time), time, "speed or torque")


def load_value(
    load: ArrayLike | Callable[..., Scalar],
    time: Scalar,
    motion: Callable[[], tuple[Scalar, Scalar, Scalar]],
) -> Scalar:
    """Load at an instant [N].

    **Arguments:**

    - `load`: a number, a function of time, or one of time, position, speed and acceleration.
    - `time`: [s].
    - `motion`: returns position, speed and acceleration of the nut; called only if needed.
    """
    if not callable(load):
        return jnp.asarray(load, time.dtype)
    arguments = (time, *motion()) if depends_on_motion(load) else (time,)
    value = _number_at(with_batched_trigonometry(load)(*arguments), time, "load")
    return jnp.asarray(value, time.dtype)


def break_times_of(
    function: ArrayLike | Callable[..., Scalar], dtype: DTypeLike
) -> Float[Array, " breaks"]:
    """Times at which a number or function has a jump or a kink, from its `break_times` [s]."""
    times = getattr(function, "break_times", None)
    return jnp.zeros(0, dtype) if times is None else jnp.asarray(times, dtype)
