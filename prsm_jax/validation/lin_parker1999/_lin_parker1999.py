"""Lin and Parker 1999: the assembled matrices, tested on a structure from outside this field."""

import functools
from collections.abc import Iterator
from typing import TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp

from ...vibration import (
    CarrierBody,
    CentralBody,
    RollerTranslation,
    VibrationSystem,
    symmetric_modes,
)
from .._difference import differs
from .._registry import rows_of
from .._row import Row, number

_CITATION = (
    "J. Lin, R. G. Parker, Analytical characterization of the unique properties of planetary gear "
    "free vibration, J. Vib. Acoust. 121 (1999) 316–321; frequencies quoted second-hand"
)
#: Published frequencies [Hz] by number of planets: rotational (simple), translational (double).
#: Second-hand: as an open-source model of drive trains quotes Table 2 (gfsReboucas/Drivetrain on
#: GitHub, Lin_Parker_99.m, test_01); the paper itself was not available, so an error of the
#: quotation cannot be distinguished from a misprint. That model computes the same numbers as this
#: one.
ROTATIONAL = {
    3: ("0.0", "1475.7", "1930.3", "2658.3", "7462.8", "11775.3"),
    4: ("0.0", "1536.6", "1970.6", "2625.7", "7773.6", "13071.1"),
    5: ("0.0", "1567.4", "2006.1", "2614.8", "8065.4", "14253.1"),
}
TRANSLATIONAL = {
    3: ("743.2", "1102.4", "1896.0", "2276.4", "6986.3", "9647.9"),
    4: ("727.0", "1091.0", "1892.8", "2342.5", "7189.9", "10437.6"),
    5: ("710.0", "1072.0", "1888.1", "2425.3", "7382.4", "11172.3"),
}
#: Planet modes, N − 3 times each, whatever N is.
PLANET = ("1808.2", "5963.8", "6981.7")
#: Those that the data do not give, and bounds of the computed number [Hz].
_DIFFERENT = {"1536.6": (1536.53, 1536.54), "727.0": (727.26, 727.27), "1091.0": (1091.16, 1091.17)}
_PLANETS = (3, 4, 5)
#: Number of planets, family and place in it.
_Place: TypeAlias = tuple[int, str, int]
#: Printed to a tenth of a hertz.
_HALF_DIGIT = 0.05
_SECOND_HAND = "second-hand, quoted from Table 2 by others"
_PUBLISHED_NAMES = {"torsional": "rotational", "transverse": "translational", "roller": "planet"}


def planetary_gear(planets: int) -> VibrationSystem:
    """Their example, Table 1: sun, ring, carrier at rest, planets with three degrees of freedom."""
    like = jnp.asarray(0.0, jnp.result_type(float))

    def central(name: str, mass: float, equivalent: float, torsional: float, sign: int):
        return CentralBody(
            mass=like + mass,
            equivalent_mass=like + equivalent,
            mesh_stiffness=like + 5e8,
            radial_support=like + 1e8,
            torsional_support=like + torsional,
            roller_sign=sign,
            name=name,
            contact_angle=like + jnp.radians(24.6),
        )

    return VibrationSystem(
        bodies=(central("sun", 0.4, 0.39, 0.0, 1), central("ring", 2.35, 3.0, 1e9, -1)),
        roller_equivalent_mass=like + 0.61,
        carrier=CarrierBody(like + 6.29, like + 0.0, like + 5.43, like + 1e8),
        roller_count=planets,
        translation=RollerTranslation(like + 0.66, like + 1e8),
    )


def _by_family(planets: int) -> dict[str, tuple[str, ...]]:
    published: dict[str, tuple[str, ...]] = {
        "torsional": ROTATIONAL[planets],
        "transverse": TRANSLATIONAL[planets],
    }
    return published | ({"roller": PLANET} if planets > 3 else {})


_solve = eqx.filter_jit(symmetric_modes)


def _frequencies(system: VibrationSystem) -> dict[_Place, float]:
    """Natural frequencies [Hz] by number of planets, family and place in it."""
    return {
        (system.roller_count, group.family, index): float(value)
        for group in _solve(system).groups
        for index, value in enumerate(group.frequencies)
    }


@functools.cache
def _slopes() -> tuple[dict[_Place, float], ...]:
    """Derivatives of all frequencies by each number of Table 1, relative to it [Hz].

    Central differences; a zero has no relative change.
    """
    step = 1e-6
    leaves = jax.tree.leaves(planetary_gear(3))
    derivatives: list[dict[_Place, float]] = []
    for place, leaf in enumerate(leaves):
        if float(leaf) == 0:
            continue
        slopes: dict[_Place, float] = {}
        for planets in _PLANETS:
            form = jax.tree.structure(planetary_gear(planets))
            more, less = (
                _frequencies(form.unflatten([*leaves[:place], value, *leaves[place + 1 :]]))
                for value in (leaf * (1 + step), leaf * (1 - step))
            )
            slopes |= {key: (more[key] - less[key]) / (2 * step) for key in more}
        derivatives.append(slopes)
    return tuple(derivatives)


def collateral(target: _Place) -> float:
    """Error of the other frequencies if a number of Table 1 brings one to its printed value.

    Each number of Table 1 is changed until the frequency is the printed one. The result is the
    largest error of the other frequencies of the three gears that are printed and reproduced, for
    the number with the smallest such error, in units of half a printed digit; 1 is allowed.
    """
    printed = {
        (planets, family, index): value
        for planets in _PLANETS
        for family, values in _by_family(planets).items()
        for index, value in enumerate(values)
    }
    computed: dict[_Place, float] = {}
    for planets in _PLANETS:
        computed |= _frequencies(planetary_gear(planets))
    missing = float(printed[target]) - computed[target]
    worst = []
    for slope in _slopes():
        # Numbers without influence on the frequency would have to change without limit.
        if abs(slope[target]) < 1e-3 * computed[target]:
            continue
        change = missing / slope[target]
        errors = [
            abs(computed[key] + change * slope[key] - float(value))
            for key, value in printed.items()
            if value not in _DIFFERENT
        ]
        worst.append(max(errors) / _HALF_DIGIT)
    return min(worst)


def _reason(planets: int, family: str, index: int, printed: str, computed: float) -> Row | None:
    """The row of a frequency that the data do not give; `None` for all others."""
    if printed not in _DIFFERENT:
        return None
    least = collateral((planets, family, index))
    is_rounded = float(printed) == round(computed)
    return differs(
        _item(planets, family, index),
        printed,
        computed,
        "Hz",
        between=_DIFFERENT[printed],
        evidence=least,
        evidence_between=(1.5, 1e3),
        because=f"{_SECOND_HAND}. The difference is "
        f"{abs(computed - float(printed)):.2f} Hz; the others agree within 0.05 Hz. No number of "
        "Table 1 explains it: if one of them is changed to reach the printed value, the error of "
        "another frequency, printed and reproduced, is at least the evidence, in units of half its "
        "last digit. "
        + (
            f"Rounded to whole hertz the computed number is the printed one, {printed}"
            if is_rounded
            else f"The last digit would have to be {computed:.1f}"
        ),
    )


def _item(planets: int, family: str, index: int) -> str:
    name = _PUBLISHED_NAMES[family]
    fold = {"torsional": "simple", "transverse": "double"}.get(family)
    fold = fold or {4: "simple", 5: "double"}[planets]
    return f"{planets} planets: {name} {index + 1}, {fold}"


@rows_of("lin_parker1999", _CITATION)
def planetary_gear_frequencies() -> Iterator[Row]:
    """All 42 natural frequencies for 3, 4 and 5 planets, by family."""
    for planets in _PLANETS:
        solution = _frequencies(planetary_gear(planets))
        for family, frequencies in _by_family(planets).items():
            for index, printed in enumerate(frequencies):
                computed = solution[planets, family, index]
                row = _reason(planets, family, index, printed, computed)
                if row is None:
                    note = _SECOND_HAND
                    if printed == "0.0":
                        note += "; a rigid rotation, the rest is rounding"
                    row = number(_item(planets, family, index), printed, computed, "Hz", note=note)
                yield row
