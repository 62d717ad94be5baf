"""The finding on equal load sharing among threads that is assumed without being stated."""

from ..geometry import Finding
from ..mechanism import Mechanism, Stage
from ..quantities import (
    derives_dynamic_capacity,
    derives_static_capacity,
    find_quantity,
    has_contacts,
)


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
