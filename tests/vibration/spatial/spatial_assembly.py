"""An assembly from vectors: springs between points of bodies, in one frame for all of them."""

import numpy as np
from present import present
from spatial_scenes import THREADS, number

import prsm_jax as prsm
from prsm_jax.mechanism import body_inertia, body_mass

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
        count = stage.roller_count
        distance = number(thread.centre_distance)
        ring = [] if stage.ring_gear is None else ["ring_gear"]
        cage = stage.carrier
        cage_mass = 0.0 if cage is None else cage.count * number(body_mass(stage, "carrier"))
        for side in ("screw", "nut"):
            fixed = [side, *(ring if side == "nut" else [])]
            mass = sum(number(body_mass(stage, name)) for name in fixed)
            inertia = sum(number(body_inertia(stage, name)) for name in fixed)
            along = mass + cage_mass if side == beside(stage) else mass
            self.add_body(side, np.zeros(3), [mass, mass, along, inertia])
        if cage is not None and stage.roller.support is not None:
            # The carrier has no z of its own; its third coordinate stays unconnected.
            cage_inertia = cage.count * number(body_inertia(stage, "carrier"))
            self.add_body("carrier", np.zeros(3), [cage_mass, cage_mass, 1.0, cage_inertia])
        mass, inertia = (number(law(stage, "roller")) for law in (body_mass, body_inertia))
        for at in range(count):
            place = turned(np.array([distance, 0.0, 0.0]), 2 * np.pi * at / count)
            self.add_body(at, place, [mass, mass, mass, inertia])

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


def beside(stage):
    """The body with which the carriers move along the axis."""
    return "screw" if stage.type == "inverted" else "nut"


#: By type: the bodies on which rollers slide, and the bodies with a thread.
SLIDES = {
    "standard": ("screw",), "inverted": ("nut",), "recirculating": ("screw", "nut"),
    "differential": ("screw",),
}  # fmt: skip
THREADED = dict.fromkeys(SLIDES, ("screw", "nut")) | {"differential": ("screw",)}


def contact_of(stage, side):
    """Touching point and unit normal; only radii and angles of the contact are taken over."""
    thread, meshing = stage.thread, prsm.mesh(stage.thread)
    contact = getattr(meshing, side)
    reduced = number(thread.lead) / (2 * np.pi) if side in THREADED[stage.type] else 0.0
    if side in SLIDES[stage.type]:
        radius, angle = number(contact.contact_radius), number(contact.contact_angle_position)
    else:
        radius, angle = number(getattr(thread, f"{side}_radius")), 0.0
    point = np.array([radius * np.cos(angle), radius * np.sin(angle), 0.0])
    slope = np.tan(number(thread.flank_angle))
    return point, flank_normal(slope, reduced, point[:2], upwards=side == "nut")


def assembled(stage, standstill=False):
    """The whole stage from vectors; only radii and angles of the contacts are taken over."""
    thread = stage.thread
    assembly = Assembly(stage)
    poisson = number(stage.material.poisson_ratio)
    springs = []
    for side in ("screw", "nut"):
        point, normal = contact_of(stage, side)
        stiffness = number(getattr(THREADS, f"{side}_roller")) / normal[2] ** 2
        springs.append((side, point, normal, stiffness))
        if standstill or side not in SLIDES[stage.type]:
            tangential = 2 * (1 - poisson) / (2 - poisson) * stiffness
            # Any two directions across the normal will do.
            across = np.linalg.svd(normal[None, :])[2][1:]
            springs += [(side, point, way, tangential) for way in across]
    if stage.gear is not None:
        pressure = number(stage.gear.pressure_angle)
        side = "screw" if stage.type == "inverted" else "nut"
        # Teeth push a roller away from the body that has them.
        away = 1 if side == "screw" else -1
        action = np.array([away * np.sin(pressure), np.cos(pressure), 0.0])
        pitch_point = np.array([number(getattr(thread, f"{side}_radius")), 0.0, 0.0])
        teeth = number(present(stage.stiffness).ring_roller)
        springs.append((side, pitch_point, action, teeth))
    pins = stage.roller.support
    for at in range(stage.roller_count):
        turn = 2 * np.pi * at / stage.roller_count
        for side, point, way, stiffness in springs:
            assembly.between(side, at, turned(point, turn), turned(way, turn), stiffness)
        centre = assembly.axes[at]
        if pins is not None:
            for direction in np.eye(3)[:2]:
                radial = number(pins.radial_stiffness)
                assembly.between("carrier", at, centre, direction, radial)
            assembly.between(beside(stage), at, centre, AXIS, number(pins.axial_stiffness))
    for name, own, per in (
        ("screw", "screw", thread.screw_radius),
        ("nut", "nut", thread.nut_radius),
        ("nut", "ring_gear", thread.nut_radius),
        ("carrier", "carrier", thread.centre_distance),
    ):
        support = getattr(getattr(stage, own), "support", None)
        for place, kind in ((0, "radial"), (1, "radial"), (2, "axial"), (3, "torsional")):
            stiffness = getattr(support, f"{kind}_stiffness", None)
            if stiffness is not None:
                goes_to = beside(stage) if kind == "axial" and name == "carrier" else name
                factor = number(per) if kind == "torsional" else 1.0
                assembly.ground(goes_to, place, number(stiffness), factor)
    return assembly


def assert_assembled(network, assembly, stage):
    """The matrices of a network against those of an assembly from vectors.

    Returns the stiffness of both, and the mass matrix of the assembly.
    """
    change = from_assembly(assembly, stage, network.coordinates)
    rows = np.stack([np.pad(row, (0, assembly.size - len(row))) for row in assembly.rows])
    expected = change.T @ (rows.T @ (np.array(assembly.stiffness)[:, None] * rows)) @ change
    found = np.asarray(network.stiffness_matrix())
    # Sums of a few tens of doubles; the contact comes from a root found to about 1e-15.
    assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()
    masses = change.T @ (np.array(assembly.masses, float)[:, None] * change)
    np.testing.assert_allclose(np.diag(np.asarray(network.mass)), masses, rtol=1e-14, atol=1e-17)
    return found, expected, masses


def turning_radius(stage):
    """r of u = r θ of the motor's rotor."""
    thread = stage.thread
    return thread.nut_radius if stage.type == "inverted" else thread.screw_radius


def from_assembly(assembly, stage, coordinates):
    """Coordinates of the assembly per coordinate of the package."""
    thread = stage.thread
    radii = {"nut": thread.nut_radius, "carrier": thread.centre_distance}
    radii |= dict.fromkeys(("screw", "screw_end"), thread.screw_radius)
    radii["motor"] = turning_radius(stage)
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
