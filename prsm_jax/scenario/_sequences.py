"""Tables over time, and sequences of profiles: repeated, optionally with alternating sign."""

from collections.abc import Callable
from typing import ClassVar, NamedTuple, TypeAlias

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, ArrayLike, Float

from ..fields import ANY, MANY, NOT_NEGATIVE, Converted, Limited, Numbers, Scalar, choice, numbers
from ._profiles import (
    ConstantProfile,
    SCurveMoveProfile,
    SineProfile,
    TrapezoidalMoveProfile,
    TrapezoidalProfile,
)
from ._tables import Curve, Interpolation

#: Maximum number of levels of nested sequences.
_DEEPEST = 16


class TableProfile(Limited):
    """A table over time, interpolated; outside of it the first or last value."""

    kind: ClassVar[str] = "table"
    times: Numbers = numbers(
        "s", "increasing times, from 0 on", limit=NOT_NEGATIVE, least=2, increasing=True
    )
    values: Numbers = numbers("*", "values at these times", limit=ANY, least=2, length="times")
    interpolation: Interpolation = choice("between the points", default="linear")

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


class SequenceProfile(Limited):
    """Parts in sequence, repeated, optionally with alternating sign.

    After its end it continues like its last part. Static: number of parts, `repeats`, `reversing`.
    """

    kind: ClassVar[str] = "sequence"
    part: tuple["PartProfile", ...] = eqx.field(converter=tuple)
    repeats: int = choice("number of times the parts are run through", default=1, limit=MANY)
    reversing: bool = choice("whether every second time has the opposite sign", default=False)

    def __check_init__(self) -> None:
        if not self.part:
            raise ValueError("SequenceProfile: part is empty; give at least one profile")
        for part in self.part:
            # Test the class: on the profile it would be computed here, again at every level.
            if not hasattr(type(part), "duration"):
                raise ValueError(
                    f"SequenceProfile: a {type(part).__name__} has no end, so nothing can follow "
                    "it; give a table or a profile that has one"
                )
        levels, repeats = self._nested()
        if levels > _DEEPEST:
            raise ValueError(
                f"SequenceProfile: sequences are nested {levels} levels deep; at most "
                f"{_DEEPEST} are allowed, so write inner ones out as parts"
            )
        if repeats > MANY.upper:
            raise ValueError(
                f"SequenceProfile: the innermost parts are run through {repeats} times; at most "
                f"{MANY.upper:.0f} are allowed"
            )

    def _nested(self) -> tuple[int, int]:
        """Levels of nested sequences, this one included; repeats of the innermost."""
        inner = [part._nested() for part in self.part if isinstance(part, SequenceProfile)]
        levels = max((levels for levels, _ in inner), default=0)
        return levels + 1, self.repeats * max((repeats for _, repeats in inner), default=1)

    def _laid_out(self) -> "_Layout":
        """Ends of all parts and nested parts, each computed once."""
        inner = tuple(
            part._laid_out() if isinstance(part, SequenceProfile) else None for part in self.part
        )
        ends: list[Scalar] = []
        for part, layout in zip(self.part, inner, strict=True):
            length = part.duration if layout is None else layout.duration
            ends.append(length if not ends else ends[-1] + length)
        starts = [jnp.zeros_like(ends[0]), *ends[:-1]]
        return _Layout(self.repeats * ends[-1], starts, ends, inner)

    @property
    def duration(self) -> Scalar:
        """Length of all repetitions [s]."""
        return self._laid_out().duration

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """Break times of all parts in all repetitions [s]."""
        return self._breaks(self._laid_out())

    def _breaks(self, layout: "_Layout") -> Float[Array, " breaks"]:
        ends = layout.ends
        once = []
        for part, start, inner in zip(self.part, layout.starts, layout.inner, strict=True):
            if isinstance(part, SequenceProfile) and inner is not None:
                once.append(start + part._breaks(inner))
            else:
                once.append(start + part.break_times)
        every = jnp.concatenate([*once, jnp.stack(ends)])
        cycles = jnp.arange(self.repeats, dtype=every.dtype) * ends[-1]
        return (cycles[:, None] + every[None, :]).reshape(-1)

    def _place(self, time: Scalar, ends: list[Scalar]):
        """Number of the repetition, its sign, and time in it."""
        if self.repeats == 1:
            return jnp.zeros_like(time), jnp.ones_like(time), time
        cycle = jnp.floor(time / ends[-1])
        # If the quotient were rounded down, the end of a repetition would belong to none.
        cycle = jnp.where(time - cycle * ends[-1] >= ends[-1], cycle + 1, cycle)
        cycle = jnp.clip(cycle, 0, self.repeats - 1)
        sign = 1 - 2 * jnp.mod(cycle, 2) if self.reversing else jnp.ones_like(time)
        # Rounding must not put the start of a repetition before its first part.
        since = time - cycle * ends[-1]
        return cycle, sign, jnp.where(cycle > 0, jnp.maximum(since, 0.0), since)

    def __call__(self, time: Scalar) -> Scalar:
        return self._value(time, self._laid_out())

    def _value(self, time: Scalar, layout: "_Layout") -> Scalar:
        _, sign, since = self._place(time, layout.ends)

        def of_part(index: int) -> Scalar:
            part, inner = self.part[index], layout.inner[index]
            own = since - layout.starts[index]
            if isinstance(part, SequenceProfile) and inner is not None:
                return part._value(own, inner)
            return part(own)

        value = of_part(len(self.part) - 1)
        for index in reversed(range(len(self.part) - 1)):
            value = jnp.where(since < layout.ends[index], of_part(index), value)
        return sign * value

    def angle(self, time: Scalar) -> Scalar:
        """Integral from 0 to a time."""
        return self._angles(time, self._laid_out())[0]

    def _angles(self, time: Scalar, layout: "_Layout") -> tuple[Scalar, Scalar]:
        """Integral from 0 to a time, and over all repetitions."""
        cycle, sign, since = self._place(time, layout.ends)
        once, inner = jnp.zeros_like(time), jnp.zeros_like(time)
        for index, (part, own) in enumerate(zip(self.part, layout.inner, strict=True)):
            length = part.duration if own is None else own.duration
            elapsed = jnp.maximum(since - layout.starts[index], 0.0)
            if index < len(self.part) - 1:
                elapsed = jnp.minimum(elapsed, length)
            if isinstance(part, SequenceProfile) and own is not None:
                reached, complete = part._angles(elapsed, own)
            else:
                reached, complete = part.angle(elapsed), part.angle(length)
            once, inner = once + complete, inner + reached
        done = jnp.mod(cycle, 2) * once if self.reversing else cycle * once
        cycles = self.repeats % 2 if self.reversing else self.repeats
        return done + sign * inner, cycles * once


class _Layout(NamedTuple):
    """Starts and ends of the parts of a sequence [s]; layouts of parts that are sequences."""

    duration: Scalar
    starts: list[Scalar]
    ends: list[Scalar]
    inner: tuple["_Layout | None", ...]


PartProfile: TypeAlias = (
    ConstantProfile
    | TrapezoidalProfile
    | TrapezoidalMoveProfile
    | SCurveMoveProfile
    | TableProfile
    | SequenceProfile
)
Profile: TypeAlias = SineProfile | PartProfile
#: Field with a number or a function of time.
Driven: TypeAlias = Converted[
    Scalar | Profile | Callable[..., Scalar], ArrayLike | Callable[..., Scalar]
]
