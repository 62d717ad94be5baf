"""Transients of threads with bristles: their deflections are states besides the speeds.

Bristles pass smoothly through standstill and reversal. They are stiff, so a solver for stiff scenes
should be used. Where the load changes flanks, bristles keep their deflection, which a slip of a few
micrometres then reverses.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...mechanism import Mechanism
from ...programs import physics
from .._kinematics import StageKinematics
from ..forces import (
    Drive,
    Motion,
    Scenario,
    StageState,
    chain_forces,
    drive_at,
    sense_of,
    sliding_motion,
)
from ..friction import bristle_rate, bristles_of, deflected, in_tangent_plane
from ..histories import CarrierHistory, Settings, SolverReport, integrated, prescribed
from ..solvers import DrivenRate
from ._carrier_motion import Problem


class BristleState(eqx.Module):
    """Speeds of the carriers, and transverse deflections of bristles in stages that have them."""

    carrier_speed: Float[Array, " stages"]
    deflection: tuple[Float[Array, "2"], ...]


@physics("bristle_dynamics")
def states_with_bristles(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    state: BristleState,
    speed: Scalar,
    load: Scalar,
    acceleration: Scalar | None,
) -> tuple[tuple[StageState, ...], tuple[Float[Array, "2"], ...]]:
    """Motion and forces of all stages at one instant, and rates of bristle deflections [m/s].

    **Arguments:**

    - `mechanism`, `kinematics`: the mechanism and its kinematics.
    - `state`: speeds of the carriers and deflections.
    - `speed`, `acceleration`: of the screw [rad/s, rad/s²]; no acceleration at constant speed.
    - `load`: on the last nut [N].
    """
    laws = [bristles_of(stage) for stage in mechanism.stages]
    with_bristles = [index for index, law in enumerate(laws) if law is not None]
    deflections = dict(zip(with_bristles, state.deflection, strict=True))

    def motion_of(index: int, flank_sign: Scalar, _, axial_acceleration) -> Motion:
        geometry, law = kinematics[index], laws[index]
        own_speed, carrier = flank_sign * speed, flank_sign * state.carrier_speed[index]
        if law is None:
            return sliding_motion(geometry, own_speed, carrier, axial_acceleration)
        bent = in_tangent_plane(geometry, deflections[index])
        return sliding_motion(geometry, own_speed, carrier, axial_acceleration, bent)

    sense = sense_of(speed)
    states = chain_forces(mechanism, kinematics, motion_of, speed, sense, load, acceleration)
    rates = []
    for index in with_bristles:
        motion, rub, law = states[index].motion, states[index].forces.rubbing, laws[index]
        assert law is not None
        assert motion.deflection is not None
        contact = deflected(motion.slip, motion.deflection, rub)
        rates.append(bristle_rate(law, contact)[:2])
    return states, tuple(rates)


def deflection_scales(mechanism: Mechanism) -> tuple[Scalar, ...]:
    """Typical deflections of the bristles, to scale states [m]."""
    laws = [bristles_of(stage) for stage in mechanism.stages]
    sizes = [law.deflection_scale for law in laws if law is not None]
    return tuple(jax.lax.stop_gradient(jnp.where(size > 0, size, 1.0)) for size in sizes)


def _scaled_drive(time: Scalar, scene: tuple[Scenario, Scalar]) -> Drive:
    scenario, time_scale = scene
    return drive_at(scenario, time * time_scale)


def bristle_history(
    problem: Problem, times: Float[Array, " times"], settings: Settings
) -> tuple[CarrierHistory, SolverReport]:
    """Integrate carriers and bristles at a prescribed speed, from undeflected bristles.

    **Arguments:** the scene, its sample times, and how to integrate.
    """
    scenario, mechanism, kinematics = problem.scenario, problem.mechanism, problem.kinematics
    sizes = deflection_scales(mechanism)

    def physical(scaled: BristleState) -> BristleState:
        bent = tuple(z * size for z, size in zip(scaled.deflection, sizes, strict=True))
        return BristleState(scaled.carrier_speed * problem.speed_scale, bent)

    def instant(drive: Drive, state: BristleState):
        speed, acceleration, load = drive
        states, rates = states_with_bristles(
            mechanism, kinematics, state, speed, load, acceleration
        )
        drives = jnp.stack([one.forces.carrier_drive for one in states])
        return states, BristleState(drives / problem.inertia, rates)

    def rate(drive, scaled, _):
        _, derivative = instant(drive, physical(scaled))
        bent = tuple(
            z * (problem.time_scale / size)
            for z, size in zip(derivative.deflection, sizes, strict=True)
        )
        return BristleState(
            derivative.carrier_speed * (problem.time_scale / problem.speed_scale), bent
        )

    first = scenario.initial_carrier_ratio * scenario.speed_at(times[0]) / problem.speed_scale
    start = BristleState(
        first * jnp.ones_like(problem.inertia), tuple(jnp.zeros(2, times.dtype) for _ in sizes)
    )
    scaled_states, report = integrated(
        DrivenRate(_scaled_drive, rate),
        start,
        scenario.duration / problem.time_scale,
        scenario.break_times / problem.time_scale,
        scenario.samples,
        settings,
        args=(scenario, problem.time_scale),
        autonomous=not (callable(scenario.speed) or callable(scenario.load)),
    )
    sampled = jax.vmap(physical)(scaled_states)
    drives = jax.vmap(lambda time: drive_at(scenario, time))(times)
    states, rates = jax.vmap(instant)(drives, sampled)
    motion = prescribed(scenario, times)
    history = CarrierHistory(*motion, sampled.carrier_speed, states, rates.carrier_speed)
    return history, report
