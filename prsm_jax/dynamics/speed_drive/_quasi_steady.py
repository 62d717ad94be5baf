"""Carriers that follow the screw without delay: a transient without integration.

The carriers settle within microseconds to milliseconds; the slower they turn, the faster they
settle. A scene of seconds need not resolve that. A balance at every instant remains, which includes
the inertia of the carriers: they accelerate with the screw.
"""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...fields import Scalar
from ...mechanism import Mechanism
from ...numerics import above_or_nan
from ...programs import physics
from .._kinematics import StageKinematics
from ..forces import Motion, Scenario, StageState, all_push, chain_forces, drive_once
from ..histories import CarrierHistory, SolverReport
from ..solvers import QuasiSteady
from ..steady import balanced_carrier_ratio, steady_motion
from ._carrier_motion import Problem, carrier_acceleration

#: Limits, on the carrier ratio, of the lag behind the balance and of the estimated error.
_LARGEST_SHIFT, _LARGEST_ERROR = 0.03, 1.0


def sense_of(speed: Scalar, acceleration: Scalar | None) -> Scalar:
    """Sense of turning, +1 or −1; at standstill that of impending motion."""
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

    The carrier ratio ζ of each stage balances `N f·d = resistance + I ζ Ω̇`; the term `I ζ̇ Ω` is
    neglected. Both the balance and the directions of slip are regular up to standstill, where they
    jump with the sense of turning.

    **Arguments:**

    - `mechanism`, `kinematics`, `scenario`: the mechanism, its kinematics, drive and load.
    - `inertia`: of the carriers with their rollers [kg·m²].
    - `time`: [s].

    **Returns:** the states, the carrier ratios, and whether friction can drive every carrier.
    """
    speed, acceleration, load = drive_once(scenario, time)
    sense = sense_of(speed, acceleration)
    ratios: list[Scalar] = []
    valid = jnp.asarray(True)

    def motion_of(
        index: int, flank_sign: Scalar, axial_force: Scalar, axial_acceleration
    ) -> Motion:
        nonlocal valid
        per_ratio = None if acceleration is None else inertia[index] * (flank_sign * acceleration)
        own_sense, own_speed = flank_sign * sense, flank_sign * speed
        balance = balanced_carrier_ratio(
            mechanism.stages[index], kinematics[index], own_sense, own_speed, axial_force, per_ratio
        )
        valid = valid & balance.converged
        ratios.append(balance.ratio)
        return balance.motion(kinematics[index], own_speed, own_sense, axial_acceleration)

    states = chain_forces(mechanism, kinematics, motion_of, speed, sense, load, acceleration)
    return states, jnp.stack(ratios[::-1]), valid & all_push(states)


def states_at_ratios(
    problem: Problem, time: Scalar, ratios: Float[Array, " stages"]
) -> tuple[StageState, ...]:
    """Forces of all stages at given carrier ratios, which are defined at standstill too."""
    mechanism, kinematics, scenario = problem.mechanism, problem.kinematics, problem.scenario
    speed, acceleration, load = drive_once(scenario, time)
    sense = sense_of(speed, acceleration)

    def motion_of(index: int, flank_sign: Scalar, _, axial_acceleration) -> Motion:
        own_sense, own_speed = flank_sign * sense, flank_sign * speed
        return steady_motion(
            kinematics[index], ratios[index], own_speed, own_sense, axial_acceleration
        )

    return chain_forces(mechanism, kinematics, motion_of, speed, sense, load, acceleration)


def _followed(problem: Problem, time: Scalar):
    """Lag of the carriers behind their balance, the balance, and the time constants of settling.

    The balance moves, `Ω ζ̇`, and the carriers follow it at their rates `|∂ω̇/∂ω|`: they lag behind
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
    # At standstill carriers follow without delay.
    moving = above_or_nan(rates) & (speed != 0)
    lag = jnp.where(moving, 1 / jnp.where(moving, rates, 1.0), 0.0)
    return lag * drift, (ratios, lag, valid)


class Neglected(NamedTuple):
    """Validity of the balance at one time, and the effect of the terms that it neglects."""

    #: Whether friction drives the carriers, and every contact pushes.
    valid: Bool[Array, ""]
    #: Time constants in which the carriers settle [s].
    lag: Float[Array, " stages"]
    #: Estimate of the error of the carrier ratios.
    ratio_error: Float[Array, " stages"]


def quasi_steady_at(problem: Problem) -> Callable[[Scalar], tuple[CarrierHistory, Neglected]]:
    """A function for the motion of quasi-steady carriers, and the error of this approximation.

    The carriers lag behind the balance by a first-order shift, which is subtracted. The remaining
    error is of second order; its estimate is the shift of that shift.

    **Arguments:**

    - `problem`: mechanism, scenario and inertias.

    **Returns:** a function of a time [s].
    """
    scenario, inertia = problem.scenario, problem.inertia

    def at(time: Scalar) -> tuple[CarrierHistory, Neglected]:
        if callable(scenario.speed) or callable(scenario.load):
            shift, change, balance = jax.jvp(
                lambda t: _followed(problem, t), (time,), (jnp.ones_like(time),), has_aux=True
            )
        else:
            shift, balance = _followed(problem, time)
            change = shift
        ratios, lag, valid = balance
        # Where the load passes through zero nothing drives the carriers, and their first-order lag
        # would be unbounded.
        ratios = ratios - jnp.clip(shift, -_LARGEST_SHIFT, _LARGEST_SHIFT)
        states = states_at_ratios(problem, time, ratios)
        drives = jnp.stack([state.forces.carrier_drive for state in states])
        motion = drive_once(scenario, time)
        history = CarrierHistory(*motion, ratios * motion[0], states, drives / inertia)
        error = jnp.minimum(jnp.abs(change) * lag, _LARGEST_ERROR)
        return history, Neglected(valid & all_push(states), lag, error)

    return at


def quasi_steady_report(neglected: Neglected) -> SolverReport:
    """Solver report of the balances at all times, which are the first axis."""
    valid, lag, error = neglected
    zero = jnp.zeros((), int)
    return SolverReport(
        steps=zero,
        rejected=zero,
        code=jnp.where(jnp.all(valid), zero, 4),
        name=QuasiSteady.label,
        error_estimate=jax.lax.stop_gradient(jnp.max(error)),
        time_constant=jax.lax.stop_gradient(jnp.max(lag)),
    )
