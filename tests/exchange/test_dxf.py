"""Drawings as DXF, read by ezdxf: lengths and radii against the numbers of the mechanism."""

import dataclasses
import math
from collections import Counter

import numpy as np
import pytest
from ezdxf.filemanagement import readfile

import prsm_jax as prsm
from prsm_jax.exchange import write_dxf

#: Millimetres of a metre, and rounding: coordinates have 16 digits in the file.
MM, EXACT = 1e3, 1e-9


@pytest.fixture(scope="module")
def actuator():
    return prsm.load("actuator")


@pytest.fixture(scope="module")
def drawing(actuator, tmp_path_factory):
    """The file of the actuator, as a program reads it that knows nothing of this package."""
    path = tmp_path_factory.mktemp("dxf") / "actuator.dxf"
    assert write_dxf(path, actuator) == path
    assert [one.name for one in path.parent.iterdir()] == ["actuator.dxf"]
    return readfile(path)


def _entities(drawing, kind, layer):
    return list(drawing.modelspace().query(f'{kind}[layer=="{layer}"]'))


def _points(polyline):
    return np.array([point[:2] for point in polyline.get_points()])


def test_the_file_has_no_errors_and_is_in_millimetres(drawing):
    audit = drawing.audit()
    assert not audit.errors
    assert not audit.fixes
    assert drawing.units == 4  # millimetres, in the words of the format
    layers = {one.dxf.layer for one in drawing.modelspace()}
    bodies = {"SCREW", "ROLLER", "NUT", "RING_GEAR", "CARRIER"}
    assert layers == bodies | {"CENTRE_LINES", "DIMENSIONS", "HATCHING", "CONTACTS", "TEXT"}
    assert layers <= {one.dxf.name for one in drawing.layers}


def test_circles_have_the_radii_of_the_bodies(drawing, actuator):
    stage = actuator.stages[0]
    thread, half_width = stage.thread, stage.carrier.radial_width / 2
    radii = {
        "SCREW": [thread.screw_radius, stage.screw.bore_radius],
        "NUT": [thread.nut_radius, thread.nut_radius + stage.nut.wall_thickness],
        "RING_GEAR": [thread.nut_radius + stage.ring_gear.wall_thickness],
        "CARRIER": [thread.centre_distance - half_width, thread.centre_distance + half_width],
        "ROLLER": [thread.roller_radius] * stage.roller_count,
    }
    for layer, expected in radii.items():
        found = sorted(circle.dxf.radius for circle in _entities(drawing, "CIRCLE", layer))
        assert found == pytest.approx(sorted(MM * float(one) for one in expected), rel=EXACT)


def test_rollers_stand_around_the_screw(drawing, actuator):
    stage = actuator.stages[0]
    places = [
        complex(one.dxf.center.x, one.dxf.center.y)
        for one in _entities(drawing, "CIRCLE", "ROLLER")
    ]
    turns = np.exp(2j * np.pi * np.arange(stage.roller_count) / stage.roller_count)
    expected = MM * float(stage.thread.centre_distance) * turns
    assert np.abs(np.array(places) - expected).max() < 1e-9


def test_contacts_are_where_the_meshing_puts_them(drawing, actuator):
    meshing = prsm.mesh(actuator.stages[0].thread)
    places = [one.dxf.location for one in _entities(drawing, "POINT", "CONTACTS")]
    radii = Counter(round(math.hypot(x, y), 6) for x, y, _ in places)
    expected = [MM * float(side.contact_radius) for side in (meshing.screw, meshing.nut)]
    assert radii == {round(one, 6): actuator.stages[0].roller_count for one in expected}


def test_the_section_has_the_lengths_and_the_pitch(drawing, actuator):
    """The section lies to the right of the view; its screw is broken off."""
    stage = actuator.stages[0]
    lengths = {"NUT": stage.nut.length, "ROLLER": stage.roller.length}
    for layer, length in lengths.items():
        outline = max(map(_points, _entities(drawing, "LWPOLYLINE", layer)), key=len)
        assert np.ptp(outline[:, 0]) == pytest.approx(MM * float(length), rel=EXACT)
    outline = max(map(_points, _entities(drawing, "LWPOLYLINE", "SCREW")), key=len)
    crest = MM * float(stage.thread.screw_radius + stage.thread.screw_addendum)
    assert outline[:, 1].max() == pytest.approx(crest, rel=EXACT)
    # Both ends of each crest: the middles lie one pitch apart.
    ends = np.sort(outline[np.isclose(outline[:, 1], crest, atol=1e-9), 0])
    middles = (ends[::2] + ends[1::2]) / 2
    assert len(middles) > 10
    assert np.diff(middles) == pytest.approx(MM * float(stage.thread.pitch), rel=1e-9)


def test_dimensions_measure_what_their_words_say(drawing, actuator):
    stage = actuator.stages[0]
    thread = stage.thread
    expected = {
        "roller": 2 * thread.roller_radius,
        "a =": thread.centre_distance,
        "screw": 2 * thread.screw_radius,
        "nut and gear": 2 * thread.nut_radius,
        "outside": 2 * (thread.nut_radius + stage.nut.wall_thickness),
        "nut 80": stage.nut.length,
        "roller 50": stage.roller.length,
        "gear 6": stage.gear.face_width,
        "carrier": stage.carrier.length,
    }
    dimensions = {one.dxf.text: one.get_measurement() for one in _dimensions(drawing)}
    assert len(dimensions) == len(expected)
    # What a program shows where it measures again: millimetres, not hundredths of a metre.
    assert {one.get_dim_style().dxf.dimlfac for one in _dimensions(drawing)} == {1.0}
    for words, value in expected.items():
        text = max((one for one in dimensions if words in one), key=lambda one: -len(one))
        if words == "roller":
            text = "Ø8 roller"
        assert dimensions[text] == pytest.approx(MM * float(value), rel=EXACT), text
        number = "".join(c for c in text.split("carrier")[-1] if c.isdigit() or c == ".")
        assert float(number) == pytest.approx(MM * float(value), abs=5e-4)


def test_words_of_a_narrow_dimension_stand_beside_its_extension_lines(actuator, tmp_path):
    """Not over extension lines that are 1.5 mm apart."""
    narrow = prsm.set_parameter(actuator, "stage.gear.face_width", 1.5e-3)
    narrow = prsm.set_parameter(narrow, "stage.carrier.length", 1.58e-3)
    drawing = readfile(write_dxf(tmp_path / "narrow.dxf", narrow))
    found = {one.dxf.text: one for one in _dimensions(drawing)}
    for words in ("gear 1.5", "carrier 1.58"):
        one = found[words]
        ends = sorted([one.dxf.defpoint2.x, one.dxf.defpoint3.x])
        (text,) = [part for part in one.virtual_entities() if part.dxftype() == "MTEXT"]
        half = 0.8 * text.dxf.char_height * len(words) / 2
        middle = text.dxf.insert.x
        assert middle - half > ends[1] or middle + half < ends[0]


def test_a_gear_that_the_file_lacks_is_not_named(tmp_path):
    mechanism = prsm.load("actuator_axis")
    assert mechanism.stages[0].gear is None
    drawing = readfile(write_dxf(tmp_path / "axis.dxf", mechanism))
    words = [one.dxf.text for one in _dimensions(drawing)]
    assert "Ø40 nut" in words
    assert not [one for one in words if "gear" in one]


def _dimensions(drawing):
    return _entities(drawing, "DIMENSION", "DIMENSIONS")


def test_all_dimensions_stand_there_as_text(drawing, actuator):
    thread = actuator.stages[0].thread
    lines = [one.dxf.text for one in _entities(drawing, "TEXT", "TEXT")]
    said = dict(line.split(": ", 1) for line in lines if ": " in line)
    for name, value in {
        "lead": thread.lead,
        "pitch": thread.pitch,
        "roller profile radius": thread.profile_radius,
        "length of the screw": actuator.stages[0].screw.length,
    }.items():
        number, unit = said[name].split()
        assert unit == "mm"
        assert float(number) == pytest.approx(MM * float(value), abs=5e-4)


def test_what_is_not_given_is_said_and_codes_in_titles_do_nothing(tmp_path):
    """The other mechanism has a title with codes of DXF: a diameter sign, a line break."""
    mechanism = dataclasses.replace(prsm.load("wu2022"), title="50%%c\nof {\\Ppower}")
    drawing = readfile(write_dxf(tmp_path / "one.dxf", mechanism))
    lines = [one.dxf.text for one in _entities(drawing, "TEXT", "TEXT")]
    assert "50% %c of {\\Ppower}" in lines
    assert "not given: nut wall, screw length, roller length, nut length" in lines
    with pytest.raises(ValueError, match="stage"):
        write_dxf(tmp_path / "two.dxf", mechanism, stage=2)
    assert [one.name for one in tmp_path.iterdir()] == ["one.dxf"]
