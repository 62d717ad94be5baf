"""Data for the load sharing of threads and rollers: sections, teeth, errors, preload."""

from typing import Any, Literal, TypeAlias

from ...fields import (
    ANY,
    NOT_NEGATIVE,
    POSITIVE,
    SHAPES,
    THREADS,
    Limit,
    Limited,
    Number,
    OptionalNumber,
    OptionalNumbers,
    choice,
    number,
    optional_number,
    optional_numbers,
    part,
)
from ._part_errors import FreeNut, PartErrors

Mounting: TypeAlias = Literal["same_end", "opposite_end"]


class ThreadTooth(Limited):
    """Proportions of the thread teeth, for their compliance after Yamamoto.

    The compliance is per unit length of thread: `effective_length` is the length of thread that
    carries one contact. No standard gives it; a few contact widths are usual. A body widens or
    shrinks as a ring, under the mean of all contacts around it, so this part has its own length.
    """

    effective_length: Number = number("m", "length of thread that carries one contact")
    screw_dedendum: Number = number("m", "depth of the screw's thread below its nominal radius")
    roller_dedendum: Number = number("m", "depth of the roller's thread below its nominal radius")
    nut_dedendum: Number = number("m", "depth of the nut's thread beyond its nominal radius")
    radial_length: OptionalNumber = optional_number(
        "m",
        "length of thread over which one contact widens a body; its share of the circumference "
        "when absent",
    )
    pitch_line_thickness: OptionalNumber = optional_number(
        "m", "axial thickness of a tooth at the nominal radius; half a pitch when absent"
    )


class SplitNut(Limited):
    """A nut of two halves pushed apart by a spacer, so that rollers are loaded on both flanks.

    Static: `after_thread`. Either the force is given or the excess length of the spacer.

    **Raises:** `ValueError` at construction unless exactly one of `preload` and `offset` is given,
    or for a thread number below 1.
    """

    after_thread: int = choice("number of the thread after which the nut is split", limit=THREADS)
    preload: OptionalNumber = optional_number(
        "N", "force in the spacer without an axial load", limit=POSITIVE
    )
    offset: OptionalNumber = optional_number(
        "m",
        "length of the spacer minus the gap between the halves at first contact",
        limit=ANY,
    )
    spacer_stiffness: OptionalNumber = optional_number(
        "N/m",
        "axial stiffness of the spacer; that of the nut between two threads when absent",
        limit=POSITIVE,
    )

    def __check_init__(self) -> None:
        if (self.preload is None) == (self.offset is None):
            state = "both" if self.preload is not None else "neither"
            raise ValueError(f"split_nut needs either preload or offset; it has {state}")


class RollerBending(Limited):
    """Rollers that lean and bend in the plane through the axes of screw and roller.

    Screw and nut press a roller on opposite sides of its axis, so its load tilts it, and the
    difference of the forces along it bends it. Its support, by carriers and ring gears, resists the
    lean of the line through its ends; the roller itself resists bending by its section.

    Static: `shapes`, and whether a support is given.
    """

    tilting_stiffness: OptionalNumber = optional_number(
        "N·m/rad",
        "stiffness of the support of one roller against its lean; free to lean when absent",
        limit=POSITIVE,
    )
    shapes: int = choice(
        "number of shapes of the deflection: 1 leans only, more bend the roller too",
        default=8,
        limit=SHAPES,
    )


def _gap(description: str, limit: Limit) -> Any:
    text = description + ", one number per thread"
    return optional_numbers("m", text, limit=limit, length="thread_count")


class LoadSharing(Limited):
    """Chains of screw, nut and rollers whose threads share the load.

    Threads are numbered from 1, at the end of the nut where the screw's force enters. All lists
    have one number per thread. Position errors are axial, positive in the direction in which the
    screw pushes the rollers under a positive load.

    Static: `thread_count`, `mounting` and which data are present. Absent data are not modelled:
    without `backlash` and `split_nut` a thread has one flank, the loaded one.

    **Raises:** `ValueError` at construction for a thread count below 1, an unknown mounting, lists
    of a wrong length, or a nut that is split after its last thread.
    """

    thread_count: int = choice(
        "number of engaged threads of one roller, one node each", limit=THREADS
    )
    mounting: Mounting = choice(
        "end of the nut that is supported, relative to the end where the screw's force enters",
        default="same_end",
    )
    tooth: ThreadTooth | None = part(
        "teeth are rigid: only contacts and shafts are elastic, and loads are less even"
    )
    split_nut: SplitNut | None = part("one nut without preload")
    backlash: OptionalNumber = optional_number(
        "m",
        "axial play of the nut between its flanks; below 0 for rollers that are too thick",
        limit=ANY,
    )
    screw_segment_stiffness: OptionalNumber = optional_number(
        "N/m",
        "axial stiffness of the screw over one pitch; from its section when absent",
        limit=POSITIVE,
    )
    roller_segment_stiffness: OptionalNumber = optional_number(
        "N/m",
        "axial stiffness of a roller over one pitch; from its section when absent",
        limit=POSITIVE,
    )
    nut_segment_stiffness: OptionalNumber = optional_number(
        "N/m",
        "axial stiffness of the nut over one pitch; from its section when absent",
        limit=POSITIVE,
    )
    torsion: bool = choice(
        "whether screw and nut also twist, where their stiffness is that of their sections",
        default=False,
    )
    screw_pitch_error: OptionalNumbers = _gap("position error of the screw's teeth", limit=ANY)
    roller_pitch_error: OptionalNumbers = _gap(
        "position error of the rollers' teeth",
        limit=ANY,
    )
    nut_pitch_error: OptionalNumbers = _gap("position error of the nut's teeth", limit=ANY)
    screw_relief: OptionalNumbers = _gap(
        "profile relief between screw and roller, axially, on either flank",
        limit=NOT_NEGATIVE,
    )
    nut_relief: OptionalNumbers = _gap(
        "profile relief between nut and roller, axially, on either flank",
        limit=NOT_NEGATIVE,
    )
    screw_wear: OptionalNumbers = _gap(
        "axial wear of the flanks between screw and roller that carry a positive load",
        limit=NOT_NEGATIVE,
    )
    nut_wear: OptionalNumbers = _gap(
        "axial wear of the flanks between nut and roller that carry a positive load",
        limit=NOT_NEGATIVE,
    )
    part_errors: PartErrors | None = part(
        "nut and screw are coaxial, and rollers have equal diameters"
    )
    roller_bending: RollerBending | None = part(
        "rollers neither lean nor bend: their ends are held rigidly"
    )
    free_nut: FreeNut | None = part("the nut is held: it neither moves sideways nor leans")

    def __check_init__(self) -> None:
        if self.split_nut is not None and self.split_nut.after_thread >= self.thread_count:
            raise ValueError(
                f"split_nut has after_thread {self.split_nut.after_thread}, but there are "
                f"{self.thread_count} threads; choose a smaller number"
            )

    @property
    def has_reverse_flanks(self) -> bool:
        """Whether the flanks that carry a negative load are modelled."""
        return self.backlash is not None or self.split_nut is not None

    @property
    def rollers_differ(self) -> bool:
        """Whether each roller has a load of its own, because of its place around the screw."""
        return self.part_errors is not None or self.free_nut is not None
