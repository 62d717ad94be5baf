"""Curves of motion over time, and losses."""

from collections.abc import Mapping

import numpy as np

from ...dynamics import SteadyState, Transient
from ...mechanism import Mechanism
from .._style import readable
from ..motion_charts import histories, is_constant, power_history
from ._chart import Axis, Chart, Curve, axis_of


def _of_stages(name: str, count: int) -> list[str]:
    return [name] if count == 1 else [f"stage {i}" for i in range(1, count + 1)]


def transient_curves(run: Transient) -> Chart:
    """Efficiency, carrier ratio of each stage and drive torque over time."""
    time, clock = axis_of("time", run.time, "s")
    ratios = np.asarray(run.carrier_ratio)
    torque, shown = axis_of("drive torque", run.drive_torque, "N·m")
    x = clock(np.asarray(run.time))
    curves = [Curve("efficiency", x, 100 * np.asarray(run.efficiency))]
    names = _of_stages("carrier ratio", len(ratios))
    curves += [Curve(n, x, one, 1) for n, one in zip(names, ratios, strict=True)]
    curves.append(Curve("drive torque", x, shown(np.asarray(run.drive_torque)), 2))
    return Chart(time, (Axis("efficiency", "%"), Axis("carrier ratio"), torque), tuple(curves))


def history_curves(mechanism: Mechanism, run: Transient) -> Chart:
    """Every history of a transient that is not constant, as `history_chart` draws them."""
    time, clock = axis_of("time", run.time, "s")
    x = clock(np.asarray(run.time))
    shown = [one for one in histories(mechanism, run) if not is_constant(one)]
    curves = [
        Curve(name, x, one.unit(curve), panel)
        for panel, one in enumerate(shown)
        for name, curve in zip(
            _of_stages(one.name, len(one.curves)), np.asarray(one.curves), strict=True
        )
    ]
    panels = tuple(Axis(one.name, one.unit.label) for one in shown)
    return Chart(time, panels, tuple(curves))


def power_curves(mechanism: Mechanism, run: Transient) -> Chart:
    """Powers over time: motor, load, masses and bristles into the mechanism; losses dissipated."""
    powers = power_history(mechanism, run)
    into = {"motor": powers.motor, "load": powers.load, "moving masses": powers.kinetic}
    if np.any(powers.bristles):
        into["bristles"] = powers.bristles
    lost = {f"loss: {readable(name)}": one for name, one in powers.losses.items()}
    time, clock = axis_of("time", powers.time, "s")
    every = np.concatenate([np.ravel(one) for one in (*into.values(), *lost.values())])
    axis, unit = axis_of("power into the mechanism", every, "W")
    loss_axis = Axis("power lost", axis.unit)
    x = clock(powers.time)
    curves = [Curve(name, x, unit(one)) for name, one in into.items()]
    curves += [Curve(name, x, unit(one), 1) for name, one in lost.items()]
    panels = (axis, loss_axis) if lost else (axis,)
    return Chart(time, panels, tuple(curves))


def loss_bars(states: Mapping[str, SteadyState]) -> Chart:
    """Losses by name, bars of several states beside each other."""
    names = tuple(dict.fromkeys(name for state in states.values() for name in state.losses))
    every = [float(state.losses.get(n, 0.0)) for state in states.values() for n in names]
    axis, unit = axis_of("power lost", every, "W")
    places = np.arange(len(names))
    curves = tuple(
        Curve(label, places, [unit(float(s.losses.get(n, 0.0))) for n in names], kind="bar")
        for label, s in states.items()
    )
    return Chart(Axis("loss", words=tuple(map(readable, names))), (axis,), curves)
