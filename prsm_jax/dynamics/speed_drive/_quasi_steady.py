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
from ..forces import Drive, Motion, Scenario, StageState, all_push, chain_forces, drive_once
from ..histories import CarrierHistory, SolverReport
from ..solvers import QuasiSteady
from ..steady import balanced_carrier_ratio, steady_motion
from ._carrier_motion import (
    Problem,
    carrier_acceleration,
    driven_states,
    jumps_at_standstill,
)

#: Limits of the lag behind the balance, and of the estimated error; both are carrier ratios, or
#: carrier speeds over the highest screw speed.
_LARGEST_SHIFT, _LARGEST_ERROR = 0.03, 1.0


def impending_sense(speed: Scalar, acceleration: Scalar | None) -> Scalar:
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
    sense = impending_sense(speed, acceleration)
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


def _states_at(
    problem: Problem,
    motion: Drive,
    carrier_speed: Float[Array, " stages"],
    ratios: Float[Array, " stages"],
) -> tuple[StageState, ...]:
    """Forces of all stages at given carrier speeds [rad/s].

    Where friction jumps at standstill, its directions there are those of impending motion, which
    follow from the carrier ratios.
    """
    mechanism, kinematics = problem.mechanism, problem.kinematics
    if not jumps_at_standstill(mechanism):
        return driven_states(mechanism, kinematics, motion, carrier_speed)
    speed, acceleration, load = motion
    sense = impending_sense(speed, acceleration)
    turns = speed != 0
    ratios = jnp.where(turns, carrier_speed / jnp.where(turns, speed, 1.0), ratios)

    def motion_of(index: int, flank_sign: Scalar, _, axial_acceleration) -> Motion:
        own_sense, own_speed = flank_sign * sense, flank_sign * speed
        return steady_motion(
            kinematics[index], ratios[index], own_speed, own_sense, axial_acceleration
        )

    return chain_forces(mechanism, kinematics, motion_of, speed, sense, load, acceleration)


class _Balance(NamedTuple):
    """The balance at one time, and how fast the carriers follow it."""

    #: Carrier ratios in balance, and their change in time [1/s].
    ratios: Float[Array, " stages"]
    drift: Float[Array, " stages"]
    #: Time constants in which the carriers settle, 1/|∂ω̇/∂ω|; 0 without friction [s].
    lag: Float[Array, " stages"]
    valid: Bool[Array, ""]


def _followed(problem: Problem, time: Scalar) -> tuple[Float[Array, " stages"], _Balance]:
    """Lag of the carrier ratios behind their balance, and the balance.

    The balance moves, `Ω ζ̇`, and the carriers follow it at their rates `|∂ω̇/∂ω|`: they lag behind
    by `ζ̇ / |∂ω̇/∂ω|`, to first order.
    """
    scenario, inertia = problem.scenario, problem.inertia

    def balanced(at):
        _, ratios, valid = quasi_steady_states(
            problem.mechanism, problem.kinematics, scenario, inertia, at
        )
        return ratios, valid

    if _moves(scenario):
        ratios, drift, valid = jax.jvp(balanced, (time,), (jnp.ones_like(time),), has_aux=True)
    else:
        ratios, valid = balanced(time)
        drift = jnp.zeros_like(ratios)
    drive = drive_once(scenario, time)
    slopes = jax.jacfwd(lambda w: carrier_acceleration(problem, drive, w))(ratios * drive.speed)
    rates = jnp.abs(jnp.diagonal(slopes))
    # Exact Coulomb friction at standstill: carriers follow without delay.
    moving = above_or_nan(rates)
    lag = jnp.where(moving, 1 / jnp.where(moving, rates, 1.0), 0.0)
    return lag * drift, _Balance(ratios, drift, lag, valid)


def _moves(scenario: Scenario) -> bool:
    return callable(scenario.speed) or callable(scenario.load)


class Neglected(NamedTuple):
    """Validity of the balance at one time, and the effect of the terms that it neglects."""

    #: Whether friction drives the carriers, and every contact pushes.
    valid: Bool[Array, ""]
    #: Time constants in which the carriers settle [s].
    lag: Float[Array, " stages"]
    #: Estimate of the error of the carrier speeds over the highest screw speed.
    speed_error: Float[Array, " stages"]


def quasi_steady_at(problem: Problem) -> Callable[[Scalar], tuple[CarrierHistory, Neglected]]:
    """A function for the motion of quasi-steady carriers, and the error of this approximation.

    The carriers lag behind the balance by a first-order shift, which is subtracted. One step of
    Newton's method on their equation of motion, `ω̇ = F(ω)`, with the acceleration of the shifted
    motion on the left, follows. The remaining error is of third order; its estimate is that step,
    which is of second order.

    **Arguments:**

    - `problem`: mechanism, scenario and inertias.

    **Returns:** a function of a time [s].
    """
    inertia = problem.inertia

    def at(time: Scalar) -> tuple[CarrierHistory, Neglected]:
        motion = drive_once(problem.scenario, time)
        if _moves(problem.scenario):
            shift, change, balance = jax.jvp(
                lambda t: _followed(problem, t), (time,), (jnp.ones_like(time),), has_aux=True
            )
            # Where the load passes through zero nothing drives the carriers, and their first-order
            # lag would be unbounded.
            ratios = balance.ratios - jnp.clip(shift, -_LARGEST_SHIFT, _LARGEST_SHIFT)
            drift = balance.drift - change
            step = _step_to_equation_of_motion(problem, motion, ratios, drift, balance.lag)
        else:
            _, balance = _followed(problem, time)
            ratios, step = balance.ratios, jnp.zeros_like(balance.ratios)
        bound = _LARGEST_SHIFT * problem.speed_scale
        speeds = ratios * motion.speed + jnp.clip(step, -bound, bound)
        states = _states_at(problem, motion, speeds, ratios)
        drives = jnp.stack([state.forces.carrier_drive for state in states])
        history = CarrierHistory(*motion, speeds, states, drives / inertia)
        error = jnp.minimum(jnp.abs(step) / problem.speed_scale, _LARGEST_ERROR)
        return history, Neglected(balance.valid & all_push(states), balance.lag, error)

    return at


def _step_to_equation_of_motion(
    problem: Problem,
    motion: Drive,
    ratios: Float[Array, " stages"],
    drift: Float[Array, " stages"],
    lag: Float[Array, " stages"],
) -> Float[Array, " stages"]:
    """One step of Newton's method from carriers that move with given ratios [rad/s].

    **Arguments:**

    - `problem`, `motion`: the scene, and its drive at this time.
    - `ratios`, `drift`: carrier ratios, and their change in time [1/s].
    - `lag`: 1/|∂ω̇/∂ω| [s].
    """
    rates = drift * motion.speed
    if motion.acceleration is not None:
        rates = rates + ratios * motion.acceleration
    return lag * (carrier_acceleration(problem, motion, ratios * motion.speed) - rates)


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
        error_over_time=jax.lax.stop_gradient(jnp.max(error, axis=-1)),
        time_constant=jax.lax.stop_gradient(jnp.max(lag)),
    )
