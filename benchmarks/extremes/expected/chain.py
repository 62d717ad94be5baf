# Examples have the parts that are changed here, and plain numbers become arrays when built:
# pyright: reportArgumentType=false, reportOptionalOperand=false, reportOperatorIssue=false
"""Steady turning and carrier rates of a chain of stages, for mpmath's numbers and for floats.

Coulomb friction in threads, splines and thrust bearings, constant drag; a load on the last nut
against its motion at positive speed (Li et al. 2020 and 2021, as `references.transients.dynamics`).
"""

from typing import Any

import mpmath

from prsm_jax.friction import CoulombFriction, SplineFriction, ThrustBearingFriction
from prsm_jax.mechanism import Mechanism

from ...references.meshing import Design, frame_of, mesh_point

#: mpf or float.
Number = Any


class NoReference(Exception):
    """The numbers are outside of what the reference covers."""


def need(condition: bool, why: str) -> None:
    """**Raises:** `NoReference` unless the condition holds."""
    if not condition:
        raise NoReference(why)


class Contact:
    """Where screw and roller of one stage touch, and how the contact moves."""

    def __init__(self, thread: dict[str, Number]):
        lead, starts, roller = thread["lead"], thread["starts"], thread["roller_radius"]
        angle = thread["contact_angle"]
        need(lead > 0 and starts > 2 and roller > 0, "no thread")
        need(0 < angle < mpmath.pi / 2, "no contact angle")
        profile = thread.get("roller_profile_radius")
        profile = roller / mpmath.cos(angle) if profile is None else profile
        need(profile > 0, "no profile")
        self.design = Design(lead, starts, roller, angle, profile)
        self.point = mesh_point(self.design)
        need(isinstance(self.point.x, mpmath.mpf), "a complex root")
        near = mpmath.hypot(self.point.x - (starts - 1) * roller, self.point.y)
        need(abs(near - roller) < roller / 2, "a root that is no contact")
        self.axial = lead / (2 * mpmath.pi)
        self.arm, self.drive, self.normal, self.steady_ratio = frame_of(self.design, self.point)

    def slip(self, ratio: Number):
        """Slip of the screw over the roller per screw speed [m]."""
        return (
            self.arm[0] - ratio * self.drive[0],
            self.arm[1] - ratio * self.drive[1],
            self.axial,
        )

    def limits(self) -> tuple[Number, Number]:
        """Friction coefficients at which the thread locks and at which it jams."""
        slip = self.slip(self.steady_ratio)
        size = mpmath.sqrt(sum(part**2 for part in slip))
        back, held = (self.arm[0] * v[0] + self.arm[1] * v[1] for v in (self.normal, slip))
        return back * size / held, -self.normal[2] * size / slip[2]


def in_plain(value):
    """A tuple of floats, or a float."""
    return tuple(float(x) for x in value) if isinstance(value, tuple) else float(value)


class _Link:
    """One stage of the chain: its contact, friction and inertia."""

    def __init__(self, stage, numbers, prefix: str):
        def of(name):
            return numbers[prefix + name][0] if prefix + name in numbers else None

        names = ("lead", "starts", "roller_radius", "contact_angle", "roller_profile_radius")
        thread = {n: of(f"thread.{n}") for n in names if of(f"thread.{n}") is not None}
        contact = Contact(thread)
        self.count = stage.roller_count
        self.arm, self.drive, self.normal = contact.arm, contact.drive, contact.normal
        self.axial, self.steady_ratio = contact.axial, contact.steady_ratio
        self.contact = contact
        friction = stage.friction
        need(isinstance(friction.thread, CoulombFriction), "another law of friction")
        need(friction.spin is None and friction.rolling_hysteresis is None, "spin")
        self.friction = of("friction.thread.coefficient")
        self.spline = self.bearing = self.drag = 0 * self.axial
        if friction.spline is not None:
            need(isinstance(friction.spline, SplineFriction), "another law of friction")
            self.spline = of("friction.spline.coefficient") / of("friction.spline.radius")
        if friction.thrust_bearing is not None:
            need(isinstance(friction.thrust_bearing, ThrustBearingFriction), "another law")
            self.bearing = of("friction.thrust_bearing.coefficient")
            self.bearing = self.bearing * of("friction.thrust_bearing.radius")
        if friction.drag is not None:
            self.drag = of("friction.drag.torque")
        inertia = of("carrier.inertia")
        roller, mass = of("roller.inertia"), of("roller.mass")
        self.inertia = None
        if None not in (inertia, roller, mass):
            starts, radius = thread["starts"], thread["roller_radius"]
            own = roller * (starts - 1) ** 2 + mass * ((starts - 1) * radius) ** 2
            self.inertia = stage.carrier.count * inertia + self.count * own


class Chain:
    """Forces from the last stage to the first."""

    def __init__(self, mechanism: Mechanism, numbers, scenario: bool = False):
        self.stages = [
            _Link(stage, numbers, f"stage.{k + 1}.") for k, stage in enumerate(mechanism.stages)
        ]
        place = "scenario" if scenario else "operating_point"
        self.speed, self.load = numbers[f"{place}.speed"][0], numbers[f"{place}.load"][0]
        self.travel = sum(stage.axial for stage in self.stages)
        need(self.load > 0 and self.speed != 0, "no load, or no motion")
        self.root = mpmath.sqrt
        #: Smallest share of a normal force that has carried so far.
        self.least_push = 1.0

    def in_floats(self) -> "Chain":
        """The same in floats, for an integrator."""
        need(self.speed > 0, "back-driving")
        for link in self.stages:
            need(link.inertia is not None and link.inertia > 0, "no inertia")
            for name, value in vars(link).items():
                if name not in ("count", "contact"):
                    setattr(link, name, in_plain(value))
        self.speed, self.load, self.travel = map(float, (self.speed, self.load, self.travel))
        self.root = lambda x: x**0.5
        return self

    def _walk(self, ratios, factor=1):
        sense = 1 if self.speed > 0 else -1
        nut, torque = self.load, 0 * self.load
        found: list[dict[str, Any]] = []
        for link, ratio in zip(reversed(self.stages), reversed(list(ratios)), strict=True):
            slip = (
                link.arm[0] - ratio * link.drive[0],
                link.arm[1] - ratio * link.drive[1],
                link.axial,
            )
            size = self.root(slip[0] ** 2 + slip[1] ** 2 + slip[2] ** 2)
            along = [sense * factor * link.friction * part / size for part in slip]
            push = -link.normal[2] - along[2]
            need(push > 0, "jammed")
            self.least_push = min(self.least_push, float(push))
            force = nut / link.count / push
            moment = link.arm[0] * (link.normal[0] + along[0])
            moment += link.arm[1] * (link.normal[1] + along[1])
            torque = torque + link.count * force * moment
            bearing, spline = factor * link.bearing, factor * link.spline
            # The screw of the next stage slides in this one's, and drags it along.
            own = nut - (found[-1]["spline"] if found else 0)
            torque = torque + sense * bearing * own
            torque = torque / (1 - bearing * spline) + sense * factor * link.drag
            state = {"force": force, "nut": nut, "slip": size, "along": along}
            state["tangential"] = along[0] * link.drive[0] + along[1] * link.drive[1]
            if spline:
                need(torque > 0 and link.drag == 0, "a spline that pulls back")
            state["spline"] = sense * spline * torque
            nut = own + state["spline"]
            found.append(state)
        return torque, found[::-1]

    def rates(self, ratios):
        """d(ω/Ω)/dt [1/s] at carrier ratios."""
        _, states = self._walk(ratios)
        return [
            link.count * s["force"] * s["tangential"] / (link.inertia * self.speed)
            for link, s in zip(self.stages, states, strict=True)
        ]

    def torque(self, ratios, factor=1):
        """Torque at the first screw; all friction times a factor."""
        return self._walk(ratios, factor)[0]

    def steady(self) -> dict[str, Any]:
        """Columns of a steady state."""
        ratios = [link.steady_ratio for link in self.stages]
        torque, states = self._walk(ratios)
        need(torque > 0, "self-locking")
        useful, spent = self.load * self.travel, torque
        if self.speed < 0:
            useful, spent = spent, useful
        power = abs(self.speed) * max(spent, useful)
        return {
            "efficiency": useful / spent,
            "carrier_ratio": ratios,
            "drive_torque": torque,
            "contact_force": [s["force"] for s in states],
            "nut_load": [s["nut"] for s in states],
            "slip_speed": [s["slip"] * abs(self.speed) for s in states],
            "input_power": spent * abs(self.speed),
            "losses": abs(spent - useful) * abs(self.speed),
            "loss_power": abs(spent - useful) * abs(self.speed) if power else 0,
        }
