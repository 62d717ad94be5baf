"""Natural frequencies over one parameter: which curves cross, and which veer."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..contact import StageContact, load_of
from ..fields import Scalar, old_name
from ..geometry import mesh
from ..load_sharing import LoadDistribution
from ..mechanism import Mechanism, find_parameters, of_one_design, set_parameter, stage_at
from ..programs import each, one_program_where_possible
from ..results import DesignResult
from ..stiffness import loaded_threads, thread_stiffness
from ..text import Line
from ._dense import stage_modes
from ._families import FAMILIES, family_shares
from ._grouped_modes import COUPLED
from ._modes import Modes
from ._spring_modes import clusters
from .model import vibration_system

#: Two curves veer where they come closer than this share of their mean frequency and diverge again.
_CLOSE = 0.1


@dataclass(frozen=True)
class Veering:
    """Two curves of one family that approach and diverge again without touching."""

    family: str
    #: Index of the lower curve in the family, from 0; the other is the next one.
    lower: int
    #: Index of the value at which they are closest.
    at: int
    value: float
    #: Frequencies of both there [Hz].
    frequencies: tuple[float, float]


class FrequencyLoci(DesignResult):
    """Natural frequencies of one stage as curves over a parameter.

    In a symmetric stage each family has its own curves: curves of different families cross, curves
    of one family veer, so each keeps its place in the order of frequencies. Without symmetry all
    modes except the carrier's are one family named `coupled`; `shares` then gives the share of
    each mode in each family.
    """

    #: Values of the parameter [SI].
    values: Float[Array, " points"]
    #: By family: ascending curves [Hz]; NaN where the thread does not mesh.
    frequencies: dict[str, Float[Array, "points _"]]
    #: Share of each coupled mode in each of `FAMILIES`, the same for all members of a repeated
    #: root; `None` for a symmetric stage.
    shares: Float[Array, "points 4 _"] | None
    valid: Bool[Array, " points"]
    parameter: str = eqx.field(static=True)
    unit: str = eqx.field(static=True)
    #: Multiplicity of the modes of each family; at the first point, if the parameter changes it.
    multiplicities: dict[str, int] = eqx.field(static=True)
    stage: int = eqx.field(static=True)
    #: Whether only whole numbers are possible (the number of rollers).
    integer: bool = eqx.field(static=True)

    @property
    def whole(self) -> bool:
        """Old name of `integer`."""
        return old_name(self, "whole", "integer")

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of a batch of curves; empty for a single design."""
        return self.valid.shape[:-1]

    def lines(self) -> list[Line]:
        """What `print` shows: the range of each family of curves."""
        curves = [
            Line(family.replace("_", " "), rows, "Hz") for family, rows in self.frequencies.items()
        ]
        points = Line("points that mesh", self.valid)
        return [Line(self.parameter, self.values, self.unit), points, *curves]

    @each
    def veerings(self) -> tuple[Veering, ...]:
        """Where two neighbouring curves of one family approach and diverge again, closest first.

        For a batch: an array of such tuples, one for each design. Not available inside a trace. On
        either side of the closest point the relative distance must reach more than twice its
        minimum; curves that coincide are repeated roots and do not count.
        """
        ranked = []
        for family, curves in self.frequencies.items():
            rows = np.asarray(curves)
            for lower in range(rows.shape[1] - 1):
                low, high = rows[:, lower], rows[:, lower + 1]
                gap = 2 * (high - low) / (high + low)
                if len(gap) < 3 or not np.isfinite(gap).all():
                    continue
                at = int(np.argmin(gap))
                diverge = min(gap[: at + 1].max(), gap[at:].max()) > 2 * gap[at]
                if 0 < at < len(gap) - 1 and diverge and 1e-9 < gap[at] < _CLOSE:
                    value = float(self.values[at])
                    both = (float(low[at]), float(high[at]))
                    ranked.append((gap[at], Veering(family, lower, at, value, both)))
        return tuple(veering for _, veering in sorted(ranked, key=lambda pair: pair[0]))


def _point(
    mechanism: Mechanism, stage: int, load: float | Scalar | None
) -> tuple[dict[str, Array], Float[Array, "4 modes"] | None, Bool[Array, ""]]:
    """Frequencies by family, shares of coupled modes, and whether the numbers are usable."""
    chosen = mechanism.stages[stage - 1]
    flags: list[Bool[Array, ""]] = []

    def contact() -> StageContact | LoadDistribution:
        meshing = mesh(chosen.thread) if chosen.curvature == "exact" else None
        contacts = loaded_threads(chosen, jnp.abs(load_of(mechanism, load)), meshing)
        if meshing is not None:
            flags.append(meshing.converged)
        if isinstance(contacts, LoadDistribution):
            flags.append(contacts.converged)
            return contacts
        flags.extend(side.hertz.semi_major >= 0 for side in (contacts.screw, contacts.nut))
        return contacts

    modes = stage_modes(vibration_system(chosen, thread_stiffness(chosen, contact)))
    frequencies = {group.family: group.frequencies for group in modes.groups}
    flags.extend(jnp.isfinite(row).all() for row in frequencies.values())
    valid = jnp.stack(flags).all()
    shown = {name: jnp.where(valid, row, jnp.nan) for name, row in frequencies.items()}
    return shown, _shares(modes), valid


def _shares(modes: Modes) -> Float[Array, "4 modes"] | None:
    group = modes.group(COUPLED)
    if group is None:
        return None
    assert modes.system is not None
    assert modes.network is not None
    assert group.shapes is not None
    single = family_shares(modes.system, modes.network, group.shapes[..., 0])
    members = clusters(group.frequencies**2).astype(single.dtype)
    return single @ (members / jnp.sum(members, axis=0, keepdims=True))


@one_program_where_possible
def _all_points(mechanism: Mechanism, values: Array, parameter: str, stage: int, load):
    return jax.vmap(lambda v: _point(set_parameter(mechanism, parameter, v), stage, load))(values)


_one_point = one_program_where_possible(_point)


@of_one_design
def frequency_loci(
    mechanism: Mechanism,
    parameter: str,
    values: Float[Array, " points"] | np.ndarray | Sequence[float | int],
    *,
    stage: int = 1,
    load: float | Scalar | None = None,
) -> FrequencyLoci:
    """Natural frequencies of one stage for every value of one parameter.

    One compiled function evaluates all values at once; whole numbers such as `roller_count`, which
    are part of the program, are evaluated one by one.

    **Arguments:**

    - `mechanism`: the mechanism; as for `modal`.
    - `parameter`: a name as in `set_parameter`: `lead`, `contact_angle`, `screw.mass`,
      `unequal_roller.2.stiffness_factor`, …
    - `values`: its values [SI], ascending or descending.
    - `stage`: which stage, counted from 1.
    - `load`: axial load at which the contact stiffness is taken [N]; default that of the operating
      point.

    **Returns:** the curves by family.

    **Raises:** `UnknownNameError` for an unknown parameter; `ValueError` for fewer than two values,
    values that are not finite or not in order, or a stage that does not exist; `MissingDataError`
    if the mechanism lacks data.
    """
    dtype = stage_at(mechanism, stage).thread.lead.dtype
    known = find_parameters(mechanism, parameter)[0]
    points = np.asarray(values, float)
    steps = np.diff(points)
    if points.ndim != 1 or len(points) < 2 or not np.isfinite(points).all():
        raise ValueError(f"values of {parameter} must be a list of at least two finite numbers")
    if not ((steps > 0).all() or (steps < 0).all()):
        raise ValueError(f"values of {parameter} must be strictly ascending or descending")
    first = mechanism
    if known.static:
        each = [set_parameter(mechanism, parameter, value) for value in points]
        first, results = each[0], [_one_point(one, stage, load) for one in each]
        frequencies, shares, valid = _stacked(results)
    else:
        frequencies, shares, valid = _all_points(
            mechanism, jnp.asarray(points, dtype), parameter, stage, load
        )
    count = first.stages[stage - 1].present_roller_count
    times = {"transverse": 2, "roller": max(count - 3, 1)}
    return FrequencyLoci(
        jnp.asarray(points, dtype),
        frequencies,
        shares,
        valid,
        parameter,
        known.unit,
        {family: times.get(family, 1) for family in frequencies},
        stage,
        known.static,
    )


def _stacked(results: list[Any]) -> tuple[dict[str, Array], Array | None, Array]:
    """Results of all points as arrays; modes that a point lacks are NaN."""

    def padded(rows: list[np.ndarray], fill: float) -> Array:
        longest = max(row.shape[-1] for row in rows)
        room = [[(0, 0)] * (row.ndim - 1) + [(0, longest - row.shape[-1])] for row in rows]
        filled = [
            np.pad(row, pad, constant_values=fill) for row, pad in zip(rows, room, strict=True)
        ]
        return jnp.asarray(np.stack(filled))

    names = [name for name in (*FAMILIES, COUPLED) if any(name in point[0] for point in results)]
    frequencies = {
        name: padded([np.asarray(point[0].get(name, np.zeros(0))) for point in results], np.nan)
        for name in names
    }
    shares = None
    if all(point[1] is not None for point in results):
        shares = padded([np.asarray(point[1]) for point in results], 0.0)
    return frequencies, shares, jnp.stack([point[2] for point in results])
