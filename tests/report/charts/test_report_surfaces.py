"""Pressure maps and cuts of contacts of true surfaces."""

import dataclasses
import functools

import jax.numpy as jnp
import numpy as np
import pytest
from report_checks import assert_printable, axis_labels

from prsm_jax.contact import HertzContact, LineContactResult, SliceGeometry
from prsm_jax.halfspace import (
    FlankContact,
    FlankGap,
    Grid,
    SubsurfaceStress,
    SurfaceContact,
    TangentPlane,
)
from prsm_jax.mechanism import LineContact
from prsm_jax.report import (
    line_contact_chart,
    pressure_map,
    pressure_profiles,
    published_pressure,
    stress_section,
)
from prsm_jax.validation import PressureFigure, PressurePanel, PrintedEllipse, PrintedPressure


@functools.cache
def _contact() -> FlankContact:
    """A Hertz pressure written onto a grid, with a crest across it; nothing is solved."""
    grid = Grid((24, 20), 2e-5, 1.8e-5)
    x, y = grid.points
    major, minor, peak = 2e-4, 1.5e-4, 2e9
    inside = 1 - (x / major) ** 2 - (y / minor) ** 2
    edge = y + x / 4 + 1e-4
    pressure = jnp.where(edge > 0, peak * jnp.sqrt(jnp.maximum(inside, 0)), 0.0)
    zero, number = jnp.zeros(grid.shape), jnp.asarray
    surface = SurfaceContact(
        grid, pressure, pressure > 0, zero, zero, number(4e-6), number(126.0), number(2.2e9),
        number(9e-8), number(20), number(1e-9), number(0),
    )  # fmt: skip
    hertz = HertzContact(
        number(major), number(minor), number(peak), number(4e-6), *(number(1.0),) * 3
    )
    flanks = FlankGap(zero, edge > 0, edge, None)
    plane = TangentPlane(*(jnp.ones(3),) * 5)
    return FlankContact(surface, flanks, plane, hertz, number(1.4))


def test_map_shows_pressure_ellipse_and_edge():
    whole = dataclasses.replace(
        _contact(), flanks=dataclasses.replace(_contact().flanks, body_edge=None)
    )
    figure = pressure_map({"cut": _contact(), "whole": whole, "third": whole})
    assert_printable(figure)
    assert "contact pressure in MPa" in axis_labels(figure)
    cut, second, *_ = figure.axes
    assert "largest 2200 MPa, Hertz 2000 MPa, 126.0 N" in cut.get_xlabel().replace("\u202f", " ")
    (image,) = cut.images
    drawn = np.ma.filled(image.get_array(), np.nan)
    expected = np.where(_contact().surface.contact, _contact().surface.pressure * 1e-6, np.nan).T
    np.testing.assert_allclose(drawn, expected)
    np.testing.assert_allclose(image.get_extent(), [-0.24, 0.24, -0.18, 0.18])
    (ellipse,) = cut.patches
    assert (ellipse.width, ellipse.height) == pytest.approx((0.4, 0.3))
    assert cut.get_legend() is not None
    assert second.get_legend() is None


def test_published_pressures_stand_below_their_maps():
    """One scale for all; the printed values and their distance; both ellipses and the crest."""
    elements = PrintedPressure("elements", 1.1e9), PrintedPressure("Hertz", 2.2e9, 1.65e9)
    whole = dataclasses.replace(
        _contact(), flanks=dataclasses.replace(_contact().flanks, body_edge=None)
    )
    panels = (
        PressurePanel("cut", _contact(), elements, PrintedEllipse(3e-4, 1e-4, np.pi / 2)),
        PressurePanel("whole", whole, (PrintedPressure("elements", None),)),
        PressurePanel("bare", whole),
    )
    figure = published_pressure(PressureFigure("lisowski2014", "name", "Two rows", (panels,) * 2))
    assert_printable(figure)
    cut, second, third, *_ = figure.axes
    lines = cut.get_xlabel().replace("\u202f", " ").split("\n")
    assert lines == [
        "major axis in mm",
        "true flanks 2200 MPa",
        "paper, elements 1100 MPa, \u221250 %",
        "paper, Hertz 2200 (read 1650) MPa, \u221225 %",
    ]
    assert second.get_xlabel().endswith("paper, elements: none printed")
    hertz, printed = cut.patches
    assert (hertz.width, hertz.height, hertz.angle) == pytest.approx((0.4, 0.3, 0))
    assert (printed.width, printed.height, printed.angle) == pytest.approx((0.6, 0.2, 90))
    # The tall ellipse fits, and all panels have the same limits.
    assert 0.3 < cut.get_ylim()[1] < 0.4
    assert len({(axes.get_xlim(), axes.get_ylim()) for axes in figure.axes[:6]}) == 1
    assert len({axes.images[0].get_clim() for axes in figure.axes[:6]}) == 1
    assert cut.collections
    assert not third.collections
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "Hertz ellipse, curvatures of the flanks",
        "Hertz ellipse of the paper",
        "crest of a thread",
    ]


def test_profiles_show_cells_and_theory():
    figure = pressure_profiles({"cut": _contact()})
    assert_printable(figure)
    assert axis_labels(figure) == [
        "along the major axis in mm",
        "contact pressure in MPa",
        "along the minor axis in mm",
    ]
    theory, cells = figure.axes[0].lines[:2]
    assert np.max(theory.get_ydata()) == pytest.approx(2000, rel=1e-3)
    # Beside the axis by half a cell: a little less than on it.
    assert 1900 < np.nanmax(cells.get_ydata()) < 2000


def test_section_shows_the_largest_stress():
    grid, depths = Grid((16, 12), 2e-5, 2e-5), jnp.asarray([0.0, 2e-5, 6e-5, 1e-4])
    tensor = jnp.zeros((4, 16, 12, 3, 3)).at[..., 0, 0].set(1e6)
    stress = SubsurfaceStress(grid, depths, tensor.at[2, 4, 7, 0, 0].set(9e8))
    for along, position, title in (("x", -0.07, "y = 0.0300"), ("y", 0.03, "x = −0.0700")):
        figure = stress_section(stress, along)  # pyright: ignore[reportArgumentType]
        assert_printable(figure)
        axes = figure.axes[0]
        assert f"section at {title}" in axes.get_title(loc="left")
        (mark,) = (line for line in axes.lines if line.get_marker() == "+")
        assert mark.get_xdata()[0] == pytest.approx(position)
        assert mark.get_ydata()[0] == pytest.approx(0.06)
        assert "largest 900.0" in axes.get_xlabel()


@pytest.mark.usefixtures("unchecked")
def test_pictures_need_contacts_and_depths():
    grid = Grid((4, 4), 2e-5, 2e-5)
    one = SubsurfaceStress(grid, jnp.zeros(1), jnp.zeros((1, 4, 4, 3, 3)))
    with pytest.raises(ValueError, match="at least two"):
        stress_section(one)
    with pytest.raises(ValueError, match="choose 'x' or 'y'"):
        stress_section(one, "z")  # type: ignore[arg-type]
    for picture in (pressure_map, pressure_profiles):
        with pytest.raises(ValueError, match="at least one contact"):
            picture({})


def test_line_contact_shows_pressure_and_footprint():
    radius = jnp.linspace(8e-3, 10e-3, 41)
    number, share = jnp.asarray, jnp.linspace(-1.0, 1.0, 41)
    half = 5e-5 * jnp.sqrt(jnp.maximum(share, 0.0))
    pressure = 1e9 * jnp.sqrt(jnp.maximum(share, 0.0))
    slices = SliceGeometry(
        radius, jnp.full(41, -4e-4), 0 * radius, 0 * radius, 0 * radius, number(True)
    )
    line = LineContactResult(
        slices, pressure, half, pressure, half, *(number(1.0),) * 4, number(1e9), number(5e-5),  # pyright: ignore[reportCallIssue]
        number(0.5), *(number(1.0),) * 2, number(True),  # pyright: ignore[reportCallIssue]
    )  # fmt: skip
    flanks = LineContact(
        *(number(v) for v in (9e-3, 11e-3, 8e-3, 10e-3, 19e-3, 0.5, 0.5)),
    )
    alone = line_contact_chart(flanks, line)
    assert_printable(alone)
    figure = line_contact_chart(flanks, line, _contact().surface)
    assert_printable(figure)
    assert axis_labels(figure) == [
        "pressure at the middle in MPa",
        "distance from the roller axis in mm",
        "arc from the line of\ncentres in µm",
    ]
    above, below = figure.axes
    np.testing.assert_allclose(above.lines[0].get_ydata(), pressure * 1e-6)
    assert len(above.lines) == 2
    assert "50 % of the flank is loaded" in above.get_title(loc="left")
    low, high = below.get_ylim()
    assert low < -450 < -350 < high
