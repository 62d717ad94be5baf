"""Whether the numbers and parts of a stage fit its type of roller screw."""

from collections.abc import Iterable
from typing import Any

from .._errors import MissingDataError
from ..fields import check_related
from .parts import FAMILIES, ROLLER_SCREW_TYPES, RollerScrewType


def check_type(stage: Any) -> None:
    """Check that starts, radii, gear and conventions fit the type of a stage.

    **Raises:** `ValueError` at the first that does not, with the type, the value and the remedy.
    """
    if stage.type not in FAMILIES:
        words = ", ".join(ROLLER_SCREW_TYPES)
        raise ValueError(f"type is {stage.type!r}; choose one of {words}")
    family, thread = FAMILIES[stage.type], stage.thread
    named = f'type = "{family.name}"'
    if family.ratio_beyond_starts is not None and thread.radius_ratio is not None:
        raise ValueError(
            f"thread.radius_ratio is given, but with {named} the radii follow from the starts: "
            f"{family.radii}; remove it, or choose another type"
        )
    if family.ratio_beyond_starts is None and thread.radius_ratio is None:
        raise ValueError(
            f"{named} needs thread.radius_ratio, nut radius over roller radius, because its "
            f"starts do not set its radii: {family.radii}"
        )
    if family.starts is not None:
        check_related(("thread", "starts"), thread.starts, thread.starts_limit)
    if family.no_gear:
        for part in ("gear", "ring_gear"):
            if getattr(stage, part) is not None:
                raise ValueError(f"{named} has no gear: {family.no_gear}; remove stage.{part}")
    if family.gear_body == "screw" and stage.ring_gear is not None:
        raise ValueError(
            f"{named} has its teeth on the screw, not in a ring gear; remove stage.ring_gear"
        )
    if family.name == "standard":
        return
    for name, usual in (("curvature", "exact"), ("line_contact", None)):
        given = getattr(stage, name)
        if given != usual:
            what = repr(given) if isinstance(given, str) else "given"
            raise ValueError(
                f"stage.{name} is {what}, which is known for standard roller screws only, not for "
                f"{named}; remove it"
            )


def require_type(
    stages: Iterable[Any], what: str, known: tuple[RollerScrewType, ...] = ("standard",)
) -> None:
    """Refuse what is not known for the type of a stage.

    **Arguments:**

    - `stages`: the stages.
    - `what`: what is asked for and its verb, for the message.
    - `known`: the types for which it is known.

    **Raises:** `MissingDataError` with the type and those for which it is known.
    """
    for stage in stages:
        if stage.type not in known:
            raise MissingDataError(
                f"{what} known for {' and '.join(known)} roller screws only, not for "
                f'type = "{stage.type}"'
            )


def check_types_in_series(stages: tuple[Any, ...]) -> None:
    """**Raises:** `ValueError` if one of several stages in series is not a standard one."""
    others = [(number, one) for number, one in enumerate(stages, 1) if one.type != "standard"]
    if len(stages) > 1 and others:
        number, stage = others[0]
        raise ValueError(
            f'stage {number} has type = "{stage.type}", but in a series of stages each nut carries '
            "the next screw, as standard roller screws do; give it alone, or make it standard"
        )
