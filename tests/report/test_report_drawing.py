"""The drawing is the mechanism: every circle and every flank has the size it should have."""

import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from matplotlib.patches import Circle
from report_checks import assert_printable

from prsm_jax import set_parameter
from prsm_jax.file import load
from prsm_jax.mechanism import UnequalRoller
from prsm_jax.report import cross_section
from prsm_jax.report.drawings._drawing_dimensions import drawing_dimensions
from prsm_jax.report.drawings._thread_profile import (
    nut_half_thickness,
    nut_profile,
    nut_shift,
    roller_half_thickness,
    roller_profile,
    screw_half_thickness,
    screw_profile,
    screw_shift,
    tooth_centres,
)


@pytest.fixture(scope="module")
def larger(actuator):
    return set_parameter(set_parameter(actuator, "roller_radius", 4.4e-3), "lead", 14e-3)


@pytest.fixture(scope="module")
def both(actuator, larger):
    return cross_section({"Before": actuator, "After": larger})


def _circles(axes):
    found: dict[str, list] = {}
    for patch in axes.patches:
        if isinstance(patch, Circle):
            found.setdefault(str(patch.get_label()), []).append(patch)
    return found


@pytest.mark.parametrize("scale", [1.0, 0.25])
def test_no_words_of_the_section_lie_on_lines_or_on_each_other(actuator, scale):
    """Also with a gear and a carrier that are narrow."""
    stage = actuator.stages[0]
    for name, width in (
        ("stage.gear.face_width", stage.gear.face_width),
        ("stage.carrier.length", stage.carrier.length),
    ):
        actuator = set_parameter(actuator, name, scale * float(width))
    figure = cross_section({"": actuator})
    figure.draw_without_rendering()
    axes = next(a for a in figure.axes if any("broken off" in t.get_text() for t in a.texts))
    words = [t for t in axes.texts if t.get_text()]
    boxes = {t.get_text(): t.get_window_extent() for t in words}
    below = {w: b for w, b in boxes.items() if w.startswith(("gear", "carrier", "screw", "roller"))}
    assert len(below) >= 4
    for name, box in below.items():
        for other, second in boxes.items():
            assert name == other or not box.overlaps(second), (name, other)
        for line in axes.lines:
            along = np.asarray(line.get_xdata())
            if len(along) == 2 and along[0] == along[1]:
                path = axes.transData.transform(np.column_stack([along, line.get_ydata()]))
                apart = path[0, 0] < box.x0 or path[0, 0] > box.x1
                apart |= max(path[:, 1]) < box.y0 or min(path[:, 1]) > box.y1
                # The words over the dimension of the roller hide the lines behind them.
                assert apart or name.startswith("roller"), name


def test_missing_and_displaced_rollers_are_seen(wu2022):
    rollers = (
        UnequalRoller(3, position_offset=jnp.asarray(0.1)),
        UnequalRoller(5, missing=True),
    )
    moved = eqx.tree_at(lambda m: m.stages[0].unequal_roller, wu2022, rollers)
    figure = cross_section({"damaged": moved})
    assert_printable(figure)
    circles = next(_circles(axes) for axes in figure.axes if "roller" in _circles(axes))
    angles = sorted(math.atan2(r.center[1], r.center[0]) % (2 * math.pi) for r in circles["roller"])
    places = 2 * math.pi * np.array([0, 1, 2, 3, 5, 6]) / 7
    assert angles == pytest.approx(places + np.array([0, 0, 0.1, 0, 0, 0]), abs=1e-12)
    (empty,) = circles["empty place"]
    angle = math.atan2(empty.center[1], empty.center[0]) % (2 * math.pi)
    assert angle == pytest.approx(2 * math.pi * 4 / 7)
    assert any("N = 6 rollers in 7 places" in text.get_text() for text in figure.texts)


def test_circles_have_the_radii_of_the_mechanism(both, actuator, larger):
    views = [axes for axes in both.axes if "roller" in _circles(axes)]
    for axes, mechanism in zip(views, (actuator, larger), strict=True):
        circles, stage = _circles(axes), mechanism.stages[0]
        thread = stage.thread
        expected = {
            "screw": thread.screw_radius,
            "bore": stage.screw.bore_radius,
            "nut thread": thread.nut_radius,
            "nut outside": thread.nut_radius + stage.nut.wall_thickness,
            "ring gear outside": thread.nut_radius + stage.ring_gear.wall_thickness,
        }
        for name, radius in expected.items():
            assert circles[name][0].get_radius() == pytest.approx(1e3 * float(radius))
        assert len(circles["roller"]) == stage.roller_count
        for roller in circles["roller"]:
            assert roller.get_radius() == pytest.approx(1e3 * float(thread.roller_radius))
            distance = math.hypot(*roller.center)
            assert distance == pytest.approx(1e3 * float(thread.centre_distance))


def test_all_views_of_a_row_have_one_scale(both):
    # Pixels per millimetre along both axes; the detail row has its own, larger scale.
    scales = []
    for axes in both.axes:
        across = axes.get_window_extent().width / np.ptp(axes.get_xlim())
        along = axes.get_window_extent().height / np.ptp(axes.get_ylim())
        assert across == pytest.approx(along, rel=1e-9)
        scales.append(across)
    transverse, axial, detail, *after = scales
    assert transverse == pytest.approx(axial, rel=1e-9)
    assert after == pytest.approx([transverse, axial, detail], rel=1e-9)
    assert detail > 2 * axial


def test_before_and_after_can_be_printed(both):
    assert_printable(both)
    assert both.get_size_inches()[0] * 25.4 == pytest.approx(180)


def test_a_mechanism_without_dimensions_says_what_is_missing(wu2022):
    assert_printable(cross_section({"Before": wu2022, "After": wu2022}))
    figure = cross_section({"Wu et al. 2022": wu2022})
    assert_printable(figure)
    words = " ".join(text.get_text() for text in figure.texts)
    assert "N = 7 rollers" in words
    for missing in ("nut wall", "screw length", "roller length", "nut length"):
        assert missing in words


@pytest.mark.parametrize("name", ["li2021_two_stage", "ring_roller", "lisowski2014"])
def test_other_mechanisms_can_be_printed(name):
    mechanism = load(name)
    number = len(mechanism.stages)
    assert_printable(cross_section({"one": mechanism}, stage=number))
    assert_printable(cross_section({"one": mechanism, "other": mechanism}, stage=number))


def test_dimensions_are_written_in_millimetres(both):
    words = {text.get_text() for axes in both.axes for text in axes.texts}
    assert {"a = 16", "Ø8 roller", "Ø24 screw", "Ø60 outside", "nut 80", "roller 50"} <= words
    assert {"gear 6", "carrier 4"} <= words
    # Ring gear 6 mm long with a rim of 4 mm about 40 mm; a carrier of 6 mm about 16 mm.
    assert "ring gear 6, ⌀48; carrier 4, ⌀26 to ⌀38" in words
    assert {"a = 17.6", "Ø8.8 roller", "Ø26.4 screw", "Ø64 outside"} <= words
    assert any("lead 14, 5 starts" in w for w in words)


def test_flanks_are_straight_and_the_roller_is_an_arc(actuator):
    dims = drawing_dimensions(actuator)
    heights = np.linspace(-0.3, 0.3, 9)
    straight = screw_half_thickness(dims, heights)
    slope = -math.tan(dims.flank_angle)
    np.testing.assert_allclose(np.diff(straight) / np.diff(heights), slope, rtol=1e-12)
    # Points of the flank lie on a circle of the profile radius about its centre.
    half = roller_half_thickness(dims, heights)
    radius, angle = dims.profile_radius, dims.flank_angle
    # Teeth are 0.05 mm thinner than half a pitch, by the file.
    centre = dims.pitch / 4 - 0.025 - radius * math.cos(angle)
    distance = np.hypot(half - centre, heights + radius * math.sin(angle))
    np.testing.assert_allclose(distance, radius, rtol=1e-12)


def test_threads_do_not_cut_into_each_other(actuator, larger):
    for mechanism in (actuator, larger):
        dims = drawing_dimensions(mechanism)
        # Over common heights a tooth and the gap that it stands in: thickness adds up to a pitch
        # at most.
        height = np.linspace(-dims.roller_dedendum, dims.roller_addendum, 21)
        room = dims.pitch / 2 - screw_half_thickness(dims, -height)
        thick = roller_half_thickness(dims, height)
        assert (thick <= room + 1e-12).all()
        # At the nominal radius it lacks the thinning of both.
        assert room[10] - thick[10] == pytest.approx((0.08 + 0.05) / 2, abs=2e-3)


def test_teeth_are_drawn_as_thin_as_the_file_says(actuator):
    """Thinned by 0.08, 0.05 and 0.01 mm; loaded flanks touch, and the play is at the others."""
    dims = drawing_dimensions(actuator)
    thin = (dims.screw_thinning, dims.roller_thinning, dims.nut_thinning)
    assert thin == pytest.approx((0.08, 0.05, 0.01))
    quarter = dims.pitch / 4
    screw, roller, nut = (
        float(half(dims, 0.0))
        for half in (screw_half_thickness, roller_half_thickness, nut_half_thickness)
    )
    assert [2 * (quarter - half) for half in (screw, roller, nut)] == pytest.approx(thin)
    # A roller tooth at 0 stands between screw teeth at half a pitch to either side.
    right = (2 * quarter + screw_shift(dims) - screw) - roller
    left = -roller - (-2 * quarter + screw_shift(dims) + screw)
    assert (right, left) == pytest.approx((0.0, 0.13))
    # Between nut teeth it is the other flank.
    right = (2 * quarter + nut_shift(dims) - nut) - roller
    left = -roller - (-2 * quarter + nut_shift(dims) + nut)
    assert (right, left) == pytest.approx((0.06, 0.0))


def test_the_single_start_roller_is_half_a_pitch_off_on_its_other_side(actuator):
    dims = drawing_dimensions(actuator)
    lower = tooth_centres(dims, -10.0, 10.0, shifted=False)
    upper = tooth_centres(dims, -10.0, 10.0, shifted=True)
    assert np.allclose(np.mod(upper - lower[0], dims.pitch), dims.pitch / 2)
    assert screw_profile(dims, upper)[1].max() == pytest.approx(
        dims.screw_radius + dims.screw_addendum
    )
    assert nut_profile(dims, lower)[1].min() == pytest.approx(dims.nut_radius - dims.screw_addendum)
    assert roller_profile(dims, upper, 1)[1].max() <= dims.nut_radius + dims.roller_addendum + 1e-9


def test_contact_points_come_from_the_meshing(actuator):
    dims = drawing_dimensions(actuator)
    assert dims.screw_contact is not None
    # Lead 10 mm, screw 24 mm, roller 8 mm, 45 degrees: 12.055213 mm at 2.995858 degrees.
    radius = math.hypot(dims.screw_contact.x, dims.screw_contact.y)
    assert radius == pytest.approx(12.055213, abs=1e-6)
    angle = math.degrees(math.atan2(dims.screw_contact.y, dims.screw_contact.x))
    assert angle == pytest.approx(-2.995858, abs=1e-6)


def test_wrong_requests_are_named(actuator):
    with pytest.raises(ValueError, match="one or two mechanisms, not 0"):
        cross_section({})
    with pytest.raises(ValueError, match="stage is 2"):
        cross_section({"one": actuator}, stage=2)
