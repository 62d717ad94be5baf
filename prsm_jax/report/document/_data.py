"""Data of a report: one analysis, every part of it optional."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array

from ..._errors import MissingDataError, PrsmError
from ...contact import StageContact, load_of, stage_contact
from ...dynamics import SteadyState, Transient, simulate, steady_state
from ...findings import check
from ...geometry import Finding, Meshing, mesh
from ...load_sharing import ForceDeflection, LoadDistribution
from ...mechanism import Mechanism, find_parameters
from ...quantities import Analysis, available_quantities, evaluate, truncated_fatigue_of
from ...strength import SideOnset, TruncatedFatigue, side_onsets
from ...text import short_heading, short_label
from ...vibration import Modes, modal
from ..contact_charts import shared_loads
from ..design_charts import Optimisation
from ._section import words_of_fault

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


# Compiled once for each structure of a mechanism: before and after an optimisation share them.
_meshings = eqx.filter_jit(lambda mechanism: tuple(mesh(s.thread) for s in mechanism.stages))
_modal = eqx.filter_jit(modal)
_steady = eqx.filter_jit(steady_state)

#: Quantities in the section on strength, as far as the file has their data.
STRENGTH = (
    "static_capacity",
    "static_safety",
    "dynamic_capacity",
    "truncation_load",
    "edge_pressure_largest",
    "equivalent_load",
    "equivalent_speed",
    "rating_life",
    "rating_life_time",
    "rating_life_distance",
    "modified_rating_life",
    "life_ratio",
    "buckling_load",
    "buckling_safety",
    "critical_speed",
    "permissible_speed",
    "critical_speed_margin",
    "axial_backlash",
    "lost_motion",
    "preload_opening_load",
    "preloaded_stiffness",
    "preload_torque",
)


@eqx.filter_jit
def _contacts(
    mechanism: Mechanism, meshings: tuple[Meshing, ...]
) -> tuple[tuple[StageContact, ...], tuple[SideOnsets, ...]]:
    """Contacts under the operating load, and onsets of cut ellipses, of every stage."""
    load = jnp.abs(load_of(mechanism, None))
    stages = tuple(zip(mechanism.stages, meshings, strict=True))
    contacts = tuple(stage_contact(stage, load, meshing) for stage, meshing in stages)
    onsets = tuple(side_onsets(stage, meshing) or (None, None) for stage, meshing in stages)
    return contacts, onsets


def analyse(
    mechanism: Mechanism,
    *,
    title: str | None = None,
    source: str = "",
    command: str = "",
    sensitivity: Any = None,
    optimisation: Optimisation | None = None,
    improved: Mechanism | None = None,
    transient: bool = True,
) -> ReportData:
    """Analyse a mechanism at its operating point for a report.

    A part for which the mechanism lacks data is left out, with the reason. A part whose analysis
    fails is left out, too, and the report says so at its top.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `title`: heading of the report; default the mechanism's title.
    - `source`, `command`: provenance, as text.
    - `sensitivity`: a table from `prsm_jax.sensitivity`, if there is one.
    - `optimisation`: from `summarise_optimisation`, if there was one.
    - `improved`: the optimised mechanism; it is analysed as well.
    - `transient`: whether to simulate, where the operating point has a duration.
    """
    left_out: list[tuple[str, str]] = []
    faults: list[tuple[str, str]] = []
    original, mechanism = mechanism, _written_out(mechanism)

    def attempt(part: str, function: Callable[..., Any], *args) -> Any:
        try:
            return function(*args)
        except (MissingDataError, PrsmError, ValueError) as error:
            left_out.append((part, str(error)))
        except Exception as error:
            # A fault in one part of the report must not lose hours of other work.
            faults.append((part, words_of_fault(error)))
        return None

    findings = attempt("checks", check, mechanism)
    meshings = attempt("meshing", _meshings, mechanism)
    contacts, onsets = None, ()
    if meshings is not None:
        contacts, onsets = attempt("contact", _contacts, mechanism, meshings) or (None, ())
    modes = attempt("vibration", _all_modes, mechanism)
    steady = attempt("steady state", _steady_states, mechanism) or (None, None, None)
    history = attempt("transient", _history, mechanism) if transient else None
    strength = attempt("strength", _strength, mechanism) or (None, ())
    shared = attempt("load sharing", _shared, mechanism) or ({}, {})
    after = None
    if improved is not None:
        after = analyse(improved, title=_title_after(optimisation), transient=transient)
        faults += [(f"{part} {after.title}", words) for part, words in after.faults]
    return ReportData(
        mechanism=original,
        title=short_heading(title or mechanism.title) or "Planetary roller screw mechanism",
        findings=findings,
        meshings=meshings,
        contacts=contacts,
        onsets=onsets,
        modes=modes,
        steady=steady[0],
        forward=steady[1],
        backward=steady[2],
        transient=history,
        strength=strength[0],
        fatigue=strength[1],
        shared=shared[0],
        deflections=shared[1],
        sensitivity=sensitivity,
        optimisation=optimisation,
        improved=after,
        left_out=tuple(left_out),
        faults=tuple(faults),
        source=source,
        command=command,
    )


def _title_after(optimisation: Optimisation | None) -> str:
    feasible = optimisation is None or optimisation.feasible
    return "after the optimisation" if feasible else "best found"


def _written_out(mechanism: Mechanism) -> Mechanism:
    """The same mechanism with every design variable present as a number of its own.

    A variable that follows from others while it is absent (the roller's profile radius) is present
    after an optimisation; if it is written out before, too, both designs use the same programs.
    """
    if mechanism.design_problem is not None:
        for variable in mechanism.design_problem.variables:
            for parameter in find_parameters(mechanism, variable.name):
                mechanism = parameter.set(mechanism, parameter.get(mechanism))
    return mechanism


def _all_modes(mechanism: Mechanism) -> tuple[Modes, ...]:
    return tuple(
        _modal(mechanism, stage=i, shapes=True) for i in range(1, len(mechanism.stages) + 1)
    )


def _steady_states(mechanism: Mechanism) -> tuple[SteadyState, SteadyState, SteadyState]:
    point = mechanism.operating_point
    if point is None:
        raise MissingDataError("the mechanism has no operating point; give [operating_point]")
    speed, load = jnp.abs(point.speed), jnp.abs(point.load)
    return (
        _steady(mechanism, point.speed, point.load),
        _steady(mechanism, speed, load),
        _steady(mechanism, -speed, load),
    )


def _history(mechanism: Mechanism) -> Transient | None:
    run = simulate(mechanism, throw=False)
    if int(run.solver.code) != 0:
        raise PrsmError(f"the simulation has no valid result: {run.solver.result}")
    return run


_Strength: TypeAlias = tuple[Mapping[str, Array] | None, tuple[TruncatedFatigue | None, ...]]


@eqx.filter_jit
def _strengths(mechanism: Mechanism, names: tuple[str, ...]) -> _Strength:
    analysis = Analysis(mechanism)
    values = evaluate(analysis, names)
    if "rating_life" not in names:
        return values, ()
    stages = enumerate(mechanism.stages)
    return values, tuple(truncated_fatigue_of(analysis, i, stage) for i, stage in stages)


def _strength(mechanism: Mechanism) -> _Strength:
    if all(stage.strength is None for stage in mechanism.stages):
        return None, ()
    return _strengths(mechanism, available_quantities(mechanism, STRENGTH))


def _shared(
    mechanism: Mechanism,
) -> tuple[dict[int, LoadDistribution], dict[int, ForceDeflection]]:
    """Load distributions and curves (up to 1.5 times the load) of stages with load sharing."""
    load = load_of(mechanism, None)
    pairs = {
        index: shared_loads(mechanism, load, index + 1)
        for index, stage in enumerate(mechanism.stages)
        if stage.load_sharing is not None
    }
    return {i: pair[0] for i, pair in pairs.items()}, {i: pair[1] for i, pair in pairs.items()}
