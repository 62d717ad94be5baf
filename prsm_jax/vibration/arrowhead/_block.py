"""Modes of one symmetry block, in a form that keeps soft modes and their derivatives exact.

A block is an arrowhead: up to three central bodies, each with a support and a mesh spring to one
common roller coordinate. Its eigenvalues come from a secular equation of springs in series, and
energies and derivatives are sums over springs of stiffness times elongation squared. Nothing
cancels in them, so a soft support beside a mesh 1e12 times stiffer keeps its digits, whereas an
eigenvalue of the matrix loses them to rounding.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...numerics import above_or_nan
from ._arrowhead import arrowhead_modes


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


def block_modes(
    block: SpringBlock,
) -> tuple[Float[Array, " modes"], Float[Array, "coordinates modes"]]:
    """Eigenvalues λ (ascending) [1/s²] and mass-normalised shapes φ of a block.

    `λ_i = Σ K_j φ_ji² + Σ k_j e_ji²` with the elongations e. Derivatives of any order are closed
    forms, see `arrowhead_modes`; in those of shapes, terms of equal eigenvalues are omitted.

    **Arguments:**

    - `block`: springs and masses of one to three bodies.
    """
    numbers = (block.support, block.mesh, block.mass)
    modes = arrowhead_modes(*(tuple(values) for values in numbers), block.factor)
    signs = (*block.signs, 1)
    rows = [
        jnp.stack([sign * shape[place] for shape in modes.shapes])
        for place, sign in enumerate(signs)
    ]
    return jnp.stack(modes.values), jnp.stack(rows)


def mesh_energy_share(
    block: SpringBlock, shapes: Float[Array, "coordinates modes"]
) -> Float[Array, " modes"]:
    """Share of each mode's strain energy that is in the mesh springs; 0 for a rigid motion."""
    supported = jnp.sum(block.support[:, None] * shapes[:-1] ** 2, axis=0)
    meshed = jnp.sum(block.mesh[:, None] * block.elongations(shapes) ** 2, axis=0)
    total = supported + meshed
    strained = above_or_nan(total)
    return jnp.where(strained, meshed / jnp.where(strained, total, 1.0), 0.0)
