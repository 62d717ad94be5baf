"""What the numbers rest on, in plain sentences: only what those asked for assume.

An assumption is a function of one stage that gives its sentence, or `None` where the stage does
not assume it. Quantities name theirs in their declaration (`assumes=…`).
"""

from collections.abc import Callable, Iterable

from .._errors import MissingDataError
from ..dynamics import has_contact_losses
from ..geometry import flanks_end
from ..mechanism import Mechanism, Stage, material_of

Sentence = Callable[[Stage], str | None]

_ASSUMPTIONS: dict[str, Sentence] = {}


def assumption(name: str) -> Callable[[Sentence], Sentence]:
    """Add an assumption that quantities may name; the way to add one of your own.

    **Raises:** `ValueError` if the name is taken.
    """

    def register(function: Sentence) -> Sentence:
        if name in _ASSUMPTIONS:
            raise ValueError(f"the assumption {name!r} exists already; choose another name")
        _ASSUMPTIONS[name] = function
        return function

    return register


def known_assumption(name: str) -> str:
    """The name of a registered assumption, as it is.

    **Raises:** `ValueError` if there is none of this name.
    """
    if name not in _ASSUMPTIONS:
        raise ValueError(f"unknown assumption {name!r}; choose one of {', '.join(_ASSUMPTIONS)}")
    return name


def sentences(mechanism: Mechanism, names: Iterable[str]) -> tuple[str, ...]:
    """The sentences of assumptions, each once; a stage is named where others differ.

    **Arguments:**

    - `mechanism`: the mechanism; only what it consists of counts, not its numbers.
    - `names`: of the assumptions.
    """
    stages: dict[str, list[int]] = {}
    for name in names:
        for number, stage in enumerate(mechanism.stages, start=1):
            found = _ASSUMPTIONS[name](stage)
            if found is not None and number not in stages.setdefault(found, []):
                stages[found].append(number)
    whole = len(mechanism.stages)

    def told(sentence: str, numbers: list[int]) -> str:
        if len(numbers) == whole:
            return sentence
        return f"Stage {', '.join(map(str, sorted(numbers)))}: {sentence}"

    return tuple(told(sentence, numbers) for sentence, numbers in stages.items())


def has_contacts(stage: Stage) -> bool:
    """Whether a stage has the data for its thread contacts."""
    try:
        for body in ("screw", "roller", "nut"):
            material_of(stage, body)
    except MissingDataError:
        return False
    return stage.engaged_threads is not None


def _equal(stage: Stage) -> str:
    why = (
        'as the file says (sharing = "equal")'
        if stage.sharing == "equal"
        else "since the file has no [stage.load_sharing]"
    )
    return (
        f"All engaged threads of all rollers carry the same load, {why}; in reality the most "
        "loaded thread carries more, so its pressure is higher, and capacities, safety and life "
        "are lower."
    )


def _derives_stiffness(stage: Stage) -> bool:
    given = stage.stiffness
    return given is None or given.screw_roller is None or given.nut_roller is None


def derives_static_capacity(stage: Stage) -> bool:
    """Whether the static capacity follows from the contacts."""
    data = stage.strength
    return (
        data is not None
        and data.static_capacity is None
        and (data.permissible_pressure is not None)
    )


def derives_dynamic_capacity(stage: Stage) -> bool:
    """Whether the dynamic capacity follows from the contacts."""
    data = stage.strength
    return data is not None and data.dynamic_capacity is None and data.material_factor is not None


@assumption("equal_contacts")
def equal_contacts(stage: Stage) -> str | None:
    """Of single contacts, whose load is the mean one whatever the stage has."""
    if not has_contacts(stage):
        return None
    if stage.load_sharing is None:
        return _equal(stage)
    return (
        "Pressures, ellipses, approaches and stresses of a single contact (max_pressure, …) are "
        "those of the mean thread load, although the file has [stage.load_sharing]; for the "
        "most loaded thread see max_pressure_shared."
    )


@assumption("equal_friction")
def equal_friction(stage: Stage) -> str | None:
    """Of spin and rolling losses, which depend on the contact ellipses."""
    if not (has_contact_losses(stage.friction) and has_contacts(stage)):
        return None
    if stage.load_sharing is None:
        return _equal(stage)
    return (
        "Spin and rolling losses are those of contacts that all carry the mean thread load, "
        "although the file has [stage.load_sharing]."
    )


@assumption("equal_stiffness")
def equal_stiffness(stage: Stage) -> str | None:
    """Of thread stiffnesses, which follow the load distribution where there is one."""
    if stage.load_sharing is not None or not (has_contacts(stage) and _derives_stiffness(stage)):
        return None
    return _equal(stage)


@assumption("secant_stiffness")
def secant_stiffness(stage: Stage) -> str | None:
    """Of the vibration model."""
    if not (_derives_stiffness(stage) and (has_contacts(stage) or stage.load_sharing is not None)):
        return None
    return (
        "Thread contacts vibrate as springs of their secant stiffness F/δ under the operating "
        "load, shafts rigid; about that load the tangent stiffness of a Hertz contact is 3/2 of it."
    )


def _equal_capacity(stage: Stage) -> str | None:
    if stage.load_sharing is None:
        return _equal(stage)
    if stage.load_sharing.split_nut is not None:
        return (
            "Capacities, safety and life count the threads of one half of the split nut as if they "
            "carried the same load, although the file has [stage.load_sharing]."
        )
    return None


@assumption("static_sharing")
def static_sharing(stage: Stage) -> str | None:
    """Of a static capacity that is derived."""
    return _equal_capacity(stage) if derives_static_capacity(stage) else None


@assumption("dent_sharing")
def dent_sharing(stage: Stage) -> str | None:
    """Of the permanent deformation, for which no capacity is needed."""
    return _equal_capacity(stage) if has_contacts(stage) and stage.strength is not None else None


@assumption("cut_sharing")
def cut_sharing(stage: Stage) -> str | None:
    """Of how much of an ellipse is cut."""
    return _equal_capacity(stage) if has_contacts(stage) and flanks_end(stage) else None


@assumption("dynamic_sharing")
def dynamic_sharing(stage: Stage) -> str | None:
    """Of a dynamic capacity that is derived, and of all lives."""
    return _equal_capacity(stage) if derives_dynamic_capacity(stage) else None


@assumption("static_criterion")
def static_criterion(stage: Stage) -> str | None:
    """What the static capacity is."""
    if not derives_static_capacity(stage):
        return None
    return (
        "The static capacity is the load at the permissible Hertz pressure of the file, a "
        "criterion of ball bearings (ISO 76); no standard exists for roller screws."
    )


@assumption("life_theory")
def life_theory(stage: Stage) -> str | None:
    """What the dynamic capacity is."""
    if not derives_dynamic_capacity(stage):
        return None
    return (
        "The dynamic capacity is an estimate by the theory of ball bearings (Lundberg and "
        "Palmgren) with the material factor of the file; no standard exists for roller screws."
    )


def _flanks(stage: Stage) -> str:
    if flanks_end(stage):
        at_edge = (
            "which the file does not round (edge_radius): in elastic half-spaces it has no finite "
            "value at a sharp edge."
            if stage.thread.edge_radius is None
            else "which edge_pressure has for the edge_radius of the file."
        )
        return (
            "Where a contact ellipse passes the crest or root of a flank, pressure, capacities and "
            "life are those of the rest of it (finding contact_truncation), without the "
            f"concentration of pressure at the edge, {at_edge}"
        )
    return (
        "Contact ellipses are taken to lie on the flanks as a whole, since the file does not say "
        "where these end (screw_addendum, roller_addendum); in reality a long ellipse is cut "
        "there, so its pressure is higher, and capacities and life are lower."
    )


@assumption("edges")
def edges(stage: Stage) -> str | None:
    """Of the pressure at rounded crests."""
    if not flanks_end(stage) or stage.thread.edge_radius is None:
        return None
    return (
        "The pressure at rounded crests is that of elastic half-spaces: yielding of the "
        "steel is left out, and a real edge, which has no material behind it, is less stiff."
    )


@assumption("flanks_of_contacts")
def flanks_of_contacts(stage: Stage) -> str | None:
    """Of pressures."""
    return _flanks(stage) if has_contacts(stage) else None


@assumption("flanks_of_static")
def flanks_of_static(stage: Stage) -> str | None:
    """Of a static capacity that is derived."""
    return _flanks(stage) if derives_static_capacity(stage) else None


@assumption("flanks_of_dynamic")
def flanks_of_dynamic(stage: Stage) -> str | None:
    """Of a dynamic capacity that is derived, and of all lives."""
    return _flanks(stage) if derives_dynamic_capacity(stage) else None
