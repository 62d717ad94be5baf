"""Natural frequencies against a parameter: families cross, curves of one family veer."""

from typing import Any

import numpy as np

from ...text import DisplayUnit, display_unit, in_unit, show
from ...vibration import FAMILIES, RIGID_SHARE, FrequencyLoci, Veering
from .._parts import WHITE, aside, in_words, legend_below, plain_ticks
from .._style import FAMILY_COLOURS, INK, SMALL, Axes, Figure, drawn, page_figure, readable

#: Frequencies that differ by more than this factor are drawn on a logarithmic axis.
_WIDE = 20.0
_ENLARGED = 2


@drawn
def frequency_loci_chart(loci: FrequencyLoci) -> Figure:
    """Draw natural frequencies against a parameter.

    Curves of one family never cross: where they come close they veer, and the closest veerings are
    enlarged beside the chart. Without symmetry the colour of every curve mixes the colours of the
    families in the proportions of its shape.

    **Arguments:**

    - `loci`: the curves, from `frequency_loci`.

    **Returns:** a matplotlib figure; the parameter in a suitable unit, frequencies in Hz or
    kHz. Rigid motions are left out; so are values at which the thread does not mesh.

    **Raises:** `ValueError` if no value gives a frequency; `MissingExtraError` without matplotlib.
    """
    every = _positive(loci)
    if not every.size:
        raise ValueError(f"no value of {loci.parameter} gives a mechanism that meshes and vibrates")
    unit = display_unit(loci.unit, [float(v) for v in loci.values])
    hertz = display_unit("Hz", float(every.max()))
    close = loci.veerings()[:_ENLARGED]
    figure = page_figure(112)
    grid = figure.add_gridspec(max(len(close), 1), 2, width_ratios=(2.3, 1)) if close else None
    main = figure.add_subplot() if grid is None else figure.add_subplot(grid[:, 0])
    _curves(main, loci, unit, hertz)
    if every.max() > _WIDE * every.min():
        main.set_yscale("log")
        plain_ticks(main.yaxis)
    if _equal_ratios(np.asarray(loci.values)):
        main.set_xscale("log")
        main.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    room = 0.3 if loci.integer else 0.0
    first, last = sorted(unit(float(loci.values[i])) for i in (0, -1))
    main.set_xlim(first - room, last + room)
    main.grid(axis="both", which="major")
    main.set_xlabel(_label(loci, unit))
    main.set_ylabel(f"natural frequency in {hertz.label}")
    main.set_title("Natural frequencies")
    for index, veering in enumerate(close):
        assert grid is not None
        _enlarge(figure.add_subplot(grid[index, 1]), main, loci, veering, unit, hertz, index)
    _legend(figure, loci)
    return figure


def _equal_ratios(values: np.ndarray) -> bool:
    """Whether the values have equal ratios, as chosen for a logarithmic axis."""
    if (values <= 0).any() or len(values) < 3:
        return False
    ratios = values[1:] / values[:-1]
    # Ratios may differ by rounding only; equal differences over a narrow range do not pass.
    return bool(np.ptp(ratios) < 1e-6 * abs(ratios[0] - 1))


def _positive(loci: FrequencyLoci) -> np.ndarray:
    flat = np.concatenate([np.asarray(rows).ravel() for rows in loci.frequencies.values()])
    flat = flat[np.isfinite(flat)]
    return flat[flat > RIGID_SHARE * flat.max(initial=0.0)]


def _label(loci: FrequencyLoci, unit: DisplayUnit) -> str:
    return in_words(readable(loci.parameter).replace(".", " "), unit)


def _curves(axes: Axes, loci: FrequencyLoci, unit: DisplayUnit, hertz: DisplayUnit) -> None:
    xs = unit(np.asarray(loci.values))
    largest = _positive(loci).max()
    for family, rows in loci.frequencies.items():
        for index, curve in enumerate(np.asarray(rows).T):
            ys = hertz(np.where(curve > RIGID_SHARE * largest, curve, np.nan))
            if not np.isfinite(ys).any():
                continue
            marks = {"marker": "o", "ms": 3.5} if loci.integer else {}
            if family in FAMILY_COLOURS:
                axes.plot(xs, ys, color=FAMILY_COLOURS[family], gid=f"{family} {index}", **marks)
            else:
                assert loci.shares is not None
                _mixed(axes, xs, ys, np.asarray(loci.shares)[:, :, index], bool(loci.integer))


def _mixed(axes: Axes, xs: np.ndarray, ys: np.ndarray, shares: np.ndarray, marks: bool) -> None:
    """A curve in pieces, each in the mixed colour of its shape."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import to_rgb

    pure = np.asarray([to_rgb(FAMILY_COLOURS[family]) for family in FAMILIES])
    colours = np.clip(shares @ pure, 0, 1)
    points = np.stack([xs, ys], axis=1)
    middle = (points[1:] + points[:-1]) / 2
    # Each point colours half of the way to its neighbours.
    starts, ends = np.vstack([points[:1], middle]), np.vstack([middle, points[-1:]])
    pieces = np.stack([starts, points, ends], axis=1)
    axes.add_collection(
        LineCollection(list(pieces), colors=list(colours), linewidths=1.4, capstyle="round")
    )
    axes.scatter(xs, ys, s=12 if marks else 0, c=colours, linewidths=0)


def _enlarge(
    axes: Axes,
    main: Axes,
    loci: FrequencyLoci,
    veering: Veering,
    unit: DisplayUnit,
    hertz: DisplayUnit,
    index: int,
) -> None:
    """An enlarged view of the veering of two curves, and its frame in the chart."""
    from matplotlib.patches import Rectangle

    rows = np.asarray(loci.frequencies[veering.family])
    low, high = rows[:, veering.lower], rows[:, veering.lower + 1]
    values, gap = np.asarray(loci.values), high - low
    # Up to where the curves are twice their least distance apart, equal on both sides.
    distance = np.abs(values - values[veering.at])
    separated = distance[gap > 2 * gap[veering.at]]
    reach = float(separated.min()) if separated.size else float(distance.max())
    reach = max(reach, 1.01 * float(np.sort(distance)[min(4, len(distance) - 1)]))
    near = distance <= reach
    bottom, top = float(low[near].min()), float(high[near].max())
    margin = 0.12 * (top - bottom)
    _curves(axes, loci, unit, hertz)
    left, right = (unit(veering.value + sign * reach) for sign in (-1, 1))
    bottom, top = hertz(bottom - margin), hertz(top + margin)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.grid(axis="both", which="major")
    axes.locator_params(nbins=4)
    axes.set_xlabel(unit.label, fontsize=SMALL)
    axes.set_ylabel(hertz.label, fontsize=SMALL)
    letter = "AB"[index]
    least = veering.frequencies[1] - veering.frequencies[0]
    axes.set_title(
        f"{letter}: {show(least, 'Hz', digits=3)} apart at {in_unit(veering.value, unit)}",
        fontsize=SMALL,
    )
    frame = Rectangle((left, bottom), right - left, top - bottom, fill=False, ec=INK, lw=0.6)
    main.add_patch(frame)
    style = {"fontweight": "bold", "color": INK, "bbox": {**WHITE, "pad": 0.6}}
    aside(main, letter, (left, bottom), (-2, -1), va="top", **style)


def _legend(figure: Figure, loci: FrequencyLoci) -> None:
    from matplotlib.lines import Line2D

    handles: list[Any] = []
    coupled = loci.shares is not None
    for family in FAMILIES:
        if family not in loci.frequencies and not (coupled and family != "carrier"):
            continue
        times = loci.multiplicities.get(family, 1)
        changes = loci.integer and family == "roller"
        words = f"{family} (×{times})" if times > 1 and not changes else family
        handles.append(Line2D([], [], color=FAMILY_COLOURS[family], lw=2, label=words))
    if coupled:
        handles.append(Line2D([], [], ls="", label="mixed colours: mixed families"))
    legend_below(figure, handles, fontsize=SMALL)
