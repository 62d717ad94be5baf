"""Carrier dynamics of a chain of stages in plain Python, apart from the package.

Coulomb friction in the threads, in splines and thrust bearings; constant screw speed; screw
driving (Li et al. 2020 and 2021, with the corrections of sign and count that balance requires).
Python floats rather than small NumPy arrays: that is the faster choice for SciPy's solvers.
"""

from dataclasses import dataclass
from math import pi, sqrt

import mpmath

from prsm_jax.friction import CoulombFriction, SplineFriction, ThrustBearingFriction
from prsm_jax.mechanism import Mechanism, Stage, body_inertia, body_mass

from ..meshing import DIGITS, Design, frame_of, mesh_point


@dataclass(frozen=True)
class StageNumbers:
    """One stage: geometry at the contact, inertia, friction coefficients."""

    rollers: int
    lead: float
    #: Velocity of the screw's contact point per radian of screw turn [m].
    screw: tuple[float, float]
    #: Generalised arm of the carrier speed, ∂v_R/∂ω [m].
    drive: tuple[float, float]
    normal: tuple[float, float, float]
    #: ζ∞: friction has no component along ∂v_R/∂ω.
    steady_ratio: float
    inertia: float
    friction: float
    #: μ_SS/r_SS [1/m] and μ_NS r_NS [m].
    spline: float
    bearing: float


def stage_numbers(stage: Stage) -> StageNumbers:
    """Read a stage's data and mesh it in mpmath."""
    thread = stage.thread
    design = Design(
        float(thread.lead),
        float(thread.starts),
        float(thread.roller_radius),
        float(thread.contact_angle),
        float(thread.profile_radius),
    )
    with mpmath.workdps(DIGITS):
        arm, drive, normal, ratio = frame_of(design, mesh_point(design))
    starts, centre = design.starts, (design.starts - 1) * design.roller_radius
    carriers = 0.0
    if stage.carrier is not None:
        carriers = stage.carrier.count * float(body_inertia(stage, "carrier"))
    roller_inertia, roller_mass = (
        float(body_inertia(stage, "roller")),
        float(body_mass(stage, "roller")),
    )
    friction = stage.friction
    assert friction is not None
    assert isinstance(friction.thread, CoulombFriction)
    spline, bearing = friction.spline, friction.thrust_bearing
    assert isinstance(spline, SplineFriction | None)
    assert isinstance(bearing, ThrustBearingFriction | None)
    return StageNumbers(
        rollers=stage.roller_count,
        lead=design.lead,
        screw=(float(arm[0]), float(arm[1])),
        drive=(float(drive[0]), float(drive[1])),
        normal=(float(normal[0]), float(normal[1]), float(normal[2])),
        steady_ratio=float(ratio),
        inertia=carriers
        + stage.roller_count * (roller_inertia * (starts - 1) ** 2 + roller_mass * centre**2),
        friction=float(friction.thread.coefficient),
        spline=0.0 if spline is None else float(spline.coefficient) / float(spline.arm),
        bearing=0.0 if bearing is None else float(bearing.coefficient) * float(bearing.arm),
    )


class Chain:
    """Right-hand side and efficiency of a chain of stages at a constant screw speed."""

    def __init__(self, mechanism: Mechanism, speed: float, load: float):
        self.stages = [stage_numbers(stage) for stage in mechanism.stages]
        self.speed, self.load = speed, load

    def with_operation(self, speed: float, load: float) -> "Chain":
        """The same mechanism at another speed and load."""
        other = object.__new__(Chain)
        other.stages, other.speed, other.load = self.stages, speed, load
        return other

    def _solve(self, ratios) -> tuple[list[float], float]:
        """dω/dt of every stage over Ω, and the torque at the first screw."""
        speed, nut_load, torque = self.speed, self.load, 0.0
        rates = [0.0] * len(self.stages)
        for index in range(len(self.stages) - 1, -1, -1):
            stage = self.stages[index]
            ratio = ratios[index]
            slip_x = stage.screw[0] - ratio * stage.drive[0]
            slip_y = stage.screw[1] - ratio * stage.drive[1]
            slip_z = stage.lead / (2 * pi)
            size = sqrt(slip_x**2 + slip_y**2 + slip_z**2)
            per_force = stage.friction / size
            friction_x, friction_y = per_force * slip_x, per_force * slip_y
            # N (F |n_z| − f_z) = F_n
            force = nut_load / stage.rollers / (-stage.normal[2] - per_force * slip_z)
            drive = friction_x * stage.drive[0] + friction_y * stage.drive[1]
            rates[index] = stage.rollers * force * drive / (stage.inertia * speed)
            # The roller pushes the screw back; the drive has to balance its moment.
            moment = stage.screw[0] * (stage.normal[0] + friction_x)
            moment += stage.screw[1] * (stage.normal[1] + friction_y)
            torque += stage.rollers * force * moment
            # M = M₀ + μ_NS r_NS F and F = F_n + μ_SS/r_SS M, both positive when the screw drives.
            torque = (torque + stage.bearing * nut_load) / (1 - stage.bearing * stage.spline)
            nut_load += stage.spline * torque
        return rates, torque

    def rate(self, _, ratios) -> list[float]:
        """d(ω/Ω)/dt [1/s]."""
        return self._solve(ratios)[0]

    def efficiency(self, ratios) -> float:
        """Output over input power at these carrier ratios."""
        travel = sum(stage.lead for stage in self.stages)
        return self.load * travel / (2 * pi * self._solve(ratios)[1])

    def steady_ratios(self) -> list[float]:
        """ζ∞ of every stage."""
        return [stage.steady_ratio for stage in self.stages]
