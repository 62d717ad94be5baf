"""Data of a report: one analysis, every part of it optional."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from jaxtyping import Array

from ...contact import StageContact
from ...dynamics import SteadyState, Transient
from ...findings import Status, StrengthCheck, status_of
from ...geometry import Finding, Meshing
from ...load_sharing import ForceDeflection, LoadDistribution
from ...mechanism import Mechanism
from ...optimisation import LimitReading, with_limits
from ...strength import SideOnset, TruncatedFatigue
from ...text import short_label
from ...vibration import Modes
from ..contact_charts import FlankLine
from ..design_charts import Optimisation
from ._origin import Origin

#: On the screw and on the nut side; `None` for a side whose flanks do not end.
SideOnsets: TypeAlias = tuple[SideOnset | None, SideOnset | None]


@dataclass(frozen=True)
class ReportData:
    """Results to report; a part that is `None` or empty is left out.

    `analyse` fills it; `dataclasses.replace` adds to it. Sequences run over the stages.
    """

    mechanism: Mechanism
    title: str
    #: `None` if the checks could not be made.
    findings: tuple[Finding, ...] | None = ()
    meshings: tuple[Meshing, ...] | None = None
    contacts: tuple[StageContact, ...] | None = None
    #: Where the ellipses of screw and nut side reach the ends of their flanks, by stage; empty
    #: if all ellipses are taken to be whole.
    onsets: tuple[SideOnsets, ...] = ()
    modes: tuple[Modes, ...] | None = None
    #: Quantities of the axis by name; `None` without an axis.
    axis: Mapping[str, Array] | None = None
    #: Steady states: operating point, screw driving, load driving the screw back.
    steady: SteadyState | None = None
    forward: SteadyState | None = None
    backward: SteadyState | None = None
    transient: Transient | None = None
    #: Quantities of strength and life by name.
    strength: Mapping[str, Array] | None = None
    #: Effect of the ends of flanks on the fatigue of each stage; empty without a rating life.
    fatigue: tuple[TruncatedFatigue | None, ...] = ()
    #: Load distributions and force–deflection curves of stages (from 0) that model load sharing.
    shared: Mapping[int, LoadDistribution] = field(default_factory=dict)
    deflections: Mapping[int, ForceDeflection] = field(default_factory=dict)
    #: Result of `sensitivity`.
    sensitivity: Any = None
    optimisation: Optimisation | None = None
    #: The analysis of the optimised mechanism.
    improved: "ReportData | None" = None
    #: Parts that could not be analysed, with the reason.
    left_out: tuple[tuple[str, str], ...] = ()
    #: Parts whose analysis failed by a fault of this program, with the fault.
    faults: tuple[tuple[str, str], ...] = ()
    #: Where the mechanism came from (file or example), and the command that made the report.
    source: str = ""
    command: str = ""
    #: The file of the mechanism, and who made the report.
    origin: Origin = field(default_factory=Origin)
    #: Strength, life, speed, play and friction beside their limits; `None` as for findings.
    checks: tuple[StrengthCheck, ...] | None = ()
    #: Crests and roots beside the contact ellipses, by stage; empty if they are not known.
    flank_lines: tuple[tuple[FlankLine, ...], ...] = ()
    #: Limits of the design problem beside their values; `None` if they could not be read.
    limits: tuple[LimitReading, ...] | None = ()

    @property
    def status(self) -> Status:
        """The worst verdict of checks, findings and limits; a part that failed is a warning.

        A broken limit of the design problem is a failure. Findings of geometry are made for every
        mechanism, so one without checks passes too.
        """
        status = with_limits(status_of(self.checks or (), self.findings), self.limits)
        if status == "no checks":
            status = "pass"
        incomplete = self.checks is None or bool(self.faults)
        return "warning" if status == "pass" and incomplete else status

    @property
    def designs(self) -> "dict[str, ReportData]":
        """This design under an empty name; with an improved one, both by their names."""
        if self.improved is None:
            return {"": self}
        return {"start": self, "optimum" if self.feasible else "best found": self.improved}

    @property
    def label(self) -> str:
        """The title as shown in pictures."""
        return short_label(self.title)

    @property
    def feasible(self) -> bool:
        """Whether the optimisation, if there was one, found a design that keeps all limits."""
        return self.optimisation is None or self.optimisation.feasible

    @property
    def ends(self) -> tuple[str, str]:
        """Names of the designs before and after; "best found" if limits are violated."""
        return ("before", "after") if self.feasible else ("before", "best found")

    def of_stage(self, index: int) -> tuple[str, str]:
        """Suffixes of the name and caption of a picture for one of several stages (from 0)."""
        if len(self.mechanism.stages) == 1:
            return "", ""
        return f"_stage_{index + 1}", f", stage {index + 1}"

    @property
    def later(self) -> str:
        """Head of the column of the improved design."""
        return "after the optimisation" if self.feasible else "best found"
