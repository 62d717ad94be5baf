"""Dimensions that change when a number of the thread is set by name, and those that do not."""

from collections.abc import Iterable, Sequence

from .._mechanism import Mechanism, Stage
from ._parameters import find_parameters

#: Independent numbers of the thread that each name sets; then the derived numbers that a design
#: variable keeps constant instead.
_SETS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "lead": (("lead",), ()),
    "starts": (("starts",), ()),
    "roller_radius": (("roller_radius",), ()),
    "radius_ratio": (("radius_ratio",), ()),
    "contact_angle": (("contact_angle",), ()),
    "roller_profile_radius": (("roller_profile_radius",), ()),
    "flank_angle": (("contact_angle",), ()),
    "pitch": (("lead",), ()),
    "screw_radius": (("roller_radius",), ()),
    "roller_radius_at_fixed_screw_radius": (("roller_radius", "starts"), ("screw_radius",)),
    "starts_at_fixed_pitch": (("starts", "lead"), ("pitch",)),
    "gear_module": (("roller_radius",), ()),
}
#: Derived numbers, and the independent numbers from which they follow.
_DERIVED: dict[str, tuple[str, ...]] = {
    "pitch": ("lead", "starts"),
    "screw_radius": ("roller_radius", "starts"),
    "nut_radius": ("roller_radius", "starts"),
    "centre_distance": ("roller_radius", "starts"),
    "flank_angle": ("contact_angle",),
}
#: Derived numbers that have the ratio of the radii.
_RADII = ("screw_radius", "nut_radius", "centre_distance")


def _dependencies(stage: Stage) -> dict[str, tuple[str, ...]]:
    dependencies = {name: (name,) for name in ("lead", "starts", "roller_radius", "contact_angle")}
    dependencies |= _DERIVED
    ratio = "radius_ratio"
    if stage.thread.family.ratio_beyond_starts is None:
        # The ratio of the radii is a number of its own.
        dependencies |= dict.fromkeys(_RADII, ("roller_radius", ratio)) | {ratio: (ratio,)}
    has_profile_radius = stage.thread.roller_profile_radius is not None
    own = ("roller_profile_radius",) if has_profile_radius else ("roller_radius", "contact_angle")
    dependencies["roller_profile_radius"] = own
    if stage.gear is not None and stage.gear.roller_teeth is not None:
        dependencies["gear_module"] = ("roller_radius",)
        if stage.gear.ring_teeth is None:
            dependencies["ring gear teeth"] = ("starts",)
    bodies = ("screw", "roller", "nut", "carrier", "ring_gear")
    parts = [(body, getattr(stage, body)) for body in bodies]
    if any(part is not None and part.mass is None and part.length is not None for _, part in parts):
        dependencies["masses from dimensions"] = dependencies["nut_radius"]
    return dependencies


def what_follows(
    mechanism: Mechanism, name: str, frozen: Iterable[str] = ()
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Numbers that follow when a number is set by name, and numbers that stay.

    A number that is not given in the file (the roller's profile radius, r_R / sin α) follows,
    unless it is frozen by name.

    **Arguments:**

    - `mechanism`: the mechanism; the first stage that has the number is used.
    - `name`: a parameter.
    - `frozen`: parameters that are set to their own values at the same time.

    **Returns:** names of the numbers that follow and of those that stay; both empty for a number
    that no other dimension depends on (a load, a modulus).

    **Raises:** `UnknownNameError` as in `find_parameters`.
    """
    path = find_parameters(mechanism, name)[0].path
    head, _, field = path.rpartition(".")
    parts = head.split(".")
    if field not in _SETS or (parts[-1] != "thread" and field != "gear_module"):
        return (), ()
    stage = mechanism.stages[int(parts[1]) - 1]
    fixed = {find_parameters(mechanism, other)[0].path.rpartition(".")[2] for other in frozen}
    sets, constant = _SETS[field]
    if constant == ("screw_radius",):
        sets = tuple(_dependencies(stage)["screw_radius"])
    follows, stays = [], []
    for other, needs in _dependencies(stage).items():
        if other == field:
            continue
        moves = bool(set(needs) & set(sets)) and other not in constant
        # A number that is set itself does not follow another.
        moves = moves and other not in fixed
        (follows if moves else stays).append(other)
    if field == "roller_radius_at_fixed_screw_radius":
        follows.remove("roller_radius")
    if field == "starts_at_fixed_pitch":
        follows.remove("starts")
    return tuple(follows), tuple(stays)


def follows_in_words(mechanism: Mechanism, name: str, frozen: Iterable[str] = ()) -> str:
    """The same as a sentence; empty if nothing follows or stays."""
    follows, stays = what_follows(mechanism, name, frozen)
    return dependents_in_words(name, follows, stays)


def dependents_in_words(name: str, follows: Sequence[str], stays: Sequence[str]) -> str:
    """Numbers that follow and numbers that stay, as a sentence; empty if there are none."""
    if not (follows or stays):
        return ""

    def listed(names: Sequence[str]) -> str:
        return ", ".join(names).replace("_", " ") or "nothing"

    return f"{name}: moves with it: {listed(follows)}; stays: {listed(stays)}"
