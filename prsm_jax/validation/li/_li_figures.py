"""Figures 8 to 10 of Li et al. 2020 and 3 to 5 of Li et al. 2021."""

from collections.abc import Iterator, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from ...dynamics import Transient, ideal_carrier_ratio
from .._examples import example, scene, transient
from .._figures import Curve, Mark, Panel, PublishedFigure, figures_of

_2020, _2021 = "li2020_two_stage", "li2021_two_stage"
#: Where the curves of Li et al. 2021 end [s].
_LAST = 0.75e-3


def _curves(runs: Sequence[Any], attribute: str, stages: Sequence[int]) -> tuple[Curve, ...]:
    """One curve for each case and stage; stage 0 is the whole mechanism."""
    return tuple(
        Curve(
            np.asarray(getattr(run, attribute) if k == 0 else getattr(run, attribute)[k - 1]),
            k,
            case,
        )
        for case, run in enumerate(runs)
        for k in stages
    )


def _ratios(runs: Sequence[Any], marks: tuple[Mark, ...] = ()) -> Panel:
    curves = _curves(runs, "carrier_ratio", (1, 2))
    return Panel("carrier speed over screw speed", "ζ_PS", "1", curves, marks)


def _efficiency(runs: Sequence[Any], *marks: Mark) -> Panel:
    return Panel("efficiency", "η", "1", _curves(runs, "efficiency", (0,)), marks)


def _force(runs: Sequence[Any], name: str, symbol: str, attribute: str, stages) -> Panel:
    return Panel(name, symbol, "N", _curves(runs, attribute, stages))


def _axial(runs: Sequence[Any]) -> Panel:
    name = "axial contact force of one roller"
    return _force(runs, name, "F_Srz", "screw_roller_axial_force", (1, 2))


def _spline(runs: Sequence[Any]) -> Panel:
    return _force(runs, "spline friction", "f_S2", "spline_friction", (2,))


def _friction_figure(number: int, symbol: str, body: str, path: str, values) -> PublishedFigure:
    runs = [transient(_2020, (path, value)) for value in values]
    return PublishedFigure(
        "li2020",
        number,
        f"Friction between {body}",
        np.asarray(runs[0].time),
        (
            _ratios(runs),
            _efficiency(runs, Mark("0.60", level=0.60), Mark("0.87", level=0.87)),
            _force(runs, "ring gear on roller", "F_RG", "ring_gear_force", (1, 2)),
            _force(runs, "carrier on roller", "F_RP", "carrier_force", (1, 2)),
        ),
        tuple(f"{symbol} = {value:g}" for value in values),
    )


@figures_of("li2020")
def li2020() -> Iterator[PublishedFigure]:
    """Figures 8, 9 and 10."""
    name = "li2020_single_stage_viscous"
    _, run = scene(name)
    ideal = float(ideal_carrier_ratio(example(name).stages[0].thread))
    panel = Panel(
        "carrier speed over screw speed",
        "ζ_PS1",
        "1",
        _curves([run], "carrier_ratio", (1,)),
        (Mark(f"rolling without slip {ideal:g}", level=ideal, printed=False),),
    )
    caption = "One stage with viscous friction"
    yield PublishedFigure("li2020", 8, caption, np.asarray(run.time), (panel,))
    yield _friction_figure(9, "µ_SS", "screws (spline)", "spline.coefficient", (0.10, 0.15, 0.20))
    values = (0.005, 0.055, 0.105)
    yield _friction_figure(
        10, "µ_NS", "nut and screw (thrust bearing)", "thrust_bearing.coefficient", values
    )


def _cut(run: Transient) -> SimpleNamespace:
    """The samples that the figures of Li et al. 2021 show."""
    count = int(np.searchsorted(run.time, _LAST * (1 + 1e-9)))
    names = (
        "time",
        "carrier_ratio",
        "efficiency",
        "stage_torque",
        "screw_roller_axial_force",
        "spline_friction",
    )
    return SimpleNamespace(**{name: np.asarray(getattr(run, name))[..., :count] for name in names})


@figures_of("li2021")
def li2021() -> Iterator[PublishedFigure]:
    """Figures 3, 4 and 5."""
    base = _cut(transient(_2021))
    settled = (Mark("0.14 ms", time=0.14e-3), Mark("0.46 ms", time=0.46e-3))
    bounds = (Mark("0.45", level=0.45), Mark("0.80", level=0.80))
    torque = Panel("torque on the screws", "M_S", "N·m", _curves([base], "stage_torque", (1, 2)))
    yield PublishedFigure(
        "li2021",
        3,
        "Base case",
        np.asarray(base.time),
        (
            _ratios([base], settled),
            torque,
            _axial([base]),
            Panel(
                "efficiency and spline friction",
                "η",
                "1",
                _curves([base], "efficiency", (0,)),
                bounds,
                right=_spline([base]),
            ),
        ),
    )
    cases = ((0.1, 0.2), (0.2, 0.2), (0.1, 0.3))
    runs = [
        _cut(transient(_2021, ("thread.coefficient", a), ("spline.coefficient", b)))
        for a, b in cases
    ]
    yield PublishedFigure(
        "li2021",
        4,
        "Friction of threads and spline",
        np.asarray(base.time),
        (_ratios(runs), _axial(runs), _efficiency(runs), _spline(runs)),
        tuple(f"µ_SR = {a:g}, µ_SS = {b:g}" for a, b in cases),
    )
    pitches = ((1, 3), (2, 2), (3, 1))
    runs = [
        _cut(transient(_2021, ("stage.1.lead", 5e-3 * a), ("stage.2.lead", 5e-3 * b)))
        for a, b in pitches
    ]
    yield PublishedFigure(
        "li2021",
        5,
        "Pitches of constant sum",
        np.asarray(base.time),
        (_ratios(runs), _axial(runs), _efficiency(runs), _spline(runs)),
        tuple(f"pitches {a} and {b} mm" for a, b in pitches),
    )
