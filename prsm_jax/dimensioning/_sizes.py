"""All sizes of the catalogue with their strength, computed by one program for all of them."""

import functools
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..catalogue_sizes import catalogue_mechanism, catalogue_rows
from ..mechanism import Mechanism, Stage, with_traced_counts
from ..quantities import compute
from ..strength import buckling_load, critical_speed

#: Columns of the catalogue that are dimensions; masses follow from them, capacities are results.
_DIMENSIONS = ("crest_diameter_mm", "root_diameter_mm", "nut_outer_diameter_mm", "nut_length_mm")
_COMPUTED = ("dynamic_capacity", "static_capacity", "truncation_load")
#: Length of the screws for which the program is evaluated [m]: Euler's load and the critical speed
#: go with 1/l².
_LENGTH = 1.0
#: Length over `_LENGTH` of a screw that is slender at every diameter.
_LONG = 100.0


def size_mechanism(row: dict[str, float]) -> Mechanism:
    """The mechanism of a row of the catalogue by its dimensions, with a screw of one metre."""
    given = {name: row[name] for name in _DIMENSIONS if name in row}
    diameter, lead = row["nominal_diameter_mm"] * 1e-3, row["lead_mm"] * 1e-3
    return catalogue_mechanism(diameter, lead, row["starts"], **given)


def nut_outer_diameter(stage: Stage) -> float:
    """Outer diameter of the nut of a size [m]."""
    assert stage.nut.wall_thickness is not None
    return 2 * float(stage.thread.nut_radius + stage.nut.wall_thickness)


@dataclass(frozen=True)
class Sizes:
    """Sizes of the catalogue, an array entry for each [SI]."""

    rows: tuple[dict[str, float], ...]
    diameter: np.ndarray
    lead: np.ndarray
    nut_diameter: np.ndarray
    nut_length: np.ndarray
    dynamic_capacity: np.ndarray
    static_capacity: np.ndarray
    #: Load from which a contact ellipse passes the end of a flank [N].
    truncation_load: np.ndarray
    #: Euler's buckling load [N] and critical speed [rad/s] of a length of one metre.
    euler_load: np.ndarray
    critical_speed: np.ndarray
    #: Axial load at which the root's section yields [N].
    yield_load: np.ndarray


@eqx.filter_jit
def capacities(
    batch: Mechanism, counts: Float[Array, " sizes"]
) -> dict[str, Float[Array, " sizes"]]:
    """Capacities, truncation load, loads and critical speed of the screws of all sizes."""

    def of_one(mechanism: Mechanism, count: Float[Array, ""]) -> dict[str, Float[Array, ""]]:
        counted = with_traced_counts(mechanism, {"roller_count": count})
        found = compute(counted, _COMPUTED)
        stage, length = counted.stages[0], jnp.asarray(_LENGTH)
        return {
            **{name: value[0] for name, value in found.items()},
            # A screw of no length yields, and a very long one buckles as Euler's.
            "euler_load": buckling_load(stage, _LONG * length) * _LONG**2,
            "yield_load": buckling_load(stage, 0.0 * length),
            "critical_speed": critical_speed(stage, length),
        }

    return jax.vmap(of_one)(batch, counts)


@functools.cache
def all_sizes() -> Sizes:
    """All sizes of the catalogue."""
    rows = catalogue_rows()
    mechanisms = [size_mechanism(row) for row in rows]
    stages = [mechanism.stages[0] for mechanism in mechanisms]
    counts = [float(stage.roller_count) for stage in stages]
    # The number of rollers is part of the structure, which must be the same in a batch.
    first = stages[0].roller_count
    alike = [
        eqx.tree_at(lambda m: m.stages[0].roller_count, one, first, is_leaf=_is_count)
        for one in mechanisms
    ]
    batch = jax.tree.map(lambda *leaves: jnp.stack(leaves), *alike)
    found = capacities(batch, jnp.asarray(counts))
    return Sizes(
        rows,
        np.array([row["nominal_diameter_mm"] * 1e-3 for row in rows]),
        np.array([row["lead_mm"] * 1e-3 for row in rows]),
        np.array([nut_outer_diameter(stage) for stage in stages]),
        np.array([float(stage.nut.length) for stage in stages]),  # pyright: ignore[reportArgumentType]
        **{name: np.asarray(values) for name, values in found.items()},
    )


def _is_count(node: object) -> bool:
    return isinstance(node, int)
