"""Force over deflection of a nut, with its play or preload."""

from collections.abc import Mapping

import numpy as np

from ...load_sharing import ForceDeflection
from ...text import display_unit, in_unit
from .._parts import legend_below
from .._style import INK, MUTED, SERIES, SMALL, Figure, drawn, page_figure

_DASHES: tuple[str, ...] = ("-", "--", "-.", ":")


def _parts(load: np.ndarray, deflection: np.ndarray, slope: np.ndarray) -> list[slice]:
    """Parts in which the stiffness curve is drawn: two if there is play, else one.

    In the play no point carries load: the nut travels farther than the stiffnesses at the two
    smallest loads account for. Without play it travels at most 3/2 of that, as the stiffness of the
    contacts falls to 0.
    """
    if not load.min() < 0 < load.max():
        return [slice(None)]
    before, after = np.flatnonzero(load < 0)[-1], np.flatnonzero(load > 0)[0]
    elastic = (load[after] - load[before]) / min(slope[before], slope[after])
    if deflection[after] - deflection[before] > 2 * elastic:
        return [slice(before + 1), slice(after, None)]
    return [slice(None)]


@drawn
def force_deflection_chart(curves: Mapping[str, ForceDeflection]) -> Figure:
    """Draw force–deflection curves and, below them, the tangent stiffness over the load.

    A thin line continues each curve's tangent at its largest load: the linear estimate. Where the
    load changes its sign, the travel between the flanks is the backlash.

    **Arguments:**

    - `curves`: by label, for example `{"backlash 10 µm": …, "preload 3 kN": …}`.

    **Returns:** a matplotlib figure; loads in N or kN, deflections in µm or mm, stiffness in N/µm.

    **Raises:** `ValueError` without a curve; `MissingExtraError` without matplotlib.
    """
    if not curves:
        raise ValueError("force_deflection_chart needs at least one curve")
    points = {
        label: tuple(
            np.asarray(values)[np.argsort(np.asarray(curve.load), kind="stable")]
            for values in (curve.load, curve.deflection, curve.tangent_stiffness)
        )
        for label, curve in curves.items()
    }
    force = display_unit("N", [float(np.abs(p[0]).max()) for p in points.values()])
    length = display_unit("m", [float(np.abs(p[1]).max()) for p in points.values()])
    stiffness = display_unit("N/m", [float(np.abs(p[2]).max()) for p in points.values()])
    figure = page_figure(140)
    above, below = figure.subplots(2, 1, height_ratios=(3, 2))
    for index, (label, (load, deflection, slope)) in enumerate(points.items()):
        colour, dashes = SERIES[index % len(SERIES)], _DASHES[index % len(_DASHES)]
        style = {"color": colour, "ls": dashes, "lw": 1.4}
        above.plot(length(deflection), force(load), label=label, **style)
        at = int(np.argmax(load))
        reach = np.array([0.0, load[at]])
        tangent = deflection[at] + (reach - load[at]) / slope[at]
        above.plot(length(tangent), force(reach), color=colour, lw=0.6)
        for part in _parts(load, deflection, slope):
            below.plot(force(load[part]), stiffness(slope[part]), **style)
        words = f"  {in_unit(slope[at], stiffness, 3)}"
        below.annotate(words, (force(load[at]), stiffness(slope[at])), va="center", fontsize=SMALL)
    above.axhline(0, color=INK, lw=0.6)
    above.axvline(0, color=INK, lw=0.6)
    above.plot([], [], color=MUTED, lw=0.6, label="tangent at the largest load")
    for axes in (above, below):
        axes.grid()
    above.set_title("Axial load over deflection of the nut")
    above.set_xlabel(f"deflection from contact of the nominal forward flanks in {length.label}")
    above.set_ylabel(f"axial load in {force.label}")
    below.set_title("Tangent stiffness: contacts, teeth and shafts")
    below.set_xlabel(f"axial load in {force.label}")
    below.set_ylabel(f"stiffness in {stiffness.label}")
    below.set_ylim(bottom=0)
    below.margins(x=0.1)
    legend_below(figure, above.get_legend_handles_labels()[0], 4)
    return figure
