"""Course of an optimisation: the objective by iteration, and the use of each limit."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...text import display_unit, in_unit, number
from .._parts import in_words
from .._style import ACTIVE, FREE, INK, SERIES, SMALL, Figure, drawn, page_figure, readable


def limit_use(value: float, limit: float, upper: bool) -> float:
    """The share of a limit that is used: 1 at the limit, above 1 beyond it.

    Value over limit for an upper limit, limit over value for a lower one; NaN where a sign or a
    zero makes the ratio meaningless.
    """
    numerator, denominator = (value, limit) if upper else (limit, value)
    if denominator == 0 or numerator * denominator < 0:
        return math.nan
    return numerator / denominator


def is_upper_limit(constraint: Any) -> bool:
    """Whether a constraint's limit is an upper one; from its `sense`, or else from its value."""
    sense = getattr(constraint, "sense", None)
    if sense in ("upper", "lower"):
        return sense == "upper"
    return float(constraint.value) <= float(constraint.limit)


#: A relative violation below this is rounding.
_WITHIN = 1e-6


@drawn
def optimisation_chart(
    history: Sequence[float | int],
    constraints: Sequence[Any],
    *,
    objective: str = "objective",
    unit: str = "1",
    violations: Sequence[float | int] = (),
    feasible: bool = True,
) -> Figure:
    """Draw the objective against the iteration, and the activity of the constraints.

    **Arguments:**

    - `history`: objective after each iteration [SI], the start first.
    - `constraints`: objects with `quantity`, `value`, `limit` [SI], `active`, and optionally
      `unit` and `sense` (`"upper"`, `"lower"`, `"equal"`). May be empty.
    - `objective`: name of the objective.
    - `unit`: its SI unit.
    - `violations`: largest relative violation of a limit after each iteration; designs that
      violate limits are drawn hollow.
    - `feasible`: false where the final design violates a limit, and is not an optimum.

    **Returns:** a matplotlib figure.

    **Raises:** `ValueError` for an empty history; `MissingExtraError` without matplotlib.
    """
    values = np.asarray(history, dtype=float)
    if values.size == 0:
        raise ValueError("the objective's history is empty; there is nothing to draw")
    height = max(62.0, 8.0 * len(constraints) + 26.0)
    figure = page_figure(height)
    if constraints:
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
        _activity(right, constraints)
        end = "at the optimum" if feasible else "of the best design found"
        right.set_title(f"Constraints {end}")
    else:
        left = figure.add_subplot()
    shown = display_unit(unit, [float(v) for v in values], objective)
    iterations = np.arange(values.size)
    left.plot(iterations, shown(values), color=SERIES[0])
    outside = np.zeros(values.size, dtype=bool)
    if len(violations) == values.size:
        outside = np.asarray(violations, dtype=float) > _WITHIN
    dots = {"ls": "", "marker": "o", "ms": 3.5, "mec": SERIES[0], "mew": 0.9, "clip_on": False}
    left.plot(iterations[~outside], shown(values[~outside]), mfc=SERIES[0], **dots)
    note = ""
    if outside.any():
        left.plot(iterations[outside], shown(values[outside]), mfc="white", **dots)
        note = "\nhollow: limits violated"
    left.set_xlabel(f"iteration (number){note}")
    left.set_ylabel(in_words(readable(objective), shown))
    left.set_title("Objective")
    left.grid(True)
    left.margins(y=0.12)
    from matplotlib.ticker import MaxNLocator

    left.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))
    return figure


def _unit_of(constraint: Any) -> str:
    unit = getattr(constraint, "unit", None)
    if unit is not None:
        return unit
    from ...quantities import find_quantity

    return find_quantity(str(constraint.quantity).partition("[")[0]).unit


def _activity(axes, constraints: Sequence[Any]) -> None:
    uses = [limit_use(float(c.value), float(c.limit), is_upper_limit(c)) for c in constraints]
    drawn_uses = [100 * u if math.isfinite(u) else 0.0 for u in uses]
    for row, (constraint, use) in enumerate(zip(constraints, drawn_uses, strict=True)):
        active = bool(constraint.active)
        axes.barh(
            row + 0.16,
            use,
            height=0.34,
            facecolor=ACTIVE if active else FREE,
            hatch="////" if active else "",
            edgecolor="white",
        )
        name, unit = str(constraint.quantity), _unit_of(constraint)
        shown = display_unit(unit, [float(constraint.value), float(constraint.limit)], name)
        sense = getattr(constraint, "sense", None)
        sign = "=" if sense == "equal" else ("≤" if is_upper_limit(constraint) else "≥")
        axes.text(
            1.0,
            row - 0.24,
            f"{readable(name)}: {number(shown(float(constraint.value)))} {sign} "
            f"{in_unit(float(constraint.limit), shown)}" + (", active" if active else ""),
            fontsize=SMALL,
            va="center",
            fontweight="bold" if active else "normal",
        )
    axes.axvline(100, color=INK, lw=0.8)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_ylim(len(constraints) - 0.4, -0.6)
    axes.set_xlim(0, max(112.0, 1.05 * max(drawn_uses)))
    axes.set_xlabel("use of the limit in %")
