"""Frequencies, elasticities and the course of an optimisation."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...text import display_unit
from ...vibration import Modes
from .._parts import component_words
from .._style import readable
from ..vibration_charts import elastic_modes
from ._chart import Axis, Chart, Curve


def frequency_bars(modes: Mapping[str, Modes]) -> Chart:
    """Distinct natural frequencies by family, one bar for each design."""
    designs = {label: elastic_modes(one)[0] for label, one in modes.items()}
    keys = list(dict.fromkeys(key for one in designs.values() for key in one))
    words = tuple(
        f"{family} {number}{_times(designs, (family, number))}" for family, number in keys
    )
    gap = (float("nan"), 0)
    curves = tuple(
        Curve(label, np.arange(len(keys)), [one.get(key, gap)[0] for key in keys], kind="bar")
        for label, one in designs.items()
    )
    return Chart(Axis("mode", words=words), (Axis("natural frequency", "Hz", log=True),), curves)


def _times(designs: Mapping[str, Mapping[Any, tuple[float, int]]], key: Any) -> str:
    """The multiplicity of a repeated frequency: " ×2", or " ×1, ×2" if designs differ."""
    found = dict.fromkeys(one[key][1] for one in designs.values() if key in one)
    return f" {', '.join(f'×{times}' for times in found)}" if max(found) > 1 else ""


def elasticity_bars(
    quantities: Sequence[str], parameters: Sequence[str], elasticity: ArrayLike
) -> Chart:
    """Elasticities by quantity, one bar for each parameter; one that is not defined is a gap."""
    values = np.asarray(elasticity, dtype=float)
    places = np.arange(len(quantities))
    curves = tuple(
        Curve(readable(name), places, values[:, column], kind="bar")
        for column, name in enumerate(parameters)
    )
    axis = Axis("elasticity", "% per %")
    return Chart(Axis("quantity", words=tuple(map(component_words, quantities))), (axis,), curves)


def objective_curve(history: Sequence[float | int], objective: str, unit: str) -> Chart:
    """The objective after each iteration."""
    numbers = np.asarray(history, dtype=float)
    shown = display_unit(unit, numbers.tolist(), objective)
    values = shown(numbers)
    curve = Curve(readable(objective), np.arange(len(values)), values)
    return Chart(Axis("iteration"), (Axis(readable(objective), shown.label),), (curve,))
