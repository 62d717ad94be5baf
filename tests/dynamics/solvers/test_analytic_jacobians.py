"""Jacobians of chains, and the method that integrates their variational equation."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import example

from prsm_jax.dynamics import all_kinematics
from prsm_jax.dynamics.solvers.rodasp._jacobians import (
    NODES,
    ChainJacobian,
    FullJacobian,
    chain_jacobian,
    full_jacobian,
    node_inverses,
    node_slopes,
)
from prsm_jax.dynamics.speed_drive import carrier_acceleration, scaled_rate
from prsm_jax.dynamics.speed_drive._carrier_motion import carrier_problem
from prsm_jax.scenario import Scenario
from tests.present import present


def _triangle(count: int, seed: int = 0) -> np.ndarray:
    return np.triu(np.random.default_rng(seed).normal(size=(count, count))) - 3 * np.eye(count)


def _chain_of(matrix: np.ndarray) -> ChainJacobian:
    return ChainJacobian([[jnp.asarray(x) for x in row[k:]] for k, row in enumerate(matrix)])


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_products_and_solutions_are_those_of_the_matrix(count):
    matrix, vector = _triangle(count), np.random.default_rng(1).normal(size=count)
    for jacobian in (_chain_of(matrix), FullJacobian(jnp.asarray(matrix))):
        np.testing.assert_allclose(jacobian.times(jnp.asarray(vector)), matrix @ vector, rtol=1e-13)
        np.testing.assert_allclose(jacobian.diagonal, np.diag(matrix))
        solved = jacobian.shifted_solve(jnp.asarray(1.7))(jnp.asarray(vector))
        exact = np.linalg.solve(1.7 * np.eye(count) - matrix, vector)
        np.testing.assert_allclose(solved, exact, rtol=1e-12)


def _rates(drive, state, args):
    later, found = args, []
    for value in reversed(list(state)):
        later = later + drive * value**2
        found.append(jnp.sin(value) * later - value)
    return found[::-1]


def test_the_jacobian_of_a_chain_is_the_whole_jacobian():
    state, drive, args = [jnp.asarray(x) for x in (0.3, -1.2, 2.0)], 0.7, jnp.asarray(1.1)
    chain = chain_jacobian(_rates, drive, state, args)
    full = full_jacobian(lambda y: jnp.stack(_rates(drive, list(y), args)), jnp.stack(state))
    matrix = np.zeros((3, 3))
    for k, row in enumerate(chain.rows):
        matrix[k, k:] = row
    np.testing.assert_allclose(matrix, full.matrix, rtol=1e-14, atol=1e-15)
    assert np.all(np.tril(full.matrix, -1) == 0)


@pytest.mark.parametrize("by_scalars", [True, False])
@pytest.mark.parametrize("count", [2, 3])
def test_stages_do_not_act_on_those_after_them(count, by_scalars):
    """The Jacobian is a triangle, of the equation in scalars and of that in vectors."""
    two = example("li2021_two_stage")
    mechanism = eqx.tree_at(lambda one: one.stages, two, (*two.stages, two.stages[1])[:count])
    scenario = Scenario(jnp.asarray(80.0), jnp.asarray(2e3), jnp.asarray(0.1))
    problem = carrier_problem(mechanism, all_kinematics(mechanism), scenario)
    assert problem.reduced is not None
    if not by_scalars:
        problem = eqx.tree_at(lambda one: one.reduced, problem, None)
    drive = scaled_rate.drive_at(jnp.asarray(0.0), problem)
    ratios = jnp.asarray(np.random.default_rng(3).uniform(0.1, 0.5, (20, count)))

    def both(ratio):
        slopes = jax.jacfwd(lambda w: carrier_acceleration(problem, drive, w * 80.0))(ratio)
        chain = present(scaled_rate.chain)
        rates = jnp.stack(list(chain(drive, list(ratio), problem)))
        return slopes, rates, scaled_rate.rate(drive, ratio, problem)

    slopes, one_by_one, at_once = jax.jit(jax.vmap(both))(ratios)
    assert np.all(np.tril(slopes, -1) == 0)
    assert np.all(np.triu(slopes)[:, *np.triu_indices(count)] != 0)
    np.testing.assert_allclose(one_by_one, at_once, rtol=1e-13)


def _slopes_of_steps(matrix_at, forcing_at, start, end, steps: int):
    """z at the end, by as many steps of the method."""
    length, z = end / steps, [jnp.asarray(x) for x in start]
    for step in range(steps):
        times = [(step + share) * length for share in NODES]
        jacobians = [_chain_of(np.asarray(matrix_at(t))) for t in times]
        forcing = [[jnp.asarray(length * g) for g in forcing_at(t)] for t in times]
        inverses = node_inverses(jacobians, jnp.asarray(length))
        slopes = node_slopes(jacobians, inverses, forcing, jnp.asarray(length), z)
        z = [a + (k[0] + 4 * k[1] + k[2]) / 6 for a, k in zip(z, slopes, strict=True)]
    return np.asarray(z)


def _coupled(time):
    return np.array([[-1.0 - time, 2.0 * np.cos(time)], [0.0, -0.5 + 0.3 * np.sin(2 * time)]])


def test_the_variational_equation_is_integrated_with_order_four():
    # z = (cos t, e⁻ᵗ) solves it with g = ż − J z.
    def exact(time):
        return np.array([np.cos(time), np.exp(-time)])

    def forcing(time):
        return np.array([-np.sin(time), -np.exp(-time)]) - _coupled(time) @ exact(time)

    errors = [
        np.abs(_slopes_of_steps(_coupled, forcing, exact(0.0), 2.0, n) - exact(2.0)).max()
        for n in (8, 16, 32)
    ]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.8)
    assert errors[-1] < 2e-7


@pytest.mark.parametrize("stiffness", [1e3, 1e6, 1e12])
def test_stiff_derivatives_are_in_balance_at_the_end_of_a_step(stiffness):
    """With `ż = −k (z − cos t)` and a start off the balance, in one step of 0.1."""

    def matrix(_):
        return np.array([[-stiffness]])

    def forcing(time):
        return np.array([stiffness * np.cos(time)])

    found = _slopes_of_steps(matrix, forcing, [5.0], 0.1, 1)[0]
    # The start is damped to 6/(h k)² of it, and the balance lags by 1/k.
    assert abs(found - np.cos(0.1)) < 2 / stiffness + 5 * 6 / (0.1 * stiffness) ** 2


@pytest.mark.parametrize("seed", range(5))
def test_deviations_never_grow_however_time_constants_change(seed):
    """Over reversals time constants of carriers change by orders of magnitude within a step."""
    random = np.random.default_rng(seed)
    rates = 10.0 ** random.uniform(-2, 8, size=64)

    def matrix(time):
        return np.array([[-rates[round(time * 20)]]])

    for step in range(30):
        found = _slopes_of_steps(
            lambda t, step=step: matrix(t + 0.1 * step), lambda _: np.zeros(1), [1.0], 0.1, 1
        )[0]
        assert abs(found) <= 1 + 1e-12


def test_growth_inside_a_step_leaves_derivatives_finite():
    """Without limits the multiplier of 0, 0 and 6 is infinite, that of −5, 1 and −5 is −30."""
    size = np.concatenate([[0.0], np.logspace(-2, 12, 15), np.linspace(2.0, 9.0, 15)])
    sizes = np.concatenate([-size, size[1:]])

    def multiplier(first, middle, last):
        jacobians = [ChainJacobian([[rate]]) for rate in (first, middle, last)]
        zero, one = jnp.zeros(()), jnp.ones(())
        inverses = node_inverses(jacobians, one)
        slopes = node_slopes(jacobians, inverses, [[zero]] * 3, one, [one])[0]
        return 1 + (slopes[0] + 4 * slopes[1] + slopes[2]) / 6

    rates = jnp.asarray(np.array(np.meshgrid(sizes, sizes, sizes)).reshape(3, -1))
    found = jax.jit(jax.vmap(multiplier))(*rates)
    # Growth by e at most in the exact solution of constant rates up to 1.
    assert float(jnp.abs(found).max()) < 3.0
    slow = (jnp.abs(rates) <= 0.1).all(0)
    exact = jnp.exp((rates[0] + 4 * rates[1] + rates[2]) / 6)
    np.testing.assert_allclose(found[slow], exact[slow], atol=3e-3)
