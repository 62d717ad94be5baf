"""Section of the von Mises stress below any pressure on a grid."""

from itertools import pairwise
from typing import Literal

import numpy as np

from ...halfspace import SubsurfaceStress
from ...text import display_unit, in_unit
from .._parts import colour_bar
from .._style import INK, Figure, drawn, page_figure


@drawn
def stress_section(
    stress: SubsurfaceStress,
    along: Literal["x", "y"] = "x",
    *,
    hardness_depth: float | None = None,
) -> Figure:
    """Draw the von Mises stress below a contact of true surfaces, in a plane through its maximum.

    Thin lines are drawn at the values that are printed at the colour bar.

    **Arguments:**

    - `stress`: from `prsm_jax.halfspace.subsurface_stress_field`, at two depths or more.
    - `along`: the axis of the grid that the section follows.
    - `hardness_depth`: depth to which the surface is hardened, drawn as a line [m].

    **Returns:** a matplotlib figure; lengths in mm or µm, stress in MPa. A cross marks the largest
    stress of all points; the section passes through it.

    **Raises:** `ValueError` for another axis, fewer than two depths or a hardness depth that is not
    positive; `MissingExtraError` without
    matplotlib.
    """
    if along not in ("x", "y"):
        raise ValueError(f"along is {along!r}; choose 'x' or 'y'")
    if hardness_depth is not None and not hardness_depth > 0:
        raise ValueError(f"hardness_depth is {hardness_depth}; give a depth above 0, in m")
    from matplotlib.ticker import MaxNLocator

    depths = np.asarray(stress.depths)
    if len(depths) < 2:
        raise ValueError(f"the stress has {len(depths)} depth; a section needs at least two")
    equivalent = np.asarray(stress.von_mises) * 1e-6
    peak = np.unravel_index(np.argmax(equivalent), equivalent.shape)
    if along == "x":
        positions, other, section = stress.grid.x, stress.grid.y[peak[2]], equivalent[:, :, peak[2]]
        index = peak[1]
    else:
        positions, other, section = stress.grid.y, stress.grid.x[peak[1]], equivalent[:, peak[1], :]
        index = peak[2]
    positions = np.asarray(positions)
    unit = display_unit("m", float(positions.max()))
    across, down = unit(positions), unit(depths)
    width = 118.0
    height = width * float(np.ptp(down)) / float(np.ptp(across)) + 24.0
    figure = page_figure(min(max(height, 50.0), 160.0), 150.0)
    axes = figure.subplots()
    steps = MaxNLocator(8).tick_values(0.0, max(float(section.max()), 1e-9))
    fine = np.unique(np.concatenate([np.linspace(a, b, 5) for a, b in pairwise(steps)]))
    filled = axes.contourf(across, down, section, levels=fine, cmap="cividis")
    filled.set_edgecolor("face")
    axes.contour(across, down, section, levels=steps[1:], colors="white", linewidths=0.5)
    axes.plot(across[index], down[peak[0]], marker="+", color=INK, markersize=9, mew=1.2)
    limit = None if hardness_depth is None else unit(float(hardness_depth))
    if limit is not None and limit <= down[-1]:
        axes.axhline(limit, color=INK, lw=1.0, ls=(0, (5, 2)), label="hardness depth")
    axes.invert_yaxis()
    axes.set_aspect("equal")
    name = "y" if along == "x" else "x"
    place = "middle" if abs(float(other)) < 1e-12 else f"{name} = {in_unit(other, unit, 3)}"
    largest = in_unit(float(equivalent[peak]) * 1e6, display_unit("Pa"))
    axes.set_title(f"section at {place}")
    axes.set_xlabel(
        f"{along} in {unit.label}\nlargest {largest} at a depth of "
        f"{in_unit(depths[peak[0]], unit, 3)}"
        + ("" if limit is None else f"; hardness depth {in_unit(limit / unit.per_si, unit, 3)}")
    )
    axes.set_ylabel(f"depth in {unit.label}")
    colour_bar(figure, filled, axes, "von Mises stress in MPa", ticks=list(steps))
    return figure
