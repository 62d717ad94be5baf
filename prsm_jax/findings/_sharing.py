"""Findings on load sharing: equal without being stated, or made uneven by errors of parts."""

from collections.abc import Iterator

import jax.numpy as jnp

from ..fields import Scalar
from ..geometry import Finding
from ..load_sharing import LargestLoads, error_names, without_each_error
from ..mechanism import Mechanism, Stage
from ..quantities import (
    Analysis,
    derives_dynamic_capacity,
    derives_static_capacity,
    find_quantity,
    has_contacts,
)
from ._margin import Margin, Reading, margin_source

#: Largest load of a roller or thread over that without errors. Pressure grows with the cube root of
#: the load and the life of a contact falls with its cube: 1.25 halves it, 1.5 leaves 30 %.
_UNEVEN, _FAR_TOO_UNEVEN = 1.25, 1.5
#: What to do about each error.
_REMEDIES = {
    "part_errors.nut_eccentricity": "grind the seat of the nut in line with its thread",
    "part_errors.screw_eccentricity": "straighten the screw, or grind its thread in line with the "
    "seats of its bearings",
    "part_errors.nut_tilt": "face the flange of the nut square to its thread",
    "part_errors.screw_tilt": "align the bearings of the screw",
    "part_errors.roller_diameter_deviation": "sort the rollers into a narrower class of pitch "
    "diameters",
    "part_errors.roller_tilt": "drill both carriers together, with less play of the pins",
    "free_nut.radial_load": "let a guide take the radial load",
    "free_nut.overturning_moment": "move the line of thrust to the axis, or let guides take the "
    "moment",
}


def _is_limited(mechanism: Mechanism) -> bool:
    """Whether the design problem optimises or limits a quantity that assumes equal sharing."""
    problem = mechanism.design_problem
    if problem is None:
        return False
    names = [term.quantity for term in (*problem.objectives, *problem.constraints)]
    sharing = {"equal_contacts", "equal_stiffness", "static_sharing", "dynamic_sharing"}
    return any(sharing & set(find_quantity(name).assumes) for name in names)


def _of_stage(stage: Stage, number: int, limited: bool) -> Finding | None:
    if stage.load_sharing is not None and stage.sharing == "equal":
        count = float(stage.load_sharing.thread_count)
        return Finding(
            "equal_sharing",
            "warning",
            number,
            count,
            1.0,
            'stage.sharing is "equal", but [stage.load_sharing] is given too, and the load '
            "distribution that it describes is used: remove one of them",
        )
    if stage.load_sharing is not None or stage.sharing == "equal" or not has_contacts(stage):
        return None
    assert stage.engaged_threads is not None
    count = float(stage.engaged_threads)
    if count <= 1:
        return None
    derived = derives_static_capacity(stage) or derives_dynamic_capacity(stage)
    return Finding(
        "equal_sharing",
        "warning" if derived or limited else "note",
        number,
        count,
        1.0,
        f"all {count:.4g} engaged threads of a roller are assumed to carry the same load; with "
        "elastic shafts the most loaded thread carries more, so pressures are higher, and "
        "capacities, safety and life lower, than stated: give [stage.load_sharing] with "
        f'thread_count = {round(count)}, or confirm equal shares by sharing = "equal" in '
        "[[stage]]",
    )


def sharing_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """`equal_sharing`: stages with equal load sharing that the file does not state.

    A warning if capacities or limits of an optimisation depend on it, otherwise a note. No finding
    for a single engaged thread, or if the file has `sharing = "equal"`; a warning if it has that
    together with `load_sharing`.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    """
    limited = _is_limited(mechanism)
    findings = (
        _of_stage(stage, number, limited) for number, stage in enumerate(mechanism.stages, start=1)
    )
    return tuple(finding for finding in findings if finding is not None)


def _amount(mechanism: Mechanism, index: int, name: str) -> str:
    """An error in words: a number, or the range over the rollers."""
    part, field = name.split(".")
    value = getattr(getattr(mechanism.stages[index].load_sharing, part), field)
    if field.endswith("load"):
        unit, factor = "N", 1.0
    elif field.endswith("moment"):
        unit, factor = "N·m", 1.0
    else:
        unit, factor = ("mrad", 1e3) if field.endswith("tilt") else ("µm", 1e6)
    if value.ndim == 0:
        return f"{float(value) * factor:.4g} {unit}"
    low, high = float(jnp.min(value)) * factor, float(jnp.max(value)) * factor
    return f"{low:.4g} to {high:.4g} {unit}"


def _larger(loads: LargestLoads, reference: Scalar) -> Scalar:
    """The larger of both ratios; 1 where nothing is loaded."""
    loaded = reference > 0
    thread = jnp.where(loaded, loads.thread_load / jnp.where(loaded, reference, 1.0), 1.0)
    return jnp.maximum(loads.roller_sharing_factor, thread)


@margin_source
def _uneven_rollers(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Errors of parts, or loads across the axis, should not overload single rollers."""
    sharing = mechanism.stages[index].load_sharing
    if sharing is None or not error_names(sharing):
        return
    names = error_names(sharing)

    def left_out(analysis: Analysis) -> tuple[LargestLoads, dict[str, LargestLoads]]:
        stage, meshing = analysis.mechanism.stages[index], analysis.meshing(index)
        return analysis.once(
            ("without_each_error", index),
            lambda: without_each_error(stage, analysis.signed_load, meshing),
        )

    def present(analysis: Analysis) -> LargestLoads:
        found = analysis.distribution(index)
        loads = jnp.stack([jnp.max(side.thread_load) for side in (found.screw, found.nut)])
        return LargestLoads(found.nut.roller_sharing_factor, jnp.max(loads))

    def value(analysis: Analysis) -> Scalar:
        return -_larger(present(analysis), left_out(analysis)[0].thread_load)

    def details(analysis: Analysis) -> dict[str, Scalar]:
        (none, each), loads = left_out(analysis), present(analysis)
        numbers = {"roller": loads.roller_sharing_factor, "thread": loads.thread_load}
        numbers["none"] = none.thread_load
        return numbers | {name: _larger(one, none.thread_load) for name, one in each.items()}

    def message(r: Reading) -> str:
        thread, none = r.details["thread"], r.details["none"]
        worst = min(names, key=lambda name: r.details[name])
        larger = (
            f"the most loaded roller carries {r.details['roller']:.3g} times the mean, and the "
            f"most loaded thread {thread:.4g} N, {thread / none:.3g} times its {none:.4g} N "
            f"without errors of parts and loads across the axis (limit {-r.limit:g}); its pressure "
            f"is {(thread / none) ** (1 / 3):.3g} times as high"
        )
        if not r.details[worst] < -r.value:
            return (
                f"{larger}: no error alone decides, because without any single one of them the "
                "larger factor would not be smaller; make the largest of "
                f"{', '.join(f'stage.load_sharing.{name}' for name in names)} smaller together"
            )
        return (
            f"{larger}: most of it comes from stage.load_sharing.{worst}, "
            f"{_amount(r.mechanism, index, worst)}, without which the larger factor, now "
            f"{-r.value:.3g}, would be {r.details[worst]:.3g}; {_REMEDIES[worst]}"
        )

    yield Margin(
        "uneven_rollers",
        index + 1,
        value,
        (("warning", -_FAR_TOO_UNEVEN), ("note", -_UNEVEN)),
        message,
        details=details,
        shown=lambda r: (-r.value, -r.limit),
        at_most=True,
        shares=("operating_point",),
    )
