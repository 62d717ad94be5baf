"""Margins of strength and life: dents, fatigue, buckling, whirling, false brinelling, play."""

import math
from collections.abc import Iterator

import jax.numpy as jnp

from .. import strength
from ..geometry import Finding, Severity
from ..mechanism import Mechanism, Scalar, Stage, Strength
from ..quantities import (
    Analysis,
    derives_dynamic_capacity,
    derives_static_capacity,
    minimum_amplitude_of,
    on_one_flank,
    rating_life_of,
    static_capacity_of,
)
from ._agreement import agreement_findings
from ._margin import Margin, Reading, margin_source

#: What catalogues of ball screws ask for against buckling.
_BUCKLING_SAFETY = 2.0


def _data(mechanism: Mechanism, index: int) -> Strength | None:
    return mechanism.stages[index].strength


def _stage(analysis: Analysis, index: int) -> tuple[Stage, Strength]:
    stage = analysis.mechanism.stages[index]
    return stage, strength.strength_of(stage)


def _safety(value: float) -> float:
    """Safety factor of a margin 1 - load / capacity."""
    return math.inf if value >= 1 else 1 / (1 - value)


@margin_source
def _static_safety(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    data = _data(mechanism, index)
    if data is None or (data.permissible_pressure is None and data.static_capacity is None):
        return

    def value(analysis: Analysis) -> Scalar:
        stage, _ = _stage(analysis, index)
        # Of the load, not of the capacity: finite without load.
        load = on_one_flank(analysis, stage)
        return 1 - load / static_capacity_of(analysis, index, stage)

    yield Margin(
        "static_safety",
        index + 1,
        value,
        (("error", 0.0),),
        lambda r: (
            f"the largest load is {1 / _safety(r.value):.3g} times the static capacity: it leaves "
            "dents in the threads that roughen the motion; add engaged threads or rollers, or "
            "lower the load"
        ),
        shown=lambda r: (_safety(r.value), 1.0),
        shares=("largest",) if derives_static_capacity(mechanism.stages[index]) else (),
    )


@margin_source
def _buckling(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    data = _data(mechanism, index)
    if data is None or data.shaft is None:
        return

    def value(analysis: Analysis) -> Scalar:
        stage, _ = _stage(analysis, index)
        return 1 - analysis.demand[1] / strength.buckling_load(stage)

    yield Margin(
        "buckling",
        index + 1,
        value,
        (("error", 0.0), ("warning", 1 - 1 / _BUCKLING_SAFETY)),
        lambda r: (
            f"the buckling load of the screw is {_safety(r.value):.3g} times the largest load, "
            f"and should be {_BUCKLING_SAFETY:.3g} times: shorten the loaded length, fix the ends, "
            "or take a larger screw"
        ),
        shown=lambda r: (_safety(r.value), _BUCKLING_SAFETY),
    )


@margin_source
def _screw_speed(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    data = _data(mechanism, index)
    if data is None or data.shaft is None:
        return

    def details(analysis: Analysis) -> dict[str, Scalar]:
        stage, _ = _stage(analysis, index)
        return {
            "speed": analysis.demand[0],
            "permissible": strength.permissible_speed(stage),
            "critical": strength.critical_speed(stage),
        }

    def message(r: Reading) -> str:
        past = r.severity == "error"
        what = "its critical speed" if past else "the permissible speed"
        limit = r.details["critical" if past else "permissible"]
        return (
            f"the screw turns at {r.details['speed'] * 30 / math.pi:.5g} rpm, above {what} of "
            f"{limit * 30 / math.pi:.5g} rpm: shorten the unsupported length, fix the ends, or "
            "take a larger lead"
        )

    levels: tuple[tuple[Severity, str], ...] = (("error", "critical"), ("warning", "permissible"))
    for severity, limit in levels:

        def value(analysis: Analysis, limit=limit) -> Scalar:
            found = details(analysis)
            return 1 - found["speed"] / found[limit]

        yield Margin(
            "screw_speed",
            index + 1,
            value,
            ((severity, 0.0),),
            message,
            details=details,
            shown=lambda r: (r.details["speed"], r.details["permissible"]),
        )


@margin_source
def _rating_life(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    data = _data(mechanism, index)
    if data is None or data.required_life is None:
        return

    def details(analysis: Analysis) -> dict[str, Scalar]:
        stage, data = _stage(analysis, index)
        life = rating_life_of(analysis, index, stage).time
        factor = strength.life_factor(stage)
        assert data.required_life is not None
        return {"life": life if factor is None else life * factor, "asked": data.required_life}

    def value(analysis: Analysis) -> Scalar:
        found = details(analysis)
        return found["life"] / found["asked"] - 1

    def message(r: Reading) -> str:
        life, asked = r.details["life"], r.details["asked"]
        return (
            f"the rating life is {life / 3600:.4g} h, and {asked / 3600:.4g} h are asked for: "
            f"a dynamic capacity {(asked / life) ** (1 / 3):.3g} times as high would do (rests "
            "on the practice of ball screws and bearings)"
        )

    yield Margin(
        "rating_life",
        index + 1,
        value,
        (("warning", 0.0),),
        message,
        details=details,
        shown=lambda r: (r.details["life"], r.details["asked"]),
        shares=("equivalent",) if derives_dynamic_capacity(mechanism.stages[index]) else (),
    )


@margin_source
def _false_brinelling(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    data = _data(mechanism, index)
    if data is None or data.oscillation_amplitude is None:
        return

    def details(analysis: Analysis) -> dict[str, Scalar]:
        stage, data = _stage(analysis, index)
        assert data.oscillation_amplitude is not None
        smallest = minimum_amplitude_of(analysis, index, stage)
        return {"amplitude": data.oscillation_amplitude, "smallest": smallest}

    def value(analysis: Analysis) -> Scalar:
        found = details(analysis)
        return found["amplitude"] - found["smallest"]

    yield Margin(
        "false_brinelling",
        index + 1,
        value,
        (("warning", 0.0),),
        lambda r: (
            f"the screw swings by {math.degrees(r.details['amplitude']):.3g} deg to either side, "
            "and its contacts leave their own ellipse only from "
            f"{math.degrees(r.details['smallest']):.3g} deg on: they wear in place, which no "
            "rating life covers; turn it further from time to time"
        ),
        unit="rad",
        details=details,
        shown=lambda r: (r.details["amplitude"], r.details["smallest"]),
    )


@margin_source
def _backlash(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    if not strength.needs_meshing_for_backlash(mechanism.stages[index]):
        return
    yield Margin(
        "backlash",
        index + 1,
        lambda analysis: strength.backlash(
            analysis.mechanism.stages[index], analysis.kinematics[index].meshing
        ),
        (("error", 0.0),),
        lambda r: (
            f"the teeth of screw, rollers and nut interfere by {-r.value * 1e3:.4g} mm together: "
            "thin them further, or give the preload that this is meant to make"
        ),
        unit="m",
        kind="assembly",
        # A micrometre of play, so that rounding in a file does not close it.
        reserve=1e-6,
    )


def agreements(mechanism: Mechanism, backlash: dict[int, float]) -> Iterator[Finding]:
    """Numbers that strength and load sharing both have, and that contradict each other.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `backlash`: play that thinned teeth leave [m], by stage (from 1), where that is known.
    """
    for number, stage in enumerate(mechanism.stages, start=1):
        play = backlash.get(number)
        teeth = None if play is None else jnp.asarray(play)
        yield from agreement_findings(stage, number, teeth)
