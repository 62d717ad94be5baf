"""The chart of each class of results; the room above that draws them adds them here."""

import importlib
from collections.abc import Callable
from typing import Any, TypeVar

_Chart = TypeVar("_Chart", bound=Callable[..., Any])
_charts: dict[type, Callable[..., Any]] = {}
#: The room that draws. It knows the results and this room knows neither, so it is not imported but
#: found by its name, as an entry point is, when the first chart is wanted.
_ROOM = "report"


def chart_for(*kinds: type) -> Callable[[_Chart], _Chart]:
    """Decorator: `plot` of results of these classes calls the function.

    **Arguments:**

    - `kinds`: classes of results. The function takes a result and options, and returns a figure.
    """

    def add(function: _Chart) -> _Chart:
        _charts.update(dict.fromkeys(kinds, function))
        return function

    return add


def draw(result: Any, options: dict[str, Any]) -> Any:
    """The figure of a result.

    **Raises:** `ValueError` for a batch of designs, and for a result without a chart.
    """
    importlib.import_module(f"{__name__.partition('.')[0]}.{_ROOM}")
    chart = next((_charts[kind] for kind in type(result).__mro__ if kind in _charts), None)
    name = type(result).__name__
    if chart is None:
        known = ", ".join(sorted(kind.__name__ for kind in _charts))
        raise ValueError(f"{name} has no chart of its own; these results have one: {known}")
    shape = getattr(result, "batch_shape", ())
    if shape:
        raise ValueError(
            f"this {name} is a batch of shape {shape}, and a chart shows one design: take one with "
            "jax.tree.map(lambda a: a[0], result)"
        )
    return chart(result, **options)
