"""Tables over time, and sequences of profiles: repeated, and turned round at every repetition."""

from typing import ClassVar, TypeAlias

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ._fields import Scalar, choice, numbers
from ._profiles import (
    ConstantProfile,
    SCurveMoveProfile,
    SineProfile,
    TrapezoidalMoveProfile,
    TrapezoidalProfile,
)
from ._tables import Curve, Interpolation


class TableProfile(eqx.Module):
    """A table over time, interpolated; its first and last value outside of it."""

    kind: ClassVar[str] = "table"
    times: Float[Array, " points"] = numbers("s", "times, from 0 on, that increase")
    values: Float[Array, " points"] = numbers("*", "values at these times")
    interpolation: Interpolation = choice("between the points", default="linear")

    def __check_init__(self):
        self._curve().check("TableProfile")

    def _curve(self) -> Curve:
        return Curve(self.times, self.values, self.interpolation)

    def __call__(self, time: Scalar) -> Scalar:
        return self._curve()(time)

    def angle(self, time: Scalar) -> Scalar:
        """Integral from 0 to a time."""
        return self._curve().integral(time)

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """The times of the table [s]."""
        return self.times

    @property
    def duration(self) -> Scalar:
        """The last time of the table [s]."""
        return self.times[-1]


class SequenceProfile(eqx.Module):
    """Parts one after the other, all of that several times, if asked in turn forth and back.

    After its end it goes on as its last part does. Static: how many parts, `repeats`, `reversing`.
    """

    kind: ClassVar[str] = "sequence"
    part: tuple["PartProfile", ...] = eqx.field(converter=tuple)
    repeats: int = choice("how often the parts are run through", default=1)
    reversing: bool = choice("whether every second time has the opposite sign", default=False)

    def __check_init__(self):
        if not self.part:
            raise ValueError("SequenceProfile: part is empty; give at least one profile")
        for part in self.part:
            if not hasattr(part, "duration"):
                raise ValueError(
                    f"SequenceProfile: a {type(part).__name__} has no end, so nothing can follow "
                    "it; give a table or a profile that has one"
                )
        if self.repeats < 1:
            raise ValueError(f"SequenceProfile: repeats is {self.repeats}; it must be 1 or more")

    def _ends(self) -> list[Scalar]:
        ends, end = [], jnp.zeros_like(self.part[0].duration)
        for part in self.part:
            end = end + part.duration
            ends.append(end)
        return ends

    @property
    def duration(self) -> Scalar:
        """Length of all repetitions [s]."""
        return self.repeats * self._ends()[-1]

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """Those of all parts in all repetitions [s]."""
        ends = self._ends()
        starts = [jnp.zeros_like(ends[0]), *ends[:-1]]
        once = [s + part.break_times for s, part in zip(starts, self.part, strict=True)]
        once = jnp.concatenate([*once, jnp.stack(ends)])
        cycles = jnp.arange(self.repeats, dtype=once.dtype) * ends[-1]
        return (cycles[:, None] + once[None, :]).reshape(-1)

    def _place(self, time: Scalar):
        """Which repetition, its sign, time in it, and the ends of the parts."""
        ends = self._ends()
        if self.repeats == 1:
            return jnp.zeros_like(time), jnp.ones_like(time), time, ends
        cycle = jnp.floor(time / ends[-1])
        # A quotient that is rounded down would leave the end of a repetition to nobody.
        cycle = jnp.where(time - cycle * ends[-1] >= ends[-1], cycle + 1, cycle)
        cycle = jnp.clip(cycle, 0, self.repeats - 1)
        sign = 1 - 2 * jnp.mod(cycle, 2) if self.reversing else jnp.ones_like(time)
        # Rounding must not put the start of a repetition before its first part.
        since = time - cycle * ends[-1]
        return cycle, sign, jnp.where(cycle > 0, jnp.maximum(since, 0.0), since), ends

    def __call__(self, time: Scalar) -> Scalar:
        _, sign, since, ends = self._place(time)
        value = self.part[-1](since - (ends[-2] if len(ends) > 1 else 0.0))
        for index in reversed(range(len(ends) - 1)):
            start = ends[index - 1] if index > 0 else 0.0
            value = jnp.where(since < ends[index], self.part[index](since - start), value)
        return sign * value

    def angle(self, time: Scalar) -> Scalar:
        """Integral from 0 to a time."""
        cycle, sign, since, ends = self._place(time)
        once = jnp.zeros_like(time)
        for part in self.part:
            once = once + part.angle(part.duration)
        done = jnp.mod(cycle, 2) * once if self.reversing else cycle * once
        inner, start = jnp.zeros_like(time), jnp.zeros_like(time)
        for index, part in enumerate(self.part):
            own = jnp.maximum(since - start, 0.0)
            if index < len(self.part) - 1:
                own = jnp.minimum(own, part.duration)
            inner, start = inner + part.angle(own), ends[index]
        return done + sign * inner


PartProfile: TypeAlias = (
    ConstantProfile
    | TrapezoidalProfile
    | TrapezoidalMoveProfile
    | SCurveMoveProfile
    | TableProfile
    | SequenceProfile
)
Profile: TypeAlias = SineProfile | PartProfile
#: Profiles by the name of their kind.
PROFILES: dict[str, type[eqx.Module]] = {
    cls.kind: cls
    for cls in (
        SineProfile,
        ConstantProfile,
        TrapezoidalProfile,
        TrapezoidalMoveProfile,
        SCurveMoveProfile,
        TableProfile,
        SequenceProfile,
    )
}
