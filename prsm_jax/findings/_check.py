"""All findings of a mechanism."""

from typing import Any, NamedTuple

from ..fields import Scalar
from ..geometry import Finding
from ..mechanism import Mechanism, of_one_known_design
from ..programs import one_program_where_possible, prepare_program
from ..quantities import Analysis
from . import (
    _axis,
    _fit,
    _gears,
    _locking,
    _preferred,
    _sharing,
    _stiffness,
    _strength,
    _truncation,
)
from ._margin import Source, evaluate_margins, findings_of, margins_of, sources
from ._masses import ExpectedMasses, expected_masses, mass_findings_from

#: Modules that declare margins when they are imported.
DECLARED_IN = (
    *(_fit, _gears, _preferred, _stiffness, _locking, _strength, _truncation, _axis),
    _sharing,
)


class CheckNumbers(NamedTuple):
    """What `check` compares."""

    #: Values of the margins; `None` where data are missing.
    margins: list[dict[str, Scalar] | None]
    #: Masses and moments of inertia from dimensions, for each stage.
    masses: list[ExpectedMasses]


def check_numbers(mechanism: Mechanism) -> CheckNumbers:
    """The numbers that `check` compares, as a pure function that can be compiled."""
    return CheckNumbers(evaluate_margins(Analysis(mechanism)), expected_masses(mechanism))


@one_program_where_possible
def _numbers_by(_sources: tuple[Source, ...], mechanism: Mechanism) -> CheckNumbers:
    # Sources are a static argument: a change of them compiles another program.
    return check_numbers(mechanism)


def plain_numbers(values: list[Any]) -> list[dict[str, float] | None]:
    """Values of `evaluate_margins` as Python numbers."""
    return [
        None if numbers is None else {name: float(number) for name, number in numbers.items()}
        for numbers in values
    ]


@of_one_known_design
def check(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Findings that an engineer should know before trusting the results of a mechanism.

    Do the parts fit: `dimension`, `bore`, `feasible_ratio`, `roller_clearance`, `gear_assembly`,
    `gear_mismatch`, `carrier_clearance`, `thread_length`, `pointed_tooth`, `meshing`,
    `contact_on_flank`, `tooth_thickness`, `backlash`. Can they be made with usual tools:
    `unusual_lead`, `unusual_module`. Are the numbers for vibration plausible: `inertia`, `mass`,
    `torsional_support`, `negative_stiffness`. Does friction let the mechanism move: `jamming`,
    `no_balance`, `sinking_load`, `self_locking`. Does it last: `static_safety`, `rating_life`,
    `buckling`, `buckling_stress`, `screw_speed`, `false_brinelling`, `contact_truncation`. Do
    repeated numbers agree: `preload`, `engaged_threads`, `axial_backlash`, `spin_coefficient`. Is
    equal load sharing assumed: `equal_sharing`; do errors of parts overload single rollers:
    `uneven_rollers`. Is the position loop slower than the axis: `position_loop`. Nothing is
    raised; a mechanism without findings gives an empty tuple. Checks whose data are missing are
    skipped. Needs concrete numbers: inside a trace use `evaluate_margins`.

    **Arguments:**

    - `mechanism`: the mechanism.

    **Returns:** the findings, stage by stage.
    """
    return check_from(mechanism, margin_numbers(mechanism))


def margin_numbers(mechanism: Mechanism) -> CheckNumbers:
    """`check_numbers`, compiled once for each structure of a mechanism and set of sources."""
    return _numbers_by(sources(), mechanism)


def prepare_check(mechanism: Mechanism) -> None:
    """Begin to read or compile the program of `check`, beside other work; see `prepare_program`.

    **Arguments:**

    - `mechanism`: has the same structure as the mechanism that will be checked.
    """
    prepare_program(_numbers_by, sources(), mechanism)


def check_from(mechanism: Mechanism, numbers: CheckNumbers) -> tuple[Finding, ...]:
    """As `check`, from numbers that are already computed.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `numbers`: the result of `check_numbers`.
    """
    known = plain_numbers(numbers.margins)
    findings = [finding for _, finding in findings_of(mechanism, known)]
    findings += mass_findings_from(mechanism, numbers.masses)
    findings += _stiffness.shaft_findings(mechanism)
    plays = {
        margin.stage: values["value"]
        for margin, values in zip(margins_of(mechanism), known, strict=True)
        if margin.name == "backlash" and values is not None
    }
    findings += _strength.agreements(mechanism, plays)
    findings += _gears.assembly_notes(mechanism)
    findings += _sharing.sharing_findings(mechanism)
    return tuple(sorted(findings, key=lambda finding: finding.stage))
