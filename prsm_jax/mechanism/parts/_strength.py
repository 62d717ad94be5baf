"""Data for strength and life of a stage: given capacities or factors, the shaft, the play."""

from typing import Literal, TypeAlias, get_args

from ...fields import (
    INNER_SHARE,
    NOT_NEGATIVE,
    POSITIVE,
    SHARE_ABOVE_0,
    Limited,
    Number,
    OptionalNumber,
    choice,
    number,
    optional_number,
    part,
)

EndConditions: TypeAlias = Literal[
    "fixed_free", "supported_supported", "fixed_supported", "fixed_fixed"
]
END_CONDITIONS: tuple[EndConditions, ...] = get_args(EndConditions)
PreloadArrangement: TypeAlias = Literal["double_nut", "split_nut"]
FatigueRule: TypeAlias = Literal["lundberg_palmgren", "equivalent_balls"]


class ScrewShaft(Limited):
    """The screw as a column and as a rotating shaft: supports, and radius of the root.

    Static: `end_conditions`, the supports of the two ends.

    **Raises:** `ValueError` at construction for unknown end conditions.
    """

    end_conditions: EndConditions = choice("supports of the two ends of the screw")
    unsupported_length: OptionalNumber = optional_number(
        "m", "longest length between supports; the screw's length when absent"
    )
    loaded_length: OptionalNumber = optional_number(
        "m", "longest length under axial load; the unsupported length when absent"
    )
    root_radius: OptionalNumber = optional_number(
        "m", "radius at the root of the screw's thread; r_s minus the roller's addendum when absent"
    )
    yield_strength: OptionalNumber = optional_number(
        "Pa", "yield strength, for the buckling of short screws; Euler alone when absent"
    )
    permissible_speed_share: Number = number(
        "1",
        "permissible share of the critical speed",
        default=0.8,
        limit=SHARE_ABOVE_0,
    )
    dn_limit: OptionalNumber = optional_number(
        "m·rad/s", "largest product of nominal screw diameter and speed (DN value)"
    )


class AxialPlay(Limited):
    """Play between the flanks: backlash, as measured or from thinned teeth, or a preload.

    Static: `arrangement`. A preload leaves no backlash, so only one of them can be given.

    **Raises:** `ValueError` at construction for an unknown arrangement, or a preload together with
    a backlash.
    """

    axial_backlash: OptionalNumber = optional_number(
        "m",
        "measured travel of the unloaded nut from flank to flank",
        limit=NOT_NEGATIVE,
    )
    screw_tooth_thinning: OptionalNumber = optional_number(
        "m",
        "half a pitch minus the axial thickness of a screw tooth at its nominal radius",
        limit=NOT_NEGATIVE,
    )
    roller_tooth_thinning: OptionalNumber = optional_number(
        "m",
        "half a pitch minus the axial thickness of a roller tooth at its nominal radius",
        limit=NOT_NEGATIVE,
    )
    nut_tooth_thinning: OptionalNumber = optional_number(
        "m",
        "half a pitch minus the axial thickness of a nut tooth at its nominal radius",
        limit=NOT_NEGATIVE,
    )
    preload_force: OptionalNumber = optional_number(
        "N",
        "axial preload between two nuts or nut halves",
        limit=POSITIVE,
    )
    arrangement: PreloadArrangement = choice(
        "preload between two nuts, or between the halves of one on the same rollers",
        default="double_nut",
        implied=True,
    )

    def __check_init__(self) -> None:
        if self.preload_force is not None and self.axial_backlash is not None:
            raise ValueError(
                "the play has preload_force and axial_backlash, but a preloaded nut has no "
                "backlash; remove one"
            )


class Strength(Limited):
    """Numbers for static safety, rating life, buckling, critical speed and play of a stage.

    Capacities are given, e.g. from catalogues and tests, or follow from the contacts: the static
    one from `permissible_pressure`, the dynamic one from `material_factor`. Results with missing
    data are not evaluated.

    Static: `fatigue_rule`, by which the dynamic capacity is derived.

    **Raises:** `ValueError` at construction for an unknown rule.
    """

    permissible_pressure: OptionalNumber = optional_number(
        "Pa", "Hertz pressure of the static capacity (ISO 76: 4.2 GPa for ball bearings)"
    )
    static_capacity: OptionalNumber = optional_number(
        "N", "static axial capacity, C_0a, if known", limit=POSITIVE
    )
    dynamic_capacity: OptionalNumber = optional_number(
        "N",
        "dynamic axial capacity for 1e6 turns, C_a, if known",
        limit=POSITIVE,
    )
    material_factor: OptionalNumber = optional_number(
        "1",
        "capacity of the steel over that of Lundberg and Palmgren, b_m; to estimate C_a",
        limit=POSITIVE,
    )
    fatigue_rule: FatigueRule = choice(
        "estimate of C_a: Lundberg and Palmgren's theory for the contact ellipses, or the formula "
        "of ball screws with equivalent balls, as makers rate",
        default="lundberg_palmgren",
        implied=True,
    )
    reliability: OptionalNumber = optional_number(
        "1",
        "probability of survival for the modified life",
        limit=INNER_SHARE,
    )
    life_modification_factor: OptionalNumber = optional_number(
        "1",
        "factor of lubrication, cleanliness and material on life, a_ISO",
        limit=POSITIVE,
    )
    oscillation_amplitude: OptionalNumber = optional_number(
        "rad",
        "half of the angle of oscillation, for a screw that oscillates",
        limit=POSITIVE,
    )
    required_life: OptionalNumber = optional_number("s", "required life, as operating time")
    shaft: ScrewShaft | None = part("no buckling, critical speed or DN value of the screw")
    play: AxialPlay | None = part("no backlash or lost motion")
