"""Error of a torque-driven run due to its quasi-steady carriers."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ..histories import CarrierHistory
from ._driven_carriers import slip_geometry
from ._torque_balance import STICKING, TorqueProblem

#: Bound on the growth of an error at a reversal: acceleration after it over that before.
_LARGEST_GROWTH = 10.0


def neglected(
    problem: TorqueProblem,
    times: Float[Array, " times"],
    history: CarrierHistory,
    mode: Float[Array, " times"],
) -> tuple[Scalar, Scalar]:
    """Error of the screw speed over its largest, and the longest time in which carriers settle [s].

    The balance of quasi-steady carriers neglects the part `P = I ω̇ − N f·d` of their inertia
    forces, `I ζ̇ Ω` where friction suffices. Near the balance, the power of friction hardly changes
    with the direction of slip, so the screw has to supply the power of P, which decelerates it by
    `ζ P/J`. The sum over time is the error of its speed to first order in the time constant of
    settling over that of the motion. A phase of sticking ends where the torque passes a limit,
    whatever the error before: errors start from zero again. At a reversal without sticking they
    grow in proportion to the acceleration.

    **Arguments:**

    - `problem`, `times`: the scene and its samples.
    - `history`: quasi-steady motion and forces at the samples.
    - `mode`: +1, −1, or 0 while the mechanism sticks.
    """
    speed, acceleration = history.screw_speed, history.screw_acceleration
    assert acceleration is not None
    turns = mode != STICKING
    moves = turns & (speed != 0)
    ratio = history.carrier_speed / jnp.where(moves, speed, 1.0)[:, None]
    inertia = problem.inertia[None, :]
    unbalanced = inertia * (ratio * acceleration[:, None] - history.acceleration)
    step = jnp.diff(times)

    def middle(values):
        return (values[1:] + values[:-1]) / 2

    impulse = inertia * middle(speed)[:, None] * jnp.diff(ratio, axis=0)
    impulse = impulse + middle(unbalanced) * step[:, None]
    lost = jnp.sum(middle(ratio) * impulse, axis=1) / problem.total_inertia
    same_phase = moves[1:] & moves[:-1] & (mode[1:] == mode[:-1])
    reverses = turns[1:] & turns[:-1] & (mode[1:] != mode[:-1])
    before = jnp.where(acceleration[:-1] == 0, 1.0, acceleration[:-1])
    growth = jnp.clip(acceleration[1:] / before, -_LARGEST_GROWTH, _LARGEST_GROWTH)
    carry_factor = jnp.where(reverses, growth, jnp.where(turns[1:] & turns[:-1], 1.0, 0.0))

    def advance(error, interval):
        factor, change = interval
        error = factor * error + change
        return error, jnp.abs(error)

    changes = (carry_factor, jnp.where(same_phase, lost, 0.0))
    _, errors = jax.lax.scan(advance, jnp.zeros_like(step[0]), changes)
    largest = jnp.max(jnp.abs(speed))
    error = jnp.max(errors) / jnp.where(largest > 0, largest, 1.0)
    result = (error, jnp.max(_time_constants(problem, history, moves)))
    return jax.lax.stop_gradient(result)


def _time_constants(
    problem: TorqueProblem, history: CarrierHistory, moves
) -> Float[Array, "times stages"]:
    """`I ‖v‖ / (N ‖f‖ d²)` where the screw turns and something rubs, else 0 [s]."""
    states, drive = history.states, slip_geometry(problem).drive
    stages = problem.mechanism.stages
    slip = jnp.stack([jnp.linalg.norm(s.motion.slip, axis=-1) for s in states], axis=-1)
    friction = jnp.stack([jnp.linalg.norm(s.forces.friction, axis=-1) for s in states], axis=-1)
    count = jnp.stack([stage.present_roller_count for stage in stages])
    rubs = (friction > 0) & moves[:, None]
    rate = jnp.where(rubs, friction, 1.0) * (count * drive**2)[None, :]
    return jnp.where(rubs, problem.inertia[None, :] * slip / rate, 0.0)
