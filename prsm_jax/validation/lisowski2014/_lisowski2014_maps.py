"""Lisowski 2014: pressure maps of both sides at the three loads, and of a nut thread that ends."""

from collections.abc import Iterator

import numpy as np

from ...halfspace import FlankContact
from .._pressure_figures import (
    PressureFigure,
    PressurePanel,
    PrintedEllipse,
    PrintedPressure,
    pressure_figures_of,
)
from .._thread_contacts import LOADS, pairs_of_threads
from ._lisowski2014 import CORRECTED, ELEMENTS, HERTZ
from ._lisowski2014_surfaces import EDGE_RADIUS, LOW, flanks

#: Heights of the nut's thread, from one that does not cut the contact to one that does [m].
_HEIGHTS = (None, 0.075e-3, LOW)


def _printed(side: str, load: float) -> tuple[PrintedPressure, ...]:
    index = LOADS.index(load)
    elements = ELEMENTS[side][index]
    hertz = 1e6 * float(HERTZ[side][index])
    corrected = CORRECTED.get((side, load))
    correct = None if corrected is None else 1e6 * float(corrected)
    return (
        PrintedPressure("elements", None if elements is None else 1e6 * float(elements)),
        PrintedPressure("Hertz", hertz, correct),
    )


def _ellipse(contact: FlankContact, side: str, load: float) -> PrintedEllipse:
    """By equations 1 to 7, φ = 0: the minor axis lies along the profile of the thread."""
    pair = pairs_of_threads("lisowski2014")["lisowski2014"][side]
    index, plane = LOADS.index(load), contact.plane
    profile = np.asarray(plane.origin[:2])
    along, across = (float(np.asarray(axis[:2]) @ profile) for axis in (plane.major, plane.minor))
    return PrintedEllipse(
        float(pair.semi_major[index]),
        float(pair.semi_minor[index]),
        float(np.arctan2(across, along)) + np.pi / 2,
    )


@pressure_figures_of("lisowski2014")
def maps(cells: int) -> Iterator[PressureFigure]:
    """Tables 1 and 2, and the edge zone of section 4."""

    def panel(side: str, load: float) -> PressurePanel:
        contact = flanks(side, load, cells=cells)
        name = f"{side} side, {load:.0f} N"
        return PressurePanel(name, contact, _printed(side, load), _ellipse(contact, side, load))

    yield PressureFigure(
        "lisowski2014",
        "pressure-maps",
        "Contact pressure of one pair of threads (Lisowski 2014, Tables 1 and 2)",
        tuple(tuple(panel(side, load) for load in LOADS) for side in HERTZ),
    )

    def edge(height: float | None) -> PressurePanel:
        if height is None:
            contact, name = flanks("nut", 50.0, cells=cells), "high thread"
        else:
            contact = flanks("nut", 50.0, height, cells=cells)
            name = f"thread {1e3 * height:g} mm high"
        return PressurePanel(name, contact, _printed("nut", 50.0))

    yield PressureFigure(
        "lisowski2014",
        "edge-zone",
        "Nut side, 50 N: crest inside the contact, its edge rounded by "
        f"{1e3 * EDGE_RADIUS:g} mm (Lisowski 2014, section 4)",
        (tuple(edge(height) for height in _HEIGHTS),),
    )
