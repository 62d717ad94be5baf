"""The stage of Wu et al. 2022 with random numbers, and its rivals: what several cases share."""

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.file import load
from prsm_jax.mechanism import set_parameter
from prsm_jax.stiffness import thread_stiffness
from prsm_jax.vibration import VibrationSystem, vibration_system

from .vibration import NUMBERS, mass_terms, stiffness_terms


def base_system(count: int) -> VibrationSystem:
    """The stage of Wu et al. 2022, Tables 3 and 4, with `count` rollers."""
    stage = set_parameter(load("wu2022"), "roller_count", count).stages[0]

    def no_contacts():
        raise AssertionError("the example gives its contact stiffnesses")

    return vibration_system(stage, thread_stiffness(stage, no_contacts))


def numbers_of(system: VibrationSystem) -> np.ndarray:
    leaves = np.array([float(leaf) for leaf in jax.tree.leaves(system)])
    assert len(leaves) == NUMBERS
    return leaves


def random_systems(count: int, designs: int, spread: float) -> np.ndarray:
    """Numbers of random designs: each number of the base by a random factor within ±spread
    decades."""
    random = np.random.default_rng(1395)
    factors = 10 ** random.uniform(-spread, spread, (designs, NUMBERS))
    return numbers_of(base_system(count)) * factors


def unflattened(count: int):
    treedef = jax.tree.structure(base_system(count))
    return lambda numbers: jax.tree.unflatten(treedef, list(numbers))


def dense_solver(count: int):
    """Frequencies from a row of numbers: the full matrix, assembled by one product (the leanest
    way) and scaled by its diagonal masses."""
    stiffness_of, mass_of = jnp.asarray(stiffness_terms(count)), jnp.asarray(mass_terms(count))

    def solve(numbers):
        stiffness, mass = jnp.tensordot(numbers, stiffness_of, 1), numbers @ mass_of
        return scaled_frequencies(stiffness, mass)

    return solve


def scaled_frequencies(stiffness, mass):
    """All frequencies of a dense system with diagonal masses."""
    weight = 1 / jnp.sqrt(mass)
    values = jnp.linalg.eigvalsh(
        stiffness * weight[:, None] * weight[None, :], symmetrize_input=False
    )
    # Rounding can leave a soft mode below zero.
    return jnp.sqrt(jnp.maximum(values, 1e-300)) / (2 * jnp.pi)


class NumPyStage:
    """Matrices and eigenvalues outside of JAX."""

    def __init__(self, count: int):
        self.stiffness_terms, self.mass_terms = stiffness_terms(count), mass_terms(count)

    def matrices(self, numbers):
        mass = numbers @ self.mass_terms
        return np.tensordot(numbers, self.stiffness_terms, axes=(-1, 0)), mass

    def by_scipy(self, numbers):
        """A loop over designs; only `eigh` is in it, without copies and without checks."""
        from scipy.linalg import eigh

        stiffness, mass = self.matrices(numbers)
        inertia = np.zeros_like(stiffness)
        inertia[:, range(mass.shape[1]), range(mass.shape[1])] = mass
        values = [
            eigh(k, m, eigvals_only=True, overwrite_a=True, overwrite_b=True, check_finite=False)
            for k, m in zip(stiffness, inertia, strict=True)
        ]
        return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)

    def by_numpy(self, numbers):
        stiffness, mass = self.matrices(numbers)
        weight = 1 / np.sqrt(mass)
        values = np.linalg.eigvalsh(stiffness * weight[:, :, None] * weight[:, None, :])
        return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)

    def elasticities(self, numbers):
        """Analytic: ½ p φᵀ(∂K/∂p − λ ∂M/∂p)φ / λ with the shapes of SciPy."""
        from scipy.linalg import eigh

        rows = []
        for row in numbers:
            stiffness, mass = self.matrices(row)
            values, shapes = eigh(stiffness, np.diag(mass))
            elastic = np.einsum(
                "ik,pij,jk->kp", shapes, self.stiffness_terms, shapes, optimize=True
            )
            inertial = np.einsum("ik,pi->kp", shapes**2, self.mass_terms)
            rows.append(row * (elastic - values[:, None] * inertial) / (2 * values[:, None]))
        return np.array(rows)

    def differences(self, numbers, step=1e-5):
        """Central differences of log frequencies by log numbers."""
        rows = []
        for row in numbers:
            moved = row * np.exp(step * np.concatenate([np.eye(NUMBERS), -np.eye(NUMBERS)]))
            logs = np.log(self.by_scipy(moved))
            rows.append(((logs[:NUMBERS] - logs[NUMBERS:]) / (2 * step)).T)
        return np.array(rows)
