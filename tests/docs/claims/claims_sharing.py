"""Claims of the page on load sharing: which errors of parts matter among rollers."""

import numpy as np

from tests.docs.claims import Claim

PAGE = "docs/load_sharing.md"
#: Rollers; mean approach of both contacts of a roller [µm]; designs that are drawn.
_ROLLERS, _APPROACH, _COUNT = 10, 10.0, 20_000


def _unbalance(nut, screw, diameters):
    """Largest over mean load of rollers on Hertz contacts between rigid shafts, at 45 deg.

    Nut and screw are displaced by vectors (amount [µm], angle), each roller has its deviation [µm].
    """
    places = 2 * np.pi * np.arange(_ROLLERS) / _ROLLERS
    (amount, angle), (other, other_angle) = nut, screw
    opening = amount[:, None] * np.cos(places - angle[:, None])
    opening = opening - other[:, None] * np.cos(places - other_angle[:, None]) - diameters
    low, high = opening.min(1), opening.max(1) + _APPROACH
    # The approach at which the rollers carry the load, by bisection.
    for _ in range(50):
        middle = (low + high) / 2
        loads = np.maximum(middle[:, None] - opening, 0) ** 1.5
        above = loads.sum(1) > _ROLLERS * _APPROACH**1.5
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return loads.max(1) / loads.mean(1)


def _shares(nut: float, screw: float, diameter: float) -> list[float]:
    """Total Sobol indices of the three errors, normalised [%], by Jansen's estimator."""
    generator = np.random.default_rng(0)

    def draw():
        vectors = [
            (generator.uniform(0, most, _COUNT), generator.uniform(0, 2 * np.pi, _COUNT))
            for most in (nut, screw)
        ]
        return [*vectors, generator.uniform(-diameter, diameter, (_COUNT, _ROLLERS))]

    first, second = draw(), draw()
    values = _unbalance(*first)
    changed = [
        np.mean((values - _unbalance(*[*first[:i], second[i], *first[i + 1 :]])) ** 2)
        for i in range(3)
    ]
    return [float(100 * one / sum(changed)) for one in changed]


def _of_three() -> list[float]:
    """Ranges and shares, in the order of the page."""
    widest, fitted, equal = (10.0, 10.0, 5.0), (6.5, 5.0, 3.5), (10.0, 10.0, 10.0)
    head = [_ROLLERS, _APPROACH, *_shares(*widest), widest[0], widest[2]]
    return [*head, *_shares(*fitted), *fitted, *_shares(*equal), *equal]


CLAIMS = [
    Claim(
        PAGE,
        "({} rollers, mean approach {} µm, uniform errors, all angles equally likely), the shares"
        " in the variance of the largest over the mean roller load are {}, {} and {} % for ranges"
        " of {} µm for both eccentricities and ±{} µm for diameters. They are {}, {} and {} % for"
        " {}, {} and ±{} µm, ranges that were chosen to fit, and {}, {} and {} % for {}, {} and"
        " ±{} µm.",
        _of_three,
    )
]
