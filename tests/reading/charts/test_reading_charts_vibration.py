"""Pictures of vibration: frequencies, orders, responses and shapes read back in SI."""

import dataclasses
import re
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
import reading_scenes as made
import scenes
from expectations import reads
from reading_artists import box_of, x_data, y_data
from reading_figures import Chart, handles
from reading_units import assert_reads, numbers, parse, to_si

import prsm_jax as prsm
from prsm_jax.report import (
    campbell_chart,
    frequency_chart,
    frequency_loci_chart,
    mode_shapes,
    response_chart,
)
from prsm_jax.response import FrequencyResponse

_FAMILIES = ("carrier", "torsional", "transverse", "roller")


@reads("chart", "frequency_chart")
def test_frequencies():
    designs = {"before": made.modes(), "after": made.modes(1.1)}
    chart = Chart(frequency_chart(designs))
    (axes,) = chart.axes
    rows = []
    for family in _FAMILIES:
        every = [
            [(float(f), g.multiplicity) for g in m.groups if g.family == family
             for f in g.frequencies if f > 0]
            for m in designs.values()
        ]  # fmt: skip
        rows += [(f"{family} {k}", pair) for k, pair in enumerate(zip(*every, strict=True), 1)]
    assert chart.ticks(axes) == [name for name, _ in rows]
    left = axes.get_xlim()[0]
    # Which design a dot belongs to is seen by its filling, as in the legend.
    legend = [one.get_markerfacecolor() == "white" for one in axes.get_legend().legend_handles]  # pyright: ignore[reportAttributeAccessIssue]
    assert legend == [True, False]
    for index, (_, pair) in enumerate(rows):
        places = []
        for hollow, (value, times) in zip(legend, pair, strict=True):
            stem, dot = chart.lines(axes)[:2]
            chart.curve(axes, stem, [left, value], None, ("Hz", ""))
            chart.curve(axes, dot, value, None, ("Hz", ""))
            assert (dot.get_markerfacecolor() == "white") == hollow
            places.append(y_data(dot)[0])
            assert set(y_data(stem)) == {places[-1]}
            expected = [(value, "Hz")] + ([(times, "", "whole")] if times > 1 else [])
            chart.says("", *expected, within="Hz", place=axes)
        assert np.mean(places) == pytest.approx(index)
        assert places[0] < places[1]
    assert "1 rigid-body mode" in chart.text("natural frequency in Hz")
    assert handles(chart.figure) == ["before", "after"]
    chart.finish()


@reads("chart", "frequency_loci_chart")
def test_loci():
    loci = made.loci()
    chart = Chart(frequency_loci_chart(loci))
    main, enlarged = chart.axes
    every = [loci.frequencies["torsional"][:, k] for k in range(3)]
    every.append(loci.frequencies["transverse"][:, 0])
    for axes, way_units in ((main, ("rad", "Hz")), (enlarged, None)):
        if way_units is None:
            # Its labels are the units alone.
            assert enlarged.get_xlabel() == "deg"
            assert enlarged.get_ylabel() in ("Hz", "kHz")
            scale = 1e3 if enlarged.get_ylabel() == "kHz" else 1.0
            for line, expected in zip(chart.lines(axes), every, strict=True):
                np.testing.assert_allclose(np.radians(line.get_xdata()), loci.values)
                np.testing.assert_allclose(scale * np.asarray(line.get_ydata()), expected)
                chart.take(line)
            continue
        for line, expected in zip(chart.lines(axes), every, strict=True):
            chart.curve(axes, line, loci.values, expected, way_units)
    assert main.get_xlabel() == "contact angle in deg"
    # The curves are closest at 0.8 rad: 2 · 3 kHz · 0.01 apart.
    chart.says("A: ", (60.0, "Hz"), (0.8, "rad"))
    (frame,) = main.patches
    scale = 1e3 if main.get_ylabel().endswith("kHz") else 1.0
    edges = np.radians([box_of(frame).get_x(), box_of(frame).get_x() + box_of(frame).get_width()])
    assert np.mean(edges) == pytest.approx(0.8)
    inside = np.radians(enlarged.get_xlim())
    assert tuple(edges) == pytest.approx(tuple(inside))
    box = box_of(frame)
    assert scale * box.get_y() < 2970 < 3030 < scale * (box.get_y() + box.get_height())
    chart.take(frame)
    assert handles(chart.figure) == ["torsional", "transverse (×2)"]
    chart.text("torsional")
    chart.text("transverse", within="×2")
    chart.finish()


def _response(loss=0.1):
    hertz = np.geomspace(300.0, 30e3, 201)
    value = 1e-6 / (1 - (hertz / 2000) ** 2 + 1j * loss)
    return FrequencyResponse(
        jnp.asarray(hertz), jnp.asarray(value), jnp.zeros(201, bool), "screw u", "nut x", "mobility"
    )


@reads("chart", "response_chart")
def test_responses():
    found, modes = {"light": _response(0.01), "heavy": _response(0.3)}, made.modes()
    chart = Chart(response_chart(found, modes))
    upper, lower = chart.axes
    for response in found.values():
        size = 20 * np.log10(np.abs(np.asarray(response.value)))
        line = chart.lines(upper)[0]
        np.testing.assert_allclose(y_data(line), size)
        chart.curve(upper, line, response.frequency, None, ("Hz", "1"))
        line = chart.lines(lower)[0]
        angle = np.angle(np.asarray(response.value))
        chart.curve(lower, line, response.frequency, angle, ("Hz", "rad"))
    for value in np.asarray(modes.frequencies):
        if 300 <= value <= 30e3:
            for axes in (upper, lower):
                chart.level(axes, float(value), "Hz", "x")
    assert upper.get_ylabel() == "mobility in dB re 1 m/(N·s)"
    chart.text("mobility in dB")
    assert upper.get_title("left") == "nut x under a force at screw u"
    assert {"light", "heavy", "carrier", "torsional", "transverse", "roller"} == {
        text.get_text()
        for legend in (upper.get_legend(), *upper.artists)
        for text in legend.texts  # pyright: ignore[reportAttributeAccessIssue]
    }
    # The scale on the right, in mm/s for each newton, beside decibels re 1 m/s for each.
    (right,) = upper.child_axes
    assert right.get_ylabel() == "mobility in (mm/s)/N"
    ends = 1e3 * 10 ** (np.asarray(upper.get_ylim()) / 20)
    np.testing.assert_allclose(right.get_ylim(), ends)
    for place, label in zip(right.get_yticks(), right.get_yticklabels(), strict=True):
        assert parse(label.get_text())[0] == pytest.approx(place)
        chart.text(label.get_text(), place=upper)
    chart.finish()


@pytest.mark.parametrize(
    ("kind", "label", "per_si"),
    [("receptance", "µm/N", 1e6), ("accelerance", "(m/s²)/N", 1.0)],
)
def test_responses_in_the_units_of_an_engineer(kind, label, per_si):
    response = dataclasses.replace(_response(), kind=kind)
    upper, _ = response_chart({"x": response}).axes
    (right,) = upper.child_axes
    assert right.get_ylabel() == f"{kind} in {label}"
    ends = per_si * 10 ** (np.asarray(upper.get_ylim()) / 20)
    np.testing.assert_allclose(right.get_ylim(), ends)


def test_speeds_of_operation_are_shaded(campbell):
    """As far as they are on the axis; beyond it nothing is."""
    axes = campbell_chart(campbell, 628.0, (31.4, 251.3)).axes[0]
    (shade,) = axes.patches
    found = to_si([shade.get_x(), shade.get_x() + shade.get_width()], "rpm")
    low = to_si(axes.get_xlim()[0], "rpm")
    np.testing.assert_allclose(found, [max(31.4, low), 251.3])
    assert "in operation" in [text.get_text() for text in axes.get_legend().get_texts()]
    assert not campbell_chart(campbell, 628.0, (700.0, 800.0)).axes[0].patches


@pytest.fixture(scope="module")
def campbell():
    return prsm.campbell(scenes.example("wu2022"), carrier_ratio=0.375)


@reads("chart", "campbell_chart")
def test_orders_meet_frequencies(campbell):
    speed = 628.0
    chart = Chart(campbell_chart(campbell, speed))
    (axes,) = chart.axes
    crossings = campbell.crossings(speed)
    periods = {order.name: float(order.order) for order in campbell.orders}
    ends = chart.si(axes, "x", axes.get_xlim(), "rad/s")
    assert ends[1] == pytest.approx(speed)
    low, high = chart.si(axes, "y", axes.get_ylim(), "Hz")
    met = sorted(
        {(h * abs(periods[n]), n, h) for n, h in {(c.order, c.harmonic) for c in crossings}}
    )
    for count, _, _ in met:
        line = chart.lines(axes)[0]
        # An order is a number of periods for each turn of the screw.
        chart.curve(axes, line, ends, count * ends / (2 * np.pi), ("rad/s", "Hz"))
    # Names stand in the order of the lines' ends, beside them.
    names = [n.replace("_", " ") if h == 1 else f"{h}× {n.replace('_', ' ')}" for _, n, h in met]
    beside = [t for t in axes.texts if t.get_position()[0] == 1.035]
    assert [t.get_text() for t in beside] == names
    for text, (count, _, _) in zip(beside, met, strict=True):
        place = text.get_position()[1]
        (pointer,) = chart.lines(
            axes,
            lambda line, place=place: (
                list(line.get_xdata()) == [1.0, 1.03] and line.get_ydata()[1] == place
            ),
        )
        height = np.log(count * speed / (2 * np.pi) / low) / np.log(high / low)
        assert y_data(pointer)[0] == pytest.approx(height)
        chart.take(pointer, text)
    for value in np.unique(np.asarray(campbell.modes.frequencies)):
        if low < value < high:
            chart.level(axes, float(value), "Hz")
            at = list(np.asarray(campbell.modes.frequencies)).index(value)
            times = campbell.modes.multiplicities[at]
            expected = [(value, "Hz", "whole")] + ([(times, "", "whole")] if times > 1 else [])
            words = f"{value:,.0f} Hz".replace(",", "\u202f")
            chart.says("", *expected, within=words)
    dots = {
        (round(float(chart.si(axes, "x", x_data(line)[0], "rad/s")), 6),
         round(float(chart.si(axes, "y", y_data(line)[0], "Hz")), 4),
         line.get_markerfacecolor() != "white")
        for line in chart.lines(axes)
    }  # fmt: skip
    assert dots == {(round(c.speed, 6), round(c.frequency, 4), c.excited) for c in crossings}
    chart.ignore(chart.lines(axes))
    excited = [c for c in crossings if c.excited]
    for index, one in enumerate(excited[:24], start=1):
        words = chart.text(f"{index}  ")
        listed = f"{one.order.replace('_', ' ')}, {one.family}"
        assert listed in words
        times = f"{one.harmonic}× "
        assert (times in words) == (one.harmonic > 1)
        assert_reads(
            words.replace(times, "").removeprefix(f"{index}  "),
            (one.speed, "rad/s", "whole"),
            (one.frequency, "Hz", "whole"),
        )
        mark: Any = next(t for t in axes.texts if t.get_text() == str(index))
        place = (chart.si(axes, "x", mark.xy[0], "rad/s"), chart.si(axes, "y", mark.xy[1], "Hz"))
        assert place == pytest.approx((one.speed, one.frequency))
        chart.take(mark)
    if len(excited) > 24:
        assert chart.text("and ") == f"and {len(excited) - 24} more at higher speeds"
    assert handles(chart.figure)[-2:] == ["excited", "cancelled"]
    chart.finish()


@reads("chart", "mode_shapes")
def test_shapes():
    mechanism = scenes.example("wu2022")
    modes = scenes.modal(mechanism, shapes=True)
    chart = Chart(mode_shapes(mechanism, modes, energy=2e-3))
    distinct = list(modes.distinct)
    assert len(chart.axes) == len(distinct)
    kinetic = {k: np.asarray(v) for k, v in modes.kinetic_energy_shares().items()}
    strain = {k: np.asarray(v) for k, v in modes.strain_energy_shares().items()}
    shapes = np.abs(np.asarray(modes.shapes))
    for axes, at in zip(chart.axes, distinct, strict=True):
        family, times = modes.families[at], modes.multiplicities[at]
        frequency = float(modes.frequencies[at])
        title = f"{at + 1}" if times == 1 else f"{at + 1}, {at + 2}"
        title = f"{at + 1}–{at + times}" if times > 2 else title
        words = chart.text(title + "  " + family, place=axes)
        assert words.endswith(f"×{times}") == (times > 1)
        chart.says("", (frequency, "Hz"), within="Hz", place=axes)
        exaggerated = chart.text("displacements ×", place=axes)
        (factor,) = numbers(exaggerated)
        # Drawn: three quarters of a roller's radius; in truth the shape at 2 mJ. Of a repeated
        # root any shape may be drawn, so that only simple ones have a number here.
        if times == 1:
            truth = shapes[:, at].max() * np.sqrt(2 * 2e-3) / (2 * np.pi * frequency)
            radius = float(mechanism.stages[0].thread.roller_radius)
            # Two digits are printed; with rollers on the carrier displacements add up.
            assert factor.value == pytest.approx(0.75 * radius / truth, rel=0.06)
        for start, energies in (("moving: ", kinetic), ("strained: ", strain)):
            words = chart.text(start, place=axes)
            for name, share in re.findall(r"([a-z ]+) (\d+) %", words.removeprefix(start)):
                name = name.strip()
                found = _share(energies, name, at)
                assert 100 * found == pytest.approx(float(share), abs=0.5001), (words, name)
            total = [sum(float(v[at]) for v in energies.values())]
            assert total == pytest.approx([1.0])
    assert "energy of 2 mJ" in chart.text("Displacements are magnified")
    for axes in chart.axes:
        # Bodies and arrows: test_report_modes reads their places.
        chart.ignore([*axes.lines, *axes.patches])
    chart.finish()


def _share(energies, name, at):
    """The share behind the words of a panel."""
    springs = {
        "screw threads": ("screw_roller",),
        "nut threads": ("nut_roller",),
        "gear": ("ring_roller",),
        "pins": ("pin_radial", "pin_tangential"),
    }
    if name in springs:
        return sum(float(energies[k][at]) for k in springs[name] if k in energies)
    body = name.removesuffix(" support").replace(" ", "_")
    if name.endswith("support"):
        return sum(float(v[at]) for k, v in energies.items() if k.startswith(f"{body}_support_"))
    return float(energies["roller" if body == "rollers" else body][at])
