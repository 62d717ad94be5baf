"""Everything a drawing of one stage needs, in millimetres and plain numbers."""

import math
from dataclasses import dataclass

from ...geometry import ThreadContact, mesh
from ...mechanism import FAMILIES, Family, Mechanism, Side, Stage, stage_at, thread_heights

#: A wall that is not given is drawn this thick, in roller radii, and broken off.
_BROKEN_WALL = 1.0


@dataclass(frozen=True)
class ContactPoint:
    """Contact point of a roller in the transverse plane, the roller's axis at (a, 0) [mm]."""

    x: float
    y: float


@dataclass(frozen=True)
class DrawingDimensions:
    """Dimensions of one stage [mm, rad]; `None` if the mechanism does not give them."""

    roller_count: int
    #: Angle around the screw of every roller present, and of every empty place [rad].
    roller_angles: tuple[float, ...]
    empty_angles: tuple[float, ...]
    starts: float
    lead: float
    pitch: float
    flank_angle: float
    profile_radius: float
    screw_radius: float
    roller_radius: float
    nut_radius: float
    centre_distance: float
    #: Height of the threads over their nominal radius (the nut's is that of the screw), and depth
    #: under it.
    screw_addendum: float
    roller_addendum: float
    screw_dedendum: float
    roller_dedendum: float
    nut_dedendum: float
    #: Half a pitch minus the thickness of a tooth at its nominal radius.
    screw_thinning: float
    roller_thinning: float
    nut_thinning: float
    bore_radius: float | None
    roller_bore_radius: float | None
    nut_outer_radius: float | None
    screw_length: float | None
    roller_length: float | None
    nut_length: float | None
    gear_width: float | None
    ring_length: float | None
    ring_outer_radius: float | None
    carrier_inner_radius: float | None
    carrier_outer_radius: float | None
    carrier_length: float | None
    carrier_count: int
    #: `None` where screw and roller have no common normal.
    screw_contact: ContactPoint | None
    nut_contact: ContactPoint | None
    #: What distinguishes the type of roller screw.
    family: Family = FAMILIES["standard"]
    #: Body whose teeth mesh with the rollers; `None` for a file without a gear.
    gear_body: Side | None = None

    @property
    def shifted_at_nut(self) -> bool:
        """Whether roller teeth towards the nut are half a pitch from those towards the screw.

        Those of one start are; grooves are not.
        """
        return self.family.roller_hand != 0

    @property
    def drawn_outer_radius(self) -> float:
        """Outer radius of the nut, or of its drawn piece [mm]."""
        if self.nut_outer_radius is not None:
            return self.nut_outer_radius
        return self.nut_radius + _BROKEN_WALL * self.roller_radius

    @property
    def drawn_roller_length(self) -> float:
        """Length of the roller, or of its drawn piece [mm]."""
        if self.roller_length is not None:
            return self.roller_length
        return 16 * self.pitch + 2 * (self.gear_width or 0.0)

    @property
    def drawn_nut_length(self) -> float:
        """Length of the nut, or of its drawn piece [mm]."""
        if self.nut_length is not None:
            return self.nut_length
        return 1.3 * self.drawn_roller_length

    @property
    def not_given(self) -> tuple[str, ...]:
        """Dimensions that the drawing leaves open, in words."""
        lengths = {
            "screw": self.screw_length,
            "roller": self.roller_length,
            "nut": self.nut_length,
        }
        names = ["nut wall"] if self.nut_outer_radius is None else []
        return (*names, *(f"{body} length" for body, value in lengths.items() if value is None))


def _millimetres(value) -> float | None:
    return None if value is None else 1e3 * float(value)


def _thinnings(stage: Stage) -> tuple[float, float, float]:
    """Thinning of the teeth of screw, roller and nut [mm]; 0 where it is not given."""
    play = None if stage.strength is None else stage.strength.play
    if play is None:
        return 0.0, 0.0, 0.0
    values = (play.screw_tooth_thinning, play.roller_tooth_thinning, play.nut_tooth_thinning)
    screw, roller, nut = (_millimetres(value) or 0.0 for value in values)
    return screw, roller, nut


def roller_places(stage: Stage) -> list[tuple[float, bool]]:
    """Angle of every place of a roller, and whether it has one."""
    unequal = {roller.number: roller for roller in stage.unequal_roller}
    places = []
    for number in range(1, stage.roller_count + 1):
        angle, roller = 2 * math.pi * (number - 1) / stage.roller_count, unequal.get(number)
        if roller is not None and roller.position_offset is not None:
            angle += float(roller.position_offset)
        places.append((angle, roller is None or not roller.missing))
    return places


def drawing_dimensions(mechanism: Mechanism, stage: int = 1) -> DrawingDimensions:
    """Collect the dimensions for the drawing of a stage.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `stage`: which stage, counted from 1.

    **Raises:** `ValueError` for a stage that does not exist.
    """
    chosen = stage_at(mechanism, stage)
    thread, carrier, ring = chosen.thread, chosen.carrier, chosen.ring_gear
    meshing = mesh(thread)
    touching = bool(meshing.converged)

    def point(contact: ThreadContact) -> ContactPoint | None:
        radius, angle = 1e3 * float(contact.contact_radius), float(contact.contact_angle_position)
        return (
            ContactPoint(radius * math.cos(angle), radius * math.sin(angle)) if touching else None
        )

    nut_radius, centre = 1e3 * float(thread.nut_radius), 1e3 * float(thread.centre_distance)
    heights = {name: 1e3 * float(value) for name, value in thread_heights(chosen)._asdict().items()}
    screw_thinning, roller_thinning, nut_thinning = _thinnings(chosen)
    wall = _millimetres(chosen.nut.wall_thickness)
    rim = None if ring is None else _millimetres(ring.wall_thickness)
    width = None if carrier is None else _millimetres(carrier.radial_width)
    places = roller_places(chosen)
    return DrawingDimensions(
        roller_count=chosen.present_roller_count,
        roller_angles=tuple(angle for angle, present in places if present),
        empty_angles=tuple(angle for angle, present in places if not present),
        starts=float(thread.starts),
        lead=1e3 * float(thread.lead),
        pitch=1e3 * float(thread.pitch),
        flank_angle=float(thread.flank_angle),
        profile_radius=1e3 * float(thread.profile_radius),
        screw_radius=1e3 * float(thread.screw_radius),
        roller_radius=1e3 * float(thread.roller_radius),
        nut_radius=nut_radius,
        centre_distance=centre,
        **heights,
        screw_thinning=screw_thinning,
        roller_thinning=roller_thinning,
        nut_thinning=nut_thinning,
        bore_radius=_millimetres(chosen.screw.bore_radius),
        roller_bore_radius=_millimetres(chosen.roller.bore_radius),
        nut_outer_radius=None if wall is None else nut_radius + wall,
        screw_length=_millimetres(chosen.screw.length),
        roller_length=_millimetres(chosen.roller.length),
        nut_length=_millimetres(chosen.nut.length),
        gear_width=None if chosen.gear is None else _millimetres(chosen.gear.face_width),
        ring_length=None if ring is None else _millimetres(ring.length),
        ring_outer_radius=None if rim is None else nut_radius + rim,
        carrier_inner_radius=None if width is None else centre - width / 2,
        carrier_outer_radius=None if width is None else centre + width / 2,
        carrier_length=None if carrier is None else _millimetres(carrier.length),
        carrier_count=0 if carrier is None else carrier.count,
        screw_contact=point(meshing.screw),
        nut_contact=point(meshing.nut),
        family=thread.family,
        gear_body=None if chosen.gear is None and ring is None else thread.family.gear_body,
    )
