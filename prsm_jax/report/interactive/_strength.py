"""Curves of loads on threads, deflection, life and limits of the screw."""

from collections.abc import Mapping

import numpy as np

from ...load_sharing import ForceDeflection, LoadDistribution
from ...mechanism import Stage
from ...strength import TruncatedFatigue
from .._style import readable
from ..design_charts import lives_under, shaft_limits
from ._chart import Axis, Chart, Curve, axis_of

_SIDES = (("screw", "screw side"), ("nut", "nut side"))


def thread_load_bars(distribution: LoadDistribution) -> Chart:
    """Load of every thread, screw side above and nut side below; opposite flanks are negative."""
    found: list[tuple[str, int, np.ndarray]] = []
    for panel, (name, _) in enumerate(_SIDES):
        side = getattr(distribution, name)
        pairs = (("forward flanks", side.forward, 1), ("opposite flanks", side.reverse, -1))
        for words, values, sign in pairs:
            if values is None:
                continue
            numbers, rows = distribution.by_roller(values)
            for number, row in zip(numbers, sign * np.asarray(rows), strict=True):
                several = len(distribution.rollers) > 1
                found.append((f"{words}, roller {number}" if several else words, panel, row))
                if not several:
                    break
    _, unit = axis_of("", np.concatenate([row for *_, row in found]), "N")
    panels = tuple(Axis(f"axial load, {words}", unit.label) for _, words in _SIDES)
    curves = tuple(
        Curve(name, np.arange(1, len(row) + 1), unit(row), panel, "bar")
        for name, panel, row in found
    )
    return Chart(Axis("thread, from the end where the screw's force enters"), panels, curves)


def deflection_curves(curves: Mapping[str, ForceDeflection]) -> Chart:
    """Deflection and tangent stiffness over the axial load."""
    every = {
        name: [np.asarray(getattr(one, name)) for one in curves.values()]
        for name in ("load", "deflection", "tangent_stiffness")
    }
    x, force = axis_of("axial load", np.concatenate(every["load"]), "N")
    travel, length = axis_of("deflection of the nut", np.concatenate(every["deflection"]), "m")
    slope, stiffness = axis_of("stiffness", np.concatenate(every["tangent_stiffness"]), "N/m")
    drawn: list[Curve] = []
    for label, one in curves.items():
        order = np.argsort(np.asarray(one.load), kind="stable")
        load = force(np.asarray(one.load)[order])
        drawn.append(Curve(label, load, length(np.asarray(one.deflection)[order])))
        drawn.append(Curve(label, load, stiffness(np.asarray(one.tangent_stiffness)[order]), 1))
    return Chart(x, (travel, slope), tuple(drawn))


def life_curve(
    capacity: float, static_capacity: float | None = None, fatigue: TruncatedFatigue | None = None
) -> Chart:
    """Basic rating life over the load on one flank, up to the larger capacity."""
    highest = max(capacity, static_capacity or 0.0)
    forces = np.geomspace(capacity / 50, highest, 60)
    x, unit = axis_of("load", forces, "N")
    x = Axis(x.name, x.unit, log=True)
    lives = lives_under(forces, capacity, fatigue)
    curve = Curve("basic rating life", unit(forces), lives)
    return Chart(x, (Axis("basic rating life", "turns", log=True),), (curve,))


def shaft_limit_curves(stage: Stage) -> Chart:
    """Buckling load over the length of the screw by end conditions, and the permissible speed.

    The speed is left out where it does not depend on the length.
    """
    lengths, limits = shaft_limits(stage)
    x, length = axis_of("length of the screw", lengths, "m", log=True)
    loads, force = axis_of("buckling load", [load for load, _ in limits.values()], "N", log=True)
    known = [speed for _, speed in limits.values() if speed is not None]
    panels, rpm = (loads,), None
    if known:
        speeds, rpm = axis_of("permissible speed", known, "rad/s", log=True)
        panels = loads, speeds
    curves: list[Curve] = []
    for ends, (load, speed) in limits.items():
        name = readable(ends).replace(" ", "–")
        curves.append(Curve(name, length(lengths), force(load)))
        if speed is not None and rpm is not None:
            curves.append(Curve(name, length(lengths), rpm(speed), 1))
    return Chart(x, panels, tuple(curves))
