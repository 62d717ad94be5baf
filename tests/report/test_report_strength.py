"""Charts of strength: readable, with units, and with the numbers of the laws."""

import jax.numpy as jnp
import numpy as np
import pytest
from report_checks import assert_printable, axis_labels

import prsm_jax as prsm
from prsm_jax.report import life_chart, shaft_limits_chart
from prsm_jax.strength import LoadSpectrum, buckling_load, permissible_speed


def test_life_of_a_duty_cycle(actuator):
    picture = life_chart(6e4, prsm.load_spectrum(actuator.duty_cycle), 9e4)
    assert_printable(picture)
    assert {
        "load in kN",
        "damage in %",
        "share of the turning in %",
        "basic rating life in turns",
    } <= set(axis_labels(picture))
    bars, damage, line = picture.axes
    heights = [patch.get_height() for patch in bars.patches]
    np.testing.assert_allclose(heights, sorted(heights, reverse=True))
    np.testing.assert_allclose(sum(patch.get_width() for patch in bars.patches), 100)
    np.testing.assert_allclose(sum(patch.get_height() for patch in damage.patches), 100)
    force, life = line.lines[0].get_data()
    np.testing.assert_allclose(life, 1e6 * (60 / np.asarray(force)) ** 3)


def test_life_of_many_samples_and_of_none():
    many = LoadSpectrum(1e3 * jnp.abs(jnp.sin(jnp.arange(400.0))), jnp.ones(400), jnp.ones(400))
    assert_printable(life_chart(2e4, many))
    idle = LoadSpectrum(jnp.zeros(2), jnp.ones(2), jnp.ones(2))
    with pytest.raises(ValueError, match="no load"):
        life_chart(2e4, idle)


def test_limits_of_the_shaft_pass_through_the_laws(actuator):
    stage = actuator.stages[0]
    picture = shaft_limits_chart(stage, load=18e3, speed=260.0)
    assert_printable(picture)
    buckling, speed = picture.axes
    chosen = [line for line in buckling.lines if "as given" in str(line.get_label())]
    length, load = chosen[0].get_data()
    expected = buckling_load(stage, jnp.asarray(length[40] * 1e-3))
    np.testing.assert_allclose(load[40], expected / 1e3)
    rpm = speed.lines[2].get_ydata()
    expected = permissible_speed(stage, jnp.asarray(length[90] * 1e-3)) * 30 / np.pi
    np.testing.assert_allclose(rpm[90], expected)
    assert "largest load" in " ".join(t.get_text() for t in buckling.texts)
    assert not shaft_limits_chart(stage).axes[0].texts
