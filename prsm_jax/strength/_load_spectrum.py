"""Load spectrum: loads with the angle of rotation and the duration of each."""

from typing import Annotated, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from .._errors import MissingDataError
from ..fields import In, Scalar
from ..mechanism import DutyCycle, Mechanism
from ..numerics import above_or_nan
from ..results import Result, lines_of
from ..text import Line
from ._powers import positive_power


class LoadSpectrum(Result):
    """Phases of constant load and speed, in any order."""

    #: Axial load; its sign gives the flank [N].
    load: Annotated[Float[Array, " phases"], In("N")]
    #: Angle of the turning body (screw or nut) in each phase, sum of both directions [rad].
    turned_angle: Annotated[Float[Array, " phases"], In("rad")]
    #: [s]
    duration: Annotated[Float[Array, " phases"], In("s")]

    def lines(self) -> list[Line]:
        """What `print` shows."""
        turns = np.asarray(self.turned_angle) / (2 * np.pi)
        load, _, duration = lines_of(self)
        return [load, Line("revolutions", turns), duration]

    @property
    def possible(self) -> Bool[Array, ""]:
        """Whether the total duration is above 0, no duration is negative and no number is infinite.

        True with NaN, which shows in the values themselves.
        """
        infinite = jnp.isinf(self.load) | jnp.isinf(self.turned_angle) | jnp.isinf(self.duration)
        short = jnp.any(self.duration < 0) | (jnp.sum(self.duration) <= 0)
        return jnp.logical_not(short | jnp.any(infinite))

    @property
    def weights(self) -> Float[Array, " phases"]:
        """Share of each phase in the total angle; in the total time if nothing ever turns."""
        total = jnp.sum(self.turned_angle)
        turns = above_or_nan(total)
        denominator = jnp.where(turns, total, jnp.sum(self.duration))
        return jnp.where(turns, self.turned_angle, self.duration) / denominator

    @property
    def revolutions(self) -> Scalar:
        """Total revolutions in all phases."""
        return jnp.sum(self.turned_angle) / (2 * jnp.pi)

    @property
    def mean_speed(self) -> Scalar:
        """Equivalent speed, the mean magnitude over all time, standstill included [rad/s]."""
        return jnp.sum(self.turned_angle) / jnp.sum(self.duration)

    @property
    def phase_speed(self) -> Float[Array, " phases"]:
        """Magnitude of the speed in each phase [rad/s]; 0 in a phase without duration."""
        lasts = above_or_nan(self.duration)
        return jnp.where(lasts, self.turned_angle, 0.0) / jnp.where(lasts, self.duration, 1.0)


@runtime_checkable
class History(Protocol):
    """Attributes used of a history: equally spaced times, speed, and load on the last nut."""

    @property
    def time(self) -> Float[Array, " times"]: ...

    @property
    def screw_speed(self) -> Float[Array, " times"]: ...

    @property
    def load(self) -> Float[Array, " times"]: ...


def load_spectrum(source: DutyCycle | History) -> LoadSpectrum:
    """The load spectrum of a duty cycle, or of a transient.

    Samples of a transient become phases, weighted by the trapezoidal rule, so they can be used like
    a duty cycle; the error falls with the square of the distance between samples, reversals
    included.

    **Arguments:**

    - `source`: a duty cycle; or an object with the histories `time` [s], `screw_speed` [rad/s] and
      `load` [N], such as a `Transient`.
    """
    if isinstance(source, DutyCycle):
        return LoadSpectrum(source.load, jnp.abs(source.speed) * source.duration, source.duration)
    steps = jnp.diff(source.time)
    zero = jnp.zeros_like(steps[:1])
    weights = (jnp.concatenate([steps, zero]) + jnp.concatenate([zero, steps])) / 2
    return LoadSpectrum(source.load, jnp.abs(source.screw_speed) * weights, weights)


def spectrum_of(mechanism: Mechanism) -> LoadSpectrum:
    """Load spectrum of a mechanism: its duty cycle, or else its operating point.

    **Raises:** `MissingDataError` if there is neither.
    """
    if mechanism.duty_cycle is not None:
        return load_spectrum(mechanism.duty_cycle)
    point = mechanism.operating_point
    if point is None:
        raise MissingDataError(
            "the mechanism has neither duty cycle nor operating point; give [[duty_cycle]] phases "
            "or [operating_point]"
        )
    return constant_load(point.speed, point.load)


def largest_demand(mechanism: Mechanism, spectrum: LoadSpectrum) -> tuple[Scalar, Scalar]:
    """Largest magnitudes of speed and load, of a spectrum and the operating point [rad/s, N]."""
    speed, load = jnp.max(spectrum.phase_speed), jnp.max(jnp.abs(spectrum.load))
    point = mechanism.operating_point
    if point is None:
        return speed, load
    return jnp.maximum(speed, jnp.abs(point.speed)), jnp.maximum(load, jnp.abs(point.load))


def constant_load(speed: Scalar, load: Scalar) -> LoadSpectrum:
    """The spectrum of one operating point [rad/s, N]."""
    return LoadSpectrum(load[None], jnp.abs(speed)[None], jnp.ones_like(load)[None])


def mean_load(
    load: Float[Array, " phases"], weights: Float[Array, " phases"], exponent: float = 3.0
) -> Scalar:
    """Power mean of loads that are not negative [N]; 0 without load."""
    # In shares of the largest load, so that no power leaves the range of numbers; the scale
    # cancels.
    largest = jax.lax.stop_gradient(jnp.max(load))
    scale = jnp.where(largest > 0, largest, 1.0)
    mean = jnp.sum(weights * positive_power(load / scale, exponent))
    return scale * positive_power(mean, 1 / exponent)


def equivalent_load(spectrum: LoadSpectrum | DutyCycle | History) -> Scalar:
    r"""Equivalent load $F_m = (\sum F_i^3 \varphi_i / \sum \varphi_i)^{1/3}$ [N].

    The constant load with the same fatigue of point contacts over the same turning (ISO 3408-5,
    7.1, and ISO 281 for bearings). Signs are ignored; only `rating_life` distinguishes loads on
    opposite flanks.

    **Arguments:**

    - `spectrum`: a load spectrum, a duty cycle or a transient.
    """
    if not isinstance(spectrum, LoadSpectrum):
        spectrum = load_spectrum(spectrum)
    return mean_load(jnp.abs(spectrum.load), spectrum.weights)
