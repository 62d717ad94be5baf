"""Damping ratios of the modes in space by creep friction."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..contact import load_of
from ..fields import Scalar
from ..mechanism import Mechanism, of_one_design
from ..programs import listed, mapped, one_program, physics
from ..results import DesignResult, outcome
from ..text import Line
from ..vibration import (
    SpatialModes,
    spatial_modes,
    spatial_spring_modes,
    stage_spatial_system,
)
from ._creep_friction import CreepFriction, creep_friction
from ._damped_modes import DampedModes, damped_modes

#: By code.
_MEANINGS = (
    "successful",
    "no steady state: forces and slip are not those of an operating point; see prsm.steady_state",
    "standstill: the threads do not slide, so creep friction damps nothing; give a speed, or a law "
    "of friction that is smooth at standstill",
    "overdamped: a mode does not vibrate under this damping, or was not found; its ratio is that "
    "of first order; give a higher speed",
    "negative damping: friction falls as the slip rises and feeds at least one mode, which is "
    "unstable unless other damping exceeds this; raise the speed, or take a lubricant whose "
    "friction does not fall (static_coefficient, stribeck_speed)",
)
#: The same as names, by code.
DAMPING_RESULTS = (
    "successful",
    "no_steady_state",
    "standstill",
    "overdamped",
    "negative_damping",
)
#: A negative ratio below this is rounding.
_NEGATIVE = -1e-14


class SpatialDamping(DesignResult):
    """Modes of a stage in space, and the damping ratio of each by creep friction."""

    modes: SpatialModes
    creep: CreepFriction
    #: `ζ = −Re λ/|λ|` of each mode of `modes.groups`; negative where friction feeds the mode, 0 for
    #: a rigid motion. A root that repeats within a group has the mean ratio of first order.
    ratios: tuple[Float[Array, "..."], ...]
    #: Of first order in the damping, φᴴ C φ/2ω: the limit at light damping.
    first_order_ratios: tuple[Float[Array, "..."], ...]
    #: `|λ|/2π` of the damped modes [Hz]: strong damping ties rollers to the screw across the slip.
    damped_frequencies: tuple[Float[Array, "..."], ...]
    #: Whether each mode vibrates under this damping and was found; the ratio of one that does not
    #: is that of first order.
    vibrates: tuple[Bool[Array, "..."], ...]
    #: 0 when all is well; see `result`.
    code: Int[Array, ""]

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of a batch of designs; empty for a single one."""
        return self.code.shape

    def _ascending(self, of_groups: tuple[Array, ...]) -> Array:
        """Values of the groups in the order of `modes.frequencies`."""
        groups = self.modes.groups
        repeated = [jnp.repeat(g.frequencies, g.multiplicity) for g in groups]
        values = [jnp.repeat(z, g.multiplicity) for z, g in zip(of_groups, groups, strict=True)]
        return jnp.concatenate(values)[jnp.argsort(jnp.concatenate(repeated), stable=True)]

    @property
    @mapped
    def damping_ratios(self) -> Float[Array, "*batch degrees"]:
        """ζ of each entry of `modes.frequencies`."""
        return self._ascending(self.ratios)

    @property
    @mapped
    def vibrating(self) -> Bool[Array, "*batch degrees"]:
        """Whether each entry of `modes.frequencies` vibrates under this damping and was found."""
        return self._ascending(self.vibrates)

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


def _code(creep: CreepFriction, damped: list[DampedModes]) -> Int[Array, ""]:
    lowest = jnp.min(jnp.stack([jnp.min(one.ratios) for one in damped]))
    every = jnp.all(jnp.stack([jnp.all(one.found) for one in damped]))
    code = jnp.where(every, jnp.where(lowest < _NEGATIVE, 4, 0), 3)
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
    tilt: bool | None = None,
) -> SpatialDamping:
    """Damping ratios of the modes of `spatial_modal` by friction of the threads that slide.

    The friction of screw and rollers at the operating point is a pair of dashpots at each roller
    (`creep_friction`), equal at all of them, so it keeps the symmetry of the stage and each
    harmonic of the rollers has its own small problem. Each damped mode is followed from the
    undamped one as the damping grows (`damped_modes`), so a ratio is that of the exact eigenvalue;
    that of first order beside it fails where a light body, such as a roller that nothing but its
    threads holds, is damped strongly. No other damping is included.

    Jittable, and differentiable by the numbers of the mechanism, speed and load.

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs what `spatial_modal` and `steady_state` need,
      and a law of thread friction.
    - `stage`: which stage, counted from 1.
    - `speed`: screw speed [rad/s]; default that of the operating point.
    - `load`: axial load, for the contact stiffness and for the friction [N]; default that of the
      operating point.
    - `sticking`, `shapes`, `motor_held`, `tilt`: as in `spatial_modal`.

    **Raises:** as `spatial_modal` and `creep_friction`.
    """
    load = load_of(mechanism, load)
    creep = creep_friction(mechanism, stage=stage, speed=speed, load=load, tilt=tilt)
    system = stage_spatial_system(
        mechanism, stage, load, sticking=sticking, motor_held=motor_held, tilt=tilt
    )
    solved = spatial_spring_modes(system)
    damped = [
        damped_modes(modes, creep.network(system, harmonic))
        for harmonic, modes in enumerate(solved)
    ]
    return SpatialDamping(
        modes=spatial_modes(system, shapes=shapes, solved=solved),
        creep=creep,
        ratios=tuple(one.ratios for one in damped),
        first_order_ratios=tuple(one.first_order for one in damped),
        damped_frequencies=tuple(jnp.abs(one.eigenvalues) / (2 * jnp.pi) for one in damped),
        vibrates=tuple(one.found for one in damped),
        code=_code(creep, damped),
    )
