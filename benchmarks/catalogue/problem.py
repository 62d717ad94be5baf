"""The benchmark problem: sizes, variables, bounds, objective and limits.

`built` makes a design by public functions alone and is what the page describes; `varied` makes the
same one inside a trace, from a mechanism of the same size and starts.
"""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

import prsm_jax as prsm
from prsm_jax.catalogue_sizes import catalogue_rows, plain_catalogue_mechanism
from prsm_jax.mechanism import Mechanism
from prsm_jax.quantities import Analysis, evaluate_checked

#: Continuous variables, and the number of rollers, whole in the result.
VARIABLES = ("contact_angle", "profile_ratio", "length_ratio", "roller_count")
#: Bounds of the first three. Below 43 deg the roller's thread would be pointed in some sizes; a
#: profile radius of twice that which is centred on the roller's axis is a nearly straight flank.
LOWER = (math.radians(43), 0.5, 0.5)
UPPER = (math.radians(60), 2.0, 1.0)
#: Rollers: at least these; at most as many as fit by the rules of `plain_catalogue_mechanism`.
FEWEST_ROLLERS = 4
#: Most starts, and the smallest diameter of a roller: 16 teeth of module 0.2 mm [m].
MOST_STARTS, THINNEST_ROLLER = 8, 3.2e-3
#: Length of the screw's shaft over its nominal diameter.
SHAFT_RATIO = 25.0

#: Quantities that are improved: the first two larger, the third smaller.
OBJECTIVES = ("dynamic_capacity", "axial_stiffness", "nut_unit_mass")
#: Quantities that must not fall below their limits.
LIMITED = ("static_capacity", "efficiency", "efficiency_backward", "truncation_load")
MEASURES = (*OBJECTIVES, *LIMITED)
#: Sense of each measure: larger is better, or smaller.
SIGNS = np.array([1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0])
#: Loss of efficiency that is allowed, by problem: none, or half of the last digit in the catalogue.
ALLOWED = {"no_loss": 0.0, "half_digit": 0.005}


@dataclasses.dataclass(frozen=True)
class Size:
    """A row of the catalogue."""

    row: Mapping[str, float]

    @property
    def name(self) -> str:
        """Such as `30 x 5`; six starts are named, for two sizes of 36 x 6."""
        row = self.row
        text = f"{row['nominal_diameter_mm']:g} x {row['lead_mm']:g}"
        return f"{text}, {self.starts} starts"

    @property
    def starts(self) -> int:
        """The size's own number of starts."""
        return round(self.row["starts"])

    @property
    def diameter(self) -> float:
        """Nominal diameter [m]."""
        return self.row["nominal_diameter_mm"] * 1e-3

    def roller_radius(self, starts: int) -> float:
        """Nominal radius of the rollers beside this screw [m]."""
        return self.diameter / 2 / (starts - 2)

    @property
    def wall(self) -> float:
        """Thickness of the nut's wall [m]."""
        nut = self.starts * self.roller_radius(self.starts)
        return self.row["nut_outer_diameter_mm"] * 5e-4 - nut

    @property
    def choices(self) -> tuple[int, ...]:
        """Numbers of starts to choose from; with fewer the nut would be thicker than the size's."""
        return tuple(
            n
            for n in range(self.starts, MOST_STARTS + 1)
            if n == self.starts or 2 * self.roller_radius(n) >= THINNEST_ROLLER
        )


def sizes() -> tuple[Size, ...]:
    """All sizes of the catalogue, in its order."""
    return tuple(map(Size, catalogue_rows()))


def dimensioned(size: Size, starts: int, length_ratio: float = 1.0) -> Mechanism:
    """A mechanism within the envelope of a size, by the rules of `plain_catalogue_mechanism`.

    Masses follow from dimensions. Heights of thread are in proportion to the pitch, the wall of
    the nut is that of the size.

    **Arguments:**

    - `size`: the size.
    - `starts`: number of starts, which gives pitch, rollers and the diameter of the nut.
    - `length_ratio`: length of nut and rollers over those of the size.
    """
    row, columns = size.row, {}
    nominal = row["nominal_diameter_mm"]
    for name in ("crest_diameter_mm", "root_diameter_mm"):
        if name in row:
            columns[name] = nominal + (row[name] - nominal) * size.starts / starts
    nut_radius = starts * size.roller_radius(starts)
    mechanism = plain_catalogue_mechanism(
        size.diameter,
        row["lead_mm"] * 1e-3,
        starts,
        nut_outer_diameter_mm=2e3 * (nut_radius + size.wall),
        nut_length_mm=row["nut_length_mm"] * length_ratio,
        largest_axial_play_mm=row["largest_axial_play_mm"],
        **columns,
    )
    return prsm.set_parameter(mechanism, "stage.1.screw.length", SHAFT_RATIO * size.diameter)


def built(
    size: Size,
    starts: int,
    contact_angle: float,
    profile_ratio: float,
    length_ratio: float,
    roller_count: int,
) -> Mechanism:
    """A design, by public functions alone.

    **Arguments:**

    - `size`, `starts`: as in `dimensioned`.
    - `contact_angle`: [rad].
    - `profile_ratio`: radius of the roller's profile over r_R / sin α = r_R / cos λ.
    - `length_ratio`: length of nut and rollers over those of the size.
    - `roller_count`: number of rollers.
    """
    mechanism = dimensioned(size, starts, length_ratio)
    profile = profile_ratio * size.roller_radius(starts) / math.cos(contact_angle)
    stage = dataclasses.replace(mechanism.stages[0], roller_count=roller_count)
    thread = dataclasses.replace(
        stage.thread,
        contact_angle=jnp.asarray(contact_angle),
        roller_profile_radius=jnp.asarray(profile),
    )
    return dataclasses.replace(mechanism, stages=(dataclasses.replace(stage, thread=thread),))


def _lengths(mechanism: Mechanism) -> tuple[Any, ...]:
    """Numbers that are in proportion to the length of the nut."""
    stage = mechanism.stages[0]
    assert stage.carrier is not None
    assert stage.gear is not None
    return (
        stage.nut.length,
        stage.roller.length,
        stage.carrier.length,
        stage.gear.face_width,
        stage.engaged_threads,
    )


def _freed(mechanism: Mechanism) -> tuple[Any, ...]:
    stage = mechanism.stages[0]
    thread = stage.thread
    return (thread.contact_angle, thread.roller_profile_radius, stage.roller_count)


def varied(mechanism: Mechanism, variables: Float[Array, "4"]) -> Mechanism:
    """The mechanism of `dimensioned`, of whole length, with other `VARIABLES`."""
    angle, profile_ratio, length_ratio, count = variables
    mechanism = eqx.tree_at(
        _lengths, mechanism, tuple(length_ratio * value for value in _lengths(mechanism))
    )
    profile = profile_ratio * mechanism.stages[0].thread.roller_radius / jnp.cos(angle)
    return eqx.tree_at(_freed, mechanism, (angle, profile, count), is_leaf=lambda x: x is None)


def measured(mechanism: Mechanism) -> tuple[Float[Array, "7"], Bool[Array, ""]]:
    """`MEASURES` of a mechanism [SI], and whether they can be used."""
    values, good = evaluate_checked(Analysis(mechanism), MEASURES)
    # A product with a matrix: XLA would recompute the operands of a concatenation.
    rows = [jnp.sum(values[name]) for name in MEASURES]
    total = jnp.zeros(len(rows))
    for row, unit in zip(rows, np.eye(len(rows)), strict=True):
        total += row * unit
    return total, good


def limits_of(start: np.ndarray, load: float, loss: float) -> np.ndarray:
    """What the measures of a design are compared with [SI].

    Those of the start; the efficiencies less the allowed loss; and no ellipse may reach an end of
    its flank under the operating load, unless one does so in the start.

    **Arguments:**

    - `start`: measures of the size's own design.
    - `load`: its operating load [N].
    - `loss`: allowed loss of efficiency.
    """
    limits = np.array(start)
    limits[[MEASURES.index("efficiency"), MEASURES.index("efficiency_backward")]] -= loss
    place = MEASURES.index("truncation_load")
    limits[place] = min(limits[place], load)
    return limits


def gains(measures: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Natural logarithms of how much better than its limit each measure is, along the last axis."""
    return SIGNS * np.log(measures / limits)
