"""Margins of strength: plastic dents, life, buckling, whirling, false brinelling, play."""

import functools
import math
from collections.abc import Callable, Iterator

import jax.numpy as jnp

from .. import strength
from ..fields import Scalar
from ..geometry import Finding, Severity
from ..mechanism import Mechanism, Stage, Strength
from ..quantities import (
    Analysis,
    SharedLoad,
    derives_dynamic_capacity,
    derives_static_capacity,
    minimum_amplitude_of,
    on_one_flank,
    rating_life_of,
    static_capacity_of,
)
from ._agreement import agreement_findings
from ._margin import Margin, Reading, Source, margin_source

#: Safety factor against buckling that ball screw catalogues require.
_BUCKLING_SAFETY = 2.0
#: Half the yield strength of a quenched and tempered screw (900 MPa): above it Johnson's formula
#: holds, not Euler's [Pa].
_LARGEST_EULER_STRESS = 450e6


def _where_given(*names: str) -> Callable[[Source], Source]:
    """Register margins of stages whose strength data have at least one of these entries."""

    def register(margins: Source) -> Source:
        # The name of a source says which programs were compiled with it.
        @functools.wraps(margins)
        def source(mechanism: Mechanism, index: int) -> Iterator[Margin]:
            data = mechanism.stages[index].strength
            if data is not None and any(getattr(data, name) is not None for name in names):
                yield from margins(mechanism, index)

        return margin_source(source)

    return register


def _at_least(
    name: str,
    index: int,
    pair: Callable[[Analysis], tuple[Scalar, Scalar]],
    message: Callable[[Reading], str],
    shown_unit: str,
    unit: str = "1",
    shares: tuple[SharedLoad, ...] = (),
) -> Margin:
    """A warning where the available value is less than the required one.

    The margin is their difference, or, without a unit, their quotient minus 1; both values are in
    the details, as `available` and `required`.
    """

    def value(analysis: Analysis) -> Scalar:
        available, required = pair(analysis)
        return available / required - 1 if unit == "1" else available - required

    return Margin(
        name,
        index + 1,
        value,
        (("warning", 0.0),),
        message,
        unit=unit,
        details=lambda analysis: dict(zip(("available", "required"), pair(analysis), strict=True)),
        shown=lambda r: (r.details["available"], r.details["required"]),
        shown_unit=shown_unit,
        shares=shares,
    )


def _stage(analysis: Analysis, index: int) -> tuple[Stage, Strength]:
    stage = analysis.mechanism.stages[index]
    return stage, strength.strength_of(stage)


def _safety(value: float) -> float:
    """Safety factor of a margin 1 - load / capacity."""
    return math.inf if value >= 1 else 1 / (1 - value)


@_where_given("permissible_pressure", "static_capacity")
def _static_safety(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    def value(analysis: Analysis) -> Scalar:
        stage, _ = _stage(analysis, index)
        # Load over capacity, not the reverse: finite without load.
        load = on_one_flank(analysis, stage)
        return 1 - load / static_capacity_of(analysis, index, stage)

    yield Margin(
        "static_safety",
        index + 1,
        value,
        (("error", 0.0),),
        lambda r: (
            f"the largest load is {1 / _safety(r.value):.3g} times the static capacity: permanent "
            "dents in the threads make the motion rough; add engaged threads or rollers, or "
            "lower the load"
        ),
        shown=lambda r: (_safety(r.value), 1.0),
        shares=("largest",) if derives_static_capacity(mechanism.stages[index]) else (),
    )


@_where_given("shaft")
def _buckling(mechanism: Mechanism, index: int) -> Iterator[Margin]:
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
            f"but should be {_BUCKLING_SAFETY:.3g} times: shorten the loaded length, fix the ends, "
            "or take a larger screw"
        ),
        shown=lambda r: (_safety(r.value), _BUCKLING_SAFETY),
    )


@_where_given("shaft")
def _buckling_stress(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    data = mechanism.stages[index].strength
    assert data is not None
    assert data.shaft is not None
    if data.shaft.yield_strength is not None:
        return

    def value(analysis: Analysis) -> Scalar:
        return 1 - strength.buckling_stress(_stage(analysis, index)[0]) / _LARGEST_EULER_STRESS

    def stress(r: Reading) -> float:
        return (1 - r.value) * _LARGEST_EULER_STRESS

    yield Margin(
        "buckling_stress",
        index + 1,
        value,
        (("warning", 0.0),),
        lambda r: (
            f"the buckling load of this short screw is {stress(r) / 1e6:.4g} MPa on the section of "
            "its root by Euler's formula, where steel may yield first: give "
            "stage.strength.shaft.yield_strength, so that Johnson's formula applies"
        ),
        shown=lambda r: (stress(r), _LARGEST_EULER_STRESS),
        shown_unit="Pa",
        at_most=True,
        # The remedy is a number of the file, not another design.
        smooth=False,
    )


@_where_given("shaft")
def _screw_speed(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    turning = mechanism.stages[index].thread.family.turning

    def details(analysis: Analysis) -> dict[str, Scalar]:
        stage, _ = _stage(analysis, index)
        speeds = {"speed": analysis.demand[0], "permissible": strength.permissible_speed(stage)}
        # A screw that does not turn has no critical speed.
        return speeds | ({"critical": strength.critical_speed(stage)} if turning == "screw" else {})

    def by_dn(r: Reading) -> bool:
        """Whether the DN limit is what makes the permissible speed low."""
        data = r.mechanism.stages[index].strength
        assert data is not None
        assert data.shaft is not None
        share = float(data.shaft.permissible_speed_share)
        return turning == "nut" or r.details["permissible"] < 0.999 * share * r.details["critical"]

    def message(r: Reading, limit: str) -> str:
        words = {"critical": "its critical speed", "permissible": "the permissible speed"}[limit]
        remedy = "shorten the unsupported length, fix the ends, or take a larger lead"
        if limit == "permissible" and by_dn(r):
            remedy = "take a larger lead, or a lubricant with a higher DN limit"
        return (
            f"the {turning} turns at {r.details['speed'] * 30 / math.pi:.5g} rpm, above {words} "
            f"of {r.details[limit] * 30 / math.pi:.5g} rpm: {remedy}"
        )

    def margin(severity: Severity, limit: str) -> Margin:
        def value(analysis: Analysis) -> Scalar:
            speeds = details(analysis)
            return 1 - speeds["speed"] / speeds[limit]

        return Margin(
            "screw_speed",
            index + 1,
            value,
            ((severity, 0.0),),
            lambda r: message(r, limit),
            details=details,
            shown=lambda r: (r.details["speed"], r.details[limit]),
            shown_unit="rad/s",
            at_most=True,
        )

    if turning == "screw":
        yield margin("error", "critical")
    yield margin("warning", "permissible")


@_where_given("required_life")
def _rating_life(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    def lives(analysis: Analysis) -> tuple[Scalar, Scalar]:
        stage, data = _stage(analysis, index)
        life = rating_life_of(analysis, index, stage).time
        factor = strength.life_factor(stage)
        assert data.required_life is not None
        return life if factor is None else life * factor, data.required_life

    def message(r: Reading) -> str:
        life, required = r.details["available"], r.details["required"]
        return (
            f"the rating life is {life / 3600:.4g} h, but {required / 3600:.4g} h are required: "
            f"a dynamic capacity {(required / life) ** (1 / 3):.3g} times as high would suffice "
            "(based on the practice for ball screws and bearings)"
        )

    shares: tuple[SharedLoad, ...] = ()
    if derives_dynamic_capacity(mechanism.stages[index]):
        shares = ("equivalent",)
    yield _at_least("rating_life", index, lives, message, "s", shares=shares)


@_where_given("oscillation_amplitude")
def _false_brinelling(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    def amplitudes(analysis: Analysis) -> tuple[Scalar, Scalar]:
        stage, data = _stage(analysis, index)
        assert data.oscillation_amplitude is not None
        return data.oscillation_amplitude, minimum_amplitude_of(analysis, index, stage)

    def message(r: Reading) -> str:
        turning = mechanism.stages[index].thread.family.turning
        return (
            f"the {turning} oscillates by {math.degrees(r.details['available']):.3g} deg to either "
            "side, but its contacts leave their own ellipse only from "
            f"{math.degrees(r.details['required']):.3g} deg on: they wear locally, which the "
            f"rating life does not cover; turn the {turning} further from time to time"
        )

    yield _at_least("false_brinelling", index, amplitudes, message, "rad", unit="rad")


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
            f"the teeth of screw, rollers and nut interfere by {-r.value * 1e3:.4g} mm in total: "
            "thin them further, or give the preload that this interference should produce"
        ),
        unit="m",
        kind="assembly",
        # A micrometre of play, so that rounding in a file does not close it.
        reserve=1e-6,
    )


def agreements(mechanism: Mechanism, backlash: dict[int, float]) -> Iterator[Finding]:
    """Findings on quantities that a stage states twice, with contradictory values.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `backlash`: play from thinned teeth [m] by stage (from 1), where known.
    """
    for number, stage in enumerate(mechanism.stages, start=1):
        play = backlash.get(number)
        teeth = None if play is None else jnp.asarray(play)
        yield from agreement_findings(stage, number, teeth)
