"""How much of each limit a size uses, and how far a requirement would have to be relaxed."""

import math

import numpy as np

from ._requirements import (
    BUCKLING_SAFETY,
    DN_LIMIT,
    SPEED_SHARE,
    STATIC_SAFETY,
    Requirements,
    loaded_length,
    unsupported_length,
)
from ._sizes import Sizes

#: Margins are quotients of what a size has over what it needs; with this reserve, rounding in a
#: file does not turn one below 1.
_RESERVE = 1 + 1e-6


def margins(sizes: Sizes, wanted: Requirements) -> dict[str, np.ndarray]:
    """What each size has over what it needs, by limit; 1 or more is enough."""
    turning = 2 * math.pi * wanted.speed / sizes.lead
    loaded = loaded_length(wanted.stroke, sizes.nut_length)
    free = unsupported_length(wanted.stroke, sizes.nut_length, sizes.diameter)
    return {
        "envelope": wanted.envelope / sizes.nut_diameter,
        "life": life(sizes, wanted) / wanted.life,
        "static_safety": sizes.static_capacity / (STATIC_SAFETY * wanted.load),
        "buckling": _buckling_load(sizes, loaded) / (BUCKLING_SAFETY * wanted.load),
        "critical_speed": SPEED_SHARE * sizes.critical_speed / free**2 / turning,
        "dn_value": DN_LIMIT / (sizes.diameter * turning),
    }


def _buckling_load(sizes: Sizes, length: np.ndarray) -> np.ndarray:
    """Euler's load E; Johnson's Y (1 − Y/(4 E)) where E is above half the load Y at yielding."""
    euler, yielding = sizes.euler_load / length**2, sizes.yield_load
    return np.where(euler < yielding / 2, euler, yielding * (1 - yielding / (4 * euler)))


def _longest(sizes: Sizes, load: float) -> np.ndarray:
    """Length at which the buckling load is `load` [m]; 0 for a screw that yields under it."""
    yielding = sizes.yield_load
    rest = np.maximum(yielding - load, 1e-9 * yielding)
    euler = np.where(load < yielding / 2, load, yielding**2 / (4 * rest))
    return np.where(load < yielding, np.sqrt(sizes.euler_load / euler), 0.0)


def life(sizes: Sizes, wanted: Requirements) -> np.ndarray:
    """Rating life L10 of each size [s]."""
    turns = 1e6 * (sizes.dynamic_capacity / wanted.load) ** 3
    return turns * sizes.lead / wanted.speed


def fits(found: dict[str, np.ndarray], without: tuple[str, ...] = ()) -> np.ndarray:
    """Which sizes keep all limits but some."""
    kept = [value >= _RESERVE for name, value in found.items() if name not in without]
    return np.logical_and.reduce(kept)


def relaxations(sizes: Sizes, wanted: Requirements) -> dict[str, float]:
    """The nearest value of each requirement, all others as they are, for which a size fits [SI].

    A requirement is absent if no value of it is enough.
    """
    found = margins(sizes, wanted)
    # What a size could carry, how fast, how long: the limits that depend on it, solved for it.
    loads = np.minimum.reduce(
        [
            wanted.load * found["static_safety"],
            wanted.load * found["buckling"],
            wanted.load * np.cbrt(found["life"]),
        ]
    )
    shares = np.minimum.reduce([found["life"], found["critical_speed"], found["dn_value"]])
    loaded = loaded_length(wanted.stroke, sizes.nut_length)
    free = unsupported_length(wanted.stroke, sizes.nut_length, sizes.diameter)
    strokes = wanted.stroke + np.minimum(
        _longest(sizes, BUCKLING_SAFETY * wanted.load) - loaded,
        free * (np.sqrt(found["critical_speed"]) - 1),
    )
    possible = {
        "load": (loads, ("life", "static_safety", "buckling")),
        "stroke": (strokes, ("buckling", "critical_speed")),
        "speed": (wanted.speed * shares, ("life", "critical_speed", "dn_value")),
        "life": (wanted.life * found["life"], ("life",)),
        "envelope": (-sizes.nut_diameter, ("envelope",)),
    }
    best: dict[str, float] = {}
    for name, (values, limits) in possible.items():
        usable = values[fits(found, limits)] / _RESERVE
        highest = float(usable.max()) if usable.size else -math.inf
        if name == "envelope" and usable.size:
            best[name] = _rounded(-highest * _RESERVE**2, up=True)
        elif highest > 0:
            best[name] = _rounded(highest, up=False)
    return best


def _rounded(value: float, *, up: bool) -> float:
    """Three significant digits, away from the limit."""
    scale = 10.0 ** (2 - math.floor(math.log10(value)))
    return (math.ceil(value * scale) if up else math.floor(value * scale)) / scale
