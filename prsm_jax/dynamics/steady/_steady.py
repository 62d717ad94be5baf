"""Steady state, without integration."""

import dataclasses
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ...contact import load_of, speed_of
from ...fields import Scalar
from ...geometry import dimensions_possible, rollers_fit
from ...mechanism import Mechanism, of_one_design
from ...numerics import above_or_nan, apart, length_few
from ...programs import one_program, physics
from .._kinematics import StageKinematics, stage_kinematics, travel_per_radian, travel_share
from ..forces import (
    Motion,
    StageState,
    chain_forces,
    forces_by_stage,
    losses,
    roller_support_forces,
    screw_forces,
)
from ..friction import turned, with_resistance
from ._carrier_balance import balanced_carrier_ratio
from ._steady_result import (
    IMPOSSIBLE,
    JAMMED,
    NO_BALANCE,
    OVERLAPPING,
    SINKING,
    SteadyState,
    marked,
)
from ._two_sliding_sides import (
    losses_of_both_sides,
    pin_force,
    torque_on_screw,
    two_sliding_sides,
)
from ._unloaded import proportional_to_load, scaled, some_load, unit_load, without_traces


def _steady_states(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    speed: Scalar,
    sense: Scalar,
    load: Scalar,
) -> tuple[tuple[StageState, ...], list[Scalar], Int[Array, ""], Bool[Array, ""]]:
    """States and carrier ratios of all stages, the result code, and whether forces balance.

    An impossible dimension comes first in the code, which then hides that forces do not balance.
    """
    # By stage: where the flank depends on the motion, the chain asks for the motion twice.
    ratios: dict[int, Scalar] = {}
    converged: dict[int, Bool[Array, ""]] = {}
    # Otherwise every use of a number of the balance would compute the balance again.
    balanced_ratio = apart(balanced_carrier_ratio)
    balanced = pushed = jnp.asarray(True)
    meshed = jnp.stack([k.meshing.converged for k in kinematics]).all()

    def motion_of(index: int, flank_sign: Scalar, axial_force: Scalar, _) -> Motion:
        stage, geometry = mechanism.stages[index], kinematics[index]
        own_speed, own_sense = flank_sign * speed, flank_sign * sense
        balance = balanced_ratio(stage, geometry, own_sense, own_speed, axial_force)
        converged[index], ratios[index] = balance.converged, balance.ratio
        return balance.motion(geometry, own_speed, own_sense)

    states = chain_forces(mechanism, kinematics, motion_of, speed, sense, load)
    for index, state in enumerate(states):
        balanced = balanced & converged[index]
        # Beyond jamming the axial balance requires a contact that pulls.
        pushed = pushed & above_or_nan(state.forces.contact_force)
    code, solved = _code(mechanism, meshed, pushed, balanced)
    return states, [ratios[index] for index in range(len(states))], code, solved


def _code(
    mechanism: Mechanism,
    meshed: Bool[Array, ""],
    pushed: Bool[Array, ""],
    balanced: Bool[Array, ""],
) -> tuple[Int[Array, ""], Bool[Array, ""]]:
    """The result code, and whether forces balance."""
    code = jnp.where(meshed, jnp.where(pushed, jnp.where(balanced, 0, NO_BALANCE), JAMMED), 4)
    solved = code == 0
    stages = mechanism.stages
    fit = jnp.stack([rollers_fit(stage) for stage in stages]).all()
    possible = jnp.stack([dimensions_possible(stage) for stage in stages]).all()
    code = jnp.where((code == 0) & ~fit, OVERLAPPING, code)
    # This takes precedence: with a negative lead the other checks may pass.
    return jnp.where(possible, code, IMPOSSIBLE), solved


def all_kinematics(mechanism: Mechanism) -> tuple[StageKinematics, ...]:
    """Kinematics of every stage, compiled as a separate part of a larger program."""
    # Derivatives of an efficiency would compute the meshing anew for each of them.
    return apart(_of_every_stage)(mechanism)


def _of_every_stage(mechanism: Mechanism) -> tuple[StageKinematics, ...]:
    return tuple(stage_kinematics(stage) for stage in mechanism.stages)


@of_one_design
@one_program
@physics("steady_state")
def steady_state(
    mechanism: Mechanism,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    kinematics: tuple[StageKinematics, ...] | None = None,
    *,
    onset: float | Scalar = 1.0,
) -> SteadyState:
    """Steady state at a prescribed screw speed and load, in closed form.

    The carrier speed follows from f·d = 0, which is linear in it, and depends on geometry alone.
    Losses inside the contact ellipses, where modelled, shift it slightly. Forces then follow stage
    by stage from the load, and the efficiency is `F_n Σ L / (2π M)`, or its inverse when the load
    drives. Where the nut has grooves the load drives the carriers as well, and their speed, with it
    the travel per turn, depends on friction. Where rollers slide in the nut too, their own rotation
    is a second unknown. At speed 0 the slip direction is that of impending motion: torque and
    efficiency are those of slow turning in their limit, and not the torque that holds the load.

    A negative load is carried by the opposite flanks.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `speed`: screw speed [rad/s]; negative with a positive load is back-driving, and without a
      load the screw drives in either direction. Default: that of the operating point.
    - `load`: axial load on the last nut [N]. Default: that of the operating point.
    - `kinematics`: kinematics of the stages, if known already.
    - `onset`: what moves the screw at standstill, and without a load: 1, the screw drives; −1, the
      load is about to drive it back.

    **Raises:** `MissingDataError` if speed, load, or data for a modelled loss are not given.
    """
    speed, load = speed_of(mechanism, speed), load_of(mechanism, load)
    if kinematics is None:
        kinematics = all_kinematics(mechanism)
    kinematics = with_resistance(mechanism.stages, kinematics)
    given = (speed, load, [stage.friction for stage in mechanism.stages])
    onset_sense = jnp.where(load < 0, -onset, onset).astype(load.dtype)
    sense = jnp.where(speed == 0, onset_sense, jnp.sign(speed))
    sense = jax.lax.stop_gradient(sense)
    # A load in place of 0 acts against the motion if the screw drives, and with it if not.
    sign, factor = onset * sense, None
    if proportional_to_load(mechanism):
        load, factor = unit_load(load, sign)
    else:
        load = some_load(load, sign)

    if mechanism.stages[-1].thread.family.carrying is None:
        two = _of_two_sides(mechanism, kinematics, speed, sense, load, factor)
        return marked(_assembled(two, speed, load, factor, given[1]), given)
    states, ratios, code, solved = _steady_states(mechanism, kinematics, speed, sense, load)
    torque = states[0].screw.drive_torque
    if factor is not None:
        states = tuple(_scaled_state(state, factor) for state in states)
    travel = travel_per_radian(mechanism.stages, len(mechanism.stages))
    share = travel_share(mechanism.stages[-1].thread, ratios[-1])
    if share is not None:
        travel = travel * share
        # Of a differential roller screw the slip under the load can exceed the travel.
        sinks = (sense * load > 0) & (travel < 0)
        code = jnp.where((code == 0) & sinks, SINKING, code)
    loss_powers = losses(mechanism, kinematics, states, speed)
    supports = [
        roller_support_forces(stage, geometry, state, None)
        for stage, geometry, state in zip(mechanism.stages, kinematics, states, strict=True)
    ]
    solution = _Solution(
        torque=torque,
        travel=travel,
        losses=loss_powers,
        carrier_ratio=jnp.stack(ratios),
        nut_load=jnp.stack([s.nut_load for s in states]),
        slip_speed=jnp.stack([length_few(s.motion.slip) for s in states]),
        forces=forces_by_stage(kinematics, states, supports),
        sense=sense,
        code=code,
        solved=solved,
    )
    return marked(_assembled(solution, speed, load, factor, given[1]), given)


def _scaled_state(state: StageState, factor: Scalar) -> StageState:
    """The same motion with all forces times a factor."""
    forces = scaled((state.forces, state.screw, state.nut_load), factor)
    return StageState(state.motion, *forces, state.flank_sign)


class _Solution(NamedTuple):
    """What the steady state of any type of roller screw is assembled from.

    Forces are those under the given load; `torque` is that under the load of `unit_load`, if forces
    are proportional to the load.
    """

    torque: Scalar
    #: Travel of the last nut per radian of the screw [m/rad].
    travel: Scalar
    losses: dict[str, Scalar]
    carrier_ratio: Float[Array, " stages"]
    nut_load: Float[Array, " stages"]
    slip_speed: Float[Array, " stages"]
    #: Results of all stages by name, as `forces_by_stage` gives them.
    forces: dict[str, Array]
    sense: Scalar
    code: Int[Array, ""]
    solved: Bool[Array, ""]


def _of_two_sides(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    speed: Scalar,
    sense: Scalar,
    load: Scalar,
    factor: Scalar | None,
) -> _Solution:
    """Steady motion of rollers that slide on both sides; such a roller screw has one stage."""
    (stage,), (geometry,) = mechanism.stages, kinematics
    count = stage.present_roller_count
    flank = jnp.where(load < 0, -1.0, 1.0).astype(load.dtype)
    sides = two_sliding_sides(stage, geometry, flank * speed, flank * sense, flank * load)
    moment = flank * torque_on_screw(geometry, count, sides.screw)
    screw = screw_forces(stage, moment, load, speed, sense, None, None, None, None)
    torque = screw.drive_torque
    # Before forces vanish with the load.
    pushed = above_or_nan(sides.screw.force) & above_or_nan(sides.nut.force)
    if factor is not None:
        sides, screw, load = sides.scaled(factor), scaled(screw, factor), factor * load
    powers = losses_of_both_sides(stage, sides.screw, sides.nut, screw, speed)
    zero, force = jnp.zeros_like(load), sides.screw.force
    rows = {
        "contact_force": force,
        "screw_roller_axial_force": -force * geometry.meshing.screw.normal[2],
        "ring_gear_force": zero,
        "carrier_force": pin_force(stage, sides, speed),
        "spline_friction": zero,
        "slip_direction": turned(sides.screw.direction, flank),
    }
    code, solved = _code(mechanism, geometry.meshing.converged, pushed, sides.converged)
    return _Solution(
        torque=torque,
        travel=travel_per_radian(mechanism.stages, 1),
        losses=powers,
        carrier_ratio=sides.carrier_ratio[None],
        nut_load=load[None],
        slip_speed=length_few(sides.screw.slip)[None],
        forces={name: row[None] for name, row in rows.items()},
        sense=sense,
        code=code,
        solved=solved,
    )


#: Numbers in which a load in place of 0 leaves traces.
_OF_FORCES = (
    *("efficiency", "drive_torque", "nut_load", "contact_force", "screw_roller_axial_force"),
    *("ring_gear_force", "carrier_force", "spline_friction", "input_power", "output_power"),
)


def _assembled(
    solution: _Solution, speed: Scalar, load: Scalar, factor: Scalar | None, as_given: Scalar
) -> SteadyState:
    """The steady state, with efficiency and power balance, under a load and as it was given."""
    torque, travel, sense, code = solution.torque, solution.travel, solution.sense, solution.code
    forward = sense * load > 0
    useful, driving = (
        jnp.where(forward, load * travel, torque),
        jnp.where(forward, torque, load * travel),
    )
    efficiency = useful / driving
    if factor is not None:
        torque, load = factor * torque, factor * load
    drive_power, load_power = torque * speed, load * travel * speed
    largest_power = jnp.maximum(jnp.abs(drive_power), jnp.abs(load_power))
    imbalance = drive_power - load_power - sum(solution.losses.values())
    state = SteadyState(
        efficiency=efficiency,
        carrier_ratio=solution.carrier_ratio,
        drive_torque=torque,
        nut_load=solution.nut_load,
        screw_speed=speed,
        slip_speed=solution.slip_speed,
        **solution.forces,
        losses=solution.losses,
        input_power=jnp.where(forward, drive_power, -load_power),
        output_power=jnp.where(forward, load_power, -drive_power),
        power_balance_residual=jnp.abs(imbalance)
        / jnp.where(largest_power > 0, largest_power, 1.0),
        valid=(code == 0) | (code == SINKING),
        solved=solution.solved,
        code=jnp.where((code == 0) & ~forward & (efficiency < 0), 1, code),
    )
    if factor is not None:
        return state
    clean = {name: without_traces(getattr(state, name), as_given) for name in _OF_FORCES}
    losses = {name: without_traces(power, as_given) for name, power in state.losses.items()}
    return dataclasses.replace(state, **clean, losses=losses)
