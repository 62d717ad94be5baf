"""Rollers that differ from the others of their stage: worn, out of place, or missing."""

from ...fields import (
    ANY,
    POSITIVE,
    ROLLER_NUMBER,
    SLANT,
    CountOrTraced,
    Limited,
    OptionalNumber,
    Scalar,
    choice,
    optional_number,
    plain,
)


class UnequalRoller(Limited):
    """One roller that differs from the others; properties not given are those of the others.

    Leaves: the factors, the offset and the thinning. Static: `number` (which roller, counted from 1
    at the angle 0) and `missing`.

    **Raises:** `ValueError` at construction for a number below 1, a roller that is missing and has
    factors, or one without any difference.
    """

    number: int = choice("number of the roller, from 1 at the angle 0", limit=ROLLER_NUMBER)
    stiffness_factor: OptionalNumber = optional_number(
        "1",
        "stiffness of this roller's meshes (screw, ring gear, nut) over that of the others",
        limit=POSITIVE,
    )
    mass_factor: OptionalNumber = optional_number(
        "1",
        "mass and moment of inertia of this roller over those of the others",
        limit=POSITIVE,
    )
    position_offset: OptionalNumber = optional_number(
        "rad",
        "angle of this roller from its place, positive in the direction of numbering",
        limit=SLANT,
    )
    tooth_thinning: OptionalNumber = optional_number(
        "m",
        "axial thickness of the others' teeth minus that of this roller's (load sharing)",
        limit=ANY,
    )
    missing: bool = choice("whether the place of this roller is empty", default=False, implied=True)

    def __check_init__(self) -> None:
        differs = [
            name
            for name in ("stiffness_factor", "mass_factor", "position_offset", "tooth_thinning")
            if getattr(self, name) is not None
        ]
        if self.missing and differs:
            raise ValueError(
                f"unequal_roller {self.number} is missing and has {' and '.join(differs)}, which "
                "have no effect then; remove them, or missing"
            )
        if not self.missing and not differs:
            raise ValueError(
                f"unequal_roller {self.number} has only its number; give stiffness_factor, "
                "mass_factor, position_offset, tooth_thinning or missing = true, or remove it"
            )

    @property
    def carries_otherwise(self) -> bool:
        """Whether this roller takes a different share of the load."""
        return self.stiffness_factor is not None or self.tooth_thinning is not None


def check_unequal_rollers(rollers: tuple[UnequalRoller, ...], roller_count: int) -> None:
    """Check that unequal rollers fit a stage.

    **Raises:** `ValueError` for a number above the roller count, the same number twice, or if all
    rollers are missing.
    """
    seen: set[int] = set()
    for roller in rollers:
        if roller.number > roller_count:
            raise ValueError(
                f"unequal_roller has number {roller.number}, but roller_count is {roller_count}; "
                f"choose a number from 1 to {roller_count}"
            )
        if roller.number in seen:
            raise ValueError(f"unequal_roller {roller.number} is given twice; remove one")
        seen.add(roller.number)
    if rollers and sum(roller.missing for roller in rollers) == roller_count:
        raise ValueError(f"all {roller_count} rollers are missing; leave at least one")


def total_factor(
    rollers: tuple[UnequalRoller, ...], roller_count: CountOrTraced, name: str
) -> Scalar | int:
    """Sum of a factor over the rollers present; 1 for each roller without it.

    **Arguments:**

    - `rollers`: the unequal rollers of a stage.
    - `roller_count`: places for rollers, N.
    - `name`: `"stiffness_factor"` or `"mass_factor"`.

    **Returns:** an integer if no roller has such a factor, so that nothing is traced.
    """
    total: Scalar | int = plain(roller_count)
    for roller in rollers:
        factor = 0 if roller.missing else getattr(roller, name)
        if factor is not None:
            total = total + (factor - 1)
    return total


__all__ = ["UnequalRoller", "check_unequal_rollers", "total_factor"]
