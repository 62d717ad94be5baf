"""Every key and every line of the verbs that analyse, against SI numbers.

The analyses themselves are replaced by results of which no two numbers are alike.
"""

import dataclasses
import tomllib
from types import SimpleNamespace

import numpy as np
import pytest
import reading_scenes as made
import scenes
from expectations import reads
from reading_tables import assert_json, without_words
from scipy.integrate import simpson

import prsm_jax
from prsm_jax.cli.verbs import _analyse, _contact, _simulate
from prsm_jax.geometry import Finding


def _directly(_, function, mechanism):
    return function(mechanism)


def _peak(major, minor, pressure, ratio, measure):
    """Made up: what tells the two measures and the two contacts apart."""
    del major
    share, depth = (0.61, 0.71) if measure == "von_mises" else (0.32, 0.48)
    return SimpleNamespace(value=share * pressure * ratio, depth=depth * minor)


def _side(place, part, ratio=0.3):
    hertz = part.hertz
    return {
        "contact_radius_m": place.contact_radius,
        "contact_angle_position_rad": place.contact_angle_position,
        "roller_contact_radius_m": place.roller_contact_radius,
        "roller_angle_position_rad": place.roller_angle_position,
        "normal_force_n": part.normal_force,
        "semi_major_m": hertz.semi_major,
        "semi_minor_m": hertz.semi_minor,
        # Both alike: these ellipses lie on no flank that could end.
        "max_pressure_pa": hertz.max_pressure,
        "whole_ellipse_max_pressure_pa": hertz.max_pressure,
        "approach_m": hertz.approach,
        "stiffness_n_per_m": hertz.stiffness,
        "stiffness_tangent_n_per_m": hertz.stiffness_tangent,
        "axial_stiffness_n_per_m": part.axial_stiffness,
        "roller_stiffness_n_per_m": part.roller_stiffness,
        "max_von_mises_stress_pa": 0.61 * ratio * hertz.max_pressure,
        "max_von_mises_depth_m": 0.71 * hertz.semi_minor,
        "max_shear_stress_pa": 0.32 * ratio * hertz.max_pressure,
        "max_shear_depth_m": 0.48 * hertz.semi_minor,
    }


def _loads(side):
    forward, reverse = np.asarray(side.forward), np.asarray(side.reverse)
    both = forward + reverse
    return {
        "thread_load_n": forward,
        "reverse_thread_load_n": reverse,
        "thread_pressure_pa": side.max_pressure,
        "whole_ellipse_thread_pressure_pa": side.max_pressure,
        "roller_load_n": (forward - reverse).sum(axis=1),
        "thread_sharing_factor": both.max() / both.mean(),
        "roller_sharing_factor": 1.0,
        "roller_stiffness_n_per_m": side.stiffness[0],
        "class_stiffness_n_per_m": side.stiffness,
    }


@reads("verb", "contact")
@pytest.mark.parametrize("name", ["actuator_load_sharing", "ring_roller"])
def test_contact(run, monkeypatch, name):
    pair, place, shared = made.contact_pair(), made.meshing(), made.distribution()
    _, line = made.line_contact()
    monkeypatch.setattr(_contact, "run_stored", _directly)
    monkeypatch.setattr(_contact, "mesh", lambda _: place)
    # The invented place lies on no flank that could end.
    monkeypatch.setattr(_contact, "side_onsets", lambda *_: None)
    monkeypatch.setattr(_contact, "thread_contacts", lambda *_: (pair,))
    monkeypatch.setattr(_contact, "stress_peak_on_axis", _peak)
    monkeypatch.setattr(_contact, "load_distribution", lambda *_, **__: shared)
    monkeypatch.setattr(_contact, "line_contact", lambda *_: line)
    found, printed = run("contact", name)
    stage = scenes.example(name).stages[0]
    sides = {s: _side(getattr(place, s), getattr(pair, s)) for s in ("screw", "nut")}
    expected = {"stage": 1, "converged": True, **sides}
    if stage.load_sharing is not None:
        elastic = shared.elastic
        expected["load_sharing"] = {
            "rollers": [[1, 2, 3]],
            "converged": bool(shared.converged & elastic.converged),
            "screw": _loads(shared.screw),
            "nut": _loads(shared.nut),
            "max_pressure_pa": shared.max_pressure,
            "whole_ellipse_max_pressure_pa": shared.max_pressure,
            "deflection_m": elastic.deflection,
            "unloaded_deflection_m": elastic.unloaded_position,
            "secant_stiffness_n_per_m": elastic.secant_stiffness,
            "tangent_stiffness_n_per_m": shared.tangent_stiffness,
            "spacer_force_n": shared.spacer_force,
        }
    else:
        expected["line_contact"] = {
            "converged": True,
            "radius_m": line.slices.radius,
            "line_load_n_per_m": line.line_load,
            "half_width_m": line.half_width,
            "pressure_pa": line.pressure,
            "axial_force_n": line.axial_force,
            "normal_force_n": line.normal_force,
            "approach_m": line.approach,
            "stiffness_tangent_n_per_m": line.stiffness_tangent,
            "max_pressure_pa": line.max_pressure,
            "max_half_width_m": line.max_half_width,
            "loaded_share": line.loaded_share,
            "edge_ratio": line.edge_ratio,
            "parabola_fit": line.parabola_fit,
        }
    assert_json(without_words(found), {"stages": [expected]})

    head = ("stage side", "r mm", "φ deg", "F_n N", "a mm", "b mm", "p₀ MPa", "δ µm", "F/δ N/µm")
    keys = ("contact_radius_m", "contact_angle_position_rad", "normal_force_n", "semi_major_m")
    keys += ("semi_minor_m", "max_pressure_pa", "approach_m", "stiffness_n_per_m")
    units = ("m", "rad", "N", "m", "m", "Pa", "m", "N/m")

    def rows(keys, units):
        return [
            (f"1 {s}", *((sides[s][k], u) for k, u in zip(keys, units, strict=True)))
            for s in ("screw", "nut")
        ]

    printed.table(head, rows(keys, units))
    head = ("stage side", "von Mises MPa", "at depth mm", "shear MPa", "at depth mm")
    keys = ("max_von_mises_stress_pa", "max_von_mises_depth_m")
    keys += ("max_shear_stress_pa", "max_shear_depth_m")
    printed.table(head, rows(keys, ("Pa", "m", "Pa", "m")))
    if stage.load_sharing is not None:
        start, loads = "stage 1: load sharing, ", expected["load_sharing"]
        for words, value, unit in (
            ("largest over mean thread load, screw", loads["screw"]["thread_sharing_factor"], ""),
            ("largest over mean thread load, nut", loads["nut"]["thread_sharing_factor"], ""),
            ("largest over mean roller load", 1.0, ""),
            ("largest pressure", shared.max_pressure, "Pa"),
            ("deflection", shared.elastic.deflection, "m"),
            ("axial stiffness dF/dx", shared.tangent_stiffness, "N/m"),
            ("force in the spacer", shared.spacer_force, "N"),
        ):
            printed.line(start + words, value, unit)
    else:
        for words, value, unit in (
            ("largest pressure", line.max_pressure, "Pa"),
            ("largest half-width", line.max_half_width, "m"),
            ("approach", line.approach, "m"),
            ("axial force", line.axial_force, "N"),
            ("share of the flank that carries", line.loaded_share, ""),
            ("largest line load over its mean", line.edge_ratio, ""),
            ("R² of the parabola", line.parabola_fit, ""),
        ):
            printed.line("stage 1: line contact, " + words, value, unit)
    printed.finish()


@reads("verb", "steady")
def test_steady(run, monkeypatch):
    state, mechanism = made.steady(stages=2), scenes.example("li2020_two_stage")
    monkeypatch.setattr(_analyse, "run_stored", _directly)
    monkeypatch.setattr(_analyse, "steady_state", lambda _: state)
    found, printed = run("steady", "li2020_two_stage")
    point = mechanism.operating_point
    assert_json(
        without_words(found),
        {
            "efficiency": state.efficiency,
            "carrier_ratio": state.carrier_ratio,
            "drive_torque_nm": state.drive_torque,
            "contact_force_n": state.contact_force,
            "screw_roller_axial_force_n": state.screw_roller_axial_force,
            "ring_gear_force_n": state.ring_gear_force,
            "carrier_force_n": state.carrier_force,
            "slip_speed_m_per_s": state.slip_speed,
            "losses_w": dict(state.losses),
            "input_power_w": state.input_power,
            "output_power_w": state.output_power,
            "power_balance_residual": state.power_balance_residual,
            "result": "successful",
            "result_message": "successful",
            "speed_rad_per_s": point.speed,
            "load_n": point.load,
        },
    )
    printed.line("efficiency", state.efficiency, "1")
    printed.line("drive torque", state.drive_torque, "N·m")
    printed.line("input power", state.input_power, "W")
    printed.line("output power", state.output_power, "W")
    for name, power in state.losses.items():
        printed.line(f"loss: {name}", power, "W")
    printed.line("power balance residual", state.power_balance_residual, "")
    for k in range(2):
        printed.line(f"stage {k + 1}: carrier ratio", state.carrier_ratio[k], "")
        words = f"stage {k + 1}: normal force of screw on one roller"
        printed.line(words, state.contact_force[k], "N")
    printed.row("Steady state: li2020_two_stage")
    printed.finish()


def test_steady_of_an_inverted_screw_names_the_nut(run, monkeypatch):
    """Its nut turns, and the force is that of the nut on the rollers, which slide there."""
    state = made.steady()
    monkeypatch.setattr(_analyse, "run_stored", _directly)
    monkeypatch.setattr(_analyse, "steady_state", lambda _: state)
    monkeypatch.setattr(_analyse, "checked", lambda _: ())
    _, printed = run("steady", "humanoid_leg")
    words = "stage 1: normal force of nut on one roller"
    printed.line(words, state.contact_force[0], "N")


#: Directions of energy in the JSON, and lines for energy in one direction or in both.
_WAYS = ("from_drive", "to_drive", "to_load", "from_load")
_BOTH_WAYS = {
    False: (
        ("energy from the drive", "drive_energy_j", "J"),
        ("energy to the load", "load_energy_j", "J"),
    ),
    True: (
        ("energy supplied by the drive", "energy_from_drive_j", "J"),
        ("energy taken back by the drive", "energy_to_drive_j", "J"),
        ("net energy from the drive", "drive_energy_j", "J"),
        ("energy taken by the load", "energy_to_load_j", "J"),
        ("energy given back by the load", "energy_from_load_j", "J"),
        ("net energy to the load", "load_energy_j", "J"),
    ),
}


@reads("verb", "simulate")
@pytest.mark.parametrize("to_and_fro", [False, True])
def test_simulate(run, monkeypatch, to_and_fro):
    history = made.transient(to_and_fro=to_and_fro)
    history = dataclasses.replace(history, load_power=0.013 * history.load * history.screw_speed)
    monkeypatch.setattr(_simulate, "run_transient", lambda *_, **__: history)
    found, printed = run("simulate", "li2020_two_stage", "--method", "closed_form")
    time, torque, speed = (
        np.asarray(x) for x in (history.time, history.drive_torque, history.screw_speed)
    )
    power, taken = torque * speed, np.asarray(history.load_power)
    given = np.maximum(power, 0) + np.maximum(-taken, 0)
    got = np.maximum(taken, 0) + np.maximum(-power, 0)
    summary = {
        "duration_s": 2e-3,
        "peak_drive_torque_nm": np.abs(torque).max(),
        "rms_drive_torque_nm": np.sqrt(simpson(torque**2, x=time) / 2e-3),
        "peak_drive_power_w": np.abs(power).max(),
        "peak_screw_speed_rad_per_s": np.abs(speed).max(),
        "peak_contact_force_n": np.asarray(history.contact_force).max(),
        "drive_energy_j": simpson(power, x=time),
        "load_energy_j": simpson(taken, x=time),
        "loss_energy_j": simpson(sum(map(np.asarray, history.losses.values())), x=time),
        "mission_efficiency": simpson(got, x=time) / simpson(given, x=time),
        "energy_from_drive_j": simpson(np.maximum(power, 0), x=time),
        "energy_to_drive_j": simpson(np.maximum(-power, 0), x=time),
        "energy_to_load_j": simpson(np.maximum(taken, 0), x=time),
        "energy_from_load_j": simpson(np.maximum(-taken, 0), x=time),
    }
    # Sums of eighty numbers in another order.
    assert found["summary"] == pytest.approx(summary, rel=1e-12, abs=1e-15)
    summary = found["summary"]
    most = np.maximum(np.abs(power), np.abs(taken))
    expected = {
        "summary": summary,
        "time_s": history.time,
        "screw_speed_rad_per_s": history.screw_speed,
        "load_n": history.load,
        "carrier_ratio": history.carrier_ratio,
        "carrier_speed_rad_per_s": history.carrier_speed,
        # Where it is one: above a fiftieth of the largest power.
        "efficiency": np.where(most > 0.02 * most.max(), history.efficiency, np.nan),
        "drive_torque_nm": history.drive_torque,
        "screw_roller_axial_force_n": history.screw_roller_axial_force,
        "contact_force_n": history.contact_force,
        "ring_gear_force_n": history.ring_gear_force,
        "carrier_force_n": history.carrier_force,
        "spline_friction_n": history.spline_friction,
        "losses_w": dict(history.losses),
        "power_balance_residual": history.power_balance_residual,
        "solver": {
            "name": "Kvaerno5",
            "steps": 50,
            "rejected": 3,
            "result": "successful",
            "error_estimate": 2.7e-7,
            "error_time_s": None,
            "time_constant_s": 4e-6,
        },
    }
    if to_and_fro:
        expected["position_m"] = history.position
        expected["sticking"] = history.sticking
        edges = [0.0, 6e-4, 9e-4, 2e-3]
        modes = ["forward", "sticking", "backward"]
        expected["phases"] = [
            {"start_s": a, "end_s": b, "mode": mode}
            for a, b, mode in zip(edges, edges[1:], modes, strict=False)
        ]
    assert_json(without_words(found), expected)
    for words, key, unit in (
        ("duration", "duration_s", "s"),
        ("peak drive torque", "peak_drive_torque_nm", "N·m"),
        ("RMS drive torque", "rms_drive_torque_nm", "N·m"),
        ("peak drive power", "peak_drive_power_w", "W"),
        ("peak screw speed", "peak_screw_speed_rad_per_s", "rad/s"),
        ("largest contact force", "peak_contact_force_n", "N"),
        *_BOTH_WAYS[to_and_fro],
        ("energy lost", "loss_energy_j", "J"),
        ("efficiency over the mission", "mission_efficiency", "1"),
    ):
        printed.line(words, summary[key], unit)
    if not to_and_fro:
        assert printed.row("start") == ["end"]
        ends = [
            ("efficiency %", 100 * history.efficiency),
            ("drive torque N·m", history.drive_torque),
            *((f"stage {k + 1}: carrier ratio", history.carrier_ratio[k]) for k in range(2)),
        ]
        for words, values in ends:
            cells = [float(cell) for cell in printed.row(words)]
            assert cells == pytest.approx([float(values[0]), float(values[-1])], rel=5e-6)
    printed.row("Transient: li2020_two_stage")
    # Sentences are broken into lines that fit the terminal.
    sentences = " ".join(cells[0] for cells in printed.lines)
    printed.lines.clear()
    of_screw = "carrier speed uncertain by up to 2.7·10⁻⁵ % of the highest screw speed"
    expected = ""
    if to_and_fro:
        of_screw = "screw speed uncertain by about 2.7·10⁻⁵ % of its largest value"
        given, back, got, driven = (f"{summary[f'energy_{way}_j']:.6g}" for way in _WAYS)
        expected = (
            "Efficiency over the mission: energy put out over energy put in, both directions "
            f"counted: ({got} + {back}) / ({given} + {driven}). A drive that cannot take energy "
            f"back has to supply {given} J. "
        )
    expected += f"Kvaerno5: 50 steps, 3 rejected, successful; {of_screw}"
    assert sentences == expected
    printed.finish()


@reads("verb", "check")
def test_check(run, monkeypatch):
    findings = (
        Finding("buckling", "warning", 1, 1.23, 2.34, "is too long"),
        Finding("mass", "error", 2, 3.45, 4.56, "is too heavy"),
    )
    monkeypatch.setattr(_analyse, "checked", lambda _: findings)
    found, printed = run("check", "wu2022", status=1)
    keys = ("name", "severity", "stage", "value", "limit", "message")
    assert found.pop("errors", 1) == 1
    found.pop("assumptions", None)
    assert_json(found, {"findings": [{k: getattr(f, k) for k in keys} for f in findings]})
    printed.row("Findings")
    head = ("name", "severity", "stage", "what")
    printed.table(head, [(f.name, f.severity, str(f.stage), f.message) for f in findings])
    printed.finish()


@reads("verb", "quantities")
def test_quantities(run):
    found, printed = run("quantities")
    known = [
        {"name": q.name, "symbol": q.symbol, "unit": q.unit, "description": q.description}
        for q in prsm_jax.quantities.catalogue()
    ]
    assert_json(found, {"quantities": known})
    for one in known:
        assert printed.row(one["name"])[:2] == [one["symbol"], one["unit"]]


@reads("verb", "example")
def test_examples(run):
    from prsm_jax.file import example_names, example_text

    found, printed = run("example")
    titles = {name: tomllib.loads(example_text(name))["title"] for name in example_names()}
    assert found == {"examples": list(example_names()), "titles": titles}
    for name, title in titles.items():
        assert printed.row(name) == [title]
    found, _ = run("example", "wu2022")
    assert found == {"name": "wu2022", "text": example_text("wu2022")}
