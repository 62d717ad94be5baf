"""Families of modes without symmetry, from the share of each mode in each family."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerics import above_or_nan
from .model import SpringNetwork, VibrationSystem

#: In the order of `family_shares`. A rigid motion is a mode without strain, of any family.
FAMILIES = ("carrier", "torsional", "transverse", "roller")
#: Share of a pattern's squared norm that is rounding after orthogonalisation.
_ABSENT = 1e-20


def _orthonormal(patterns: list[Float[Array, " rollers"]]) -> Float[Array, "patterns rollers"]:
    """The patterns orthonormalised in turn; 0 for one that depends on the previous ones."""
    rows: list[Array] = []
    for pattern in patterns:
        rest = pattern
        # Twice is enough (Kahan and Parlett).
        for _ in range(2):
            for row in rows:
                rest = rest - jnp.sum(row * rest) * row
        square = jnp.sum(rest**2)
        # A pattern of NaN stays NaN.
        independent = above_or_nan(square, _ABSENT * jnp.sum(pattern**2))
        rows.append(
            jnp.where(independent, rest, 0.0) / jnp.sqrt(jnp.where(independent, square, 1.0))
        )
    return jnp.stack(rows)


def family_shares(
    system: VibrationSystem, network: SpringNetwork, shapes: Float[Array, "coordinates modes"]
) -> Float[Array, "4 modes"]:
    """Share of each mode's kinetic energy in the motions of each family.

    The families are those of a symmetric mechanism: rotations of the central bodies with equal
    motion of all rollers (torsional), their translations with the first harmonic of the rollers
    in the angle around the screw (transverse), any other motion of the rollers (roller), and the
    carrier if it moves on its own. Rows as `FAMILIES`; they add up to one.

    **Arguments:**

    - `system`: the system, for the rollers' positions.
    - `network`: its spring network.
    - `shapes`: mass-normalised shapes.
    """
    amplitude = jnp.sqrt(network.mass)[:, None] * shapes
    energy = amplitude**2
    separate_carrier = system.translation is None
    places: dict[str, list[int]] = {"carrier": [], "torsional": [], "transverse": []}
    rollers: dict[str, list[int]] = {}
    for index, coordinate in enumerate(network.coordinates):
        if coordinate.body.startswith("roller "):
            rollers.setdefault(coordinate.direction, []).append(index)
        elif coordinate.body == "carrier" and separate_carrier:
            places["carrier"].append(index)
        else:
            places["torsional" if coordinate.direction == "u" else "transverse"].append(index)
    position = system.roller_positions
    basis = _orthonormal([jnp.ones_like(position), jnp.cos(position), jnp.sin(position)])
    shares = {
        name: jnp.sum(energy[jnp.asarray(indices, int)], axis=0) for name, indices in places.items()
    }
    shares["roller"] = jnp.zeros_like(shares["carrier"])
    for indices in rollers.values():
        squares = (basis @ amplitude[jnp.asarray(indices, int)]) ** 2
        first, second = squares[0], jnp.sum(squares[1:], axis=0)
        shares["torsional"] = shares["torsional"] + first
        shares["transverse"] = shares["transverse"] + second
        # Rounding may leave a share of −1e-17.
        rest = jnp.sum(energy[jnp.asarray(indices, int)], axis=0) - first - second
        shares["roller"] = shares["roller"] + jnp.maximum(rest, 0.0)
    return jnp.stack([shares[name] for name in FAMILIES])
