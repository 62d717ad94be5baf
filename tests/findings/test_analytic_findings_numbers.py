"""Findings on masses and stiffnesses: each where it should appear, with its numbers, only there."""

import dataclasses
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import STEEL, example, stage, thread

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.findings import check, mass_findings
from prsm_jax.geometry import dimension_margins, dimension_names
from prsm_jax.mechanism import (
    Carrier,
    GivenStiffness,
    Material,
    Nut,
    RingGear,
    Roller,
    Screw,
    Support,
    UnequalRoller,
)

NAMES = {"inertia", "mass", "torsional_support", "negative_stiffness"}
#: J = ½ m (R² + r²) for a nut of 20 mm and 30 mm.
SOUND: dict[str, Any] = {
    "screw": Screw(mass=1.0, inertia=0.72e-4),
    "roller": Roller(mass=0.03, inertia=2.4e-7),
    "nut": Nut(mass=2.0, inertia=1.3e-3),
}


def _of_stiffness(mechanism):
    names = ("negative_stiffness", "torsional_support")
    return tuple(one for one in check(mechanism) if one.name in names)


def _mechanism(**bodies):
    return prsm.Mechanism((stage(**(SOUND | bodies)),))


def _inertias(**bodies):
    found = mass_findings(_mechanism(**bodies))
    return [finding for finding in found if finding.name == "inertia"]


def test_sound_bodies_have_none():
    mechanism = _mechanism()
    assert not mass_findings(mechanism)
    assert not _of_stiffness(mechanism)


@pytest.mark.parametrize(
    ("body", "part", "expected"),
    [
        # m r² with r = 12, 4 mm; half of it for the solid cylinder.
        ("screw", Screw(mass=1.0, inertia=1.44e-4), 0.72e-4),
        ("roller", Roller(mass=0.03, inertia=4.8e-7), 2.4e-7),
        # With a bore of 6 mm: ½ m (12² + 6²) mm².
        ("screw", Screw(mass=1.0, inertia=1.44e-4, bore_radius=6e-3), 0.9e-4),
        # Sleeve of 20 and 30 mm: ½ m (20² + 30²) mm².
        ("nut", Nut(mass=2.0, inertia=8e-4, wall_thickness=10e-3), 1.3e-3),
        # No wall is given: all that can be said is "more than m r²".
        ("nut", Nut(mass=2.0, inertia=8e-4), 8e-4),
        ("ring_gear", RingGear(mass=0.1, inertia=4e-5), 4e-5),
    ],
)
def test_inertia_of_a_thin_ring(body, part, expected):
    (found,) = _inertias(**{body: part})
    assert found.severity == "warning"
    assert found.value == float(part.inertia)
    assert found.limit == pytest.approx(expected, rel=1e-12)
    assert body.replace("_", " ") in found.message
    assert "m r²" in found.message
    assert f"stage.{body}.length" in found.message


@pytest.mark.parametrize("ratio", [1.03, 2.0, 1e3])
def test_more_than_a_cylinder_can_have(ratio):
    (found,) = _inertias(roller=Roller(mass=0.03, inertia=ratio * 4.8e-7))
    assert f"{ratio:.3g} m r², more than any cylinder" in found.message
    assert found.limit == pytest.approx(2.4e-7, rel=1e-12)


@pytest.mark.parametrize(
    ("body", "part"),
    [
        ("screw", Screw(mass=1.0, inertia=1.44e-5)),
        ("nut", Nut(mass=2.0, inertia=4e-4)),
        ("nut", Nut(mass=2.0, inertia=1e-2)),
        ("carrier", Carrier(mass=0.02, inertia=2e-5)),
    ],
)
def test_inertia_in_another_unit_or_mistyped(body, part):
    assert len(_inertias(**{body: part})) == 1


@pytest.mark.parametrize(
    ("body", "part"),
    [
        # A tube of 11.5 mm bore does have nearly m r², as has a sleeve of 0.2 mm wall, and
        # a carrier, which is centred on the circle of the roller axes.
        ("screw", Screw(mass=0.1, inertia=0.985 * 1.44e-5, bore_radius=11.8e-3)),
        ("nut", Nut(mass=0.1, inertia=4.04e-5, wall_thickness=0.2e-3)),
        ("carrier", Carrier(mass=0.02, inertia=0.02 * 16e-3**2)),
        # The second screw of Li et al. 2020 is hollow, with 0.83 m r².
        ("screw", Screw(mass=1.0, inertia=0.83 * 1.44e-4)),
        # What is not given cannot be wrong.
        ("screw", Screw(inertia=1.0)),
        ("screw", Screw(mass=1.0, length=0.3)),
    ],
)
def test_inertia_that_is_right_for_its_shape(body, part):
    assert not _inertias(**{body: part})


@pytest.mark.parametrize(
    ("factor", "found"), [(0.4, True), (0.6, False), (1.0, False), (1.9, False), (2.1, True)]
)
@pytest.mark.parametrize("density", [None, 2700.0])
def test_mass_against_length_and_density(factor, found, density):
    """π ρ l R² of a roller of 4 mm and 50 mm: 0.01973 kg at 7850 kg/m³."""
    mass = np.pi * 16e-6 * 0.05 * (7850.0 if density is None else density)
    roller = Roller(mass=factor * mass, length=0.05)
    material = Material(210e9, 0.3, density)
    reported = mass_findings(_mechanism(roller=roller, material=material))
    assert [finding.name for finding in reported] == ["mass"] * found
    if found:
        assert reported[0].limit == pytest.approx(mass, rel=1e-12)
        assert f"{factor:.3g} times" in reported[0].message


def _screw(stiffness, **more):
    screw = Screw(support=Support(torsional_stiffness=stiffness), **more)
    return {f.name: f for f in _of_stiffness(_mechanism(screw=screw))}


@pytest.mark.parametrize("length", [None, 0.3])
def test_torsional_support_against_the_shaft(length):
    """G I_p/(l r²) = G π r²/2l of a steel shaft of 24 mm, within a factor 3 at either end."""
    more = {} if length is None else {"length": length}
    shear = float(STEEL.youngs_modulus) / 2.6
    soft = shear * np.pi / 2 * 12e-3**2 / (0.72 if length is None else length)
    stiff = shear * np.pi / 2 * 12e-3**2 / 24e-3
    for inside in (soft / 2.9, soft, stiff, stiff * 2.9):
        assert not _screw(inside, **more)
    below = _screw(soft / 3.1, **more)["torsional_support"]
    assert below.limit == pytest.approx(soft, rel=1e-12)
    assert "3.1 times softer" in below.message
    above = _screw(stiff * 3.1, **more)["torsional_support"]
    assert above.limit == pytest.approx(stiff, rel=1e-12)
    assert "3.1 times stiffer" in above.message


def test_a_bore_makes_the_shaft_softer():
    whole = _screw(1e4, length=0.3)["torsional_support"].limit
    bored = _screw(1e4, length=0.3, bore_radius=9e-3)["torsional_support"].limit
    assert bored / whole == pytest.approx(1 - (9 / 12) ** 4, rel=1e-12)


def test_units_that_would_fit_are_named():
    """6.241e7 N/m in N/mm, and in N·m/rad 6.241e7 (12 mm)² = 8987."""
    assert "N/mm (6.24e+07 N/m)" in _screw(6.241e4)["torsional_support"].message
    assert "N·m/rad (6.24e+07 N/m)" in _screw(8987.0)["torsional_support"].message
    assert "read in" not in _screw(1.0)["torsional_support"].message


def test_no_torsional_support_is_no_finding():
    assert not _screw(0.0)
    screw = Screw(support=Support(radial_stiffness=1e8))
    assert not _of_stiffness(_mechanism(screw=screw))


def _past_checks(cls, springs):
    """A part with stiffnesses that construction refuses; a search may come there."""
    part = cls(**dict.fromkeys(springs, 1.0))
    values = [jnp.asarray(value) for value in springs.values()]
    return eqx.tree_at(lambda p: [getattr(p, name) for name in springs], part, values)


def _with(**changes):
    whole = example("wu2022")
    return dataclasses.replace(whole, stages=(dataclasses.replace(whole.stages[0], **changes),))


@pytest.mark.parametrize(
    ("changes", "name", "eigenvalues"),
    [
        # More than the meshes hold the nut with, in x and in y.
        ({"nut": {"radial_stiffness": -2e9}}, "stage.nut.support.radial_stiffness", 2),
        # Turned together without slip, nut and ring gear hold 9.359e6 + 3.380e6 N/m against it.
        ({"screw": {"torsional_stiffness": -1.4e7}}, "stage.screw.support.torsional", 1),
        ({"screw": {"torsional_stiffness": -1.2e7}}, "stage.screw.support.torsional", 0),
    ],
)
def test_negative_support(changes, name, eigenvalues):
    stage_ = example("wu2022").stages[0]
    bodies = {
        body: dataclasses.replace(getattr(stage_, body), support=_past_checks(Support, springs))
        for body, springs in changes.items()
    }
    found = [f for f in _of_stiffness(_with(**bodies)) if f.name == "negative_stiffness"]
    assert len(found) == 1
    assert found[0].severity == "error"
    assert name in found[0].message
    if eigenvalues:
        assert f"({eigenvalues} negative eigenvalue" in found[0].message
    else:
        assert "still outweigh" in found[0].message


def test_negative_mesh():
    """All N rollers then release energy: at least the N − 3 roller modes are unstable."""
    springs = {"screw_roller": -6e8, "nut_roller": 2.198e8, "ring_roller": 2.464e8}
    given = _past_checks(GivenStiffness, springs)
    (found,) = [f for f in _of_stiffness(_with(stiffness=given)) if f.name == "negative_stiffness"]
    assert found.value == -6e8
    assert "stage.stiffness.screw_roller is -6e+08 N/m" in found.message
    count = int(found.message.split("(")[1].split()[0])
    assert count >= 4
    # It cannot be made so, but a search may come there.
    roller = UnequalRoller(number=3, stiffness_factor=1.0)
    roller = eqx.tree_at(lambda one: one.stiffness_factor, roller, jnp.asarray(-1.0))
    names = [f.message for f in _of_stiffness(_with(unequal_roller=(roller,)))]
    assert any(
        "stiffness_factor of roller 3 is -1, a negative stiffness:" in message for message in names
    )


def test_negative_stiffness_without_the_data_for_a_matrix():
    support = _past_checks(Support, {"radial_stiffness": -1.0})
    found = _of_stiffness(prsm.Mechanism((stage(nut=Nut(mass=2.0, support=support)),)))
    assert [f.name for f in found] == ["negative_stiffness"]
    assert "can be indefinite" in found[0].message


@pytest.mark.parametrize("name", file.example_names())
def test_shipped_examples(name):
    """Only Table 4 of Wu et al. 2022 has such faults: inertias m r² and the screw's torsion."""
    found = [f.name for f in prsm.check(example(name)) if f.name in NAMES]
    assert found == (["inertia"] * 4 + ["torsional_support"] if name == "wu2022" else [])


def test_findings_come_stage_by_stage():
    bad = stage(13, geometry=thread(), **SOUND)
    worse = stage(**{**SOUND, "roller": Roller(mass=0.03, inertia=4.8e-7)})
    found = prsm.check(prsm.Mechanism((worse, bad)))
    assert [f.stage for f in found] == sorted(f.stage for f in found)
    assert {(f.name, f.stage) for f in found} >= {("inertia", 1), ("roller_clearance", 2)}


@pytest.mark.parametrize("name", ["wu2022", "lisowski2014"])
def test_names_of_dimensions_are_those_of_their_margins(name):
    given = prsm.load(name).stages[0].thread
    other = eqx.tree_at(
        lambda t: t.roller_profile_radius, given, jnp.asarray(0.01), is_leaf=lambda x: x is None
    )
    without = eqx.tree_at(lambda t: t.roller_profile_radius, other, None)
    for one in (other, without):
        assert dimension_names(one) == tuple(dimension_margins(one))


@pytest.mark.parametrize("example", ["actuator", "wu2022", "lisowski2014", "differential_stage"])
def test_margins_of_dimensions_have_the_units_of_their_numbers(example):
    """A unit of a margin that is not that of its number would be read as another value."""
    mechanism = prsm.load(example)
    dimensions = [one for one in prsm.findings.margins_of(mechanism) if one.name == "dimension"]
    assert len(dimensions) >= 4
    for one in dimensions:
        name = f"stage.{one.stage}.thread.{one.subject}"
        (number,) = prsm.mechanism.find_parameters(mechanism, name)
        assert (one.subject, one.unit) == (one.subject, number.unit)
