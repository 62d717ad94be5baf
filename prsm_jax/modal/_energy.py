"""Where the energy of a mode is: kinetic by body, strain by kind of spring."""

import jax.numpy as jnp
from jaxtyping import Array, Float, Inexact

from ._spring_network import SpringNetwork


def _gathered(names: list[str], energy: Float[Array, "items modes"]) -> dict[str, Array]:
    """Rows of equal name added up, as shares of the sum of all; zero where there is no energy."""
    total = jnp.sum(energy, axis=0, keepdims=True)
    any_at_all = total > 0
    shares = jnp.where(any_at_all, energy / jnp.where(any_at_all, total, 1.0), 0.0)
    rows: dict[str, Array] = {}
    for name, row in zip(names, shares, strict=True):
        rows[name] = rows[name] + row if name in rows else row
    return rows


def kinetic_energy_shares(
    network: SpringNetwork, shapes: Inexact[Array, "coordinates modes"], *, each_roller=False
) -> dict[str, Float[Array, " modes"]]:
    """Share of each mode's kinetic energy in each body.

    **Arguments:**

    - `network`: the springs and masses.
    - `shapes`: a column for each mode, of any scale.
    - `each_roller`: list every roller by itself, instead of all of them as `roller`.
    """
    energy = network.mass[:, None] * jnp.abs(shapes) ** 2
    bodies = [coordinate.body for coordinate in network.coordinates]
    if not each_roller:
        bodies = ["roller" if body.startswith("roller ") else body for body in bodies]
    return _gathered(bodies, energy)


def strain_energy_shares(
    network: SpringNetwork, shapes: Inexact[Array, "coordinates modes"], *, each_spring=False
) -> dict[str, Float[Array, " modes"]]:
    """Share of each mode's strain energy in each kind of spring; all zero for a rigid motion.

    **Arguments:**

    - `network`: the springs and masses.
    - `shapes`: a column for each mode, of any scale.
    - `each_spring`: list the springs of every roller by themselves.
    """
    energy = network.stiffness[:, None] * jnp.abs(network.rows @ shapes) ** 2
    names = [str(spring) if each_spring else spring.name for spring in network.springs]
    return _gathered(names, energy)
