"""Forces under a prescribed torque with carriers at any speed.

Each carrier is described in one of two ways. In step with the screw, its motion is given by the
tangent `t = s/(q Ω)` of its slip, with the slip's part s along d and the remaining part q Ω, which
depends on the screw speed alone: the direction of slip is then regular through standstill, where ω
and Ω vanish together. Coasting, while the screw is at or near standstill and the carrier is not,
its motion is given by its speed: slip is then not small, and its direction is regular.

While the screw is held, friction that jumps with the sense of turning lies between its values at
the onset of turning backward and forward. The unknown is its share, from −1 to 1, that balances the
torque.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...fields import Scalar
from ...numerics import find_root, root_or_zero, solve_small, sum_few
from ...programs import physics
from .._kinematics import travel_per_radian
from ..forces import Motion, StageState, carrier_drives, chain_forces, reduced_stage, sliding_motion
from ..friction import has_contact_losses
from ..steady import find_roots, steady_motion
from ._torque_balance import (
    BACKWARD,
    FORWARD,
    STICKING,
    ScrewMotion,
    TorqueProblem,
    axial_residuals,
    first_unknowns,
    shares_of,
)


class Turning(NamedTuple):
    """Rotation of screw over roller and roller over nut: speeds over the screw's, or senses."""

    screw: Float[Array, " stages"]
    nut: Float[Array, " stages"]


class Carriers(eqx.Module):
    """Motion of the carriers; `coasts` tells which of the two numbers of a stage applies."""

    coasts: Bool[Array, " stages"]
    #: t of stages in step with the screw.
    tangent: Float[Array, " stages"]
    #: Speed of carriers that coast [rad/s].
    speed: Float[Array, " stages"]
    #: Senses of turning of stages in step, relative to that of the screw: +1, or −1 where a carrier
    #: still turns against the screw. `None` where nothing resists turning.
    senses: Turning | None = None


#: Shares of the normal force that carry axially, where they are unknown (`unknown_shares`).
Shares = dict[int, Scalar]


class Driven(NamedTuple):
    """Forces of all stages, and the accelerations that follow."""

    states: tuple[StageState, ...]
    load: Scalar
    #: Of the screw, and of every carrier [rad/s²].
    acceleration: Scalar
    carriers: Float[Array, " stages"]
    converged: Bool[Array, ""]


class SlipGeometry(eqx.Module):
    """Slip of all stages per radian of screw turn, and ∂/∂ω of its part along d [m]."""

    along: Float[Array, " stages"]
    across: Float[Array, " stages"]
    drive: Float[Array, " stages"]

    def ratio(self, tangent: Float[Array, " stages"]) -> Float[Array, " stages"]:
        """Carrier ratios ω/Ω at tangents."""
        return (self.along - tangent * self.across) / self.drive

    def tangent(self, ratio: Float[Array, " stages"]) -> Float[Array, " stages"]:
        """Tangents at carrier ratios ω/Ω."""
        return (self.along - ratio * self.drive) / self.across


def slip_geometry(problem: TorqueProblem) -> SlipGeometry:
    """Slip geometry of all stages."""
    each = [reduced_stage(kinematics) for kinematics in problem.kinematics]
    return SlipGeometry(
        along=jnp.stack([stage.along for stage in each]),
        across=jnp.stack([stage.across for stage in each]),
        drive=jnp.stack([stage.drive for stage in each]),
    )


def resists_turning(problem: TorqueProblem) -> list[bool]:
    """Whether losses besides thread friction resist the rollers, by stage."""
    return [has_contact_losses(stage.friction) for stage in problem.mechanism.stages]


def turning_over(problem: TorqueProblem, ratio: Float[Array, " stages"]) -> Turning:
    """Speeds of turning over the screw's at carrier ratios, `1 + (n − 1) ζ` and `(n − 1) ζ`.

    The resistance to turning changes its sign with them.
    """
    rolling = jnp.stack([k.relative_spin_ratio for k in problem.kinematics]) * ratio
    return Turning(1 + rolling, rolling)


@physics("driven_carriers")
def _forces(
    problem: TorqueProblem,
    time: Scalar,
    screw: ScrewMotion,
    sense: Scalar,
    carriers: Carriers,
    shares: Shares,
) -> tuple[tuple[StageState, ...], Scalar]:
    """Forces of all stages, and the load; `sense` is the share while the screw is held."""
    mechanism, kinematics = problem.mechanism, problem.kinematics
    travel = travel_per_radian(mechanism.stages, len(mechanism.stages))
    load = problem.scenario.load_at(
        time,
        problem.scenario.initial_position + travel * screw.angle,
        travel * screw.speed,
        travel * screw.acceleration,
    )

    ratios = slip_geometry(problem).ratio(carriers.tangent)

    def motion_of(index: int, flank_sign: Scalar, _, axial_acceleration) -> Motion:
        geometry, share = kinematics[index], shares.get(index)
        speed = flank_sign * screw.speed
        in_step = steady_motion(
            geometry, ratios[index], speed, flank_sign * sense, axial_acceleration, share
        )
        if carriers.senses is not None:
            senses = tuple(flank_sign * sense * one[index] for one in carriers.senses)
            in_step = eqx.tree_at(lambda m: (m.screw_sense, m.nut_sense), in_step, senses)
        coasting = sliding_motion(
            geometry, speed, flank_sign * carriers.speed[index], axial_acceleration, share=share
        )
        return jax.tree.map(
            lambda one, other: jnp.where(carriers.coasts[index], one, other), coasting, in_step
        )

    states = chain_forces(
        mechanism, kinematics, motion_of, screw.speed, sense, load, screw.acceleration
    )
    return states, load


@eqx.filter_jit
def driven(
    problem: TorqueProblem,
    time: Scalar,
    angle: Scalar,
    speed: Scalar,
    mode: Scalar,
    carriers: Carriers,
) -> Driven:
    """Motion under the applied torque; in the mode `STICKING` the screw is held.

    **Arguments:**

    - `problem`, `time`: the scene.
    - `angle`, `speed`: of the screw [rad], [rad/s].
    - `mode`: +1, −1, or 0.
    - `carriers`: their motion.
    """
    turns = mode != STICKING
    applied, scale = problem.scenario.torque_at(time), problem.torque_scale
    unit = scale / problem.total_inertia

    def at(unknowns):
        acceleration = jnp.where(turns, unknowns[0] * unit, 0.0)
        sense = jnp.where(turns, mode, unknowns[0])
        screw = ScrewMotion(angle, speed, acceleration)
        shares = shares_of(problem, unknowns)
        return _forces(problem, time, screw, sense, carriers, shares), acceleration

    def residual(unknowns):
        (states, _), _ = at(unknowns)
        return jnp.stack(
            [(states[0].screw.drive_torque - applied) / scale, *axial_residuals(states)]
        )

    # Linear in the acceleration except for changes of flanks, the moduli in the friction of splines
    # and thrust bearings, and losses in the contact ellipses.
    begin = jnp.zeros_like(speed)
    shares = first_unknowns(problem)[len(problem.kinematics) :]
    if shares.size:
        # At a zero share of friction the spin is unknown, so the search starts at 0.5.
        begin = jnp.where(turns, begin, 0.5)
        unknowns, converged = find_roots(
            residual,
            jnp.concatenate([begin[None], shares]),
            tolerance=_accuracy(speed),
            max_steps=30,
        )
    else:
        accuracy = 1e-13 if speed.dtype == jnp.float64 else 1e-5
        unknown, converged = find_root(
            lambda x: residual(x[None])[0], begin, tolerance=accuracy, max_steps=30
        )
        unknowns = unknown[None]
    (states, load), acceleration = at(unknowns)
    carrier_acceleration = carrier_drives(states) / problem.inertia
    carrier_acceleration = jnp.where(turns | carriers.coasts, carrier_acceleration, 0.0)
    return Driven(states, load, acceleration, carrier_acceleration, converged)


def _out_of_balance(
    problem: TorqueProblem,
    states: tuple[StageState, ...],
    acceleration: Scalar,
    sense: Scalar,
    carriers: Carriers,
) -> Float[Array, " stages"]:
    """Residuals, zero where carriers in step keep their ratio, `N f·d − resistance = I ζ Ω̇`.

    Nearly linear in the tangents: a slip of tangent t has the share `t/√(1 + t²)` of friction
    along d.
    """
    geometry = slip_geometry(problem)
    needed = problem.inertia * geometry.ratio(carriers.tangent) * acceleration
    excess = sense * (carrier_drives(states) - needed)
    square = jnp.stack([sum_few(state.forces.friction**2) for state in states])
    friction = root_or_zero(square)
    count = jnp.stack([stage.present_roller_count for stage in problem.mechanism.stages])
    largest = count * friction * geometry.drive
    scale = jax.lax.stop_gradient(largest + problem.inertia * jnp.abs(acceleration))
    # Without drive and resistance any ratio is in balance: that of free rolling is taken.
    idle = scale == 0
    residual = jnp.sqrt(1 + carriers.tangent**2) * excess / jnp.where(idle, 1.0, scale)
    return jnp.where(carriers.coasts | idle, carriers.tangent, residual)


def _accuracy(value: Scalar) -> float:
    return 1e-9 if value.dtype == jnp.float64 else 1e-4


@eqx.filter_jit
def leaving(
    problem: TorqueProblem,
    time: Scalar,
    angle: Scalar,
    speed: Scalar,
    mode: Scalar,
    carriers: Carriers,
) -> tuple[Float[Array, " stages"], Bool[Array, ""]]:
    """Tangents at which carriers keep a constant ratio to a turning screw, and whether they exist.

    From rest carriers start in this ratio at once: until the speeds grow, only the directions of
    slip matter, and any other ratio settles immediately. The balance has to be stable. If the screw
    is braked there is always a second balance, with carriers that turn against it, which is
    unstable. Where friction cannot brake the carriers as hard as the screw is braked, that second
    balance is the only one.
    """
    applied, scale = problem.scenario.torque_at(time), problem.torque_scale
    unit = scale / problem.total_inertia

    def residual(unknowns):
        acceleration = unknowns[0] * unit
        moved = eqx.tree_at(lambda c: c.tangent, carriers, unknowns[1 : 1 + count])
        screw = ScrewMotion(angle, speed, acceleration)
        states, _ = _forces(problem, time, screw, mode, moved, shares_of(problem, unknowns))
        torque = (states[0].screw.drive_torque - applied) / scale
        balance = _out_of_balance(problem, states, acceleration, mode, moved)
        return jnp.stack([torque, *balance, *axial_residuals(states)])

    count = len(problem.kinematics)
    start = jnp.concatenate([jnp.zeros_like(speed)[None], first_unknowns(problem)])
    unknowns, converged = find_roots(residual, start, tolerance=_accuracy(speed), max_steps=40)
    return unknowns[1 : 1 + count], converged & _attracts(residual, unknowns, count)


def _attracts(residual, unknowns: Float[Array, " unknowns"], count: int) -> Bool[Array, ""]:
    """Whether a balance is stable: the residual of each carrier grows with its tangent.

    The acceleration of the screw, and shares of normal forces, follow the tangents at once. Only
    each carrier's own derivative counts: those by the others are due to the friction of splines and
    thrust bearings alone.
    """
    slopes = jax.jacfwd(residual)(jax.lax.stop_gradient(unknowns))
    own, size = slice(1, 1 + count), unknowns.size
    others = jnp.asarray([0, *range(1 + count, size)])
    followed = slopes[others][:, others], slopes[others][:, own]
    effect = jax.vmap(solve_small(followed[0]), in_axes=-1, out_axes=-1)(followed[1])
    reduced = slopes[own, own] - slopes[own][:, others] @ effect
    return jnp.all(jnp.diagonal(reduced) > 0)


@eqx.filter_jit
def onsets(
    problem: TorqueProblem, time: Scalar, angle: Scalar, carriers: Carriers
) -> tuple[tuple[StageState, ...], Float[Array, "2"]]:
    """Forces of all stages, and the load, at the onset of turning from rest in both senses.

    Some carriers may coast; the tangents of the others are solved for.

    **Returns:** the results of `_forces`, with a first axis: turning backward, and forward.
    """
    zero = jnp.zeros_like(angle)
    at_rest, count = ScrewMotion(angle, zero, zero), len(problem.kinematics)

    def forces(sense, unknowns):
        moved = eqx.tree_at(lambda c: c.tangent, carriers, unknowns[:count])
        shares = shares_of(problem, unknowns)
        return moved, _forces(problem, time, at_rest, sense, moved, shares)

    def onset(sense):
        def residual(unknowns):
            moved, (states, _) = forces(sense, unknowns)
            balance = _out_of_balance(problem, states, zero, sense, moved)
            return jnp.stack([*balance, *axial_residuals(states)])

        unknowns = first_unknowns(problem)
        # Where nothing resists the rollers the slip depends on geometry alone.
        if any(resists_turning(problem)) or unknowns.size > count:
            unknowns, _ = find_roots(residual, unknowns, tolerance=_accuracy(angle), max_steps=30)
        return forces(sense, unknowns)[1]

    # One program for both senses.
    return jax.vmap(onset)(jnp.asarray([BACKWARD, FORWARD], angle.dtype))


def onset_torques(
    problem: TorqueProblem, time: Scalar, angle: Scalar, carriers: Carriers
) -> Float[Array, "2"]:
    """Torques at which a screw at rest begins to turn backward and forward [N·m].

    As `breakaway_torques`, with some of the carriers coasting.
    """
    return onsets(problem, time, angle, carriers)[0][0].screw.drive_torque
