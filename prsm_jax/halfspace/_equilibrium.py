"""Pressures of a contact and their derivatives, through the cells in contact."""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..fields import Scalar
from ._convolution import convolve
from ._displacement import normal_displacement, normal_influence
from ._grid import Grid
from ._polonsky_keer import Control, Pressures, constrained_conjugate_gradients
from ._preconditioner import apply_symbol, stiffness_symbol

#: Grids with at least twice as many cells in both directions are first solved with half the cells
#: per direction.
_COARSEST = 32
#: Residual of the linear system of the derivatives, relative.
_DERIVATIVE_TOLERANCE = 1e-11


def _halved(field: Float[Array, "nx ny"]) -> Float[Array, "mx my"]:
    nx, ny = field.shape
    return field.reshape(nx // 2, 2, ny // 2, 2).mean(axis=(1, 3))


def _first_guess(grid: Grid, gap, control: Control, target, modulus) -> Float[Array, "nx ny"]:
    """Uniform pressure for a load; for an approach, proportional to the overlap."""
    if control == "load":
        return jnp.ones_like(gap)
    shorter = jnp.minimum(grid.shape[0] * grid.spacing_x, grid.shape[1] * grid.spacing_y)
    return jnp.maximum(target - gap, 0.0) * (modulus / shorter)


def _search(grid, gap, material, control, target, modulus, tolerance, max_iterations) -> Pressures:
    """Constrained conjugate gradients, started on a grid with half the cells per direction.

    For a load the target is Σp on both grids: a coarse cell has four times the area.
    """
    nx, ny = grid.shape
    start, iterations = _first_guess(grid, gap, control, target, modulus), 0
    if min(nx, ny) >= 2 * _COARSEST and nx % 2 == 0 and ny % 2 == 0:
        coarse = _search(
            Grid((nx // 2, ny // 2), 2 * grid.spacing_x, 2 * grid.spacing_y),
            _halved(gap),
            _halved(material.astype(gap.dtype)) > 0.5,
            control,
            target / 4 if control == "load" else target,
            modulus,
            # The accuracy of the coarser grid.
            jnp.maximum(tolerance, 1e-3),
            max_iterations,
        )
        finer = jnp.repeat(jnp.repeat(coarse.pressure, 2, axis=0), 2, axis=1)
        solved = jnp.any(material & (finer > 0))
        start, iterations = jnp.where(solved, finer, start), coarse.iterations
    transform = normal_influence(grid) / modulus
    symbol = stiffness_symbol(grid) * modulus
    solved = constrained_conjugate_gradients(
        functools.partial(convolve, transform),
        functools.partial(apply_symbol, symbol),
        jnp.mean(symbol),
        gap,
        material,
        control,
        target,
        start,
        tolerance,
        max_iterations,
    )
    return solved._replace(iterations=solved.iterations + iterations)


def _rigid(grid: Grid, gap, pressure, modulus) -> Float[Array, "nx ny"]:
    """Displacement plus gap: equal to the approach on all cells in contact."""
    return normal_displacement(grid, pressure, modulus) + gap


def _conjugate_gradients(
    precondition: Callable[..., Any],
    max_iterations: int,
    system: Callable[..., Any],
    right: Float[Array, "nx ny"],
) -> Float[Array, "nx ny"]:
    """Solve `system(x) = right`, symmetric and positive definite where `right` is not zero."""
    target = _DERIVATIVE_TOLERANCE**2 * jnp.sum(right**2)

    def step(state):
        solution, residual, direction, product, iterations = state
        image = system(direction)
        curvature = jnp.sum(direction * image)
        # A right-hand side of rounding errors alone gives no search direction.
        ends = curvature == 0
        length = jnp.where(ends, 0.0, product / jnp.where(ends, 1.0, curvature))
        solution, residual = solution + length * direction, residual - length * image
        steepest = precondition(residual)
        following = jnp.where(ends, 0.0, jnp.sum(residual * steepest))
        direction = steepest + following / product * direction
        return solution, residual, direction, following, iterations + 1

    def unfinished(state):
        under_way = (state[3] != 0) & (state[4] < max_iterations)
        return (jnp.sum(state[1] ** 2) > target) & under_way

    steepest = precondition(right)
    start = (jnp.zeros_like(right), right, steepest, jnp.sum(right * steepest), jnp.asarray(0))
    return jax.lax.while_loop(unfinished, step, start)[0]


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def equilibrium(
    control: Control,
    max_iterations: int,
    grid: Grid,
    gap: Float[Array, "nx ny"],
    target: Scalar,
    modulus: Scalar,
    material: Bool[Array, "nx ny"],
    tolerance: Scalar,
) -> Pressures:
    """Pressures under a load [N] or at an approach [m].

    Derivatives are those of the solution with the set of cells in contact fixed:
    `K ṗ = δ̇ − K̇ p − ġ` there, one more conjugate-gradient solution, in forward and in reverse
    mode.

    **Arguments:** as in `solve_contact`.
    """
    scaled = target / grid.cell_area if control == "load" else target
    return _search(grid, gap, material, control, scaled, modulus, tolerance, max_iterations)


@equilibrium.defjvp
def _equilibrium_jvp(control, max_iterations, primals, tangents):
    grid, gap, target, modulus, _, _ = primals
    grid_dot, gap_dot, target_dot, modulus_dot, _, _ = tangents
    pressures = equilibrium(control, max_iterations, *primals)
    pressure = pressures.pressure
    contact = (pressure > 0).astype(pressure.dtype)
    count = jnp.maximum(jnp.sum(contact), 1.0)
    transform = normal_influence(grid) / modulus
    symbol = stiffness_symbol(grid) * modulus

    def spread(values):
        """Projected onto the cells in contact; under a load, with a sum of 0."""
        values = values * contact
        return values - contact * (jnp.sum(values) / count) if control == "load" else values

    def system(values):
        return spread(convolve(transform, spread(values)))

    def precondition(values):
        return spread(apply_symbol(symbol, spread(values)))

    _, explicit = jax.jvp(
        lambda grid, gap, modulus: _rigid(grid, gap, pressure, modulus),
        (grid, gap, modulus),
        (grid_dot, gap_dot, modulus_dot),
    )
    if control == "load":
        # Σp = load/area of a cell.
        _, sum_dot = jax.jvp(
            lambda grid, load: load / grid.cell_area, (grid, target), (grid_dot, target_dot)
        )
        even = contact * (sum_dot / count)
        right = spread(-explicit - convolve(transform, even))
    else:
        even = jnp.zeros_like(gap)
        right = spread(target_dot - explicit)
    solved = jax.lax.custom_linear_solve(
        system,
        right,
        # In reverse mode a sum of all pressures leaves only rounding here, with a mean that is not
        # 0.
        lambda system, right: _conjugate_gradients(
            precondition, max_iterations, system, spread(right) if control == "load" else right
        ),
        symmetric=True,
    )
    pressure_dot = even + spread(solved)
    approach_dot = target_dot
    if control == "load":
        moved = convolve(transform, pressure_dot) + explicit
        approach_dot = jnp.sum(moved * contact) / count
    no_change: Any = np.zeros(pressures.iterations.shape, jax.dtypes.float0)
    return pressures, Pressures(
        pressure_dot,
        approach_dot,
        no_change,
        jnp.zeros_like(pressures.residual),
    )
