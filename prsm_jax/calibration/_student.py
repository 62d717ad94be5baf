"""Quantiles of Student's t for a whole number of degrees of freedom."""

import math

import numpy as np


def _within(angle: float, degrees: int) -> float:
    """Probability that |t| < √ν tan θ (Abramowitz and Stegun, 26.7.3 and 26.7.4)."""
    sine, cosine = math.sin(angle), math.cos(angle)
    if degrees % 2:
        numbers = np.arange(2, degrees - 1, 2)
        if degrees == 1:
            return 2 * angle / math.pi
        factors = np.concatenate([[cosine], numbers / (numbers + 1) * cosine**2])
        return 2 / math.pi * (angle + sine * float(np.cumprod(factors).sum()))
    numbers = np.arange(1, degrees - 2, 2)
    factors = np.concatenate([[1.0], numbers / (numbers + 1) * cosine**2])
    return sine * float(np.cumprod(factors).sum())


def student_quantile(probability: float, degrees: int) -> float:
    """The t for which |t| is smaller with this probability.

    **Arguments:**

    - `probability`: between 0 and 1, both excluded, such as 0.95.
    - `degrees`: degrees of freedom, 1 or more.
    """
    low, high = 0.0, math.pi / 2
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if _within(middle, degrees) < probability else (low, middle)
    return math.sqrt(degrees) * math.tan((low + high) / 2)
