"""Charts of strength: readable, with units, and with the numbers of the laws."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from report_checks import assert_printable, axis_labels
from truncation_scenes import screw_of_30_mm

import prsm_jax as prsm
from prsm_jax import strength
from prsm_jax.findings import StrengthCheck
from prsm_jax.mechanism import AxialPlay, DutyCycle
from prsm_jax.report import ReportData, life_chart, shaft_limits_chart
from prsm_jax.report.document._status_section import (
    label_of,
    limit_text,
    status_section,
    value_text,
)
from prsm_jax.report.document._strength_section import _strength_pictures, strength_section
from prsm_jax.report.interactive import shaft_limit_curves
from prsm_jax.strength import (
    LoadSpectrum,
    buckling_load,
    permissible_speed,
    preloaded_pair_loads,
    rating_life,
)


def test_life_of_a_duty_cycle(actuator):
    picture = life_chart(6e4, prsm.strength.load_spectrum(actuator.duty_cycle), 9e4)
    assert_printable(picture)
    assert {
        "load in kN",
        "damage in %",
        "share of the revolutions in %",
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


def test_life_and_damage_follow_ellipses_that_are_cut():
    """As the rating life of every single load, and of the phases; a straight line would not."""
    stage = screw_of_30_mm(3e-3).stages[0]
    capacity, fatigue = strength.dynamic_capacity(stage), strength.truncated_fatigue(stage)
    spectrum = LoadSpectrum(
        jnp.asarray([4e4, 3e5, 1.2e5]), jnp.asarray([4e3, 9.0, 3e2]), jnp.ones(3)
    )
    picture = life_chart(capacity, spectrum, 6e5, fatigue)
    assert_printable(picture)
    bars, damage, line = picture.axes
    force, life = (np.asarray(x) for x in line.lines[0].get_data())

    def lasts(load):
        alone = strength.constant_load(jnp.asarray(1.0), jnp.asarray(load))
        return float(rating_life(stage, capacity, alone, fatigue).revolutions)

    for place in (0, 20, 35, 49):
        np.testing.assert_allclose(life[place], lasts(1e3 * force[place]), rtol=1e-10)
    cube = 1e6 * (float(capacity) / (1e3 * force)) ** 3
    assert np.max(np.abs(life / cube - 1)) > 0.1
    together = float(rating_life(stage, capacity, spectrum, fatigue).revolutions)
    (mean,), (turns,) = line.lines[2].get_data()
    np.testing.assert_allclose(turns, together, rtol=1e-9)
    np.testing.assert_allclose(lasts(1e3 * mean), together, rtol=1e-9)
    np.testing.assert_allclose(bars.lines[0].get_ydata()[0], mean, rtol=1e-12)
    used = np.asarray(strength.damage(stage, capacity, spectrum, fatigue))
    order = np.argsort(-np.asarray(spectrum.load))
    heights = [patch.get_height() for patch in damage.patches]
    np.testing.assert_allclose(heights, 100 * used[order] / used.sum(), rtol=1e-9)


def test_a_report_draws_lives_with_the_ends_of_the_flanks():
    """The fatigue of the report is that of the quantities, shared loads included."""
    from prsm_jax.report.results._analyse import _strength

    one = screw_of_30_mm(3e-3, load=2e5)
    cycle = DutyCycle(jnp.ones(2), jnp.ones(2), jnp.asarray([3e5, 1e5]))
    one = eqx.tree_at(lambda m: m.duty_cycle, one, cycle, is_leaf=lambda x: x is None)
    values, fatigue = _strength(one)
    data = ReportData(one, "a title", strength=values, fatigue=fatigue)
    (picture,) = [p for p in strength_section(data).pictures if p.name == "life"]
    assert "same life" in picture.caption
    *_, line = picture.draw().axes
    np.testing.assert_allclose(
        line.lines[2].get_ydata()[0], float(values["rating_life"][0]), rtol=1e-9
    )


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


def test_a_screw_that_does_not_turn_has_no_speed_in_its_picture():
    """The report draws it from the demand, with a point for the load alone."""
    leg = prsm.load("humanoid_leg")
    (stage,) = leg.stages
    (drawn,) = _strength_pictures(ReportData(leg, "a title"))
    assert drawn.name == "shaft_limits"
    picture = drawn.draw()
    assert_printable(picture)
    (buckling,) = picture.axes
    assert "speed" not in " ".join([*axis_labels(picture), buckling.get_title()])
    chosen = next(line for line in buckling.lines if "as given" in str(line.get_label()))
    length, load = chosen.get_data()
    expected = buckling_load(stage, jnp.asarray(length[40] * 1e-3))
    np.testing.assert_allclose(load[40], expected / 1e3)
    # Heel strike, 6 kN.
    assert [t.get_text() for t in buckling.texts] == ["largest load\n6.000\u202fkN"]
    assert len(shaft_limit_curves(stage).panels) == 1


def test_the_life_in_a_report_is_drawn_with_the_preload(actuator):
    """On the flank that is loaded more; the table's life is that of both flanks together."""
    play = AxialPlay(preload_force=8e3)
    preloaded = eqx.tree_at(lambda m: m.stages[0].strength.play, actuator, play)
    capacity = jnp.asarray(6e4)
    life = rating_life(
        preloaded.stages[0], capacity, prsm.strength.load_spectrum(preloaded.duty_cycle)
    )
    values = {"dynamic_capacity": capacity[None], "rating_life": life.revolutions[None]}

    def drawn(one, given):
        section = strength_section(ReportData(one, "a title", strength=given))
        return [p for p in section.pictures if p.name == "life"]

    (picture,) = drawn(preloaded, values)
    assert "preload included" in picture.caption
    figure = picture.draw()
    assert_printable(figure)
    *_, line = figure.axes
    mean = 1e3 * float(line.lines[2].get_xdata()[0])
    spectrum = prsm.strength.load_spectrum(preloaded.duty_cycle)
    means = [
        float(np.cbrt(jnp.sum(spectrum.weights * load**3)))
        for load in preloaded_pair_loads(spectrum.load, jnp.asarray(8e3))
    ]
    np.testing.assert_allclose(mean, max(means), rtol=1e-12)
    both = sum((1e6 * (6e4 / x) ** 3) ** (-10 / 9) for x in means) ** -0.9
    np.testing.assert_allclose(life.revolutions, both, rtol=1e-12)
    # Without a life, as where the preload is not known, there is none to draw.
    assert drawn(preloaded, {"dynamic_capacity": capacity[None]}) == []
    (alone,) = drawn(actuator, values)
    assert "preload" not in alone.caption


def test_safety_and_pressures_name_their_loads():
    """At 3 kN the pressure is 2022 MPa, at heel strike, 6 kN, higher by the cube root of 2.

    So the static safety under 6 kN is (4200/2022)³ · 3/6 for the permissible 4200 MPa.
    """
    leg = prsm.load("humanoid_leg")
    data = ReportData(leg, "a title", checks=prsm.strength_checks(leg))
    table, *_ = status_section(data).tables
    cells = {row[0]: row[1].split() for row in table.rows}
    pressure, unit = cells["contact pressure at the operating point, equal sharing"]
    assert unit == "MPa"
    (safety,) = cells["static safety under the largest load"]
    assert float(safety) == pytest.approx((4200 / float(pressure)) ** 3 * 3 / 6, rel=2e-3)
    shared = StrengthCheck("max_pressure_shared", 1, 2e9, None, "Pa", True, None, "1", "no limit")
    assert label_of(shared) == "contact pressure at the operating point, most loaded thread"
    preloaded = dataclasses.replace(shared, name="preloaded_pressure")
    assert label_of(preloaded) == (
        "contact pressure at the operating point with preload, equal sharing"
    )


def test_jamming_is_a_coefficient_or_a_share_of_force():
    """Of rollers without lead no coefficient jams: the share is limited from below."""
    upper = StrengthCheck("jamming", 1, 0.05, 0.7, "1", True, 0.6, "1", "pass")
    lower = StrengthCheck("jamming", 1, 0.9, 0.3, "1", False, 0.6, "1", "pass")
    assert label_of(upper) == "friction coefficient (jamming)"
    assert limit_text(upper) == "at most 0.7000"
    assert label_of(lower) == "share of the axial thread force that carries load"
    assert limit_text(lower) == "at least 0.3000"


def test_a_load_of_zero_that_drag_holds_has_no_efficiency():
    """The power of drag over a vanishing load is no number that an engineer can use."""
    held = StrengthCheck("self_locking", 1, -7.9e30, None, "1", False, None, "1", "no limit")
    assert value_text(held) == "self-locking"
    unloaded = dataclasses.replace(held, value=np.nan)
    assert value_text(unloaded) == "not defined (no load)"
    assert value_text(dataclasses.replace(held, value=-0.3)).startswith("\N{MINUS SIGN}0.3")
