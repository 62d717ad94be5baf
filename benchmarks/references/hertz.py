"""Elliptical Hertz contact in mpmath (Johnson 1985, chapter 4)."""

from typing import Any

import mpmath

#: Decimal digits; the cancellation in K − E near circles costs up to a dozen of them.
DIGITS = 40


def hertz(force, first, second, modulus) -> tuple[float, float, float, float]:
    """Largest pressure [Pa], approach and semi-axes [m] of the gap A x² + B y², A ≤ B.

    **Arguments:** F [N], A and B [1/m], E* [Pa]; floats count as exact.
    """
    with mpmath.workdps(DIGITS):
        pressure, approach, major, minor = exact_hertz(force, first, second, modulus)
        return float(pressure), float(approach), float(major), float(minor)


def exact_hertz(force, first, second, modulus) -> tuple[Any, ...]:
    """The same in mpmath's numbers, at the digits that it works with."""
    force, modulus = mpmath.mpf(force), mpmath.mpf(modulus)
    smaller, larger = mpmath.mpf(first), mpmath.mpf(second)
    target = mpmath.log(smaller / larger)

    def residual(log_axis_ratio):
        square = mpmath.exp(2 * log_axis_ratio)
        k, e = mpmath.ellipk(1 - square), mpmath.ellipe(1 - square)
        return mpmath.log((k - e) / (e / square - k)) - target

    if smaller == larger:
        axis_ratio = mpmath.mpf(1)
    else:
        start = target * 2 / 3
        axis_ratio = mpmath.exp(mpmath.findroot(residual, (start, start * mpmath.mpf("0.99"))))
    k, e = mpmath.ellipk(1 - axis_ratio**2), mpmath.ellipe(1 - axis_ratio**2)
    major = mpmath.cbrt(
        3 * force * e / (2 * mpmath.pi * modulus * axis_ratio**2 * (smaller + larger))
    )
    minor = axis_ratio * major
    pressure = 3 * force / (2 * mpmath.pi * major * minor)
    approach = pressure * minor * k / modulus
    return pressure, approach, major, minor
