"""Pictures of transients: histories with shaded sticking, power flow, the stages in motion."""

import dataclasses
import math

import jax.numpy as jnp
import numpy as np
import pytest
from PIL import Image
from present import present
from report_checks import assert_printable, axis_labels
from report_scenes import make_steady, make_transient
from scenes import array, example, simulate
from scipy.integrate import simpson

from prsm_jax.dynamics import body_forces, energy
from prsm_jax.dynamics.histories._transient_result import Phase
from prsm_jax.report import (
    PowerFlow,
    energy_flow,
    force_orbit,
    history_chart,
    power_flow_chart,
    power_history,
    power_history_chart,
    save_motion_animation,
    save_transient_pictures,
    steady_flow,
)
from prsm_jax.report._style import page_figure
from prsm_jax.report.animations import _stage_animation
from prsm_jax.report.animations._stage_animation import angle_scale, poses
from prsm_jax.report.animations._stage_view import TelescopeView
from prsm_jax.report.motion_charts._history_chart import sticking_phases, travel_of
from prsm_jax.scenario import Scenario


@pytest.fixture(scope="module")
def mechanism():
    return example("li2021_two_stage")


@pytest.fixture(scope="module")
def settling(mechanism):
    return simulate(mechanism, Scenario(100.0, 5000.0, 1e-3, samples=201))


@pytest.fixture(scope="module")
def sticking(settling):
    """Turns to and fro and sticks twice; the numbers are made up."""
    time = settling.time * 1e3
    speed = 100 * jnp.sin(2 * jnp.pi * time)
    held = (time > 0.2) & (time < 0.3)
    padding = jnp.ones(3)
    return dataclasses.replace(
        settling,
        time=time,
        screw_speed=jnp.where(held, 0.0, speed),
        sticking=held,
        position=1e-3 * jnp.cos(2 * jnp.pi * time),
        phases=Phase(
            jnp.concatenate([jnp.array([0.0, 0.2, 0.3, 0.8]), padding]),
            jnp.concatenate([jnp.array([0.2, 0.3, 0.8, 0.9]), padding]),
            jnp.concatenate([jnp.array([1.0, 0.0, 1.0, 0.0]), 0 * padding]),
        ),
    )


def _shaded(axes):
    boxes = [p for p in axes.patches if p.get_height() == 1 and p.get_y() == 0]
    return [(box.get_x(), box.get_x() + box.get_width()) for box in boxes]


def test_every_picture_of_a_transient_can_be_printed(mechanism, settling, sticking):
    for run in (settling, sticking):
        figure = history_chart(mechanism, run)
        assert_printable(figure)
        labels = axis_labels(figure)
        assert {"in N·m", "in %", "in mm"} <= set(labels)
        figure = power_history_chart(mechanism, run)
        assert_printable(figure)
        assert any(label.startswith("power in") for label in axis_labels(figure))
        assert_printable(power_flow_chart(energy_flow(mechanism, run)))


def test_sticking_is_shaded_where_the_phases_say(mechanism, settling, sticking):
    assert sticking_phases(settling) == []
    assert np.allclose(sticking_phases(sticking), [(0.2, 0.3), (0.8, 0.9)])
    for figure in (history_chart(mechanism, sticking), power_history_chart(mechanism, sticking)):
        for axes in figure.axes:
            if axes.get_visible():
                assert np.allclose(_shaded(axes), [(0.2, 0.3), (0.8, 0.9)])
    assert "sticks" in [t.get_text() for t in history_chart(mechanism, sticking).legends[0].texts]


def test_what_does_not_change_is_named_instead_of_drawn(mechanism, settling):
    figure = history_chart(mechanism, settling)
    words = figure.get_suptitle()
    assert "screw speed 954.9" in words
    assert "load 5.000" in words
    titles = [axes.get_title() or axes.get_title(loc="left") for axes in figure.axes]
    assert "screw speed" not in titles
    assert "drive torque" in titles


def test_energies_are_integrals_of_the_powers(mechanism, settling):
    flow = energy_flow(mechanism, settling)
    assert flow.unit == "J"
    # 5 kN over the travel of two leads of 10 mm at 100 rad/s, for a millisecond.
    assert flow.sinks["load"] == pytest.approx(5000 * 0.02 * 100 / (2 * math.pi) * 1e-3)
    assert flow.sources["motor"] == pytest.approx(
        float(simpson(settling.drive_torque * 100.0, x=settling.time)), rel=1e-12
    )
    assert sum(flow.sinks.values()) == pytest.approx(flow.total, rel=1e-12)
    # The carriers have their kinetic energy in the end: ½ I ω², from nothing.
    inertia = [
        2 * float(s.carrier.inertia)
        + 7 * float(s.roller.inertia) * 16
        + 7 * float(s.roller.mass) * float(s.thread.centre_distance) ** 2
        for s in mechanism.stages
    ]
    energy = sum(
        i * float(w) ** 2 / 2 for i, w in zip(inertia, settling.carrier_speed[:, -1], strict=True)
    )
    # To the error of Simpson's rule on 200 intervals.
    assert flow.sinks["moving masses"] == pytest.approx(energy, rel=2e-4)


def test_the_energies_of_the_picture_are_those_of_the_table(mechanism):
    """`prsm simulate` prints `energy`; on few samples the trapezoidal rule would differ."""
    run = simulate(mechanism, Scenario(100.0, 5000.0, 1e-3, samples=21))
    flow = energy_flow(mechanism, run)
    trapezoidal = float(np.trapezoid(run.drive_torque * run.screw_speed, run.time))
    assert trapezoidal != pytest.approx(flow.sources["motor"], rel=1e-4)
    assert flow.sources["motor"] == pytest.approx(float(energy(run, "from_drive")), rel=1e-12)
    assert flow.sinks["load"] == pytest.approx(float(energy(run, "to_load")), rel=1e-9)
    for name, power in run.losses.items():
        assert flow.sinks.get(name, 0.0) == pytest.approx(float(simpson(power, x=run.time)))


def test_both_halves_of_the_power_picture_are_equal(mechanism, settling):
    powers = power_history(mechanism, settling)
    total = powers.motor + powers.load + powers.kinetic + powers.bristles
    np.testing.assert_allclose(total, sum(powers.losses.values()), rtol=1e-12)
    figure = power_history_chart(mechanism, settling)
    low, high = figure.axes[0].dataLim.intervaly
    assert low == pytest.approx(-high)


def test_steady_flows_name_who_drives():
    state = make_steady(3000.0, thread_sliding=400.0, spin=40.0)
    flow = steady_flow(state)
    assert flow.sources == {"motor": 3440.0}
    assert flow.sinks == {"load": 3000.0, "thread_sliding": 400.0, "spin": 40.0}
    assert steady_flow(state, load_drives=True).sources == {"load": 3440.0}
    # What locks itself takes power from both ends.
    locked = dataclasses.replace(
        state, output_power=jnp.asarray(-40.0), input_power=jnp.asarray(400.0)
    )
    assert steady_flow(locked, load_drives=True).sources == {"load": 400.0, "motor": 40.0}


def test_widths_of_the_bands_are_the_flows():
    flow = PowerFlow({"motor": 90.0, "load": 10.0}, {"load": 70.0, "spin": 29.9, "drag": 0.1}, "W")
    figure = power_flow_chart(flow)
    assert_printable(figure)
    heights: dict[str, list[float]] = {}
    for patch in figure.axes[0].patches:
        if patch.get_label() in ("motor", "load", "spin", "drag"):
            heights.setdefault(patch.get_label(), []).append(patch.get_height())
    whole = heights["motor"][0] / 0.9
    assert heights["load"] == pytest.approx([0.1 * whole, 0.7 * whole])
    assert heights["spin"] == pytest.approx([0.299 * whole])
    with pytest.raises(ValueError, match="nothing flows"):
        power_flow_chart(PowerFlow({}, {}, "W"))


def test_the_stages_move_as_they_should(mechanism, settling):
    times, found, scale = poses(mechanism, settling, 11)
    assert times[-1] == pytest.approx(1e-3)
    last = found[-1]
    assert last.turned == {"screw": pytest.approx(scale * 0.1)}
    # Each nut takes the next screw along, so the second has travelled both leads.
    assert last.travel == pytest.approx([0.1 / (2 * math.pi) * 10, 0.1 / (2 * math.pi) * 20])
    for stage in (0, 1):
        turned = np.trapezoid(settling.carrier_speed[stage], settling.time)
        assert last.carriers[stage] == pytest.approx(scale * float(turned))
        assert last.rollers[stage] == pytest.approx(-5 * last.carriers[stage])
    np.testing.assert_allclose(
        travel_of(mechanism, settling), 0.02 * 100 / (2 * math.pi) * settling.time
    )


@pytest.mark.parametrize("span", [0.0, 1e-3, 0.1, 3.0, 500.0])
def test_turning_is_drawn_so_that_the_eye_can_follow(span):
    scale = angle_scale(np.linspace(0.0, span, 60))
    drawn = scale * span / 59
    assert drawn <= math.radians(20) * (1 + 1e-12)
    assert scale == pytest.approx(round(scale)) or 1 / scale == pytest.approx(round(1 / scale))
    if span:
        assert scale * span >= math.radians(150)


def test_all_pictures_are_written(mechanism, settling, tmp_path):
    written = save_transient_pictures(tmp_path / "out", mechanism, settling, animation=False)
    names = {"force-orbit", "transient", "histories", "powers", "energy-flow"}
    assert {path.name for path in written} == {f"{n}.{s}" for n in names for s in ("png", "svg")}
    assert all(path.stat().st_size > 1000 for path in written)


def test_the_animation_moves_and_repeats(mechanism, settling, tmp_path):
    path = save_motion_animation(tmp_path / "motion", mechanism, settling, frames=8)
    with Image.open(path) as picture:
        assert picture.n_frames == 8  # pyright: ignore[reportAttributeAccessIssue]
        assert picture.info["loop"] == 0
        first = np.asarray(picture.convert("RGB")).astype(int)
        picture.seek(4)
        assert (np.abs(np.asarray(picture.convert("RGB")) - first).max(axis=2) > 40).mean() > 0.01
    with pytest.raises(ValueError, match="at least 8"):
        save_motion_animation(tmp_path / "motion", mechanism, settling, frames=4)
    assert [p.name for p in tmp_path.iterdir()] == ["motion.gif"]


def test_force_orbits_end_where_the_forces_do(mechanism, settling):
    forces = body_forces(mechanism, settling)
    figure = force_orbit(mechanism, settling, forces)
    assert_printable(figure)
    assert axis_labels(figure).count("radial force in N") == 4
    friction = np.asarray(forces.screw_friction_on_roller)
    for stage in (0, 1):
        ends = [line.get_xydata()[-1] for line in figure.axes[2 * stage + 1].lines]
        expected = friction[stage, -1, :2]
        assert min(float(np.abs(end - expected).max()) for end in ends) < 1e-9


def test_nothing_moves_and_nothing_is_said_of_energy(mechanism, tmp_path):
    run = make_transient()
    still = dataclasses.replace(
        run, screw_speed=array(0 * run.time), carrier_speed=0 * run.carrier_speed
    )
    written = save_transient_pictures(tmp_path, mechanism, still, animation=False)
    assert not any("energy" in path.name for path in written)


#: By example: the body that turns, the bodies that move along the axis in the half-section, and
#: travel over the angle of that body, in leads.
TYPES = {
    "humanoid_leg": ("nut", {"screw", "thread", "rollers"}),
    "recirculating_stage": ("screw", {"nut", "rollers"}),
    "differential_stage": ("screw", {"nut", "rollers"}),
}


@pytest.mark.parametrize("name", TYPES)
def test_other_types_have_pictures_of_their_motion(name, tmp_path):
    mechanism, (turning, moving) = example(name), TYPES[name]
    run = simulate(mechanism, Scenario(100.0, 2000.0, 1e-3, samples=21))
    written = save_transient_pictures(tmp_path / "out", mechanism, run, animation=False)
    names = {"transient", "histories", "powers", "energy-flow"}
    names |= {"force-orbit"} if name == "humanoid_leg" else set()
    assert {path.name for path in written} == {f"{n}.{s}" for n in names for s in ("png", "svg")}
    _, found, scale = poses(mechanism, run, 11)
    last, thread = found[-1], mechanism.stages[0].thread
    assert last.turned == {turning: pytest.approx(scale * 0.1)}
    carriers = np.trapezoid(np.asarray(run.carrier_speed)[0], np.asarray(run.time))
    # The nut of a differential one travels by the lead per turn of screw over carrier.
    angle = 0.1 - carriers if name == "differential_stage" else 0.1
    travel = 1e3 * float(thread.lead) / (2 * math.pi) * angle
    assert last.travel == pytest.approx((travel,), rel=1e-6)
    radii = float(thread.nut_radius), float(thread.screw_radius), float(thread.roller_radius)
    # Around a held screw rollers turn with the carrier, in a held nut against it.
    ratio = -radii[1] / radii[2] if turning == "nut" else radii[0] / radii[2]
    assert last.rollers[0] == pytest.approx(-ratio * last.carriers[0])

    axes = page_figure(40, 100).subplots()
    view = TelescopeView(axes, mechanism, np.array([pose.travel for pose in found]).T)

    def places():
        return {
            body: (artists[0].get_transform() - axes.transData).transform((0.0, 0.0))[0]
            for _, body, artists in view._moving
        }

    view.move(found[0])
    start = places()
    view.move(last)
    shifts = {body: place - start[body] for body, place in places().items()}
    for body in ("screw", "nut", "rollers"):
        assert shifts[body] == pytest.approx(travel if body in moving else 0.0, abs=1e-9)
    pitch = 1e3 * float(thread.pitch)
    along = travel
    if turning == "screw":
        along = last.turned["screw"] / (2 * math.pi) * 1e3 * float(thread.lead) % pitch
    assert shifts["thread"] == pytest.approx(along, abs=1e-9)


def test_the_forces_name_the_bodies_of_an_inverted_screw():
    mechanism = example("humanoid_leg")
    run = simulate(mechanism, Scenario(100.0, 2000.0, 1e-3, samples=21))
    figure = force_orbit(mechanism, run)
    words = [
        text.get_text().partition(" (")[0]
        for axes in figure.axes
        for text in present(axes.get_legend()).get_texts()
    ]
    assert words == [
        *("nut, normal", "screw"),
        *("nut, friction", "teeth of the screw, both ends", "carrier pins, both ends"),
    ]


def test_the_heading_names_the_bodies_of_an_inverted_screw(monkeypatch, tmp_path):
    mechanism = example("humanoid_leg")
    run = simulate(mechanism, Scenario(100.0, 2000.0, 1e-3, samples=21))
    figures, still = [], _stage_animation._still
    monkeypatch.setattr(
        _stage_animation, "_still", lambda *given: figures.append(still(*given)) or figures[-1]
    )
    save_motion_animation(tmp_path / "motion", mechanism, run, frames=8)
    heading = figures[0].texts[-1].get_text()
    assert heading == "1 ms, nut 955 rpm, screw 0.0796 mm"
