"""Frequency responses: magnitude in decibels and phase, natural frequencies marked by family."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...response import FrequencyResponse
from ...text import number
from ...vibration import Modes
from .._style import FAINT, FAMILY_COLOURS, INK, SERIES, Axes, Figure, drawn, page_figure

_HEIGHT = 120.0
#: Line styles, to distinguish several responses without colour.
_DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1, 1.5)))
#: Unit of each kind on the scale on the right, and its factor from SI.
_UNITS = {
    "receptance": ("µm/N", 1e6),
    "mobility": ("(mm/s)/N", 1e3),
    "accelerance": ("(m/s²)/N", 1.0),
}
#: Values this far below the largest one are not shown [dB].
_DEPTH = 180.0


@drawn
def response_chart(
    responses: Mapping[str, FrequencyResponse], modes: Modes | None = None
) -> Figure:
    """Draw the magnitude and the phase of one or several frequency responses in one chart.

    Magnitude in dB re 1 SI unit (1 m/N for a receptance), on the right in µm/N (mm/s/N for a
    mobility, m/s²/N for an accelerance), phase in degrees. The frequency axis is
    logarithmic unless it starts at zero. Infinite values, at the poles of an undamped system, leave
    gaps.

    **Arguments:**

    - `responses`: by label; all of one kind.
    - `modes`: natural frequencies to mark, by family.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` without a response, for responses of different kinds, or if nothing
    moves; `MissingExtraError` without matplotlib.
    """
    if not responses:
        raise ValueError("response_chart needs at least one response")
    kinds = {response.kind for response in responses.values()}
    if len(kinds) > 1:
        raise ValueError(f"the responses are of kinds {', '.join(sorted(kinds))}; draw one kind")
    first = next(iter(responses.values()))
    figure = page_figure(_HEIGHT)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1))
    highest = -np.inf
    for index, (label, response) in enumerate(responses.items()):
        hertz, size = np.asarray(response.frequency), np.array(response.decibel)
        angle = np.degrees(np.asarray(response.phase))
        size[~np.isfinite(size)] = np.nan
        if np.isnan(size).all():
            raise ValueError(
                f"nothing moves at {response.response} under a force at {response.excitation}; "
                "symmetry decouples some pairs: choose another pair"
            )
        highest = max(highest, float(np.nanmax(size)))
        style: dict[str, Any] = {
            "color": SERIES[index % len(SERIES)] if len(responses) > 1 else INK,
            "ls": _DASHES[index % len(_DASHES)],
            "lw": 1.1,
        }
        upper.plot(hertz, size, label=label, zorder=3, **style)
        lower.plot(hertz, _without_jumps(angle), zorder=3, **style)
    hertz = np.concatenate([np.asarray(response.frequency) for response in responses.values()])
    if hertz.min() > 0:
        upper.set_xscale("log")
    upper.set_xlim(hertz.min(), hertz.max())
    bottom = max(upper.get_ylim()[0], highest - _DEPTH)
    upper.set_ylim(bottom, highest + 0.08 * (highest - bottom))
    _in_units(upper, first.kind)
    lower.set_ylim(-190, 190)
    lower.set_yticks([-180, -90, 0, 90, 180])
    upper.set_ylabel(f"{first.kind} in dB re 1 {first.unit}")
    lower.set_ylabel("phase in deg")
    lower.set_xlabel("frequency in Hz")
    lower.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}".replace(",", " "))
    for axes in (upper, lower):
        axes.grid(axis="both", which="major", color=FAINT)
    pairs = {(response.excitation, response.response) for response in responses.values()}
    title = f"{first.response} under a force at {first.excitation}" if len(pairs) == 1 else ""
    upper.set_title(title or "Frequency responses")
    inside = None
    if len(responses) > 1:
        inside = upper.legend(loc="lower left", handlelength=2.4, frameon=True, framealpha=0.9)
        inside.get_frame().set_edgecolor("none")
    handles = [] if modes is None else _mark(upper, lower, modes)
    if handles and inside is not None:
        # A second legend replaces the first unless that is added as an artist.
        upper.add_artist(inside)
    if handles:
        upper.legend(
            handles=handles,
            loc="lower right",
            bbox_to_anchor=(1, 1.0),
            ncols=len(handles),
            handlelength=1.6,
            columnspacing=1.2,
        )
    return figure


def _in_units(axes: Axes, kind: str) -> None:
    """A second scale on the right, in an engineer's unit."""
    label, per_si = _UNITS[kind]

    def size(decibel):
        return per_si * 10.0 ** (np.asarray(decibel, dtype=float) / 20)

    def decibel(size):
        return 20 * np.log10(np.maximum(np.asarray(size, dtype=float), 1e-300) / per_si)

    from matplotlib.ticker import NullLocator

    scale = axes.secondary_yaxis("right", functions=(size, decibel))
    low, high = (float(np.log10(size(end))) for end in axes.get_ylim())
    powers = np.arange(np.ceil(low), np.floor(high) + 1)
    # Every second or third decade, if there are many.
    powers = powers[:: max(1, -(-len(powers) // 6))]
    scale.set_yticks(10.0**powers, [number(10.0**p, 1) for p in powers])
    scale.yaxis.set_minor_locator(NullLocator())
    scale.set_ylabel(f"{kind} in {label}")


def _without_jumps(angle: np.ndarray) -> np.ndarray:
    """Phases with a gap where they wrap from −180° to 180°, which is not a real change."""
    angle = angle.astype(float)
    angle[1:][np.abs(np.diff(angle)) > 300] = np.nan
    return angle


def _mark(upper, lower, modes: Modes) -> list[Any]:
    """Natural frequencies as thin lines in the colour of their family; handles for a legend."""
    from matplotlib.lines import Line2D

    left, right = upper.get_xlim()
    shown: dict[str, str] = {}
    for value, family in zip(np.asarray(modes.frequencies), modes.families, strict=True):
        if left <= value <= right and family != "rigid":
            shown[family] = FAMILY_COLOURS[family]
            for axes in (upper, lower):
                axes.axvline(value, color=FAMILY_COLOURS[family], lw=0.8, alpha=0.7, zorder=1)
    return [Line2D([], [], color=colour, lw=1.2, label=family) for family, colour in shown.items()]
