"""Claims of the page on strength and life."""

import dataclasses
import functools

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from ball_bearings import published, ring
from scenes import array, equal_shares
from truncation_scenes import screw_of_30_mm, without_addenda

import prsm_jax as prsm
from benchmarks.references.meshing import Design
from benchmarks.references.truncated import hertz_pressure, pressures
from prsm_jax import strength
from prsm_jax.contact import largest_pressure, pressure_ratio, truncation
from tests.docs.claims import Claim
from tests.present import present

STRENGTH = "docs/strength.md"
_CELLS, _RADIUS = 192, 0.1e-3
_MODULUS = 210e9 / (1 - 0.3**2) / 2
#: Lead [m] and Hertz pressure [Pa] of the lines of the table.
_CUT = ((5e-3, 4.2e9), (3e-3, 3.5e9), (2e-3, 4.2e9))
_compute = eqx.filter_jit(prsm.compute)


@eqx.filter_jit
def _laws(stage, pressure):
    """Share cut, pressure at the contact point and largest one over Hertz, of both sides."""
    both = zip(present(strength.side_onsets(stage)), strength.side_edges(stage), strict=True)
    return [
        (
            truncation(pressure, side.onsets),
            pressure_ratio(pressure, side.onsets),
            largest_pressure(pressure, side.onsets, edges) / pressure,
        )
        for side, edges in both
    ]


@functools.cache
def _line(side: str, lead: float, pressure: float) -> tuple[float, ...]:
    """Share cut; law, sharp and rounded half-spaces at the contact point; largest, both ways."""
    one = screw_of_30_mm(lead).stages[0]
    one = dataclasses.replace(
        one, thread=dataclasses.replace(one.thread, edge_radius=array(_RADIUS))
    )
    index = ("screw", "nut").index(side)
    cut, at_point, largest = (float(x) for x in _laws(one, array(pressure))[index])
    design = Design(lead, 5.0, 5e-3, np.pi / 4, 5e-3 / np.sin(np.pi / 4))
    unit, _, _ = hertz_pressure(design, side, 100.0, _MODULUS)
    force, height = 100.0 * (pressure / unit) ** 3, 0.2 * lead / 5
    given = design, side, (height, height), force, _MODULUS, _CELLS
    sharp, _ = pressures(*given)
    rounded, peak = pressures(*given, edge_radius=_RADIUS)
    return cut, at_point, sharp, rounded, largest, peak


def _lines():
    return [_line(side, *one) for one in _CUT for side in ("screw", "nut")]


def _errors(law: int, reference: int) -> list[float]:
    return [100 * (one[law] / one[reference] - 1) for one in _lines()]


@functools.cache
def _capacities(lead: float) -> list[float]:
    """C_0a whole, 0.2 and 0.15 pitch, C_a whole and 0.2 pitch [kN]."""
    names = ["static_capacity", "dynamic_capacity"]
    cut = [_compute(screw_of_30_mm(lead, addendum), names) for addendum in (0.2, 0.15)]
    whole = _compute(without_addenda(screw_of_30_mm(lead)), names)
    found = [whole[names[0]], cut[0][names[0]], cut[1][names[0]], whole[names[1]], cut[0][names[1]]]
    return [float(value[0]) * 1e-3 for value in found]


def _row(index: int):
    return lambda: [_capacities(lead * 1e-3)[index] for lead in (2, 3, 4, 5, 6, 8, 10)]


def _bearings() -> list[float]:
    """Largest departure from the printed formula over conformities and diameters [%]."""
    worst = 0.0
    for sense in (1, -1):
        for conformity in (0.515, 0.53):
            for ratio in (0.05, 0.3):
                found, balls = ring(conformity, ratio, sense)
                worst = max(worst, abs(found / published(conformity, ratio, sense, balls) - 1))
    return [100 * worst]


def _dent() -> list[float]:
    """Of the actuator under its static capacity, in 1e-4 of the rolling element's diameter."""
    stage = equal_shares("actuator").stages[0]
    capacity = strength.static_capacity(stage)
    return [1e4 * float(strength.permanent_deformation(stage, capacity))]


def _usual_preload() -> list[float]:
    """By how much the usual approximation of the loaded nut is too high at most [%]."""
    loads = jnp.linspace(0.01, 2**1.5, 400)
    exact, _ = strength.preloaded_pair_loads(loads, array(1.0))
    return [float(jnp.max(100 * ((1 + loads / 2.83) ** 1.5 / exact - 1)))]


def _table_line(side: str, lead: float, pressure: float) -> Claim:
    head = f"{side}, {lead * 1e3:g} mm, {pressure * 1e-9:.1f} GPa"
    text = f"| {{}} | {head} | {{}} | {{}} | {{}} | {{}} | {{}} |"
    return Claim(STRENGTH, text, lambda: _line(side, lead, pressure))


CLAIMS = [
    Claim(STRENGTH, "actuator under its $C_{0a}$ at ${}\\cdot10^{-4}$", _dent),
    Claim(
        STRENGTH, "for a ball on a ring, which it does within {} % over", _bearings,
        rounded=False, least=0.9,
    ),
    Claim(STRENGTH, "$F_p (1 + F/2.83 F_p)^{3/2}$, is up to {} % higher", _usual_preload),
    *(_table_line(side, *one) for one in _CUT for side in ("screw", "nut")),
    Claim(
        STRENGTH,
        "the pressure of the laminae differs from the half-spaces by {} to {} %",
        lambda: [min(_errors(1, 2)), max(_errors(1, 2))],
    ),
    Claim(
        STRENGTH,
        "law of the edges is within {} % of the half-spaces in these rows",
        lambda: [max(abs(one) for one in _errors(4, 5))],
        rounded=False,
        least=0.5,
    ),
    *(
        Claim(STRENGTH, f"| {words} | {{}} | {{}} | {{}} | {{}} | {{}} | {{}} | {{}} |", _row(k))
        for k, words in enumerate(
            (
                "$C_{0a}$, whole ellipses (kN)",
                "$C_{0a}$, addenda 0.2 pitch",
                "$C_{0a}$, addenda 0.15 pitch",
                "$C_a$, whole ellipses",
                "$C_a$, addenda 0.2 pitch",
            )
        )
    ),
]  # fmt: skip
