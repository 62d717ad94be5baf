"""The shipped examples hold the papers' numbers."""

import re

import numpy as np
import pytest

import prsm_jax.file as file
from tests.present import present

NAMES = (
    "actuator",
    "actuator_axis",
    "actuator_load_sharing",
    "actuator_mission",
    "actuator_part_errors",
    "actuator_tolerances",
    "differential_stage",
    "humanoid_leg",
    "li2020_single_stage_viscous",
    "li2020_two_stage",
    "li2021_two_stage",
    "lisowski2014",
    "recirculating_stage",
    "ring_roller",
    "wu2022",
)


def test_names():
    assert file.example_names() == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_each_says_where_its_numbers_come_from(name):
    text = file.example_text(name)
    assert "Source: " in text or "All numbers are assumptions" in text
    assert file.load(name).title


@pytest.mark.parametrize(
    ("name", "speed", "load", "stages", "rollers"),
    [
        ("actuator", 50 * np.pi, 12e3, 1, 10),
        ("actuator_load_sharing", 50 * np.pi, 12e3, 1, 10),
        ("actuator_part_errors", 50 * np.pi, 12e3, 1, 10),
        ("li2020_single_stage_viscous", 1.0, 100.0, 1, 7),
        ("li2020_two_stage", 100.0, 7e3, 2, 7),
        ("li2021_two_stage", 100.0, 5e3, 2, 7),
        ("lisowski2014", 100 * np.pi / 3, 1e3, 1, 10),
        ("ring_roller", 100.0, 2.75e3, 1, 5),
        ("wu2022", 100.0, 7e3, 1, 7),
    ],
)
def test_operating_points(name, speed, load, stages, rollers):
    mechanism = file.load(name)
    assert float(mechanism.operating_point.speed) == pytest.approx(speed, rel=1e-15)
    assert float(mechanism.operating_point.load) == load
    assert mechanism.operating_point.duration is not None
    assert [stage.roller_count for stage in mechanism.stages] == [rollers] * stages


@pytest.mark.parametrize("name", NAMES)
def test_friction_is_there_for_a_steady_state(name):
    for stage in file.load(name).stages:
        assert stage.friction.thread is not None
        assert stage.material is not None
        assert stage.engaged_threads is not None


def test_radii_of_the_papers():
    radii = {
        name: [
            (
                float(s.thread.screw_radius),
                float(s.thread.roller_radius),
                float(s.thread.nut_radius),
            )
            for s in file.load(name).stages
        ]
        for name in NAMES
    }
    small, large = (9.75e-3, 3.25e-3, 16.25e-3), (16.5e-3, 5.5e-3, 27.5e-3)
    np.testing.assert_allclose(radii["li2020_two_stage"], [small, large])
    np.testing.assert_allclose(radii["li2021_two_stage"], [small, large])
    np.testing.assert_allclose(radii["lisowski2014"], [(15e-3, 5e-3, 25e-3)])
    np.testing.assert_allclose(radii["wu2022"], [(12e-3, 4e-3, 20e-3)])
    ring = file.load("ring_roller").stages[0]
    assert float(ring.line_contact.centre_distance) == 0.02
    np.testing.assert_allclose(ring.thread.centre_distance, 0.02)


def test_wu2022_columns_give_the_reference_frequencies():
    """The order of Table 4's columns, by a dense model that is independent of the package's.

    Its inertias are all m r², so the equivalent masses in rotation equal the masses.
    """
    stage = file.load("wu2022").stages[0]
    count, thread = stage.roller_count, stage.thread
    roller_radius, starts = float(thread.roller_radius), float(thread.starts)
    tangent = float(thread.lead) / (2 * np.pi * starts * roller_radius)
    helix = 1 / (1 + tangent**2)
    bodies = (
        (stage.screw, starts - 2, float(present(stage.stiffness.screw_roller)) * helix, -1, 1),
        (stage.ring_gear, starts, float(present(stage.stiffness.ring_roller)), 1, -1),
        (stage.nut, starts, float(present(stage.stiffness.nut_roller)) * helix, 1, -1),
    )
    stiffness, mass = np.zeros((count + 10, count + 10)), np.zeros(count + 10)
    for index, (body, ratio, mesh, turn, sign) in enumerate(bodies):
        at = slice(3 * index, 3 * index + 3)
        radial = float(present(body.support.radial_stiffness))
        stiffness[at, at] = np.diag(
            [radial, radial, float(present(body.support.torsional_stiffness))]
        )
        equivalent = float(present(body.inertia)) / (ratio * roller_radius) ** 2
        assert equivalent == pytest.approx(float(present(body.mass)), rel=1e-3)
        mass[at] = float(present(body.mass)), float(present(body.mass)), equivalent
        for i in range(count):
            angle = turn * 2 * np.pi * i / count
            direction = np.zeros(count + 10)
            direction[at] = -np.sin(angle), np.cos(angle), 1
            direction[9 + i] = sign
            stiffness += mesh * np.outer(direction, direction)
    mass[9 : 9 + count] = float(present(stage.roller.inertia)) / roller_radius**2
    circle = ((starts - 1) * roller_radius) ** 2
    mass[-1] = float(present(stage.carrier.inertia)) / circle + count * float(
        present(stage.roller.mass)
    )
    stiffness[-1, -1] = float(present(stage.carrier.support.torsional_stiffness))
    squares = np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(mass, mass)))
    expected = [293.3, 839.1, *[2262.2] * 2, *[3604.0] * 2, 4847.5, 13856.5, *[21761.9] * 2]
    expected += [*[22838.8] * 4, 27273.8, *[34523.4] * 2]
    np.testing.assert_allclose(np.sqrt(squares) / (2 * np.pi), expected, atol=0.06)


def test_no_example_copies_a_misprint():
    stage = file.load("wu2022").stages[0]
    assert stage.thread.roller_profile_radius is None
    assert float(stage.thread.starts) == 5
    assert re.search("misprint", file.example_text("wu2022"))
