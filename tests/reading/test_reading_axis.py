"""Pictures and tables of the axis in space, read back in SI."""

import dataclasses
import types
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
import reading_scenes as made
import scenes
from expectations import reads
from present import present
from reading_artists import box_of, vertices_of, x_data, y_data
from reading_figures import Chart, handles
from reading_tables import assert_json, without_words
from reading_units import numbers

from prsm_jax.cli.verbs import _modal
from prsm_jax.mechanism import ModalDamping
from prsm_jax.report import axis_compliance_chart, axis_mode_shapes, nut_position_chart
from prsm_jax.response import AxisCompliance
from prsm_jax.vibration import Coordinate, ModeGroup, SpatialModes, Spring, SpringNetwork

_ENERGY = 2e-3
_SPRINGS = {
    "screw_support_axial": "thrust bearing",
    "screw_shaft_axial": "screw, stretching",
    "screw_shaft_torsional": "screw, twisting",
    "screw_roller": "threads at the screw",
    "nut_roller": "threads at the nut",
    "sticking_nut_roller": "threads at the nut",
    "coupling": "coupling",
    "motor_shaft": "motor shaft",
    "position_gain": "position gain",
    "thrust_tube": "thrust tube",
}
#: Words of an inverted roller screw, whose nut turns in the thrust bearing.
_INVERTED = _SPRINGS | {
    "screw_support_axial": "screw mounting",
    "thrust_tube": "joint at the load",
}
#: Bodies whose displacement moves the ends of each part; of the tube by example.
_PARTS = {
    "screw": [("screw_end", "screw"), ("screw", "screw")],
    "roller": [("roller 1", "roller 1")],
    "nut": [("nut", "nut")],
    "motor": [("", "")],
    "load": [("load", "load")],
}
_MOVED = {
    "actuator_axis": _PARTS | {"tube": [("nut", "load")]},
    "humanoid_leg": _PARTS | {"tube": [("load", "screw_end")]},
}


def _spatial_modes() -> SpatialModes:
    """Shapes and springs at odds: a rigid motion and three elastic modes."""
    degrees = tuple(
        Coordinate(body, direction)
        for body, directions in (
            ("screw", "xyzu"), ("nut", "xyzu"), ("screw_end", "zu"), ("motor", "u"), ("load", "z"),
            ("roller 1", ("radial", "tangential", "z", "u")),
        )
        for direction in directions
    )  # fmt: skip
    sign = jnp.asarray(np.random.default_rng(7).choice([-1.0, 1.0], (len(degrees), 4)))
    shapes = made.odds(len(degrees), 4) * sign
    network = SpringNetwork(
        stiffness=made.odds(len(_SPRINGS), scale=1e8),
        rows=made.odds(len(_SPRINGS), len(degrees)) - 1.4,
        mass=made.odds(len(degrees)),
        coordinates=degrees,
        springs=tuple(map(Spring, _SPRINGS)),
    )
    frequencies = jnp.asarray([0.0, 19.3, 127.1, 1.31e3])
    axial = ModeGroup(frequencies, made.odds(4) / 2, 1, "axial_torsional", shapes[..., None])
    across = ModeGroup(
        jnp.asarray([411.0]), made.odds(1) / 2, 2, "transverse", made.odds(len(degrees), 1, 2)
    )
    share = jnp.asarray([0.0, 0.3, 0.8, 0.2])
    return SpatialModes((axial, across), axial_share=share, network=network)


@pytest.fixture(scope="module")
def modes():
    return _spatial_modes()


def _strain(modes, at, words_of=_SPRINGS):
    """Share of the strain energy by the words for the springs."""
    network = modes.network
    shape = np.asarray(modes.groups[0].shapes)[:, at, 0]
    energy = np.asarray(network.stiffness) * (np.asarray(network.rows) @ shape) ** 2
    found: dict[str, float] = {}
    for words, one in zip(words_of.values(), energy / energy.sum(), strict=True):
        found[words] = found.get(words, 0.0) + one
    return dict(sorted(found.items(), key=lambda item: -item[1]))


@reads("chart", "axis_mode_shapes")
@pytest.mark.parametrize("name", _MOVED)
def test_shapes_in_a_longitudinal_section(modes, name):
    mechanism, moved = scenes.example(name), _MOVED[name]
    words_of = _INVERTED if name == "humanoid_leg" else _SPRINGS
    chart = Chart(axis_mode_shapes(mechanism, modes, energy=_ENERGY))
    shapes = np.asarray(modes.groups[0].shapes)[..., 0]
    names = [str(one) for one in modes.network.coordinates]
    thread = mechanism.stages[0].thread
    travel = float(thread.lead) / (2 * np.pi)
    radius = float(thread.screw_radius)
    radii = {"screw": radius, "screw_end": radius, "motor": radius, "nut": float(thread.nut_radius)}
    if name == "humanoid_leg":
        # Its motor turns the nut, without a shaft or coupling between them.
        radii["motor"] = radii["nut"]
    frequencies = np.asarray(modes.groups[0].frequencies)
    panels = iter(chart.axes)
    families = ["torsional", "axial", "torsional"]
    for at, family in enumerate(families, start=1):
        section, bars = next(panels), next(panels)
        chart.says(f"{at}  {family}", (frequencies[at], "Hz"), place=section)
        words = chart.text("displacements ×", place=section)
        (factor,) = numbers(words)
        truth = np.sqrt(2 * _ENERGY) / (2 * np.pi * frequencies[at])
        pairs = list(zip(section.patches[::2], section.patches[1::2], strict=True))
        expected = {name: list(ends) for name, ends in moved.items()}
        for now, rest in pairs:
            assert rest.get_label() == "rest"
            ends = expected[str(now.get_label())].pop(0)
            shift = vertices_of(now.get_path()) - vertices_of(rest.get_path())
            for column, body in zip((0, 1), ends, strict=True):
                size = shapes[names.index(f"{body} z"), at] if body else 0.0
                # The magnification is rounded before it is drawn.
                drawn = 1e-3 * shift[column, 0]
                assert drawn == pytest.approx(factor.value * truth * size, rel=1e-9, abs=1e-12)
            assert not shift[:, 1].any()
            chart.take(now, rest)
        assert not any(expected.values())
        paper = [size * 25.4 for size in chart.figure.get_size_inches()]
        box = section.get_position()
        along = np.ptp(section.get_xlim()) / (box.width * paper[0])
        across = np.ptp(section.get_ylim()) / (box.height * paper[1])
        for line in chart.lines(section, lambda line: str(line.get_label()).startswith("turn of")):
            body = str(line.get_label()).removeprefix("turn of ")
            turn = shapes[names.index(f"{body} u"), at] / radii[body]
            # Of the same length on paper as a displacement along the axis.
            length = 1e-3 * np.ptp(y_data(line)) * along / across
            signed = length * np.sign(y_data(line)[1] - y_data(line)[0])
            assert signed == pytest.approx(-factor.value * truth * travel * turn, rel=1e-9)
            chart.take(line)
        shares = [pair for pair in _strain(modes, at, words_of).items() if pair[1] >= 0.005][:5]
        assert chart.ticks(bars) == [words for words, _ in shares]
        for bar, (_, share) in zip(bars.patches, shares, strict=True):
            assert box_of(bar).get_width() / 100 == pytest.approx(share, rel=1e-12)
            chart.says("", (share, "1", "whole"), within="%", place=bars)
            chart.take(bar)
        # The centre line and the thrust bearing.
        chart.ignore(chart.lines(section))
    assert "strain energy in %" in chart.text("strain energy")
    assert "energy of 2 mJ" in chart.text("Displacements are magnified")
    # Distances along the axis are in millimetres: the screw ends at its length.
    ends = [
        vertices_of(p.get_path())[1, 0] for p in chart.axes[0].patches if p.get_label() == "rest"
    ]
    assert pytest.approx(1e3 * float(present(mechanism.stages[0].screw.length))) in ends
    assert chart.axes[-2].get_xlabel() == "along the axis in mm"
    assert "turn, as travel θL/2π" in handles(chart.figure)
    assert words_of["thrust_tube"] in handles(chart.figure)
    chart.text("turn, as travel")
    chart.finish()


def test_a_load_behind_the_mounting_of_the_nut_moves_by_itself(modes):
    """Without a thrust tube, too, which draws it as with one."""
    mechanism = scenes.example("actuator_axis")
    axis = present(mechanism.axis)
    load = dataclasses.replace(present(axis.load), tube_stiffness=None)
    without = dataclasses.replace(mechanism, axis=dataclasses.replace(axis, load=load))

    def drawn(one):
        section = axis_mode_shapes(one, modes, energy=_ENERGY).axes[0]
        return {
            str(patch.get_label()): vertices_of(patch.get_path())
            for patch in section.patches
            if patch.get_label() in ("tube", "load")
        }

    expected = drawn(mechanism)
    assert set(expected) == {"tube", "load"}
    for name, vertices in drawn(without).items():
        np.testing.assert_array_equal(vertices, expected[name])


@reads("chart", "nut_position_chart")
def test_numbers_against_the_position_of_the_nut():
    distance = np.linspace(0.05, 0.4, 9)
    values = {
        "held_motor_stiffness": np.asarray(made.odds(9, scale=1.2e8)),
        "first_axial_frequency": np.asarray(made.odds(9, scale=130.0)),
        "servo_stiffness": np.asarray(made.odds(9, scale=2e7)),
        "antiresonance_frequency": np.asarray(made.odds(9, scale=110.0)),
        "first_torsional_frequency": np.where(distance < 0.2, np.inf, 600.0),
    }
    chart = Chart(nut_position_chart(distance, values, 0.21))
    upper, lower = chart.axes
    for name in ("first_axial_frequency", "first_torsional_frequency", "antiresonance_frequency"):
        wanted = np.where(np.isfinite(values[name]), values[name], np.nan)
        line = chart.lines(upper)[0]
        chart.curve(upper, line, distance, wanted, ("m", "Hz"))
    for name in ("held_motor_stiffness", "servo_stiffness"):
        chart.curve(lower, chart.lines(lower)[0], distance, values[name], ("m", "N/m"))
    for axes in (upper, lower):
        chart.level(axes, 0.21, "m", "x")
    assert handles(chart.figure) == [
        *("first axial", "first torsional", "first, motor held"),
        *("motor held", "motor held by its controller"),
    ]
    chart.finish()
    assert "from the thrust bearing in mm" in lower.get_xlabel()
    turned = nut_position_chart(distance, values, turning="nut").axes[-1]
    assert turned.get_xlabel() == "distance of the nut from the end of the screw at the load in mm"
    with pytest.raises(ValueError, match="values has mass; give some of first_axial_frequency"):
        nut_position_chart(distance, {"mass": distance})


def _compliance() -> AxisCompliance:
    hertz = np.geomspace(2.0, 2e3, 60)
    values = [
        np.asarray(made.odds(60, scale=scale)) * np.exp(1j * np.asarray(made.odds(60)))
        for scale in (2e-8, 3e-8, 0.02)
    ]
    pole = np.arange(60) == 7
    for value in values:
        value[pole] = np.inf
    nut, load, motor = map(jnp.asarray, values)
    return AxisCompliance(jnp.asarray(hertz), nut, load, motor, jnp.asarray(pole))


@reads("chart", "axis_compliance_chart")
def test_compliance_at_nut_load_and_motor(modes):
    compliance = _compliance()
    held = SpatialModes(
        (ModeGroup(jnp.asarray([113.0]), made.odds(1), 1, "axial_torsional"),),
        axial_share=jnp.asarray([0.9]),
    )
    chart = Chart(axis_compliance_chart(compliance, modes, held))
    upper, lower = chart.axes
    for axes, name, unit in (
        (upper, "nut", "m/N"),
        (upper, "load", "m/N"),
        (lower, "motor", "rad/(N·m)"),
    ):
        size = np.abs(np.asarray(getattr(compliance, name)))
        size = np.where(np.isfinite(size), size, np.nan)
        line = chart.lines(axes)[0]
        np.testing.assert_allclose(x_data(line), np.asarray(compliance.frequency))
        chart.curve(axes, line, compliance.frequency, size, ("Hz", unit))
    for value in (19.3, 127.1, 1310.0):
        for axes in (upper, lower):
            chart.level(axes, value, "Hz", "x")
    chart.level(lower, 113.0, "Hz", "x")
    chart.finish()
    words = {text.get_text() for one in upper.artists for text in one.texts}  # pyright: ignore[reportAttributeAccessIssue]
    assert words == {"at the nut", "at the load"}
    turned = axis_compliance_chart(compliance, turning="nut").axes[0]
    assert {text.get_text() for one in turned.artists for text in one.texts} == {
        "at the screw",
        "at the load",
    }
    assert handles(chart.figure) == ["torsional", "axial", "motor held (anti-resonance)"]


def _damping() -> Any:
    """Ratios of six modes in their order, one fed by friction, and the dashpots."""
    return types.SimpleNamespace(
        damping_ratios=np.asarray([0.0, 4.1e-5, 0.0153, -0.0078, -0.0078, 0.62]),
        vibrating=np.asarray([True, True, True, True, True, False]),
        result_name="negative_damping",
        result="negative damping: a sentence",
        creep=types.SimpleNamespace(
            slip_speed=0.311,
            contact_force=471.0,
            damping_along_slip=-13.7,
            damping_across_slip=91.3,
        ),
    )


@pytest.mark.parametrize(
    ("name", "damped", "law"),
    [
        ("actuator_axis", False, None),
        ("actuator_axis", True, None),
        ("humanoid_leg", True, ModalDamping(0.015)),
        ("humanoid_leg", False, ModalDamping(0.015)),
    ],
)
def test_the_verb_modal_in_space(run, monkeypatch, modes, name, damped, law):
    values = {
        name: float(made.odd(1e7 if unit == "N/m" else 100.0))
        for name, (_, unit) in _modal.AXIS_QUANTITIES.items()
    }
    found = object.__new__(_modal.Spatial)
    mechanism = scenes.example(name)
    stage = dataclasses.replace(mechanism.stages[0], damping=law)
    found.mechanism = dataclasses.replace(mechanism, stages=(stage,))
    found.stage, found.modes = 1, modes
    found.elastic, found.held, found.axis = modes.elastic_modes(), modes, values
    found.damping, found.tilt = _damping() if damped else None, damped
    asked: list[tuple[Any, ...]] = []

    def make(*arguments):
        asked.append(arguments)
        return found

    monkeypatch.setattr(_modal, "Spatial", make)
    results, printed = run("modal", name, "--spatial", *(["--tilt"] if damped else []))
    # Numbers and pictures of the axis follow what its table says.
    assert {(one.axis.tilt, stage, tilt) for one, stage, tilt in asked} == {(damped, 1, damped)}
    frequencies = [19.3, 127.1, 1310.0]
    network, shapes = modes.network, np.asarray(modes.groups[0].shapes)[..., 0]
    energies = np.asarray(network.stiffness)[:, None] * (np.asarray(network.rows) @ shapes) ** 2
    energies /= energies.sum(axis=0)
    moving = np.asarray(network.mass)[:, None] * shapes**2
    moving /= moving.sum(axis=0)
    bodies = [one.body.split()[0] for one in network.coordinates]
    strain = [dict(zip(_SPRINGS, energies[:, at], strict=True)) for at in (1, 2, 3)]
    kinetic = [
        {b: sum(moving[[one == b for one in bodies], at]) for b in dict.fromkeys(bodies)}
        for at in (1, 2, 3)
    ]
    families = ["torsional", "axial", "torsional"]
    keys = {"Hz": "hz", "N/m": "n_per_m"}
    units = {name: unit for name, (_, unit) in _modal.AXIS_QUANTITIES.items()}
    assert ("creep_friction" in results) == damped
    creep = results.pop("creep_friction", None)
    if damped:
        assert creep == {
            "result": "negative_damping",
            "damping_ratios": [0.0, 4.1e-5, 0.0153, -0.0078, -0.0078, 0.62],
            "vibrating": [True, True, True, True, True, False],
            "slip_speed_m_per_s": 0.311,
            "contact_force_n": 471.0,
            "damping_along_slip_n_s_per_m": -13.7,
            "damping_across_slip_n_s_per_m": 91.3,
        }
    assert_json(
        without_words(results),
        {
            "stage": 1,
            "spatial": True,
            "tilt": damped,
            "frequencies_hz": [0.0, 19.3, 127.1, 411.0, 411.0, 1310.0],
            "families": ["rigid", "torsional", "axial", "transverse", "transverse", "torsional"],
            "multiplicities": [1, 1, 1, 2, 2, 1],
            "axial_torsional": [
                {
                    "number": at + 1,
                    "family": families[at],
                    "frequency_hz": frequencies[at],
                    "kinetic_energy_shares": kinetic[at],
                    "strain_energy_shares": strain[at],
                }
                for at in range(3)
            ],
            "antiresonances_hz": frequencies,
            "axis": {f"{name}_{keys[units[name]]}": value for name, value in values.items()},
        },
    )
    rows = [
        ("rigid", (0.0, "Hz"), (1, "")),
        ("torsional", (19.3, "Hz"), (1, "")),
        ("axial", (127.1, "Hz"), (1, "")),
        ("transverse", (411.0, "Hz"), (2, "")),
        ("torsional", (1310.0, "Hz"), (1, "")),
    ]
    tilting = ", bodies tilting" if damped else ""
    printed.row(f"Natural frequencies in space{tilting}: {name}, stage 1")
    head = ("family", "f Hz", "times")
    if damped:
        # One row for each distinct frequency.
        ratios = [(0.0, "1"), (4.1e-5, "1"), (0.0153, "1"), (-0.0078, "1"), "62 (first order)"]
        rows = [(*row, ratio) for row, ratio in zip(rows, ratios, strict=True)]
        head = (*head, "damping %")
    printed.table(head, rows)
    if damped:
        other = "[stage.damping] of the file is not included" if law else "no other"
        printed.row(f"Damping: friction of the sliding threads at the operating point, {other}.")
        printed.row("negative damping: a sentence")
    for quantity, (words, unit) in _modal.AXIS_QUANTITIES.items():
        printed.line(words, values[quantity], unit)
    words_of = _INVERTED if name == "humanoid_leg" else _SPRINGS
    springs = [
        (f"{at + 1} {families[at]}", (frequencies[at], "Hz"), words, (share, "1"))
        for at in range(3)
        for words, share in list(_strain(modes, at + 1, words_of).items())[:4]
        if share >= 0.01
    ]
    printed.table(("mode", "f Hz", "spring", "share %"), springs)
    printed.finish()
