"""Transients with diffrax: the carriers on their way to the steady state."""

from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .._errors import PrsmError
from .._physics import physics
from ..mechanism import Mechanism, Scalar
from ._chain import StageState, chain_forces
from ._kinematics import StageKinematics, slip_velocity
from ._scenario import Scenario, default_scenario
from ._stage_forces import Motion, carrier_inertia
from ._steady import all_kinematics
from ._thread_friction import slip_direction
from ._transient_result import SolverReport, Transient, histories

Method = Literal["implicit", "explicit", "rosenbrock"]
_NAMES = {
    "implicit": "Kvaerno5 with Newton",
    "explicit": "Tsit5",
    "rosenbrock": "RODASP",
}
Gradient = Literal["reverse", "forward", "both"]


class _Problem(eqx.Module):
    """Everything the right-hand side needs, as one pytree."""

    mechanism: Mechanism
    kinematics: tuple[StageKinematics, ...]
    scenario: Scenario
    inertia: Float[Array, " stages"]
    speed_scale: Scalar
    time_scale: Scalar


def _sign(value: Scalar) -> Scalar:
    return jnp.sign(jax.lax.stop_gradient(value))


def states_at(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    scenario: Scenario,
    time: Scalar,
    carrier_speed: Float[Array, " stages"],
) -> tuple[StageState, ...]:
    """Motion and forces of all stages at one instant.

    **Arguments:**

    - `mechanism`, `kinematics`, `scenario`: what moves, and how it is driven and loaded.
    - `time`: [s].
    - `carrier_speed`: ω of every stage [rad/s].
    """
    speed, acceleration = scenario.speed_at(time), None
    if callable(scenario.speed):
        speed, acceleration = jax.jvp(scenario.speed_at, (time,), (jnp.ones_like(time),))

    def motion_of(index: int, _, axial_acceleration) -> Motion:
        geometry, carrier = kinematics[index], carrier_speed[index]
        slip = slip_velocity(geometry, speed, carrier)
        rolling = geometry.relative_spin_ratio * carrier
        return Motion(
            screw_speed=speed,
            carrier_speed=carrier,
            slip=slip,
            direction=slip_direction(slip),
            screw_sense=_sign(speed + rolling),
            nut_sense=_sign(rolling),
            axial_acceleration=axial_acceleration,
        )

    load = scenario.load_at(time)
    return chain_forces(mechanism, kinematics, motion_of, _sign(speed), load, acceleration)


def _acceleration(problem: _Problem, time: Scalar, carrier_speed) -> Float[Array, " stages"]:
    states = states_at(problem.mechanism, problem.kinematics, problem.scenario, time, carrier_speed)
    return jnp.stack([state.forces.carrier_drive for state in states]) / problem.inertia


@physics("carrier_dynamics")
def _scaled_rate(time, ratio, problem: _Problem):
    """d(ω/Ω₀)/d(t/τ): both state and time of order one, so that one tolerance fits every scene."""
    rate = _acceleration(problem, time * problem.time_scale, ratio * problem.speed_scale)
    return rate * problem.time_scale / problem.speed_scale


def _scales(mechanism, kinematics, scenario, inertia) -> tuple[Scalar, Scalar]:
    """A speed Ω₀ and the shortest time constant τ of the carriers near their steady state."""
    times = jnp.linspace(0.0, 1.0, 9, dtype=scenario.duration.dtype) * scenario.duration
    speeds = jnp.abs(jax.vmap(scenario.speed_at)(times))
    fastest = jnp.argmax(speeds)
    speed = jnp.where(speeds[fastest] > 0, speeds[fastest], 1.0)
    unscaled = _Problem(mechanism, kinematics, scenario, inertia, speed, jnp.ones_like(speed))
    # Away from the exact steady state, where a friction law might have its kink.
    carrier = 0.3 * scenario.speed_at(times[fastest]) * jnp.ones_like(inertia)
    slopes = jax.jacfwd(lambda w: _acceleration(unscaled, times[fastest], w))(carrier)
    fastest_rate = jnp.max(jnp.abs(jnp.diagonal(slopes)))
    decays = fastest_rate * scenario.duration > 1.0
    shortest = jnp.where(decays, 1 / jnp.where(decays, fastest_rate, 1.0), scenario.duration)
    # Scales shape the grid of steps, not the solution: nothing is differentiated through them.
    return jax.lax.stop_gradient(speed), jax.lax.stop_gradient(shortest)


def _solver(method: Method, rtol: float, atol: float, autonomous: bool):
    import diffrax
    import optimistix

    if method == "explicit":
        return diffrax.Tsit5()
    if method == "implicit":
        # Not diffrax's default root finder: its chord iterations stall here and the step size
        # collapses.
        return diffrax.Kvaerno5(root_finder=optimistix.Newton(rtol=rtol, atol=atol))
    if method == "rosenbrock":
        from ._rosenbrock import Rodasp

        return Rodasp(autonomous)
    raise ValueError(f"method is {method!r}; choose one of {', '.join(_NAMES)}")


def _adjoint(gradient: Gradient):
    import diffrax

    adjoints = {
        "reverse": diffrax.RecursiveCheckpointAdjoint,
        "forward": diffrax.ForwardMode,
        "both": diffrax.DirectAdjoint,
    }
    if gradient not in adjoints:
        raise ValueError(f"gradient is {gradient!r}; choose one of {', '.join(adjoints)}")
    return adjoints[gradient]()


def simulate(
    mechanism: Mechanism,
    scenario: Scenario | None = None,
    *,
    method: Method = "implicit",
    gradient: Gradient = "both",
    rtol: float = 1e-8,
    atol: float = 1e-10,
    max_steps: int = 4096,
    throw: bool = True,
) -> Transient:
    """Simulate the carriers of all stages under prescribed screw speed and load.

    States are the carrier speeds, `[2 J_P + N J_R (n − 1)² + N m_R a²] ω̇ = N f·d − resisting
    moments` (Li et al. 2021, in Lagrange's form); all forces follow algebraically at the sample
    times. Speed and time are scaled inside by the fastest screw speed and the shortest time
    constant, so the tolerances are relative to those.

    **Arguments:**

    - `mechanism`: the mechanism, with masses and inertias of rollers and carriers (and of screws
      and nuts if the speed varies).
    - `scenario`: speed, load, duration; default the mechanism's operating point.
    - `method`: `"implicit"` (Kvaerno 5/4 with Newton, any stiffness, the reference),
      `"rosenbrock"` (RODASP 4/3, any stiffness, no iterations: the cheapest for stiff scenes) or
      `"explicit"` (Tsitouras 5/4, for short scenes).
    - `gradient`: `"both"` (either mode through one program), `"reverse"` (checkpointed, bounded
      memory for long scenes) or `"forward"` (for few parameters).
    - `rtol`, `atol`: tolerances on the carrier ratio, of the steps. Between the large steps of the
      implicit method the samples are interpolated to third order: at the default their largest
      error is about 1e-6 while the carriers still accelerate (`benchmarks`, case transient).
    - `max_steps`: steps allowed; running out of them is reported in `solver`, never hidden.
    - `throw`: raise if the solver fails. Inside a trace nothing is raised and the result code in
      `solver.code` tells.

    **Raises:** `MissingDataError` if masses or the scenario are not given; `ValueError` for an
    unknown method or gradient; `PrsmError` if the solver fails and `throw` is set.
    """
    import diffrax

    if scenario is None:
        scenario = default_scenario(mechanism)
    kinematics = all_kinematics(mechanism)
    inertia = jnp.stack([carrier_inertia(stage) for stage in mechanism.stages])
    speed_scale, time_scale = _scales(mechanism, kinematics, scenario, inertia)
    problem = _Problem(mechanism, kinematics, scenario, inertia, speed_scale, time_scale)
    times = jnp.linspace(0.0, 1.0, scenario.samples, dtype=inertia.dtype) * scenario.duration
    start = scenario.initial_carrier_ratio * scenario.speed_at(times[0]) / speed_scale
    end = scenario.duration / time_scale
    autonomous = not (callable(scenario.speed) or callable(scenario.load))
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(_scaled_rate),
        _solver(method, rtol, atol, autonomous),
        t0=jnp.zeros_like(end),
        t1=end,
        dt0=None,
        y0=start * jnp.ones_like(inertia),
        args=problem,
        saveat=diffrax.SaveAt(ts=jnp.linspace(0.0, 1.0, scenario.samples, dtype=end.dtype) * end),
        stepsize_controller=diffrax.PIDController(rtol=rtol, atol=atol),
        adjoint=_adjoint(gradient),
        max_steps=max_steps,
        throw=False,
    )
    ratio: Any = solution.ys
    carrier_speed = ratio * speed_scale

    def at(time, speeds):
        return (
            states_at(mechanism, kinematics, scenario, time, speeds),
            _acceleration(problem, time, speeds),
        )

    states, accelerations = jax.vmap(at)(times, carrier_speed)
    report = SolverReport(
        steps=solution.stats["num_accepted_steps"],
        rejected=solution.stats["num_rejected_steps"],
        code=_code(solution.result),
        name=_NAMES[method],
    )
    if throw and _is_concrete(report.code) and int(report.code) != 0:
        raise PrsmError(f"the transient did not finish: {report.result}")
    return histories(
        mechanism, kinematics, scenario, times, carrier_speed, states, accelerations, report
    )


def _is_concrete(array: Array) -> bool:
    try:
        int(array)
    except jax.errors.ConcretizationTypeError:
        return False
    return True


def _code(result) -> Int[Array, ""]:
    """0 success, 1 out of steps, 2 step size too small, 3 anything else (a root search failed)."""
    import diffrax

    results = diffrax.RESULTS
    code = jnp.asarray(3)
    for number, known in enumerate(
        (results.successful, results.max_steps_reached, results.dt_min_reached)
    ):
        code = jnp.where(result == known, number, code)
    return code
