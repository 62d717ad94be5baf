"""Line contact of a ring: pressure along the contact line, and its footprint on the flank."""

from typing import Any

import numpy as np

from ...contact import LineContactResult
from ...halfspace import SurfaceContact
from ...mechanism import LineContact
from ...text import display_unit, in_unit
from .._style import FREE, INK, MUTED, SERIES, SMALL, Figure, drawn, page_figure


@drawn
def line_contact_chart(
    contact: LineContact, line: LineContactResult, surface: SurfaceContact | None = None
) -> Figure:
    """Draw the pressure along the contact line and the position of the contact on the flank.

    Above, the pressure at the middle of every slice over the distance from the roller axis; below,
    the width of the contact about the narrowest point of the gap of every slice.

    **Arguments:**

    - `contact`: the flanks.
    - `line`: from `prsm_jax.contact.line_contact`.
    - `surface`: the same contact on a half-space, from `prsm_jax.halfspace.ring_contact`, whose
      pressure rises at the ends of the zone.

    **Returns:** a matplotlib figure; lengths in mm or µm, pressures in MPa.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    radius = np.asarray(line.slices.radius) * 1e3
    figure = page_figure(104.0, 140.0)
    panels: Any = figure.subplots(2, 1, sharex=True, height_ratios=(1.5, 1))
    above, below = panels
    above.plot(radius, np.asarray(line.pressure) * 1e-6, color=SERIES[0], lw=1.2, label="slices")
    if surface is not None:
        rows = np.max(np.asarray(surface.pressure), axis=1) * 1e-6
        # The grid runs along the ring's generator, about the middle of the zone.
        along = np.asarray(surface.grid.x) * float(np.cos(contact.roller_profile_angle))
        position = (radius[0] + radius[-1]) / 2 + along * 1e3
        in_contact = rows > 0
        above.plot(
            position[in_contact],
            rows[in_contact],
            color=SERIES[1],
            ls="none",
            marker="o",
            markersize=2.6,
            label="half-space; at a sharp end it rises as the grid is refined",
        )
    above.set_ylim(bottom=0)
    above.set_ylabel("pressure at the middle in MPa")
    above.set_title(
        f"Largest by slices {in_unit(line.max_pressure, display_unit('Pa'))}, "
        f"{100 * float(line.loaded_share):.0f} % of the flank is loaded"
    )
    above.legend(loc="best")
    above.grid(True)

    half, arc = np.asarray(line.half_width), np.asarray(line.slices.arc)
    unit = display_unit("m", float(np.max(half)))
    middle, wide = unit(arc), unit(half)
    below.fill_between(
        radius, middle - wide, middle + wide, where=half > 0, facecolor=FREE, edgecolor="none"
    )
    below.plot(radius, middle, color=INK, lw=0.8, ls="--")
    # The footprint is only a fraction of a millimetre wide.
    loaded = half > 0
    if loaded.any():
        low, high = (middle - wide)[loaded].min(), (middle + wide)[loaded].max()
        below.set_ylim(low - 0.15 * (high - low), high + 0.15 * (high - low))
    below.set_ylabel(f"arc from the line of\ncentres in {unit.label}")
    below.set_xlabel("distance from the roller axis in mm")
    below.text(
        0.005, 0.04, "dashed: narrowest point of every slice",
        transform=below.transAxes, ha="left", va="bottom", fontsize=SMALL, color=MUTED,
    )  # fmt: skip
    below.grid(True)
    return figure
