"""The analysis behind a report: every part that a mechanism has the data for."""

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

import jax.numpy as jnp
from jaxtyping import Array

from ..._errors import MissingDataError, PrsmError
from ...contact import StageContact, load_of, stage_contact
from ...dynamics import SteadyState, Transient, simulate, steady_state
from ...findings import (
    CheckNumbers,
    StrengthCheck,
    check_from,
    margin_numbers,
    strength_checks_from,
)
from ...geometry import Meshing, mesh
from ...load_sharing import ForceDeflection, LoadDistribution
from ...mechanism import Mechanism, written_out
from ...optimisation import limit_readings
from ...programs import beside, one_program_where_possible
from ...quantities import (
    AXIS_QUANTITIES,
    Analysis,
    available_quantities,
    compute,
    evaluate,
    truncated_fatigue_of,
)
from ...strength import TruncatedFatigue, side_onsets
from ...text import short_heading
from ...vibration import Modes, modal
from ..contact_charts import FlankLine, flank_lines, shared_loads
from ..design_charts import Optimisation
from ._data import ReportData, SideOnsets
from ._origin import Origin
from ._pressures import largest_pressures, largest_shared_pressure


def words_of_fault(error: Exception) -> str:
    """A fault of this program in one line, for a user to report."""
    words = short_heading(str(error))
    return f"{type(error).__name__}: {words}" if words else type(error).__name__


# Compiled once for each structure of a mechanism: before and after an optimisation share them.
@one_program_where_possible
def _meshings(mechanism: Mechanism) -> tuple[Meshing, ...]:
    return tuple(mesh(stage.thread) for stage in mechanism.stages)


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
    "preloaded_pressure",
    "preloaded_stiffness",
    "preload_torque",
)


@one_program_where_possible
def _contacts(
    mechanism: Mechanism, meshings: tuple[Meshing, ...]
) -> tuple[tuple[StageContact, ...], tuple[SideOnsets, ...]]:
    """Contacts under the operating load, and onsets of cut ellipses, of every stage."""
    load = jnp.abs(load_of(mechanism, None))
    stages = tuple(zip(mechanism.stages, meshings, strict=True))
    contacts = tuple(stage_contact(stage, load, meshing) for stage, meshing in stages)
    onsets = tuple(side_onsets(stage, meshing) or (None, None) for stage, meshing in stages)
    return contacts, onsets


def _lines(
    mechanism: Mechanism, meshings: tuple[Meshing, ...]
) -> tuple[tuple[FlankLine, ...], ...]:
    """Crests and roots beside the ellipses under the operating load, of every stage."""
    load = jnp.abs(load_of(mechanism, None))
    return tuple(
        flank_lines(stage, load, meshing)
        for stage, meshing in zip(mechanism.stages, meshings, strict=True)
    )


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
    origin: Origin | None = None,
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
    - `origin`: the file of the mechanism, and author, revision and date.

    **Returns:** a `ReportData`.
    """
    original = mechanism
    if mechanism.design_problem is not None:
        # As after an optimisation, so that both designs use the same programs.
        mechanism = written_out(mechanism, (one.name for one in mechanism.design_problem.variables))

    parts, more = _Parts(), _Parts()
    attempt = parts.attempt
    # Programs that take long to compile, beside the others.
    others = beside(_others, more, mechanism, transient)
    numbers = attempt("checks", margin_numbers, mechanism)
    findings = None
    if numbers is not None:
        findings = attempt("checks", check_from, mechanism, numbers)
    meshings = attempt("meshing", _meshings, mechanism)
    contacts, onsets = None, ()
    if meshings is not None:
        contacts, onsets = attempt("contact", _contacts, mechanism, meshings) or (None, ())
    lines = None if contacts is None else attempt("contact", _lines, mechanism, meshings)
    modes = attempt("vibration", _all_modes, mechanism)
    steady = attempt("steady state", _steady_states, mechanism) or (None, None, None)
    history, strength, shared, axis, limits = others()
    parts.add(more)
    data = ReportData(
        mechanism=original,
        title=short_heading(title or mechanism.title) or "Planetary roller screw mechanism",
        findings=findings,
        meshings=meshings,
        contacts=contacts,
        onsets=onsets,
        flank_lines=lines or (),
        modes=modes,
        axis=axis,
        steady=steady[0],
        forward=steady[1],
        backward=steady[2],
        transient=history,
        strength=strength[0],
        fatigue=strength[1],
        shared=shared[0],
        deflections=shared[1],
        limits=limits,
        source=source,
        command=command,
        origin=origin or Origin(),
    )
    checks = None
    if numbers is not None:
        checks = attempt("checks", _checks, data, mechanism, numbers)
    data = dataclasses.replace(
        data, checks=checks, left_out=tuple(parts.left_out), faults=tuple(parts.faults)
    )
    return with_optimisation(data, sensitivity, optimisation, improved, transient=transient)


def with_optimisation(
    data: ReportData,
    sensitivity: Any,
    optimisation: Optimisation | None,
    improved: Mechanism | None,
    *,
    transient: bool = True,
) -> ReportData:
    """An analysis together with what an optimisation has found.

    **Arguments:**

    - `data`: of `analyse`.
    - `sensitivity`, `optimisation`, `improved`, `transient`: as for `analyse`.
    """
    after, faults = None, data.faults
    if improved is not None:
        after = analyse(improved, title=_title_after(optimisation), transient=transient)
        faults += tuple((f"{part} {after.title}", words) for part, words in after.faults)
    return dataclasses.replace(
        data, sensitivity=sensitivity, optimisation=optimisation, improved=after, faults=faults
    )


class _Parts:
    """Parts of an analysis, of which some are left out."""

    def __init__(self) -> None:
        #: Names of parts, and why they are left out.
        self.left_out: list[tuple[str, str]] = []
        self.faults: list[tuple[str, str]] = []

    def attempt(self, part: str, function: Callable[..., Any], *args: Any) -> Any:
        """The result of a part, or `None`."""
        try:
            return function(*args)
        except (MissingDataError, PrsmError, ValueError) as error:
            self.left_out.append((part, str(error)))
        except Exception as error:
            # A fault in one part of the report must not lose hours of other work.
            self.faults.append((part, words_of_fault(error)))
        return None

    def add(self, others: "_Parts") -> None:
        """Append what was left out of other parts."""
        self.left_out += others.left_out
        self.faults += others.faults


def _others(parts: _Parts, mechanism: Mechanism, transient: bool) -> tuple[Any, ...]:
    """Transient, strength, load sharing, axis and limits of the design problem."""
    history = parts.attempt("transient", _history, mechanism) if transient else None
    strength = parts.attempt("strength", _strength, mechanism) or (None, ())
    shared = parts.attempt("load sharing", _shared, mechanism) or ({}, {})
    axis = parts.attempt("axis", _axis, mechanism)
    limits = parts.attempt("limits of [optimise]", limit_readings, mechanism)
    return history, strength, shared, axis, limits


def _checks(
    data: ReportData, mechanism: Mechanism, numbers: CheckNumbers
) -> tuple[StrengthCheck, ...]:
    """Checks from the numbers of `check` on the mechanism and the results of this analysis."""
    values: dict[str, Any] = dict(data.strength or {})
    stages = range(len(data.mechanism.stages))
    if data.contacts is not None:
        values["max_pressure"] = _of_stages(max(largest_pressures(data, i)) for i in stages)
    if data.contacts is not None and len(data.shared) == len(stages):
        shared = (largest_shared_pressure(data, i) for i in stages)
        values["max_pressure_shared"] = _of_stages(shared)
    steady = data.steady
    if steady is not None and steady.has_efficiency and bool(steady.valid):
        values["efficiency"] = steady.efficiency
    return strength_checks_from(mechanism, numbers, values)


def _of_stages(numbers: Iterable[float]) -> float | list[float]:
    """Numbers of several stages as a list; that of a single stage is of the whole mechanism."""
    listed = list(numbers)
    return listed if len(listed) > 1 else listed[0]


def _title_after(optimisation: Optimisation | None) -> str:
    feasible = optimisation is None or optimisation.feasible
    return "after the optimisation" if feasible else "best found"


def _all_modes(mechanism: Mechanism) -> tuple[Modes, ...]:
    return tuple(
        modal(mechanism, stage=i, shapes=True) for i in range(1, len(mechanism.stages) + 1)
    )


def _axis(mechanism: Mechanism) -> Mapping[str, Array] | None:
    """Frequencies in space and stiffnesses of the axis, as of `prsm modal --spatial`."""
    if mechanism.axis is None:
        return None
    names = available_quantities(mechanism, tuple(AXIS_QUANTITIES))
    # Without data for any of them, the first one says what is missing.
    return compute(mechanism, names or ("first_axial_frequency",))


def _steady_states(mechanism: Mechanism) -> tuple[SteadyState, SteadyState, SteadyState]:
    point = mechanism.operating_point
    if point is None:
        raise MissingDataError("the mechanism has no operating point; give [operating_point]")
    speed, load = jnp.abs(point.speed), jnp.abs(point.load)
    return (
        steady_state(mechanism, point.speed, point.load),
        steady_state(mechanism, speed, load),
        steady_state(mechanism, -speed, load, onset=-1.0),
    )


def _history(mechanism: Mechanism) -> Transient | None:
    run = simulate(mechanism, throw=False)
    if int(run.solver.code) != 0:
        raise PrsmError(f"the simulation has no valid result: {run.solver.result}")
    return run


_Strength: TypeAlias = tuple[Mapping[str, Array] | None, tuple[TruncatedFatigue | None, ...]]


@one_program_where_possible
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
