"""Loads of all threads around the screw, as errors of parts or a tilted nut distribute them."""

from typing import Any

import numpy as np

from ...load_sharing import LoadDistribution, SideLoads
from ...text import display_unit, in_unit, number
from .._parts import colour_bar, page_title
from .._style import INK, SERIES, SMALL, Figure, drawn, page_figure

#: Innermost thread over the number of threads: sectors need some width there.
_INNER = 0.5
#: Pieces of a sector.
_PIECES = 12


@drawn
def roller_force_chart(distribution: LoadDistribution) -> Figure:
    """Draw the load of every thread of every roller at its angle, screw side and nut side.

    A sector is a roller at its angle, seen from the end where the screw's force enters; the first
    thread is the innermost ring. The line on the nut side shows the direction of the rollers'
    radial force on the nut. Both flanks of a thread are added.

    **Arguments:**

    - `distribution`: a load distribution with errors of parts or a free nut, with concrete numbers.

    **Returns:** a matplotlib figure; loads in N.

    **Raises:** `ValueError` for a distribution without angles of rollers; `MissingExtraError`
    without matplotlib.
    """
    from matplotlib.colors import LinearSegmentedColormap

    if distribution.roller_angle is None:
        raise ValueError(
            "the distribution has no angles of rollers; give [stage.load_sharing.part_errors] or "
            "[stage.load_sharing.free_nut], or use thread_load_chart"
        )
    angle = np.asarray(distribution.roller_angle)
    numbers = [str(n) for (n,) in distribution.rollers]
    loads = [np.asarray(side.thread_load) for side in (distribution.screw, distribution.nut)]
    largest = max(one.max() for one in loads) or 1.0
    scale = LinearSegmentedColormap.from_list("load", ["#ffffff", "#cfe3f1", SERIES[0], "#00263d"])
    figure = page_figure(92)
    panels = figure.subplots(1, 2, subplot_kw={"projection": "polar"})
    mesh = None
    for axes, values, words in zip(panels, loads, ("screw side", "nut side"), strict=True):
        mesh = _sectors(axes, angle, values, {"cmap": scale, "vmin": 0.0, "vmax": largest})
        axes.set_xticks(angle, numbers)
        axes.set_title(words)
        axes.set_xlabel(_words(distribution, words), fontsize=SMALL)
    direction = _vector(distribution.nut_radial_force)[1]
    threads = loads[1].shape[1]
    panels[1].plot([direction] * 2, [0.5, threads + 0.5], color=INK, lw=1.6, ls=(0, (4, 2)))
    load = in_unit(distribution.load, display_unit("N", float(distribution.load)), 3)
    page_title(figure, f"Loads of threads around the screw under {load}; first thread inside")
    bar = colour_bar(figure, mesh, list(panels), "axial load of a thread in N")
    bar.ax.tick_params(labelsize=SMALL)
    return figure


def _words(distribution: LoadDistribution, words: str) -> str:
    """What stands below one side."""
    side: SideLoads = getattr(distribution, words.split()[0])
    factor = f"largest over mean roller load {number(float(side.roller_sharing_factor), 3)}"
    if words != "nut side":
        return factor
    force = _vector(distribution.nut_radial_force)[0]
    pressed = f"dashed: radial force on the nut, {in_unit(force, display_unit('N', force), 3)}"
    moment, towards = _vector(distribution.nut_overturning_moment)
    return (
        f"{factor}\n{pressed}\n"
        f"moment on the nut {in_unit(moment, display_unit('N·m', moment), 3)} "
        f"towards {number(np.degrees(towards) % 360, 3)} deg"
    )


def _vector(components: Any) -> tuple[float, float]:
    """Length and angle of a vector across the axis."""
    x, y = (float(one) for one in np.asarray(components))
    return float(np.hypot(x, y)), float(np.arctan2(y, x))


def _sectors(axes: Any, angle: np.ndarray, values: np.ndarray, style: dict[str, Any]) -> Any:
    """A sector for each roller, bounded halfway to its neighbours, and a ring for each thread."""
    order = np.argsort(angle)
    around = angle[order]
    following = np.append(around[1:], around[0] + 2 * np.pi)
    middle = (around + following) / 2
    corners = np.concatenate([[middle[-1] - 2 * np.pi], middle])
    # Straight pieces of a mesh that look like arcs.
    pieces = np.arange(len(angle) * _PIECES + 1) / _PIECES
    edges = np.interp(pieces, np.arange(len(corners)), corners)
    threads = values.shape[1]
    rings = np.arange(threads + 1) + 0.5
    mesh = axes.pcolormesh(
        edges, rings, np.repeat(values[order].T, _PIECES, axis=1), shading="flat", **style
    )
    axes.set_rorigin(-_INNER * threads)
    axes.set_rlim(0.5, threads + 0.5)
    axes.set_yticks([])
    axes.grid(False)
    axes.tick_params(pad=1)
    return mesh
