"""Mass and stiffness matrices: the full ones, and the two small ones that symmetry leaves."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._physics import physics
from ._block import SpringBlock
from ._system import VibrationSystem


def roller_corner(system: VibrationSystem):
    """k_s + k_r + k_n, the stiffness that holds one roller by all its springs [N/m]."""
    return sum(body.mesh_stiffness for body in system.bodies)


def _block(system: VibrationSystem, support: str, mass: str, share: float) -> SpringBlock:
    bodies = system.bodies
    stiffness = jnp.stack([body.mesh_stiffness for body in bodies])
    masses = [*(getattr(body, mass) for body in bodies), system.roller_equivalent_mass]
    return SpringBlock(
        support=jnp.stack([getattr(body, support) for body in bodies]),
        mesh=stiffness,
        mass=jnp.stack(masses),
        factor=jnp.asarray((share * system.roller_count) ** 0.5, stiffness.dtype),
        signs=tuple(body.roller_sign for body in bodies),
    )


@physics("torsional_springs")
def torsional_springs(system: VibrationSystem) -> SpringBlock:
    """Harmonic 0 of the rollers: torsional modes in (u of each body, all rollers alike)."""
    return _block(system, "torsional_support", "equivalent_mass", 1.0)


@physics("transverse_springs")
def transverse_springs(system: VibrationSystem) -> SpringBlock:
    """Harmonic 1 of the rollers: transverse modes, each of them twice.

    The phases of the contacts drop out: they only turn the modes.
    """
    return _block(system, "radial_support", "mass", 0.5)


def torsional_block(
    system: VibrationSystem,
) -> tuple[Float[Array, "n n"], Float[Array, " n"]]:
    """Reduced torsional matrices: diagonal `K_ju + N k_j`, couplings `±√N k_j`, corner `Σ k_j`.

    **Returns:** stiffness matrix [N/m] and the diagonal of the mass matrix [kg].
    """
    springs = torsional_springs(system)
    return springs.stiffness_matrix(), springs.mass


def transverse_block(
    system: VibrationSystem,
) -> tuple[Float[Array, "n n"], Float[Array, " n"]]:
    """Reduced transverse matrices: diagonal `K_jx + N/2 k_j`, couplings `±√(N/2) k_j`.

    **Returns:** stiffness matrix [N/m] and the diagonal of the mass matrix [kg].
    """
    springs = transverse_springs(system)
    return springs.stiffness_matrix(), springs.mass


@physics("dense_assembly")
def dense_matrices(
    system: VibrationSystem, phases: Float[Array, " bodies"] | None = None
) -> tuple[Float[Array, "n n"], Float[Array, " n"]]:
    """Full matrices in q = [x, y, u of each central body; u of each roller; u of the carrier].

    Every mesh spring stretches by `δ = gᵀ q`, so `K = Σ k g gᵀ` plus the supports is positive
    semidefinite by construction. For a body j and roller i at φ_i = 2π(i − 1)/N the row g holds
    `−sin φ`, `cos φ`, 1 on the body and ±1 on the roller, with φ = α_s − φ_i on the screw and
    φ = α_j + φ_i on ring gear and nut (Wu et al. 2022, equations 7 to 13).

    **Arguments:**

    - `system`: the masses and springs.
    - `phases`: contact phases α_s, α_r, α_n [rad]; zero if not given. They do not change the
      frequencies of equal rollers.

    **Returns:** stiffness matrix [N/m] and the diagonal of the mass matrix [kg].
    """
    count, bodies = system.roller_count, system.bodies
    dtype = system.roller_equivalent_mass.dtype
    size = 3 * len(bodies) + count + (system.carrier is not None)
    if phases is None:
        phases = jnp.zeros(len(bodies), dtype)
    positions = 2 * jnp.pi * jnp.arange(count, dtype=dtype) / count
    support, mass = [], []
    stiffness = jnp.zeros((size, size), dtype)
    for index, body in enumerate(bodies):
        angle = phases[index] - body.roller_sign * positions
        rows = jnp.zeros((count, size), dtype)
        rows = rows.at[:, 3 * index].set(-jnp.sin(angle))
        rows = rows.at[:, 3 * index + 1].set(jnp.cos(angle))
        rows = rows.at[:, 3 * index + 2].set(1.0)
        rollers = 3 * len(bodies) + jnp.arange(count)
        rows = rows.at[jnp.arange(count), rollers].set(float(body.roller_sign))
        stiffness = stiffness + body.mesh_stiffness * rows.T @ rows
        support += [body.radial_support, body.radial_support, body.torsional_support]
        mass += [body.mass, body.mass, body.equivalent_mass]
    support += [jnp.zeros((), dtype)] * count
    mass += [system.roller_equivalent_mass] * count
    if system.carrier is not None:
        support.append(system.carrier.torsional_support)
        mass.append(system.carrier.equivalent_mass)
    return stiffness + jnp.diag(jnp.stack(support)), jnp.stack(mass)
