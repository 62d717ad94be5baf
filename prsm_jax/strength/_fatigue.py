r"""Rolling fatigue of the threads after Lundberg and Palmgren, and the dynamic capacity from it.

Of one track, with the stress τ₀ at the depth z₀, the half width a and the length l,

$$\ln(1/S) = K\,\tau_0^c\,a\,l\,z_0^{1-h}\,(u L)^e,\qquad c = 31/3,\ h = 7/3,\ e = 10/9,$$

after L million turns of u stress cycles each. With Hertz stresses this gives $L = (C/F)^3$. K is
that of Lundberg and Palmgren's ball bearings (see `_STEEL`). No standard exists for roller screws:
this is the theory behind ISO 281 and ISO 3408-5, applied to their tracks.
"""

import math

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._errors import MissingDataError
from ..contact import StageContact, axis_ratio_of, contact_frames, engaged_threads
from ..fields import Scalar
from ..geometry import Meshing
from ..mechanism import ContactMethod, Stage
from ..numerics import above_or_nan, apart
from ..programs import physics
from ._contacts import REFERENCE_LOAD, known_contact, strength_of, thread_share
from ._equivalent_balls import equivalent_ball_capacity
from ._load_spectrum import mean_load
from ._subsurface import orthogonal_shear
from ._truncation import SideOnset, ThreadShares, TruncatedFatigue, side_onsets

#: Exponents of stress, depth and life, and Weibull slope, of point contacts.
STRESS_EXPONENT, DEPTH_EXPONENT, WEIBULL_SLOPE = 31 / 3, 7 / 3, 10 / 9
#: ln(1/S) at the survival of 90 % that defines basic rating lives.
RATED = math.log(1 / 0.9)
#: K in GPa, mm and 10⁶ cycles: from Q_c = 98.1 (2f/(2f−1))^0.41 (1−γ)^1.39/(1+γ)^{1/3} γ^0.3 D^1.8
#: Z^{−1/3}, N and mm, of an inner ring with f = 0.52, γ = 0.2 and E = 206 GPa. Other rings (f 0.515
#: to 0.53, γ 0.05 to 0.3, inner and outer) agree in capacity within 4 %: their formula is fitted.
_STEEL = 7.945875e-6
#: Below this anisotropy log κ = −4/3 τ; the error is of third order.
_CIRCULAR = 1e-5
#: Exponent of the number of threads: risk ∝ z (F/z)^{10/3}, load ∝ risk^{−3/10}.
_THREADS_EXPONENT = 0.7


def _stressed(p0: Scalar, semi_axes_product: Scalar, rolling_ratio: Scalar) -> Scalar:
    """τ₀^c a z₀^{1−h} in GPa and mm."""
    across = jnp.sqrt(semi_axes_product / rolling_ratio)
    shear, depth = orthogonal_shear(p0, rolling_ratio * across, rolling_ratio)
    return (shear / 1e9) ** STRESS_EXPONENT * (across * 1e3) * (depth * 1e3) ** (1 - DEPTH_EXPONENT)


def _rolling_ratio(total: Scalar, rolling: Scalar, method: ContactMethod) -> Scalar:
    """Semi-axis along over semi-axis across the rolling direction, taken as a principal direction.

    In roller screws the principal directions lie within some 30° of it, which changes the capacity
    by a few per cent. log κ is odd in the difference of the gap's two coefficients, so contacts may
    vary through the circle.
    """
    slant = (2 * rolling - total) / total
    small = jnp.abs(slant) < _CIRCULAR
    log_ratio = jnp.log(axis_ratio_of(jnp.where(small, 0.5, jnp.abs(slant)), method))
    return jnp.exp(jnp.where(small, -4 / 3 * slant, jnp.sign(slant) * log_ratio))


def carrier_share(stage: Stage) -> Scalar:
    """Carrier speed over screw speed for rolling on the nominal circles, (n − 2)/(2 (n − 1)).

    In general `Thread.ideal_carrier_ratio`, over the speed of the body that turns.
    """
    return stage.thread.ideal_carrier_ratio


def cycles_per_turn(stage: Stage) -> tuple[Scalar, Scalar, Scalar]:
    """Stress cycles of a point of screw, roller and nut in one turn of the body that turns.

    N (1 − ζ) rollers pass a point of the body that turns, N ζ a point of the other. A roller turns
    ζ times the absolute value of κ (`Thread.rolling_ratio`, n in a standard roller screw) relative
    to its carrier, and each of its flanks touches one body only.

    **Arguments:**

    - `stage`: the stage.
    """
    share, rollers = carrier_share(stage), stage.present_roller_count
    family, thread = stage.thread.family, stage.thread
    ratio = thread.nut_ratio if family.held == "nut" else thread.screw_ratio
    turning, roller, held = rollers * (1 - share), ratio * share, rollers * share
    return (turning, roller, held) if family.turning == "screw" else (held, roller, turning)


@physics("dynamic_capacity")
def dynamic_capacity(
    stage: Stage,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
    sharing_factor: Scalar | float = 1.0,
    fatigue: TruncatedFatigue | None = None,
) -> Scalar:
    r"""Dynamic axial capacity $C_a$ [N]: the load for a rating life of 10⁶ turns of the screw.

    As given, or an estimate if `material_factor` is given: every engaged thread of screw, nut and
    rollers is a track of Lundberg and Palmgren, and $L^{-10/9} = \sum L_i^{-10/9}$. The stroke is
    assumed to be short: the screw's life is that of the threads under the nut. For a preloaded pair
    it is the capacity of one nut, or of one half. With `fatigue_rule = "equivalent_balls"` it is
    that of `equivalent_ball_capacity`, the way in which makers rate: whole ellipses, one track.

    Range of the estimate: hardened bearing steel, full film, pressures that stay elastic (below
    about 3 GPa); sliding and spin in the contacts, and the pressure concentration at the ends of
    flanks, are neglected. The estimate has not been compared with tests of roller screws.

    **Arguments:**

    - `stage`: the stage, with strength data.
    - `meshing`: its meshing, if already known.
    - `contact`: `reference_contact` of the stage, if already known.
    - `sharing_factor`: (mean of the 10/3 powers of thread loads over their mean)^{3/10}, see
        `fatigue_sharing_factor`; a capacity that is given holds as it is.
    - `fatigue`: `truncated_fatigue` of the stage, if already known.

    **Raises:** `MissingDataError` if neither capacity nor material factor is given, or materials
    or engaged threads are not.
    """
    strength = strength_of(stage)
    if strength.dynamic_capacity is not None:
        return strength.dynamic_capacity
    factor = _material_factor(stage)
    if strength.fatigue_rule == "equivalent_balls":
        return factor * equivalent_ball_capacity(stage, meshing) / sharing_factor
    meshing, contact = known_contact(stage, meshing, contact)
    if fatigue is None:
        fatigue = truncated_fatigue(stage, meshing, contact, sharing_factor)
    if fatigue is not None:
        return fatigue.capacity()
    return _full_capacity(stage, fatigue_risk(stage, meshing, contact), sharing_factor)


def _material_factor(stage: Stage) -> Scalar:
    factor = strength_of(stage).material_factor
    if factor is None:
        raise MissingDataError(
            "the stage has neither dynamic_capacity nor material_factor; give "
            "stage.strength.dynamic_capacity from a catalogue or a test, or "
            "stage.strength.material_factor for an estimate (1 for Lundberg and Palmgren's steel, "
            "1.3 for that of ISO 281)"
        )
    return factor


@physics("dynamic_capacity")
def _full_capacity(stage: Stage, risk: Scalar, sharing_factor: Scalar | float) -> Scalar:
    """Dynamic capacity with full ellipses, from `fatigue_risk` under the reference load [N]."""
    life = (RATED / risk) ** (1 / WEIBULL_SLOPE)
    capacity = _material_factor(stage) * REFERENCE_LOAD * jnp.cbrt(life)
    return capacity * thread_share(stage) ** _THREADS_EXPONENT / sharing_factor


def cuts_fatigue(stage: Stage) -> bool:
    """Whether ends of flanks, if there are any, lower the dynamic capacity and the life."""
    strength = stage.strength
    if strength is None or strength.dynamic_capacity is not None:
        return False
    return strength.fatigue_rule == "lundberg_palmgren"


def truncated_fatigue(
    stage: Stage,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
    sharing_factor: Scalar | float = 1.0,
    sides: tuple[SideOnset | None, SideOnset | None] | None = None,
    threads: tuple[ThreadShares, ThreadShares] | None = None,
) -> TruncatedFatigue | None:
    """Fatigue with ellipses cut by the ends of the flanks; `None` if no flank has an end.

    Also `None` if the dynamic capacity is given, since a test includes the truncation, or is that
    of equivalent balls, which have whole ellipses. If threads share unequally, each is truncated
    under its own load; without `threads` all are truncated like a thread that carries
    `sharing_factor` times the mean.

    **Arguments:** as in `dynamic_capacity`, and

    - `sides`: `side_onsets` of the stage, if already known.
    - `threads`: loads of the threads over the mean, on the screw and the nut side.

    **Raises:** as in `dynamic_capacity`.
    """
    if not cuts_fatigue(stage):
        return None
    meshing, contact = known_contact(stage, meshing, contact)
    if sides is None:
        sides = side_onsets(stage, meshing, contact)
    if sides is None:
        return None
    risks = side_risks(stage, meshing, contact)
    common = sharing_factor if threads is None else 1.0
    untruncated = _full_capacity(stage, risks[0] + risks[1], sharing_factor)
    return TruncatedFatigue(sides, risks, common / thread_share(stage), untruncated, threads)


def fatigue_risk(stage: Stage, meshing: Meshing | None, contact: StageContact) -> Scalar:
    """ln(1/S) of all tracks after 10⁶ turns of the screw under the load of the contacts.

    **Arguments:**

    - `stage`, `meshing`: the stage, and its meshing if its curvature convention needs it.
    - `contact`: its thread contacts under some load.
    """
    return sum(side_risks(stage, meshing, contact), jnp.zeros_like(stage.thread.lead))


def side_risks(
    stage: Stage, meshing: Meshing | None, contact: StageContact
) -> tuple[Scalar, Scalar]:
    """`fatigue_risk` of the tracks on the screw and on the nut side, with full ellipses.

    Arguments as there. A separate part of a program: two numbers leave it.
    """
    return apart(_side_risks, whole=True)(stage, meshing, contact)


@physics("dynamic_capacity")
def _side_risks(
    stage: Stage, meshing: Meshing | None, contact: StageContact
) -> tuple[Scalar, Scalar]:
    threads, rollers = engaged_threads(stage), stage.present_roller_count
    screw_cycles, roller_cycles, nut_cycles = cycles_per_turn(stage)
    frames = contact_frames(stage.thread, meshing, stage.curvature)
    bodies = (stage.thread.screw_radius, screw_cycles), (stage.thread.nut_radius, nut_cycles)

    def stressed_of(total: Scalar, rolling: Scalar, pressure: Scalar, product: Scalar) -> Scalar:
        return _stressed(pressure, product, _rolling_ratio(total, rolling, stage.contact_method))

    inputs = [
        (
            frame.curvature.total,
            frame.curvature.rolling,
            side.hertz.max_pressure,
            side.hertz.semi_major * side.hertz.semi_minor,
        )
        for frame, side in zip(frames, (contact.screw, contact.nut), strict=True)
    ]
    # Both sides in one call: half the program size.
    both = jax.vmap(stressed_of)(*(jnp.stack(pair) for pair in zip(*inputs, strict=True)))
    risks = []
    for stressed, (radius, cycles) in zip(both, bodies, strict=True):
        tracks = radius * cycles**WEIBULL_SLOPE
        tracks = tracks + rollers * stage.thread.roller_radius * roller_cycles**WEIBULL_SLOPE
        risks.append(_STEEL * stressed * threads * tracks * (2 * jnp.pi * 1e3))
    return risks[0], risks[1]


def fatigue_sharing_factor(
    thread_loads: Float[Array, "*threads"], weights: Float[Array, "*threads"] | None = None
) -> Scalar:
    r"""Divisor of the capacity for unequal thread loads: $(\overline{q^{10/3}})^{3/10} \ge 1$.

    q is a thread's load over the mean; Lundberg and Palmgren's risk is proportional to its 10/3
    power. 1 without load.

    **Arguments:**

    - `thread_loads`: loads of all threads, in any unit, not negative.
    - `weights`: number of threads that each load represents; one if not given.
    """
    if weights is None:
        weights = jnp.ones_like(thread_loads)
    shares = jnp.ravel(weights / jnp.sum(weights))
    mean = jnp.sum(shares * jnp.ravel(thread_loads))
    loaded = above_or_nan(mean)
    effective = mean_load(jnp.ravel(thread_loads), shares, 10 / 3)
    return jnp.where(loaded, effective / jnp.where(loaded, mean, 1.0), 1.0)
