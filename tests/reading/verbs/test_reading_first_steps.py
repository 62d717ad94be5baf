"""The verbs doctor and new: what they print, write and give as JSON, turned back to SI."""

import functools
import itertools
import json
import math
import re
import tomllib

import pytest
from expectations import reads
from reading_units import assert_reads

import prsm_jax
from prsm_jax.catalogue_sizes import catalogue_rows
from prsm_jax.cli import main
from prsm_jax.cli.verbs.first_steps import _doctor, _new
from prsm_jax.cli.verbs.first_steps._file_text import file_text
from prsm_jax.dimensioning import Dimensioning, Requirements
from prsm_jax.dimensioning._dimension import _mechanism
from prsm_jax.friction import CoulombFriction
from tests.present import present

_OPTIONS = ("--load", "11 kN", "--stroke", "310 mm", "--speed", "120 mm/s", "--life", "4000 h")
_OPTIONS += ("--envelope", "81 mm")
_ASKED = {"load": 11e3, "stroke": 0.31, "speed": 0.12, "life": 4000 * 3600.0, "envelope": 0.081}
_MARGINS = {
    "envelope": 1.27,
    "life": 1.31,
    "static_safety": 4.17,
    "buckling": 7.19,
    "critical_speed": 3.23,
    "dn_value": 1.43,
}
_ROW = catalogue_rows()[22]
_COARSE = next(row for row in catalogue_rows() if row["lead_mm"] / row["starts"] >= 3.5)


@pytest.fixture
def at(monkeypatch, tmp_path):
    """`at(fits)` replaces the search for a size by an answer of which no two numbers are alike."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PRSM_JAX_CACHE", "")
    monkeypatch.setattr(_new, "checked", lambda mechanism: ())

    def answer(fits):
        def dimension(**wanted):
            assert wanted == pytest.approx(_ASKED, rel=1e-15)
            asked = Requirements(**wanted)
            if fits:
                return Dimensioning(asked, _ROW, _mechanism(_ROW, asked), _MARGINS, {}, 90)
            relaxed = {"load": 4.56e3, "stroke": 0.123, "envelope": 0.0987}
            return Dimensioning(asked, None, None, {}, relaxed, 90)

        monkeypatch.setattr(_new, "dimension", dimension)
        return tmp_path

    return answer


def _lines(text: str) -> dict[str, str]:
    rows = (line.strip().partition("  ") for line in text.splitlines())
    return {label: value.strip() for label, _, value in rows}


@reads("verb", "new")
def test_new(at, capsys):
    folder = at(fits=True)
    assert main(["new", "mine.toml", *_OPTIONS]) == 0
    rows = _lines(capsys.readouterr().out)
    units = {"load": "N", "stroke": "m", "speed": "m/s", "life": "s", "envelope": "m"}
    for name, unit in units.items():
        assert_reads(rows[name], (_ASKED[name], unit))
    words = f"{_ROW['nominal_diameter_mm']:g} × {_ROW['lead_mm']:g} mm, {_ROW['starts']:g} starts"
    assert rows["size"] == words
    found = [float(value) for label, value in rows.items() if " / " in label]
    assert found == list(_MARGINS.values())
    assert "mine.toml has the design" in "\n".join(rows)
    assert "prsm check mine.toml" in rows

    text = (folder / "mine.toml").read_text(encoding="utf-8")
    table = tomllib.loads(text)
    point, stage = table["operating_point"], table["stage"][0]
    rpm = 120 * 60 / _ROW["lead_mm"]
    assert_reads(point["speed"], (rpm * 2 * 3.141592653589793 / 60, "rad/s", "coarse"))
    assert_reads(point["load"], (11e3, "N", "coarse"))
    duration = present(present(_mechanism(_ROW, Requirements(**_ASKED)).operating_point).duration)
    assert_reads(point["duration"], (float(duration), "s", "coarse"))
    assert_reads(stage["thread"]["lead"], (_ROW["lead_mm"] * 1e-3, "m", "coarse"))
    assert_reads(stage["strength"]["required_life"], (4000 * 3600, "s", "coarse"))
    length = 310 + _ROW["nut_length_mm"]
    shaft = stage["strength"]["shaft"]
    assert_reads(shaft["loaded_length"], (length * 1e-3, "m", "coarse"))
    # What the comments say, from the margins.
    for said in (
        "load 11 kN, stroke 310 mm, speed 120 mm/s, life 4000 h, envelope 81 mm",
        "the smallest of 90 sizes",
        "static capacity 8.34 times the load",
        "the buckling load is 14.4 times the load",
        "by the dynamic capacity it is 1.31 times as long",
        "the design has 69.9 % of it",
        f"{100 * 0.8 / 3.23:.3g} % of the critical speed",
        "in a bore of 81 mm",
    ):
        assert said in " ".join(text.replace("#", " ").split()), said


def test_every_number_of_a_new_file_has_a_comment(at):
    folder = at(fits=True)
    assert main(["new", *_OPTIONS]) == 0
    lines = (folder / "my_screw.toml").read_text(encoding="utf-8").splitlines()
    bare = [
        line
        for before, line in itertools.pairwise(lines)
        if " = " in line and "#" not in line and not before.startswith("#")
    ]
    # The word that names the law stands under the comment of its table.
    assert bare == ['law = "coulomb"']
    assert max(map(len, lines)) <= 99


def test_a_new_file_is_the_mechanism_to_six_digits(at):
    folder = at(fits=True)
    assert main(["new", *_OPTIONS]) == 0
    read = prsm_jax.load(folder / "my_screw.toml")
    made = _mechanism(_ROW, Requirements(**_ASKED))
    for one in prsm_jax.mechanism.all_parameters(made):
        value = one.get(made)
        if value is not None:
            assert float(one.get(read)) == pytest.approx(float(value), rel=5e-6), one.path


def _commented(text: str) -> dict[str, str]:
    """Comment of each number, by table and key."""
    found: dict[str, str] = {}
    table, above = "", ""
    for line in text.splitlines():
        if line.startswith("#"):
            above = f"{above} {line[1:].strip()}".strip()
            continue
        if line.startswith("["):
            table = line.strip("[]") + "."
        elif " = " in line:
            key, _, rest = line.partition(" = ")
            found[table + key] = rest.partition("#")[2].strip() or above
        above = ""
    return found


def _numbers(comment: str) -> list[float]:
    return [float(number) for number in re.findall(r"\d+\.?\d*(?:e-?\d+)?", comment)]


# A fine pitch, one of 2 mm, and the first of 3.5 mm or more.
@pytest.mark.parametrize("row", [_ROW, catalogue_rows()[0], _COARSE], ids=["2", "0.25", "coarse"])
def test_comments_of_a_new_file_say_the_rules_of_its_numbers(row):
    """Each value again from the numbers in its comment; 1e-4: values have six digits."""
    asked = Requirements(**_ASKED)
    made = _mechanism(row, asked)
    said = _commented(file_text(Dimensioning(asked, row, made, _MARGINS, {}, 90)))
    stage = made.stages[0]
    starts, pitch, nut = row["starts"], row["lead_mm"] / row["starts"], row["nut_length_mm"]
    close = functools.partial(pytest.approx, rel=1e-4)

    less, share = _numbers(said["stage.engaged_threads"])
    assert stage.engaged_threads * pitch == close(max(nut - less, share * nut))
    less, share = _numbers(said["stage.roller.length"])
    assert present(stage.roller.length) * 1e3 == close(max(nut - less, share * nut))
    (pitches,) = _numbers(said["stage.thread.roller_profile_radius"])
    assert present(stage.thread.roller_profile_radius) * 1e3 == close(pitches * pitch)
    circle = row["nominal_diameter_mm"] / 2 * (1 + 1 / (starts - 2))
    angle = math.asin((circle - row["nominal_diameter_mm"] / 2) / circle)
    (spare,) = _numbers(said["stage.roller_count"])
    assert stage.roller_count == math.floor(math.pi / angle + 1e-9) - spare
    factor, one = _numbers(said["stage.friction.thread.coefficient"])
    law = present(stage.friction).thread
    assert isinstance(law, CoulombFriction)
    assert law.coefficient == close(factor * (starts - one))
    strength = present(stage.strength)
    assert (strength.fatigue_rule, "equivalent balls" in said["stage.strength.fatigue_rule"]) == (
        "equivalent_balls",
        True,
    )
    assert said["stage.thread.contact_angle"] == "45 deg, the usual value"


def test_new_as_json(at, capsys):
    folder = at(fits=True)
    assert main(["new", "a.toml", *_OPTIONS, "--json", "-", "--out", "made/here"]) == 0
    found = json.loads(capsys.readouterr().out)
    keys = ("load_n", "stroke_m", "speed_m_per_s", "life_s", "envelope_m")
    assert found["requirements"] == pytest.approx(dict(zip(keys, _ASKED.values(), strict=True)))
    assert found["margins"] == _MARGINS
    assert found["size"] == _ROW
    assert (found["relaxed"], found["sizes"], found["errors"]) == ({}, 90, 0)
    assert found["file"] == "made/here/a.toml"
    assert (folder / "made" / "here" / "a.toml").is_file()


def test_new_without_a_size_says_what_to_relax(at, capsys):
    folder = at(fits=False)
    assert main(["new", *_OPTIONS]) == 1
    text = " ".join(capsys.readouterr().out.split())
    assert "No size of the catalogue fits" in text
    assert "load: at most 4.560 kN instead of 11.00 kN (58.5 % less)" in text
    assert "envelope: at least 98.70 mm instead of 81.00 mm (21.9 % more)" in text
    assert main(["new", *_OPTIONS, "--json", "-"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["file"] is None
    assert found["relaxed"] == {"load_n": 4.56e3, "stroke_m": 0.123, "envelope_m": 0.0987}
    assert not list(folder.iterdir())


@reads("verb", "doctor")
def test_doctor(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    cache = tmp_path / "cache"
    monkeypatch.setenv("PRSM_JAX_CACHE", str(cache))
    cache.mkdir()
    (cache / "one").write_bytes(b"x" * 1_234_567)
    import jax

    before = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
    # So that doctor keeps no programs of its own in it.
    monkeypatch.setattr(
        _doctor, "_devices", lambda *_: {"devices": [], "backend": "x", "precision": "y"}
    )
    try:
        assert main(["doctor", "--json", "-"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert main(["doctor"]) == 0
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
    assert found["cache"] == {"folder": str(cache), "files": 1, "size_bytes": 1_234_567}
    assert found["packages"]["jax"] == jax.__version__
    assert found["prsm_jax"] == prsm_jax.__version__
    text = capsys.readouterr().out
    assert f"{cache} (1 file, 1.2 MB)" in " ".join(text.split())
    assert f"jax {jax.__version__}" in " ".join(text.split())
    assert {one["extra"] for one in found["extras"]} >= {"cli", "file", "report", "sweep", "export"}
