"""A linear vibrating system as masses and springs, from which all matrices are assembled."""

import dataclasses
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Inexact


@dataclasses.dataclass(frozen=True)
class Coordinate:
    """One degree of freedom: a body, and the direction in which it moves.

    Directions: `x`, `y` of a body on the axis; `z` of any body; `u = r θ`, its rotation as a
    displacement on its nominal circle, anticlockwise positive; `radial`, `tangential` of a roller,
    in the frame of its own position around the screw.
    """

    body: str
    direction: str

    def __str__(self) -> str:
        return f"{self.body} {self.direction}"


@dataclasses.dataclass(frozen=True)
class Spring:
    """The name of a spring, with the number of its roller if each roller has one."""

    name: str
    roller: int | None = None

    def __str__(self) -> str:
        return self.name if self.roller is None else f"{self.name} {self.roller}"


class SpringNetwork(eqx.Module):
    """Springs and masses: spring s stretches by `rows[s] @ q`, coordinate j has `mass[j]`.

    The stiffness matrix is `Σ k g gᵀ` over the springs, so it is positive semidefinite by
    construction, and every energy is a sum of positive terms in which nothing cancels.
    """

    #: Stiffness of each spring [N/m].
    stiffness: Float[Array, " springs"]
    #: Elongation of each spring per unit of each coordinate; complex for a harmonic.
    rows: Inexact[Array, "springs coordinates"]
    #: Mass of each coordinate [kg].
    mass: Float[Array, " coordinates"]
    coordinates: tuple[Coordinate, ...] = eqx.field(static=True)
    springs: tuple[Spring, ...] = eqx.field(static=True)

    def stiffness_matrix(self) -> Inexact[Array, "coordinates coordinates"]:
        """K = Gᵀ diag(k) G [N/m]."""
        return self.rows.conj().T @ (self.stiffness[:, None].astype(self.rows.dtype) * self.rows)

    def index(self, coordinate: str) -> int:
        """Index of a coordinate by its name, such as `"screw u"` or `"roller 3 u"`.

        **Raises:** `ValueError` for an unknown name, with the names that exist.
        """
        names = [str(known) for known in self.coordinates]
        if coordinate not in names:
            raise ValueError(f"coordinate is {coordinate!r}; choose one of {', '.join(names)}")
        return names.index(coordinate)


def _widest(arrays: list[Array]):
    """The dtype for all arrays: complex if one of them is."""
    dtypes = [array.dtype for array in arrays]
    return next((t for t in dtypes if jnp.issubdtype(t, jnp.complexfloating)), dtypes[0])


class NetworkBuilder:
    """Collects springs, one kind at a time, and builds a network from them."""

    def __init__(self, coordinates: tuple[Coordinate, ...]) -> None:
        self._coordinates = coordinates
        self._places = {coordinate: place for place, coordinate in enumerate(coordinates)}
        self._springs: list[Spring] = []
        self._stiffness: list[Array] = []
        self._rows: list[Array] = []

    def add(self, springs: tuple[Spring, ...], stiffness: Any, elongation: list[Any]) -> None:
        """Springs of one kind.

        **Arguments:**

        - `springs`: their names.
        - `stiffness`: of each, or one for all [N/m].
        - `elongation`: pairs of a coordinate (or one coordinate for each spring) and the
          elongation per unit of it (one for each spring, or one for all).
        """
        count = len(springs)
        values = [jnp.asarray(value) for _, value in elongation]
        dtype = _widest(values)
        rows = jnp.zeros((count, len(self._coordinates)), dtype)
        for (touched, _), value in zip(elongation, values, strict=True):
            touched = [touched] * count if isinstance(touched, Coordinate) else touched
            columns = np.array([self._places[coordinate] for coordinate in touched])
            rows = rows.at[np.arange(count), columns].set(value.astype(dtype))
        self._springs += springs
        self._stiffness.append(jnp.broadcast_to(stiffness, (count,)))
        self._rows.append(rows)

    def network(self, mass: dict[Coordinate, Array]) -> SpringNetwork:
        """The network, with the mass of every coordinate [kg]."""
        dtype = _widest(self._rows)
        return SpringNetwork(
            stiffness=jnp.concatenate(self._stiffness),
            rows=jnp.concatenate([rows.astype(dtype) for rows in self._rows]),
            mass=jnp.stack([mass[coordinate] for coordinate in self._coordinates]),
            coordinates=self._coordinates,
            springs=tuple(self._springs),
        )
