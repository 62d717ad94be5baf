"""Results of the mechanisms of a catalogue's sizes, in one batch and in the catalogue's units."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..._errors import FileError
from ...catalogue_sizes import DIMENSIONS, catalogue_mechanism
from ...fields import Scalar
from ...mechanism import (
    Mechanism,
    Stage,
    body_inertia,
    body_mass,
    mean_roller_inertia,
    mean_roller_mass,
)
from ...quantities import Analysis, evaluate

Row = Mapping[str, float]


@dataclasses.dataclass(frozen=True)
class Predicted:
    """A column of the catalogue that a mechanism predicts."""

    #: What it is, in words, and its unit for tables and charts.
    name: str
    unit: str
    #: Relative error that its median should not exceed.
    goal: float = 0.1


#: Columns that mechanisms predict, in the order of tables and charts.
PREDICTED: dict[str, Predicted] = {
    "static_capacity_kn": Predicted("static capacity", "kN", 0.2),
    "dynamic_capacity_kn": Predicted("dynamic capacity", "kN", 0.2),
    "nut_mass_kg": Predicted("mass of nut and rollers", "kg"),
    "nut_inertia_kg_mm2": Predicted("inertia of the nut", "kg·mm²"),
    "rollers_inertia_at_screw_kg_mm2": Predicted("inertia of the rollers at the screw", "kg·mm²"),
    "shaft_mass_kg_per_m": Predicted("mass of the screw per metre", "kg/m"),
    "shaft_inertia_kg_mm2_per_m": Predicted("inertia of the screw per metre", "kg·mm²/m"),
    "efficiency_screw_drives": Predicted("efficiency, screw drives", "1"),
    "efficiency_load_drives": Predicted("efficiency, load drives", "1"),
    "largest_axial_play_mm": Predicted("largest axial play", "mm"),
}
_QUANTITIES = (
    "static_capacity",
    "dynamic_capacity",
    "nut_unit_mass",
    "efficiency",
    "efficiency_backward",
)


def size_name(row: Row) -> str:
    """Such as `30 x 5 mm, 5 starts`."""
    sizes = (row["nominal_diameter_mm"], row["lead_mm"], row["starts"])
    return "{:g} x {:g} mm, {:g} starts".format(*sizes)


def mechanism_of(row: Row) -> Mechanism:
    """The mechanism of a size from its dimensions alone; printed results are not used.

    **Raises:** `FileError` for dimensions that do not make a screw.
    """
    dimensions = {name: row[name] for name in DIMENSIONS if name in row}
    try:
        return catalogue_mechanism(
            row["nominal_diameter_mm"] * 1e-3, row["lead_mm"] * 1e-3, row["starts"], **dimensions
        )
    except ValueError as error:
        raise FileError(f"{size_name(row)}: {error}") from error


def batch_of(mechanisms: Sequence[Mechanism]) -> Mechanism:
    """Mechanisms of one structure as a batch, with their numbers of rollers as numbers."""
    counted = [
        eqx.tree_at(lambda m: m.stages[0].roller_count, one, float(one.stages[0].roller_count))
        for one in mechanisms
    ]
    return jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(leaf) for leaf in leaves]), *counted)


def rollers_inertia_at_screw(stage: Stage) -> Scalar:
    r"""Inertia of all rollers at the screw, $N (m_R a^2 + (n-1)^2 J_R)\,\zeta^2$ [kg m²].

    They go round with $\zeta = r_s/2a$ of the screw's speed, and turn n − 1 times as fast. The
    carriers are left out: the catalogue prints rollers.

    **Arguments:**

    - `stage`: the stage.
    """
    thread = stage.thread
    share = thread.screw_radius / (2 * thread.centre_distance)
    orbit = mean_roller_mass(stage) * thread.centre_distance**2
    spin = mean_roller_inertia(stage) * (thread.starts - 1) ** 2
    return stage.present_roller_count * (orbit + spin) * share**2


@eqx.filter_jit
def evaluated(batch: Mechanism) -> dict[str, Array]:
    """All `PREDICTED` columns of a batch, in the units of their names.

    **Arguments:**

    - `batch`: from `batch_of`.
    """

    def one(mechanism: Mechanism) -> dict[str, Any]:
        values = evaluate(Analysis(mechanism), _QUANTITIES)
        (stage,) = mechanism.stages
        strength = stage.strength
        assert strength is not None
        assert strength.play is not None
        assert strength.play.axial_backlash is not None
        assert stage.screw.length is not None
        return {
            "static_capacity_kn": 1e-3 * values["static_capacity"][0],
            "dynamic_capacity_kn": 1e-3 * values["dynamic_capacity"][0],
            "nut_mass_kg": values["nut_unit_mass"],
            "nut_inertia_kg_mm2": 1e6 * body_inertia(stage, "nut"),
            "rollers_inertia_at_screw_kg_mm2": 1e6 * rollers_inertia_at_screw(stage),
            "shaft_mass_kg_per_m": body_mass(stage, "screw") / stage.screw.length,
            "shaft_inertia_kg_mm2_per_m": 1e6 * body_inertia(stage, "screw") / stage.screw.length,
            "efficiency_screw_drives": values["efficiency"],
            "efficiency_load_drives": values["efficiency_backward"],
            "largest_axial_play_mm": 1e3 * strength.play.axial_backlash,
        }

    return jax.vmap(one)(batch)


def predicted(mechanisms: Sequence[Mechanism]) -> dict[str, np.ndarray]:
    """All `PREDICTED` columns of the mechanisms, in the units of their names.

    **Arguments:**

    - `mechanisms`: from `mechanism_of`.
    """
    return {name: np.asarray(x) for name, x in evaluated(batch_of(mechanisms)).items()}
