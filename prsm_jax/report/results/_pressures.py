"""Largest contact pressures, equal to the quantities of the same names."""

import numpy as np
from jaxtyping import Array, Float

from ...contact import StageContact
from ...strength import truncated_pressure
from ._data import ReportData, SideOnsets

SIDES = ("screw", "nut")


def untruncated_pressures(pair: StageContact) -> tuple[Array, Array]:
    """Hertz pressures on the screw and on the nut side, of whole ellipses [Pa]."""
    return pair.screw.hertz.max_pressure, pair.nut.hertz.max_pressure


def truncated_pressures(
    onsets: SideOnsets | None, untruncated: tuple[Float[Array, "..."], Float[Array, "..."]]
) -> tuple[float, float]:
    """Largest pressures of both sides where the ends of flanks cut ellipses [Pa].

    **Arguments:**

    - `onsets`: where ellipses reach the ends of flanks; `None` if flanks have no ends.
    - `untruncated`: pressures of whole ellipses on the screw and on the nut side [Pa].
    """
    screw, nut = (
        float(np.max(truncated_pressure(side, pressure)))
        for side, pressure in zip(onsets or (None, None), untruncated, strict=True)
    )
    return screw, nut


def _onsets(data: ReportData, index: int) -> SideOnsets | None:
    return data.onsets[index] if data.onsets else None


def largest_pressures(data: ReportData, index: int) -> tuple[float, float]:
    """`max_pressure_screw` and `max_pressure_nut` of a stage (from 0) [Pa]."""
    assert data.contacts is not None
    return truncated_pressures(_onsets(data, index), untruncated_pressures(data.contacts[index]))


def largest_pressure(data: ReportData) -> float:
    """`max_pressure`: of all stages and sides [Pa]."""
    assert data.contacts is not None
    return max(max(largest_pressures(data, i)) for i in range(len(data.contacts)))


def largest_shared_pressure(data: ReportData, index: int) -> float:
    """`max_pressure_shared` of one stage (from 0): that of its most loaded thread [Pa]."""
    shared = data.shared[index]
    pressures = shared.screw.max_pressure, shared.nut.max_pressure
    return max(truncated_pressures(_onsets(data, index), pressures))


def any_cut(data: ReportData) -> bool:
    """Whether the end of a flank cuts a contact ellipse under the operating load."""
    contacts = data.contacts or ()
    return any(
        largest_pressures(data, i) != tuple(map(float, untruncated_pressures(pair)))
        for i, pair in enumerate(contacts)
    )
