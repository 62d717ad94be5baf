"""Damping ratios of the modes in space by creep friction, to first order."""

from typing import Annotated

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..contact import load_of
from ..fields import In, Scalar
from ..mechanism import Mechanism, of_one_design
from ..programs import listed, mapped, one_program, physics
from ..results import DesignResult, outcome
from ..text import Line
from ..vibration import (
    RIGID_SHARE,
    SpatialModes,
    SpringModes,
    SpringNetwork,
    clusters,
    spatial_harmonic_network,
    spatial_modes,
    spring_modes,
    stage_spatial_system,
)
from ._creep_friction import CreepFriction, creep_friction

#: By code.
_MEANINGS = (
    "successful",
    "no steady state: forces and slip are not those of an operating point; see prsm.steady_state",
    "standstill: the threads do not slide, so creep friction damps nothing; give a speed, or a law "
    "of friction that is smooth at standstill",
    "strong damping: a ratio, or its error of higher order, is above 0.1, so that ratios of first "
    "order are estimates only; give a higher speed, or solve the equations with viscous_matrix",
    "negative damping: friction falls as the slip rises and feeds at least one mode, which is "
    "unstable unless other damping exceeds this; raise the speed, or take a lubricant whose "
    "friction does not fall (static_coefficient, stribeck_speed)",
)
#: The same as names, by code.
DAMPING_RESULTS = (
    "successful",
    "no_steady_state",
    "standstill",
    "strong_damping",
    "negative_damping",
)
#: Ratios and errors of higher order above it are estimates.
_STRONG = 0.1
#: A negative ratio below this is rounding.
_NEGATIVE = -1e-14


class SpatialDamping(DesignResult):
    """Modes of a stage in space, and the damping ratio of each by creep friction."""

    modes: SpatialModes
    creep: CreepFriction
    #: ζ of each mode of `modes.groups`; negative where friction feeds the mode, 0 for a rigid
    #: motion. A repeated root has the mean of its members.
    ratios: Annotated[tuple[Float[Array, " modes"], ...], In("1")]
    #: Estimate of the error of each ratio: what the first correction of the shapes changes.
    errors: Annotated[tuple[Float[Array, " modes"], ...], In("1")]
    #: 0 when all is well; see `result`.
    code: Int[Array, ""]

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of a batch of designs; empty for a single one."""
        return self.code.shape

    @property
    @mapped
    def damping_ratios(self) -> Float[Array, "*batch degrees"]:
        """ζ of each entry of `modes.frequencies`."""
        groups = self.modes.groups
        repeated = [jnp.repeat(g.frequencies, g.multiplicity) for g in groups]
        values = [
            jnp.repeat(z, g.multiplicity) for z, g in zip(self.ratios, groups, strict=True)
        ]
        return jnp.concatenate(values)[jnp.argsort(jnp.concatenate(repeated), stable=True)]

    @property
    @listed
    def result(self) -> str:
        """Meaning of `code`, with the remedy."""
        return _MEANINGS[int(self.code)]

    @property
    @listed
    def result_name(self) -> str:
        """`result` as one name: `successful`, `standstill`, `negative_damping`, …"""
        return DAMPING_RESULTS[int(self.code)]

    def lines(self) -> list[Line]:
        """What `print` shows: frequencies and ratios of each group, and the dashpots."""
        found = [outcome(self.code, DAMPING_RESULTS)]
        for group, ratio in zip(self.modes.groups, self.ratios, strict=True):
            label = group.family.replace("_", " ")
            found += [
                Line(label, group.frequencies, "Hz", most=20),
                Line(f"{label}: damping ratio", ratio, "1", most=20),
            ]
        return [*found, *self.creep.lines()]


def modal_damping(
    modes: SpringModes, dashpots: SpringNetwork
) -> tuple[Float[Array, " modes"], Float[Array, " modes"]]:
    """Damping ratios of first order, and an estimate of their error.

    With mass-normalised shapes `ζ_i = φ_iᴴ C φ_i / 2 ω_i = Σ c |g φ_i|² / 2 ω_i`, a sum over
    dashpots (Lord Rayleigh, The Theory of Sound, section 102). At a repeated root it is the mean
    over its members, the trace of C on their subspace. Damping turns a shape into
    `φ_i + Σ i ω_i C_ji/(ω_j² − ω_i²) φ_j`; the error is what this changes in the quotient
    `qᴴ C q / qᴴ M q`, of which the real part of an eigenvalue is exactly −1/2. It is of second
    order relative to the ratio.

    **Arguments:**

    - `modes`: modes of a network.
    - `dashpots`: with a damping constant for each row in place of a stiffness, of the same degrees
      of freedom.
    """
    omega = modes.angular_frequencies
    elastic = ~(omega <= RIGID_SHARE * jnp.max(omega))
    moved = dashpots.rows @ modes.shapes
    powers = dashpots.stiffness @ (jnp.real(moved) ** 2 + jnp.imag(moved) ** 2)
    together = clusters(modes.eigenvalues)
    members = together.astype(omega.dtype)
    mean = members @ powers / jnp.sum(members, axis=1)
    divisor = jnp.where(elastic, 2 * omega, 1.0)
    ratios = jnp.where(elastic, mean / divisor, 0.0)

    # The estimate only chooses the code: it has no derivative.
    moved, omega, values = jax.lax.stop_gradient((moved, omega, modes.eigenvalues))
    damping = jax.lax.stop_gradient(dashpots.stiffness)[:, None].astype(moved.dtype)
    matrix = moved.conj().T @ (damping * moved)
    gaps = jnp.where(together, 1.0, values[:, None] - values[None, :]).astype(moved.dtype)
    turning = 1j * jnp.where(together, jnp.zeros_like(matrix), omega[None, :] * matrix / gaps)
    turned = jnp.eye(len(omega)) + turning
    energy = jnp.sum(jnp.abs(turned) ** 2, axis=0)
    power = jnp.real(jnp.sum(turned.conj() * (matrix @ turned), axis=0))
    own = jnp.real(jnp.diagonal(matrix))
    change = jnp.where(elastic, (power / energy - own) / jax.lax.stop_gradient(divisor), 0.0)
    return ratios, jnp.abs(change)


def _code(
    creep: CreepFriction,
    ratios: tuple[Float[Array, " modes"], ...],
    errors: tuple[Float[Array, " modes"], ...],
) -> Int[Array, ""]:
    lowest = jnp.min(jnp.stack([jnp.min(ratio) for ratio in ratios]))
    sizes = [jnp.max(jnp.abs(one)) for one in (*ratios, *errors)]
    strong = jnp.max(jnp.stack(sizes)) > _STRONG
    code = jnp.where(lowest < _NEGATIVE, 4, jnp.where(strong, 3, 0))
    return jnp.where(creep.valid, jnp.where(creep.slides, code, 2), 1)


@of_one_design
@one_program
@physics("spatial_damping")
def spatial_damping(
    mechanism: Mechanism,
    *,
    stage: int = 1,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    sticking: bool = True,
    shapes: bool = False,
    motor_held: bool = False,
) -> SpatialDamping:
    """Damping ratios of the modes of `spatial_modal` by friction of the threads that slide.

    The friction of screw and rollers at the operating point is a pair of dashpots at each roller
    (`creep_friction`), equal at all of them, so it keeps the symmetry of the stage and each
    harmonic of the rollers has its own small problem. Ratios are of first order in the damping. No
    other damping is included.

    Jittable, and differentiable by the numbers of the mechanism, speed and load.

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs what `spatial_modal` and `steady_state` need,
      and a law of thread friction.
    - `stage`: which stage, counted from 1.
    - `speed`: screw speed [rad/s]; default that of the operating point.
    - `load`: axial load, for the contact stiffness and for the friction [N]; default that of the
      operating point.
    - `sticking`, `shapes`, `motor_held`: as in `spatial_modal`.

    **Raises:** as `spatial_modal` and `creep_friction`.
    """
    load = load_of(mechanism, load)
    creep = creep_friction(mechanism, stage=stage, speed=speed, load=load)
    system = stage_spatial_system(mechanism, stage, load, sticking=sticking, motor_held=motor_held)
    modes = spatial_modes(system, shapes=shapes)
    found = [
        modal_damping(
            spring_modes(spatial_harmonic_network(system, harmonic)),
            creep.network(system, harmonic),
        )
        for harmonic in range(len(modes.groups))
    ]
    ratios, errors = tuple(r for r, _ in found), tuple(e for _, e in found)
    return SpatialDamping(modes, creep, ratios, errors, _code(creep, ratios, errors))
