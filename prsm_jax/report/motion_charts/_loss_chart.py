"""Power balance: output and every loss by name."""

from collections.abc import Mapping
from typing import Any

from ...dynamics import SteadyState
from ...text import display_unit, in_unit, number
from .._parts import legend_below
from .._style import LOSS_COLOURS, MUTED, SERIES, SMALL, Figure, drawn, page_figure, readable

_OUTPUT = "#b8d8c8"
#: Hatches distinguish losses in print without colour.
_HATCHES = {
    "spin": "////",
    "rolling_hysteresis": "....",
    "spline": "xxxx",
    "thrust_bearing": "\\\\\\\\",
}


def loss_style(name: str, index: int = 0) -> dict[str, Any]:
    """Colour and hatch of a loss."""
    colour = LOSS_COLOURS.get(name, SERIES[index % len(SERIES)])
    return {"facecolor": colour, "hatch": _HATCHES.get(name, ""), "edgecolor": "white"}


@drawn
def loss_chart(states: Mapping[str, SteadyState]) -> Figure:
    """Draw the power balance of one or several steady states.

    Above, output and losses as shares of the input power; below, the losses alone in W. When the
    mechanism is self-locking, both ends supply power, and the losses are 100 % of it.

    **Arguments:**

    - `states`: by label, for example `{"before": …, "after": …}`.

    **Returns:** a matplotlib figure; powers in W or kW and per cent.

    **Raises:** `ValueError` without a state; `MissingExtraError` without matplotlib.
    """
    if not states:
        raise ValueError("loss_chart needs at least one steady state")
    names = list(dict.fromkeys(name for state in states.values() for name in state.losses))
    unit = display_unit("W", [float(s.input_power) for s in states.values()])
    small = display_unit("W", [float(sum(s.losses.values(), 0.0)) for s in states.values()])
    figure = page_figure(2 * (9 * len(states) + 14) + 14)
    above, below = figure.subplots(2, 1)
    for row, state in enumerate(states.values()):
        output, losses = float(state.output_power), {n: float(v) for n, v in state.losses.items()}
        total = sum(losses.values())
        source = max(output, 0.0) + total
        share = 100 / source if source > 0 else 0.0
        start = max(output, 0.0) * share
        above.barh(row, start, height=0.6, facecolor=_OUTPUT, edgecolor="white")
        if start > 25:
            words = f"output {in_unit(output, unit)}, {number(start, 4)} %"
            above.text(start / 2, row, words, ha="center", va="center", fontsize=SMALL)
        position = 0.0
        for index, name in enumerate(names):
            loss = losses.get(name, 0.0)
            style = loss_style(name, index)
            above.barh(row, loss * share, left=start, height=0.6, **style)
            below.barh(row, small(loss), left=position, height=0.6, **style)
            start += loss * share
            position += small(loss)
        words = f"  input {in_unit(source, unit)}" if source > 0 else "  no motion, no power"
        above.text(100 if source > 0 else 0, row, words, va="center", fontsize=SMALL)
        below.text(position, row, f"  {in_unit(total, small)}", va="center", fontsize=SMALL)
    for axes in (above, below):
        axes.set_yticks(range(len(states)), list(states))
        axes.set_ylim(len(states) - 0.5, -0.5)
        axes.tick_params(axis="y", length=0)
        axes.grid(axis="x")
    above.set_xlim(0, 122)
    above.set_xticks(range(0, 101, 20))
    below.set_xlim(0, 1.18 * max(below.get_xlim()[1], 1e-12))
    above.set_xlabel("share of the input power in %")
    below.set_xlabel(f"power lost in {small.label}")
    above.set_title("Power balance in the steady state")
    below.set_title("Losses by name")
    _legend(figure, names)
    return figure


def _legend(figure: Figure, names: list[str]) -> None:
    from matplotlib.patches import Patch

    handles = [Patch(facecolor=_OUTPUT, edgecolor=MUTED, linewidth=0.4, label="output")]
    handles += [
        Patch(**loss_style(name, index), label=readable(name)) for index, name in enumerate(names)
    ]
    legend_below(figure, handles)
