"""Margins: the quantities behind findings, declared once for `check` and for the optimiser.

A margin is a quantity that should not fall below a limit, with the severity and the message of
the finding if it does. `check` compares its value; the optimiser takes every limit of
severity error as a constraint, with exact derivatives, and on request those of warnings. To add a
finding, write a source (see `margin_source`) in one of the files of this folder.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import jax.numpy as jnp
from jaxtyping import Array, Bool, Int

from .._errors import MissingDataError
from ..fields import Scalar, old_name, renamed_arguments
from ..geometry import Finding, Severity
from ..mechanism import Mechanism
from ..quantities import Analysis, SharedLoad

#: What a violated limit of severity error means for the other results. `existence`: no such
#: mechanism exists, and its other numbers are meaningless. `assembly`: it cannot be assembled as
#: drawn; its numbers are computed as if it could. `service`: it can be built, but fails under its
#: load.
Kind: TypeAlias = Literal["existence", "assembly", "service"]


@dataclass(frozen=True)
class Reading:
    """The evaluated margin of one mechanism, with the limit that it violates."""

    mechanism: Mechanism
    value: float
    #: Further numbers for the message.
    details: dict[str, float]
    severity: Severity
    limit: float


@renamed_arguments(whole="integer")
@dataclass(frozen=True)
class Margin:
    """A quantity of one stage that should not fall below its limits.

    `value` is differentiable, finite wherever the mechanism meshes, and larger when better.
    """

    #: Name of the finding.
    name: str
    #: Number of the stage, from 1.
    stage: int
    value: Callable[[Analysis], Scalar]
    #: Pairs of severity and limit; the first limit that the value falls below counts.
    levels: tuple[tuple[Severity, float], ...]
    message: Callable[[Reading], str]
    unit: str = "1"
    kind: Kind = "service"
    #: Numbers for the message beside the value.
    details: Callable[[Analysis], dict[str, Scalar]] | None = None
    #: Whether the value means something, from value and details; default always. Where it means
    #: nothing there is no finding, and the check has no value.
    applies: Callable[[dict[str, float]], bool] | None = None
    #: Value and limit that the finding shows, where those of the margin are less clear to a reader.
    shown: Callable[[Reading], tuple[float, float]] | None = None
    #: SI unit of `shown`; default that of the value.
    shown_unit: str | None = None
    #: Load at which the value holds, in words, where it is the worst of several.
    at_load: Callable[[Reading], str] | None = None
    #: Whether the limit of `shown` is an upper one.
    at_most: bool = False
    #: How far inside the limit the optimiser stays, for rounding in a file [unit of the value].
    reserve: float = 1e-4
    #: Whether a value equal to the limit violates it.
    strict: bool = False
    #: Whether the value must also be a whole number.
    integer: bool = False
    #: False for what is no constraint of a search: a yes-or-no condition, which has no derivative,
    #: and a finding whose remedy is a number of the file.
    smooth: bool = True
    #: Distinguishes findings of one name and stage; for each subject the worst is reported.
    subject: str = ""
    #: Loads for which the margin needs the load distribution (`Analysis.distribution`).
    shares: tuple[SharedLoad, ...] = ()

    @property
    def strictest(self) -> tuple[Severity, float]:
        """The highest limit of severity warning or error, with its severity.

        **Raises:** `ValueError` if all limits are of severity note.
        """
        return max((one for one in self.levels if one[0] != "note"), key=lambda one: one[1])

    @property
    def whole(self) -> bool:
        """Old name of `integer`."""
        return old_name(self, "whole", "integer")

    @property
    def error_limit(self) -> float | None:
        """The limit below which the finding is an error, if there is one."""
        return next((limit for severity, limit in self.levels if severity == "error"), None)


#: Yields the margins of a stage (index from 0); depends on the structure of the mechanism only.
Source: TypeAlias = Callable[[Mechanism, int], Iterator[Margin]]
_SOURCES: list[Source] = []
_ORDER: tuple[Severity, ...] = ("error", "warning", "note")
#: Distance from a whole number due to rounding: some numbers are ratios of measured radii.
_ROUNDING = 1e-6


def margin_source(source: Source) -> Source:
    """Register a function that yields margins of a stage for `check` and the optimiser.

    It is called inside and outside of traces, and must yield the same margins for mechanisms of
    the same structure.
    """
    _SOURCES.append(source)
    return source


def sources() -> tuple[Source, ...]:
    """All sources; every set of sources has its own compiled program."""
    return tuple(_SOURCES)


def margins_of(mechanism: Mechanism) -> tuple[Margin, ...]:
    """The margins that a mechanism of this structure has, stage by stage."""
    return tuple(
        margin
        for index in range(len(mechanism.stages))
        for source in _SOURCES
        for margin in source(mechanism, index)
    )


def shared_loads(
    margins: Iterable[Margin], wanted: Callable[[Margin], bool] = lambda _: True
) -> tuple[SharedLoad, ...]:
    """Loads for which margins need the load distribution, for `Analysis.expect`."""
    return tuple(dict.fromkeys(load for m in margins if wanted(m) for load in m.shares))


def evaluate_margins(
    analysis: Analysis,
    wanted: Callable[[Margin], bool] = lambda _: True,
    *,
    details: bool = True,
) -> list[dict[str, Scalar] | None]:
    """Values of all margins of an analysis, jittable and differentiable.

    **Arguments:**

    - `analysis`: of the mechanism, inside or outside a trace.
    - `wanted`: which margins to evaluate.
    - `details`: whether to evaluate the further numbers for messages too.

    **Returns:** one entry for each of `margins_of`: `value` and details by name, or `None` where
    the margin is not selected or its data are missing.
    """
    values: list[dict[str, Scalar] | None] = []
    margins = margins_of(analysis.mechanism)
    analysis.expect(shared_loads(margins, wanted))
    for margin in margins:
        if not wanted(margin):
            values.append(None)
            continue
        try:
            numbers = {"value": jnp.asarray(margin.value(analysis))}
            if details and margin.details is not None:
                numbers |= margin.details(analysis)
        except MissingDataError:
            values.append(None)
            continue
        values.append(numbers)
    return values


def is_whole(value: float) -> bool:
    """Whether a number is whole, within the rounding of derived numbers."""
    return abs(value - round(value)) < _ROUNDING


def severity_at(margin: Margin, value: float) -> tuple[Severity, float] | None:
    """Severity and limit that a value violates, or `None`.

    NaN violates a condition of existence; in any other margin it is only a consequence.
    """
    if value != value:
        return margin.levels[0] if margin.kind == "existence" else None
    for severity, limit in margin.levels:
        below = value <= limit if margin.strict else value < limit
        if below or (margin.integer and severity == "error" and not is_whole(value)):
            return severity, limit
    return None


def has_meaning(margin: Margin, numbers: dict[str, float]) -> bool:
    """Whether the value of an evaluated margin means something (`Margin.applies`)."""
    return margin.applies is None or margin.applies(numbers)


def is_error(margin: Margin, value: Scalar) -> Bool[Array, ""]:
    """Whether a value makes the finding an error; as `severity_at`, in a trace."""
    limit = margin.error_limit
    if limit is None:
        return jnp.asarray(False)
    broken = value <= limit if margin.strict else value < limit
    if margin.integer:
        broken = broken | (jnp.abs(value - jnp.round(value)) >= _ROUNDING)
    return broken | jnp.isnan(value) if margin.kind == "existence" else broken


def error_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Names of the findings that can be errors of a mechanism of this structure, each once."""
    margins = margins_of(mechanism)
    return tuple(dict.fromkeys(m.name for m in margins if m.error_limit is not None))


def first_error(analysis: Analysis) -> Int[Array, ""]:
    """The first error of `check`, in a trace: its place in `error_names` from 1, or 0 for none."""
    names, code = error_names(analysis.mechanism), jnp.asarray(0)
    margins = margins_of(analysis.mechanism)
    values = evaluate_margins(analysis, lambda m: m.error_limit is not None, details=False)
    for margin, numbers in reversed(list(zip(margins, values, strict=True))):
        if numbers is not None:
            place = names.index(margin.name) + 1
            code = jnp.where(is_error(margin, numbers["value"]), place, code)
    return code


def finding_of(
    mechanism: Mechanism, margin: Margin, numbers: dict[str, float] | None
) -> Finding | None:
    """The finding of an evaluated margin, if it violates a limit."""
    if numbers is None or not has_meaning(margin, numbers):
        return None
    broken = severity_at(margin, numbers["value"])
    if broken is None:
        return None
    reading = Reading(mechanism, numbers["value"], numbers, *broken)
    value, limit = (reading.value, reading.limit) if margin.shown is None else margin.shown(reading)
    return Finding(
        margin.name,
        broken[0],
        margin.stage,
        value,
        limit,
        margin.message(reading),
        impossible=broken[0] == "error" and margin.kind != "service",
    )


def findings_of(
    mechanism: Mechanism, values: list[dict[str, float] | None]
) -> Iterator[tuple[Margin, Finding]]:
    """The findings of evaluated margins: the most serious per name, stage and subject."""
    worst: dict[tuple[Any, ...], tuple[Margin, Finding]] = {}
    for margin, numbers in zip(margins_of(mechanism), values, strict=True):
        finding = finding_of(mechanism, margin, numbers)
        if finding is None:
            continue
        key = margin.name, margin.stage, margin.subject
        previous = worst.get(key)
        if previous is None or _ORDER.index(finding.severity) < _ORDER.index(previous[1].severity):
            worst[key] = margin, finding
    yield from worst.values()
