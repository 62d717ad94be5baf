"""Charts for plotly's JavaScript library, which a page contains once."""

import html
import json
from typing import Any

from .._style import FAINT, INK, MUTED, SERIES
from ._chart import Axis, Chart, Curve, numbers

#: Height of a panel, and of titles and axis [pixels].
_PANEL, _EXTRA = 210, 90
#: Width at the right for the tools of a chart, under each other [pixels].
_TOOLS = 45
#: Share of the height between two panels.
_GAP = 0.07
_HOVER = "%{{x{x}}}{x_unit}<br>%{{y:.6~g}}{y_unit}<extra>{name}</extra>"


def plotly_library() -> str | None:
    """The JavaScript of plotly; `None` if plotly is not installed."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        return None
    return str(get_plotlyjs())


def script_text(value: Any) -> str:
    """JSON that can stand in a script element of a page: it cannot end that element."""
    text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def plotly_figure(chart: Chart) -> dict[str, Any]:
    """A chart as traces and layout; names are escaped, since plotly reads some HTML in them."""
    layout: dict[str, Any] = {
        "height": _PANEL * len(chart.panels) + _EXTRA,
        "margin": {"l": 75, "r": _TOOLS, "t": 30, "b": 50},
        # Across the top they would cover the legend.
        "modebar": {"orientation": "v"},
        "font": {"size": 12, "color": INK},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "hovermode": "closest",
        "barmode": "stack" if chart.stacked else "group",
        "showlegend": len({one.name for one in chart.curves}) > 1,
        "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom"},
        "xaxis": {**_axis(chart.x), "anchor": _suffixed("y", len(chart.panels) - 1)},
    }
    count = len(chart.panels)
    each = (1 - _GAP * (count - 1)) / count
    for place, panel in enumerate(chart.panels):
        top = 1 - place * (each + _GAP)
        layout[_suffixed("yaxis", place)] = {**_axis(panel), "domain": [max(top - each, 0.0), top]}
    shown: set[str] = set()
    data = []
    for curve in chart.curves:
        data.append(_trace(chart, curve, curve.name not in shown))
        shown.add(curve.name)
    # One colour for each name, in all panels.
    colours = {
        name: SERIES[i % len(SERIES)]
        for i, name in enumerate(dict.fromkeys(one.name for one in chart.curves))
    }
    for trace, curve in zip(data, chart.curves, strict=True):
        trace["marker" if curve.kind == "bar" else "line"] = {"color": colours[curve.name]}
    return {"data": data, "layout": layout}


def _suffixed(name: str, place: int) -> str:
    return name if place == 0 else f"{name}{place + 1}"


def _axis(axis: Axis) -> dict[str, Any]:
    style: dict[str, Any] = {
        "title": {"text": html.escape(axis.label)},
        "gridcolor": FAINT,
        "linecolor": MUTED,
        "zeroline": False,
        "automargin": True,
    }
    if axis.log:
        style["type"] = "log"
    if axis.words:
        words = [html.escape(one) for one in axis.words]
        style |= {"tickmode": "array", "tickvals": list(range(len(words))), "ticktext": words}
    return style


def _trace(chart: Chart, curve: Curve, first: bool) -> dict[str, Any]:
    name, panel = html.escape(curve.name), chart.panels[curve.panel]
    hover = _HOVER.format(
        x="" if chart.x.words else ":.6~g",
        x_unit=_unit(chart.x),
        y_unit=_unit(panel),
        # A brace would be read as a field.
        name=name.replace("{", "(").replace("}", ")"),
    )
    trace: dict[str, Any] = {
        "type": "bar" if curve.kind == "bar" else "scatter",
        "name": name,
        "legendgroup": name,
        "showlegend": first,
        "x": numbers(curve.x),
        "y": numbers(curve.y),
        "yaxis": _suffixed("y", curve.panel),
        "hovertemplate": hover,
    }
    if curve.kind == "line":
        trace |= {"mode": "lines", "connectgaps": False}
    return trace


def _unit(axis: Axis) -> str:
    return f" {html.escape(axis.unit)}" if axis.unit else ""
