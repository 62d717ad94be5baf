"""Interpolated tables: of a drive over time, or of a load over position."""

import functools
from typing import Literal, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap
from jaxtyping import Array, Float, Int

from ..fields import Scalar
from ..numerics import above_or_nan

Interpolation: TypeAlias = Literal["linear", "cubic", "monotone"]


@custom_vmap
def _place(points: Float[Array, " points"], at: Scalar) -> Int[Array, ""]:
    """Number of points not above a value; for one value an unrolled bisection is fastest."""
    return jnp.searchsorted(points, at, side="right", method="scan_unrolled")


@_place.def_vmap
def _places(axis_size, in_batched, points, at):
    # Unrolled, the steps of the bisection would be recomputed for each later step.
    del axis_size
    axes = tuple(0 if batched else None for batched in in_batched)
    search = functools.partial(jnp.searchsorted, side="right", method="scan")
    return jax.vmap(search, in_axes=axes)(points, at), True


class Curve(eqx.Module):
    """A piecewise curve through points, constant outside of them.

    `linear`; `cubic`, Hermite with the slopes of the parabolas through three neighbours; or
    `monotone`, Hermite with slopes that never overshoot (Fritsch and Butland 1984, known as PCHIP).
    The last two are smooth to the first derivative.
    """

    points: Float[Array, " points"]
    values: Float[Array, " points"]
    interpolation: Interpolation = eqx.field(static=True)

    def _steps_and_chords(self, index: Int[Array, "*places"]):
        """Lengths and mean slopes of intervals by their index."""
        # Only for the given intervals: a table may have a point for every second of a day.
        step = self.points[index + 1] - self.points[index]
        return step, (self.values[index + 1] - self.values[index]) / step

    def _slope(self, index: Int[Array, "*places"]) -> Float[Array, "*places"]:
        """Slopes of `cubic` and `monotone` at points by their index."""
        last = len(self.points) - 1
        ends = jnp.asarray([0, min(1, last - 1), last - 1, max(last - 2, 0)])
        steps, chords = self._steps_and_chords(ends)
        if last == 1:
            return jnp.broadcast_to(chords[0], index.shape)
        middle = jnp.clip(index, 1, last - 1)
        before, left = self._steps_and_chords(middle - 1)
        after, right = self._steps_and_chords(middle)
        if self.interpolation == "cubic":
            inner = (after * left + before * right) / (before + after)
        else:
            # A harmonic mean, 0 where the chords differ in sign.
            weight_left, weight_right = before + 2 * after, 2 * before + after
            same = above_or_nan(left * right)
            inverse = weight_left / jnp.where(same, left, 1.0) + weight_right / jnp.where(
                same, right, 1.0
            )
            inner = jnp.where(same, (weight_left + weight_right) / inverse, 0.0)
        first = self._end_slope(steps[0], steps[1], chords[0], chords[1])
        final = self._end_slope(steps[2], steps[3], chords[2], chords[3])
        return jnp.where(index == 0, first, jnp.where(index == last, final, inner))

    def _end_slope(self, near, far, chord, next_chord):
        """Slope of the parabola through three points, limited in monotone curves."""
        slope = ((2 * near + far) * chord - near * next_chord) / (near + far)
        if self.interpolation == "cubic":
            return slope
        slope = jnp.where(slope * chord <= 0, 0.0, slope)
        steep = (chord * next_chord <= 0) & (jnp.abs(slope) > 3 * jnp.abs(chord))
        return jnp.where(steep, 3 * chord, slope)

    def _coefficients(self, index: Int[Array, "*places"]):
        """Coefficients of `y₀ + s (c₁ + s (c₂ + s c₃))` in intervals by index, s from the start."""
        step, chord = self._steps_and_chords(index)
        if self.interpolation == "linear":
            return chord, jnp.zeros_like(chord), jnp.zeros_like(chord)
        first, last = self._slope(index), self._slope(index + 1)
        second = (3 * chord - 2 * first - last) / step
        return first, second, (first + last - 2 * chord) / step**2

    def _interval(self, at: Scalar) -> Int[Array, ""]:
        points, at = jax.lax.stop_gradient((self.points, at))
        # Few points: all comparisons at once.
        if len(self.points) <= 128:
            index = jnp.searchsorted(points, at, side="right", method="compare_all")
        else:
            index = _place(points, at)
        return jnp.clip(index - 1, 0, len(self.points) - 2)

    def __call__(self, at: Scalar) -> Scalar:
        """Value at a point."""
        index = self._interval(at)
        first, second, third = self._coefficients(index)
        since = at - self.points[index]
        inside = self.values[index] + since * (first + since * (second + since * third))
        after = jnp.where(at >= self.points[-1], self.values[-1], inside)
        return jnp.where(at < self.points[0], self.values[0], after)

    def integral(self, at: Scalar) -> Scalar:
        """Integral from 0 to a point; valid if no point lies below 0."""
        steps = jnp.diff(self.points)
        values, coefficients = self.values[:-1], self._coefficients(jnp.arange(len(steps)))

        def from_start(since, value, first, second, third):
            return since * (value + since * (first / 2 + since * (second / 3 + since * third / 4)))

        complete = from_start(steps, values, *coefficients)
        before = jnp.cumsum(complete) - complete
        index = self._interval(at)
        since = jnp.clip(at, self.points[0], self.points[-1]) - self.points[index]
        inner = before[index] + from_start(since, values[index], *self._coefficients(index))
        early = jnp.minimum(at, self.points[0]) * self.values[0]
        late = jnp.maximum(at - self.points[-1], 0.0) * self.values[-1]
        return early + inner + late
