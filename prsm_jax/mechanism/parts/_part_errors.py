"""Errors of real parts in the load sharing, and a nut that is free to move sideways and to lean."""

from typing import Any

from ...fields import (
    ANY,
    POSITIVE,
    CountOrTraced,
    Limited,
    OptionalNumber,
    OptionalNumbers,
    optional_number,
    optional_numbers,
)

#: Each amount and the angle that gives its direction.
_ERRORS = {
    "nut_eccentricity": "nut_eccentricity_angle",
    "nut_tilt": "nut_tilt_angle",
    "screw_eccentricity": "screw_eccentricity_angle",
    "screw_tilt": "screw_tilt_angle",
}
_LOADS = {
    "radial_load": "radial_load_angle",
    "overturning_moment": "overturning_moment_angle",
}


def _amount(unit: str, description: str) -> Any:
    return optional_number(unit, description, limit=ANY)


def _angle(words: str) -> Any:
    text = f"direction {words}, from roller 1 in the direction of numbering; 0 when absent"
    return optional_number("rad", text, limit=ANY)


def _per_roller(unit: str, description: str) -> Any:
    return optional_numbers(unit, f"{description}, one number per roller place", limit=ANY)


def _check_angles(part: Limited, angles: dict[str, str], name: str) -> None:
    for amount, angle in angles.items():
        if getattr(part, amount) is None and getattr(part, angle) is not None:
            raise ValueError(f"{name} has {angle}, but no {amount}; give it, or remove the angle")


class PartErrors(Limited):
    """Errors of nut, screw and rollers at one position of the parts.

    An eccentricity is the distance of a thread's axis from the axis of the mechanism; a dial gauge
    shows twice that as runout. A tilt is the angle between both axes; its direction is the one
    towards which the axis leans at the end where thread numbers rise. Angles are those at the
    position that is considered: with the screw's they follow it as it turns.

    Leaves: all numbers. Static: which of them are present. Absent ones are not modelled.

    **Raises:** `ValueError` at construction for an angle without its amount, or without any error.
    """

    nut_eccentricity: OptionalNumber = _amount(
        "m", "distance of the nut's thread axis from the axis of the mechanism"
    )
    nut_eccentricity_angle: OptionalNumber = _angle("of the nut's eccentricity")
    nut_tilt: OptionalNumber = _amount("rad", "angle by which the nut's thread axis leans")
    nut_tilt_angle: OptionalNumber = _angle("towards which the nut's axis leans")
    screw_eccentricity: OptionalNumber = _amount(
        "m", "distance of the screw's thread axis from the axis of the mechanism"
    )
    screw_eccentricity_angle: OptionalNumber = _angle("of the screw's eccentricity")
    screw_tilt: OptionalNumber = _amount("rad", "angle by which the screw's thread axis leans")
    screw_tilt_angle: OptionalNumber = _angle("towards which the screw's axis leans")
    roller_diameter_deviation: OptionalNumbers = _per_roller(
        "m", "pitch diameter of a roller minus its nominal value"
    )
    roller_tilt: OptionalNumbers = _per_roller(
        "rad",
        "angle by which a roller's axis leans outward at the end with the higher thread numbers",
    )

    def __check_init__(self) -> None:
        _check_angles(self, _ERRORS, "part_errors")
        names = (*_ERRORS, "roller_diameter_deviation", "roller_tilt")
        if all(getattr(self, name) is None for name in names):
            raise ValueError(f"part_errors has no error; give one of {', '.join(names)}")


class FreeNut(Limited):
    """A nut that moves sideways and leans until its rollers balance a radial load and a moment.

    The moment is about the middle of the engaged threads; its direction is the one towards which it
    tips the nut's end where thread numbers rise. Absent loads are 0: the nut then centres itself.
    An elastic seat, given by its stiffnesses, pulls the nut back to where it was mounted, with its
    errors; absent stiffnesses are 0, and very large ones hold the nut.

    Leaves: all numbers. Static: which of them are present.

    **Raises:** `ValueError` at construction for an angle without its amount.
    """

    radial_load: OptionalNumber = _amount("N", "radial load on the nut")
    radial_load_angle: OptionalNumber = _angle("of the radial load")
    overturning_moment: OptionalNumber = _amount("N·m", "moment that tips the nut")
    overturning_moment_angle: OptionalNumber = _angle("towards which the moment tips the nut")
    radial_stiffness: OptionalNumber = optional_number(
        "N/m", "radial stiffness of the nut's seat; free sideways when absent", limit=POSITIVE
    )
    tilting_stiffness: OptionalNumber = optional_number(
        "N·m/rad",
        "stiffness of the nut's seat against a lean about the middle of the engaged threads; free "
        "to lean when absent",
        limit=POSITIVE,
    )

    def __check_init__(self) -> None:
        _check_angles(self, _LOADS, "free_nut")


def check_part_errors(errors: PartErrors | None, roller_count: CountOrTraced) -> None:
    """Check that errors of rollers fit a stage.

    **Raises:** `ValueError` unless lists have one number for each of `roller_count` places.
    """
    if errors is None:
        return
    for name in ("roller_diameter_deviation", "roller_tilt"):
        values = getattr(errors, name)
        if values is not None and values.shape[-1] != roller_count:
            raise ValueError(
                f"part_errors.{name} has {values.shape[-1]} numbers, but roller_count is "
                f"{roller_count}; give one number for each place of a roller"
            )
