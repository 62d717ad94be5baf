"""Interpolated tables: of a drive over time, or of a load over position."""

from typing import Literal, TypeAlias

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .._guards import above_or_nan
from ._checked import check_increasing
from ._fields import Scalar

Interpolation: TypeAlias = Literal["linear", "cubic", "monotone"]
INTERPOLATIONS: tuple[Interpolation, ...] = ("linear", "cubic", "monotone")


class Curve(eqx.Module):
    """A piecewise curve through points, constant outside of them.

    `linear`; `cubic`, Hermite with the slopes of the parabolas through three neighbours; or
    `monotone`, Hermite with slopes that never overshoot (Fritsch and Butland 1984, known as PCHIP).
    The last two are smooth to the first derivative.
    """

    points: Float[Array, " points"]
    values: Float[Array, " points"]
    interpolation: Interpolation = eqx.field(static=True)

    def check(self, owner: str) -> None:
        """**Raises:** `ValueError` if the table makes no sense."""
        if self.interpolation not in INTERPOLATIONS:
            raise ValueError(
                f"{owner}: interpolation is {self.interpolation!r}; choose one of "
                f"{', '.join(INTERPOLATIONS)}"
            )
        if self.points.shape != self.values.shape:
            raise ValueError(
                f"{owner}: {self.points.shape[-1]} points have {self.values.shape[-1]} values; "
                "give as many of one as of the other"
            )
        check_increasing(owner, points=self.points)

    def _slopes(self) -> Float[Array, " points"]:
        steps = jnp.diff(self.points)
        chords = jnp.diff(self.values) / steps
        if len(self.points) == 2:
            return jnp.concatenate([chords, chords])
        before, after = steps[:-1], steps[1:]
        left, right = chords[:-1], chords[1:]
        if self.interpolation == "cubic":
            inner = (after * left + before * right) / (before + after)
        else:
            # A harmonic mean, 0 where the chords turn back.
            weight_left, weight_right = before + 2 * after, 2 * before + after
            same = above_or_nan(left * right)
            inverse = weight_left / jnp.where(same, left, 1.0) + weight_right / jnp.where(
                same, right, 1.0
            )
            inner = jnp.where(same, (weight_left + weight_right) / inverse, 0.0)
        first = self._end_slope(steps[0], steps[1], chords[0], chords[1])
        last = self._end_slope(steps[-1], steps[-2], chords[-1], chords[-2])
        return jnp.concatenate([first[None], inner, last[None]])

    def _end_slope(self, near, far, chord, next_chord):
        """That of the parabola through three points, which monotone curves limit."""
        slope = ((2 * near + far) * chord - near * next_chord) / (near + far)
        if self.interpolation == "cubic":
            return slope
        slope = jnp.where(slope * chord <= 0, 0.0, slope)
        steep = (chord * next_chord <= 0) & (jnp.abs(slope) > 3 * jnp.abs(chord))
        return jnp.where(steep, 3 * chord, slope)

    def _coefficients(self):
        """Of `y₀ + s (c₁ + s (c₂ + s c₃))` in every interval, s from its start."""
        steps = jnp.diff(self.points)
        chords = jnp.diff(self.values) / steps
        if self.interpolation == "linear":
            return chords, jnp.zeros_like(chords), jnp.zeros_like(chords)
        slopes = self._slopes()
        first, last = slopes[:-1], slopes[1:]
        second = (3 * chords - 2 * first - last) / steps
        return first, second, (first + last - 2 * chords) / steps**2

    def _interval(self, at: Scalar) -> Int[Array, ""]:
        # Few points: all comparisons at once.
        method = "compare_all" if len(self.points) <= 128 else "scan_unrolled"
        index = jnp.searchsorted(self.points, at, side="right", method=method) - 1
        return jnp.clip(index, 0, len(self.points) - 2)

    def __call__(self, at: Scalar) -> Scalar:
        """Value at a point."""
        index = self._interval(at)
        first, second, third = (c[index] for c in self._coefficients())
        since = at - self.points[index]
        inside = self.values[index] + since * (first + since * (second + since * third))
        after = jnp.where(at >= self.points[-1], self.values[-1], inside)
        return jnp.where(at < self.points[0], self.values[0], after)

    def integral(self, at: Scalar) -> Scalar:
        """Integral from 0 to a point, where no point lies below 0."""
        steps = jnp.diff(self.points)
        values, coefficients = self.values[:-1], self._coefficients()

        def from_start(since, value, first, second, third):
            return since * (value + since * (first / 2 + since * (second / 3 + since * third / 4)))

        whole = from_start(steps, values, *coefficients)
        before = jnp.cumsum(whole) - whole
        index = self._interval(at)
        since = jnp.clip(at, self.points[0], self.points[-1]) - self.points[index]
        inner = before[index] + from_start(since, values[index], *(c[index] for c in coefficients))
        early = jnp.minimum(at, self.points[0]) * self.values[0]
        late = jnp.maximum(at - self.points[-1], 0.0) * self.values[-1]
        return early + inner + late
