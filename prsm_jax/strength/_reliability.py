"""Factors on the basic rating life: reliability, and oscillating screws."""

import functools

import jax.numpy as jnp

from ..contact import StageContact
from ..fields import Scalar
from ..geometry import Meshing
from ..mechanism import Stage
from ..programs import physics
from ._contacts import REFERENCE_LOAD, reference_contact, strength_of, thread_share
from ._fatigue import RATED, WEIBULL_SLOPE, carrier_share, cycles_per_turn
from ._powers import positive_power

#: Weibull slope and the share of L10 that all survive, from which ISO 281:2007 tabulates a₁.
_SLOPE, _SURVIVED = 1.5, 0.05


def reliability_factor(reliability: Scalar) -> Scalar:
    r"""Life at a survival S over that at 90 %, $a_1$.

    $a_1 = 0.95\,(\ln S/\ln 0.9)^{2/3} + 0.05$, the Weibull distribution with three parameters of
    ISO/TR 1281-2, from which the table of ISO 281:2007 is made (95 %: 0.64, 99 %: 0.25, 99.95 %:
    0.077). This is for bearings; ISO 3408-5 has its own table for ball screws (95 %: 0.62, 99 %:
    0.21), which is that of ISO 281 before 2007.

    Range: 90 to 99.95 %.

    **Arguments:**

    - `reliability`: S, between 0 and 1.
    """
    hazard = -jnp.log(reliability) / RATED
    return (1 - _SURVIVED) * hazard ** (1 / _SLOPE) + _SURVIVED


def swept_share(stage: Stage, amplitude: Scalar) -> Scalar:
    """Smallest share of a track that the contacts of an oscillating screw roll over.

    With an oscillation of ±φ, N contacts roll over N (1 − ζ) φ/π of a track of the screw and N ζ
    φ/π of a track of the nut; a flank of a roller has one contact, which rolls over n ζ φ/π. At
    most 1.

    **Arguments:**

    - `stage`: the stage.
    - `amplitude`: φ, half of the angle through which the screw swings [rad].
    """
    fewest = functools.reduce(jnp.minimum, cycles_per_turn(stage))
    return jnp.minimum(fewest * amplitude / jnp.pi, 1.0)


@physics("oscillation_factor")
def oscillation_factor(stage: Stage, amplitude: Scalar) -> Scalar:
    r"""Life in turns of an oscillating screw over that of a continuously rotating one.

    The same number of stress cycles acts on a share s of the track: the volume is proportional to s
    and the cycles to 1/s, so $L \propto s^{(e-1)/e} = s^{1/10}$ with the Weibull slope e = 10/9
    (Rumbarger and Jones 1968, and Harris and Kotzalas 2006 for bearings, where it is a load factor
    $\propto (Z\varphi)^{1/30}$). The smallest share is used for all tracks: a lower bound. 1 above
    the critical amplitude, where tracks overlap.

    Range: rolling fatigue only. Below `minimum_oscillation_amplitude` the lubricant is not
    replenished and false brinelling, which rating lives do not cover, occurs first.

    **Arguments:**

    - `stage`: the stage.
    - `amplitude`: half of the angle through which the screw swings [rad].
    """
    return swept_share(stage, amplitude) ** ((WEIBULL_SLOPE - 1) / WEIBULL_SLOPE)


def minimum_oscillation_amplitude(
    stage: Stage,
    load: Scalar,
    meshing: Meshing | None = None,
    contact: StageContact | None = None,
) -> Scalar:
    r"""Amplitude below which a contact does not leave its own ellipse and wears into the surface.

    The roller rolls $2\varphi\,|\kappa|\zeta r_R$ on the body that does not turn, whose radius is
    $|\kappa| r_R$; where this is less than the ellipse's larger axis $2a$, part of the contact is
    never exposed to lubricant: $\varphi = a/(|\kappa|\zeta r_R)$. In bearings false brinelling is
    observed at ratios of these two lengths up to about 1.

    **Arguments:**

    - `stage`: the stage; needs strength data, materials and `engaged_threads`.
    - `load`: axial load; its sign is ignored [N].
    - `meshing`: its meshing, if already known.
    - `contact`: `reference_contact` of the stage, if already known.

    **Raises:** `MissingDataError` if one of these is not given.
    """
    strength_of(stage)
    if contact is None:
        contact = reference_contact(stage, meshing)
    share = jnp.abs(load) / (REFERENCE_LOAD * thread_share(stage))
    family, thread = stage.thread.family, stage.thread
    held = contact.nut if family.held == "nut" else contact.screw
    half_length = held.hertz.semi_major * positive_power(share, 1 / 3)
    ratio = thread.nut_ratio if family.held == "nut" else thread.screw_ratio
    rolled = ratio * carrier_share(stage) * thread.roller_radius
    return half_length / rolled


def life_factor(stage: Stage) -> Scalar | None:
    """a₁ a_ISO and the factor of oscillation, as far as given; `None` if none is given."""
    strength = stage.strength
    if strength is None:
        return None
    factors = []
    if strength.reliability is not None:
        factors.append(reliability_factor(strength.reliability))
    if strength.life_modification_factor is not None:
        factors.append(strength.life_modification_factor)
    if strength.oscillation_amplitude is not None:
        factors.append(oscillation_factor(stage, strength.oscillation_amplitude))
    return jnp.prod(jnp.stack(factors)) if factors else None
