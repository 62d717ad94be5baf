"""Torque and acceleration of a screw whose carriers follow it.

Two problems with the same equations: the acceleration at which the motion needs the applied torque,
and the torque at which a mechanism at rest begins to turn. Friction of splines and thrust bearings
depends on forces that depend on the acceleration, and so do the balances of the carriers: all of
them are solved together.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...fields import Scalar
from ...mechanism import Mechanism
from ...programs import physics
from ...scenario import TorqueScenario
from .._kinematics import StageKinematics, travel_per_radian
from ..forces import Motion, StageState, all_push, carrier_inertia, chain_forces
from ..friction import has_contact_losses, unknown_shares, with_resistance
from ..steady import all_kinematics, carrier_balance, find_roots, steady_motion

FORWARD, BACKWARD, STICKING = 1.0, -1.0, 0.0


class TorqueProblem(eqx.Module):
    """Everything that the equation of motion needs, as one pytree."""

    mechanism: Mechanism
    kinematics: tuple[StageKinematics, ...]
    scenario: TorqueScenario
    inertia: Float[Array, " stages"]
    #: Inertia of everything that moves, referred to the screw, to scale accelerations [kg·m²].
    total_inertia: Scalar
    #: Typical torque of the scene, to scale torques [N·m].
    torque_scale: Scalar


class ScrewMotion(eqx.Module):
    """Angle, speed and acceleration of the screw."""

    angle: Scalar
    speed: Scalar
    acceleration: Scalar


class Instant(NamedTuple):
    """All forces for a motion of the screw."""

    states: tuple[StageState, ...]
    ratios: Float[Array, " stages"]
    load: Scalar
    #: Residuals of the carriers' balances and of the axial balances with an unknown share; and
    #: whether all threads mesh and all contacts push.
    residuals: Float[Array, " unknowns"]
    valid: Bool[Array, ""]

    @property
    def torque(self) -> Scalar:
        """Torque at the first screw that the motion needs [N·m]."""
        return self.states[0].screw.drive_torque


def first_unknowns(problem: TorqueProblem) -> Float[Array, " unknowns"]:
    """Initial guess of a search: tangents of all carriers, and `unknown_shares`."""
    shares = unknown_shares(problem.mechanism.stages, problem.kinematics).values()
    start = jnp.zeros_like(problem.inertia)
    return jnp.concatenate([start, jnp.stack(list(shares))]) if shares else start


def shares_of(problem: TorqueProblem, unknowns: Float[Array, " unknowns"]) -> dict[int, Scalar]:
    """Shares of the normal force that carry axially, by stage: the last of the unknowns."""
    unknown = list(unknown_shares(problem.mechanism.stages, problem.kinematics))
    return {index: unknowns[at - len(unknown)] for at, index in enumerate(unknown)}


def axial_residuals(states: tuple[StageState, ...]) -> list[Scalar]:
    """Residuals of the axial balances at these shares."""
    each = [state.forces.residual for state in states]
    return [residual for residual in each if residual is not None]


@physics("torque_drive")
def instant(
    problem: TorqueProblem,
    time: Scalar,
    motion: ScrewMotion,
    sense: Scalar,
    unknowns: Float[Array, " unknowns"],
) -> Instant:
    """Forces of all stages for a motion of the screw, with slip directions of a sense of turning.

    **Arguments:**

    - `problem`, `time`, `motion`, `sense`: the scene, the screw's motion, its sense +1 or −1.
    - `unknowns`: tangents of the carriers' balances (`CarrierBalance`), and shares (`shares_of`).
    """
    mechanism, kinematics = problem.mechanism, problem.kinematics
    travel = travel_per_radian(mechanism.stages, len(mechanism.stages))
    position = problem.scenario.initial_position + travel * motion.angle
    velocity, acceleration = travel * motion.speed, travel * motion.acceleration
    load = problem.scenario.load_at(time, position, velocity, acceleration)
    ratios: list[Scalar] = []
    residuals: list[Scalar] = []
    valid = jnp.stack([k.meshing.converged for k in kinematics]).all()
    shares = shares_of(problem, unknowns)

    def motion_of(
        index: int, flank_sign: Scalar, axial_force: Scalar, axial_acceleration
    ) -> Motion:
        stage, geometry = mechanism.stages[index], kinematics[index]
        own_speed, own_sense = flank_sign * motion.speed, flank_sign * sense
        per_ratio = problem.inertia[index] * (flank_sign * motion.acceleration)
        balance = carrier_balance(stage, geometry, own_sense, own_speed, axial_force, per_ratio)
        point = balance.at(unknowns[index], shares.get(index))
        ratios.append(point.ratio)
        residuals.append(point.residual)
        return steady_motion(
            geometry,
            point.ratio,
            own_speed,
            own_sense,
            axial_acceleration,
            slip=point.slip,
            contact=point.contact,
        )

    states = chain_forces(
        mechanism, kinematics, motion_of, motion.speed, sense, load, motion.acceleration
    )
    all_residuals = jnp.stack([*residuals[::-1], *axial_residuals(states)])
    return Instant(states, jnp.stack(ratios[::-1]), load, all_residuals, valid & all_push(states))


class Balance(NamedTuple):
    """Result of a search."""

    acceleration: Scalar
    #: As those of `instant`.
    unknowns: Float[Array, " unknowns"]
    converged: Bool[Array, ""]


# Inner functions that are compiled on their own are traced once, however often they are called.
@eqx.filter_jit
def moving(
    problem: TorqueProblem, time: Scalar, angle: Scalar, speed: Scalar, sense: Scalar
) -> Balance:
    """Acceleration at which the required torque is the applied one [rad/s²]."""
    applied, scale = problem.scenario.torque_at(time), problem.torque_scale
    unit = scale / problem.total_inertia

    def residual(unknowns):
        motion = ScrewMotion(angle, speed, unknowns[0] * unit)
        now = instant(problem, time, motion, sense, unknowns[1:])
        return jnp.concatenate([((now.torque - applied) / scale)[None], now.residuals])

    start = jnp.concatenate([jnp.zeros_like(speed)[None], first_unknowns(problem)])
    unknowns, converged = find_roots(residual, start, tolerance=_tolerance(speed), max_steps=30)
    return Balance(unknowns[0] * unit, unknowns[1:], converged)


@eqx.filter_jit
def resting(problem: TorqueProblem, time: Scalar, angle: Scalar, sense: Scalar) -> Balance:
    """The balances of the carriers in impending motion."""
    zero = jnp.zeros_like(angle)
    at_rest = ScrewMotion(angle, zero, zero)
    start = first_unknowns(problem)
    resisted = any(has_contact_losses(stage.friction) for stage in problem.mechanism.stages)
    if not resisted and start.size == len(problem.kinematics):
        # Nothing resists the rollers: the slip depends on geometry alone.
        return Balance(zero, start, jnp.asarray(True))

    def residual(unknowns):
        return instant(problem, time, at_rest, sense, unknowns).residuals

    unknowns, converged = find_roots(residual, start, tolerance=_tolerance(angle), max_steps=30)
    return Balance(zero, unknowns, converged)


def _tolerance(value: Scalar) -> float:
    return 1e-9 if value.dtype == jnp.float64 else 1e-4


@eqx.filter_jit
def breakaway_torques(problem: TorqueProblem, time: Scalar, angle: Scalar) -> Float[Array, "2"]:
    """Torques at which a mechanism at rest begins to turn backward and forward [N·m].

    In between it sticks. If the backward torque is negative, the mechanism is self-locking.
    Friction that is larger at rest than in motion counts with its value at rest.
    """
    zero = jnp.zeros_like(angle)

    def torque(sense):
        unknowns = resting(problem, time, angle, sense).unknowns
        return instant(problem, time, ScrewMotion(angle, zero, zero), sense, unknowns).torque

    # One program for both senses.
    return jax.vmap(torque)(jnp.asarray([BACKWARD, FORWARD], angle.dtype))


def torque_problem(mechanism: Mechanism, scenario: TorqueScenario) -> TorqueProblem:
    """Collect the input of the equation of motion."""
    kinematics = with_resistance(mechanism.stages, all_kinematics(mechanism))
    inertia = jnp.stack([carrier_inertia(stage) for stage in mechanism.stages])
    zero, one = jnp.zeros((), inertia.dtype), jnp.ones((), inertia.dtype)
    problem = TorqueProblem(mechanism, kinematics, scenario, inertia, one, one)

    def torque(acceleration):
        motion = ScrewMotion(zero, zero, acceleration)
        return instant(problem, zero, motion, one, first_unknowns(problem)).torque

    at_rest, total = jax.jvp(torque, (zero,), (one,))
    grid = jnp.linspace(0.0, 1.0, 17, dtype=inertia.dtype) * scenario.duration
    applied = jnp.max(jnp.abs(jax.vmap(scenario.torque_at)(grid)))
    scale = jnp.abs(at_rest) + applied
    scale = jnp.where(scale > 0, scale, 1.0)
    # Only scales: nothing is differentiated through them.
    return eqx.tree_at(
        lambda p: (p.total_inertia, p.torque_scale),
        problem,
        (jax.lax.stop_gradient(total), jax.lax.stop_gradient(scale)),
    )
