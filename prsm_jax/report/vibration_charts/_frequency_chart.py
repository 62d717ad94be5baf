"""Natural frequencies by family, before and after."""

from collections.abc import Mapping

from ...text import show
from ...vibration import Modes
from .._parts import aside
from .._style import FAMILY_COLOURS, MUTED, TEXT, Figure, drawn, page_figure

_ORDER = ("carrier", "torsional", "transverse", "roller")


def elastic_modes(modes: Modes) -> tuple[dict[tuple[str, int], tuple[float, int]], int]:
    """Distinct elastic modes by family and number, and how many rigid-body modes there are.

    **Returns:** `{(family, number): (frequency [Hz], multiplicity)}`, families in the order of
    drawing, numbers from 1; and the number of rigid-body modes.
    """
    families, frequencies = modes.families, [float(f) for f in modes.frequencies]
    elastic: dict[tuple[str, int], tuple[float, int]] = {}
    for family in _ORDER:
        at, number = 0, 0
        while at < len(families):
            times = modes.multiplicities[at]
            if families[at] == family:
                number += 1
                elastic[family, number] = (frequencies[at], times)
            at += times
    return elastic, families.count("rigid")


@drawn
def frequency_chart(modes: Mapping[str, Modes]) -> Figure:
    """Draw the natural frequencies of one or several designs as stems on a logarithmic axis.

    One row for each mode, by family; designs lie under each other in the row. Rigid-body modes
    cannot be shown on a logarithmic axis; their number is given under it.

    **Arguments:**

    - `modes`: by label, for example `{"before": …, "after": …}`.

    **Returns:** a matplotlib figure; frequencies in Hz, multiplicities as ×2.

    **Raises:** `ValueError` without a design; `MissingExtraError` without matplotlib.
    """
    if not modes:
        raise ValueError("frequency_chart needs at least one set of modes")
    designs = {label: elastic_modes(m) for label, m in modes.items()}
    rows = sorted(
        {key for elastic, _ in designs.values() for key in elastic},
        key=lambda key: (_ORDER.index(key[0]), key[1]),
    )
    every = [f for elastic, _ in designs.values() for f, _ in elastic.values()]
    step = 3.6 * len(designs) + 2.4
    figure = page_figure(step * len(rows) + 26)
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_xlim(min(every) / 2.5, max(every) * 5)
    for index, (family, number) in enumerate(rows):
        for turn, (elastic, _) in enumerate(designs.values()):
            if (family, number) not in elastic:
                continue
            value, multiplicity = elastic[family, number]
            y = index + (turn - (len(designs) - 1) / 2) * 3.6 / step
            last = turn == len(designs) - 1
            colour = FAMILY_COLOURS[family]
            style = {"color": colour, "lw": 1.6 if last else 0.8, "solid_capstyle": "butt"}
            axes.plot((axes.get_xlim()[0], value), (y, y), **style)
            axes.plot(value, y, "o", ms=4.5, mec=colour, mfc=colour if last else "white", mew=1.1)
            words = show(value, "Hz") + (f"  ×{multiplicity}" if multiplicity > 1 else "")
            aside(axes, words, (value, y), (5, 0), va="center")
    axes.set_yticks(range(len(rows)), [f"{family} {number}" for family, number in rows])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(axis="x", which="major")
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}".replace(",", " "))
    axes.set_xlabel(_axis_label(designs))
    axes.set_title("Natural frequencies by family")
    if len(designs) > 1:
        _design_legend(axes, list(designs))
    return figure


def _axis_label(designs) -> str:
    rigid = {label: count for label, (_, count) in designs.items() if count}
    if not rigid:
        return "natural frequency in Hz"
    counts = sorted(set(rigid.values()))
    return f"natural frequency in Hz   (and {counts[-1]} rigid-body mode(s) at 0 Hz)"


def _design_legend(axes, labels: list[str]) -> None:
    from matplotlib.lines import Line2D

    last = len(labels) - 1
    handles = [
        Line2D(
            [],
            [],
            color=MUTED,
            marker="o",
            ms=4.5,
            mfc=MUTED if index == last else "white",
            lw=1.6 if index == last else 0.8,
            label=label,
        )
        for index, label in enumerate(labels)
    ]
    axes.legend(
        handles=handles,
        loc="lower right",
        bbox_to_anchor=(1, 1.0),
        ncols=len(labels),
        fontsize=TEXT,
    )
