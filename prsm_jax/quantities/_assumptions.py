"""Assumptions behind the results, as plain sentences, for the requested quantities only.

An assumption is a function of one stage that returns its sentence, or `None` where it does not
apply; `OF_MECHANISM` has those of a whole mechanism. Quantities name theirs (`assumes=…`).
"""

from collections.abc import Callable, Collection

from .._errors import MissingDataError
from ..dynamics import has_contact_losses
from ..geometry import flanks_end
from ..mechanism import Mechanism, Stage, material_of
from ..strength import cuts_fatigue, is_preloaded, split_nut_of
from ._mechanism_assumptions import OF_MECHANISM

Sentence = Callable[[Stage], str | None]

_ASSUMPTIONS: dict[str, Sentence] = {}


def assumption(name: str) -> Callable[[Sentence], Sentence]:
    """Add an assumption that quantities can name; use it to add your own.

    **Raises:** `ValueError` if the name is taken.
    """

    def register(function: Sentence) -> Sentence:
        if name in _ASSUMPTIONS or name in OF_MECHANISM:
            raise ValueError(f"the assumption {name!r} exists already; choose another name")
        _ASSUMPTIONS[name] = function
        return function

    return register


def known_assumption(name: str) -> str:
    """Check that an assumption is registered, and return its name.

    **Raises:** `ValueError` if no assumption has this name.
    """
    if name not in _ASSUMPTIONS and name not in OF_MECHANISM:
        raise ValueError(f"unknown assumption {name!r}; choose one of {', '.join(_ASSUMPTIONS)}")
    return name


def sentences(mechanism: Mechanism, names: Collection[str]) -> tuple[str, ...]:
    """Sentences of assumptions, each once; its stages are named unless it holds for all.

    **Arguments:**

    - `mechanism`: the mechanism; only its parts matter, not their numbers.
    - `names`: names of the assumptions.
    """
    stages: dict[str, list[int]] = {}
    whole = [OF_MECHANISM[name](mechanism) for name in names if name in OF_MECHANISM]
    for name in (one for one in names if one in _ASSUMPTIONS):
        for number, stage in enumerate(mechanism.stages, start=1):
            text = _ASSUMPTIONS[name](stage)
            approximated = name in _OF_ELLIPSES and text is not None
            for one in (text, _approximation(stage) if approximated else None):
                if one is not None and number not in stages.setdefault(one, []):
                    stages[one].append(number)
    stage_count = len(mechanism.stages)

    def with_stages(sentence: str, numbers: list[int]) -> str:
        if len(numbers) == stage_count:
            return sentence
        return f"Stage {', '.join(map(str, sorted(numbers)))}: {sentence}"

    return (*(with_stages(*one) for one in stages.items()), *filter(None, whole))


def has_contacts(stage: Stage) -> bool:
    """Whether a stage has the data for its thread contacts."""
    try:
        for body in ("screw", "roller", "nut"):
            material_of(stage, body)
    except MissingDataError:
        return False
    return stage.engaged_threads is not None


def _approximation(stage: Stage) -> str | None:
    method = stage.contact_method
    if method == "exact":
        return None
    name = method if isinstance(method, str) else getattr(method, "__name__", type(method).__name__)
    return (
        f"Contact ellipses are those of the approximation {name} (contact_method), not of Hertz's "
        "exact theory; so are all pressures, stiffnesses, losses and capacities that depend on "
        "them."
    )


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
    stiffness = stage.stiffness
    return stiffness is None or stiffness.screw_roller is None or stiffness.nut_roller is None


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


@assumption("masses")
def masses(stage: Stage) -> str | None:
    """For masses that are derived from dimensions."""
    parts = (stage.screw, stage.roller, stage.nut)
    if all(part.mass is not None for part in parts):
        return None
    if stage.mass_rule == "thread_profile":
        return (
            "Masses and moments of inertia of screw, rollers and nut that the file does not give "
            "are those of their thread profiles over their whole lengths, with sharp edges and "
            "without gear teeth; a root that is not given clears the crest of the other thread by "
            'a tenth of the height of a tooth (mass_rule = "thread_profile").'
        )
    return (
        "Masses and moments of inertia of screw, rollers and nut that the file does not give are "
        "those of cylinders of the nominal radii, without their threads (mass_rule = "
        '"nominal_cylinder").'
    )


@assumption("equal_contacts")
def equal_contacts(stage: Stage) -> str | None:
    """For single contacts, which always carry the mean thread load."""
    if not has_contacts(stage):
        return None
    if stage.load_sharing is None:
        return _equal(stage)
    return (
        "Pressures, ellipses, approaches and stresses of a single contact (max_pressure, …) are "
        "those of the mean thread load, although the file has [stage.load_sharing]; for the "
        "most loaded thread see max_pressure_shared."
    )


@assumption("contacts_without_preload")
def contacts_without_preload(stage: Stage) -> str | None:
    """For single contacts."""
    if not (is_preloaded(stage) and has_contacts(stage)):
        return None
    return (
        "Pressures, ellipses, approaches and stresses of a single contact (max_pressure, …) are "
        "those of the operating load alone, without the preload of the nut; preloaded_pressure, "
        "static_safety, contact_truncation and lives include it."
    )


@assumption("contacts_without_friction")
def contacts_without_friction(stage: Stage) -> str | None:
    """For pressures and all else of thread contacts, single or shared."""
    if stage.thread_law is None or not has_contacts(stage):
        return None
    return (
        "Pressures, ellipses, approaches and stresses of thread contacts are those of the axial "
        "load without thread friction, which raises the normal force where rollers slide while the "
        "body that turns drives (contact_force includes it), and lowers it while the load drives."
    )


@assumption("stiffness_without_preload")
def stiffness_without_preload(stage: Stage) -> str | None:
    """For thread stiffnesses that are derived; a modelled split nut has its preload in them."""
    if not _has_unmodelled_preload(stage) or not _derives_stiffness(stage):
        return None
    if not has_contacts(stage) and stage.load_sharing is None:
        return None
    return (
        "Thread stiffnesses, and frequencies and stiffnesses with them, are those of one nut under "
        "the operating load alone, without its preload; preloaded_stiffness includes it."
    )


@assumption("secant_of_both_flanks")
def secant_of_both_flanks(stage: Stage) -> str | None:
    """For secants of contacts of a split nut, whose forces contain the preload."""
    if split_nut_of(stage) is None:
        return None
    return (
        "In a split nut the secant stiffness of the contacts adds up force over approach of every "
        "contact on both flanks, preload included, as the springs for vibration do. It is not the "
        "load over the travel that it causes, which is larger: see nut_axial_stiffness_secant."
    )


@assumption("friction_without_preload")
def friction_without_preload(stage: Stage) -> str | None:
    """For torques, losses and efficiencies."""
    if stage.friction is None or not is_preloaded(stage):
        return None
    return (
        "Torques, forces, losses and efficiencies are those of the operating load alone, without "
        "the preload of the nut: its drag torque is preload_torque."
    )


@assumption("shared_without_preload")
def shared_without_preload(stage: Stage) -> str | None:
    """For loads of threads; a modelled split nut has its preload in them."""
    if stage.load_sharing is None or not _has_unmodelled_preload(stage):
        return None
    return (
        "Loads, pressures and deflections of the threads of [stage.load_sharing] are those of the "
        "operating load alone, without the preload of strength.play; static_safety and lives "
        "include it."
    )


def _has_unmodelled_preload(stage: Stage) -> bool:
    return is_preloaded(stage) and split_nut_of(stage) is None


@assumption("held_rollers")
def held_rollers(stage: Stage) -> str | None:
    """For loads of threads that are computed."""
    if stage.load_sharing is None or stage.load_sharing.roller_bending is not None:
        return None
    return (
        "For the loads of threads, rollers neither lean nor bend: their ends are held rigidly. In "
        "a softer support the first threads carry more; [stage.load_sharing.roller_bending] "
        "computes it."
    )


@assumption("equal_friction")
def equal_friction(stage: Stage) -> str | None:
    """For spin and rolling losses, which depend on the contact ellipses."""
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
    """For thread stiffnesses, which depend on the load distribution if there is one."""
    if stage.load_sharing is not None or not (has_contacts(stage) and _derives_stiffness(stage)):
        return None
    return _equal(stage)


@assumption("secant_stiffness")
def secant_stiffness(stage: Stage) -> str | None:
    """For the vibration model."""
    if not (_derives_stiffness(stage) and (has_contacts(stage) or stage.load_sharing is not None)):
        return None
    return (
        "For vibration, thread contacts are springs with their secant stiffness F/δ under the "
        "operating load, and shafts are rigid; the tangent stiffness of a Hertz contact at that "
        "load is 3/2 of it."
    )


def _equal_capacity(stage: Stage) -> str | None:
    if stage.load_sharing is None:
        return _equal(stage)
    if stage.load_sharing.split_nut is not None:
        return (
            "For capacities, safety and life, all threads of one half of the split nut are taken "
            "to carry the same load, although the file has [stage.load_sharing]."
        )
    return None


@assumption("static_sharing")
def static_sharing(stage: Stage) -> str | None:
    """For a static capacity that is computed from the contacts."""
    return _equal_capacity(stage) if derives_static_capacity(stage) else None


@assumption("dent_sharing")
def dent_sharing(stage: Stage) -> str | None:
    """For the permanent deformation, for which no capacity is needed."""
    return _equal_capacity(stage) if has_contacts(stage) and stage.strength is not None else None


@assumption("cut_sharing")
def cut_sharing(stage: Stage) -> str | None:
    """For the share of a contact ellipse that is cut."""
    return _equal_capacity(stage) if has_contacts(stage) and flanks_end(stage) else None


@assumption("dynamic_sharing")
def dynamic_sharing(stage: Stage) -> str | None:
    """For a dynamic capacity that is computed from the contacts, and for all lives."""
    return _equal_capacity(stage) if derives_dynamic_capacity(stage) else None


@assumption("static_criterion")
def static_criterion(stage: Stage) -> str | None:
    """Definition of the static capacity."""
    if not derives_static_capacity(stage):
        return None
    return (
        "The static capacity is the load at the permissible Hertz pressure of the file, a "
        "criterion of ball bearings (ISO 76); no standard exists for roller screws."
    )


@assumption("life_theory")
def life_theory(stage: Stage) -> str | None:
    """Theory of the dynamic capacity."""
    if not derives_dynamic_capacity(stage):
        return None
    assert stage.strength is not None
    if stage.strength.fatigue_rule == "equivalent_balls":
        return (
            "The dynamic capacity is rated by the formula of ball screws, with balls of equal "
            "curvature in place of the thread contacts and the material factor of the file; no "
            "standard exists for roller screws."
        )
    return (
        "The dynamic capacity is an estimate by the theory of ball bearings (Lundberg and "
        "Palmgren) with the material factor of the file; no standard exists for roller screws."
    )


def _flanks(stage: Stage) -> str:
    if flanks_end(stage):
        at_edge = (
            "which the file does not round (edge_radius): in an elastic half-space the pressure "
            "has no finite value at a sharp edge."
            if stage.thread.edge_radius is None
            else "which edge_pressure includes for the edge_radius of the file."
        )
        return (
            "Where a contact ellipse extends beyond the crest or root of a flank, pressures, and "
            "capacities and lives that the file does not give, are those of its remaining part "
            "(finding contact_truncation), without the concentration of pressure at the edge, "
            f"{at_edge}"
        )
    return (
        "Contact ellipses are taken to lie completely on the flanks, since the file does not say "
        "where flanks end (screw_addendum, roller_addendum); in reality a long ellipse is cut "
        "there, so its pressure is higher, and capacities and life are lower."
    )


@assumption("edges")
def edges(stage: Stage) -> str | None:
    """For the pressure at rounded crests."""
    if not flanks_end(stage) or stage.thread.edge_radius is None:
        return None
    return (
        "The pressure at rounded crests is that of elastic half-spaces: yielding of the steel is "
        "left out, and a real edge, which has no material behind it, is less stiff."
    )


@assumption("flanks_of_contacts")
def flanks_of_contacts(stage: Stage) -> str | None:
    """For pressures."""
    return _flanks(stage) if has_contacts(stage) else None


@assumption("flanks_of_static")
def flanks_of_static(stage: Stage) -> str | None:
    """For a static capacity that is computed from the contacts."""
    return _flanks(stage) if derives_static_capacity(stage) else None


@assumption("flanks_of_dynamic")
def flanks_of_dynamic(stage: Stage) -> str | None:
    """For a dynamic capacity that is computed from the contacts, and for all lives."""
    cut = derives_dynamic_capacity(stage) and cuts_fatigue(stage)
    return _flanks(stage) if cut else None


#: Where one of the assumptions above applies, the numbers depend on contact ellipses.
_OF_ELLIPSES = frozenset(_ASSUMPTIONS)
