"""The flanks of an annular roller: rings without a lead, in line contact with the screw."""

from ...fields import ACUTE_ANGLE, SLANT, Limited, Number, OptionalNumber, number, optional_number


class LineContact(Limited):
    """Flanks that touch along a line: a screw thread and a roller of rings.

    The identity r_n = n r_R of a threaded roller does not hold for an annular one, so the radii and
    the centre distance are given individually. The analysis of line contact uses only this part,
    not the stage's `thread`.
    """

    screw_minor_radius: Number = number("m", "radius at the root of the screw's flank")
    screw_major_radius: Number = number("m", "radius at the crest of the screw's flank")
    roller_minor_radius: Number = number("m", "radius at the root of the roller's flank")
    roller_major_radius: Number = number("m", "radius at the crest of the roller's flank")
    centre_distance: Number = number("m", "distance between screw and roller axes, d")
    screw_profile_angle: Number = number(
        "rad",
        "angle of the screw's flank from the transverse plane, j",
        limit=ACUTE_ANGLE,
    )
    roller_profile_angle: Number = number(
        "rad",
        "angle of the roller's flank from the transverse plane, k",
        limit=ACUTE_ANGLE,
    )
    lead_angle: OptionalNumber = optional_number(
        "rad", "lead angle of the screw's thread, ψ", limit=SLANT
    )
