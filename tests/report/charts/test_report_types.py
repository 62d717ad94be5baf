"""The drawing of every type of roller screw has its own radii, contacts and places of teeth."""

import math

import numpy as np
import pytest
from matplotlib.patches import Circle
from report_checks import assert_printable

from prsm_jax.file import load
from prsm_jax.report import cross_section, section_svg
from prsm_jax.report.drawings._drawing_dimensions import drawing_dimensions

#: Diameters of screw and nut from the comments of the files, and words on the drawing [mm].
TYPES = {
    "humanoid_leg": (20.0, 28.0, "nominal circle of the screw; contacts with the nut are"),
    "recirculating_stage": (20.0, 30.0, "Contacts with the screw and the nut are projected"),
    "differential_stage": (15.0, 25.0, "Contacts with the screw are projected"),
}


@pytest.mark.parametrize("name", TYPES)
def test_circles_words_and_contacts(name):
    screw, nut, words = TYPES[name]
    mechanism = load(name)
    figure = cross_section({mechanism.title: mechanism})
    assert_printable(figure)
    circles = {
        str(patch.get_label()): patch
        for axes in figure.axes
        for patch in axes.patches
        if isinstance(patch, Circle)
    }
    assert circles["screw"].get_radius() == pytest.approx(screw / 2)
    assert circles["nut thread"].get_radius() == pytest.approx(nut / 2)
    written = " ".join(text.get_text() for text in figure.texts)
    assert words in " ".join(written.split())
    labels = " ".join(text.get_text() for axes in figure.axes for text in axes.texts)
    assert ("screw and gear" in labels) == (name == "humanoid_leg")
    assert "nut and gear" not in labels


@pytest.mark.parametrize(("name", "has_gear"), [("actuator_axis", False), ("wu2022", True)])
def test_a_gear_is_named_only_where_the_file_has_one(name, has_gear):
    mechanism = load(name)
    stage = mechanism.stages[0]
    assert (stage.gear is not None) == has_gear
    figure = cross_section({mechanism.title: mechanism})
    labels = " ".join(text.get_text() for axes in figure.axes for text in axes.texts)
    written = " ".join(text.get_text() for text in figure.texts)
    assert f"Ø{2e3 * float(stage.thread.nut_radius):g} nut" in labels
    assert ("and gear" in labels) == has_gear
    assert ("pitch circle" in written) == has_gear
    # The studio and the DXF draw the same view.
    assert ("and gear" in section_svg(mechanism, 1)[0]) == has_gear


@pytest.mark.parametrize("name", TYPES)
def test_a_contact_lies_on_both_circles_of_its_bodies_nearly(name):
    """Aside of the line of centres where rollers slide, within a hundredth of a radius."""
    mechanism = load(name)
    dims = drawing_dimensions(mechanism)
    sliding = mechanism.stages[0].thread.family.sliding
    for side, radius in (("screw", dims.screw_radius), ("nut", dims.nut_radius)):
        point = getattr(dims, f"{side}_contact")
        assert math.hypot(point.x, point.y) == pytest.approx(radius, rel=1e-2)
        from_roller = math.hypot(point.x - dims.centre_distance, point.y)
        assert from_roller == pytest.approx(dims.roller_radius, rel=1e-2)
        assert (abs(point.y) > 0.01) == (side in sliding)


def test_grooves_lie_opposite_each_other_and_starts_do_not():
    """A single start is half a pitch further on the other side of a roller; a groove is not."""
    assert drawing_dimensions(load("humanoid_leg")).shifted_at_nut
    assert not drawing_dimensions(load("differential_stage")).shifted_at_nut


def test_an_inverted_nut_has_thread_along_all_of_its_length():
    """And its screw only between the gears of the rollers, 24 mm."""
    drawn = _outlines("humanoid_leg")
    nut, screw = drawn["nut"], drawn["screw"]
    # Crests of the nut lie on the smallest radius, those of the screw on the largest.
    crests = nut[nut[:, 1] < nut[:, 1].min() + 1e-6, 0]
    assert np.ptp(crests) > 113
    tips = screw[screw[:, 1] > screw[:, 1].max() - 1e-6, 0]
    assert 22 < np.ptp(tips) < 24


def _outlines(name):
    """Outlines in the half-section along the axis, by body [mm]."""
    mechanism = load(name)
    figure = cross_section({"": mechanism})
    found = {}
    for axes in figure.axes:
        for patch in axes.patches:
            label = str(patch.get_label())
            if label in ("nut", "screw", "roller") and not isinstance(patch, Circle):
                points = patch.get_xy()
                if label not in found or len(points) > len(found[label]):
                    found[label] = points
    return found
