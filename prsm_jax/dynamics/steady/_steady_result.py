"""Result of a steady state, and what its codes mean."""

import dataclasses
from typing import Annotated, Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ...fields import In, Scalar
from ...numerics import sum_few
from ...programs import listed
from ...results import DesignResult, lines_of, outcome
from ...text import Line

#: By code. Self-locking and a load that sinks are valid states; the others have no valid steady
#: state.
_MEANINGS = (
    "successful",
    "self-locking: the load alone does not keep up this motion, and the motor must drive in the "
    "direction of the load; for back-driving, lower the friction or raise the lead (quantity "
    "self_locking_margin)",
    "jammed: thread friction cancels the axial part of the normal force, and no torque moves the "
    "load; lower the friction or raise the contact angle (quantity jamming_margin)",
    "no balance: thread friction cannot drive the carriers against their losses, or hold those of "
    "a differential roller screw against the load; raise it, or lower the friction of spin and "
    "rolling",
    "no meshing: screw and roller do not touch with a common normal; check lead, contact angle "
    "and profile radius",
    "impossible dimension: lead and radii must be more than 0, starts within the range of the type "
    "(more than 2 in a standard roller screw), the contact angle between 0 and 90 deg, and bores "
    "narrower than their bodies (prsm_jax.check names it)",
    "overlapping rollers: neighbouring rollers have no room; use fewer, or a larger ratio of nut "
    "to roller radius",
    "not finite: a number of the mechanism, the speed or the load is NaN or infinite, or so large "
    "that a result is not finite; correct it",
    "sinking load: the rollers slip so fast under the load that the nut moves with it, against the "
    "travel that the screw drives; motor and load both feed the friction, and there is no "
    "efficiency; raise the friction of the threads or the speed, or lower the load",
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
    "sinking_load",
)
JAMMED, NO_BALANCE, IMPOSSIBLE, OVERLAPPING, NOT_FINITE, SINKING = 2, 3, 5, 6, 7, 8


def steady_meaning(name: str) -> str:
    """Meaning of a name of `STEADY_RESULTS`, with the remedy."""
    return _MEANINGS[STEADY_RESULTS.index(name)]


class SteadyState(DesignResult):
    """Steady operating point of a mechanism; arrays run over the stages.

    `efficiency` is output power over input power. The output is that of the load when the body that
    turns drives, and that of this body when the load drives it back (then negative if
    self-locking).
    """

    #: Output power over input power [1].
    efficiency: Annotated[Scalar, In("1")]
    #: Speed of the body that turns: first screw, or nut of an inverted roller screw [rad/s].
    screw_speed: Annotated[Scalar, In("rad/s")]
    #: ω/Ω of each stage.
    carrier_ratio: Annotated[Float[Array, " stages"], In("1")]
    #: Torque at the same body [N·m].
    drive_torque: Annotated[Scalar, In("N·m")]
    #: Normal force of the body that turns on one roller, all its threads together [N].
    contact_force: Annotated[Float[Array, " stages"], In("N")]
    #: Axial part of it [N].
    screw_roller_axial_force: Annotated[Float[Array, " stages"], In("N")]
    #: Load on each nut [N].
    nut_load: Annotated[Float[Array, " stages"], In("N")]
    #: Slip speed of the body that turns over the roller [m/s].
    slip_speed: Annotated[Float[Array, " stages"], In("m/s")]
    #: Unit vector of that slip, in the carrier's frame: radial, tangential, axial; at standstill
    #: that of impending motion.
    slip_direction: Float[Array, "stages 3"]
    #: Tooth force of the ring gear, and force of the carrier's pin, at one of the two ends of one
    #: roller [N].
    ring_gear_force: Annotated[Float[Array, " stages"], In("N")]
    carrier_force: Annotated[Float[Array, " stages"], In("N")]
    #: Axial friction force of the spline of each screw that moves along the axis [N].
    spline_friction: Annotated[Float[Array, " stages"], In("N")]
    #: Power of each modelled loss [W].
    losses: Annotated[dict[str, Scalar], In("W")]
    #: Of the body that drives, and of the one that is driven [W].
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
        """Whether `efficiency` is one: a locked or jammed thread and a sinking load have none."""
        return self.code is None or int(self.code) in (0, OVERLAPPING)

    @property
    def computed(self) -> Bool[Array, "*batch"]:
        """Whether motion and forces are known, even if the rollers overlap."""
        if self.code is None:
            return self.valid
        known = jnp.isfinite(self.drive_torque) & jnp.isfinite(self.efficiency)
        known = known & jnp.isfinite(self.carrier_ratio + self.contact_force).all(axis=-1)
        solved = (self.code <= 1) | (self.code >= IMPOSSIBLE)
        return known & (solved if self.solved is None else solved & self.solved)


def marked(state: SteadyState, given: Any) -> SteadyState:
    """The state with the code of non-finite numbers, where no other code explains them.

    No carrier is in balance under `given` numbers that are not finite, which explains it.
    """
    assert state.code is not None
    finite = _is_finite(state)
    unexplained = (state.code <= JAMMED) & ~finite
    unexplained = unexplained | ((state.code <= NO_BALANCE) & ~_is_finite(given))
    code = jnp.where(unexplained, NOT_FINITE, state.code)
    return dataclasses.replace(state, valid=state.valid & finite & (code != NOT_FINITE), code=code)


def _is_finite(tree: Any) -> Bool[Array, ""]:
    numbers = [x for x in jax.tree.leaves(tree) if eqx.is_inexact_array(x)]
    # 0 times NaN or infinity is NaN; a verdict has no derivative.
    zeros = [sum_few(0.0 * jnp.ravel(jax.lax.stop_gradient(x))) for x in numbers]
    return jnp.isfinite(sum(zeros))
