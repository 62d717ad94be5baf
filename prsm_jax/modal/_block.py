"""Eigenvalues of one symmetry block, in a form that keeps soft modes and their derivatives exact.

A block is an arrowhead: n central bodies, each with a support and a mesh spring to one common
roller coordinate. Its matrix is formed only to find the mode shapes; eigenvalues, energies and
derivatives are then sums over springs of stiffness times elongation squared. Nothing cancels in
such a sum, so a soft support beside a mesh a 1e12 times stiffer keeps its digits, where the
eigenvalue of the matrix has lost them to rounding.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ._eigen import generalised_eigen


class SpringBlock(eqx.Module):
    """Springs and masses of one symmetry block.

    Central body j has the coordinate q_j, the rollers together q_R (last). The mesh spring
    stretches by `factor q_j + sign_j q_R`, with factor² the number of rollers that take part.
    """

    support: Float[Array, " bodies"]
    mesh: Float[Array, " bodies"]
    #: Masses of the bodies and, last, of one roller.
    mass: Float[Array, " coordinates"]
    factor: Float[Array, ""]
    signs: tuple[int, ...] = eqx.field(static=True)

    def stiffness_matrix(self) -> Float[Array, "coordinates coordinates"]:
        """Arrowhead: diagonal K_j + factor² k_j, couplings ± factor k_j, corner Σ k_j [N/m]."""
        size = len(self.signs)
        signs = jnp.asarray(self.signs, self.mesh.dtype)
        diagonal = jnp.append(self.support + self.factor**2 * self.mesh, jnp.sum(self.mesh))
        coupling = self.factor * signs * self.mesh
        matrix = jnp.diag(diagonal)
        return matrix.at[size, :size].set(coupling).at[:size, size].set(coupling)

    def elongations(
        self, shapes: Float[Array, "coordinates modes"]
    ) -> Float[Array, "bodies modes"]:
        """Stretch of the mesh springs in each mode."""
        signs = jnp.asarray(self.signs, shapes.dtype)[:, None]
        return self.factor * shapes[:-1] + signs * shapes[-1:]


@jax.custom_jvp
def block_modes(
    block: SpringBlock,
) -> tuple[Float[Array, " modes"], Float[Array, "coordinates modes"]]:
    """Eigenvalues λ (ascending) [1/s²] and mass-normalised shapes φ of a block.

    `λ_i = Σ K_j φ_ji² + Σ k_j e_ji²` with the elongations e. Derivatives, of any order:
    `dλ_i = φ_iᵀ (dK − λ_i dM) φ_i`, also summed over springs, and
    `dφ_i = Σ_{a≠i} φ_a φ_aᵀ (dK − λ_i dM) φ_i / (λ_i − λ_a) − φ_i (φ_iᵀ dM φ_i)/2`, terms of
    equal eigenvalues left out.

    **Arguments:**

    - `block`: springs and masses.
    """
    _, shapes = generalised_eigen(block.stiffness_matrix(), block.mass)
    values = jnp.sum(block.support[:, None] * shapes[:-1] ** 2, axis=0)
    values = values + jnp.sum(block.mesh[:, None] * block.elongations(shapes) ** 2, axis=0)
    order = jnp.argsort(values)
    return values[order], shapes[:, order]


@block_modes.defjvp
def _block_modes_jvp(primals, tangents):
    (block,), (change,) = primals, tangents
    values, shapes = block_modes(block)
    bodies, stretch = shapes[:-1], block.elongations(shapes)

    def weighted(weight, left, right):
        return left.T @ (weight[:, None] * right)

    moved = change.factor * weighted(block.mesh, bodies, stretch)
    stiffness = (
        weighted(change.support, bodies, bodies)
        + weighted(change.mesh, stretch, stretch)
        + moved
        + moved.T
    )
    mass = weighted(change.mass, shapes, shapes)
    # Row a, column i: φ_aᵀ (dK − λ_i dM) φ_i.
    projected = stiffness - mass * values[None, :]
    gaps = values[None, :] - values[:, None]
    distinct = gaps != 0
    mixing = jnp.where(distinct, projected / jnp.where(distinct, gaps, 1.0), 0.0)
    mixing = mixing - jnp.diag(jnp.diagonal(mass)) / 2
    return (values, shapes), (jnp.diagonal(projected), shapes @ mixing)


def mesh_energy_share(
    block: SpringBlock, shapes: Float[Array, "coordinates modes"]
) -> Float[Array, " modes"]:
    """Share of each mode's strain energy that is in the mesh springs; 0 for a rigid motion."""
    held = jnp.sum(block.support[:, None] * shapes[:-1] ** 2, axis=0)
    meshed = jnp.sum(block.mesh[:, None] * block.elongations(shapes) ** 2, axis=0)
    total = held + meshed
    strained = total > 0
    return jnp.where(strained, meshed / jnp.where(strained, total, 1.0), 0.0)
