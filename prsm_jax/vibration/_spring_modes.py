"""Modes of any spring network, with derivatives that hold at repeated roots.

The shapes are the right singular vectors of `√k G M^{-1/2}`, the square root of the dynamic
matrix: its small singular values keep twice the digits that the small eigenvalues of the matrix
would have. Eigenvalues are then sums over springs, in which nothing cancels.

At a repeated root the eigenvalues form a cluster. Differentiable are the mean of its eigenvalues
or frequencies, and everything that belongs to its whole subspace (summed energies, receptances,
projections). A single eigenvalue is differentiable only if the change does not split the cluster,
and a single shape never is. The rules below therefore treat a cluster as a small matrix
`B = Vᴴ A V` on a subspace; the subspace turns towards others, but not within itself. Each member
gets the mean slope of its cluster. This is exact to second order for everything that is
differentiable, and finite for the rest. `directional_slopes` gives the slopes of the single
members along a given change.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Inexact

from ..numerics import above_or_nan, hermitian_eigenvalues, singular_values
from .model import SpringNetwork

#: Relative distance below which eigenvalues are one cluster. Those of an exact cluster differ by
#: about 1e-15. At a distance in between the root is nearly repeated; the error of a mean slope
#: over such a narrow gap is only in how the members separate.
_CLUSTER = 1e-11
#: A frequency below this share of the largest one is that of a rigid motion: rounding leaves it at
#: about 1e-16, and no spring is that soft.
RIGID_SHARE = 1e-13
#: The same for eigenvalues, which are squares of frequencies.
_ZERO = RIGID_SHARE**2


class SpringModes(eqx.Module):
    """Modes of a spring network, ascending."""

    #: ω² [1/s²].
    eigenvalues: Float[Array, " modes"]
    #: ω [rad/s].
    angular_frequencies: Float[Array, " modes"]
    #: Mass-normalised, φᵀ M φ = 1 [1/√kg]; a column for each mode.
    shapes: Inexact[Array, "coordinates modes"]


def clusters(eigenvalues: Float[Array, " modes"]) -> Bool[Array, "modes modes"]:
    """Which pairs of ascending eigenvalues belong to one repeated root."""
    values = jax.lax.stop_gradient(eigenvalues)
    floor = _ZERO * values[-1]
    parted = jnp.diff(values) > _CLUSTER * values[1:] + floor
    number = jnp.concatenate([jnp.zeros((1,), int), jnp.cumsum(parted.astype(int))])
    return number[:, None] == number[None, :]


def _stretches(stiffness, rows, vectors, values):
    """Elongation of every spring in every mode, accurate in stiff springs too.

    In a soft mode a stiff spring hardly stretches: `G v` is mainly rounding of v, which the
    stiffness turns into a large force. But the forces must be in equilibrium, `Gᴴ k G v = λ v`.
    The residual gives the error δ of v, its share of stiffer modes: `A δ = A v − λ v`.
    """
    stretch = rows @ vectors
    residual = rows.conj().T @ (stiffness[:, None].astype(rows.dtype) * stretch)
    residual = residual - vectors * values[None, :].astype(rows.dtype)
    stiffer = values[:, None] > jnp.maximum(values, _ZERO * jnp.max(values))[None, :]
    divisor = jnp.where(stiffer, values[:, None], 1.0).astype(rows.dtype)
    share = vectors.conj().T @ residual / divisor
    error = vectors @ jnp.where(stiffer, share, jnp.zeros_like(share))
    # The correction is zero except for rounding, and so are its derivatives.
    return stretch - jax.lax.stop_gradient(rows @ error)


def _projected_change(stiffness, rows, vectors, values, stiffness_change, rows_change):
    """Vᴴ dA V for A = Gᴴ k G, as sums over springs."""
    dtype = rows.dtype
    stretch = _stretches(stiffness, rows, vectors, values)
    moved = stretch.conj().T @ (stiffness[:, None].astype(dtype) * (rows_change @ vectors))
    change = stretch.conj().T @ (stiffness_change[:, None].astype(dtype) * stretch)
    return change + moved + moved.conj().T


def _diagonal(matrix):
    return jnp.real(jnp.diagonal(matrix))


# The two functions below solve `B X − X B = −C` and `R Y + Y R = C` for B and R that are diagonal
# in value, but whose derivatives have entries off the diagonal. The second term is zero in value
# and adds the effect of these entries. Custom derivative rules would not suffice: reverse mode
# transposes the function itself, so forward over reverse would see a diagonal matrix only.


def _off_diagonal(matrix):
    return matrix - jnp.diag(jnp.diagonal(matrix))


def _turn(blocks, change):
    """Rotation of subspaces into each other: X with `B X − X B = −change`, 0 within a cluster."""
    values = _diagonal(blocks)
    same_cluster = clusters(values)
    gaps = jnp.where(same_cluster, 1.0, values[None, :] - values[:, None]).astype(change.dtype)

    def divided(matrix):
        return jnp.where(same_cluster, jnp.zeros_like(matrix), matrix / gaps)

    first, rest = divided(change), _off_diagonal(blocks)
    return first + divided(rest @ first - first @ rest)


def _halved(root, change):
    """Y with `root Y + Y root = change`; 0 where the root is zero within rounding."""
    values = _diagonal(root)
    total = values[None, :] + values[:, None]
    nonzero = above_or_nan(total, jax.lax.stop_gradient(_ZERO**0.5 * jnp.max(values)))
    divisor = jnp.where(nonzero, total, 1.0).astype(change.dtype)

    def divided(matrix):
        return jnp.where(nonzero, matrix / divisor, jnp.zeros_like(matrix))

    first, rest = divided(change), _off_diagonal(root)
    return first - divided(rest @ first + first @ rest)


@jax.custom_jvp
def _modes(stiffness, rows):
    """Blocks B = Vᴴ A V of the clusters, diagonal in value and ascending, and the vectors V."""
    root = jnp.sqrt(stiffness)[:, None].astype(rows.dtype) * rows
    singular, vectors = singular_values(root)
    order = jnp.argsort(singular)
    return jnp.diag(singular[order] ** 2).astype(rows.dtype), vectors[:, order]


@_modes.defjvp
def _modes_jvp(primals, tangents):
    (stiffness, rows), (stiffness_change, rows_change) = primals, tangents
    blocks, vectors = _modes(stiffness, rows)
    values = _diagonal(blocks)
    projected = _projected_change(stiffness, rows, vectors, values, stiffness_change, rows_change)
    same_cluster = clusters(values)
    within = jnp.where(same_cluster, projected, jnp.zeros_like(projected))
    return (blocks, vectors), (within, vectors @ _turn(blocks, projected))


@jax.custom_jvp
def _matrix_root(blocks):
    """√B of blocks that are diagonal in value."""
    values = jnp.sqrt(jnp.maximum(_diagonal(blocks), 0.0))
    return jnp.diag(values).astype(blocks.dtype)


@_matrix_root.defjvp
def _matrix_root_jvp(primals, tangents):
    root = _matrix_root(*primals)
    return root, _halved(root, *tangents)


def _cluster_means(same_cluster, values):
    members = same_cluster.astype(values.dtype)
    # The values are unchanged: only their derivatives are averaged.
    mean = members @ values / jnp.sum(members, axis=1)
    return jax.lax.stop_gradient(values - mean) + mean


def _scaled(network: SpringNetwork):
    weight = 1 / jnp.sqrt(network.mass)
    return network.stiffness, network.rows * weight[None, :].astype(network.rows.dtype), weight


def spring_modes(network: SpringNetwork) -> SpringModes:
    """Eigenvalues and mass-normalised shapes of a spring network.

    Derivatives, of first and second order, with dA of the mass-scaled matrix A and its
    orthonormal vectors v: `dλ_i = mean over the cluster of v_jᵀ dA v_j` and
    `dv_i = Σ v_a v_aᵀ dA v_i / (λ_i − λ_a)` over all a outside the cluster of i, so a vanishing gap
    is never a divisor. At a repeated root, means and sums over its members are differentiable; a
    single member of a root that the change splits (see `directional_slopes`) and a single shape
    are not.

    **Arguments:**

    - `network`: the springs and masses; at least as many springs as coordinates, none negative.
    """
    stiffness, rows, weight = _scaled(network)
    blocks, vectors = _modes(stiffness, rows)
    same_cluster = clusters(_diagonal(blocks))
    return SpringModes(
        _cluster_means(same_cluster, _diagonal(blocks)),
        _cluster_means(same_cluster, _diagonal(_matrix_root(blocks))),
        weight[:, None].astype(vectors.dtype) * vectors,
    )


def directional_slopes(
    network: SpringNetwork, change: SpringNetwork
) -> tuple[Float[Array, " modes"], Float[Array, " modes"], Float[Array, " modes"]]:
    """Eigenvalues, and their one-sided slopes along a change of the network.

    The slopes of a repeated root are the eigenvalues of `Φᵀ (dK − λ dM) Φ` in its subspace. The
    forward derivatives of the ascending eigenvalues are these slopes in ascending order, the
    backward derivatives in descending order. Both agree only if the root does not split.

    **Arguments:**

    - `network`: the springs and masses.
    - `change`: their tangent, as `jax.jvp` of the network gives it.

    **Returns:** eigenvalues, forward slopes, backward slopes.
    """
    (stiffness, rows), (stiffness_change, rows_change) = jax.jvp(
        lambda n: _scaled(n)[:2], (network,), (change,)
    )
    blocks, vectors = _modes(stiffness, rows)
    values = _diagonal(blocks)
    projected = _projected_change(stiffness, rows, vectors, values, stiffness_change, rows_change)
    same_cluster = clusters(values)
    inside = jnp.where(same_cluster, projected, jnp.zeros_like(projected))
    # One eigenproblem for all clusters, each scaled to a norm of one.
    size = jnp.sqrt(same_cluster.astype(values.dtype) @ jnp.sum(jnp.abs(inside) ** 2, axis=1))
    size = jnp.where(size == 0, 1.0, size)
    slopes = hermitian_eigenvalues(inside / size[:, None].astype(inside.dtype)) * size
    first = jnp.argmax(same_cluster, axis=1)
    _, slopes = jax.lax.sort((first, slopes), num_keys=2)
    last = first + jnp.sum(same_cluster, axis=1) - 1
    return values, slopes, slopes[first + last - jnp.arange(len(values))]
