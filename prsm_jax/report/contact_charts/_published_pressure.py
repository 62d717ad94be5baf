"""Pressure maps of contacts in a paper, with the printed pressures below them."""

from typing import Any

import numpy as np

from ...text import MINUS, DisplayUnit, display_unit, in_unit
from ...validation import PressureFigure, PressurePanel
from .._parts import colour_bar, legend_below, page_title
from .._style import INK, MUTED, SERIES, SMALL, Axes, Figure, drawn, page_figure
from ._pressure_map import draw_map

_PAGE, _SCALE = 180.0, 22.0  # mm: width, and its part for the colour bar
_BELOW, _ABOVE, _LEGEND = 22.0, 6.0, 12.0  # mm: words below and above a panel, title and legend
#: Half-width of the view over that of the largest ellipse.
_ROOM = 1.12
_ELLIPSE: dict[str, Any] = {"ls": "--", "lw": 0.9, "color": INK}
_PRINTED: dict[str, Any] = {"ls": "-.", "lw": 1.1, "color": SERIES[3]}
_CREST: dict[str, Any] = {"ls": ":", "lw": 1.4, "color": SERIES[3]}


@drawn
def published_pressure(figure: PressureFigure) -> Figure:
    """Draw contacts of a paper on the true flanks, all to one scale of length and of pressure.

    Below each map are the largest pressure, the printed ones and their deviation from it. The
    dashed line is the Hertz ellipse with the curvatures of the flanks, the dash-dotted one that of
    the paper; the dotted line, where it crosses a map, is the crest of a thread.

    **Arguments:**

    - `figure`: from `prsm_jax.validation.published_pressures`.

    **Returns:** a matplotlib figure; lengths in mm or µm, pressures in MPa.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    panels = [panel for row in figure.rows for panel in row]
    rows, columns = len(figure.rows), len(figure.rows[0])
    contacts = [panel.contact for panel in panels]
    unit = display_unit("m", max(float(c.hertz.semi_major) for c in contacts))
    highest = max(float(np.max(c.surface.pressure)) for c in contacts) * 1e-6
    across, up = (float(unit(_ROOM * reach)) for reach in np.max([*map(_reach, panels)], axis=0))
    width = (_PAGE - _SCALE) / columns
    height = 0.85 * width * up / across + _BELOW + _ABOVE
    page = page_figure(rows * height + _LEGEND, _PAGE)
    grid = page.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    image = None
    for axes, panel in zip(grid.flat, panels, strict=True):
        image = draw_map(axes, panel.contact, unit, max(highest, 1e-12), named=False)
        _printed_ellipse(axes, panel, unit)
        axes.set_xlim(-across, across)
        axes.set_ylim(-up, up)
        axes.tick_params(labelbottom=True)
        axes.set_title(panel.name)
        words = [f"major axis in {unit.label}", *_words(panel)]
        axes.set_xlabel("\n".join(words), fontsize=SMALL, linespacing=1.3)
    for row in grid:
        row[0].set_ylabel(f"minor axis in {unit.label}", fontsize=SMALL)
    colour_bar(page, image, grid, "contact pressure in MPa")
    _legend(page, grid, panels)
    page_title(page, figure.caption)
    return page


def _reach(panel: PressurePanel) -> np.ndarray:
    """How far the ellipses of a panel reach along both axes [m]."""
    hertz, printed = panel.contact.hertz, panel.ellipse
    reach = np.array([float(hertz.semi_major), float(hertz.semi_minor)])
    if printed is None:
        return reach
    cosine, sine = np.cos(printed.angle), np.sin(printed.angle)
    major, minor = printed.semi_major, printed.semi_minor
    turned = np.hypot([major * cosine, major * sine], [minor * sine, minor * cosine])
    return np.maximum(reach, turned)


def _words(panel: PressurePanel) -> list[str]:
    megapascal = display_unit("Pa")
    largest = float(panel.contact.surface.max_pressure)
    lines = [f"true flanks {in_unit(largest, megapascal)}"]
    for printed in panel.printed:
        if printed.value is None:
            lines.append(f"paper, {printed.name}: none printed")
            continue
        meant = printed.value if printed.correct is None else printed.correct
        value = f"{1e-6 * printed.value:.0f} MPa"
        if printed.correct is not None:
            value = f"{1e-6 * printed.value:.0f} (read {1e-6 * meant:.0f}) MPa"
        change = f"{100 * (meant / largest - 1):+.0f}".replace("-", MINUS)
        lines.append(f"paper, {printed.name} {value}, {change} %")
    return lines


def _printed_ellipse(axes: Axes, panel: PressurePanel, unit: DisplayUnit) -> None:
    from matplotlib.patches import Ellipse

    ellipse = panel.ellipse
    if ellipse is None:
        return
    style = {key: value for key, value in _PRINTED.items() if key != "color"}
    axes.add_patch(
        Ellipse(
            (0, 0),
            2 * unit(ellipse.semi_major),
            2 * unit(ellipse.semi_minor),
            angle=float(np.degrees(ellipse.angle)),
            facecolor="none",
            edgecolor=_PRINTED["color"],
            **style,
        )
    )


def _legend(page: Figure, grid, panels: list[PressurePanel]) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], **_ELLIPSE, label="Hertz ellipse, curvatures of the flanks")]
    if any(panel.ellipse is not None for panel in panels):
        handles.append(Line2D([], [], **_PRINTED, label="Hertz ellipse of the paper"))
    if any(axes.collections for axes in grid.flat):
        handles.append(Line2D([], [], **_CREST, label="crest of a thread"))
    legend_below(page, handles, labelcolor=MUTED)
