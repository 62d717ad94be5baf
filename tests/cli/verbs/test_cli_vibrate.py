"""The verbs of forced vibration: JSON, tables, pictures, errors."""

import re

import numpy as np
import pytest

import prsm_jax
from prsm_jax.mechanism import ModalDamping
from tests import scenes

RESPONSE_KEYS = {
    "stage",
    "from",
    "to",
    "kind",
    "unit",
    "damping",
    "frequency_hz",
    "real",
    "imaginary",
    "magnitude_db",
    "phase_rad",
    "at_pole",
    "natural_frequencies_hz",
    "families",
    "multiplicities",
}
CROSSING_KEYS = {
    "speed_rpm",
    "speed_rad_per_s",
    "order",
    "harmonic",
    "frequency_hz",
    "family",
    "multiplicity",
    "excited",
}
_PAIR = ("--from", "screw u", "--to", "nut u")
_FAMILIES = ("carrier", "torsional", "transverse", "roller")


def test_response_json_agrees_with_python(prsm_json):
    found = prsm_json(
        "response", "wu2022", *_PAIR, "--fmin", 100, "--fmax", 1e4, "--points", 5, "--ratio", 0.02
    )
    assert found.keys() >= RESPONSE_KEYS
    assert (found["damping"], found["unit"]) == ("modal", "m/N")
    hertz = np.geomspace(100, 1e4, 5)
    np.testing.assert_allclose(found["frequency_hz"], hertz, rtol=1e-14)
    expected = prsm_jax.frequency_response(
        scenes.example("wu2022"), "screw u", "nut u", hertz, damping=ModalDamping(0.02)
    )
    np.testing.assert_allclose(found["real"], expected.value.real, rtol=1e-9)
    np.testing.assert_allclose(found["imaginary"], expected.value.imag, rtol=1e-9)
    np.testing.assert_allclose(found["magnitude_db"], expected.decibel, rtol=1e-12)
    assert len(found["natural_frequencies_hz"]) == 17


def test_a_pole_is_null_in_json_and_said_in_the_table(prsm, prsm_json):
    at_rest = prsm_json("response", "wu2022", *_PAIR, "--fmin", 0, "--fmax", 10, "--points", 2)
    assert at_rest["frequency_hz"] == [0, 10]
    assert at_rest["at_pole"] == [False, False]
    assert at_rest["damping"] is None
    status, out, err = prsm("response", "wu2022", *_PAIR, "--points", "5")
    assert (status, err) == (0, "")
    assert "inf" in out
    assert "no damping" in out
    status, out, _ = prsm("response", "wu2022", "--from", "screw u", "--to", "nut x", "--points", 5)
    assert status == 0
    assert "by symmetry a force at screw u does not move nut x" in out


def test_campbell_json_and_table(prsm, prsm_json):
    found = prsm_json("campbell", "wu2022", "--max-rpm", "6000")
    assert found["max_speed_rpm"] == pytest.approx(6000)
    assert found["carrier_ratio"] == pytest.approx(0.374132, abs=1e-6)
    names = [order["name"] for order in found["orders"]]
    assert names[-1] == "ring_gear_mesh"
    speeds = [crossing["speed_rpm"] for crossing in found["crossings"]]
    assert speeds == sorted(speeds)
    assert max(speeds) <= 6000
    assert all(crossing.keys() >= CROSSING_KEYS for crossing in found["crossings"])
    assert {crossing["excited"] for crossing in found["crossings"]} == {True, False}
    _, out, _ = prsm("campbell", "wu2022", "--max-rpm", "6000")
    assert "roller_passing_screw" in out
    assert out.count(" yes") == sum(crossing["excited"] for crossing in found["crossings"])
    assert " no\n" not in out
    _, every, _ = prsm("campbell", "wu2022", "--max-rpm", "6000", "--every")
    assert every.count(" no\n") == sum(not crossing["excited"] for crossing in found["crossings"])
    _, none, _ = prsm("campbell", "wu2022", "--max-rpm", "1", "--orders", "carrier")
    assert "none" in none


def test_no_picture_without_a_crossing_is_said_with_the_speed_of_the_lowest(prsm, tmp_path):
    """At a little more than that speed the crossing is in the table and in the picture."""
    folder = tmp_path / "out"
    words = ("campbell", "wu2022", "--orders", "thread_passing", "--out", folder)
    status, out, _ = prsm(*words, "--max-rpm", 1)
    assert status == 0
    said = " ".join(out.split())
    assert "No picture: no order meets a natural frequency up to 1 rpm; give a higher" in said
    assert not folder.exists()
    named = re.search(r"The lowest is ([\d.]+) rpm, where harmonic 3 of thread_passing meets", said)
    assert named is not None, said
    status, out, _ = prsm(*words, "--max-rpm", 1.001 * float(named[1]))
    assert status == 0
    assert "The lowest" not in out
    assert named[1] in out
    assert "picture: " in out


def test_pictures_are_written(prsm, tmp_path):
    folder = tmp_path / "out"
    status, out, _ = prsm("campbell", "wu2022", "--max-rpm", "6000", "--out", folder)
    assert status == 0
    assert "picture: " in out
    status, out, _ = prsm(
        "response", "wu2022", *_PAIR, "--points", "50", "--ratio", "0.02", "--out", folder
    )
    assert status == 0
    assert "picture: " in out
    assert {path.name for path in folder.iterdir()} >= {"campbell.png", "response.png"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("response", "wu2022", "--from", "screw z"), "choose one of screw x"),
        (("response", "wu2022", "--points", "1"), "--points 1: must be a whole number from 2 to"),
        (("response", "wu2022", "--fmin", "10", "--fmax", "5"), "fmin below fmax"),
        (("response", "wu2022", "--ratio", "1"), "less than 1"),
        (("response", "wu2022", "--stage", "2"), "has 1 stage"),
        (("campbell", "wu2022", "--max-rpm", "0"), "must be more than 0"),
        (("campbell", "wu2022", "--orders", "belt"), "choose one of carrier"),
        (
            ("campbell", "wu2022", "--harmonics", "0"),
            "--harmonics 0: must be a whole number from 1 to",
        ),
        (("campbell", "li2020_two_stage"), "the screw has neither mass"),
    ],
)
def test_one_line_says_what_is_wrong(prsm, words, message):
    status, out, err = prsm(*words)
    assert (status, out) == (2, "")
    assert err.startswith("prsm: ")
    assert message in err
    assert err.count("\n") == 1


def test_the_table_shows_resonances_where_the_mode_takes_part(prsm, prsm_json):
    """Rotations of the actuator: torsional modes only; a limit at all others, as beside them."""
    pair = ("response", "actuator", *_PAIR)
    status, out, _ = prsm(*pair, "--points", 3)
    assert status == 0
    rows = [line.split() for line in out.splitlines() if line.startswith(_FAMILIES)]
    assert {row[3] for row in rows if row[0] == "torsional"} <= {"∞", "inf"}
    shown = [float(row[3]) for row in rows if row[0] != "torsional"]
    assert len(shown) == 6
    assert "no damping, so infinite at resonance" in out
    assert "Finite: the modes of this frequency do not connect the two places" in " ".join(
        out.split()
    )
    found = prsm_json(*pair, "--fmin", 10, "--fmax", 20, "--points", 2)
    hertz = np.array(found["natural_frequencies_hz"])
    still = [k for k, name in enumerate(found["families"]) if name != "torsional"]
    for share in (1 - 1e-6, 1 + 1e-6):
        beside = prsm_jax.frequency_response(
            scenes.example("actuator"), "screw u", "nut u", np.unique(hertz[still]) * share
        )
        # A double root may differ in its last digit: the same to four decimals, then listed once.
        listed = list(dict.fromkeys(np.round(np.asarray(beside.decibel), 2)))
        np.testing.assert_allclose(listed, shown, atol=6e-3)
    at = prsm_json(*pair, "--fmin", hertz[1], "--fmax", hertz[2], "--points", 2)
    assert at["at_pole"] == [True, False]
    assert at["real"][0] is None
    assert at["magnitude_db"][1] == pytest.approx(-170.239, abs=1e-3)
    _, out, _ = prsm("response", "wu2022", "--from", "screw u", "--to", "nut x", "--points", 5)
    assert "no damping" not in out
