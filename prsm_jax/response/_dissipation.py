"""Damping as matrices: the laws of a mechanism, dashpots at single springs, or any matrix."""

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._errors import UnknownNameError, closest
from ..fields import Scalar
from ..mechanism import Damping, DampingLaw, Stage
from ..numerics import above_or_nan
from ..programs import physics
from ..vibration import SpringModes, SpringNetwork, spring_modes


class Dissipation(eqx.Module):
    """Damping of a network: forces `C q̇`, and `i H q` in steady harmonic vibration.

    Either may be any matrix, proportional or not; `None` means no such damping.
    """

    #: C [N·s/m].
    viscous: Float[Array, "coordinates coordinates"] | None = None
    #: H [N/m], η K where every spring has the loss factor η.
    hysteretic: Float[Array, "coordinates coordinates"] | None = None


#: Use the damping of the mechanism, if it has any.
AsGiven: TypeAlias = Literal["given"]
#: Types of the damping of a response; an array is a viscous matrix C.
AnyDamping: TypeAlias = Damping | Dissipation | Float[Array, "coordinates coordinates"]


def scaled_modes(network: SpringNetwork) -> tuple[Float[Array, "n n"], Float[Array, " n"]]:
    """Orthonormal eigenvectors of `M^{-1/2} K M^{-1/2}`, and ω [rad/s], as constants."""
    modes: SpringModes = spring_modes(jax.lax.stop_gradient(network))
    weight = jnp.sqrt(jax.lax.stop_gradient(network.mass))
    values = jnp.maximum(modes.eigenvalues, 0.0)
    return weight[:, None] * modes.shapes, jnp.sqrt(values)


@jax.custom_jvp
def _square_root(matrix, vectors, roots):
    """The square root of a matrix, from its eigenvectors and the roots of its eigenvalues."""
    return (vectors * roots[None, :]) @ vectors.T


@_square_root.defjvp
def _square_root_jvp(primals, tangents):
    matrix, vectors, roots = primals
    root = _square_root(matrix, vectors, roots)

    def solve(_, right):
        # Divided by sums of roots, not by gaps: repeated roots need no special case.
        total = roots[:, None] + roots[None, :]
        some = above_or_nan(total)
        share = jnp.where(some, 1 / jnp.where(some, total, 1.0), 0.0)
        return vectors @ (share * (vectors.T @ right @ vectors)) @ vectors.T

    change = jax.lax.custom_linear_solve(
        lambda x: root @ x + x @ root, tangents[0], solve, symmetric=True
    )
    return root, change


class _OfNetwork(NamedTuple):
    """Mass and stiffness of a network (`mechanism.MassAndStiffness`)."""

    network: SpringNetwork

    @property
    def mass(self) -> Float[Array, " n"]:
        return self.network.mass

    def stiffness_matrix(self) -> Float[Array, "n n"]:
        return self.network.stiffness_matrix()

    def square_root(self) -> Float[Array, "n n"]:
        weight = jnp.sqrt(self.mass)
        scale = weight[:, None] * weight[None, :]
        vectors, roots = scaled_modes(self.network)
        return scale * _square_root(self.stiffness_matrix() / scale, vectors, roots)


def dissipation(network: SpringNetwork, damping: AnyDamping | None) -> Dissipation:
    """The damping matrices of a network under a law.

    Those of a law follow from its methods. A `Dissipation` or a matrix C is used unchanged.

    **Arguments:**

    - `network`: the springs and masses.
    - `damping`: a law, a viscous matrix, a `Dissipation`, or `None` for no damping.

    **Raises:** `ValueError` for a matrix that does not fit the network.
    """
    if damping is None:
        return Dissipation()
    if isinstance(damping, DampingLaw):
        of = _OfNetwork(network)
        losses = Dissipation(damping.viscous_matrix(of), damping.hysteretic_matrix(of))
    elif isinstance(damping, Dissipation):
        losses = damping
    else:
        losses = Dissipation(jnp.asarray(damping))
    size = len(network.coordinates)
    for name in ("viscous", "hysteretic"):
        matrix = getattr(losses, name)
        if matrix is not None and matrix.shape != (size, size):
            raise ValueError(
                f"the {name} damping matrix has shape {matrix.shape}; the stage has {size} degrees "
                f"of freedom, so give {(size, size)}"
            )
    return losses


def checked_damping(damping: Any) -> Any:
    """The damping of a call.

    **Raises:** `ValueError` for a number or a text.
    """
    if isinstance(damping, str) and damping == "given":
        return damping
    if isinstance(damping, str) or (damping is not None and _is_number(damping)):
        ratio = damping if isinstance(damping, float) else 0.02
        raise ValueError(
            f"damping is {damping!r}; give a law such as prsm_jax.mechanism.ModalDamping({ratio}), "
            'a viscous damping matrix, None, or "given" for that of the stage'
        )
    return damping


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | complex | np.ndarray | jax.Array) and not np.ndim(value)


def stage_damping(stage: Stage, damping: AnyDamping | AsGiven | None) -> AnyDamping | None:
    """The damping to use: that of the stage, or the given one."""
    return stage.damping if isinstance(damping, str) else damping


@physics("spring_damping")
def spring_damping(
    network: SpringNetwork,
    viscous: Mapping[str, float | Scalar] | None = None,
    loss_factor: Mapping[str, float | Scalar] | None = None,
) -> Dissipation:
    """Damping of single springs: a parallel dashpot, or a loss factor of the material.

    `C = Gᵀ diag(c) G`, `H = Gᵀ diag(η k) G` with the elongations G of the springs. In general not
    proportional: only the direct solution accepts it.

    **Arguments:**

    - `network`: the springs and masses.
    - `viscous`: damping constant c [N·s/m] by the name of the springs, such as
      `{"screw_roller": 50.0}` for those of all rollers or `{"nut_roller 3": 80.0}` for one.
    - `loss_factor`: loss factor η by name.

    **Raises:** `UnknownNameError` for a spring that does not exist.
    """

    def matrix(factors: Mapping[str, float | Scalar] | None, scale: Array):
        if not factors:
            return None
        total = jnp.zeros_like(network.stiffness)
        for name, value in factors.items():
            indices = [k for k, s in enumerate(network.springs) if name in (s.name, str(s))]
            if not indices:
                known = {spring.name for spring in network.springs}
                raise UnknownNameError(f"unknown spring {name!r}; {closest(name, known)}")
            total = total.at[jnp.asarray(indices)].add(jnp.asarray(value, total.dtype))
        return network.rows.T @ ((total * scale)[:, None] * network.rows)

    return Dissipation(
        matrix(viscous, jnp.ones_like(network.stiffness)), matrix(loss_factor, network.stiffness)
    )
