"""Pictures of motion, power and losses: curves, areas, bands and words read back in SI."""

import dataclasses
import math

import jax.numpy as jnp
import numpy as np
import pytest
import reading_scenes as made
import scenes
from expectations import reads
from reading_artists import box_of, vertices_of
from reading_figures import Chart, handles
from reading_units import assert_reads, numbers, to_si

from prsm_jax.report import (
    force_orbit,
    history_chart,
    loss_chart,
    power_flow_chart,
    power_history_chart,
    published_figure,
    steady_flow,
    transient_chart,
)
from prsm_jax.report.motion_charts._power_flow import PowerFlow
from prsm_jax.validation._figures import Curve, Mark, Panel, PublishedFigure
from tests.present import present

#: Of the example of two stages, by hand: two leads of 10 mm for each turn.
_TRAVEL = 2 * 10e-3 / (2 * math.pi)


@pytest.fixture(scope="module")
def mechanism():
    return scenes.example("li2021_two_stage")


def _integral(time, rate):
    return np.concatenate([[0], np.cumsum(np.diff(time) * (rate[1:] + rate[:-1]) / 2)])


def _shaded(chart, axes, phases):
    boxes = [p for p in axes.patches if p.get_height() == 1 and p.get_y() == 0]
    found = [tuple(chart.si(axes, "x", [p.get_x(), p.get_x() + p.get_width()], "s")) for p in boxes]
    assert [pytest.approx(pair) for pair in phases] == found
    chart.take(*boxes)


@reads("chart", "transient_chart")
def test_transient():
    run = made.transient()
    chart = Chart(transient_chart(run))
    upper, middle, lower = chart.axes
    for axes, curves, unit in (
        (upper, [run.efficiency], "1"),
        (middle, list(run.carrier_ratio), ""),
        (lower, [run.drive_torque], "N·m"),
    ):
        for curve in curves:
            chart.curve(axes, chart.lines(axes)[0], run.time, curve, ("s", unit))
    # Within one per cent of the last value from here on.
    settled = made.time_within_one_per_cent(run)
    for axes in (upper, middle, lower):
        chart.level(axes, settled, "s", "x")
    words = chart.text("dashed: carriers within")
    assert_reads(words, (0.01, "1", "whole"), (settled, "s"))
    assert handles(chart.figure) == ["stage 1", "stage 2"]
    chart.text("stage 1")
    chart.text("stage 2")
    assert middle.get_ylabel() == "carrier ratio ω/Ω"
    chart.finish()


def test_a_transient_on_coarse_samples():
    """No dashed line at an interpolated place, and a bound: samples are 25 ms apart."""
    run = made.transient()
    run = dataclasses.replace(
        run, time=run.time * 1e3, carrier_ratio=jnp.where(run.time > 0, 0.37, jnp.zeros((2, 1)))
    )
    chart = Chart(transient_chart(run))
    words = chart.text("carriers within")
    assert (
        words == "carriers within 1 % of their last speed after less than 25.0\u202fms (1 sample)"
    )
    assert [len(axes.lines) for axes in chart.axes] == [1, 2, 1]


_HISTORIES = {
    "screw speed": "rad/s",
    "drive torque": "N·m",
    "travel of the last nut": "m",
    "load": "N",
    "carrier ratio ω/Ω": "",
    "contact force on a roller": "N",
    "efficiency": "1",
    "ring gear on roller": "N",
    "spline friction": "N",
    "carrier on roller": "N",
}


def _expected_histories(mechanism, run):
    time, speed = np.asarray(run.time), np.asarray(run.screw_speed)
    assert math.isclose(sum(float(s.thread.lead) for s in mechanism.stages), 2 * math.pi * _TRAVEL)
    travel = _TRAVEL * _integral(time, speed) if run.position is None else run.position
    power = np.maximum(
        np.abs(np.asarray(run.drive_torque) * speed), np.abs(run.load * speed * _TRAVEL)
    )
    return {
        "screw speed": [speed],
        "drive torque": [run.drive_torque],
        "travel of the last nut": [travel],
        "load": [run.load],
        "carrier ratio ω/Ω": list(
            np.where(np.abs(speed) <= 0.01 * np.abs(speed).max(), np.nan, run.carrier_ratio)
        ),
        "contact force on a roller": list(run.contact_force),
        # Where it is one: not near standstill, and within 0 and 1.
        "efficiency": [
            np.where(
                (power > 0.02 * power.max()) & (run.efficiency >= 0) & (run.efficiency <= 1),
                run.efficiency,
                np.nan,
            )
        ],
        "ring gear on roller": list(run.ring_gear_force),
        "spline friction": list(run.spline_friction),
        "carrier on roller": list(run.carrier_force),
    }


@reads("chart", "history_chart")
@pytest.mark.parametrize("to_and_fro", [False, True])
def test_histories(mechanism, to_and_fro):
    run = made.transient(to_and_fro=to_and_fro)
    chart = Chart(history_chart(mechanism, run))
    expected = _expected_histories(mechanism, run)
    named = {axes.get_title("left"): axes for axes in chart.axes}
    constant = [] if to_and_fro else ["screw speed", "load"]
    assert set(named) == set(expected) - set(constant)
    for name, axes in named.items():
        for curve in expected[name]:
            chart.curve(axes, chart.lines(axes)[0], run.time, curve, ("s", _HISTORIES[name]))
        _shaded(chart, axes, [(6e-4, 9e-4)] if to_and_fro else [])
        # No curve lies on the frame.
        for way, ends in (("x", axes.get_xlim()), ("y", axes.get_ylim())):
            inside = [getattr(line, f"get_{way}data")() for line in axes.lines]
            low, high = np.nanmin(inside), np.nanmax(inside)
            apart = 0.01 * (ends[1] - ends[0])
            assert ends[0] + apart < low <= high < ends[1] - apart
    # The last of an odd number has the whole width.
    widths = [axes.get_position().width for axes in chart.axes]
    assert (widths[-1] > 1.8 * widths[0]) == (len(widths) % 2 == 1)
    heading = chart.text("Time histories")
    assert_reads(heading, *((100.0, "rad/s"), (7e3, "N")) if constant else ())
    sticks = ["sticks"] if to_and_fro else []
    assert handles(chart.figure) == ["stage 1", "stage 2", *sticks]
    chart.text("stage 1")
    chart.text("stage 2")
    chart.finish()


@reads("chart", "force_orbit")
def test_force_orbits(mechanism):
    run, forces = made.transient(), made.body_forces()
    chart = Chart(force_orbit(mechanism, run, forces))
    assert len(chart.axes) == 4
    # Both ends of a roller together: twice the force of one gear and of one pin.
    left = [forces.screw_normal_on_roller, forces.nut_on_roller]
    right = [forces.screw_friction_on_roller, 2 * forces.ring_gear_on_roller]
    right.append(2 * forces.pin_on_roller)
    for index, axes in enumerate(chart.axes):
        stage, others = divmod(index, 2)
        for way in ("x", "y"):
            chart.level(axes, 0.0, "N", way)
        plane = (0, 1) if others else (0, 2)
        names = [axes.get_xlabel().split()[0], axes.get_ylabel().split()[0]]
        assert names == [("radial", "tangential", "axial")[k] for k in plane]
        for force in right if others else left:
            x, y = np.asarray(force)[stage][:, plane].T
            path, start, end = chart.lines(axes)[:3]
            words = chart.text(str(path.get_label()).partition(" (")[0], place=axes)
            size = np.hypot(x, y).max()
            assert_reads(words.rpartition("(")[2], (size, "N"))
            chart.curve(axes, path, x, y, ("N", "N"))
            chart.curve(axes, start, x[0], y[0], ("N", "N"))
            chart.curve(axes, end, x[-1], y[-1], ("N", "N"))
            assert start.get_markerfacecolor() == "white"
        assert axes.get_title("left").endswith(f"stage {stage + 1}")
        chart.text("", within=f"stage {stage + 1}", place=axes)
    names = [words.partition(" (")[0] for words in handles(chart.figure)[2:7]]
    assert names == [
        "screw, normal", "nut", "screw, friction", "ring gear, both ends", "carrier pins, both ends"
    ]  # fmt: skip
    chart.says("at ", (0.0, "s"))
    chart.says("at ", (2e-3, "s"))
    chart.finish()


@reads("chart", "loss_chart")
def test_losses():
    states = {"before": made.steady(), "after": made.steady(4012.0), "locked": made.steady(0, True)}
    chart = Chart(loss_chart(states))
    above, below = chart.axes
    assert chart.ticks(above) == chart.ticks(below) == list(states)
    for row, state in enumerate(states.values()):
        lost = {name: float(power) for name, power in state.losses.items()}
        useful = max(float(state.output_power), 0.0)
        source, start = useful + sum(lost.values()), 0.0
        assert all(box_of(p).get_y() == pytest.approx(row - 0.3) for p in [above.patches[4 * row]])
        chart.bars(above, useful / source, "1", "x")
        chart.bars(
            above,
            [power / source for power in lost.values()],
            "1",
            "x",
            (useful + np.cumsum([0, *lost.values()])[:-1]) / source,
        )
        for power in lost.values():
            chart.bars(below, power, "W", "x", start)
            start += power
        if useful > 0.25 * source:
            chart.says("output ", (useful, "W"), (useful / source, "1"), place=above)
        chart.says("  input ", (source, "W"), place=above)
        chart.says("  ", (sum(lost.values()), "W"), place=below)
    assert handles(chart.figure) == ["output", "thread sliding", "spin", "drag"]
    chart.finish()


@reads("chart", "power_flow_chart")
@pytest.mark.parametrize("unit", ["W", "J", "mJ"])
def test_power_flows(unit):
    if unit == "W":
        state = made.steady()
        flow = steady_flow(state)
        lost = {name: float(power) for name, power in state.losses.items()}
        assert flow.sources == {"motor": pytest.approx(float(state.input_power))}
        assert flow.sinks == {"load": pytest.approx(float(state.output_power)), **lost}
    else:
        scale = 1.0 if unit == "J" else 1e-4
        flow = PowerFlow(
            {"motor": 91.0 * scale, "load": 9.3 * scale},
            {"load": 71.3 * scale, "moving masses": 29.0 * scale},
            "J",
        )
    chart = Chart(power_flow_chart(flow))
    chart.text("Power flow")
    (axes,) = chart.axes
    total = sum(flow.sources.values())
    # One millimetre of page for so much power.
    height = 46.0 / total
    words = {
        ("motor", True): "motor",
        ("load", True): "load drives",
        ("load", False): "work on the load",
        ("moving masses", False): "into moving masses",
    }
    (trunk,) = axes.collections
    y = vertices_of(trunk.get_paths()[0])[:, 1]
    assert np.ptp(y) == pytest.approx(46.0)
    chart.take(trunk)
    for ends, source in ((flow.sources, True), (flow.sinks, False)):
        for name, value in ends.items():
            block = next(
                p for p in axes.patches if p.get_label() == name
                and (box_of(p).get_x() < 60) == source and hasattr(p, "get_height")
            )  # fmt: skip
            assert box_of(block).get_height() == pytest.approx(height * value)
            chart.take(block)
            label = words.get((name, source), name.replace("_", " "))
            expected = [(value, flow.unit)]
            if value != total:
                expected.append((value / total, "1"))
            chart.says(f"{label}\n", *expected)
    chart.says("", (total, flow.unit))
    # Bands are as high as their blocks.
    bands = [p for p in axes.patches if not hasattr(p, "get_height")]
    sizes = [np.ptp(vertices_of(p.get_path())[[0, -2], 1]) for p in bands]
    every = [*flow.sources.values(), *flow.sinks.values()]
    assert sorted(sizes) == pytest.approx(sorted(height * v for v in every))
    chart.take(*bands)
    chart.finish()


@reads("chart", "power_history_chart")
@pytest.mark.parametrize("to_and_fro", [False, True])
def test_powers(mechanism, to_and_fro):
    run = made.transient(to_and_fro=to_and_fro)
    chart = Chart(power_history_chart(mechanism, run))
    (axes,) = chart.axes
    _shaded(chart, axes, [(6e-4, 9e-4)] if to_and_fro else [])
    chart.level(axes, 0.0, "W")
    speed = np.asarray(run.screw_speed)
    motor = np.asarray(run.drive_torque) * speed
    load = -np.asarray(run.load) * _TRAVEL * speed
    losses = {name: np.asarray(power) for name, power in run.losses.items()}
    masses = sum(losses.values()) - motor - load
    sinks = {name.replace("_", " "): power for name, power in losses.items()}
    sinks |= {"back to the motor": -motor, "work on the load": -load, "into moving masses": -masses}
    sources = {"motor": motor, "load drives": load, "from moving masses": masses}
    areas = [*axes.collections]
    time = np.asarray(run.time)
    for sign, parts in ((1, sinks), (-1, sources)):
        base = np.zeros_like(time)
        for name, power in parts.items():
            power = np.maximum(power, 0.0)
            if not power.max() > 0:
                continue
            area = next(a for a in areas if a.get_label() == name)
            top = base + sign * power
            x = chart.si(axes, "x", vertices_of(area.get_paths()[0])[:, 0], "s")
            y = chart.si(axes, "y", vertices_of(area.get_paths()[0])[:, 1], "W")
            edges = [np.interp(x, time, edge) for edge in (base, top)]
            off = np.minimum(np.abs(y - edges[0]), np.abs(y - edges[1]))
            assert off.max() <= 1e-9 * np.abs(motor).max()
            assert np.ptp(y) > 0
            assert np.abs(y).max() == pytest.approx(np.abs(top).max())
            chart.take(area)
            base = top
    assert set(handles(chart.figure)) == {a.get_label() for a in areas}
    chart.finish()


@reads("chart", "published_figure")
def test_published_figures():
    time = np.linspace(0, 0.75e-3, 31)
    rise = 1 - np.exp(-time / 1e-4)
    force = Panel(
        "forces",
        "F_RG",
        "N",
        (Curve(3.0 + 40 * rise, stage=1), Curve(50 * rise, stage=2)),
        (Mark("43", level=43.0), Mark("0.2 ms", time=0.2e-3)),
    )
    torque = Panel("torque", "T", "N·m", (Curve(7 - 2 * rise),))
    share = Panel("efficiency", "η", "1", (Curve(0.4 + 0.4 * rise),), right=torque)
    figure = PublishedFigure("li2021", 3, "Made up", time, (force, share), ("",))
    chart = Chart(published_figure(figure))
    axes = {"forces": chart.axes[0], "efficiency": chart.axes[1], "torque": chart.axes[2]}
    for panel in (force, share, torque):
        for curve in panel.curves:
            line = chart.lines(axes[panel.name])[0]
            unit = "" if panel.unit == "1" else panel.unit
            time_si = to_si(line.get_xdata(), "ms")
            np.testing.assert_allclose(time_si, time)
            found = chart.si(axes[panel.name], "y", line.get_ydata(), unit)
            np.testing.assert_allclose(found, curve.y)
            chart.take(line)
    chart.level(axes["forces"], 43.0, "N")
    chart.level(axes["forces"], 0.2e-3, "s", "x")
    assert axes["forces"].get_xlabel() == "time in ms"
    mark = chart.text("43")
    assert numbers(mark)[0].value == 43
    chart.text(" 0.2 ms")
    assert chart.text("$F_") == "$F_{\\mathrm{RG}}$ in N"
    assert chart.text("", within="figure 3").startswith("Made up (")
    chart.text("stage 1")
    chart.text("stage 2")
    chart.finish()


@reads("chart", "save_motion_animation")
def test_words_of_the_motion(mechanism, monkeypatch, tmp_path):
    """Time, speed and travel over every picture, against the histories at that time."""
    from prsm_jax.report import save_motion_animation
    from prsm_jax.report.animations import _stage_animation

    run, said, figures = made.transient(to_and_fro=True), [], []
    still, indexed = _stage_animation._still, _stage_animation.indexed

    def keep(*given):
        figures.append(still(*given))
        return figures[-1]

    def listen(*given):
        said.append([text.get_text() for text in figures[-1].texts])
        return indexed(*given)

    monkeypatch.setattr(_stage_animation, "_still", keep)
    monkeypatch.setattr(_stage_animation, "indexed", listen)
    save_motion_animation(tmp_path / "motion", mechanism, run, frames=9)
    assert len(said) == 9
    time = np.asarray(run.time)
    for at, words in zip(np.linspace(0, 2e-3, 9), said, strict=True):
        speed, travel = (
            float(np.interp(at, time, present(v))) for v in (run.screw_speed, run.position)
        )
        heading = words[-1]
        found = numbers(heading)
        assert [one.label for one in found] == ["ms", "rpm", "mm"]
        for one, value, unit in zip(found, (at, speed, travel), ("s", "rad/s", "m"), strict=True):
            size = {"s": 2e-3, "rad/s": 100.0, "m": 1.3e-4}[unit]
            assert to_si(one.value, one.label) == pytest.approx(value, rel=5e-3, abs=1e-9 * size)
    turned = float(np.max(_integral(time, np.asarray(run.screw_speed))))
    (drawn,) = {words[2] for words in said}
    scale = float(drawn.split("drawn ")[1].split(" times")[0])
    # At most 20 degrees between two pictures and at least 270 in all.
    assert scale * turned <= np.radians(20) * 9
    assert drawn.endswith("travel to scale")


@reads("chart", "save_mode_animation")
def test_words_of_a_moving_mode(monkeypatch, tmp_path):
    from prsm_jax.report import save_mode_animation
    from prsm_jax.report.animations import _mode_animation

    mechanism = scenes.example("wu2022")
    modes = scenes.modal(mechanism, shapes=True)
    drawn = []
    still = _mode_animation._still

    def keep(*given):
        drawn.append(still(*given))
        return drawn[-1]

    monkeypatch.setattr(_mode_animation, "_still", keep)
    save_mode_animation(tmp_path / "mode", mechanism, modes, 8, energy=2e-3, frames=8)
    head, foot = (text.get_text() for text in drawn[0].texts)
    frequency = float(modes.frequencies[7])
    assert head.startswith("8  torsional")
    assert_reads(head.removeprefix("8  torsional"), (frequency, "Hz"))
    # A mode that holds 2 mJ: ½ (2π f)² a² for a shape of unit mass.
    amplitude = np.sqrt(2 * 2e-3) / (2 * np.pi * frequency)
    largest = amplitude * np.abs(np.asarray(modes.shapes[:, 7])).max()
    factor, energy, size = numbers(foot)
    assert to_si(energy.value, energy.label) == pytest.approx(2e-3)
    assert size.label == "µm"
    assert to_si(size.value, "µm") == pytest.approx(largest, rel=0.06)
    radius = float(mechanism.stages[0].thread.roller_radius)
    assert factor.value * largest == pytest.approx(0.75 * radius, rel=0.06)
