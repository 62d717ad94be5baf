"""Bending–torsional vibration of one stage in full, N + 10 degrees of freedom.

Written for any scalar type, so that the same equations serve mpmath (reference) and NumPy
(rivals). Mass and stiffness are linear in the numbers of the system, which are, in this order:
m, J/r², mesh stiffness, radial and torsional support of screw, ring gear and nut; J/r² of a
roller; equivalent mass and torsional support of the carrier.
"""

import itertools
import math
from collections.abc import Sequence
from typing import Any

import mpmath
import numpy as np

#: Decimal digits: the spread of the eigenvalues reaches 1e12 and costs as many.
DIGITS = 40
#: Sense in which a roller's rotation stretches the springs of screw, ring gear, nut.
SIGNS = (1, -1, -1)
NUMBERS = 18


def structure(count: int, library=math) -> tuple[list[list[tuple[Any, ...]]], list[list[int]]]:
    """What each number does: springs `(coordinates, coefficients)`, and the masses it adds to.

    **Arguments:**

    - `count`: number of rollers.
    - `library`: `math` or `mpmath`, for sines.

    **Returns:** for each number the springs whose stiffness it is, and for each number the
    coordinates whose mass it is.
    """
    springs: list[list[tuple[Any, ...]]] = [[] for _ in range(NUMBERS)]
    masses: list[list[int]] = [[] for _ in range(NUMBERS)]
    carrier = 9 + count
    for body, sign in enumerate(SIGNS):
        x, y, turn = 3 * body, 3 * body + 1, 3 * body + 2
        first = 5 * body
        masses[first], masses[first + 1] = [x, y], [turn]
        for roller in range(count):
            angle = -sign * 2 * library.pi * roller / count
            coordinates = (x, y, turn, 9 + roller)
            springs[first + 2].append(
                (coordinates, (-library.sin(angle), library.cos(angle), 1, sign))
            )
        springs[first + 3] = [((x,), (1,)), ((y,), (1,))]
        springs[first + 4] = [((turn,), (1,))]
    masses[15] = list(range(9, carrier))
    masses[16] = [carrier]
    springs[17] = [((carrier,), (1,))]
    return springs, masses


def stiffness_terms(count: int) -> np.ndarray:
    """∂K/∂number in float64, shape (numbers, N + 10, N + 10)."""
    terms = np.zeros((NUMBERS, count + 10, count + 10))
    for number, springs in enumerate(structure(count)[0]):
        for coordinates, coefficients in springs:
            terms[number][np.ix_(coordinates, coordinates)] += np.outer(coefficients, coefficients)
    return terms


def mass_terms(count: int) -> np.ndarray:
    """∂(diagonal of M)/∂number in float64, shape (numbers, N + 10)."""
    terms = np.zeros((NUMBERS, count + 10))
    for number, coordinates in enumerate(structure(count)[1]):
        terms[number, coordinates] = 1.0
    return terms


def frequencies(
    numbers: Sequence[float], count: int, *, elasticities: bool = False
) -> tuple[np.ndarray, np.ndarray | None]:
    """Natural frequencies, ascending [Hz], and on request their elasticities, in mpmath.

    **Returns:** frequencies, shape (N + 10,), and `∂log f/∂log number`, shape (N + 10, numbers).
    """
    with mpmath.workdps(DIGITS):
        exact = [mpmath.mpf(number) for number in numbers]
        springs, masses = structure(count, mpmath)
        size = count + 10
        mass = [mpmath.mpf(0)] * size
        for number, coordinates in zip(exact, masses, strict=True):
            for i in coordinates:
                mass[i] += number
        weight = [1 / mpmath.sqrt(m) for m in mass]
        matrix = mpmath.zeros(size)
        for number, group in zip(exact, springs, strict=True):
            for coordinates, coefficients in group:
                pairs = list(zip(coordinates, coefficients, strict=True))
                for (i, ci), (j, cj) in itertools.product(pairs, pairs):
                    matrix[i, j] += number * ci * cj * weight[i] * weight[j]
        if not elasticities:
            values = sorted(mpmath.eigsy(matrix, eigvals_only=True))
            return np.array([float(mpmath.sqrt(v) / (2 * mpmath.pi)) for v in values]), None
        values, vectors = mpmath.eigsy(matrix)
        shapes = [[weight[i] * vectors[i, k] for i in range(size)] for k in range(size)]
        rates = [_rates(exact, springs, masses, v, s) for v, s in zip(values, shapes, strict=True)]
        frequency = [mpmath.sqrt(v) / (2 * mpmath.pi) for v in values]
        return np.array([float(f) for f in frequency]), _cluster_means(frequency, rates)


def _rates(numbers, springs, masses, value, shape) -> list[Any]:
    """½ p φᵀ(∂K/∂p − λ ∂M/∂p)φ / λ for every number p: the elasticity of one frequency."""
    rates = []
    for number, group, coordinates in zip(numbers, springs, masses, strict=True):
        rate = -value * sum((shape[i] ** 2 for i in coordinates), mpmath.mpf(0))
        for places, coefficients in group:
            stretch = sum(c * shape[i] for i, c in zip(places, coefficients, strict=True))
            rate += stretch**2
        rates.append(number * rate / (2 * value))
    return rates


def _cluster_means(frequency, rates) -> np.ndarray:
    """Equal roots stay equal when symmetry does, so all of them have the mean of their rates."""
    means, tolerance = np.zeros((len(rates), NUMBERS)), mpmath.mpf(10) ** (-DIGITS // 2)
    for k, own in enumerate(frequency):
        equal = [i for i, f in enumerate(frequency) if abs(f - own) <= tolerance * own]
        means[k] = [float(sum(rates[i][p] for i in equal) / len(equal)) for p in range(NUMBERS)]
    return means
