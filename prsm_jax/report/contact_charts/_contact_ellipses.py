"""The Hertz ellipses to scale, with the pressure in them."""

from collections.abc import Mapping

import numpy as np

from ...contact import StageContact
from ...text import display_unit, in_unit
from .._parts import colour_bar, draw_pressure
from .._style import Figure, drawn, page_figure

_SIDES = ("screw", "nut")


@drawn
def contact_ellipses(
    contacts: Mapping[str, StageContact],
    largest: Mapping[str, tuple[float, float]] | None = None,
) -> Figure:
    """Draw the contact ellipses of screw and nut side, all to the same scale.

    The major axis is drawn horizontally, whatever its direction in the thread. Whole ellipses are
    drawn, with the Hertz pressure, even if a flank ends within them.

    **Arguments:**

    - `contacts`: by label, for example `{"before": …, "after": …}`.
    - `largest`: largest pressures on the screw and on the nut side by label, with the effect of
        the ends of flanks [Pa]; default those of the whole ellipses.

    **Returns:** a matplotlib figure; lengths in mm or µm, pressure in MPa.

    **Raises:** `ValueError` without contacts; `MissingExtraError` without matplotlib.
    """
    if not contacts:
        raise ValueError("contact_ellipses needs at least one contact")
    hertz = {
        (label, side): getattr(contact, side).hertz
        for label, contact in contacts.items()
        for side in _SIDES
    }
    longest = max(float(h.semi_major) for h in hertz.values())
    widest = max(float(h.semi_minor) for h in hertz.values())
    highest = max(float(h.max_pressure) for h in hertz.values()) * 1e-6
    unit = display_unit("m", longest)
    x_limit, y_limit = 1.2 * unit(longest), 1.25 * unit(widest)
    x_limit, y_limit = max(x_limit, 1e-12), max(y_limit, 1e-12)
    # A column of the page leaves 66 mm for the axes themselves.
    height = 66.0 * y_limit / x_limit + 16.0
    figure = page_figure(height * len(contacts) + 14.0)
    grid = figure.subplots(len(contacts), 2, squeeze=False, sharex=True, sharey=True)
    image = None
    for row, label in enumerate(contacts):
        for column, side in enumerate(_SIDES):
            axes, contact = grid[row, column], hertz[label, side]
            image = _ellipse(axes, contact, unit, x_limit, y_limit, max(highest, 1e-12))
            axes.set_title(f"{label}: {side} side" if len(contacts) > 1 else f"{side} side")
            hertz_pressure = float(contact.max_pressure)
            pressure = hertz_pressure if largest is None else float(largest[label][column])
            axes.set_xlabel(
                f"along the major axis in {unit.label}\n"
                f"p₀ = {in_unit(pressure, display_unit('Pa'))}, "
                f"a = {in_unit(contact.semi_major, unit, 3)}, "
                f"b = {in_unit(contact.semi_minor, unit, 3)}"
                + (
                    f"\ncut by the end of a flank; whole ellipse: "
                    f"{in_unit(hertz_pressure, display_unit('Pa'))}"
                    if pressure > hertz_pressure
                    else ""
                )
            )
            axes.tick_params(labelbottom=True)
        grid[row, 0].set_ylabel(f"minor axis in {unit.label}")
    colour_bar(figure, image, grid, "contact pressure in MPa")
    return figure


def _ellipse(axes, contact, unit, x_limit: float, y_limit: float, highest: float):
    major, minor = unit(float(contact.semi_major)), unit(float(contact.semi_minor))
    x, y = np.meshgrid(np.linspace(-x_limit, x_limit, 401), np.linspace(-y_limit, y_limit, 301))
    if major > 0 and minor > 0:
        inside = 1 - (x / major) ** 2 - (y / minor) ** 2
    else:
        inside = np.full_like(x, -1.0)
    pressure = 1e-6 * float(contact.max_pressure) * np.sqrt(np.maximum(inside, 0.0))
    extent = (-x_limit, x_limit, -y_limit, y_limit)
    pressure[inside <= 0] = 0.0
    return draw_pressure(axes, pressure, extent, highest, (major, minor), smooth=True, dashes="-")
