"""All findings of a mechanism together."""

import equinox as eqx

from ..geometry import Finding
from ..mechanism import Mechanism, Scalar, of_one_known_design
from ..quantities import Analysis
from . import _fit, _locking, _preferred, _stiffness, _strength, _truncation
from ._margin import Source, evaluate_margins, findings_of, margins_of, sources
from ._masses import mass_findings
from ._sharing import sharing_findings

#: The files that declare margins; to import them is to declare.
DECLARED_IN = (_fit, _preferred, _stiffness, _locking, _strength, _truncation)


def check_margins(mechanism: Mechanism) -> list[dict[str, Scalar] | None]:
    """Values of all margins: what `check` computes, as a pure function for a program of its own."""
    return evaluate_margins(Analysis(mechanism))


@eqx.filter_jit
def _margins_by(_sources: tuple[Source, ...], mechanism: Mechanism):
    # Other sources, even as many, are another static argument, and so another program.
    return check_margins(mechanism)


def _plain(values: list) -> list[dict[str, float] | None]:
    return [
        None if numbers is None else {name: float(number) for name, number in numbers.items()}
        for numbers in values
    ]


@of_one_known_design
def check(mechanism: Mechanism) -> tuple[Finding, ...]:
    """What an engineer should know about a mechanism before trusting its results, by name.

    Does it fit together: `dimension`, `feasible_ratio`, `roller_clearance`, `gear_assembly`,
    `carrier_clearance`, `meshing`, `contact_on_flank`, `tooth_thickness`, `backlash`. Can it be
    made with usual tools: `unusual_lead`, `unusual_module`. Do the numbers behind its vibration
    make sense: `inertia`, `mass`, `torsional_support`, `negative_stiffness`. Does friction let it
    move: `jamming`, `self_locking`. Does it last: `static_safety`, `rating_life`, `buckling`,
    `screw_speed`, `false_brinelling`, `contact_truncation`. Do its numbers agree: `preload`,
    `engaged_threads`, `axial_backlash`, `spin_coefficient`. Do threads share as assumed:
    `equal_sharing`. Nothing is raised; a mechanism without findings gives an empty tuple. Of what
    lacks data nothing is found. Needs concrete numbers: inside a trace use `evaluate_margins`.

    **Arguments:**

    - `mechanism`: the mechanism.

    **Returns:** the findings, stage by stage.
    """
    return check_from(mechanism, _margins_by(sources(), mechanism))


def check_from(mechanism: Mechanism, values: list[dict[str, Scalar] | None]) -> tuple[Finding, ...]:
    """As `check`, from values of its margins that are known already.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    - `values`: what `check_margins` gives.
    """
    known = _plain(values)
    found = [finding for _, finding in findings_of(mechanism, known)]
    found += mass_findings(mechanism)
    found += _stiffness.shaft_findings(mechanism)
    plays = {
        margin.stage: numbers["value"]
        for margin, numbers in zip(margins_of(mechanism), known, strict=True)
        if margin.name == "backlash" and numbers is not None
    }
    found += _strength.agreements(mechanism, plays)
    found += _fit.assembly_notes(mechanism)
    found += sharing_findings(mechanism)
    return tuple(sorted(found, key=lambda finding: finding.stage))


#: Names of findings on given stiffnesses, and on strength and life.
_STIFFNESS = ("negative_stiffness", "torsional_support")
_STRENGTH = (
    *("static_safety", "rating_life", "buckling", "screw_speed", "false_brinelling", "backlash"),
    *("preload", "engaged_threads", "axial_backlash", "contact_truncation"),
)


def stiffness_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Findings of `check` on given stiffnesses that no structure, or no shaft, has."""
    return tuple(finding for finding in check(mechanism) if finding.name in _STIFFNESS)


def strength_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Findings of `check` on loads, speeds and lives that the strength data do not bear."""
    return tuple(finding for finding in check(mechanism) if finding.name in _STRENGTH)
