"""An assembly from vectors: springs between points of bodies, in one frame for all of them."""

import numpy as np
from present import present
from spatial_scenes import THREADS, number

import prsm_jax as prsm

AXIS = np.array([0.0, 0.0, 1.0])


def turned(vector, angle):
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]) @ vector


def flank_normal(slope, reduced_lead, point, upwards):
    """Unit normal of the helicoid z = slope·ρ + h θ at a point of the transverse plane."""
    radius = np.hypot(*point)
    outward = np.array([*point, 0.0]) / radius
    gradient = slope * outward + reduced_lead / radius * np.cross(AXIS, outward)
    normal = gradient - AXIS
    return (-1 if upwards else 1) * normal / np.linalg.norm(normal)


class Assembly:
    """Springs between points of bodies that move by (x, y, z) and turn by θ, one frame for all."""

    def __init__(self, stage):
        self.masses: list[float] = []
        self.places: dict[object, slice] = {}
        self.axes: dict[object, np.ndarray] = {}
        self.rows: list[np.ndarray] = []
        self.stiffness: list[float] = []
        thread = stage.thread
        count, self.starts = stage.roller_count, number(thread.starts)
        distance = number(thread.centre_distance)
        ring, cage = present(stage.ring_gear), present(stage.carrier)
        screw, nut, roller = stage.screw, stage.nut, stage.roller
        self.add_body("screw", np.zeros(3), [number(screw.mass)] * 3 + [number(screw.inertia)])
        mass = number(nut.mass) + number(ring.mass)
        inertia = number(nut.inertia) + number(ring.inertia)
        cage_mass = cage.count * number(cage.mass)
        self.add_body("nut", np.zeros(3), [mass, mass, mass + cage_mass, inertia])
        # The carrier has no z of its own; its third coordinate stays unconnected.
        cage_inertia = cage.count * number(cage.inertia)
        self.add_body("carrier", np.zeros(3), [cage_mass, cage_mass, 1.0, cage_inertia])
        for at in range(count):
            place = turned(np.array([distance, 0.0, 0.0]), 2 * np.pi * at / count)
            self.add_body(at, place, [number(roller.mass)] * 3 + [number(roller.inertia)])

    def add_body(self, name, axis, masses):
        self.places[name] = slice(len(self.masses), len(self.masses) + 4)
        self.axes[name] = axis
        self.masses += masses

    def moved(self, name, point, direction):
        """Displacement of a body's point along a direction, per unit of its coordinates."""
        turn = np.cross(AXIS, point - self.axes[name]) @ direction
        return np.array([*direction, turn])

    def row(self, *parts):
        row = np.zeros(self.size)
        for name, values in parts:
            row[self.places[name]] += values
        return row

    @property
    def size(self):
        return len(self.masses)

    def between(self, first, second, point, direction, stiffness):
        row = self.row(
            (first, self.moved(first, point, direction)),
            (second, -self.moved(second, point, direction)),
        )
        self.rows.append(row)
        self.stiffness.append(stiffness)

    def ground(self, name, place, stiffness, per=1.0):
        """A support; a torsional one acts on u = r θ."""
        values = np.zeros(4)
        values[place] = per
        self.rows.append(self.row((name, values)))
        self.stiffness.append(stiffness)


def assembled(stage):
    """The whole stage from vectors; only radii and angles of the contacts are taken over."""
    thread, contact = stage.thread, prsm.mesh(stage.thread).screw
    assembly = Assembly(stage)
    reduced = number(thread.lead) / (2 * np.pi)
    slope = np.tan(number(thread.flank_angle))
    radius, angle = number(contact.contact_radius), number(contact.contact_angle_position)
    touching = np.array([radius * np.cos(angle), radius * np.sin(angle), 0.0])
    at_nut = np.array([number(thread.nut_radius), 0.0, 0.0])
    screw_normal = flank_normal(slope, reduced, touching[:2], upwards=False)
    nut_normal = flank_normal(slope, reduced, at_nut[:2], upwards=True)
    screw_stiffness = number(THREADS.screw_roller) / screw_normal[2] ** 2
    nut_stiffness = number(THREADS.nut_roller) / nut_normal[2] ** 2
    poisson = number(stage.material.poisson_ratio)
    tangential = 2 * (1 - poisson) / (2 - poisson) * nut_stiffness
    # Any two directions across the normal will do.
    across = np.linalg.svd(nut_normal[None, :])[2][1:]
    pressure = number(present(stage.gear).pressure_angle)
    action = np.array([-np.sin(pressure), np.cos(pressure), 0.0])
    pins = present(stage.roller.support)
    for at in range(stage.roller_count):
        turn = 2 * np.pi * at / stage.roller_count
        inner, outer = turned(touching, turn), turned(at_nut, turn)
        normal = turned(screw_normal, turn)
        assembly.between("screw", at, inner, normal, screw_stiffness)
        assembly.between("nut", at, outer, turned(nut_normal, turn), nut_stiffness)
        for direction in across:
            assembly.between("nut", at, outer, turned(direction, turn), tangential)
        teeth = number(present(stage.stiffness).ring_roller)
        assembly.between("nut", at, outer, turned(action, turn), teeth)
        centre = assembly.axes[at]
        for direction in np.eye(3)[:2]:
            assembly.between("carrier", at, centre, direction, number(pins.radial_stiffness))
        assembly.between("nut", at, centre, AXIS, number(pins.axial_stiffness))
    for name, own, per in (
        ("screw", "screw", thread.screw_radius),
        ("nut", "nut", thread.nut_radius),
        ("nut", "ring_gear", thread.nut_radius),
        ("carrier", "carrier", thread.centre_distance),
    ):
        support = getattr(stage, own).support
        for place, kind in ((0, "radial"), (1, "radial"), (2, "axial"), (3, "torsional")):
            stiffness = getattr(support, f"{kind}_stiffness")
            if stiffness is not None:
                goes_to = "nut" if kind == "axial" and name == "carrier" else name
                factor = number(per) if kind == "torsional" else 1.0
                assembly.ground(goes_to, place, number(stiffness), factor)
    return assembly


def from_assembly(assembly, stage, coordinates):
    """Coordinates of the assembly per coordinate of the package."""
    thread = stage.thread
    radii = {"nut": thread.nut_radius, "carrier": thread.centre_distance}
    radii |= dict.fromkeys(("screw", "screw_end", "motor"), thread.screw_radius)
    change = np.zeros((assembly.size, len(coordinates)))
    for column, coordinate in enumerate(coordinates):
        body, direction = coordinate.body, coordinate.direction
        at = int(body.split()[1]) - 1 if body.startswith("roller") else None
        first = assembly.places[body if at is None else at].start
        if direction in "xyz":
            change[first + "xyz".index(direction), column] = 1.0
        elif direction == "u":
            radius = radii.get(body, thread.roller_radius)
            change[first + 3, column] = 1 / number(radius)
        else:
            unit = np.eye(3)[("radial", "tangential").index(direction)]
            assert at is not None
            place = turned(unit, 2 * np.pi * at / stage.roller_count)
            change[first : first + 3, column] = place
    return change
