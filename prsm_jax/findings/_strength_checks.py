"""Checks of strength, life, speed and play: value, limit, margin and verdict of each.

Values, limits and margins are those of `check` and of the optimiser (`_margin`); quantities that
have no limit are listed with their values.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import jax.numpy as jnp
import numpy as np

from .._errors import MissingDataError
from ..fields import Scalar
from ..geometry import Finding
from ..mechanism import Mechanism, of_one_known_design
from ..programs import one_program_where_possible
from ..quantities import (
    Analysis,
    available_quantities,
    evaluate,
    find_quantity,
    shared_stage_pressures,
    stage_preloaded_pressure,
    stage_pressures,
)
from ..strength import is_preloaded, split_nut_of
from ._check import CheckNumbers, margin_numbers, plain_numbers
from ._margin import Margin, Reading, has_meaning, margins_of, severity_at

Verdict: TypeAlias = Literal["pass", "warning", "fail", "no limit"]
Status: TypeAlias = Literal["pass", "warning", "fail", "no checks"]

#: Names of the margins that are checks, in the order of the table; a quantity of `_WITHOUT_LIMIT`
#: stands after the margin of the same kind.
_ORDER = (
    *("static_safety", "static_capacity", "max_pressure_shared", "max_pressure"),
    "preloaded_pressure",
    *("rating_life", "rating_life_time", "dynamic_capacity", "buckling", "buckling_load"),
    *("screw_speed", "critical_speed", "contact_truncation", "backlash", "axial_backlash"),
    *("lost_motion", "false_brinelling", "jamming", "self_locking", "efficiency"),
)
_MARGINS = (
    *("static_safety", "rating_life", "buckling", "screw_speed", "contact_truncation"),
    *("backlash", "false_brinelling", "jamming", "self_locking"),
)
#: Quantities that are listed beside the margins.
CHECK_VALUES = tuple(name for name in _ORDER if name not in _MARGINS)
#: Pressures of every stage in place of the largest of all.
_PRESSURES = {"max_pressure": stage_pressures, "max_pressure_shared": shared_stage_pressures}
_PRELOADED = "preloaded_pressure"
_PRESSURE_NAMES = (*_PRESSURES, _PRELOADED)
#: Quantities that are left out where a stage has the margin that states the same value.
_STATED_BY = {"rating_life_time": "rating_life", "axial_backlash": "backlash"}
_VERDICTS: dict[str, Verdict] = {"error": "fail", "warning": "warning", "note": "no limit"}


@dataclass(frozen=True)
class StrengthCheck:
    """One check: a value beside its limit.

    - `name`: that of the finding of `check`, or of the quantity.
    - `stage`: number of the stage, from 1; 0 for a value of the whole mechanism.
    - `subject`: distinguishes checks of one name and stage, such as the ends of flanks.
    - `value`, `limit`, `unit`: in SI; the limit is `None` if there is none. The value is NaN where
      it is not defined, such as the efficiency of a load of 0.
    - `at_most`: whether the limit is an upper one.
    - `margin`, `margin_unit`: distance from the limit, negative where it is violated; mostly
      relative ("1"), such as 1 − load/capacity.
    - `verdict`: `"pass"`, `"warning"`, `"fail"` or `"no limit"`.
    - `at_load`: the load at which the value holds, such as `"the static capacity"`, where it is the
      worst of several loads.
    """

    name: str
    stage: int
    value: float
    limit: float | None
    unit: str
    at_most: bool
    margin: float | None
    margin_unit: str
    verdict: Verdict
    subject: str = ""
    at_load: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Everything by the keys of the JSON."""
        return dict(vars(self))


def _of_margin(mechanism: Mechanism, margin: Margin, numbers: dict[str, float]) -> StrengthCheck:
    """The check of an evaluated margin, against the strictest of its limits."""
    value = numbers["value"]
    severity, strictest = margin.strictest
    reading = Reading(mechanism, value, numbers, severity, strictest)
    shown, limit = (value, strictest) if margin.shown is None else margin.shown(reading)
    unit = margin.unit if margin.shown_unit is None else margin.shown_unit
    broken = severity_at(margin, value)
    verdict = "pass" if broken is None else _VERDICTS[broken[0]]
    distance: float | None = value - strictest
    if value != value:
        # A value that does not exist does not keep its limit.
        verdict = "fail"
    if not has_meaning(margin, numbers):
        shown, verdict = float("nan"), "no limit"
    if verdict == "no limit":
        limit = distance = None
    return StrengthCheck(
        margin.name,
        margin.stage,
        shown,
        limit,
        unit,
        margin.at_most,
        distance,
        margin.unit,
        verdict,
        margin.subject,
        "" if margin.at_load is None else margin.at_load(reading),
    )


def _of_margins(
    mechanism: Mechanism, numbers: list[dict[str, float] | None]
) -> Iterator[StrengthCheck]:
    """The checks of all margins; of several margins of one name and subject, the closest."""
    closest: dict[tuple[Any, ...], StrengthCheck] = {}
    for margin, known in zip(margins_of(mechanism), numbers, strict=True):
        if margin.name not in _MARGINS or known is None:
            continue
        one = _of_margin(mechanism, margin, known)
        key = one.name, one.stage, one.subject
        before = closest.get(key)
        if before is None or _rank(one) > _rank(before):
            closest[key] = one
    yield from closest.values()


def _rank(check: StrengthCheck) -> tuple[int, float]:
    """Larger for the more serious verdict, and of two equal ones for the smaller margin."""
    severity = ("no limit", "pass", "warning", "fail").index(check.verdict)
    margin = check.margin
    return severity, -np.inf if margin is None or margin != margin else -margin


def _of_values(
    mechanism: Mechanism, values: Mapping[str, Any], stated: set[tuple[str, int]]
) -> Iterator[StrengthCheck]:
    for name in CHECK_VALUES:
        if name not in values or (name == "max_pressure" and "max_pressure_shared" in values):
            continue
        unit, numbers = find_quantity(name).unit, np.ravel(np.asarray(values[name], dtype=float))
        per_stage = np.ndim(values[name]) == 1
        for index, value in enumerate(numbers):
            stage = index + 1 if per_stage else 0
            if (_STATED_BY.get(name, ""), stage) in stated:
                continue
            if np.isneginf(value):
                continue
            if name in _PRESSURE_NAMES:
                yield _pressure(mechanism, name, stage, float(value))
            else:
                yield StrengthCheck(
                    name, stage, float(value), None, unit, False, None, "1", "no limit"
                )


def _pressure(mechanism: Mechanism, name: str, number: int, value: float) -> StrengthCheck:
    """The largest pressure of a stage at the operating point beside the permissible one.

    `max_pressure` is without the preload of two nuts, and so is `max_pressure_shared` unless the
    nut is a modelled split one: within the limit they prove nothing there. `preloaded_pressure`
    proves it, except where the shares of the threads are known to differ. It has no limit beside a
    modelled split nut, whose pressures say more.
    """
    stage = mechanism.stages[max(number - 1, 0)]
    strength = stage.strength
    permissible = None if strength is None else strength.permissible_pressure
    split = split_nut_of(stage) is not None
    if name == _PRELOADED:
        proves = stage.load_sharing is None
        if split:
            permissible = None
    else:
        proves = (name == "max_pressure_shared" and split) or not is_preloaded(stage)
    limit = None if permissible is None else float(permissible)
    if limit is None or (value <= limit and not proves):
        return StrengthCheck(name, number, value, None, "Pa", True, None, "1", "no limit")
    verdict: Verdict = "pass" if value <= limit else "fail"
    return StrengthCheck(name, number, value, limit, "Pa", True, 1 - value / limit, "1", verdict)


def strength_checks_from(
    mechanism: Mechanism, numbers: CheckNumbers, values: Mapping[str, Any]
) -> tuple[StrengthCheck, ...]:
    """As `strength_checks`, from numbers that are already computed.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `numbers`: the result of `check_numbers`.
    - `values`: quantities of `CHECK_VALUES` by name, as far as known; others are ignored.
    """
    checks = list(_of_margins(mechanism, plain_numbers(numbers.margins)))
    checks += _of_values(mechanism, values, {(one.name, one.stage) for one in checks})
    # Sorting is stable: subjects stay in their order.
    return tuple(sorted(checks, key=lambda one: (_ORDER.index(one.name), one.stage)))


@one_program_where_possible
def _values(mechanism: Mechanism, names: tuple[str, ...]) -> dict[str, Any]:
    analysis = Analysis(mechanism)
    values = evaluate(analysis, names)
    if len(mechanism.stages) > 1:
        # Each stage has its own permissible pressure.
        values |= {name: of(analysis) for name, of in _PRESSURES.items() if name in values}
        if _PRELOADED not in values and any(map(is_preloaded, mechanism.stages)):
            # The quantity needs a preload of all stages.
            stages = range(len(mechanism.stages))
            values[_PRELOADED] = jnp.stack([_preloaded(analysis, index) for index in stages])
    return values


def _preloaded(analysis: Analysis, index: int) -> Scalar:
    """Pressure of a stage with its preload; −∞, which no pressure is, for a stage without one."""
    try:
        return stage_preloaded_pressure(analysis, index)
    except MissingDataError:
        return jnp.full_like(analysis.mechanism.stages[index].thread.lead, -jnp.inf)


def check_values(mechanism: Mechanism) -> dict[str, Any]:
    """The quantities of `CHECK_VALUES` that a mechanism has the data for."""
    return _values(mechanism, available_quantities(mechanism, CHECK_VALUES))


@of_one_known_design
def strength_checks(mechanism: Mechanism) -> tuple[StrengthCheck, ...]:
    """Value, limit, margin and verdict of strength, life, speed, play and friction.

    Static safety, contact pressure, rating life, buckling, screw speed, ends of contact ellipses,
    backlash, oscillation, jamming and self-locking, each for every stage that has the data.
    Limits and margins are those of `check` and of the optimiser: a verdict is `"fail"` where
    `check` finds an error, and `"warning"` where it finds a warning. The limit of a contact
    pressure is `permissible_pressure`, at the operating point; `static_safety` applies it to the
    largest load. Quantities without a limit have the verdict `"no limit"`. Needs concrete numbers.

    **Arguments:**

    - `mechanism`: the mechanism.

    **Returns:** the checks; none for a mechanism without data of strength and friction.
    """
    values = check_values(mechanism)
    return strength_checks_from(mechanism, margin_numbers(mechanism), values)


def status_of(checks: Iterable[StrengthCheck], findings: Iterable[Finding] | None) -> Status:
    """The worst verdict of checks and findings; `"no checks"` if neither has a limit to keep.

    **Arguments:**

    - `checks`: from `strength_checks`.
    - `findings`: from `check`; `None`, where they could not be made, is a warning.
    """
    verdicts = {one.verdict for one in checks}
    severities = {"warning"} if findings is None else {one.severity for one in findings}
    if "fail" in verdicts or "error" in severities:
        return "fail"
    if "warning" in verdicts or "warning" in severities:
        return "warning"
    return "pass" if "pass" in verdicts else "no checks"
