"""Runs under a prescribed torque in ellipses that slide and spin, in NumPy and SciPy.

Slip and spin are integrated over the ellipse itself (`slip_and_spin`), for directions of slip all
round and for forces in a range, and interpolated: both dependences are analytic, so trigonometric
and Chebyshev polynomials converge to rounding with few points. Only Hertz's ellipse at 1 N is the
package's.
"""

from math import atan2, cbrt, copysign, pi
from typing import Any

import numpy as np

from prsm_jax.dynamics.friction._contact_losses import with_resistance
from prsm_jax.dynamics.steady._steady import all_kinematics
from prsm_jax.mechanism import Mechanism

from ..slip_and_spin import slip_and_spin
from .dynamics import StageNumbers
from .torque_runs import TorqueChain


class SpinningRollers:
    """Friction of one roller by direction of slip and normal force.

    **Arguments:**

    - `numbers`: of the stage.
    - `starts`: of its screw.
    - `axes`, `semi`: directions of the ellipse's axes in space, and their lengths at 1 N [m].
    - `nut_spin`: moment about the axis that resists on the nut side at 1 N [N·m].
    - `nut_normal`: axial part of the normal there.
    - `points`: directions within half a turn, and forces.
    - `forces`: range of normal forces [N].
    """

    def __init__(
        self,
        numbers: StageNumbers,
        starts: float,
        axes: np.ndarray,
        semi: np.ndarray,
        nut_spin: float,
        nut_normal: float,
        points: tuple[int, int],
        forces: tuple[float, float],
    ):
        self.numbers, self.more_starts = numbers, starts - 1
        self.axes, self.nut_spin, self.nut_normal = axes, nut_spin, nut_normal
        # All slips lie in the plane of the drive d and of what turns with the screw alone.
        drive = np.array([*numbers.drive, 0.0])
        self.reach = float(np.linalg.norm(drive))
        screw = np.array([*numbers.screw, numbers.lead / (2 * pi)])
        self.along = drive / self.reach
        self.lead = float(screw @ self.along)
        across = screw - self.lead * self.along
        self.crossing = float(np.linalg.norm(across))
        self.across = across / self.crossing
        directions, growths = points
        self.lower, self.upper = cbrt(forces[0]), cbrt(forces[1])
        turns = pi * np.arange(directions) / directions
        nodes = np.cos(pi * (np.arange(growths) + 0.5) / growths)
        values = np.array(
            [[self.integrated(turn, self._growth(node), semi) for node in nodes] for turn in turns]
        )
        # All of it changes sign with the direction of slip: odd harmonics only.
        self.harmonics = np.arange(1 - directions, directions, 2)
        waves = np.exp(1j * np.outer(turns, self.harmonics))
        table = np.linalg.solve(waves, values.reshape(directions, -1)).reshape(values.shape)
        inverse = np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, growths - 1))
        self.table = np.einsum("kg,hgc->hkc", inverse, table)

    def _growth(self, node):
        return (self.lower + self.upper) / 2 + (self.upper - self.lower) / 2 * node

    def speeds(self, turn: float) -> tuple[float, float]:
        """Speeds of screw and carrier per slip speed [rad/m]."""
        screw = np.cos(turn) / self.crossing
        return screw, (screw * self.lead - np.sin(turn)) / self.reach

    def turn_of(self, ratio: float) -> float:
        """Direction of slip at a carrier ratio and a screw that turns forward."""
        return atan2(self.lead - ratio * self.reach, self.crossing)

    def integrated(self, turn, growth, semi, points=400):
        """Force along both axes of the ellipse and moment about the normal, per μ F."""
        slip = np.cos(turn) * self.across + np.sin(turn) * self.along
        screw, carrier = self.speeds(turn)
        spin = self.numbers.normal[2] * (screw + self.more_starts * carrier)
        major, minor = growth * semi
        return slip_and_spin(major, minor, self.axes @ slip, spin, points)

    def friction(self, turn: float, axial: float) -> tuple[float, Any, float]:
        """Normal force [N], friction [N], and moment about the axis on the screw [N·m]."""
        friction, normal = self.numbers.friction, self.numbers.normal[2]
        weights = np.einsum("h,hkc->kc", np.exp(1j * self.harmonics * turn), self.table).real
        force = axial
        for _ in range(60):
            before = force
            node = (2 * cbrt(force) - self.lower - self.upper) / (self.upper - self.lower)
            if abs(node) > 1:
                raise ValueError(f"the reference has no ellipse at {force:g} N")
            first, second, moment = np.polynomial.chebyshev.chebval(node, weights)
            per_force = friction * (first * self.axes[0] + second * self.axes[1])
            force = axial / (-normal - per_force[2])
            if abs(force - before) <= 1e-14 * force:
                break
        return force, force * per_force, friction * force * moment * normal


class SpinningChain(TorqueChain):
    """A chain of stages whose ellipses slide and spin.

    **Arguments:**

    - `mechanism`, `torque`, `load`: as of the base.
    - `points`, `forces`: as of `SpinningRollers`.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        torque,
        load,
        points: tuple[int, int] = (16, 8),
        forces: tuple[float, float] = (1.0, 500.0),
    ):
        super().__init__(mechanism, torque, load)
        self.contacts, self.roller_masses, self.semi_axes = [], [], []
        geometries = with_resistance(mechanism.stages, all_kinematics(mechanism))
        for stage, geometry, numbers in zip(mechanism.stages, geometries, self.stages, strict=True):
            resistance: Any = geometry.resistance
            ellipse = resistance.ellipse
            shape = ellipse.shape
            (minor, major), ways = np.linalg.eigh(
                np.array([[shape.first, shape.mixed], [shape.mixed, shape.second]])
            )
            # Major axis first, the second by a right angle from it.
            first = ways[:, 1]
            axes = np.stack([first, [-first[1], first[0]]])
            axes = axes @ np.stack([ellipse.rolling, ellipse.across])
            self.semi_axes.append(np.sqrt([major, minor]))
            self.contacts.append(
                SpinningRollers(
                    numbers,
                    float(stage.thread.starts),
                    axes,
                    self.semi_axes[-1],
                    float(resistance.nut.spin),
                    float(geometry.meshing.nut.normal[2]),
                    points,
                    forces,
                )
            )
            assert stage.roller.mass is not None
            self.roller_masses.append(float(stage.roller.mass))

    def rollers(self, k, pushed, unit, acceleration) -> tuple[float, float]:
        """As that of the base, with slip and spin in one, and the spin of the nut side."""
        stage, contact = self.stages[k], self.contacts[k]
        if not np.any(unit):
            # Held, with a carrier at rest: nothing moves.
            return super().rollers(k, pushed, unit, acceleration)
        turn = atan2(unit @ contact.along, unit @ contact.across)
        force, rub, by_screw = contact.friction(turn, pushed / stage.rollers)
        on_roller = force * np.array(stage.normal) + rub
        # The nut and its rollers move axially at z̈ = −Ω̇ times all leads so far over 2π.
        on_nut = -on_roller[2] - self.roller_masses[k] * self.travels[k] * acceleration
        by_nut = contact.nut_spin * (on_nut / contact.nut_normal) ** (4 / 3)
        by_nut = copysign(by_nut, contact.speeds(turn)[1])
        drive = rub[:2] @ np.array(stage.drive) - contact.more_starts * (by_screw + by_nut)
        arm = stage.screw[0] * on_roller[0] + stage.screw[1] * on_roller[1]
        return stage.rollers * (arm + by_screw), stage.rollers * drive

    def about_to_turn(self, k, pushed, sense, acceleration) -> np.ndarray:
        """Of all directions the one in which nothing drives the carrier."""
        from scipy.optimize import brentq

        contact = self.contacts[k]

        def direction(turn):
            return sense * (np.cos(turn) * contact.across + np.sin(turn) * contact.along)

        def driven(turn):
            return self.rollers(k, pushed, direction(turn), acceleration)[1]

        # Carrier and screw turn the same way.
        return direction(brentq(driven, -1.4, contact.turn_of(1e-9), xtol=1e-15))
