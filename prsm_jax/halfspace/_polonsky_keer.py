"""Constrained conjugate gradients for non-negative pressures (Polonsky and Keer 1999)."""

from collections.abc import Callable
from typing import Literal, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..fields import Scalar

#: The prescribed quantity: the sum of all pressures, or the approach of the bodies.
Control: TypeAlias = Literal["load", "approach"]


class Pressures(NamedTuple):
    """Result of a search for the pressures."""

    pressure: Float[Array, "nx ny"]
    approach: Scalar
    iterations: Int[Array, ""]
    #: Largest violation of contact (gap 0 under pressure, not negative elsewhere) over the largest
    #: displacement.
    residual: Scalar


class _State(NamedTuple):
    pressure: Float[Array, "nx ny"]
    displacement: Float[Array, "nx ny"]
    #: Gap after deformation.
    gap: Float[Array, "nx ny"]
    approach: Scalar
    residual: Scalar
    direction: Float[Array, "nx ny"]
    #: Sum of squares of the last step's gaps in contact; infinite for a restart.
    previous: Scalar
    iterations: Int[Array, ""]


def _mean(values: Float[Array, "nx ny"], where: Float[Array, "nx ny"]) -> Scalar:
    """Mean over a set given by ones and zeros; 0 if it is empty."""
    return jnp.sum(values * where) / jnp.maximum(jnp.sum(where), 1.0)


def constrained_conjugate_gradients(
    influence: Callable[[Float[Array, "nx ny"]], Float[Array, "nx ny"]],
    stiffness: Callable[[Float[Array, "nx ny"]], Float[Array, "nx ny"]],
    cell_stiffness: Scalar,
    gap: Float[Array, "nx ny"],
    material: Bool[Array, "nx ny"],
    control: Control,
    target: Scalar,
    start: Float[Array, "nx ny"],
    tolerance: Scalar,
    max_iterations: int,
) -> Pressures:
    """Pressures p ≥ 0 with g = K p + gap − δ ≥ 0 and p g = 0 on all cells with material.

    Conjugate gradients on the cells in contact; a cell whose pressure would become negative leaves,
    a cell that overlaps without pressure enters, and the directions are then restarted. Unlike in
    the original method they are preconditioned. Two products with K per step, one if the set does
    not change.

    **Arguments:**

    - `influence`: the product K p, symmetric and positive definite.
    - `stiffness`: approximately its inverse, symmetric and positive definite.
    - `cell_stiffness`: the value of `stiffness` for a single cell [Pa/m].
    - `gap`: before deformation [m].
    - `material`: cells that can carry pressure.
    - `control`, `target`: `"load"` and the sum of all pressures [Pa], or `"approach"` and δ [m].
    - `start`: pressures to begin with, not negative [Pa].
    - `tolerance`: on `residual`.
    - `max_iterations`: steps allowed.
    """

    # Without any pressure the bodies just touch, for any constant in the gap.
    nearest = jnp.min(gap, where=material, initial=jnp.inf)
    nearest = jnp.where(jnp.isfinite(nearest), nearest, 0.0)

    def assess(pressure, displacement):
        contact = (pressure > 0).astype(pressure.dtype)
        approach = target
        if control == "load":
            mean = _mean(displacement + gap, contact)
            approach = jnp.where(jnp.any(pressure > 0), mean, nearest)
        opened = displacement + gap - approach
        overlap = jnp.where(material & (pressure <= 0), -opened, 0.0)
        violation = jnp.maximum(jnp.max(jnp.abs(opened) * contact), jnp.max(overlap))
        scale = jnp.max(displacement)
        return opened, approach, violation / jnp.where(scale > 0, scale, 1.0)

    def loaded(pressure):
        """Scaled to carry the load."""
        if control == "approach":
            return pressure, jnp.ones_like(target)
        total = jnp.sum(pressure)
        factor = target / jnp.where(total > 0, total, 1.0)
        return pressure * factor, factor

    def step(state: _State) -> _State:
        pressure = state.pressure
        contact = (pressure > 0).astype(pressure.dtype)
        steepest = contact * stiffness(contact * state.gap)
        if control == "load":
            steepest = contact * (steepest - _mean(steepest, contact))
        squares = jnp.sum(state.gap * steepest)
        direction = contact * (steepest + squares / state.previous * state.direction)
        change = influence(direction)
        centred = change - _mean(change, contact) if control == "load" else change
        curvature = jnp.sum(centred * direction)
        length = jnp.sum(state.gap * direction) / jnp.where(curvature > 0, curvature, 1.0)
        moved = pressure - length * direction
        clipped = jnp.maximum(moved, 0.0)
        entering = material & (clipped <= 0) & (state.gap < 0)
        following, factor = loaded(
            jnp.where(entering, -length * cell_stiffness * state.gap, clipped)
        )
        changed = jnp.any(entering | (moved < 0))
        displacement = jax.lax.cond(
            changed,
            lambda: influence(following),
            lambda: factor * (state.displacement - length * change),
        )
        return _State(
            following,
            displacement,
            *assess(following, displacement),
            direction,
            jnp.where(jnp.any(entering), jnp.inf, squares),
            state.iterations + 1,
        )

    def unfinished(state: _State) -> Bool[Array, ""]:
        return (state.residual > tolerance) & (state.iterations < max_iterations)

    pressure, _ = loaded(jnp.where(material, start, 0.0))
    displacement = influence(pressure)
    state = _State(
        pressure,
        displacement,
        *assess(pressure, displacement),
        jnp.zeros_like(pressure),
        jnp.full_like(target, jnp.inf),
        jnp.asarray(0),
    )
    state = jax.lax.while_loop(unfinished, step, state)
    return Pressures(state.pressure, state.approach, state.iterations, state.residual)
