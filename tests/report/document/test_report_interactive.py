"""Numbers of interactive charts, as a page holds them, against results converted by `pint`."""

import json

import jax.numpy as jnp
import numpy as np
import pint
import pytest
from report_scenes import make_modes, make_steady, make_transient

from prsm_jax.load_sharing import ForceDeflection
from prsm_jax.report.interactive import (
    Axis,
    Chart,
    Curve,
    deflection_curves,
    elasticity_bars,
    frequency_bars,
    history_curves,
    life_curve,
    loss_bars,
    objective_curve,
    plotly_figure,
    power_curves,
    script_text,
    shaft_limit_curves,
    transient_curves,
)
from prsm_jax.strength import buckling_load, permissible_speed

_REGISTRY = pint.UnitRegistry()


def _si(values, label):
    """Numbers of the page in SI; a gap is NaN."""
    numbers = np.array([np.nan if one is None else one for one in values], float)
    words = {"": "dimensionless", "turns": "dimensionless", "%": "percent"}.get(label, label)
    quantity = _REGISTRY.Quantity(numbers, words.replace("·", "*"))
    return quantity.to_base_units().magnitude


class _Read:
    """A chart as a browser reads it: traces by name and axis, units from the hover text."""

    def __init__(self, chart: Chart):
        self.figure = json.loads(script_text(plotly_figure(chart)))

    def curve(self, name: str, panel: int = 0):
        axis = "y" if panel == 0 else f"y{panel + 1}"
        found = [t for t in self.figure["data"] if t["name"] == name and t["yaxis"] == axis]
        (trace,) = found
        x_part, y_part = trace["hovertemplate"].removesuffix("</extra>").split("<br>")
        x_label = x_part.partition("}")[2].strip()
        y_label = y_part.partition("<extra>")[0].partition("}")[2].strip()
        layout = self.figure["layout"]
        # The axis names the unit that the hover text has.
        for key, label in (("xaxis", x_label), (axis.replace("y", "yaxis"), y_label)):
            if label:
                assert layout[key]["title"]["text"].endswith(f" in {label}")
        x = trace["x"] if "ticktext" in layout["xaxis"] else _si(trace["x"], x_label)
        return x, _si(trace["y"], y_label)

    def words(self):
        return self.figure["layout"]["xaxis"]["ticktext"]


def _same(found, expected):
    # Nine digits are in the page.
    np.testing.assert_allclose(found, np.asarray(expected), rtol=1e-8, atol=1e-12)


def test_transients():
    run = make_transient(2)
    page = _Read(transient_curves(run))
    time, efficiency = page.curve("efficiency")
    _same(time, run.time)
    _same(efficiency, run.efficiency)
    for stage in range(2):
        _same(page.curve(f"stage {stage + 1}", 1)[1], run.carrier_ratio[stage])
    _same(page.curve("drive torque", 2)[1], run.drive_torque)


def test_histories_and_powers(wu2022):
    run = make_transient(1)
    page = _Read(history_curves(wu2022, run))
    titles = {
        key: one["title"]["text"]
        for key, one in page.figure["layout"].items()
        if key.startswith("yaxis")
    }
    # Constant speed and load are no curves.
    assert not [words for words in titles.values() if words.startswith(("screw speed", "load"))]
    place = list(titles.values()).index("drive torque in N·m")
    _same(page.curve("drive torque", place)[1], run.drive_torque)
    powers = _Read(power_curves(wu2022, run))
    _, motor = powers.curve("motor")
    _same(motor, np.asarray(run.drive_torque) * np.asarray(run.screw_speed))
    # 10 mm a turn at 100 rad/s against 7 kN.
    _same(powers.curve("load")[1], -7e3 * 100 * 0.01 / (2 * np.pi) * np.ones(len(run.time)))


def test_losses_and_frequencies():
    states = {"before": make_steady(2e3, thread_sliding=300.0, drag=20.0)}
    states["after"] = make_steady(2e3, thread_sliding=200.0)
    page = _Read(loss_bars(states))
    assert page.words() == ["thread sliding", "drag"]
    _same(page.curve("before")[1], [300.0, 20.0])
    _same(page.curve("after")[1], [200.0, 0.0])
    page = _Read(frequency_bars({"x": make_modes(1.0)}))
    found = dict(zip(page.words(), page.curve("x")[1], strict=True))
    assert found["carrier 1"] == pytest.approx(840.0)
    assert found["torsional 3"] == pytest.approx(27e3)
    assert "rigid 1" not in found
    # Tools stand under each other beside the diagram: across the top they cover the legend.
    assert page.figure["layout"]["modebar"]["orientation"] == "v"
    assert page.figure["layout"]["margin"]["r"] >= 40
    # As the caption says of the picture, where four frequencies are double and one is fourfold.
    assert sum(word.endswith(" ×2") for word in found) == 4
    assert sum(word.endswith(" ×4") for word in found) == 1
    assert not any("×1" in word for word in found)


def test_deflection_life_and_shaft(actuator):
    load = jnp.asarray([-2e3, 1e3, 3e3])
    travel = 3e-6 * jnp.sign(load) * jnp.abs(load / 1e3) ** 0.7
    curve = ForceDeflection(load, travel, 4e8 + load, 0 * load, load == load)
    page = _Read(deflection_curves({"a": curve}))
    force, travel = page.curve("a")
    _same(force, load)
    _same(travel, curve.deflection)
    _same(page.curve("a", 1)[1], curve.tangent_stiffness)
    force, turns = _Read(life_curve(60e3, 90e3)).curve("basic rating life")
    # Nine digits of a force are fewer of its cube.
    np.testing.assert_allclose(turns, 1e6 * (60e3 / force) ** 3, rtol=4e-8)
    assert force.max() == pytest.approx(90e3)
    stage = actuator.stages[0]
    page = _Read(shaft_limit_curves(stage))
    length, buckling = page.curve("fixed–supported")
    # Nine digits of the length give as many of the load.
    assert buckling[40] == pytest.approx(
        float(buckling_load(stage, jnp.asarray(length[40]))), rel=1e-7
    )
    length, speed = page.curve("fixed–supported", 1)
    wanted = float(permissible_speed(stage, jnp.asarray(length[7])))
    assert speed[7] == pytest.approx(wanted, rel=1e-7)


def test_elasticities_and_the_objective():
    page = _Read(elasticity_bars(("a_b", "rating_life[2]"), ("lead",), [[0.5], [np.nan]]))
    assert page.words() == ["a b", "rating life, stage 2"]
    assert page.figure["data"][0]["y"] == [0.5, None]
    page = _Read(objective_curve((0.8512, 0.8791), "efficiency", "1"))
    _same(page.curve("efficiency")[1], [0.8512, 0.8791])


def test_a_gap_is_no_number_and_names_are_text():
    evil = "</script><b>{x}"
    chart = Chart(Axis(evil), (Axis(evil, "mm"),), (Curve(evil, [1.0, 2.0], [np.nan, 3.0]),))
    text = script_text(plotly_figure(chart))
    assert "<" not in text
    assert ">" not in text
    (trace,) = json.loads(text)["data"]
    assert trace["y"] == [None, 3.0]
    # plotly shows some HTML and fields in names: neither is left.
    assert trace["name"] == "&lt;/script&gt;&lt;b&gt;{x}"
    assert "<b>" not in trace["hovertemplate"].replace("<br>", "")
    assert trace["hovertemplate"].count("{") == 2
