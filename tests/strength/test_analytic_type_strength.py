"""Strength of every type of roller screw: cycles by counting, and what a held screw lacks."""

import dataclasses

import numpy as np
import pytest
from scenes import STEEL, array, example

from prsm_jax import strength
from prsm_jax._errors import MissingDataError
from prsm_jax.mechanism import (
    ROLLER_SCREW_TYPES,
    Nut,
    Roller,
    Screw,
    Stage,
    Thread,
    nut_unit_mass,
    stage_mass,
)


def _stage(kind):
    """Screw 20 or 12 mm and rollers 4 mm in diameter, eight of them."""
    free = kind in ("recirculating", "differential")
    thread = Thread(
        lead=2e-3,
        starts=1.0 if free else 5.0,
        roller_radius=2e-3,
        contact_angle=np.pi / 4,
        radius_ratio=5.0 if free else None,
    )
    return Stage(thread, 8, type=kind, material=STEEL, engaged_threads=10.0)


@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
def test_cycles_are_passes_of_rollers_at_ideal_rolling(kind):
    """Counted from the speeds of rigid bodies that roll without slip on their nominal circles."""
    stage = _stage(kind)
    screw, nut = float(stage.thread.screw_radius), float(stage.thread.nut_radius)
    turns = {"screw": 0.0, "nut": 1.0} if kind == "inverted" else {"screw": 1.0, "nut": 0.0}
    # Equal surface speeds of both bodies and the roller: Ω_s r_s + Ω_n r_n = 2 a ω.
    carrier = (turns["screw"] * screw + turns["nut"] * nut) / (screw + nut)
    roller = (carrier - turns["nut"]) * nut / 2e-3
    expected = 8 * abs(turns["screw"] - carrier), abs(roller), 8 * abs(turns["nut"] - carrier)
    found = [float(one) for one in strength.cycles_per_turn(stage)]
    np.testing.assert_allclose(found, expected, rtol=1e-14)


def test_a_screw_that_does_not_turn_has_no_critical_speed():
    """Its nut is limited by DN alone: 120,000 mm rpm over 20 mm."""
    (stage,) = example("humanoid_leg").stages
    with pytest.raises(MissingDataError, match="inverted roller screw does not turn"):
        strength.critical_speed(stage)
    limit = float(strength.permissible_speed(stage)) * 30 / np.pi
    assert limit == pytest.approx(6000.0, rel=1e-12)


@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
def test_what_moves_along_the_axis(kind):
    """The nut, or the screw of an inverted one, with all rollers; steel cylinders."""
    stage = dataclasses.replace(
        _stage(kind),
        screw=Screw(length=0.2),
        roller=Roller(length=0.03),
        nut=Nut(length=0.05, wall_thickness=6e-3),
    )
    screw, roller, nut = (
        np.pi * 7850 * (outer**2 - inner**2) * length
        for outer, inner, length in (
            (float(stage.thread.screw_radius), 0.0, 0.2),
            (2e-3, 0.0, 0.03),
            (float(stage.thread.nut_radius) + 6e-3, float(stage.thread.nut_radius), 0.05),
        )
    )
    moves = (screw if kind == "inverted" else nut) + 8 * roller
    assert float(nut_unit_mass(stage)) == pytest.approx(moves, rel=1e-14)
    assert float(stage_mass(stage)) == pytest.approx(screw + nut + 8 * roller, rel=1e-14)


def test_life_counts_the_travel_of_ideal_rolling():
    """A differential screw travels p (1 − r_s/2a) per turn: 5/8 of 2 mm with k = 5."""
    stage = _stage("differential")
    assert float(stage.thread.ideal_travel) == pytest.approx(2e-3 * 5 / 8, rel=1e-14)
    life = strength.rating_life(stage, array(1e4), strength.constant_load(array(10.0), array(1e3)))
    assert float(life.distance / life.revolutions) == pytest.approx(1.25e-3, rel=1e-14)
