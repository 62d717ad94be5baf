"""The finding on a load that all threads are taken to share equally."""

from ..geometry import Finding
from ..mechanism import Mechanism, Stage
from ..quantities import (
    derives_dynamic_capacity,
    derives_static_capacity,
    find_quantity,
    has_contacts,
)


def _is_limited(mechanism: Mechanism) -> bool:
    """Whether an optimisation aims at or limits a quantity that rests on equal sharing."""
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
            'stage.sharing is "equal", and [stage.load_sharing] says how the threads share, which '
            "is what is computed: remove one of them",
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
        f"all {count:.4g} engaged threads of a roller are taken to carry the same load; with "
        "elastic shafts the most loaded thread carries more, so pressures are higher, and "
        "capacities, safety and life lower, than stated: give [stage.load_sharing] with "
        f'thread_count = {round(count)}, or state by sharing = "equal" in [[stage]] that equal '
        "shares are meant",
    )


def sharing_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Stages whose contacts share the load equally without the file saying so: `equal_sharing`.

    A warning where capacities or limits of an optimisation rest on it, else a note. None for a
    single engaged thread, nor where the file says `sharing = "equal"`; a warning where it says so
    beside `load_sharing`.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    """
    limited = _is_limited(mechanism)
    found = (
        _of_stage(stage, number, limited) for number, stage in enumerate(mechanism.stages, start=1)
    )
    return tuple(finding for finding in found if finding is not None)
