"""The chart of the loads around the screw: its colours, angles and words."""

import dataclasses
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
import reading_scenes as scenes
from expectations import reads
from reading_figures import Chart
from reading_units import assert_reads, label_unit

from prsm_jax.load_sharing import SideLoads
from prsm_jax.report import roller_force_chart
from tests.present import present

ANGLE = np.array([0.1, 2.0, 4.1])


def _distribution():
    found = scenes.distribution(classes=2)
    sides = {}
    for name, seed in (("screw", 1), ("nut", 2)):
        loads = jnp.asarray(np.random.default_rng(seed).uniform(10, 90, (3, 5)))
        sides[name] = SideLoads(
            forward=loads,
            reverse=loads / 7,
            max_pressure=loads,
            stiffness=jnp.ones(3),
            weight=jnp.ones(3),
        )
    return dataclasses.replace(
        found,
        **sides,
        rollers=((1,), (2,), (3,)),
        roller_angle=jnp.asarray(ANGLE),
        nut_radial_force=jnp.asarray([-30.0, 40.0]),
        nut_overturning_moment=jnp.asarray([0.0, -2.5]),
    )


@reads("chart", "roller_force_chart")
def test_loads_around_the_screw():
    found = _distribution()
    chart = Chart(roller_force_chart(found))
    screw, nut, bar = chart.axes
    assert label_unit(bar.get_ylabel()) == "N"
    chart.ignore([*bar.collections, *bar.patches, *bar.lines])
    largest = 8 / 7 * max(float(found.screw.forward.max()), float(found.nut.forward.max()))
    for axes, side in ((screw, found.screw), (nut, found.nut)):
        mesh: Any = axes.collections[0]
        assert len(axes.collections) == 1
        loads = np.asarray(side.forward) * 8 / 7
        # A sector consists of twelve pieces of one colour.
        colours = present(mesh.get_array()).reshape(5, 3, 12)
        np.testing.assert_allclose(colours, np.broadcast_to(loads.T[..., None], (5, 3, 12)))
        assert mesh.get_clim() == pytest.approx((0, largest))
        corners = np.asarray(mesh.get_coordinates())[0, ::12, 0]
        # Every roller stands in its own sector, and sectors fill the circle.
        assert np.all((corners[:-1] < ANGLE) & (corners[1:] > ANGLE))
        assert corners[-1] - corners[0] == pytest.approx(2 * np.pi)
        assert np.asarray(mesh.get_coordinates())[:, 0, 1] == pytest.approx(np.arange(6) + 0.5)
        assert chart.ticks(axes, "x") == ["1", "2", "3"]
        np.testing.assert_allclose(axes.get_xticks(), ANGLE)
        chart.take(mesh)
        # Net of both flanks, whose ratio is the same for all.
        sums = loads.sum(axis=1)
        below = [(sums.max() / sums.mean(), "1")]
        if axes is nut:
            below += [(50.0, "N"), (2.5, "N·m"), (1.5 * np.pi, "rad")]
        words = chart.text("largest over mean", place=axes)
        assert_reads(words.replace("\n", " "), *below)
    (line,) = nut.lines
    assert np.asarray(line.get_xdata()) == pytest.approx([np.arctan2(40, -30)] * 2)
    chart.take(line)
    title = chart.text("Loads of threads")
    assert_reads(title.removesuffix("; first thread inside"), (1512.0, "N"))
    chart.finish()


def test_equal_rollers_have_no_angles():
    with pytest.raises(ValueError, match="no angles of rollers"):
        roller_force_chart(scenes.distribution())
