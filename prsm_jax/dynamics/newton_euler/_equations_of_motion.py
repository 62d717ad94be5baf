"""All free bodies of a mechanism at once: forces and carrier accelerations from one system.

The equations are linear in the forces except for the magnitudes in the friction laws, the choice of
the loaded flanks, and the resisting moments in the contact ellipses. Newton's iteration on all of
them searches the signs: once these are right, one step gives the solution, and the next removes its
rounding error.
"""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...fields import Scalar
from ...mechanism import Mechanism, Stage
from ...numerics import solve
from ...programs import physics
from .._kinematics import StageKinematics
from ..friction import has_contact_losses, resisting_moments
from ._free_bodies import (
    FromNext,
    StageSurroundings,
    StageUnknowns,
    rubbing_on_screw_side,
    unbalanced,
)
from ._part_masses import PartMasses

_UNKNOWNS = len(StageUnknowns._fields)
_MOST_ITERATIONS = 20


def from_following(
    stages: tuple[Stage, ...], unknowns: Sequence[StageUnknowns], index: int, load: Scalar
) -> FromNext:
    """Reactions of the screw that follows a stage; the load where there is none."""
    if index + 1 == len(stages):
        zero = jnp.zeros_like(load)
        return FromNext(load, zero, zero, zero)
    radius, following = stages[index + 1].thread.screw_radius, unknowns[index + 1]
    return FromNext(
        load=following.support,
        drive_torque=radius * following.drive_torque,
        spline_friction=following.spline_friction,
        bearing_torque=radius * following.bearing_torque,
    )


def contact_moments(
    stage: Stage, kinematics: StageKinematics, known: StageSurroundings, unknowns: StageUnknowns
) -> tuple[Scalar, Scalar]:
    """Moments that resist the turning of one roller, screw and nut side [N·m]."""
    if not has_contact_losses(stage.friction):
        zero = jnp.zeros_like(unknowns.screw_contact)
        return zero, zero
    pressed = jnp.abs(unknowns.screw_contact)
    rub = rubbing_on_screw_side(stage, kinematics, known, unknowns)
    screw, nut = resisting_moments(stage, kinematics, pressed, unknowns.nut_contact, rub)
    return jnp.asarray(screw.total), jnp.asarray(nut.total)


@physics("newton")
def newton_forces(
    mechanism: Mechanism,
    kinematics: tuple[StageKinematics, ...],
    masses: tuple[PartMasses, ...],
    surroundings: tuple[StageSurroundings, ...],
    load: Scalar,
) -> tuple[tuple[StageUnknowns, ...], Bool[Array, ""]]:
    """Solve the equations of all bodies of all stages.

    **Arguments:**

    - `mechanism`, `kinematics`, `masses`, `surroundings`: all stages and their known quantities.
    - `load`: on the last nut [N].

    **Returns:** the unknowns of every stage, and whether the iteration converged.
    """
    stages = mechanism.stages

    def parts(flat: Float[Array, " n"]) -> list[StageUnknowns]:
        rows = flat.reshape(len(stages), _UNKNOWNS)
        return [StageUnknowns(*row) for row in rows]

    def residual(flat: Float[Array, " n"]) -> Float[Array, " n"]:
        unknowns = parts(flat)
        rows: list[Scalar] = []
        for index, (stage, geometry, mass, known, own) in enumerate(
            zip(stages, kinematics, masses, surroundings, unknowns, strict=True)
        ):
            following = from_following(stages, unknowns, index, load)
            moments = contact_moments(stage, geometry, known, own)
            rows += unbalanced(stage, geometry, mass, known, own, following, moments)
        return jnp.stack(rows)

    def search(function, start):
        def step(carry):
            flat, _, count = carry
            change = solve(jax.jacfwd(function)(flat), function(flat))
            settled = jnp.max(jnp.abs(change)) <= 1e-13 * jnp.max(jnp.abs(flat - change))
            return flat - change, settled, count + 1

        def goes_on(carry):
            _, settled, count = carry
            return jnp.logical_not(settled) & (count < _MOST_ITERATIONS)

        first = (start, jnp.asarray(False), jnp.asarray(0))
        flat, settled, _ = jax.lax.while_loop(goes_on, step, first)
        return flat, settled.astype(start.dtype)

    def solve_linear(linear, right):
        return solve(jax.vmap(linear, out_axes=1)(jnp.eye(len(right), dtype=right.dtype)), right)

    # Starts with contacts that press, where the moments in their ellipses have a derivative.
    start = jnp.ones(len(stages) * _UNKNOWNS, load.dtype)
    flat, settled = jax.lax.custom_root(residual, start, search, solve_linear, has_aux=True)
    return tuple(parts(flat)), settled > 0.5
