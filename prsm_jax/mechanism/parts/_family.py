r"""The types of roller screws: what distinguishes one from another, as one static description.

All other rooms ask this description; none of them asks for the name of a type. With the leads over
2π of screw, roller and nut, h, h_R, h_n, and speeds of turning Ω, ω_R, ω_n about parallel axes, a
contact that neither opens nor closes moves axially at the same speed on both of its bodies, seen
from the carrier (speed ω):

$$v_s - h(\Omega-\omega) = v_R - h_R(\omega_R-\omega) = v_n - h_n(\omega_n-\omega).$$

Rollers keep their axial place in a body on which they roll if h_R is that body's lead over the
ratio of the radii; on the screw, which they touch from outside, with the opposite hand.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

RollerScrewType: TypeAlias = Literal["standard", "inverted", "recirculating", "differential"]
ROLLER_SCREW_TYPES: tuple[RollerScrewType, ...] = get_args(RollerScrewType)
Side: TypeAlias = Literal["screw", "nut"]


@dataclass(frozen=True)
class Family:
    """Description of a type of roller screws."""

    name: RollerScrewType
    #: The body that the motor turns; the other one is held against rotation, and is the one whose
    #: frame carrier speeds refer to.
    turning: Side
    #: The body in which rollers keep their axial place, and on which they roll without slip.
    #: `None`: in neither; rollers slide on both.
    carrying: Side | None
    #: Ratio r_n/r_R minus the number of starts, where starts determine it; else `None`: the ratio
    #: is a number of its own.
    ratio_beyond_starts: int | None
    #: Lead of the roller over the pitch, negative for a thread of the other hand than the screw's;
    #: 0 for grooves.
    roller_hand: int
    #: Whether the nut has the starts of the screw; else it has grooves.
    nut_has_thread: bool
    #: Smallest and largest number of starts, both allowed; `None`: above 2, as the radii require.
    starts: tuple[float, float] | None
    #: Why there is no gear; empty if the rollers may have one, with the body that carries them.
    no_gear: str
    #: The radii, in words.
    radii: str
    #: Axial travel per turn, in words.
    travel: str

    @property
    def held(self) -> Side:
        """The body that is held against rotation."""
        return "nut" if self.turning == "screw" else "screw"

    @property
    def sliding(self) -> tuple[Side, ...]:
        """The bodies on which the rollers slide."""
        sides: tuple[Side, ...] = ("screw", "nut")
        return tuple(side for side in sides if side != self.carrying)

    @property
    def gear_body(self) -> Side | None:
        """The body that has the teeth which the rollers' gears mesh with."""
        return None if self.no_gear else self.carrying

    @property
    def lead_is_fixed(self) -> bool:
        """Whether the travel per turn follows from threads alone, at any speed of the carrier."""
        return self.nut_has_thread


FAMILIES: dict[RollerScrewType, Family] = {
    one.name: one
    for one in (
        Family(
            name="standard",
            turning="screw",
            carrying="nut",
            ratio_beyond_starts=0,
            roller_hand=1,
            nut_has_thread=True,
            starts=None,
            no_gear="",
            radii="r_n = n r_R, r_s = (n - 2) r_R",
            travel="n p",
        ),
        Family(
            name="inverted",
            turning="nut",
            carrying="screw",
            ratio_beyond_starts=2,
            roller_hand=-1,
            nut_has_thread=True,
            starts=None,
            no_gear="",
            radii="r_s = n r_R, r_n = (n + 2) r_R",
            travel="n p",
        ),
        Family(
            name="recirculating",
            turning="screw",
            carrying=None,
            ratio_beyond_starts=None,
            roller_hand=0,
            nut_has_thread=True,
            starts=(1.0, 2.0),
            no_gear="its rollers have grooves, and a cam returns them",
            radii="r_n = radius_ratio r_R, r_s = (radius_ratio - 2) r_R",
            travel="n p",
        ),
        Family(
            name="differential",
            turning="screw",
            carrying="nut",
            ratio_beyond_starts=None,
            roller_hand=0,
            nut_has_thread=False,
            starts=(1.0, 1000.0),
            no_gear="its rollers roll in the grooves of the nut by friction alone",
            radii="r_n = radius_ratio r_R, r_s = (radius_ratio - 2) r_R",
            travel="n p (1 - carrier ratio)",
        ),
    )
}
