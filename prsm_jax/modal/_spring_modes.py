"""Modes of any spring network, with derivatives that hold at repeated roots.

The shapes are the right singular vectors of `√k G M^{-1/2}`, the square root of the dynamic
matrix: its small singular values keep twice the digits that the small eigenvalues of the matrix
would have. Eigenvalues are then sums over springs, in which nothing cancels.

What is differentiable at a repeated root, and what is not: the sum of a cluster's eigenvalues and
everything that belongs to its whole subspace (energy shares, receptances, projections) are; the
single eigenvalue is not, unless the change leaves the cluster together, and the single shape never
is. The rule below gives each member the mean slope of its cluster and turns no shape within it.
That is exact for everything that is differentiable, to second order too, and finite for the rest.
How the members of a cluster part along a given change is what `directional_slopes` gives.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Inexact

from ._spring_network import SpringNetwork

#: Eigenvalues closer than this share of themselves are one cluster. Those of an exact cluster
#: differ by about 1e-15; what lies between is a nearly repeated root, for which a mean slope
#: over so narrow a gap is off only in how the members part.
_CLUSTER = 1e-11
#: Below this share of the largest eigenvalue a root is zero: a rigid motion leaves 1e-32.
_ZERO = 1e-26


class SpringModes(eqx.Module):
    """Modes of a spring network, ascending."""

    #: ω² [1/s²].
    eigenvalues: Float[Array, " modes"]
    #: Mass-normalised, φᵀ M φ = 1 [1/√kg]; a column for each mode.
    shapes: Inexact[Array, "coordinates modes"]


def clusters(eigenvalues: Float[Array, " modes"]) -> Bool[Array, "modes modes"]:
    """Which pairs of ascending eigenvalues belong to one repeated root."""
    values = jax.lax.stop_gradient(eigenvalues)
    floor = _ZERO * values[-1]
    parted = jnp.diff(values) > _CLUSTER * values[1:] + floor
    number = jnp.concatenate([jnp.zeros((1,), int), jnp.cumsum(parted.astype(int))])
    return number[:, None] == number[None, :]


def _projected_change(stiffness, rows, vectors, stiffness_change, rows_change):
    """Vᴴ dA V for A = Gᴴ k G, as sums over springs."""
    dtype = rows.dtype
    stretch = rows @ vectors
    moved = stretch.conj().T @ (stiffness[:, None].astype(dtype) * (rows_change @ vectors))
    change = stretch.conj().T @ (stiffness_change[:, None].astype(dtype) * stretch)
    return change + moved + moved.conj().T


@jax.custom_jvp
def _modes(stiffness, rows):
    root = jnp.sqrt(stiffness)[:, None].astype(rows.dtype) * rows
    # Unit size, so that float32 keeps its range.
    size = jnp.max(jnp.abs(root))
    size = jnp.where(size > 0, size, 1.0)
    _, _, adjoint = jnp.linalg.svd(root / size.astype(rows.dtype), full_matrices=False)
    vectors = adjoint.conj().T
    values = jnp.sum(stiffness[:, None] * jnp.abs(rows @ vectors) ** 2, axis=0)
    order = jnp.argsort(values)
    return values[order], vectors[:, order]


@_modes.defjvp
def _modes_jvp(primals, tangents):
    values, vectors = _modes(*primals)
    (stiffness, rows), (stiffness_change, rows_change) = primals, tangents
    projected = _projected_change(stiffness, rows, vectors, stiffness_change, rows_change)
    together = clusters(values)
    slopes = jnp.real(jnp.diagonal(projected))
    members = together.astype(slopes.dtype)
    mean = members @ slopes / jnp.sum(members, axis=1)
    gaps = values[None, :] - values[:, None]
    turn = projected / jnp.where(together, 1.0, gaps).astype(projected.dtype)
    turn = jnp.where(together, jnp.zeros_like(turn), turn)
    return (values, vectors), (mean, vectors @ turn)


def _scaled(network: SpringNetwork):
    weight = 1 / jnp.sqrt(network.mass)
    return network.stiffness, network.rows * weight[None, :].astype(network.rows.dtype), weight


def spring_modes(network: SpringNetwork) -> SpringModes:
    """Eigenvalues and mass-normalised shapes of a spring network.

    Derivatives, of first and second order, with dA of the mass-scaled matrix A and its
    orthonormal vectors v: `dλ_i = mean over the cluster of v_jᵀ dA v_j` and
    `dv_i = Σ v_a v_aᵀ dA v_i / (λ_i − λ_a)` over the a outside of i's cluster. See the head of
    this module for what they mean at repeated roots.

    **Arguments:**

    - `network`: the springs and masses; no fewer springs than coordinates, none negative.
    """
    stiffness, rows, weight = _scaled(network)
    values, vectors = _modes(stiffness, rows)
    return SpringModes(values, weight[:, None].astype(vectors.dtype) * vectors)


def directional_slopes(
    network: SpringNetwork, change: SpringNetwork
) -> tuple[Float[Array, " modes"], Float[Array, " modes"], Float[Array, " modes"]]:
    """Eigenvalues, and their one-sided slopes along a change of the network.

    The slopes of a repeated root are the eigenvalues of `Φᵀ (dK − λ dM) Φ` in its subspace. Going
    forward the ascending eigenvalues take them in ascending order, coming from behind in
    descending order: the two one-sided derivatives agree only where the root does not part.

    **Arguments:**

    - `network`: the springs and masses.
    - `change`: their tangent, as `jax.jvp` of the network gives it.

    **Returns:** eigenvalues, slopes forward, slopes from behind.
    """
    (stiffness, rows), (stiffness_change, rows_change) = jax.jvp(
        lambda n: _scaled(n)[:2], (network,), (change,)
    )
    values, vectors = _modes(stiffness, rows)
    projected = _projected_change(stiffness, rows, vectors, stiffness_change, rows_change)
    together = clusters(values)
    inside = jnp.where(together, projected, jnp.zeros_like(projected))
    # One eigenproblem for all clusters: scaled to a norm of one, and each shifted so far that the
    # ascending eigenvalues come cluster by cluster.
    size = jnp.linalg.norm(inside)
    size = jnp.where(size > 0, size, 1.0)
    first = jnp.argmax(together, axis=1)
    shift = 3.0 * first.astype(values.dtype)
    shifted = jnp.linalg.eigvalsh(
        inside / size.astype(inside.dtype) + jnp.diag(shift).astype(inside.dtype)
    )
    slopes = (shifted - shift) * size
    last = first + jnp.sum(together, axis=1) - 1
    number = jnp.arange(len(values))
    last = first.astype(int) + jnp.sum(together, axis=1) - 1
    return values, slopes, slopes[first + last - number]
