"""At a natural frequency: which amplitudes are infinite, and the limits of the others.

`q = Σ φ φᵀ f / (ω_k² − ω²)` is infinite where the modes of the pole together have a residue
`Σ φ φᵀ f` other than zero. Every other amplitude has a limit: the sum without these modes.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap
from jaxtyping import Array, Bool, Float, Inexact

from ..fields import Scalar
from ..vibration import SpringNetwork, clusters
from ._dissipation import scaled_modes

#: Two solvers of the same eigenproblem agree to this many units of the rounding of ω².
_AGREEMENT = 8


def rounding(values: Array) -> float:
    """Bound on the relative rounding of sums over the axis of an array."""
    return values.shape[-1] * float(jnp.finfo(values.dtype).eps)


def shape_rounding(shapes: Array) -> float:
    """Bound on the relative rounding of a shape, which that of its neighbours enlarges: ε^(2/3)."""
    return float(jnp.finfo(shapes.dtype).eps) ** (2 / 3)


class ScaledModes(eqx.Module):
    """Modes in coordinates `√m q`, as constants; a repeated root has one value."""

    #: Orthonormal, a column for each mode.
    vectors: Float[Array, "n n"]
    #: ω_k [rad/s].
    roots: Float[Array, " n"]
    #: ω_k², the mean of its cluster [rad²/s²].
    squares: Float[Array, " n"]

    def met(
        self, omega: Scalar, lost: Float[Array, " n"], noise: float | Scalar = 0.0
    ) -> Bool[Array, " n"]:
        """Whether ω is the natural frequency of each mode, with no loss, within rounding.

        **Arguments:**

        - `omega`: ω [rad/s].
        - `lost`: the imaginary part that damping adds to `ω_k² − ω²` [rad²/s²].
        - `noise`: rounding of `lost` [rad²/s²].
        """
        # Rounding errors of ω² and ω_k² are relative; for rigid motions relative to the largest.
        share = rounding(self.squares)
        relative = _AGREEMENT * share * (self.squares + omega**2)
        away = jnp.abs(self.squares - omega**2) + jnp.abs(lost)
        return away <= relative + share**2 * jnp.max(self.squares) + noise

    def residue(
        self, which: Bool[Array, " n"], right: Inexact[Array, "n loads"]
    ) -> Inexact[Array, "n loads"]:
        """Residue of some modes together, by coordinate and load, without its rounding error.

        A mode takes part with more than ε^(4/3) of its energy, for the rounding ε: 1e-21 in double
        precision.
        """
        right = jax.lax.stop_gradient(right)
        chosen = jnp.where(which[None, :], self.vectors, 0.0)
        pushed = chosen.T.astype(right.dtype) @ right
        residue = chosen.astype(right.dtype) @ pushed
        reach = jnp.sqrt(jnp.sum(chosen**2, axis=1))
        load, push = (jnp.sqrt(jnp.sum(jnp.abs(x) ** 2, axis=0)) for x in (right, pushed))
        still = shape_rounding(self.vectors)
        moves = jnp.abs(residue) > still * (reach[:, None] * load[None, :] + push[None, :])
        return jnp.where(moves, residue, jnp.zeros_like(residue))


def modes_of(network: SpringNetwork) -> ScaledModes:
    """The modes of a network, as constants."""
    vectors, roots = scaled_modes(network)
    same = clusters(roots**2).astype(roots.dtype)
    return ScaledModes(vectors, roots, (same @ roots**2) / jnp.sum(same, axis=1))


@custom_vmap
def anywhere(given: Bool[Array, " frequencies"]) -> Bool[Array, ""]:
    """Whether any is true, of all designs of a batch: a `cond` then leaves out what none needs."""
    return jnp.any(given)


@anywhere.def_vmap
def _anywhere_of_all(axis_size, in_batched, given):
    return anywhere(given.ravel()), False
