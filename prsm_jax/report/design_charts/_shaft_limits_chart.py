"""Buckling load and permissible speed of a screw over its length, as in catalogues."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ...fields import Scalar
from ...mechanism import END_CONDITIONS, ScrewShaft, Stage, material_of
from ...programs import one_program_where_possible
from ...strength import buckling_load, loaded_length, permissible_speed, unsupported_length
from ...text import DisplayUnit, display_unit, in_unit, show
from .._parts import WHITE, aside, legend_below, plain_ticks
from .._style import INK, MUTED, SERIES, Axes, Figure, drawn, page_figure, readable

_SAMPLES = 120
_DASHES = ("-", (0, (6, 2)), (0, (3, 1.5)), (0, (1, 1.2)))


@one_program_where_possible
def _curves(stage: Stage, lengths):
    load = jax.vmap(lambda length: buckling_load(stage, length))(lengths)
    if not _has_critical_speed(stage):
        return load, None
    return load, jax.vmap(lambda length: permissible_speed(stage, length))(lengths)


def _has_critical_speed(stage: Stage) -> bool:
    """Whether the permissible speed depends on the length: the screw turns, of a known density."""
    turns = stage.thread.family.turning == "screw"
    return turns and material_of(stage, "screw").density is not None


def _shaft(stage: Stage) -> ScrewShaft:
    assert stage.strength is not None
    assert stage.strength.shaft is not None
    return stage.strength.shaft


def _with_ends(stage: Stage, end_conditions: str) -> Stage:
    shaft = dataclasses.replace(_shaft(stage), end_conditions=end_conditions)
    return eqx.tree_at(lambda s: s.strength.shaft, stage, shaft)


def shaft_limits(
    stage: Stage,
) -> tuple[np.ndarray, dict[str, tuple[np.ndarray, np.ndarray | None]]]:
    """Lengths of a screw [m], and by end conditions its buckling load [N] and speed [rad/s].

    The speed is `None` where it does not depend on the length: the nut turns, or the screw's
    density is not given.
    """
    own = float(loaded_length(stage)), float(unsupported_length(stage))
    lengths = np.geomspace(min(own) / 3, max(own) * 6, _SAMPLES)
    limits: dict[str, tuple[np.ndarray, np.ndarray | None]] = {}
    for ends in END_CONDITIONS:
        load, speed = _curves(_with_ends(stage, ends), jnp.asarray(lengths))
        limits[ends] = np.asarray(load), None if speed is None else np.asarray(speed)
    return lengths, limits


@drawn
def shaft_limits_chart(
    stage: Stage,
    load: Scalar | float | None = None,
    speed: Scalar | float | None = None,
) -> Figure:
    """Draw the limits of a screw over its unsupported length, for all end conditions.

    On the left the buckling load (Euler; Johnson where short, if a yield strength is given), on the
    right the permissible speed (a share of the critical speed, or the DN limit) if the screw turns
    and its density is known; the end conditions of the file are drawn thick.

    **Arguments:**

    - `stage`: the stage, with `[stage.strength.shaft]`.
    - `load`, `speed`: the demand at the length of the file, drawn as a point [N, rad/s].

    **Returns:** a matplotlib figure; lengths in mm, loads in kN, speeds in rpm.

    **Raises:** `MissingDataError` where the stage lacks data; `MissingExtraError` without
    matplotlib.
    """
    own = float(loaded_length(stage)), float(unsupported_length(stage))
    lengths, limits = shaft_limits(stage)
    millimetres, kilonewtons = DisplayUnit("mm", 1e3), DisplayUnit("kN", 1e-3)
    rpm = display_unit("rad/s")
    figure = page_figure(92)
    panels = figure.subplots(1, 2 if _has_critical_speed(stage) else 1, squeeze=False)[0]
    for index, (ends, curves) in enumerate(limits.items()):
        chosen = ends == _shaft(stage).end_conditions
        # Without a speed there is one panel, that of the load.
        for axes, values, unit in zip(panels, curves, (kilonewtons, rpm), strict=False):
            axes.loglog(
                millimetres(lengths),
                unit(values),
                color=SERIES[index],
                linestyle=_DASHES[index],
                linewidth=2.4 if chosen else 1.1,
                label=readable(ends).replace(" ", "–") + (" (as given)" if chosen else ""),
            )
    points = ((load, kilonewtons, "largest load"), (speed, rpm, "largest speed"))
    for axes, length, (value, unit, words) in zip(panels, own, points, strict=False):
        if value is not None and abs(float(value)) > 0:
            _demand(axes, millimetres(length), abs(float(value)), unit, words)
        axes.grid(which="major")
        _plain_numbers(axes)
    panels[0].set_xlabel("length under load in mm")
    panels[0].set_ylabel("buckling load in kN")
    panels[0].set_title("Buckling")
    if len(panels) == 2:
        _dn_limit(panels[1], stage, millimetres(lengths[0]), rpm)
        panels[1].set_xlabel("unsupported length in mm")
        panels[1].set_ylabel("permissible speed in rpm")
        panels[1].set_title("Speed")
    legend_below(figure, panels[0].get_legend_handles_labels()[0], 4)
    return figure


def _dn_limit(axes: Axes, stage: Stage, length: float, rpm: DisplayUnit) -> None:
    """Label the DN limit, which cuts the speeds off, if there is one."""
    limit = _shaft(stage).dn_limit
    if limit is None:
        return
    speed = rpm(float(limit / (2 * stage.thread.screw_radius)))
    axes.set_ylim(top=1.5 * speed)
    words = f"DN limit {show(float(limit), 'm·rad/s')}"
    aside(axes, words, (length, speed), (0, 5), bbox={**WHITE, "pad": 0.5})


def _demand(axes: Axes, length: float, value: float, unit: DisplayUnit, words: str) -> None:
    axes.axvline(length, color=MUTED, linewidth=0.8, linestyle=":")
    axes.plot(length, unit(value), "o", color=INK, markersize=4.5)
    # Room for the words below a point that is the lowest of the panel.
    axes.set_ylim(bottom=min(axes.get_ylim()[0], unit(value) / 3))
    words += f"\n{in_unit(value, unit)}"
    aside(axes, words, (length, unit(value)), (-6, -3), va="top")


def _plain_numbers(axes: Axes) -> None:
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        plain_ticks(axis, subs=(1.0, 2.0, 5.0) if high < 1000 * low else (1.0,))
