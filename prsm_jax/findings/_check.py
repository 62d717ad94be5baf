"""All findings of a mechanism."""

from typing import Any

import equinox as eqx

from ..fields import Scalar
from ..geometry import Finding
from ..mechanism import Mechanism, of_one_known_design
from ..quantities import Analysis
from . import _fit, _locking, _preferred, _stiffness, _strength, _truncation
from ._margin import Source, evaluate_margins, findings_of, margins_of, sources
from ._masses import mass_findings
from ._sharing import sharing_findings

#: Modules that declare margins when they are imported.
DECLARED_IN = (_fit, _preferred, _stiffness, _locking, _strength, _truncation)


def check_margins(mechanism: Mechanism) -> list[dict[str, Scalar] | None]:
    """Values of all margins that `check` compares, as a pure function that can be compiled."""
    return evaluate_margins(Analysis(mechanism))


@eqx.filter_jit
def _margins_by(_sources: tuple[Source, ...], mechanism: Mechanism):
    # Sources are a static argument: a change of them compiles another program.
    return check_margins(mechanism)


def _plain(values: list[Any]) -> list[dict[str, float] | None]:
    return [
        None if numbers is None else {name: float(number) for name, number in numbers.items()}
        for numbers in values
    ]


@of_one_known_design
def check(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Findings that an engineer should know before trusting the results of a mechanism.

    Do the parts fit: `dimension`, `feasible_ratio`, `roller_clearance`, `gear_assembly`,
    `carrier_clearance`, `meshing`, `contact_on_flank`, `tooth_thickness`, `backlash`. Can they
    be made with usual tools: `unusual_lead`, `unusual_module`. Are the numbers for vibration
    plausible: `inertia`, `mass`, `torsional_support`, `negative_stiffness`. Does friction let
    the mechanism move: `jamming`, `self_locking`. Does it last: `static_safety`, `rating_life`,
    `buckling`, `screw_speed`, `false_brinelling`, `contact_truncation`. Do repeated numbers agree:
    `preload`, `engaged_threads`, `axial_backlash`, `spin_coefficient`. Is equal load sharing
    assumed: `equal_sharing`. Nothing is raised; a mechanism without findings gives an empty tuple.
    Checks whose data are missing are skipped. Needs concrete numbers: inside a trace use
    `evaluate_margins`.

    **Arguments:**

    - `mechanism`: the mechanism.

    **Returns:** the findings, stage by stage.
    """
    return check_from(mechanism, _margins_by(sources(), mechanism))


def check_from(mechanism: Mechanism, values: list[dict[str, Scalar] | None]) -> tuple[Finding, ...]:
    """As `check`, from margin values that are already computed.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `values`: the result of `check_margins`.
    """
    known = _plain(values)
    findings = [finding for _, finding in findings_of(mechanism, known)]
    findings += mass_findings(mechanism)
    findings += _stiffness.shaft_findings(mechanism)
    plays = {
        margin.stage: numbers["value"]
        for margin, numbers in zip(margins_of(mechanism), known, strict=True)
        if margin.name == "backlash" and numbers is not None
    }
    findings += _strength.agreements(mechanism, plays)
    findings += _fit.assembly_notes(mechanism)
    findings += sharing_findings(mechanism)
    return tuple(sorted(findings, key=lambda finding: finding.stage))


#: Names of findings on given stiffnesses, and on strength and life.
_STIFFNESS = ("negative_stiffness", "torsional_support")
_STRENGTH = (
    *("static_safety", "rating_life", "buckling", "screw_speed", "false_brinelling", "backlash"),
    *("preload", "engaged_threads", "axial_backlash", "contact_truncation"),
)


def stiffness_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Findings of `check` on given stiffnesses that are negative or implausible for a shaft."""
    return tuple(finding for finding in check(mechanism) if finding.name in _STIFFNESS)


def strength_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Findings of `check` on strength, life, speed, play and preload."""
    return tuple(finding for finding in check(mechanism) if finding.name in _STRENGTH)
