"""One stage in mpmath: thread, contacts, steady turning, masses, frequencies."""

from functools import cached_property
from typing import Any

import mpmath

from prsm_jax.mechanism import Stage

from ...references.contact import gaps
from ...references.geometry_chain import cylinder, gear_stiffness
from ...references.hertz import exact_hertz
from .chain import Contact, NoReference, Number, need


class StageNumbers:
    """Numbers of a stage by name, and what follows from them."""

    def __init__(self, stage: Stage, numbers: dict[str, list[Any]]):
        self.stage, self.numbers = stage, numbers

    def of(self, name: str) -> Number:
        """A number of the stage, or `None`."""
        found = self.numbers.get(f"stage.1.{name}", self.numbers.get(name))
        return None if found is None else found[0]

    def __getitem__(self, name: str) -> Number:
        found = self.of(name)
        if found is None:
            raise NoReference(f"no {name}")
        return found

    @cached_property
    def contact(self) -> Contact:
        """Where screw and roller touch."""
        names = ("lead", "starts", "roller_radius", "contact_angle", "roller_profile_radius")
        thread = {n: self.of(f"thread.{n}") for n in names}
        return Contact({n: value for n, value in thread.items() if value is not None})

    @cached_property
    def radii(self) -> dict[str, Number]:
        """Radii of the thread [m]."""
        starts, roller = self["thread.starts"], self["thread.roller_radius"]
        return {
            "screw": (starts - 2) * roller,
            "nut": starts * roller,
            "roller": roller,
            "centre": (starts - 1) * roller,
        }

    @cached_property
    def modulus(self) -> Number:
        """Contact modulus E* [Pa]."""
        young, poisson = self["material.youngs_modulus"], self["material.poisson_ratio"]
        need(young > 0 and -1 < poisson < mpmath.mpf(1) / 2, "no material")
        return young / (2 * (1 - poisson**2))

    @cached_property
    def thread_force(self) -> Number:
        """Axial force on one thread of one roller [N]."""
        load = abs(self["operating_point.load"])
        need(load > 0, "no load")
        return load / (self.stage.roller_count * self["engaged_threads"])

    @cached_property
    def sides(self) -> dict[str, tuple[Any, ...]]:
        """A, B and F_n/F_a of both sides."""
        found = {}
        sides = zip(("screw", "nut"), gaps(self.contact.design, self.contact.point), strict=True)
        for side, (smaller, larger, factor) in sides:
            need(isinstance(smaller, mpmath.mpf) and smaller > 0, "no ellipse")
            found[side] = (smaller, larger, factor)
        return found

    def hertz(self, side: str) -> tuple[Any, ...]:
        """Largest pressure, approach and semi-axes of one thread's contact."""
        smaller, larger, factor = self.sides[side]
        return exact_hertz(self.thread_force * factor, smaller, larger, self.modulus)

    def stiffness(self, side: str) -> Number:
        """Axial secant stiffness of one roller [N/m]."""
        # The normal approach is an axial travel times the cosine of the normal's slope.
        force = self["engaged_threads"] * self.thread_force
        return force / self.sides[side][2] / self.hertz(side)[1]

    # Steady turning ------------------------------------------------------------------------

    def _torque(self, sense: int, load, factor=1) -> Number:
        contact = self.contact
        slip = contact.slip(contact.steady_ratio)
        size = mpmath.sqrt(sum(part**2 for part in slip))
        friction = factor * self["friction.thread.coefficient"]
        along = [sense * friction * part / size for part in slip]
        push = -contact.normal[2] - along[2]
        need(push > 0, "jammed")
        moment = contact.arm[0] * (contact.normal[0] + along[0])
        moment += contact.arm[1] * (contact.normal[1] + along[1])
        bearing = (
            self["friction.thrust_bearing.coefficient"] * self["friction.thrust_bearing.radius"]
        )
        torque = load * moment / push + sense * factor * bearing * load
        return torque + sense * factor * self["friction.drag.torque"]

    def _steady(self) -> dict[str, Any]:
        contact = self.contact
        slip = contact.slip(contact.steady_ratio)
        size = mpmath.sqrt(sum(part**2 for part in slip))
        axial = contact.axial
        lock, jam = contact.limits()
        friction = self["friction.thread.coefficient"]
        found: dict[str, Any] = {
            "carrier_ratio": [contact.steady_ratio],
            "critical_friction_coefficient": [lock],
            "jamming_friction_coefficient": [jam],
            "screw_contact_radius": [contact.point.screw_radius],
        }
        load, speed = self["operating_point.load"], self["operating_point.speed"]
        if speed != 0:
            found["slip_speed"] = [size * abs(speed)]
        found["nut_speed"] = axial * abs(speed)
        if load <= 0 or friction >= jam:
            return found
        if speed > 0:
            found["jamming_margin"] = 1 - friction / jam
        forward, backward = self._torque(1, load), self._torque(-1, load)
        found["efficiency_forward"] = load * axial / forward
        if backward > 0:
            found["efficiency_backward"] = backward / (load * axial)
        if speed > 0:
            found["efficiency"] = found["efficiency_forward"]
            found["drive_torque"] = forward
            found["loss_power"] = (forward - load * axial) * speed
            count = self.stage.roller_count
            push = -contact.normal[2] - friction * slip[2] / size
            found["contact_force"] = [load / count / push]
            sliding = load / push * friction * size * speed
            found["loss_thread_sliding"] = sliding
        elif speed < 0 and backward > 0:
            found["efficiency"] = found["efficiency_backward"]
            found["drive_torque"] = backward
        return found

    # Masses and modes ----------------------------------------------------------------------

    def _cylinder(self, body: str) -> tuple[Number, Number]:
        radii = self.radii
        length = self[f"{body}.length"]
        bore = self.of(f"{body}.bore_radius")
        wall = self.of(f"{body}.wall_thickness")
        width = self.of(f"{body}.radial_width")
        if body in ("screw", "roller"):
            inner, outer = (0 if bore is None else bore), radii[body]
        elif wall is not None:
            inner, outer = radii["nut"], radii["nut"] + wall
        else:
            inner, outer = radii["centre"] - width / 2, radii["centre"] + width / 2
        mass, inertia = cylinder(length, inner, outer, self["material.density"])
        need(mass > 0 and inner >= 0, f"no {body}")
        return mass, inertia

    def _gear(self) -> Number:
        roller_teeth, starts = self["gear.roller_teeth"], self["thread.starts"]
        for name in ("roller_profile_shift", "ring_profile_shift", "helix_angle"):
            need(self[f"gear.{name}"] == 0, "another gear")
        single = gear_stiffness(roller_teeth, starts * roller_teeth, self["gear.face_width"])
        return single * self["gear.mesh_factor"]

    @cached_property
    def bodies(self) -> list[dict[str, Number]]:
        """Masses, meshes and supports of screw, ring gear and nut."""
        radii = self.radii
        share = 1 / (1 + (self["thread.lead"] / (2 * mpmath.pi * radii["nut"])) ** 2)
        found = []
        for body, radius, mesh in (
            ("screw", radii["screw"], self.stiffness("screw") * share),
            ("ring_gear", radii["nut"], self._gear()),
            ("nut", radii["nut"], self.stiffness("nut") * share),
        ):
            mass, inertia = self._cylinder(body)
            radial = self[f"{body}.support.radial_stiffness"]
            second = self.of(f"{body}.support.radial_stiffness_y")
            found.append(
                {
                    "mass": mass,
                    "turn": inertia / radius**2,
                    "mesh": mesh,
                    "radial": radial,
                    "radial_y": radial if second is None else second,
                    "torsional": self[f"{body}.support.torsional_stiffness"],
                }
            )
        return found

    @cached_property
    def carrier(self) -> tuple[Number, Number]:
        """Equivalent mass and support of the carrier."""
        count, carrier = self.stage.roller_count, self.stage.carrier
        assert carrier is not None
        _, inertia = self._cylinder("carrier")
        mass, _ = self._cylinder("roller")
        equivalent = carrier.count * inertia / self.radii["centre"] ** 2 + count * mass
        return equivalent, self["carrier.support.torsional_stiffness"]

    @cached_property
    def roller_turn(self) -> Number:
        """Moment of inertia of a roller over its radius squared [kg]."""
        return self._cylinder("roller")[1] / self.radii["roller"] ** 2

    def _families(self) -> dict[str, Any]:
        count = self.stage.roller_count
        corner = sum(body["mesh"] for body in self.bodies)
        roots = {}
        for family, share, coupling in (
            ("torsional", mpmath.mpf(count), mpmath.sqrt(count)),
            ("transverse", mpmath.mpf(count) / 2, mpmath.sqrt(mpmath.mpf(count) / 2)),
        ):
            matrix = mpmath.zeros(4)
            own = "turn" if family == "torsional" else "mass"
            support = "torsional" if family == "torsional" else "radial"
            for i, body in enumerate(self.bodies):
                matrix[i, i] = (body[support] + share * body["mesh"]) / body[own]
                scaled = coupling * body["mesh"] / mpmath.sqrt(body[own] * self.roller_turn)
                matrix[i, 3] = matrix[3, i] = scaled
            # Its sign changes no root of an arrowhead.
            matrix[3, 3] = corner / self.roller_turn
            values = sorted(mpmath.eigsy(matrix, eigvals_only=True))
            roots[family] = [mpmath.sqrt(max(v, 0)) / (2 * mpmath.pi) for v in values]
        mass, support = self.carrier
        carrier = mpmath.sqrt(support / mass) / (2 * mpmath.pi)
        roller = mpmath.sqrt(corner / self.roller_turn) / (2 * mpmath.pi)
        every = [carrier, *roots["torsional"], *roots["transverse"] * 2]
        every += [roller] * (count - 3)
        found = {
            "torsional_frequencies": roots["torsional"],
            "transverse_frequencies": roots["transverse"],
            "carrier_frequency": [carrier],
            "natural_frequencies": sorted(every),
            "lowest_torsional_frequency": roots["torsional"][0],
            "lowest_transverse_frequency": roots["transverse"][0],
            "gear_mesh_stiffness": [self.bodies[1]["mesh"]],
        }
        if count > 3:
            found["roller_frequency"] = [roller]
        return found

    def columns(self) -> dict[str, Any]:
        """Everything that is known of the catalogue."""
        found: dict[str, Any] = {}
        for part in (self._lengths, self._contacts, self._steady, self._families, self._mass):
            try:
                found |= part()
            except NoReference:
                continue
        return found

    def _lengths(self) -> dict[str, Any]:
        radii, lead = self.radii, self["thread.lead"]
        count = self.stage.roller_count
        addendum = self.of("thread.roller_addendum")
        major = radii["roller"] + (0 if addendum is None else addendum)
        need(radii["screw"] > 0 and lead > 0, "no thread")
        return {
            "centre_distance": [radii["centre"]],
            "screw_radius": [radii["screw"]],
            "nut_radius": [radii["nut"]],
            "screw_helix_angle": [mpmath.atan2(lead, 2 * mpmath.pi * radii["screw"])],
            "roller_helix_angle": [mpmath.atan2(lead, 2 * mpmath.pi * radii["nut"])],
            "roller_clearance": 2 * radii["centre"] * mpmath.sin(mpmath.pi / count) - 2 * major,
            "nut_outer_diameter": 2 * (radii["nut"] + self["nut.wall_thickness"]),
        }

    def _mass(self) -> dict[str, Any]:
        count, carrier = self.stage.roller_count, self.stage.carrier
        assert carrier is not None
        total = sum(self._cylinder(body)[0] for body in ("screw", "nut", "ring_gear"))
        total += count * self._cylinder("roller")[0]
        return {"mass": total + carrier.count * self._cylinder("carrier")[0]}

    def _contacts(self) -> dict[str, Any]:
        found: dict[str, Any] = {}
        uncut = self.of("thread.screw_addendum") is None
        for side in ("screw", "nut"):
            pressure, approach, major, minor = self.hertz(side)
            found[f"approach_{side}"] = [approach]
            found[f"thread_stiffness_{side}"] = [self.stiffness(side)]
            if side == "screw":
                found["semi_major_screw"], found["semi_minor_screw"] = [major], [minor]
            if uncut:
                found[f"max_pressure_{side}"] = [pressure]
        return found


def modes_of(own: StageNumbers) -> list[Number]:
    """All frequencies of a stage with unequal rollers or supports, from the full matrices."""
    count = own.stage.roller_count
    size = 10 + count
    stiff, mass = mpmath.zeros(size), [mpmath.mpf(0)] * size
    factors, weights = [mpmath.mpf(1)] * count, [mpmath.mpf(1)] * count
    for place, unequal in enumerate(own.stage.unequal_roller):
        name = f"unequal_roller.{place + 1}"
        for values, field in ((factors, "stiffness_factor"), (weights, "mass_factor")):
            given = own.of(f"{name}.{field}")
            if given is not None:
                values[unequal.number - 1] = given
    for body, (numbers, sign) in enumerate(zip(own.bodies, (1, -1, -1), strict=True)):
        x, y, turn = 3 * body, 3 * body + 1, 3 * body + 2
        mass[x] = mass[y] = numbers["mass"]
        mass[turn] = numbers["turn"]
        stiff[x, x] += numbers["radial"]
        stiff[y, y] += numbers["radial_y"]
        stiff[turn, turn] += numbers["torsional"]
        for roller in range(count):
            angle = -sign * 2 * mpmath.pi * roller / count
            row = ((x, -mpmath.sin(angle)), (y, mpmath.cos(angle)), (turn, 1), (9 + roller, sign))
            for i, a in row:
                for j, b in row:
                    stiff[i, j] += numbers["mesh"] * factors[roller] * a * b
    for roller in range(count):
        mass[9 + roller] = own.roller_turn * weights[roller]
    equivalent, support = own.carrier
    # The carrier moves the rollers that there are.
    each = own._cylinder("roller")[0]
    mass[-1] = equivalent + each * (sum(weights) - count)
    stiff[size - 1, size - 1] = support
    for m in mass:
        need(m > 0, "no mass")
    for i in range(size):
        for j in range(size):
            stiff[i, j] /= mpmath.sqrt(mass[i] * mass[j])
    values = sorted(mpmath.eigsy(stiff, eigvals_only=True))
    return [mpmath.sqrt(max(v, 0)) / (2 * mpmath.pi) for v in values]
