"""Functions of time that drive a mechanism: screw speed, torque or load.

All are pure functions whose numbers are differentiable; they have an integral in closed form (of a
speed: the angle), and the times at which they or their derivatives jump, so that an integrator can
step exactly to these. Derivatives at a jump are those after it.

A unit `*` in the metadata is that of the function: rad/s for a speed. A class whose values can have
one unit only gives it as `value_unit`.
"""

import abc
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import (
    ANY,
    NOT_NEGATIVE,
    NOT_ZERO,
    POSITIVE,
    Limited,
    Scalar,
    number,
    optional_number,
)


class SineProfile(Limited):
    """`mean + amplitude sin(2π f t + phase)`."""

    kind: ClassVar[str] = "sine"
    amplitude: Scalar = number("*", "amplitude", limit=ANY)
    frequency: Scalar = number("Hz", "frequency, f", limit=NOT_NEGATIVE)
    mean: Scalar = number("*", "mean value", default=0.0, limit=ANY)
    phase: Scalar = number("rad", "phase at the start", default=0.0)

    def _turned(self, time: Scalar) -> Scalar:
        return 2 * jnp.pi * self.frequency * time + self.phase

    def __call__(self, time: Scalar) -> Scalar:
        return self.mean + self.amplitude * jnp.sin(self._turned(time))

    def angle(self, time: Scalar) -> Scalar:
        """Integral from 0 to a time; without a frequency the function is constant."""
        turns = self.frequency != 0
        pulsation = 2 * jnp.pi * jnp.where(turns, self.frequency, 1.0)
        oscillating = (jnp.cos(self.phase) - jnp.cos(self._turned(time))) / pulsation
        oscillating = jnp.where(turns, oscillating, jnp.sin(self.phase) * time)
        return self.mean * time + self.amplitude * oscillating

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """None."""
        return jnp.zeros(0, self.mean.dtype)


class _Segments(eqx.Module):
    """Segments of constant jerk: length, and value, slope and curvature at the start."""

    length: Float[Array, " segments"]
    value: Float[Array, " segments"]
    slope: Float[Array, " segments"]
    curvature: Float[Array, " segments"]


def _limits(parts: _Segments) -> tuple[Float[Array, " segments"], Float[Array, " segments"]]:
    """Starts and ends of the segments; each begins exactly where the previous one ends."""
    ends = jnp.cumsum(parts.length)
    return jnp.concatenate([jnp.zeros_like(ends[:1]), ends[:-1]]), ends


class AbstractSegmentedProfile(Limited):
    """Segments of second-order polynomials in sequence; 0 after the last."""

    @abc.abstractmethod
    def _segments(self) -> _Segments:
        """The segments."""

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """Ends of all segments [s]."""
        return jnp.cumsum(self._segments().length)

    @property
    def duration(self) -> Scalar:
        """Total length of all segments [s]."""
        return jnp.sum(self._segments().length)

    def __call__(self, time: Scalar) -> Scalar:
        parts = self._segments()
        starts, ends = _limits(parts)
        since = time - starts
        here = (time < ends) & (time >= starts)
        value = parts.value + since * (parts.slope + since * parts.curvature / 2)
        # With a length that is NaN the time would be in no segment.
        return jnp.where(jnp.isnan(time + ends[-1]), jnp.nan, jnp.sum(jnp.where(here, value, 0.0)))

    def angle(self, time: Scalar) -> Scalar:
        """Integral from 0 to a time."""
        parts = self._segments()
        starts, ends = _limits(parts)
        since = time - starts
        since = jnp.where(since < 0, 0.0, jnp.where(time < ends, since, parts.length))
        turned = jnp.sum(
            since * (parts.value + since * (parts.slope / 2 + since * parts.curvature / 6))
        )
        return jnp.where(jnp.isnan(time + ends[-1]), jnp.nan, turned)


class ConstantProfile(AbstractSegmentedProfile):
    """One value for a given time: a part of a sequence."""

    kind: ClassVar[str] = "constant"
    value: Scalar = number("*", "value", limit=ANY)
    hold_time: Scalar = number("s", "duration of this value", limit=POSITIVE)

    def _segments(self) -> _Segments:
        one, zero = self.value[None], jnp.zeros_like(self.value)[None]
        return _Segments(self.hold_time[None], one, zero, zero)


class TrapezoidalProfile(AbstractSegmentedProfile):
    """Linear rise, plateau, linear fall, and a dwell at 0."""

    kind: ClassVar[str] = "trapezoidal"
    peak: Scalar = number("*", "value of the plateau", limit=ANY)
    rise_time: Scalar = number("s", "time from 0 to the plateau", limit=POSITIVE)
    hold_time: Scalar = number("s", "length of the plateau", limit=NOT_NEGATIVE)
    fall_time: Scalar | None = optional_number(
        "s", "time from the plateau to 0; equal to the rise time if not given", limit=POSITIVE
    )
    dwell_time: Scalar = number("s", "rest at 0 afterwards", default=0.0, limit=NOT_NEGATIVE)

    def _segments(self) -> _Segments:
        fall = self.rise_time if self.fall_time is None else self.fall_time
        return _trapezoid(self.peak, self.rise_time, self.hold_time, fall, self.dwell_time)


def _trapezoid(peak, rise, hold, fall, dwell) -> _Segments:
    zero = jnp.zeros_like(peak)
    return _Segments(
        length=jnp.stack([rise, hold, fall, dwell]),
        value=jnp.stack([zero, peak, peak, zero]),
        slope=jnp.stack([peak / rise, zero, -peak / fall, zero]),
        curvature=jnp.zeros_like(peak, shape=4),
    )


class TrapezoidalMoveProfile(AbstractSegmentedProfile):
    """The fastest move through an angle within limits of speed and acceleration.

    A short move does not reach the limit of speed: its profile is a triangle.
    """

    kind: ClassVar[str] = "trapezoidal_move"
    value_unit: ClassVar[str] = "rad/s"
    angle_moved: Scalar = number("rad", "angle of the move; negative backwards", limit=NOT_ZERO)
    speed_limit: Scalar = number("rad/s", "largest speed", limit=POSITIVE)
    acceleration_limit: Scalar = number("rad/s²", "largest acceleration", limit=POSITIVE)
    deceleration_limit: Scalar | None = optional_number(
        "rad/s²",
        "largest deceleration; equal to the acceleration if not given",
        limit=POSITIVE,
    )
    dwell_time: Scalar = number("s", "rest afterwards", default=0.0, limit=NOT_NEGATIVE)

    def _segments(self) -> _Segments:
        distance, up = jnp.abs(self.angle_moved), self.acceleration_limit
        down = up if self.deceleration_limit is None else self.deceleration_limit
        # Distance of acceleration and deceleration: v² (1/a + 1/d) / 2.
        slowness = (1 / up + 1 / down) / 2
        peak = jnp.minimum(self.speed_limit, jnp.sqrt(distance / slowness))
        hold = jnp.where(
            peak < self.speed_limit, 0.0, distance / self.speed_limit - peak * slowness
        )
        moved = jnp.sign(self.angle_moved) * peak
        return _trapezoid(moved, peak / up, hold, peak / down, self.dwell_time)


class SCurveMoveProfile(AbstractSegmentedProfile):
    """The fastest move through an angle within limits of speed, acceleration and jerk.

    Up to seven segments of constant jerk; some have length 0 in a short move that does not reach
    all limits (Biagiotti and Melchiorri 2008, section 3.4).
    """

    kind: ClassVar[str] = "s_curve_move"
    value_unit: ClassVar[str] = "rad/s"
    angle_moved: Scalar = number("rad", "angle of the move; negative backwards", limit=NOT_ZERO)
    speed_limit: Scalar = number("rad/s", "largest speed", limit=POSITIVE)
    acceleration_limit: Scalar = number("rad/s²", "largest acceleration", limit=POSITIVE)
    jerk_limit: Scalar = number("rad/s³", "largest jerk", limit=POSITIVE)
    dwell_time: Scalar = number("s", "rest afterwards", default=0.0, limit=NOT_NEGATIVE)

    def _segments(self) -> _Segments:
        distance, jerk = jnp.abs(self.angle_moved), self.jerk_limit
        # The limit that is reached first determines the length of each phase.
        bend = jnp.minimum(self.acceleration_limit / jerk, jnp.sqrt(self.speed_limit / jerk))
        bend = jnp.minimum(bend, jnp.cbrt(distance / (2 * jerk)))
        steepest = jerk * bend
        # Acceleration takes `ramp + 2 bend`; with deceleration, twice that covers the distance.
        by_distance = jnp.sqrt(bend**2 / 4 + distance / steepest) - 1.5 * bend
        ramp = jnp.minimum(self.speed_limit / steepest - bend, by_distance)
        ramp = jnp.maximum(ramp, 0.0)
        peak = steepest * (bend + ramp)
        hold = jnp.maximum(distance / peak - (2 * bend + ramp), 0.0)
        low, high, zero = steepest * bend / 2, peak - steepest * bend / 2, jnp.zeros_like(peak)
        sign = jnp.sign(self.angle_moved)
        return _Segments(
            length=jnp.stack([bend, ramp, bend, hold, bend, ramp, bend, self.dwell_time]),
            value=sign * jnp.stack([zero, low, high, peak, peak, high, low, zero]),
            slope=sign
            * jnp.stack([zero, steepest, steepest, zero, zero, -steepest, -steepest, zero]),
            curvature=sign * jnp.stack([jerk, zero, -jerk, zero, -jerk, zero, jerk, zero]),
        )
