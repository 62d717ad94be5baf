"""Scalar quantities of a transient for judging designs, differentiable by definition.

All are functions of the histories alone, so their derivatives follow from those of the histories.
None selects a sample by its index without correcting for the curve between the samples.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..._errors import UnknownNameError, closest
from ...fields import Scalar
from ...numerics import above_or_nan
from ...programs import mapped, one_program
from ._transient_result import Transient


@one_program
def peak(history: Float[Array, "*batch times"]) -> Float[Array, "*batch"]:
    """Largest value of a history: the vertex of the parabola through the largest sample.

    Exact for parabolas; otherwise its error is of third order in the sample distance, and that of
    the largest sample itself of second order. To that order, the peak and its derivatives do not
    jump where the largest sample changes to its neighbour. At either end of the history the peak is
    the sample. For the largest magnitude take the peak of `abs(history)`, for the minimum
    `-peak(-history)`.

    **Arguments:**

    - `history`: equally spaced samples, along the last axis.

    **Returns:** the peak, with one axis less.
    """
    count = history.shape[-1]
    if count < 3:
        return jnp.max(history, axis=-1)
    largest = jax.lax.stop_gradient(jnp.argmax(history, axis=-1))
    inside = (largest > 0) & (largest < count - 1)
    middle = jnp.clip(largest, 1, count - 2)

    def sample(offset: int):
        index = (middle + offset)[..., None]
        return jnp.take_along_axis(history, index, axis=-1)[..., 0]

    before, here, after = sample(-1), sample(0), sample(1)
    bend = before - 2 * here + after
    curved = inside & (bend < 0)
    rise = (after - before) ** 2 / (8 * jnp.where(curved, bend, -1.0))
    at_sample = jnp.take_along_axis(history, largest[..., None], axis=-1)[..., 0]
    return jnp.where(curved, here - rise, at_sample)


@one_program
def settling_time(
    time: Float[Array, "*#batch times"],
    history: Float[Array, "*batch times"],
    band: float | Scalar = 0.02,
    end: Float[Array, "*batch"] | None = None,
) -> tuple[Float[Array, "*batch"], Bool[Array, "*batch"]]:
    """Time from which a history stays within a band around its end value.

    The crossing into the band, `|x(t) − x_end| = band |x_end|`, lies between two samples. Between
    them the logarithm of the distance is a straight line, which is exact for an exponential
    approach, so the crossing is a smooth function of the samples: it moves with a parameter p by
    `−(∂x/∂p)/(∂x/∂t)`, as the implicit relation requires.

    **Arguments:**

    - `time`: sample times [s]; one row for all histories, or one for each.
    - `history`: samples, along the last axis.
    - `band`: half the width of the band, relative to the end value.
    - `end`: the end value; default the last sample.

    **Returns:** the time, and whether the history both leaves the band and returns to it; the time
    is the first sample's where it never leaves, the last where it never returns, and NaN where a
    sample is NaN.
    """
    final = history[..., -1] if end is None else end
    allowed = jnp.abs(band * final)[..., None]
    distance = jnp.abs(history - final[..., None])
    outside = jax.lax.stop_gradient(above_or_nan(distance, allowed))
    count = history.shape[-1]
    indices = jnp.arange(count)
    last = jnp.max(jnp.where(outside, indices, -1), axis=-1)
    crosses = (last >= 0) & (last < count - 1)
    index = jnp.clip(last, 0, count - 2)[..., None]

    def at(values, offset):
        return jnp.take_along_axis(values, index + offset, axis=-1)[..., 0]

    outer, inner, limit = at(distance, 0), at(distance, 1), allowed[..., 0]
    time = jnp.broadcast_to(time, history.shape)
    start, stop = at(time, 0), at(time, 1)
    # Only crossings have values with a logarithm. If the next sample is exactly at the end value, a
    # straight line is taken.
    decays = crosses & (inner > 0) & (limit > 0)
    high, low, between = (
        jnp.where(decays, value, other) for value, other in ((outer, 4), (inner, 1), (limit, 2))
    )
    fallen = jnp.where(crosses, outer - inner, 1.0)
    straight = jnp.where(crosses, outer - limit, 0.0) / fallen
    share = jnp.where(decays, jnp.log(high / between) / jnp.log(high / low), straight)
    end_time = jnp.where(last < 0, time[..., 0], time[..., -1])
    end_time = jnp.where(jnp.isnan(jnp.sum(distance, axis=-1)), jnp.nan, end_time)
    return jnp.where(crosses, start + share * (stop - start), end_time), crosses


@one_program
def integral(
    time: Float[Array, "*#batch times"], history: Float[Array, "*batch times"]
) -> Float[Array, "*batch"]:
    """Integral of a history over its time, by Simpson's rule.

    Fourth order, as the samples are, which must be equally spaced. Of an odd number of intervals,
    the last three take the 3/8 rule.

    **Arguments:**

    - `time`: sample times [s]; one row for all histories, or one for each.
    - `history`: samples, along the last axis.
    """
    intervals = history.shape[-1] - 1
    step = time[..., 1] - time[..., 0]
    if intervals == 1:
        return step * (history[..., 0] + history[..., 1]) / 2
    if intervals == 2:
        return step * (history[..., 0] + 4 * history[..., 1] + history[..., 2]) / 3
    even = intervals if intervals % 2 == 0 else intervals - 3
    total = jnp.zeros_like(history[..., 0])
    if even:
        part = history[..., : even + 1]
        ends, odd = part[..., 0] + part[..., -1], jnp.sum(part[..., 1::2], axis=-1)
        total = step * (ends + 4 * odd + 2 * jnp.sum(part[..., 2:-1:2], axis=-1)) / 3
    if even != intervals:
        four = history[..., even:]
        weights = jnp.asarray([3.0, 9.0, 9.0, 3.0], history.dtype) / 8
        total = total + step * (four @ weights)
    return total


@one_program
@mapped
def energy(run: Transient, of: str = "drive") -> Scalar:
    """Energy over the time of a transient [J].

    **Arguments:**

    - `run`: the transient.
    - `of`: `"drive"`, net input at the first screw; `"load"`, net output at the last nut; `"loss"`,
      all losses together; or the name of one of them (`run.losses`). The parts of the net energies
      are all positive: `"from_drive"` is what the drive supplies and `"to_drive"` what it takes
      back while it brakes, `"to_load"` is what the load takes and `"from_load"` what it gives back
      while it drives: `drive = from_drive − to_drive`, `load = to_load − from_load`.

    **Raises:** `UnknownNameError` for an unknown name.
    """
    return integral(run.time, _power(run, of))


#: Of which net power each direction is a part, and its sign in it.
_DIRECTIONS = {
    "from_drive": ("drive", 1.0),
    "to_drive": ("drive", -1.0),
    "to_load": ("load", 1.0),
    "from_load": ("load", -1.0),
}


def _power(run: Transient, of: str) -> Float[Array, " times"]:
    if of in _DIRECTIONS:
        net, sign = _DIRECTIONS[of]
        return jnp.maximum(sign * _power(run, net), 0.0)
    if of == "drive":
        return run.drive_torque * run.screw_speed
    if of == "load":
        assert run.load_power is not None
        return run.load_power
    if of == "loss":
        return sum(run.losses.values(), jnp.zeros_like(run.screw_speed))
    if of not in run.losses:
        names = ("drive", "load", "loss", *_DIRECTIONS, *run.losses)
        raise UnknownNameError(f"unknown energy {of!r}; {closest(of, names)}")
    return run.losses[of]


@one_program
@mapped
def mean_efficiency(run: Transient) -> Scalar:
    """Output energy over input energy of the whole transient.

    Drive and load may each supply and absorb power: what they supply is input, what they absorb is
    output, so that both directions count: `(to_load + to_drive) / (from_drive + from_load)`, the
    energies as `energy` names them. It is not the ratio of the net energies, `load / drive`,
    which is 0 where a load is lifted and lowered again. 0 without input.
    """
    supplied = _power(run, "from_drive") + _power(run, "from_load")
    absorbed = _power(run, "to_load") + _power(run, "to_drive")
    input_energy = integral(run.time, supplied)
    positive = above_or_nan(input_energy)
    return jnp.where(
        positive, integral(run.time, absorbed) / jnp.where(positive, input_energy, 1.0), 0.0
    )
