"""An assembly of bodies with six degrees of freedom: every thread, tooth and pin by itself."""

import dataclasses

import numpy as np
from present import present
from spatial_assembly import SLIDES, beside, contact_of, turned
from spatial_scenes import THREADS, held_stage, number

from prsm_jax.mechanism import Support, body_inertia, body_mass

AXIS = np.array([0.0, 0.0, 1.0])


def tilting_stage(roller_count=5):
    """The held stage with everything that a tilt needs, and tilting stiffness of its supports."""
    return with_tilt_data(held_stage(roller_count))


def with_tilt_data(stage):
    """Lengths, engaged threads, two carriers, and tilting stiffness of the supports."""

    def held(body, stiffness, **more):
        support = dataclasses.replace(present(body.support), tilting_stiffness=stiffness)
        return dataclasses.replace(body, support=support, **more)

    gear = stage.gear
    return dataclasses.replace(
        stage,
        engaged_threads=9,
        load_sharing=None,
        screw=held(stage.screw, 3e4, length=0.31),
        nut=held(stage.nut, 5e4, length=0.062),
        roller=dataclasses.replace(stage.roller, length=0.057),
        carrier=held(present(stage.carrier), 70.0, count=2),
        gear=None if gear is None else dataclasses.replace(gear, face_width=6e-3),
    )


@dataclasses.dataclass
class Body:
    centre: np.ndarray
    #: Mass, moment of inertia about a diameter and about the axis.
    mass: float
    across: float
    along: float
    place: int

    def moved(self, point, direction, size):
        """Displacement of a point along a direction per unit of (v, ω): d·(v + ω × r)."""
        row = np.zeros(size)
        row[self.place : self.place + 3] = direction
        row[self.place + 3 : self.place + 6] = np.cross(point - self.centre, direction)
        return row


class RigidBodies:
    """Bodies in one frame; springs between their points."""

    def __init__(self, stage):
        self.stage, self.bodies = stage, {}
        self.springs = []
        thread = stage.thread
        length = number(stage.roller.length)
        self.pin = length / 2
        self.tooth = 0.0 if stage.gear is None else (length - number(stage.gear.face_width)) / 2
        for side in ("screw", "nut"):
            self._cylinder(side, side, np.zeros(3))
        self._cylinder_rollers(number(thread.centre_distance))
        halves = {}
        if stage.ring_gear is not None:
            halves["ring_gear"] = (self.tooth, 0.5)
        if stage.carrier is not None:
            halves["carrier"] = (self.pin, 1.0)
        for name, (distance, share) in halves.items():
            for number_of, sign in enumerate((1, -1), start=1):
                inertia = share * number(body_inertia(stage, name))
                centre = sign * distance * AXIS
                mass = share * number(body_mass(stage, name))
                self._add(f"{name} {number_of}", centre, mass, inertia / 2, inertia)

    def _cylinder_rollers(self, distance):
        for at in range(self.stage.roller_count):
            angle = 2 * np.pi * at / self.stage.roller_count
            self._cylinder(at, "roller", turned(np.array([distance, 0.0, 0.0]), angle))

    def _cylinder(self, key, name, centre):
        mass, inertia = (number(law(self.stage, name)) for law in (body_mass, body_inertia))
        length = number(getattr(self.stage, name).length)
        self._add(key, centre, mass, inertia / 2 + mass * length**2 / 12, inertia)

    def _add(self, key, centre, mass, across, along):
        self.bodies[key] = Body(centre, mass, across, along, 6 * len(self.bodies))

    @property
    def size(self):
        return 6 * len(self.bodies)

    def between(self, first, second, point, direction, stiffness):
        row = self.bodies[first].moved(point, direction, self.size)
        if second is not None:
            row = row - self.bodies[second].moved(point, direction, self.size)
        self.springs.append((stiffness, row))

    def ground(self, key, place, stiffness):
        row = np.zeros(self.size)
        row[self.bodies[key].place + place] = 1.0
        self.springs.append((stiffness, row))

    def matrices(self):
        stiffness = np.array([k for k, _ in self.springs])
        rows = np.stack([row for _, row in self.springs])
        masses = np.concatenate(
            [[b.mass] * 3 + [b.across] * 2 + [b.along] for b in self.bodies.values()]
        )
        return rows.T @ (stiffness[:, None] * rows), masses


def rigid_bodies(stage, standstill=False):
    """The whole stage: each thread, each row of teeth and each pin is a spring."""
    found = RigidBodies(stage)
    thread, threads = stage.thread, int(stage.engaged_threads)
    poisson = number(stage.material.poisson_ratio)
    places = (np.arange(threads) - (threads - 1) / 2) * number(thread.pitch)
    springs = []
    for side in ("screw", "nut"):
        point, normal = contact_of(stage, side)
        stiffness = number(getattr(THREADS, f"{side}_roller")) / normal[2] ** 2 / threads
        ways = [(normal, stiffness)]
        if standstill or side not in SLIDES[stage.type]:
            tangential = 2 * (1 - poisson) / (2 - poisson) * stiffness
            ways += [(way, tangential) for way in np.linalg.svd(normal[None, :])[2][1:]]
        springs += [(side, point, place, *way) for way in ways for place in places]
    given = stage.stiffness
    if given is not None and given.ring_roller is not None:
        pressure = number(present(stage.gear).pressure_angle)
        side = "screw" if stage.type == "inverted" else "nut"
        away = 1 if side == "screw" else -1
        action = np.array([away * np.sin(pressure), np.cos(pressure), 0.0])
        pitch_point = np.array([number(getattr(thread, f"{side}_radius")), 0.0, 0.0])
        for end in (1, -1):
            teeth = number(given.ring_roller) / 2
            springs.append((side, pitch_point, end * found.tooth, action, teeth))
    pins: Support | None = stage.roller.support
    for at in range(stage.roller_count):
        turn = 2 * np.pi * at / stage.roller_count
        for side, point, place, way, stiffness in springs:
            where = turned(point, turn) + place * AXIS
            found.between(side, at, where, turned(way, turn), stiffness)
        if pins is None:
            continue
        centre = found.bodies[at].centre
        for which, end in ((1, 1), (2, -1)):
            where = centre + end * found.pin * AXIS
            for way in np.eye(3)[:2]:
                found.between(f"carrier {which}", at, where, way, number(pins.radial_stiffness) / 2)
            # The retaining rings of the carriers stand in the planes of the nut or the screw.
            axial = number(pins.axial_stiffness) / 2
            found.between(beside(stage), at, where, AXIS, axial)
    _supports(found, stage)
    return found


def _supports(found, stage):
    """Tilting stiffness of parts that tilt with screw or nut acts on these."""
    thread = stage.thread
    for name, keys, radius, tilts in (
        ("screw", ["screw"], thread.screw_radius, "screw"),
        ("nut", ["nut"], thread.nut_radius, "nut"),
        ("ring_gear", ["nut"], thread.nut_radius, "nut"),
        ("carrier", ["carrier 1", "carrier 2"], thread.centre_distance, beside(stage)),
    ):
        support = getattr(getattr(stage, name), "support", None)

        def of(kind, support=support):
            value = getattr(support, f"{kind}_stiffness", None)
            return 0.0 if value is None else number(value)

        for key in keys:
            for place in (0, 1):
                found.ground(key, place, of("radial") / len(keys))
            found.ground(key, 5, of("torsional") * number(radius) ** 2 / len(keys))
        found.ground(tilts, 2, of("axial"))
        for place in (3, 4):
            found.ground(tilts, place, of("tilting"))


def of_coordinates(found, stage, coordinates):
    """Velocities of all bodies per coordinate of the package."""
    thread = stage.thread
    radii = {"screw": thread.screw_radius, "nut": thread.nut_radius}
    change = np.zeros((found.size, len(coordinates)))

    def move(keys, column, velocity, rotation):
        for key, sign in keys:
            place = found.bodies[key].place
            change[place : place + 3, column] += sign * velocity
            change[place + 3 : place + 6, column] += sign * rotation

    def fixed(body):
        """Parts that move as one with a body, with what of its motion they follow."""
        rings = [key for key in found.bodies if str(key).startswith("ring_gear") and body == "nut"]
        cages = [key for key in found.bodies if str(key).startswith("carrier")]
        return rings, cages if body == beside(stage) else []

    for column, coordinate in enumerate(coordinates):
        body, direction = coordinate.body, coordinate.direction
        unit = np.zeros(3)
        if body.startswith("roller"):
            at = int(body.split()[1]) - 1
            if direction in ("z", "u"):
                unit[2] = 1.0
            else:
                unit[["radial", "tangential"].index(direction.removeprefix("tilt_"))] = 1.0
            unit = turned(unit, 2 * np.pi * at / stage.roller_count)
            turns = direction == "u" or direction.startswith("tilt")
            rotation = unit / number(thread.roller_radius) * turns
            move([(at, 1)], column, unit * (not turns), rotation)
        elif body in ("carrier", "opposite_carriers"):
            unit["xyu".index(direction)] = 1.0
            other = -1 if body == "opposite_carriers" else 1
            pair = [("carrier 1", 1), ("carrier 2", other)]
            turns = direction == "u"
            rotation = unit / number(thread.centre_distance) * turns
            move(pair, column, unit * (not turns), rotation)
        else:
            unit["xyz".index(direction.removeprefix("tilt_").replace("u", "z"))] = 1.0
            turns = direction == "u" or direction.startswith("tilt")
            rotation = unit / number(radii[body]) * turns
            rings, cages = fixed(body)
            for key in (body, *rings):
                centre = found.bodies[key].centre
                velocity = np.cross(rotation, centre) if turns else unit
                move([(key, 1)], column, velocity, rotation)
            # Carriers stand beside it: they follow its plane, and slide in it.
            if direction == "z":
                move([(key, 1) for key in cages], column, unit, 0 * unit)
            if direction.startswith("tilt"):
                move([(key, 1) for key in cages], column, 0 * unit, rotation)
    return change
