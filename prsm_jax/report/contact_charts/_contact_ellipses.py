"""The Hertz ellipses to scale, with the pressure in them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...contact import HertzContact, StageContact
from ...text import DisplayUnit, display_unit, in_unit
from .._parts import colour_bar, draw_pressure, legend_below, legend_line
from .._style import Axes, Figure, drawn, page_figure
from ._flank_lines import FlankLine

_SIDES = ("screw", "nut")


@drawn
def contact_ellipses(
    contacts: Mapping[str, StageContact],
    largest: Mapping[str, tuple[float, float]] | None = None,
    ends: Mapping[str, Sequence[FlankLine]] | None = None,
) -> Figure:
    """Draw the contact ellipses of screw and nut side, all to the same scale.

    The major axis is drawn horizontally, whatever its direction in the thread. Whole ellipses are
    drawn, with the Hertz pressure, even if a flank ends within them; lines are the crests and roots
    where flanks end, as far as they lie in the picture.

    **Arguments:**

    - `contacts`: by label, for example `{"before": …, "after": …}`.
    - `largest`: largest pressures on the screw and on the nut side by label, with the effect of
        the ends of flanks [Pa]; default those of the whole ellipses.
    - `ends`: crests and roots by label, from `flank_lines`.

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
    if ends is not None:
        x_limit, y_limit = _with_lines(contacts, ends, unit, (x_limit, y_limit))
    x_limit, y_limit = max(x_limit, 1e-12), max(y_limit, 1e-12)
    # A column of the page leaves 66 mm for the axes themselves.
    height = 66.0 * y_limit / x_limit + 16.0
    figure = page_figure(height * len(contacts) + (14.0 if ends is None else 20.0))
    grid = figure.subplots(len(contacts), 2, squeeze=False, sharex=True, sharey=True)
    image = None
    shown: dict[str, Any] = {}
    for row, label in enumerate(contacts):
        for column, side in enumerate(_SIDES):
            axes, contact = grid[row, column], hertz[label, side]
            image = _ellipse(axes, contact, unit, x_limit, y_limit, max(highest, 1e-12))
            for line in () if ends is None else ends.get(label, ()):
                if line.side == side:
                    _end(axes, line, contact, unit, (x_limit, y_limit), shown)
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
    legend_below(figure, list(shown.values()), 4)
    return figure


#: Line styles of the ends of flanks.
_ENDS: dict[str, Any] = {
    "crest of the screw": {"color": "#d55e00", "ls": "-"},
    "root of the screw": {"color": "#d55e00", "ls": (0, (2, 1.5))},
    "crest of the nut": {"color": "#009e73", "ls": "-"},
    "root of the nut": {"color": "#009e73", "ls": (0, (2, 1.5))},
    "crest of the roller": {"color": "#0072b2", "ls": (0, (6, 2))},
    "root of the roller": {"color": "#0072b2", "ls": (0, (1, 1.2))},
}


#: Lines farther away than this, in halves of the picture, are left out of it.
_FAR = 1.7


def _with_lines(
    contacts: Mapping[str, StageContact],
    ends: Mapping[str, Sequence[FlankLine]],
    unit: DisplayUnit,
    limits: tuple[float, float],
) -> tuple[float, float]:
    """Halves of the picture that show crests and roots close to the ellipses, too."""
    found = list(limits)
    for label, lines in ends.items():
        for line in lines:
            hertz = getattr(contacts[label], line.side).hertz
            way = line.direction(float(hertz.semi_major), float(hertz.semi_minor))
            needed = [1.1 * unit(abs(line.distance * part)) for part in way]
            if all(one <= _FAR * limit for one, limit in zip(needed, limits, strict=True)):
                found = [max(pair) for pair in zip(found, needed, strict=True)]
    return found[0], found[1]


def _end(
    axes: Axes,
    line: FlankLine,
    contact: HertzContact,
    unit: DisplayUnit,
    limits: tuple[float, float],
    shown: dict[str, Any],
) -> None:
    """A crest or root, if it lies in the picture; `shown` collects entries of the legend."""
    x, y = line.direction(float(contact.semi_major), float(contact.semi_minor))
    distance = unit(line.distance)
    # Where the line would leave the picture at its nearest corner.
    if abs(distance) > abs(x) * limits[0] + abs(y) * limits[1]:
        return
    reach = 2 * (limits[0] + limits[1])
    style = {"lw": 1.4, "zorder": 3, **_ENDS[line.words]}
    xs = [distance * x + s * reach * y for s in (-1, 1)]
    ys = [distance * y - s * reach * x for s in (-1, 1)]
    axes.plot(xs, ys, scalex=False, scaley=False, **style)
    shown[line.words] = legend_line(line.words, **style)


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
