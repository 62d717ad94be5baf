"""The verb modal: shapes in the JSON, pictures, and frequencies against a parameter."""

import numpy as np
import pytest

import prsm_jax
from tests import scenes


def test_shapes_go_with_the_frequencies(prsm_json):
    results = prsm_json("modal", "wu2022", "--shapes")
    modes = scenes.modal(scenes.example("wu2022"), shapes=True)
    assert results["coordinates"] == [str(coordinate) for coordinate in modes.coordinates]
    shapes = np.asarray(results["shapes_per_sqrt_kg"])
    assert shapes.shape == (17, 17)
    # A row for each mode, each of modal mass one.
    mass = np.asarray(modes.network.mass)
    np.testing.assert_allclose((shapes**2) @ mass, 1.0, rtol=1e-12)
    stiffness = np.asarray(modes.network.stiffness_matrix())
    omega = 2 * np.pi * np.asarray(results["frequencies_hz"])
    values = np.einsum("mi,ij,mj->m", shapes, stiffness, shapes)
    np.testing.assert_allclose(values, omega**2, rtol=1e-9)
    for name in ("kinetic_energy_shares", "strain_energy_shares"):
        total = np.sum(list(results[name].values()), axis=0)
        np.testing.assert_allclose(total, 1.0, rtol=1e-12)


def test_pictures_and_a_range(prsm_json, tmp_path):
    folder = tmp_path / "pictures"
    results = prsm_json(
        "modal",
        "wu2022",
        "--out",
        folder,
        "--no-animation",
        "--against",
        "screw.support.radial_stiffness",
        "--from",
        "1 kN/um",
        "--to",
        "60 kN/um",
        "--points",
        "31",
    )
    names = {
        f"{name}.{suffix}"
        for name in ("mode-shapes", "frequencies-against-screw-support-radial_stiffness")
        for suffix in ("png", "svg")
    }
    assert {path.name for path in folder.iterdir()} == names
    assert {path.rsplit("/", 1)[1] for path in results["pictures"]} == names
    against = results["against"]
    assert against["parameter"] == "screw.support.radial_stiffness"
    assert against["unit"] == "N/m"
    np.testing.assert_allclose(against["values"], np.geomspace(1e9, 6e10, 31), rtol=1e-12)
    assert np.shape(against["frequencies_hz"]["transverse"]) == (31, 4)
    assert [v["family"] for v in against["veerings"]] == ["transverse"]


def test_a_range_prints_a_table(prsm):
    status, out, err = prsm(
        "modal", "wu2022", "--against", "roller_count", "--from", "7", "--to", "8"
    )
    assert (status, err) == (0, "")
    assert "f Hz at 7" in out
    assert "f Hz at 8" in out
    # The first column is the mechanism as it is.
    frequency = float(scenes.modal(scenes.example("wu2022")).group("carrier").frequencies[0])
    assert out.count(f"{frequency:.6g}") == 2


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--against", "lead"], "--from and --to"),
        (["--from", "1 mm", "--to", "2 mm"], "--against"),
        (["--against", "leed", "--from", "1 mm", "--to", "2 mm"], "leed"),
        (["--against", "lead", "--from", "1 kg", "--to", "2 mm"], "--from 1 kg"),
        (["--against", "lead", "--from", "8 mm", "--to", "0.8 cm"], "must differ"),
        (["--against", "lead", "--from", "8 mm", "--to", "9 mm", "--points", "2"], "--points 2"),
        (["--against", "roller_count", "--from", "2.5", "--to", "4"], "--from 2.5"),
        (["--stage", "2"], "stage is 2"),
        (["--spatial", "--stage", "2"], "stage is 2"),
        (["--spatial", "--against", "lead"], "not with --spatial"),
        (["--spatial", "--from", "1", "--to", "2"], "--from, --to: not with --spatial"),
        (["--spatial", "--points", "7"], "--points: not with --spatial"),
        (["--spatial", "--no-animation"], "--no-animation: not with --spatial"),
        (["--tilt"], "--tilt: give --spatial too"),
        (["--spatial", "--tilt"], "give stage.roller.length"),
    ],
)
def test_what_a_user_can_mend_is_one_line(prsm, tmp_path, words, expected):
    status, out, err = prsm("modal", "wu2022", *words, "--out", tmp_path / "new")
    assert (status, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    assert expected in err
    assert list(tmp_path.iterdir()) == []


def test_in_space_with_pictures_of_the_axis(prsm_json, tmp_path):
    results = prsm_json("modal", "actuator_axis", "--spatial", "--out", tmp_path / "axis")
    names = {
        f"axis-{name}.{suffix}"
        for name in ("mode-shapes", "compliance", "against-nut-position")
        for suffix in ("png", "svg")
    }
    assert {path.name for path in (tmp_path / "axis").iterdir()} == names
    assert {path.rsplit("/", 1)[1] for path in results["pictures"]} == names
    axis, modes = results["axis"], results["axial_torsional"]
    axial = next(mode for mode in modes if mode["family"] == "axial")
    assert axial["frequency_hz"] == pytest.approx(axis["first_axial_frequency_hz"], rel=1e-12)
    assert next(iter(axial["strain_energy_shares"])) == "screw_shaft_axial"
    held = results["antiresonances_hz"][0]
    assert held == pytest.approx(axis["antiresonance_frequency_hz"], rel=1e-12)


def test_in_space_with_tilts(prsm_json):
    results = prsm_json("modal", "actuator", "--spatial", "--tilt")
    assert results["tilt"] is True
    expected = prsm_jax.spatial_modal(prsm_jax.load("actuator"), tilt=True)
    found = np.array(results["frequencies_hz"])
    np.testing.assert_allclose(found, expected.frequencies, rtol=1e-11, atol=1e-11 * found.max())
    assert results["families"].count("transverse") == 2 * 8
    assert len(results["creep_friction"]["damping_ratios"]) == len(found)
