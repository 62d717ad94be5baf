"""Expected values apart from the package: mpmath at 50 digits, SciPy where a scene is integrated.

Every function takes a structure and its numbers by name, and gives for some columns the value and
the relative error that a backward stable algorithm may make: what a relative change of the numbers
by 1e-13 does.
"""

import contextlib
from collections.abc import Callable, Mapping
from typing import Any

import mpmath
import numpy as np
from mpmath import mpf
from mpmath.libmp import NoConvergence

from ...references.hertz import exact_hertz
from ...references.meshing import Design, mesh_point
from .chain import Chain, NoReference, Number
from .stage import StageNumbers, modes_of

#: Decimal digits.
DIGITS = 50
#: Relative change of the numbers whose effect is no error of an algorithm.
_BACKWARD = 1e-13

Given = Mapping[str, np.ndarray]
Expected = dict[str, tuple[np.ndarray, float]]


@contextlib.contextmanager
def _solvable():
    """**Raises:** `NoReference` for what mpmath raises where there is no solution."""
    try:
        yield
    except (ValueError, ZeroDivisionError, NoConvergence, TypeError) as error:
        raise NoReference(str(error)) from error
    except AttributeError as error:
        # mpmath to 1.3 where a real number was expected and a complex one came.
        if "_mpf_" not in str(error):
            raise
        raise NoReference("a complex number") from error


def _conditioned(
    function: Callable[[dict[str, list[Any]]], dict[str, Any]], given: Given
) -> Expected:
    """Values at the numbers, and how far a small change of them moves the values."""
    random = np.random.default_rng(50)
    with mpmath.workdps(DIGITS):
        exact = {k: [mpf(float(x)) for x in np.ravel(v)] for k, v in given.items()}
        with _solvable():
            middle = function(exact)
            moved = {
                k: [x * (1 + mpf(_BACKWARD) * int(random.choice([-1, 1]))) for x in v]
                for k, v in exact.items()
            }
            beside = function(moved)
    found: Expected = {}
    for name, value in middle.items():
        here = np.array([float(x) for x in _list(value)])
        there = np.array([float(x) for x in _list(beside.get(name, value))])
        with np.errstate(all="ignore"):
            error = np.where(here == there, 0.0, np.abs(there - here) / np.abs(here))
        shaped = here if isinstance(value, list) else here[0]
        found[name] = (np.asarray(shaped), float(np.max(error)) + 1e-13)
    return found


def _list(value) -> list[Any]:
    return value if isinstance(value, list) else [value]


def hertz(_, given: Given) -> Expected:
    """A bare contact by the elliptic integrals of Johnson 1985, chapter 4."""

    def exact(numbers):
        force, total, square, modulus = (
            numbers[name][0] for name in ("force", "total", "difference_squared", "modulus")
        )
        difference = mpmath.sqrt(square)
        if force <= 0 or modulus <= 0 or not 0 <= difference < total:
            raise NoReference("no contact of an ellipse")
        smaller, larger = (total - difference) / 2, (total + difference) / 2
        pressure, approach, major, minor = exact_hertz(force, smaller, larger, modulus)
        return {
            "max_pressure": pressure,
            "approach": approach,
            "semi_major": major,
            "semi_minor": minor,
            "stiffness": force / approach,
        }

    return _conditioned(exact, given)


def stage(structure, given: Given) -> Expected:
    """A stage from its thread to its frequencies."""
    part = structure.base.stages[0]
    return _conditioned(lambda numbers: StageNumbers(part, numbers).columns(), given)


def unequal(structure, given: Given) -> Expected:
    """All frequencies from the full matrices of masses and springs."""
    part = structure.base.stages[0]
    with mpmath.workdps(40):
        exact = {k: [mpf(float(x)) for x in np.ravel(v)] for k, v in given.items()}
        with _solvable():
            numbers = StageNumbers(part, exact)
            found = modes_of(numbers)
    return {"natural_frequencies": (np.array([float(x) for x in found]), 1e-11)}


def chain(structure, given: Given) -> Expected:
    """Steady state of a chain of stages."""
    return _conditioned(lambda numbers: Chain(structure.base, numbers).steady(), given)


def settling(structure, given: Given) -> Expected:
    """Carriers that settle at constant speed and load, integrated by SciPy."""
    from scipy.integrate import solve_ivp

    with mpmath.workdps(30):
        exact = {k: [mpf(float(x)) for x in np.ravel(v)] for k, v in given.items()}
        with _solvable():
            whole = Chain(structure.base, exact, scenario=True)
            floats = whole.in_floats()
    duration = float(given["scenario.duration"])
    start = float(given["scenario.initial_carrier_ratio"])
    samples = structure.base.scenario.samples
    count = len(floats.stages)
    solution = solve_ivp(
        lambda s, y: np.asarray(floats.rates(y)) * duration,
        (0.0, 1.0),
        np.full(count, start),
        method="Radau",
        rtol=1e-9,
        atol=1e-11,
        t_eval=np.linspace(0.0, 1.0, samples),
    )
    if not solution.success:
        raise NoReference(solution.message)
    torques = np.array([floats.torque(y) for y in solution.y.T])
    # Next to jamming rounding of the floats here is no small error.
    own = 1e-6 + 1e-14 / floats.least_push
    return {
        "carrier_ratio": (solution.y, 0.0),
        "drive_torque": (torques, own),
        "efficiency": (floats.load * floats.travel / torques, own),
    }


def half_space(structure, given: Given) -> Expected:
    """Hertz on the osculating paraboloids; no crests, so only the grid is between the two."""
    part = structure.base.stages[0]

    def exact(numbers):
        own = StageNumbers(part, numbers)
        found: dict[str, Number] = {}
        for side in ("screw", "nut"):
            pressure, approach, _, _ = own.hertz(side)
            found[f"max_pressure_{side}"] = pressure
            found[f"approach_{side}"] = approach
            found[f"load_{side}"] = own.thread_force * own.sides[side][2]
        return found

    return _conditioned(exact, given)


__all__ = ["Design", "NoReference", "mesh_point"]
