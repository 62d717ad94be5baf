"""Derivatives of responses: forward, reverse and finite differences, at repeated roots too."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from response_scenes import LAWS, natural, with_rollers
from scenes import example

import prsm_jax as prsm
from prsm_jax.dynamics import ideal_carrier_ratio
from prsm_jax.mechanism import UnequalRoller
from prsm_jax.response import campbell, receptance_matrix
from prsm_jax.response._dissipation import _square_root
from prsm_jax.vibration import spring_network, stage_system

#: A change that keeps the symmetry, one that splits repeated roots, a mass, a support.
NAMES = (
    "stiffness.screw_roller",
    "unequal_roller.3.stiffness_factor",
    "roller.mass",
    "nut.support.torsional_stiffness",
    "nut.support.radial_stiffness",
)


def _moved(mechanism, changes):
    """The mechanism with its parameters changed by these shares."""
    for name, change in zip(NAMES, changes, strict=True):
        mechanism = prsm.set_parameter(
            mechanism, name, prsm.get_parameter(mechanism, name) * (1 + change)
        )
    return mechanism


def _central(function, at, step):
    """Jacobian by central differences."""
    columns = []
    for direction in np.eye(len(at)):
        ahead, behind = function(at + step * direction), function(at - step * direction)
        columns.append((np.asarray(ahead) - np.asarray(behind)) / (2 * step))
    return np.stack(columns, axis=1)


@pytest.mark.parametrize(
    ("law", "method"),
    [("modal", "direct"), ("modal", "modal"), ("structural", "direct"), ("undamped", "direct")],
)
def test_receptances_at_repeated_roots(law, method):
    """A symmetric stage seen by a solver that does not know it: 4-fold and double roots.

    At rest, a thousandth from the 4-fold root and from a double one, and between them.
    """
    one = with_rollers(UnequalRoller(3, stiffness_factor=1.0))
    roots = natural("symmetric")
    omega = jnp.asarray([0.0, 0.999 * roots[10], 1.001 * roots[3], 1.2e5])
    into, out_of = ("screw u", "roller 3 u", "nut x"), ("roller 3 u", "screw y")

    def parts(changes):
        network = spring_network(stage_system(_moved(one, changes), 1))
        found, _ = receptance_matrix(network, omega, into, out_of, LAWS[law], method)
        return jnp.stack([found.real, found.imag]).ravel()

    nothing = jnp.zeros(len(NAMES))
    values = np.asarray(jax.jit(parts)(nothing))
    forward = np.asarray(jax.jit(jax.jacfwd(parts))(nothing))
    reverse = np.asarray(jax.jit(jax.jacrev(parts))(nothing))
    # A step of 1e-6 at a distance of 1e-3 from a pole: (1e-3)² of truncation.
    difference = _central(jax.jit(parts), nothing, 1e-6)
    assert np.isfinite(values).all()
    # Per frequency, the size of the largest slope: what symmetry cancels is only rounding.
    size = np.abs(difference).reshape(2, len(omega), -1).max(axis=(0, 2))
    size = np.broadcast_to(size[None, :, None, None], (2, len(omega), 6, len(NAMES)))
    size = size.reshape(forward.shape)
    assert (np.abs(forward - reverse) <= 1e-9 * size).all()
    assert (np.abs(forward - difference) <= 2e-5 * size).all()
    # The splitting change is felt where nothing but the third roller's symmetry was broken.
    assert np.abs(forward[:, 1]).max() > 0


def test_the_square_root_of_a_matrix_at_repeated_eigenvalues():
    """First and second derivatives along changes that split the eigenvalues and along others."""
    generator = np.random.default_rng(1)
    vectors = np.linalg.qr(generator.normal(size=(5, 5)))[0]
    values = np.array([1.0, 4.0, 4.0, 4.0, 9.0])
    base = vectors * values @ vectors.T
    change = generator.normal(size=(5, 5))
    change = change + change.T

    def root(t):
        matrix = jnp.asarray(base) + t * jnp.asarray(change)
        return _square_root(matrix, jnp.asarray(vectors), jnp.asarray(np.sqrt(values)))

    def exact(t):
        found, basis = np.linalg.eigh(base + t * change)
        return basis * np.sqrt(found) @ basis.T

    np.testing.assert_allclose(root(0.0), exact(0.0), atol=1e-14)
    step = 1e-3
    # Truncation of the differences of order h⁴ and h².
    slope = (8 * (exact(step) - exact(-step)) - (exact(2 * step) - exact(-2 * step))) / (12 * step)
    np.testing.assert_allclose(jax.jit(jax.jacfwd(root))(0.0), slope, atol=1e-9)
    np.testing.assert_allclose(jax.jit(jax.jacrev(root))(0.0), slope, atol=1e-9)
    bend = (exact(step) - 2 * exact(0.0) + exact(-step)) / step**2
    np.testing.assert_allclose(jax.jit(jax.jacfwd(jax.jacfwd(root)))(0.0), bend, atol=1e-4)
    np.testing.assert_allclose(jax.jit(jax.jacfwd(jax.jacrev(root)))(0.0), bend, atol=1e-4)


def test_critical_speeds():
    """2π f / (h · order) by geometry, stiffness and mass; rollers that roll without slip."""
    one = example("wu2022")
    names = ("lead", "roller_radius", "starts", "stiffness.screw_roller", "roller.mass")
    start = jnp.asarray([prsm.get_parameter(one, name) for name in names])

    def speeds(changes):
        moved = one
        for name, value in zip(names, start * (1 + changes), strict=True):
            moved = prsm.set_parameter(moved, name, value)
        ratio = ideal_carrier_ratio(moved.stages[0].thread)
        names_ = ("thread_passing", "ring_gear_mesh")
        found = campbell(moved, harmonics=1, carrier_ratio=ratio, orders=names_)
        return found.critical_speeds.ravel()

    nothing = jnp.zeros(len(names))
    values = np.asarray(jax.jit(speeds)(nothing))
    forward = np.asarray(jax.jit(jax.jacfwd(speeds))(nothing))
    # Weights of one over the speed: each counts alike.
    weights = 1 / np.where(values > 1e-6 * values.max(), values, np.inf)
    reverse = np.asarray(jax.jit(jax.grad(lambda c: speeds(c) @ jnp.asarray(weights)))(nothing))
    difference = _central(jax.jit(speeds), nothing, 1e-5)
    elastic = values > 1e-6 * values.max()
    size = np.abs(values)[:, None]
    assert elastic.sum() >= 2 * (len(values) // 2 - 1)
    np.testing.assert_allclose(reverse, weights @ forward, rtol=1e-9)
    # Differences: 1e-10 of truncation, and rounding of 1e-12 over a step of 1e-5.
    assert (np.abs(forward - difference) <= 1e-6 * size)[elastic].all()
    assert np.isfinite(forward).all()
    assert np.isfinite(reverse).all()


def test_the_magnitude_of_nothing_has_a_derivative():
    """What symmetry keeps at zero has the slope zero, and not none."""
    wu = example("wu2022")

    def magnitude(stiffness):
        moved = prsm.set_parameter(wu, "stiffness.screw_roller", stiffness)
        return prsm.frequency_response(moved, "screw u", "nut x", [100.0]).magnitude[0]

    assert float(jax.jit(jax.grad(magnitude))(2e8)) == 0.0
