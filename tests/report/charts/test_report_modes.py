"""Mode shapes, their animations, and frequencies against a parameter."""

import math
import re

import equinox as eqx
import jax
import numpy as np
import pytest
from report_checks import assert_printable, axis_labels

import prsm_jax as prsm
from prsm_jax.mechanism import UnequalRoller
from prsm_jax.report import (
    frequency_chart,
    frequency_loci_chart,
    mode_shapes,
    save_mode_animation,
    save_mode_animations,
)
from prsm_jax.vibration import frequency_loci
from tests import scenes
from tests.present import present


@pytest.fixture(scope="module")
def modes(wu2022):
    return scenes.modal(wu2022, shapes=True)


@pytest.fixture(scope="module")
def sheet(wu2022, modes):
    return mode_shapes(wu2022, modes)


@pytest.fixture(scope="module")
def unequal(wu2022):
    rollers = (
        UnequalRoller(2, stiffness_factor=scenes.array(0.7)),
        UnequalRoller(5, missing=True),
    )
    return eqx.tree_at(lambda m: m.stages[0].unequal_roller, wu2022, rollers)


def _panel(figure, start):
    """The panel whose headline starts so."""
    return next(
        axes for axes in figure.axes if any(t.get_text().startswith(start) for t in axes.texts)
    )


def _placed(axes):
    """Displacement of the centre [mm] and angle [rad] of every body as drawn, by name."""
    found = {}
    for patch in axes.patches:
        name = patch.get_label()
        if name and not name.startswith("_"):
            matrix = (patch.get_data_transform() - axes.transData).get_matrix()
            angle = math.atan2(matrix[1, 0], matrix[0, 0])
            found[name] = (matrix[0, 2], matrix[1, 2], angle)
    return found


def test_there_is_a_panel_for_each_distinct_frequency(sheet, modes):
    assert len(sheet.axes) == len(set(zip(modes.families, modes.frequencies.tolist(), strict=True)))
    words = [axes.texts[0].get_text() for axes in sheet.axes]
    assert words[:3] == ["1  torsional", "2  carrier", "3, 4  transverse ×2"]
    assert "11–14  roller ×4" in words
    assert_printable(sheet)


def test_a_torsional_mode_turns_all_rollers_alike(sheet, modes):
    placed = _placed(_panel(sheet, "8  torsional"))
    angles = [placed[f"roller {n}"][2] for n in range(1, 8)]
    # Rounding of the transforms to pixels and back.
    assert np.ptp(angles) < 1e-9
    assert abs(angles[0]) > 0.05
    assert placed["screw"][:2] == pytest.approx((0, 0), abs=1e-9)
    # u = r θ on each body's own circle: 12, 20 and 4 mm.
    u = {n: float(modes.shapes[modes.network.index(f"{n} u"), 7]) for n in ("screw", "ring_gear")}
    drawn = placed["ring_gear"][2] * 20 / (placed["screw"][2] * 12)
    assert drawn == pytest.approx(u["ring_gear"] / u["screw"], rel=1e-6)
    one = float(modes.shapes[modes.network.index("roller 1 u"), 7])
    assert angles[0] * 4 / (placed["screw"][2] * 12) == pytest.approx(one / u["screw"], rel=1e-6)


def test_a_transverse_mode_moves_the_screw_by_what_is_printed(sheet, modes):
    """Against the energy share of the screw, which does not depend on the choice of a shape."""
    axes = _panel(sheet, "3, 4  transverse")
    x, y, angle = _placed(axes)["screw"]
    assert (y, angle) == pytest.approx((0, 0), abs=1e-9)
    share = float(modes.kinetic_energy_shares()["screw"][2])
    mass = float(present(scenes.example("wu2022").stages[0].screw.mass))
    # ½ m (ω a)² is the screw's share of 1 mJ.
    amplitude = math.sqrt(2 * 1e-3 * share / mass) / (2 * math.pi * float(modes.frequencies[2]))
    printed = next(t.get_text() for t in axes.texts if "displacements" in t.get_text())
    factor = float(re.fullmatch(r"displacements ×(\d+)", printed).group(1))
    # Two digits are printed.
    assert abs(x) == pytest.approx(1e3 * factor * amplitude, rel=0.04)
    # What moves most does so by three quarters of the roller radius.
    drawn = [abs(_placed(axes)[name][0]) for name in ("nut", "screw", "ring_gear")]
    assert max(drawn) == pytest.approx(3.0, rel=1e-6)


def test_the_carrier_takes_its_rollers_along(sheet):
    placed = _placed(_panel(sheet, "2  carrier"))
    assert placed["carrier"][2] != 0
    turned = placed["carrier"][2] * 16
    assert placed["roller 1"] == pytest.approx((16, turned, 0), abs=1e-9)
    assert placed["screw"] == pytest.approx((0, 0, 0), abs=1e-9)


def test_unequal_rollers_are_drawn_in_their_places(unequal):
    modes = scenes.modal(unequal, shapes=True)
    figure = mode_shapes(unequal, modes)
    assert_printable(figure)
    names = set(_placed(figure.axes[0]))
    assert {n for n in names if n.startswith("roller")} == {
        f"roller {n}" for n in (1, 2, 3, 4, 6, 7)
    }
    # Two rollers' places are exchanged by no symmetry, but two roller modes stay alike.
    assert any("roller ×2" in t.get_text() for axes in figure.axes for t in axes.texts)
    assert_printable(frequency_chart({"unequal": modes}))


def test_rigid_motions_have_any_size():
    wu2022 = scenes.example("wu2022")
    bodies = ("screw", "nut", "ring_gear", "carrier")
    mechanism = eqx.tree_at(
        lambda m: [getattr(m.stages[0], name).support for name in bodies], wu2022, [None] * 4
    )
    figure = mode_shapes(mechanism, scenes.modal(mechanism, shapes=True))
    assert_printable(figure)
    words = [t.get_text() for axes in figure.axes for t in axes.texts]
    assert "displacements of any size" in words
    rigid = [axes for axes in figure.axes if "rigid" in axes.texts[0].get_text()]
    assert len(rigid) == 3
    assert all("strained: nothing" in [t.get_text() for t in axes.texts] for axes in rigid)


def test_what_cannot_be_drawn_is_said(wu2022, modes):
    with pytest.raises(ValueError, match="shapes=True"):
        mode_shapes(wu2022, scenes.modal(wu2022))
    with pytest.raises(ValueError, match="stage is 2"):
        mode_shapes(wu2022, modes, stage=2)
    with pytest.raises(ValueError, match="energy is -1 J"):
        mode_shapes(wu2022, modes, energy=-1.0)


def test_an_animation_is_one_period_that_repeats(wu2022, modes, tmp_path):
    from PIL import Image

    path = save_mode_animation(tmp_path / "mode", wu2022, modes, 4)
    assert path == tmp_path / "mode.gif"
    assert [p.name for p in tmp_path.iterdir()] == ["mode.gif"]
    assert 50_000 < path.stat().st_size < 1_000_000
    with Image.open(path) as animation:
        assert animation.n_frames == 24  # pyright: ignore[reportAttributeAccessIssue]
        assert animation.info["loop"] == 0
        frames = []
        for index in (0, 1, 12, 23):
            animation.seek(index)
            frames.append(np.asarray(animation.convert("RGB"), float))
    assert (frames[0] != frames[2]).any()
    # The way back shows what the way there did.
    assert (frames[1] == frames[3]).all()
    assert (frames[0][0, 0] == 255).all()


def test_an_animation_is_whole_or_not_there(wu2022, modes, tmp_path, monkeypatch):
    with pytest.raises(ValueError, match="modes 1 to 17"):
        save_mode_animation(tmp_path / "mode", wu2022, modes, 18)
    with pytest.raises(ValueError, match="frames is 9"):
        save_mode_animations(tmp_path / "new", wu2022, modes, frames=9)

    def full(*_):
        raise OSError("no space")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(OSError, match="no space"):
        save_mode_animation(tmp_path / "mode", wu2022, modes, 1, frames=8)
    assert list(tmp_path.iterdir()) == []


STIFFNESS = np.geomspace(1e9, 6e10, 61)


@pytest.fixture(scope="module")
def loci(wu2022):
    return frequency_loci(wu2022, "screw.support.radial_stiffness", STIFFNESS)


def test_loci_are_the_frequencies_of_each_design(wu2022, loci):
    assert bool(loci.valid.all())
    for at in (0, 30, 60):
        one = prsm.set_parameter(wu2022, "screw.support.radial_stiffness", STIFFNESS[at])
        single = scenes.modal(one)
        for group in single.groups:
            np.testing.assert_allclose(
                loci.frequencies[group.family][at], group.frequencies, rtol=1e-12
            )


def test_families_cross_and_curves_of_one_family_veer(loci):
    transverse = np.asarray(loci.frequencies["transverse"])
    torsional = np.asarray(loci.frequencies["torsional"])
    # The screw on its support passes the torsional mode at 13.9 kHz.
    assert np.ptp(np.sign(transverse[:, 1] - torsional[:, 2])) == 2
    (veering,) = loci.veerings()
    assert (veering.family, veering.lower) == ("transverse", 1)
    gap = transverse[:, 2] - transverse[:, 1]
    assert veering.at == np.argmin(gap)
    assert gap[veering.at] > 0


def test_the_chart_shows_the_loci_and_enlarges_the_veering(loci):
    figure = frequency_loci_chart(loci)
    assert_printable(figure)
    main, enlarged = figure.axes
    assert (main.get_xscale(), main.get_yscale()) == ("log", "log")
    lines = {line.get_gid(): line for line in main.lines}
    np.testing.assert_allclose(
        lines["transverse 1"].get_ydata(), 1e-3 * np.asarray(loci.frequencies["transverse"])[:, 1]
    )
    np.testing.assert_allclose(lines["carrier 0"].get_xdata(), 1e-6 * STIFFNESS)
    assert axis_labels(figure)[:2] == [
        "screw support radial stiffness in N/µm",
        "natural frequency in kHz",
    ]
    value = 1e-6 * loci.veerings()[0].value
    assert enlarged.get_xlim()[0] < value < enlarged.get_xlim()[1]


def test_loci_without_symmetry_mix_their_colours(unequal):
    values = np.linspace(0.5, 1.5, 5)
    found = frequency_loci(unequal, "unequal_roller.2.stiffness_factor", values)
    np.testing.assert_allclose(np.asarray(found.shares).sum(axis=1), 1.0, rtol=1e-12)
    moved = prsm.set_parameter(unequal, "unequal_roller.2.stiffness_factor", 0.5)
    single = scenes.modal(moved)
    np.testing.assert_allclose(
        found.frequencies["coupled"][0], single.group("coupled").frequencies, rtol=1e-12
    )
    assert_printable(frequency_loci_chart(found))


def test_whole_numbers_are_points_and_absent_modes_gaps(wu2022):
    found = frequency_loci(wu2022, "roller_count", [3, 4])
    roller = np.asarray(found.frequencies["roller"])[:, 0]
    assert np.isnan(roller[0])
    assert np.isfinite(roller[1])
    figure = frequency_loci_chart(found)
    assert_printable(figure)
    assert {line.get_marker() for line in figure.axes[0].lines} == {"o"}


def test_designs_that_do_not_mesh_are_left_out():
    actuator = scenes.example("actuator")
    # So flat a flank touches the screw's nowhere between the axes.
    found = frequency_loci(actuator, "roller_profile_radius", [5e-3, 6e-3, 1.0])
    assert found.valid.tolist() == [True, True, False]
    assert np.isnan(found.frequencies["roller"][2]).all()
    assert_printable(frequency_loci_chart(found))


@pytest.mark.parametrize(
    ("parameter", "values", "message"),
    [
        ("leed", [1e-3, 2e-3], "leed"),
        ("lead", [1e-3], "at least two"),
        ("lead", [1e-3, np.nan], "finite"),
        ("lead", [1e-3, 2e-3, 2e-3], "strictly ascending or descending"),
        ("roller_count", [3.5, 4.5], "whole number"),
    ],
)
def test_bad_ranges_are_one_line(wu2022, parameter, values, message):
    with pytest.raises((ValueError, prsm.UnknownNameError), match=message):
        frequency_loci(wu2022, parameter, values)


def test_loci_have_derivatives(wu2022):
    """With respect to another number of the mechanism: forward, reverse, and differences."""
    values = [1e8, 3e9]

    @jax.jit
    def transverse(mass):
        moved = prsm.set_parameter(wu2022, "nut.mass", mass)
        return frequency_loci(moved, "screw.support.radial_stiffness", values).frequencies[
            "transverse"
        ]

    mass, step = scenes.array(2.159), 1e-5
    forward, reverse = jax.jacfwd(transverse)(mass), jax.jacrev(transverse)(mass)
    differences = (transverse(mass + step) - transverse(mass - step)) / (2 * step)
    np.testing.assert_allclose(forward, reverse, atol=1e-9)
    # Frequencies of 2e4 Hz, known to 1e-15 of themselves, over a step of 1e-5.
    np.testing.assert_allclose(forward, differences, atol=1e-4)
    assert float(np.abs(forward).max()) > 100
