r"""Displacements that are shared by many threads: of a free nut, or shapes of bent rollers.

Each unknown $p_m$ [m] opens the gaps of threads by a fixed share of itself, on the nut side, the
screw side, or both. The unknowns minimise the same convex energy as all others, with
$\tfrac12 p^T K p$ of the springs that hold them, less the work of the given loads.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import jax.scipy.linalg
from jaxtyping import Array, Float

from ...fields import Scalar

#: Decrease of an approach, or opening of gaps, per displacement.
PerDisplacement = Float[Array, "displacements classes threads"]
PerThread = Float[Array, "classes threads"]


class SideCoupling(eqx.Module):
    """Change of the gaps on one side over the displacements."""

    #: Change of the approach of forward flanks (reverse ones: the opposite), with its sign turned.
    axial: PerDisplacement
    #: Opening of both flanks; `None` where threads have one flank: then `axial` contains it.
    radial: PerDisplacement | None

    def shift(self, displacement: Float[Array, " displacements"]) -> PerThread:
        """Decrease of the approach of the forward flanks [m]."""
        return jnp.tensordot(displacement, self.axial, axes=1)

    def opening(self, displacement: Float[Array, " displacements"]) -> PerThread | float:
        """Opening of both flanks [m]; 0 where threads have one."""
        return 0.0 if self.radial is None else jnp.tensordot(displacement, self.radial, axes=1)

    def forces(
        self, force: PerThread, force_sum: PerThread | None
    ) -> Float[Array, " displacements"]:
        """Force of the flanks on each displacement [N].

        **Arguments:**

        - `force`, `force_sum`: on this side, net and of both flanks together [N].
        """
        forces = jnp.tensordot(self.axial, force, axes=2)
        if self.radial is None:
            return forces
        assert force_sum is not None
        return forces + jnp.tensordot(self.radial, force_sum, axes=2)


class Displacements(eqx.Module):
    """Unknown displacements: what they do to the gaps, what holds them, and the loads on them."""

    nut: SideCoupling
    #: `None` where they leave the screw side as it is.
    screw: SideCoupling | None
    #: Loads on the displacements [N].
    load: Float[Array, " displacements"]
    #: Stiffness of the springs that hold them [N/m]; `None` without springs.
    stiffness: Float[Array, "displacements displacements"] | None = None

    @property
    def count(self) -> int:
        """Number of displacements."""
        return self.load.shape[0]

    def held(
        self, displacement: Float[Array, " displacements"], regularisation: Scalar
    ) -> Float[Array, " displacements"]:
        """Force of the springs and the loads, against the displacements [N].

        **Arguments:**

        - `displacement`: the displacements [m].
        - `regularisation`: stiffness of the regularising springs [N/m].
        """
        force = regularisation * displacement - self.load
        return force if self.stiffness is None else force + self.stiffness @ displacement

    def stored(self, displacement: Float[Array, " displacements"]) -> Scalar | float:
        """Elastic energy in the springs [J]."""
        if self.stiffness is None:
            return 0.0
        return displacement @ self.stiffness @ displacement / 2


def joined(first: Displacements | None, second: Displacements | None) -> Displacements | None:
    """Both kinds of displacements, the first in front."""
    if first is None or second is None:
        return second if first is None else first
    both = first, second
    screw = None
    if first.screw is not None or second.screw is not None:
        screw = _in_rows(*(_zero(one.nut) if one.screw is None else one.screw for one in both))
    stiffness = None
    if first.stiffness is not None or second.stiffness is not None:
        square = [jnp.zeros((one.count, one.count), one.load.dtype) for one in both]
        given = [one.stiffness for one in both]
        stiffness = jax.scipy.linalg.block_diag(
            *(none if one is None else one for none, one in zip(square, given, strict=True))
        )
    load = jnp.concatenate([first.load, second.load])
    return Displacements(_in_rows(first.nut, second.nut), screw, load, stiffness)


def _zero(side: SideCoupling) -> SideCoupling:
    return jax.tree.map(jnp.zeros_like, side)


def _in_rows(first: SideCoupling, second: SideCoupling) -> SideCoupling:
    return jax.tree.map(lambda one, other: jnp.concatenate([one, other]), first, second)
