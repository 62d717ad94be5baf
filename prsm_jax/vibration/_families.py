"""Families of modes where no symmetry tells them apart: by how much of a mode is in each."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from .model import SpringNetwork, VibrationSystem

#: In the order of `family_shares`. A rigid motion is a mode without strain, of whatever family.
FAMILIES = ("carrier", "torsional", "transverse", "roller")
#: Less than this share of a pattern's square left beside those before it is rounding.
_ABSENT = 1e-20


def _orthonormal(patterns: list[Float[Array, " rollers"]]) -> Float[Array, "patterns rollers"]:
    """The patterns orthogonal to those before them and of norm one; 0 where nothing is left."""
    rows: list[Array] = []
    for pattern in patterns:
        rest = pattern
        # Twice is enough (Kahan and Parlett).
        for _ in range(2):
            for row in rows:
                rest = rest - jnp.sum(row * rest) * row
        square = jnp.sum(rest**2)
        left = square > _ABSENT * jnp.sum(pattern**2)
        # Not the other way round: what is not a number stays so.
        rows.append(jnp.where(left, rest, 0.0) / jnp.sqrt(jnp.where(left, square, 1.0)))
    return jnp.stack(rows)


def family_shares(
    system: VibrationSystem, network: SpringNetwork, shapes: Float[Array, "coordinates modes"]
) -> Float[Array, "4 modes"]:
    """Share of each mode's kinetic energy that is in the motions of each family.

    The motions of a symmetric mechanism are the measure: rotations of the central bodies with
    all rollers alike (torsional), their translations with the rollers' first harmonic in the
    angle around the screw (transverse), any other motion of the rollers (roller), and the carrier
    where it moves on its own. Rows as `FAMILIES`; they add up to one.

    **Arguments:**

    - `system`: the system, for the rollers' positions.
    - `network`: its spring network.
    - `shapes`: mass-normalised shapes.
    """
    amplitude = jnp.sqrt(network.mass)[:, None] * shapes
    energy = amplitude**2
    alone = system.translation is None
    places: dict[str, list[int]] = {"carrier": [], "torsional": [], "transverse": []}
    rollers: dict[str, list[int]] = {}
    for index, coordinate in enumerate(network.coordinates):
        if coordinate.body.startswith("roller "):
            rollers.setdefault(coordinate.direction, []).append(index)
        elif coordinate.body == "carrier" and alone:
            places["carrier"].append(index)
        else:
            places["torsional" if coordinate.direction == "u" else "transverse"].append(index)
    position = system.roller_positions
    basis = _orthonormal([jnp.ones_like(position), jnp.cos(position), jnp.sin(position)])
    shares = {name: jnp.sum(energy[jnp.asarray(at, int)], axis=0) for name, at in places.items()}
    shares["roller"] = jnp.zeros_like(shares["carrier"])
    for at in rollers.values():
        found = (basis @ amplitude[jnp.asarray(at, int)]) ** 2
        first, second = found[0], jnp.sum(found[1:], axis=0)
        shares["torsional"] = shares["torsional"] + first
        shares["transverse"] = shares["transverse"] + second
        # Rounding may leave a share of −1e-17.
        rest = jnp.sum(energy[jnp.asarray(at, int)], axis=0) - first - second
        shares["roller"] = shares["roller"] + jnp.maximum(rest, 0.0)
    return jnp.stack([shares[name] for name in FAMILIES])
