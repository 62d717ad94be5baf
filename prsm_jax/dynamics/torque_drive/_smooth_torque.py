"""Prescribed torque with friction laws that are smooth through standstill: no events.

With bristles (LuGre) or regularised Coulomb friction the contact forces follow from the states at
any speed. Screw and carriers are then all free: angle and speed of the screw, the speed of every
carrier, and the deflections of bristles. Where exact Coulomb friction sticks, these laws act as
a stiff spring, or creep.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from ...fields import Scalar
from ...friction import friction_laws
from ...mechanism import Mechanism, Stage
from ...numerics import find_root, sum_few
from ...programs import physics
from ...scenario import TorqueScenario
from .._kinematics import free_carrier_ratio, travel_per_radian
from ..forces import all_push
from ..friction import bristles_of, has_contact_losses
from ..histories import CarrierHistory, Settings, Transient, histories, integrated
from ..solvers import Rodasp
from ..speed_drive import BristleState, deflection_scales, states_with_bristles
from ._torque_balance import TorqueProblem, torque_problem


class _State(eqx.Module):
    """Angle and speed of the screw, and the state of carriers and bristles."""

    angle: Scalar
    speed: Scalar
    bristles: BristleState


def has_smooth_threads(mechanism: Mechanism) -> bool:
    """Whether thread friction of any stage passes standstill without events."""
    laws = [stage.thread_law for stage in mechanism.stages]
    return any(
        law is not None and law.smooth_at_standstill and not law.load_independent for law in laws
    )


def _jump_of(stage: Stage) -> str | None:
    """The friction of a stage that jumps at standstill, with the remedy."""
    friction = stage.friction
    if friction is None:
        return None
    for name, one in (
        ("thread", friction.thread),
        ("spline", friction.spline and friction.spline.law),
        ("thrust_bearing", friction.thrust_bearing and friction.thrust_bearing.law),
    ):
        if one is not None and not one.smooth_at_standstill:
            laws = friction_laws(of_threads=name == "thread").items()
            words = ", ".join(f'"{law}"' for law, cls in laws if cls.smooth_at_standstill)
            return f"friction.{name} jumps there; give it one of the laws {words}"
    if friction.drag is not None and friction.drag.width is None:
        return "friction.drag jumps there; give its width"
    if has_contact_losses(friction):
        return "friction.spin and friction.rolling_hysteresis jump there; leave them out"
    return None


def _check_smooth(mechanism: Mechanism) -> None:
    for number, stage in enumerate(mechanism.stages, start=1):
        jump = _jump_of(stage)
        if jump is not None:
            raise ValueError(
                "under a prescribed torque, if some thread friction is smooth through "
                f"standstill, all friction has to be; stage {number}: {jump}"
            )


def _load(problem: TorqueProblem, time: Scalar, state: _State, acceleration: Scalar) -> Scalar:
    travel = travel_per_radian(problem.mechanism.stages, len(problem.mechanism.stages))
    position = problem.scenario.initial_position + travel * state.angle
    return problem.scenario.load_at(time, position, travel * state.speed, travel * acceleration)


@physics("smooth_torque_drive")
def _motion(problem: TorqueProblem, time: Scalar, state: _State):
    """Forces of all stages, rates of the state, the load, and whether the torques balance."""
    torque = problem.scenario.torque_at(time)

    def states_at(acceleration):
        load = _load(problem, time, state, acceleration)
        forces_and_rates = states_with_bristles(
            problem.mechanism, problem.kinematics, state.bristles, state.speed, load, acceleration
        )
        return *forces_and_rates, load

    def residual(scaled: Scalar) -> Scalar:
        states, _, _ = states_at(scaled * size / problem.total_inertia)
        return (states[0].screw.drive_torque - torque) / size

    unaccelerated, _, _ = states_at(jnp.zeros_like(state.speed))
    size = jnp.abs(unaccelerated[0].screw.drive_torque) + jnp.abs(torque)
    size = jax.lax.stop_gradient(jnp.where(size > 0, size, 1.0))
    # Linear except for the moduli in the friction of splines and thrust bearings.
    scaled, converged = find_root(residual, jnp.zeros_like(size), tolerance=1e-12, max_steps=20)
    acceleration = scaled * size / problem.total_inertia
    states, bending, load = states_at(acceleration)
    carriers = jnp.stack([one.forces.carrier_drive for one in states]) / problem.inertia
    rates = _State(state.speed, acceleration, BristleState(carriers, bending))
    return states, rates, load, converged


def _scales(problem: TorqueProblem, times: Float[Array, " times"]) -> _State:
    """Sizes of the states: of bristles before they slip, else of a free run-up."""
    mechanism, scenario = problem.mechanism, problem.scenario
    inertia, one = problem.total_inertia, jnp.ones_like(problem.total_inertia)
    torques = jnp.abs(jax.vmap(lambda time: scenario.torque_at(time))(times))
    travel = travel_per_radian(mechanism.stages, len(mechanism.stages))
    load = scenario.load_at(times[0], scenario.initial_position, 0 * travel, 0 * travel)
    torque = jnp.max(torques) + jnp.abs(load) * travel
    torque = jnp.where(torque > 0, torque, one)
    sizes = deflection_scales(mechanism)
    angle = torque * times[-1] ** 2 / inertia
    bent = [
        size / jnp.sqrt(sum_few(geometry.slip_per_screw**2))
        for size, geometry in zip(
            sizes,
            [
                geometry
                for stage, geometry in zip(mechanism.stages, problem.kinematics, strict=True)
                if bristles_of(stage) is not None
            ],
            strict=True,
        )
    ]
    for size in bent:
        angle = jnp.minimum(angle, size)
    speed = jnp.sqrt(torque * angle / inertia)
    both = tuple(size * jnp.ones(2, size.dtype) for size in sizes)
    scales = _State(angle, speed, BristleState(speed * jnp.ones_like(problem.inertia), both))
    return jax.lax.stop_gradient(scales)


def smooth_torque_history(
    mechanism: Mechanism, scenario: TorqueScenario, settings: Settings
) -> Transient:
    """Integrate screw, carriers and bristles under a prescribed torque, from settled carriers.

    **Arguments:** the scene, and how to integrate; quasi-steady is RODASP as well.

    **Raises:** `ValueError` if other friction of the mechanism jumps at standstill.
    """
    _check_smooth(mechanism)
    if settings.method.carriers == "in_balance":
        settings = settings._replace(method=Rodasp())
    problem = torque_problem(mechanism, scenario)
    dtype = problem.inertia.dtype
    times = jnp.linspace(0.0, 1.0, scenario.samples, dtype=dtype) * scenario.duration
    end, scales = scenario.duration, _scales(problem, times)

    # One vector, because without bristles one part is empty.
    sizes, unflatten = ravel_pytree(scales)

    def physical(scaled):
        return unflatten(scaled * sizes)

    def rate(share, scaled, _):
        _, rates, _, _ = _motion(problem, share * end, physical(scaled))
        return ravel_pytree(rates)[0] * (end / sizes)

    turning = scenario.initial_speed.astype(dtype) / scales.speed
    ratios = jnp.stack([free_carrier_ratio(geometry) for geometry in problem.kinematics])
    carriers = ratios * turning * (scales.speed / scales.bristles.carrier_speed)
    start = _State(
        jnp.zeros((), dtype),
        turning,
        BristleState(carriers, tuple(jnp.zeros(2, dtype) for _ in scales.bristles.deflection)),
    )
    scaled, report = integrated(
        rate,
        ravel_pytree(start)[0],
        jnp.ones_like(end),
        scenario.break_times / end,
        scenario.samples,
        settings,
    )
    sampled = jax.vmap(physical)(scaled)
    states, rates, load, balanced = jax.vmap(lambda t, y: _motion(problem, t, y))(times, sampled)
    unbalanced = ~jnp.all(balanced & all_push(states))
    code = jnp.where((report.code == 0) & unbalanced, 4, report.code)
    report = eqx.tree_at(lambda r: r.code, report, code)
    history = CarrierHistory(
        sampled.speed,
        rates.speed,
        load,
        sampled.bristles.carrier_speed,
        states,
        rates.bristles.carrier_speed,
    )
    run = histories(mechanism, problem.kinematics, times, history, report)
    position = travel_per_radian(mechanism.stages, len(mechanism.stages)) * sampled.angle
    return eqx.tree_at(lambda r: r.position, run, position, is_leaf=lambda leaf: leaf is None)
