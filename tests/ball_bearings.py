"""Ball bearings by the theory of the dynamic capacity, and by the formula fitted to it."""

import numpy as np
import scipy.special
from scenes import array

from prsm_jax.strength import _fatigue
from tests.roots import root_between


def ring(conformity, ratio, sense, diameter=10.0):
    """Ball force [N] at which an inner (+1) or outer (−1) ring lasts 10⁶ turns, from the theory."""
    modulus, poisson = 206e3, 0.3
    pitch = diameter / ratio
    rolling = (2 / diameter + sense * 2 / (pitch * (1 - sense * ratio))) / 2
    across = (2 / diameter - 1 / (conformity * diameter)) / 2

    def excess(k):
        first, second = scipy.special.ellipk(1 - k * k), scipy.special.ellipe(1 - k * k)
        return (first - second) / (second / k**2 - first) - across / rolling

    k = root_between(excess, 1e-4, 1 - 1e-12)
    second = scipy.special.ellipe(1 - k * k)
    contact = modulus / (2 * (1 - poisson**2))
    major = (3 * second / (2 * np.pi * contact * k * k * (across + rolling))) ** (1 / 3)
    pressure = 3 / (2 * np.pi * k * major**2)
    stressed = _fatigue._stressed(array(pressure * 1e6), array(k * (major * 1e-3) ** 2), array(k))
    track = np.pi * pitch * (1 - sense * ratio)
    balls = 9
    cycles = balls / 2 * (1 + sense * ratio)
    risk = _fatigue._STEEL * float(stressed) * track * cycles ** (10 / 9)
    return (np.log(1 / 0.9) / risk) ** 0.3, balls


def published(conformity, ratio, sense, balls, diameter=10.0):
    """Lundberg and Palmgren's formula for the same force."""
    return (
        98.1
        * (2 * conformity / (2 * conformity - 1)) ** 0.41
        * (1 - sense * ratio) ** 1.39
        / (1 + sense * ratio) ** (1 / 3)
        * ratio**0.3
        * diameter**1.8
        * balls ** (-1 / 3)
    )
