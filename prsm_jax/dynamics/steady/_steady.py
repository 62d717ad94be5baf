"""Steady state, without integration."""

import dataclasses
from typing import Annotated, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ...contact import load_of, speed_of
from ...fields import In, Scalar
from ...geometry import dimensions_possible, rollers_fit
from ...mechanism import Mechanism, of_one_design
from ...numerics import above_or_nan, apart, length_few, sum_few
from ...programs import listed, one_program, physics
from ...results import DesignResult, lines_of, outcome
from ...text import Line
from .._kinematics import StageKinematics, stage_kinematics, travel_per_turn, travel_share
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
from ._two_sliding_sides import (
    losses_of_both_sides,
    pin_force,
    torque_on_screw,
    two_sliding_sides,
)

#: Load in place of 0, too small to change anything but ratios: efficiency is then its limit [N].
_NO_LOAD = 1e-30
#: Smaller loads count as 0: their squares underflow [N].
_LEAST_LOAD = 1e-100


#: By code. Self-locking is a valid state; the others have no valid steady state.
_MEANINGS = (
    "successful",
    "self-locking: the load alone causes no motion, and the motor must drive in the direction of "
    "the load; for back-driving, lower friction or contact angle (quantity self_locking_margin)",
    "jammed: thread friction cancels the axial part of the normal force, and no torque moves the "
    "load; lower the friction or raise the contact angle (quantity jamming_margin)",
    "no balance: thread friction cannot drive the carriers against their losses; raise it, or "
    "lower the friction of spin and rolling",
    "no meshing: screw and roller do not touch with a common normal; check lead, contact angle "
    "and profile radius",
    "impossible dimension: lead and radii must be more than 0, starts more than 2, the contact "
    "angle between 0 and 90 deg, and bores narrower than their bodies (prsm_jax.check names it)",
    "overlapping rollers: neighbouring rollers have no room; use fewer or smaller ones",
    "not finite: a number of the mechanism, the speed or the load is NaN or infinite, or so large "
    "that a result is not finite; correct it",
)
#: The same as names, by code.
STEADY_RESULTS = (
    "successful",
    "self_locking",
    "jammed",
    "no_balance",
    "no_meshing",
    "impossible_dimension",
    "overlapping_rollers",
    "not_finite",
)
JAMMED, _IMPOSSIBLE, _OVERLAPPING, _NOT_FINITE = 2, 5, 6, 7


def steady_meaning(name: str) -> str:
    """Meaning of a name of `STEADY_RESULTS`, with the remedy."""
    return _MEANINGS[STEADY_RESULTS.index(name)]


class SteadyState(DesignResult):
    """Steady operating point of a mechanism; arrays run over the stages.

    `efficiency` is output power over input power. The output is that of the nut when the screw
    drives, and that of the screw when the load drives it back (then negative if self-locking).
    """

    efficiency: Annotated[Scalar, In("1")]
    #: Screw speed [rad/s].
    screw_speed: Annotated[Scalar, In("rad/s")]
    #: ω/Ω of each stage.
    carrier_ratio: Annotated[Float[Array, " stages"], In("1")]
    #: Torque at the first screw [N·m].
    drive_torque: Annotated[Scalar, In("N·m")]
    #: Normal force of the screw on one roller, all its threads together [N].
    contact_force: Annotated[Float[Array, " stages"], In("N")]
    #: Axial part of it [N].
    screw_roller_axial_force: Annotated[Float[Array, " stages"], In("N")]
    #: Load on each nut [N].
    nut_load: Annotated[Float[Array, " stages"], In("N")]
    #: Slip speed of the screw over the roller [m/s].
    slip_speed: Annotated[Float[Array, " stages"], In("m/s")]
    #: Unit vector of the slip of the screw over the roller, in the carrier's frame: radial,
    #: tangential, axial; at standstill that of impending motion.
    slip_direction: Float[Array, "stages 3"]
    ring_gear_force: Annotated[Float[Array, " stages"], In("N")]
    carrier_force: Annotated[Float[Array, " stages"], In("N")]
    spline_friction: Annotated[Float[Array, " stages"], In("N")]
    #: Power of each modelled loss [W].
    losses: Annotated[dict[str, Scalar], In("W")]
    input_power: Annotated[Scalar, In("W")]
    output_power: Annotated[Scalar, In("W")]
    #: |input − output − losses| / input.
    power_balance_residual: Annotated[Scalar, In("1")]
    #: False where the meshing has no solution, a thread jams, the carrier cannot turn, no such
    #: mechanism can be built (a dimension out of range, rollers that overlap), or a number here is
    #: NaN or infinite.
    valid: Bool[Array, ""]
    #: 0 when all is well; see `result`.
    code: Int[Array, ""] | None = None
    #: Whether the threads mesh and all forces balance, whatever else `code` names.
    solved: Bool[Array, ""] | None = None

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch that this steady state is of; empty for a single design."""
        return self.efficiency.shape

    def lines(self) -> list[Line]:
        """What `print` shows."""
        return [outcome(self.code, STEADY_RESULTS), *lines_of(self)]

    @property
    @listed
    def result(self) -> str:
        """Meaning of `code`, with the remedy."""
        return _MEANINGS[0 if self.code is None else int(self.code)]

    @property
    @listed
    def result_name(self) -> str:
        """`result` as one name: `successful`, `self_locking`, `jammed`, …"""
        return STEADY_RESULTS[0 if self.code is None else int(self.code)]

    @property
    @listed
    def has_efficiency(self) -> bool:
        """Whether `efficiency` is one: a locked or jammed thread has none."""
        return self.code is None or int(self.code) in (0, _OVERLAPPING)

    @property
    def computed(self) -> Bool[Array, "*batch"]:
        """Whether motion and forces are known, even if the rollers overlap."""
        if self.code is None:
            return self.valid
        known = jnp.isfinite(self.drive_torque) & jnp.isfinite(self.efficiency)
        known = known & jnp.isfinite(self.carrier_ratio + self.contact_force).all(axis=-1)
        solved = (self.code <= 1) | (self.code >= _IMPOSSIBLE)
        return known & (solved if self.solved is None else solved & self.solved)


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
    ratios: list[Scalar] = []
    # Otherwise every use of a number of the balance would compute the balance again.
    balanced_ratio = apart(balanced_carrier_ratio)
    balanced = pushed = jnp.asarray(True)
    meshed = jnp.stack([k.meshing.converged for k in kinematics]).all()

    def motion_of(index: int, flank_sign: Scalar, axial_force: Scalar, _) -> Motion:
        nonlocal balanced
        stage, geometry = mechanism.stages[index], kinematics[index]
        own_speed, own_sense = flank_sign * speed, flank_sign * sense
        balance = balanced_ratio(stage, geometry, own_sense, own_speed, axial_force)
        balanced = balanced & balance.converged
        ratios.append(balance.ratio)
        return balance.motion(geometry, own_speed, own_sense)

    states = chain_forces(mechanism, kinematics, motion_of, speed, sense, load)
    for state in states:
        # Beyond jamming the axial balance requires a contact that pulls.
        pushed = pushed & above_or_nan(state.forces.contact_force)
    code, solved = _code(mechanism, meshed, pushed, balanced)
    return states, ratios[::-1], code, solved


def _code(
    mechanism: Mechanism,
    meshed: Bool[Array, ""],
    pushed: Bool[Array, ""],
    balanced: Bool[Array, ""],
) -> tuple[Int[Array, ""], Bool[Array, ""]]:
    """The result code, and whether forces balance."""
    code = jnp.where(meshed, jnp.where(pushed, jnp.where(balanced, 0, 3), 2), 4)
    solved = code == 0
    stages = mechanism.stages
    fit = jnp.stack([rollers_fit(stage) for stage in stages]).all()
    possible = jnp.stack([dimensions_possible(stage) for stage in stages]).all()
    code = jnp.where((code == 0) & ~fit, _OVERLAPPING, code)
    # This takes precedence: with a negative lead the other checks may pass.
    return jnp.where(possible, code, _IMPOSSIBLE), solved


def all_kinematics(mechanism: Mechanism) -> tuple[StageKinematics, ...]:
    """Kinematics of every stage, compiled as a separate part of a larger program."""
    # Derivatives of an efficiency would compute the meshing anew for each of them.
    return apart(_of_every_stage)(mechanism)


def _of_every_stage(mechanism: Mechanism) -> tuple[StageKinematics, ...]:
    return tuple(stage_kinematics(stage) for stage in mechanism.stages)


def some_load(load: Scalar) -> Scalar:
    """The load, or in place of 0 a load that is too small to change anything but ratios [N]."""
    unloaded = (load == 0) | (jnp.abs(load) < _LEAST_LOAD)
    return load + jnp.where(unloaded, _NO_LOAD, 0.0).astype(load.dtype)


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
    is a second unknown. At speed 0 the slip direction is that of impending motion.

    A negative load is carried by the opposite flanks.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `speed`: screw speed [rad/s]; negative with a positive load is back-driving. Default: that
      of the operating point.
    - `load`: axial load on the last nut [N]. Default: that of the operating point.
    - `kinematics`: kinematics of the stages, if known already.
    - `onset`: impending motion at standstill: 1, the screw drives; −1, the load drives it back.

    **Raises:** `MissingDataError` if speed, load, or data for a modelled loss are not given.
    """
    speed, load = speed_of(mechanism, speed), load_of(mechanism, load)
    if kinematics is None:
        kinematics = all_kinematics(mechanism)
    kinematics = with_resistance(mechanism.stages, kinematics)
    load = some_load(load)
    onset_sense = jnp.where(load < 0, -onset, onset).astype(load.dtype)
    sense = jnp.where(speed == 0, onset_sense, jnp.sign(speed))
    sense = jax.lax.stop_gradient(sense)

    if mechanism.stages[-1].thread.family.carrying is None:
        return _assembled(_of_two_sides(mechanism, kinematics, speed, sense, load), speed, load)
    states, ratios, code, solved = _steady_states(mechanism, kinematics, speed, sense, load)
    torque = states[0].screw.drive_torque
    travel = travel_per_turn(mechanism.stages, len(mechanism.stages))
    share = travel_share(mechanism.stages[-1].thread, ratios[-1])
    if share is not None:
        travel = travel * share
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
    return _assembled(solution, speed, load)


class _Solution(NamedTuple):
    """What the steady state of any type of roller screw is assembled from."""

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
) -> _Solution:
    """Steady motion of rollers that slide on both sides; such a roller screw has one stage."""
    (stage,), (geometry,) = mechanism.stages, kinematics
    count = stage.present_roller_count
    flank = jnp.where(load < 0, -1.0, 1.0).astype(load.dtype)
    sides = two_sliding_sides(stage, geometry, flank * speed, flank * sense, flank * load)
    moment = flank * torque_on_screw(geometry, count, sides.screw)
    screw = screw_forces(stage, moment, load, speed, sense, None, None, None, None)
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
    pushed = above_or_nan(force) & above_or_nan(sides.nut.force)
    code, solved = _code(mechanism, geometry.meshing.converged, pushed, sides.converged)
    return _Solution(
        torque=screw.drive_torque,
        travel=travel_per_turn(mechanism.stages, 1),
        losses=powers,
        carrier_ratio=sides.carrier_ratio[None],
        nut_load=load[None],
        slip_speed=length_few(sides.screw.slip)[None],
        forces={name: row[None] for name, row in rows.items()},
        sense=sense,
        code=code,
        solved=solved,
    )


def _assembled(solution: _Solution, speed: Scalar, load: Scalar) -> SteadyState:
    """The steady state, with efficiency and power balance."""
    torque, travel, sense, code = solution.torque, solution.travel, solution.sense, solution.code
    forward = sense * load > 0
    useful, driving = (
        jnp.where(forward, load * travel, torque),
        jnp.where(forward, torque, load * travel),
    )
    drive_power, load_power = torque * speed, load * travel * speed
    largest_power = jnp.maximum(jnp.abs(drive_power), jnp.abs(load_power))
    imbalance = drive_power - load_power - sum(solution.losses.values())
    result = SteadyState(
        efficiency=useful / driving,
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
        valid=code == 0,
        solved=solution.solved,
        code=jnp.where((code == 0) & ~forward & (useful / driving < 0), 1, code),
    )
    return _marked(result)


def _marked(state: SteadyState) -> SteadyState:
    """The state with the code of non-finite numbers, where no other code explains them."""
    assert state.code is not None
    numbers = [x for x in jax.tree.leaves(state) if jnp.issubdtype(x.dtype, jnp.inexact)]
    # 0 times NaN or infinity is NaN; a verdict has no derivative.
    zeros = [sum_few(0.0 * jnp.ravel(jax.lax.stop_gradient(x))) for x in numbers]
    finite = jnp.isfinite(sum(zeros))
    unexplained = (state.code <= JAMMED) & ~finite
    code = jnp.where(unexplained, _NOT_FINITE, state.code)
    return dataclasses.replace(state, valid=state.valid & finite, code=code)
