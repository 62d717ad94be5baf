"""Pressure maps of contacts of true surfaces, with the Hertz ellipse and the flanks' edges."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...halfspace import FlankContact
from ...text import display_unit, in_unit, number
from .._parts import colour_bar, draw_pressure, legend_below
from .._style import SERIES, Figure, drawn, page_figure

_PANEL = 66.0  # mm


def _in(unit, values) -> Any:
    return unit(np.asarray(values, dtype=float))


def _first(contacts: Mapping[str, Any], name: str):
    if not contacts:
        raise ValueError(f"{name} needs at least one contact")
    return next(iter(contacts.values()))


@drawn
def pressure_map(contacts: Mapping[str, FlankContact]) -> Figure:
    """Draw the pressure over the tangent plane, one panel per contact, all to the same scale.

    The dashed line is the Hertz ellipse under the same load; the dotted line, where it crosses the
    panel, is the crest of a thread, beyond which there is no flank.

    **Arguments:**

    - `contacts`: by label, for example `{"screw side": …, "nut side": …}`, from
      `prsm_jax.halfspace.flank_contact`.

    **Returns:** a matplotlib figure; lengths in mm or µm, pressures in MPa.

    **Raises:** `ValueError` without contacts; `MissingExtraError` without matplotlib.
    """
    _first(contacts, "pressure_map")
    unit = display_unit("m", max(float(c.hertz.semi_major) for c in contacts.values()))
    highest = max(float(np.max(c.surface.pressure)) for c in contacts.values()) * 1e-6
    columns = min(2, len(contacts))
    rows = -(-len(contacts) // columns)
    limits = [
        max(float(_in(unit, axis(c.surface.grid)).max()) for c in contacts.values())
        for axis in (lambda g: g.x, lambda g: g.y)
    ]
    height = _PANEL * limits[1] / limits[0] + 22.0
    figure = page_figure(rows * height + 14.0, 180.0 if columns == 2 else 110.0)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    image = None
    for axes, (label, contact) in zip(panels.flat, contacts.items(), strict=False):
        image = draw_map(axes, contact, unit, max(highest, 1e-12))
        axes.set_title(label)
        axes.set_xlim(-limits[0], limits[0])
        axes.set_ylim(-limits[1], limits[1])
        surface, hertz = contact.surface, contact.hertz
        peak = in_unit(surface.max_pressure, display_unit("Pa"))
        theory = in_unit(hertz.max_pressure, display_unit("Pa"))
        axes.set_xlabel(
            f"along the major axis in {unit.label}\nlargest {peak}, Hertz {theory}, "
            f"{number(surface.load)} N"
        )
        axes.tick_params(labelbottom=True)
    for row in panels:
        row[0].set_ylabel(f"along the minor axis in {unit.label}")
    for axes in list(panels.flat)[len(contacts) :]:
        axes.set_axis_off()
    colour_bar(figure, image, panels, "contact pressure in MPa")
    return figure


def draw_map(axes, contact: FlankContact, unit, highest: float, *, named: bool = True):
    """The pressure of one contact with ellipse and crests, up to `highest` in MPa; the image.

    `named`: whether crests that cross the map get a legend.
    """
    surface = contact.surface
    x, y = _in(unit, surface.grid.x), _in(unit, surface.grid.y)
    half_x, half_y = (float(axis[1] - axis[0]) / 2 for axis in (x, y))
    pressure = np.asarray(surface.pressure).T * 1e-6
    extent = (x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y)
    ellipse = _in(unit, contact.hertz.semi_major), _in(unit, contact.hertz.semi_minor)
    image = draw_pressure(axes, pressure, extent, highest, ellipse, smooth=False, dashes="--")
    for edge, name in (
        (contact.flanks.roller_edge, "crest of the roller"),
        (contact.flanks.body_edge, "crest of screw or nut"),
    ):
        if edge is not None and float(np.min(edge)) < 0 < float(np.max(edge)):
            line = axes.contour(
                x, y, np.asarray(edge).T, levels=[0.0], colors=[SERIES[3]], linewidths=1.2
            )
            line.set_linestyle(":")
            axes.plot([], [], color=SERIES[3], lw=1.2, ls=":", label=name)
    if named and axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right")
    return image


@drawn
def pressure_profiles(contacts: Mapping[str, FlankContact]) -> Figure:
    """Draw cuts of the pressure along both axes of the ellipse, beside Hertz theory.

    **Arguments:**

    - `contacts`: by label, from `prsm_jax.halfspace.flank_contact`; every contact has a colour.

    **Returns:** a matplotlib figure; lengths in mm or µm, pressures in MPa. Markers are the grid's
    cells nearest to the axis, on fine grids every other one; lines the Hertz pressure under the
    same load.

    **Raises:** `ValueError` without contacts; `MissingExtraError` without matplotlib.
    """
    _first(contacts, "pressure_profiles")
    unit = display_unit("m", max(float(c.hertz.semi_major) for c in contacts.values()))
    figure = page_figure(72.0 + 5.0 * len(contacts))
    panels = figure.subplots(1, 2, sharey=True)
    for index, (label, contact) in enumerate(contacts.items()):
        colour = SERIES[index % len(SERIES)]
        hertz, grid = contact.hertz, contact.surface.grid
        pressure = np.asarray(contact.surface.pressure) * 1e-6
        middle = grid.shape[0] // 2, grid.shape[1] // 2
        # With an even number of cells none lies on the axis: take the mean of both beside it.
        lines = [
            (pressure[:, middle[1]] + pressure[:, -1 - middle[1]]) / 2,
            (pressure[middle[0]] + pressure[-1 - middle[0]]) / 2,
        ]
        for axes, positions, line, half in zip(
            panels, (grid.x, grid.y), lines, (hertz.semi_major, hertz.semi_minor), strict=True
        ):
            fine = np.linspace(-float(half), float(half), 201)
            theory = 1e-6 * float(hertz.max_pressure)
            theory = theory * np.sqrt(np.maximum(1 - (fine / float(half)) ** 2, 0))
            axes.plot(_in(unit, fine), theory, color=colour, lw=1.0, label=f"{label}, Hertz")
            every = max(1, len(line) // 48)
            axes.plot(
                _in(unit, positions)[::every],
                np.where(line > 0, line, np.nan)[::every],
                color=colour,
                ls="none",
                marker="o",
                markersize=2.6,
                label=f"{label}, true flanks",
            )
    for axes, name in zip(panels, ("major", "minor"), strict=True):
        axes.set_xlabel(f"along the {name} axis in {unit.label}")
        axes.set_ylim(bottom=0)
        axes.grid(True)
    panels[0].set_ylabel("contact pressure in MPa")
    legend_below(figure, panels[0].get_legend_handles_labels()[0], 2)
    return figure
