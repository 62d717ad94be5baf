"""Rating life: in revolutions of the body that turns, with loads on one or both flanks."""

from typing import Annotated

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import In, Scalar
from ..mechanism import Stage, of_one_design
from ..numerics import above_or_nan
from ..programs import physics
from ..results import Result
from ._contacts import preload_of
from ._fatigue import WEIBULL_SLOPE
from ._load_spectrum import LoadSpectrum, mean_load
from ._powers import positive_power, ratio_or_infinity, scaled_unless_infinite
from ._preload import flank_loads
from ._truncation import TruncatedFatigue


class RatingLife(Result):
    """Basic rating life of one stage, for a survival of 90 %; ∞ without load."""

    #: Revolutions of the body that turns.
    revolutions: Annotated[Scalar, In("1")]
    #: Operating time, standstill included [s].
    time: Annotated[Scalar, In("s")]
    #: Travel of the nut, the sum of both directions [m].
    distance: Annotated[Scalar, In("m")]


def basic_life(capacity: Scalar, load: Scalar) -> Scalar:
    """Revolutions L10 = 10⁶ (C_a/F)³; ∞ without load (ISO 3408-5, ISO 281).

    A load so small that the life exceeds the range of numbers counts as no load.
    """
    smallest = jnp.finfo(capacity.dtype).tiny ** 0.25
    share = jnp.abs(load) / capacity
    loaded = above_or_nan(share, smallest)
    return jnp.where(loaded, 1e6 * jnp.where(loaded, share, 1.0) ** -3, jnp.inf)


@of_one_design
@physics("rating_life")
def rating_life(
    stage: Stage,
    capacity: Scalar | None,
    spectrum: LoadSpectrum,
    fatigue: TruncatedFatigue | None = None,
) -> RatingLife:
    r"""Basic rating life under a load spectrum.

    Loads of opposite sign act on opposite flanks. With the cubic mean loads $F_{m\pm}$ of both over
    all revolutions, $L_\pm = 10^6 (C_a/F_{m\pm})^3$ and $L^{-10/9} = L_+^{-10/9} + L_-^{-10/9}$, as
    ISO 3408-5 combines the two directions of a ball screw; a preload loads both at all times. Loads
    of one sign on a nut without preload give $10^6 (C_a/F_m)^3$.

    Range: that of the capacity; loads below about half of it. Without load the life is ∞ by
    definition, with derivatives of 0.

    **Arguments:**

    - `stage`: the stage: its lead, and its preload if there is one.
    - `capacity`: C_a [N]. Only for the cubic law; `None` with `fatigue`, from which it follows.
    - `spectrum`: the loads.
    - `fatigue`: `truncated_fatigue` of the stage: each load is weighted by the truncation that it
      causes. Without it the life follows the cubic law.

    **Raises:** `ValueError` with neither capacity nor fatigue.
    """
    capacity, loads = _by_flank(stage, capacity, spectrum, fatigue)
    means = [mean_load(load, spectrum.weights) for load in loads]
    # Σ L^{−10/9} of both is a sum of 10/3 powers of their loads.
    both = mean_load(jnp.stack(means), jnp.ones_like(jnp.stack(means)), 3 * WEIBULL_SLOPE)
    revolutions = basic_life(capacity, both)
    seconds_per_turn = ratio_or_infinity(2 * jnp.pi * jnp.ones_like(both), spectrum.mean_speed)
    still = jnp.isinf(seconds_per_turn)
    time = scaled_unless_infinite(revolutions, jnp.where(still, 1.0, seconds_per_turn))
    return RatingLife(
        revolutions=revolutions,
        time=jnp.where(still, jnp.inf, time),
        distance=scaled_unless_infinite(revolutions, stage.thread.ideal_travel),
    )


def modified_life(
    life: Float[Array, "*stages"], factor: Float[Array, "*stages"]
) -> Float[Array, "*stages"]:
    """A life times `life_factor`, or times 1 over a required time; ∞ stays ∞."""
    return scaled_unless_infinite(life, factor)


def largest_flank_load(stage: Stage, load: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """Load on the flanks that an axial load presses, preload included [N].

    **Arguments:**

    - `stage`: the stage, with its preload if there is one.
    - `load`: axial load, not negative [N].

    **Raises:** `MissingDataError` if the preload of a split nut is given by its offset only.
    """
    preload = preload_of(stage)
    return load if preload is None else flank_loads(load, preload)[0]


def _by_flank(
    stage: Stage, capacity: Scalar | None, spectrum: LoadSpectrum, fatigue: TruncatedFatigue | None
) -> tuple[Scalar, tuple[Float[Array, " phases"], Float[Array, " phases"]]]:
    """A capacity, and loads on either flank that are comparable with it by the cubic law [N].

    With ends of flanks these are the capacity and the loads of full ellipses: with g of
    `TruncatedFatigue.load_factor`, C_a g(C_a) is the capacity of full ellipses, so that
    C_a/F′ with F′ = F g(F)/g(C_a) is that capacity over F g(F), and C_a need not be known.
    """
    first, second = flank_loads(spectrum.load, preload_of(stage))
    if fatigue is not None:
        # Both in one call: half the program size.
        both = fatigue.equivalent_load(jnp.stack([first, second]))
        return fatigue.untruncated, (both[0], both[1])
    if capacity is None:
        raise ValueError(
            "capacity and fatigue are None; pass dynamic_capacity(stage), or "
            "truncated_fatigue(stage) where flanks end"
        )
    return capacity, (first, second)


@physics("damage")
def damage(
    stage: Stage,
    capacity: Scalar | None,
    spectrum: LoadSpectrum,
    fatigue: TruncatedFatigue | None = None,
) -> Float[Array, " phases"]:
    r"""Share of the basic rating life that each phase uses up (Palmgren 1924, Miner 1945).

    With the damage $D_{i\pm} = \varphi_i/2\pi\,(F_{i\pm}/C_a)^3/10^6$ of the flanks of either
    direction and the lives of `rating_life`,
    $D_i = D_{i+} (L/L_+)^{1/9} + D_{i-} (L/L_-)^{1/9}$. The sum over all phases is their
    revolutions over the life L; 1 is the end of the life. If loads press only one flank, the factor
    is 1.

    The factor is derived here: L is homogeneous in the damages of both flanks, so by Euler's
    theorem their derivatives divide it among the phases.

    **Arguments:**

    - `stage`: the stage, with its preload if there is one.
    - `capacity`, `fatigue`: as in `rating_life`.
    - `spectrum`: the loads.

    **Raises:** as in `rating_life`.
    """
    turns = spectrum.turned_angle / (2 * jnp.pi)
    capacity, loads = _by_flank(stage, capacity, spectrum, fatigue)
    flanks = [turns * (load / capacity) ** 3 / 1e6 for load in loads]
    sums = [jnp.sum(flank) for flank in flanks]
    # The damages are divided by the larger sum before powers are taken: they may be tiny.
    largest = jax.lax.stop_gradient(jnp.maximum(*sums))
    loaded = above_or_nan(largest)
    shares = [one / jnp.where(loaded, largest, 1.0) for one in sums]
    # At least 1, for one of the shares is 1. NaN of one flank is NaN here.
    powers = sum(positive_power(one, WEIBULL_SLOPE) for one in shares)
    both = jnp.where(loaded, powers, 1.0) ** (1 - 1 / WEIBULL_SLOPE)
    first, second = (
        positive_power(share, WEIBULL_SLOPE - 1) / both * flank
        for share, flank in zip(shares, flanks, strict=True)
    )
    return first + second
