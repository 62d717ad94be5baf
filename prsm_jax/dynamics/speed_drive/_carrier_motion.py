"""The carriers' equation of motion, and its scales."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...fields import Scalar
from ...mechanism import Mechanism
from ...programs import physics
from .._kinematics import StageKinematics, free_carrier_ratio, turning_range
from ..forces import (
    Drive,
    Motion,
    ReducedChain,
    Scenario,
    StageState,
    carrier_drives,
    carrier_inertia,
    chain_forces,
    drive_at,
    drive_once,
    reduced_chain,
    reduced_rates,
    sense_of,
    sliding_motion,
)
from ..friction import with_resistance
from ..solvers import DrivenRate, still

#: Errors get more weight where friction turns within less than the ratio over this number.
_TURNS = 10.0
#: Largest error, as a share of the distance to where friction turns plus the range of turning.
_OF_THE_RANGE = 0.3
#: Speed that counts as standstill, and the narrowest range resolved, in absolute tolerances.
_LEAST_SPEED, _LEAST_RANGE = 10.0, 1e-2
#: Roundings of the scaled time that are added to the narrowest range.
_ROUNDINGS = 16.0
#: Fractional parts of its multiples are spread evenly between 0 and 1 and never repeat.
_GOLDEN = (5**0.5 - 1) / 2


class ScaledProblem(eqx.Module):
    """What right-hand sides of all types need: the scene, and scales of its speeds and its time."""

    mechanism: Mechanism
    kinematics: tuple[StageKinematics, ...]
    scenario: Scenario
    speed_scale: Scalar
    time_scale: Scalar


class Problem(ScaledProblem):
    """Everything the right-hand side needs, as one pytree."""

    inertia: Float[Array, " stages"]
    #: The mechanism in few scalars, where those suffice.
    reduced: ReducedChain | None = None


def states_at(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    scenario: Scenario,
    time: Scalar,
    carrier_speed: Float[Array, " stages"],
) -> tuple[StageState, ...]:
    """Motion and forces of all stages at one instant.

    **Arguments:**

    - `mechanism`, `kinematics`, `scenario`: the mechanism, its kinematics, drive and load.
    - `time`: [s].
    - `carrier_speed`: ω of every stage [rad/s].
    """
    return driven_states(mechanism, kinematics, drive_at(scenario, time), carrier_speed)


def driven_states(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    drive: Drive,
    carrier_speed: Float[Array, " stages"],
    carrier_acceleration: Float[Array, " stages"] | None = None,
) -> tuple[StageState, ...]:
    """As `states_at`, from the drive at that instant.

    `carrier_acceleration` is that of `chain_forces`.
    """
    kinematics = with_resistance(mechanism.stages, kinematics)
    speed, acceleration, load = drive

    def motion_of(index: int, flank_sign: Scalar, _, axial_acceleration) -> Motion:
        own_speed, carrier = flank_sign * speed, flank_sign * carrier_speed[index]
        return sliding_motion(kinematics[index], own_speed, carrier, axial_acceleration)

    sense = sense_of(speed)
    return chain_forces(
        mechanism, kinematics, motion_of, speed, sense, load, acceleration, carrier_acceleration
    )


def moves_nut(mechanism: Mechanism) -> bool:
    """Whether the carriers move the nut along the axis, because it has grooves."""
    return not all(stage.thread.family.lead_is_fixed for stage in mechanism.stages)


def carrier_acceleration(
    problem: Problem, drive: Drive, carrier_speed: Float[Array, " stages"]
) -> Float[Array, " stages"]:
    """ω̇ of every stage [rad/s²]."""
    if problem.reduced is not None:
        return jnp.stack(reduced_rates(problem.reduced, *drive, carrier_speed))
    if moves_nut(problem.mechanism):
        return _acceleration_with_nut(problem, drive, carrier_speed)
    states = driven_states(problem.mechanism, problem.kinematics, drive, carrier_speed)
    return carrier_drives(states) / problem.inertia


@physics("nut_moved_by_carriers")
def _acceleration_with_nut(
    problem: Problem, drive: Drive, carrier_speed: Float[Array, " stages"]
) -> Float[Array, " stages"]:
    """ω̇ of a carrier that moves the nut along the axis [rad/s²].

    With z̈ = h (ω̇ − Ω̇) of nut and rollers, and axial force F − m z̈ of the rollers, the equation
    `I ω̇ = N f·d + h (F − m z̈)` holds ω̇ on both sides. It is linear where friction is in proportion
    to the normal force, so that one step of Newton's method solves it; the second step removes
    rounding, and the error of laws and losses that are not linear.
    """

    def unbalanced(rate: Float[Array, " stages"]) -> Float[Array, " stages"]:
        states = driven_states(problem.mechanism, problem.kinematics, drive, carrier_speed, rate)
        return carrier_drives(states) - problem.inertia * rate

    def step(rate: Float[Array, " stages"], _: None):
        residual, slope = jax.jvp(unbalanced, (rate,), (jnp.ones_like(rate),))
        return rate - residual / slope, None

    # A loop: the forces would be compiled once more for the second step.
    rate, _ = jax.lax.scan(step, jnp.zeros_like(carrier_speed), length=2)
    return rate


def _scaled_drive(time: Scalar, problem: Problem) -> Drive:
    return drive_at(problem.scenario, time * problem.time_scale)


@physics("carrier_dynamics")
def _scaled_rate(drive: Drive, ratio: Float[Array, " stages"], problem: Problem):
    rate = carrier_acceleration(problem, drive, ratio * problem.speed_scale)
    return rate * (problem.time_scale / problem.speed_scale)


@physics("carrier_dynamics")
def _scaled_rates(drive: Drive, ratios: Sequence[Scalar], problem: Problem) -> list[Scalar]:
    """`_scaled_rate` of a list of scalars, as a list of scalars."""
    if problem.reduced is None:
        return list(_scaled_rate(drive, jnp.stack(ratios), problem))
    speeds = [ratio * problem.speed_scale for ratio in ratios]
    scale = problem.time_scale / problem.speed_scale
    return [rate * scale for rate in reduced_rates(problem.reduced, *drive, speeds)]


def _scaled_speed(drive: Drive, problem: Problem) -> tuple[Scalar, Scalar]:
    """Scaled speed of the screw, which the carriers follow, and its rate."""
    rate = jnp.zeros_like(drive.speed) if drive.acceleration is None else drive.acceleration
    return drive.speed / problem.speed_scale, rate * problem.time_scale / problem.speed_scale


#: d(ω/Ω₀)/d(t/τ): both state and time of order one, so that one tolerance fits every scene.
scaled_rate: DrivenRate = DrivenRate(_scaled_drive, _scaled_rate, _scaled_speed, _scaled_rates)


def carrier_problem(
    mechanism: Mechanism, kinematics: tuple[StageKinematics, ...], scenario: Scenario
) -> Problem:
    """Collect the input of the equation of motion, with its scales: a speed Ω₀ and a time τ.

    Ω₀ is the highest screw speed, τ the shortest time constant of the carriers at that speed, near
    their steady state.
    """
    inertia = jnp.stack([carrier_inertia(stage) for stage in mechanism.stages])
    speed, drive = fastest_drive(scenario)
    reduced = reduced_chain(mechanism, kinematics, inertia)
    one = jnp.ones_like(speed)
    problem = Problem(mechanism, kinematics, scenario, speed, one, inertia, reduced)
    # Not exactly at the steady state, where a friction law may have a kink.
    carrier = 0.3 * drive.speed * jnp.ones_like(inertia)
    return with_scales(problem, lambda w: carrier_acceleration(problem, drive, w), carrier)


def fastest_drive(scenario: Scenario) -> tuple[Scalar, Drive]:
    """The highest speed of a scene (1 where it stands still) [rad/s], and the drive at its time."""
    times = _times_of_scales(scenario)
    speeds = jnp.abs(jax.vmap(scenario.speed_at)(times))
    fastest = jnp.argmax(speeds)
    speed = jnp.where(speeds[fastest] > 0, speeds[fastest], 1.0)
    return speed, drive_at(scenario, times[fastest])


#: A problem with a scenario and scales of speed and time.
_Scaled = TypeVar("_Scaled", bound=ScaledProblem)


def with_scales(
    problem: _Scaled,
    acceleration: Callable[[Float[Array, " speeds"]], Float[Array, " speeds"]],
    speeds: Float[Array, " speeds"],
) -> _Scaled:
    """A problem with its scale of time, the shortest time constant at some speeds.

    **Arguments:**

    - `problem`: with its scale of speed.
    - `acceleration`: rate of the speeds that are its states [rad/s²].
    - `speeds`: near the steady state [rad/s].
    """
    slopes = jax.jacfwd(acceleration)(speeds)
    rate, duration = jnp.max(jnp.abs(jnp.diagonal(slopes))), problem.scenario.duration
    decays = rate * duration > 1.0
    shortest = jnp.where(decays, 1 / jnp.where(decays, rate, 1.0), duration)
    # Scales affect the steps, not the solution: nothing is differentiated through them.
    scales = (jax.lax.stop_gradient(problem.speed_scale), jax.lax.stop_gradient(shortest))
    return eqx.tree_at(lambda p: (p.speed_scale, p.time_scale), problem, scales)


def sample_times(problem: ScaledProblem) -> Float[Array, " times"]:
    """Sample times of a scene, both ends included [s]."""
    scenario = problem.scenario
    times = jnp.linspace(0.0, 1.0, scenario.samples, dtype=problem.speed_scale.dtype)
    return times * scenario.duration


def _times_of_scales(scenario: Scenario) -> Float[Array, " times"]:
    """Times at which the highest speed of a scene is searched for [s].

    Equal intervals may all hit the standstills of a periodic speed; intervals of the golden ratio
    are in phase with no period. Break times are included because a speed that is monotonic between
    them is highest at one of them.
    """
    dtype, duration = scenario.duration.dtype, scenario.duration
    equal = jnp.linspace(0.0, 1.0, 9, dtype=dtype) * duration
    uneven = jnp.asarray(np.modf(np.arange(1, 17) * _GOLDEN)[0], dtype) * duration
    return jnp.concatenate([equal, uneven, jnp.clip(scenario.break_times, 0.0, duration)])


class ErrorWeight(eqx.Module):
    """Weight of errors of ω/Ω₀; it exceeds 1 where friction turns within a narrow range.

    The range is proportional to the speed. Just after a reversal it is narrower than the absolute
    tolerance. Without the weight, steps then jumped from one side of it to the other, and one such
    step multiplied a derivative by up to 90.
    """

    scenario: Scenario
    speed_scale: Scalar
    time_scale: Scalar
    #: Carrier ratios ζ∞, and the ranges around them within which friction turns.
    rolling: Float[Array, " stages"]
    turning: Float[Array, " stages"]
    #: Absolute tolerance of the steps.
    atol: Scalar

    def __call__(self, time: Scalar, ratio: Float[Array, " stages"]) -> Float[Array, " stages"]:
        """The factor for each stage at a scaled time and state; 1 at an ordinary lead."""
        speed = drive_once(self.scenario, time * self.time_scale).speed / self.speed_scale
        # The range would vanish at standstill; there it is that of the least speed.
        size = jnp.maximum(jnp.abs(speed), _LEAST_SPEED * self.atol)
        near = jnp.abs(ratio - self.rolling * speed) + self.turning * size
        # Changes of a state by rounding of the time cannot be resolved.
        near = jnp.maximum(
            near, _LEAST_RANGE * self.atol + _ROUNDINGS * time * jnp.finfo(size.dtype).eps
        )
        of_the_ratio = jnp.abs(self.rolling * speed) / (_TURNS * near)
        return jnp.maximum(1.0, jnp.maximum(of_the_ratio, self.atol / (_OF_THE_RANGE * near)))


def error_weight(problem: Problem, atol: Any) -> ErrorWeight:
    """The weight of errors of a scene; nothing is differentiated through it.

    **Arguments:**

    - `problem`: the scene.
    - `atol`: absolute tolerance of the carrier ratios.
    """
    rolling = jnp.stack([free_carrier_ratio(k) for k in problem.kinematics])
    turning = jnp.stack([turning_range(k) for k in problem.kinematics])
    weight = ErrorWeight(
        problem.scenario,
        problem.speed_scale,
        problem.time_scale,
        rolling,
        turning,
        jnp.asarray(atol, problem.speed_scale.dtype),
    )
    return still(weight)


class Standstills(eqx.Module):
    """Times to and since a standstill of the screw, from its speed and acceleration."""

    scenario: Scenario
    speed_scale: Scalar
    time_scale: Scalar
    #: Share of the largest speed that counts as standstill.
    least: Scalar

    def __call__(self, time: Scalar) -> tuple[Scalar, Scalar]:
        """Scaled times until and since a standstill; infinity where there is none."""
        speed, acceleration, _ = drive_once(self.scenario, time * self.time_scale)
        assert acceleration is not None
        least, slows = self.least * self.speed_scale, speed * acceleration < 0
        moves = acceleration != 0
        size = jnp.abs(speed)
        rate = self.time_scale * jnp.where(moves, jnp.abs(acceleration), 1.0)
        until = jnp.where(slows & (size > least), size / rate, jnp.inf)
        return until, jnp.where(moves & ~slows, jnp.maximum(size, least) / rate, jnp.inf)


def jumps_at_standstill(mechanism: Mechanism) -> bool:
    """Whether thread friction of any stage jumps at standstill."""
    laws = [stage.thread_law for stage in mechanism.stages]
    return any(law is not None and not law.smooth_at_standstill for law in laws)


def standstills(problem: Problem, atol: Any) -> Standstills | None:
    """Times to and since standstills, where friction jumps there; else `None`.

    **Arguments:**

    - `problem`: the scene.
    - `atol`: absolute tolerance of the carrier ratios; ten times this speed counts as standstill.
    """
    if not (jumps_at_standstill(problem.mechanism) and callable(problem.scenario.speed)):
        return None
    least = jnp.asarray(_LEAST_SPEED * atol, problem.speed_scale.dtype)
    estimate = Standstills(problem.scenario, problem.speed_scale, problem.time_scale, least)
    return still(estimate)
