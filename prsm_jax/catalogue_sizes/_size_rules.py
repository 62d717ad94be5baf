"""Numbers that no row of a catalogue gives: two sets of rules for them."""

import dataclasses
import math

from ..mechanism import FatigueRule

#: Smallest addendum of a roller for which a roller more is given up, over the pitch.
_LEAST_ADDENDUM = 0.1
#: Pitch from which on the sizes have larger capacities: between 3 and 4 mm, at all diameters [m].
_COARSE = 3.5e-3
#: Largest axial play [m] below a pitch [m]: the table prints three values, by the pitch alone.
_PLAY = ((1.8e-3, 20e-6), (2.5e-3, 40e-6), (math.inf, 70e-6))


def rollers_that_fit(centre_distance: float | int, largest_radius: float | int) -> int:
    """Largest number of rollers beside each other: 2 a sin(π/N) ≥ 2 r, at least 3."""
    return max(3, math.floor(math.pi / math.asin(largest_radius / centre_distance) + 1e-9))


@dataclasses.dataclass(frozen=True)
class SizeRules:
    """What completes the dimensions of a size to a mechanism."""

    #: Parts of the nut's length without roller and without loaded thread, both ends together [m].
    roller_ends: float
    thread_ends: float
    #: Least lengths of roller and loaded thread over that of the nut.
    least_roller: float
    least_thread: float
    #: Half of the smallest gap between crests of neighbouring rollers, over the roller's radius.
    gap: float
    #: Rollers fewer than those whose pitch circles fit; `None`: as many as fit with their crests.
    spare_rollers: int | None
    #: Profile radius of the roller over the pitch; `None`: centred on the roller's axis.
    profile_ratio: float | None
    #: The same for coarse pitches.
    coarse_profile_ratio: float | None
    #: Theory of the dynamic capacity, and its material factor.
    fatigue_rule: FatigueRule
    material_factor: float
    #: Friction coefficient: a constant, and a part for each start but one.
    friction: float
    friction_by_starts: float
    #: Whether the axial play follows from the pitch if it is not given.
    estimates_play: bool

    def roller_length(self, nut_length: float | int) -> float:
        """Length of a roller [m]."""
        return max(nut_length - self.roller_ends, self.least_roller * nut_length)

    def threaded_length(self, nut_length: float | int) -> float:
        """Length of a roller's thread that carries load [m]."""
        return max(nut_length - self.thread_ends, self.least_thread * nut_length)

    def profile_radius(self, pitch: float | int) -> float | None:
        """Profile radius of a roller; `None` if it is centred on the roller's axis [m]."""
        ratio = self.profile_ratio if pitch < _COARSE else self.coarse_profile_ratio
        return None if ratio is None else ratio * pitch

    def rollers(
        self,
        centre_distance: float | int,
        radius: float | int,
        addendum: float | int,
        pitch: float | int,
    ) -> tuple[int, float]:
        """Number of rollers, and the addendum with which they fit [m].

        **Arguments:**

        - `centre_distance`: of screw and rollers [m].
        - `radius`: nominal radius of the roller [m].
        - `addendum`: that of the roller if neighbours left room for it [m].
        - `pitch`: [m].
        """
        body = radius * (1 + self.gap)
        if self.spare_rollers is None:
            return rollers_that_fit(centre_distance, body + addendum), addendum

        def room(count: int) -> float:
            return centre_distance * math.sin(math.pi / count) - body

        count = max(3, rollers_that_fit(centre_distance, radius) - self.spare_rollers)
        while count > 3 and room(count) < _LEAST_ADDENDUM * pitch:
            count -= 1
        return count, min(addendum, room(count))

    def friction_coefficient(self, starts: float | int) -> float:
        """Friction coefficient of the threads."""
        return self.friction + self.friction_by_starts * (starts - 1)

    def play(self, pitch: float | int) -> float | None:
        """Largest axial play of a size whose row does not give it [m]."""
        if not self.estimates_play:
            return None
        return next(play for limit, play in _PLAY if pitch < limit)


#: Both ends, both profile ratios, the material factor and the friction are fits of the sizes of 8,
#: 21, 30, 44, 56, 68 and 92 mm (`docs/catalogue_witness.md`). The least shares leave some thread in
#: nuts that are shorter than those of the table.
FITTED = SizeRules(
    roller_ends=14e-3,
    thread_ends=20e-3,
    least_roller=0.65,
    least_thread=0.45,
    gap=0.01,
    spare_rollers=1,
    profile_ratio=3.7,
    coarse_profile_ratio=4.6,
    fatigue_rule="equivalent_balls",
    material_factor=0.81,
    friction=0.0,
    friction_by_starts=0.027,
    estimates_play=True,
)
#: Lengths in proportion to the nut, a profile centred on the axis of the roller, Lundberg
#: and Palmgren's theory; what the benchmark of the catalogue starts from.
PLAIN = SizeRules(
    roller_ends=math.inf,
    thread_ends=math.inf,
    least_roller=0.85,
    least_thread=0.6,
    gap=0.02,
    spare_rollers=None,
    profile_ratio=None,
    coarse_profile_ratio=None,
    fatigue_rule="lundberg_palmgren",
    material_factor=1.1,
    friction=0.06,
    friction_by_starts=0.0,
    estimates_play=False,
)
