"""Charts of load sharing: every load at its place, axes with units, words that do not overlap."""

import jax.numpy as jnp
import numpy as np
import pytest
from report_checks import axis_labels, overlaps
from scenes import array
from sharing_scenes import chains

from prsm_jax.load_sharing import (
    Equilibrium,
    ForceDeflection,
    LoadDistribution,
    SideLoads,
    State,
)
from prsm_jax.report import force_deflection_chart, thread_load_chart


def _side(forward, reverse):
    weight = jnp.ones(len(forward))
    reverse = None if reverse is None else jnp.asarray(reverse)
    forward = jnp.asarray(forward)
    return SideLoads(forward, reverse, forward * 1e7, weight * 1e8, weight)


def _distribution(forward, reverse=None, rollers=((1, 2, 3),)):
    """A distribution with given loads; nothing is solved."""
    classes, threads = np.shape(forward)
    nothing = State(
        jnp.zeros((classes, threads)),
        jnp.zeros(threads),
        jnp.zeros((classes, threads - 1)),
        jnp.zeros(threads - 1),
    )
    found = Equilibrium(nothing, array(0.0), jnp.asarray(1), jnp.asarray(0))
    return LoadDistribution(
        _side(forward, reverse),
        _side(forward, reverse),
        load=array(1500.0),
        deflection=array(2e-5),
        tangent_stiffness=array(3e8),
        spacer_force=None,
        chains=chains(threads, (1.0,) * classes),
        equilibrium=found,
        converged=jnp.asarray(True),
        rollers=rollers,
    )


def test_bars_of_equal_rollers():
    forward = np.array([[90.0, 60.0, 30.0, 0.0]])
    reverse = np.array([[0.0, 0.0, 0.0, 12.0]])
    figure = thread_load_chart(_distribution(forward, reverse))
    for axes in figure.axes:
        heights = [bar.get_height() for bar in axes.patches]
        np.testing.assert_allclose(heights, [90, 60, 30, 0, 0, 0, 0, -12])
    labels = axis_labels(figure)
    assert "axial load in N" in labels
    assert any(label.startswith("thread, from the end") for label in labels)
    assert not overlaps(figure)


def test_a_map_of_unequal_rollers():
    forward = np.array([[90.0, 60.0, 30.0], [9.0, 6.0, 3.0]])
    figure = thread_load_chart(_distribution(forward, rollers=((1, 3), (2,))))
    image = figure.axes[0].images[0].get_array()
    np.testing.assert_allclose(image, forward[[0, 1, 0]])
    widths = [bar.get_width() for bar in figure.axes[1].patches]
    np.testing.assert_allclose(widths, [180, 18, 180])
    assert {"roller", "load of a roller in N", "axial load of a thread in N"} <= set(
        axis_labels(figure)
    )
    assert not overlaps(figure)


def test_maps_of_both_flanks():
    """What presses a roller on opposite flanks is seen on both, and does not cancel."""
    forward = np.array([[90.0, 60.0, 0.0], [9.0, 6.0, 3.0]])
    reverse = np.array([[90.0, 0.0, 30.0], [0.0, 0.0, 1.0]])
    figure = thread_load_chart(_distribution(forward, reverse, rollers=((1, 3), (2,))))
    pressed, opposite, sums = figure.axes[:3]
    for axes, loads in ((pressed, forward), (opposite, reverse)):
        (image,) = axes.images
        np.testing.assert_allclose(image.get_array(), loads[[0, 1, 0]])
        assert image.get_clim() == (0.0, 90.0)
    widths = [bar.get_width() for bar in sums.patches]
    np.testing.assert_allclose(widths, [150, 18, 150, -120, -1, -120])
    titles = [axes.get_title("left") for axes in figure.axes]
    assert {"screw side, forward flanks", "nut side, opposite flanks"} <= set(titles)
    assert not overlaps(figure)


def test_force_over_deflection():
    load = jnp.asarray([-10e3, -1e3, 1e3, 10e3])
    deflection = jnp.asarray([-3e-5, -1.2e-5, 0.2e-5, 2e-5])
    curve = ForceDeflection(load, deflection, jnp.full(4, 5e8), jnp.zeros(4), jnp.ones(4, bool))
    figure = force_deflection_chart({"backlash 10 µm": curve})
    above, below = figure.axes
    np.testing.assert_allclose(above.lines[0].get_xdata(), [-30, -12, 2, 20])
    np.testing.assert_allclose(above.lines[0].get_ydata(), [-10, -1, 1, 10])
    # The tangent at 10 kN and 500 N/µm meets the axis 20 µm before.
    np.testing.assert_allclose(above.lines[1].get_xdata(), [0, 20], atol=1e-9)
    np.testing.assert_allclose(below.lines[0].get_ydata(), 500)
    assert {"axial load in kN", "stiffness in N/µm"} <= set(axis_labels(figure))
    assert not overlaps(figure)
    with pytest.raises(ValueError, match="at least one curve"):
        force_deflection_chart({})
