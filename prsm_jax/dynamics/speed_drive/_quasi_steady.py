"""Carriers that follow the screw at once: a transient without integration.

The carriers settle within microseconds to milliseconds, the faster the slower they turn. A scene
of seconds need not resolve that. What is left is a balance at every instant, in which the carriers
still have their inertia: they accelerate as the screw makes them.
"""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...mechanism import Mechanism, Scalar
from ...numerics import above_or_nan
from ...programs import physics
from .._kinematics import StageKinematics
from ..forces import Motion, Scenario, StageState, chain_forces, drive_once
from ..histories import CarrierHistory, SolverReport
from ..solvers import NAMES
from ..steady import balanced_carrier_ratio, steady_motion
from ._carrier_motion import Problem, carrier_acceleration

#: Of the carrier ratio: what carriers may stay behind their balance, and be wrong by.
_LARGEST_SHIFT, _LARGEST_ERROR = 0.03, 1.0


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
    speed, acceleration, load = drive_once(scenario, time)
    sense = sense_of(speed, acceleration)
    ratios: list[Scalar] = []
    valid = jnp.asarray(True)

    def motion_of(index: int, flank: Scalar, axial_force: Scalar, axial_acceleration) -> Motion:
        nonlocal valid
        per_ratio = None if acceleration is None else inertia[index] * (flank * acceleration)
        own_sense, own_speed = flank * sense, flank * speed
        balance = balanced_carrier_ratio(
            mechanism.stages[index], kinematics[index], own_sense, own_speed, axial_force, per_ratio
        )
        valid = valid & balance.found
        ratios.append(balance.ratio)
        return balance.motion(kinematics[index], own_speed, own_sense, axial_acceleration)

    states = chain_forces(mechanism, kinematics, motion_of, speed, sense, load, acceleration)
    for state in states:
        # Past the locking limit the axial balance asks for a pulling contact.
        valid = valid & (state.forces.contact_force >= 0)
    return states, jnp.stack(ratios[::-1]), valid


def states_at_ratios(
    problem: Problem, time: Scalar, ratios: Float[Array, " stages"]
) -> tuple[StageState, ...]:
    """Forces of all stages at given carrier ratios, which make sense at standstill too."""
    mechanism, kinematics, scenario = problem.mechanism, problem.kinematics, problem.scenario
    speed, acceleration, load = drive_once(scenario, time)
    sense = sense_of(speed, acceleration)

    def motion_of(index: int, flank: Scalar, _, axial_acceleration) -> Motion:
        own_sense, own_speed = flank * sense, flank * speed
        return steady_motion(
            kinematics[index], ratios[index], own_speed, own_sense, axial_acceleration
        )

    return chain_forces(mechanism, kinematics, motion_of, speed, sense, load, acceleration)


def _followed(problem: Problem, time: Scalar):
    """By how much the carriers stay behind their balance, the balance, and their time constants.

    The balance moves, `Ω ζ̇`, and the carriers follow it at their rates `|∂ω̇/∂ω|`: they stay behind
    by `ζ̇ / |∂ω̇/∂ω|`, to first order.
    """
    scenario, inertia = problem.scenario, problem.inertia

    def balanced(at):
        _, ratios, valid = quasi_steady_states(
            problem.mechanism, problem.kinematics, scenario, inertia, at
        )
        return ratios, valid

    moves = callable(scenario.speed) or callable(scenario.load)
    if moves:
        ratios, drift, valid = jax.jvp(balanced, (time,), (jnp.ones_like(time),), has_aux=True)
    else:
        ratios, valid = balanced(time)
        drift = jnp.zeros_like(ratios)
    drive = drive_once(scenario, time)
    speed = drive.speed
    slopes = jax.jacfwd(lambda w: carrier_acceleration(problem, drive, w))(ratios * speed)
    rates = jnp.abs(jnp.diagonal(slopes))
    # Standstill: carriers follow at once.
    moving = above_or_nan(rates) & (speed != 0)
    lag = jnp.where(moving, 1 / jnp.where(moving, rates, 1.0), 0.0)
    return lag * drift, (ratios, lag, valid)


class Neglected(NamedTuple):
    """Of the balance at one time: whether there is one, and what it leaves out."""

    #: Whether friction drives the carriers, and every contact pushes.
    valid: Bool[Array, ""]
    #: Time constants in which the carriers settle [s].
    lag: Float[Array, " stages"]
    #: Estimate of the error of the carrier ratios.
    left: Float[Array, " stages"]


def quasi_steady_at(problem: Problem) -> Callable[[Scalar], tuple[CarrierHistory, Neglected]]:
    """A function that finds carriers which follow their balance, and what that neglects.

    The carriers stay behind the balance by a first-order shift, which is taken off. What is left
    is of second order; the estimate is the shift of that shift.

    **Arguments:**

    - `problem`: mechanism, scenario and inertias.

    **Returns:** a function of a time [s].
    """
    scenario, inertia = problem.scenario, problem.inertia

    def at(time: Scalar) -> tuple[CarrierHistory, Neglected]:
        if callable(scenario.speed) or callable(scenario.load):
            shift, change, found = jax.jvp(
                lambda t: _followed(problem, t), (time,), (jnp.ones_like(time),), has_aux=True
            )
        else:
            shift, found = _followed(problem, time)
            change = shift
        ratios, lag, valid = found
        # Where the load passes through zero nothing drives the carriers, and to first order they
        # would stay behind without bound.
        ratios = ratios - jnp.clip(shift, -_LARGEST_SHIFT, _LARGEST_SHIFT)
        states = states_at_ratios(problem, time, ratios)
        # Past the locking limit the axial balance asks for a pulling contact.
        pushed = jnp.stack([state.forces.contact_force >= 0 for state in states]).all()
        drives = jnp.stack([state.forces.carrier_drive for state in states])
        motion = drive_once(scenario, time)
        history = CarrierHistory(*motion, ratios * motion[0], states, drives / inertia)
        left = jnp.minimum(jnp.abs(change) * lag, _LARGEST_ERROR)
        return history, Neglected(valid & pushed, lag, left)

    return at


def quasi_steady_report(neglected: Neglected) -> SolverReport:
    """How the balance went at all times, which are the first axis."""
    valid, lag, left = neglected
    none = jnp.zeros((), int)
    return SolverReport(
        steps=none,
        rejected=none,
        code=jnp.where(jnp.all(valid), none, 4),
        name=NAMES["quasi_steady"],
        error_estimate=jax.lax.stop_gradient(jnp.max(left)),
        time_constant=jax.lax.stop_gradient(jnp.max(lag)),
    )
