"""Energies of modes: kinetic by body, strain by kind of spring."""

import jax.numpy as jnp
from jaxtyping import Array, Float, Inexact

from ...numerics import above_or_nan
from ._spring_network import SpringNetwork


def _gathered(names: list[str], energy: Float[Array, "items modes"]) -> dict[str, Array]:
    """Sums of the rows of equal name."""
    rows: dict[str, Array] = {}
    for name, row in zip(names, energy, strict=True):
        rows[name] = rows[name] + row if name in rows else row
    return rows


def kinetic_energies(
    network: SpringNetwork,
    shapes: Inexact[Array, "coordinates modes"],
    *,
    each_roller: bool = False,
) -> dict[str, Float[Array, " modes"]]:
    """`φ² m` of each mode by body; they add up to one for mass-normalised shapes.

    **Arguments:**

    - `network`: the springs and masses.
    - `shapes`: a column for each mode.
    - `each_roller`: list every roller separately, instead of all together as `roller`.
    """
    energy = network.mass[:, None] * jnp.abs(shapes) ** 2
    bodies = [coordinate.body for coordinate in network.coordinates]
    if not each_roller:
        bodies = ["roller" if body.startswith("roller ") else body for body in bodies]
    return _gathered(bodies, energy)


def strain_energies(
    network: SpringNetwork,
    shapes: Inexact[Array, "coordinates modes"],
    *,
    each_spring: bool = False,
) -> dict[str, Float[Array, " modes"]]:
    """`k (g φ)²` of each mode by kind of spring; they add up to ω² for mass-normalised shapes.

    **Arguments:**

    - `network`: the springs and masses.
    - `shapes`: a column for each mode.
    - `each_spring`: list the springs of every roller separately.
    """
    energy = network.stiffness[:, None] * jnp.abs(network.rows @ shapes) ** 2
    names = [str(spring) if each_spring else spring.name for spring in network.springs]
    return _gathered(names, energy)


def shares(energies: dict[str, Float[Array, " modes"]]) -> dict[str, Float[Array, " modes"]]:
    """Energies as shares of their sum; all zero where the sum is zero."""
    total = jnp.sum(jnp.stack(list(energies.values())), axis=0)
    some = above_or_nan(total)
    divisor = jnp.where(some, total, 1.0)
    return {name: jnp.where(some, row / divisor, 0.0) for name, row in energies.items()}
