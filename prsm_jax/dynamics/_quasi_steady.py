"""Carriers that follow the screw at once: a transient without integration.

The carriers settle within microseconds to milliseconds, the faster the slower they turn. A scene
of seconds need not resolve that. What is left is a balance at every instant, in which the carriers
still have their inertia: they accelerate as the screw makes them.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .._physics import physics
from ..mechanism import Mechanism, Scalar
from ._carrier_balance import balanced_carrier_ratio, steady_motion
from ._carrier_motion import Problem, carrier_acceleration
from ._chain import StageState, chain_forces
from ._kinematics import StageKinematics
from ._scenario import Scenario
from ._solvers import NAMES
from ._stage_forces import Motion
from ._transient_result import CarrierHistory, SolverReport, prescribed


def sense_of(speed: Scalar, acceleration: Scalar | None) -> Scalar:
    """Sense of turning, +1 or −1; at standstill that of the motion about to begin."""
    onset = jnp.ones_like(speed) if acceleration is None else jnp.sign(acceleration)
    onset = jnp.where(onset == 0, 1.0, onset)
    sense = jnp.where(speed == 0, onset, jnp.sign(speed))
    return jax.lax.stop_gradient(sense)


@physics("quasi_steady")
def quasi_steady_states(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    scenario: Scenario,
    inertia: Float[Array, " stages"],
    time: Scalar,
) -> tuple[tuple[StageState, ...], Float[Array, " stages"], Bool[Array, ""]]:
    """Motion and forces of all stages at one instant, with the carriers in balance.

    The carrier ratio ζ of each stage balances `N f·d = resistance + I ζ Ω̇`; what is neglected is
    `I ζ̇ Ω`. Both the balance and the directions of slip are regular through standstill, where
    they jump with the sense of turning.

    **Arguments:**

    - `mechanism`, `kinematics`, `scenario`: what moves, and how it is driven and loaded.
    - `inertia`: of the carriers with their rollers [kg·m²].
    - `time`: [s].

    **Returns:** the states, the carrier ratios, and whether friction can drive every carrier.
    """
    speed, acceleration = scenario.motion_at(time)
    sense = sense_of(speed, acceleration)
    ratios: list[Scalar] = []
    valid = jnp.asarray(True)

    def motion_of(index: int, flank: Scalar, axial_force: Scalar, axial_acceleration) -> Motion:
        nonlocal valid
        per_ratio = None if acceleration is None else inertia[index] * (flank * acceleration)
        own_sense, own_speed = flank * sense, flank * speed
        ratio, found = balanced_carrier_ratio(
            mechanism.stages[index], kinematics[index], own_sense, own_speed, axial_force, per_ratio
        )
        valid = valid & found
        ratios.append(ratio)
        return steady_motion(kinematics[index], ratio, own_speed, own_sense, axial_acceleration)

    load = scenario.load_at(time)
    states = chain_forces(mechanism, kinematics, motion_of, speed, sense, load, acceleration)
    for state in states:
        # Past the locking limit the axial balance asks for a pulling contact.
        valid = valid & (state.forces.contact_force >= 0)
    return states, jnp.stack(ratios[::-1]), valid


def quasi_steady_history(
    problem: Problem, times: Float[Array, " times"]
) -> tuple[CarrierHistory, SolverReport]:
    """Carriers in balance at every time, with an estimate of what that neglects.

    The neglected `I ζ̇ Ω` shifts the ratio by `I ζ̇ / |∂(N f·d)/∂ω|` to first order.

    **Arguments:**

    - `problem`: mechanism, scenario and inertias.
    - `times`: [s].
    """
    scenario, inertia = problem.scenario, problem.inertia

    def balanced(time):
        return quasi_steady_states(problem.mechanism, problem.kinematics, scenario, inertia, time)

    def at(time):
        states, ratios, valid = balanced(time)
        speed = scenario.speed_at(time)
        drives = jnp.stack([state.forces.carrier_drive for state in states])
        slopes = jax.jacfwd(lambda w: carrier_acceleration(problem, time, w))(ratios * speed)
        rates = jnp.abs(jnp.diagonal(slopes))
        # Standstill: carriers follow at once.
        moves = (rates > 0) & (speed != 0)
        lag = jnp.where(moves, 1 / jnp.where(moves, rates, 1.0), 0.0)
        drift = jnp.zeros_like(ratios)
        if callable(scenario.speed) or callable(scenario.load):
            _, drift = jax.jvp(lambda t: balanced(t)[1], (time,), (jnp.ones_like(time),))
        return ratios * speed, states, drives / inertia, valid, lag, jnp.abs(drift) * lag

    speeds, states, accelerations, valid, lag, shift = jax.vmap(at)(times)
    none = jnp.zeros((), int)
    report = SolverReport(
        steps=none,
        rejected=none,
        code=jnp.where(jnp.all(valid), none, 4),
        name=NAMES["quasi_steady"],
        error_estimate=jax.lax.stop_gradient(jnp.max(shift)),
        time_constant=jax.lax.stop_gradient(jnp.max(lag)),
    )
    history = CarrierHistory(*prescribed(scenario, times), speeds, states, accelerations)
    return history, report
