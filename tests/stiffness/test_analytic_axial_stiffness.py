"""Axial stiffnesses: secants and tangents of contacts, nut and axis, against closed forms."""

import dataclasses
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax.mechanism import LoadSharing, ScrewShaft, Strength, Support, ThreadTooth
from tests.present import present

NAMES = tuple(
    f"{part}_axial_stiffness_{kind}"
    for part in ("contact", "nut", "axis")
    for kind in ("secant", "tangent")
)
_compute = eqx.filter_jit(lambda m, names: prsm.compute(m, names))
#: One program for a pair of loads and all quantities.
_at_loads = eqx.filter_jit(
    lambda m, loads: [prsm.compute(m, (*NAMES, "axial_deflection"), load=one) for one in loads]
)
LENGTH, ROOT, BORE, YOUNG = 0.3, 11.4e-3, 4e-3, 210e9


def _mechanism(rigid=False, **supports):
    """The actuator's stage with a shaft and, where not `rigid`, elastic teeth and sections."""
    base = example("actuator")
    dedendum = 0.45e-3
    # Rigid: a million times stiffer than the contacts.
    bodies = ("screw", "roller", "nut") if rigid else ()
    stiff: dict[str, Any] = {f"{body}_segment_stiffness": 1e16 for body in bodies}
    sharing = LoadSharing(
        thread_count=20,
        tooth=None if rigid else ThreadTooth(0.8e-3, dedendum, dedendum, dedendum),
        **stiff,
    )
    stage = base.stages[0]
    screw = dataclasses.replace(stage.screw, bore_radius=BORE, support=supports.get("screw"))
    nut = dataclasses.replace(stage.nut, support=supports.get("nut"))
    shaft = ScrewShaft("fixed_supported", loaded_length=LENGTH, root_radius=ROOT)
    stage = dataclasses.replace(
        stage,
        load_sharing=sharing,
        screw=screw,
        nut=nut,
        strength=Strength(shaft=shaft),
    )
    return prsm.Mechanism((stage,), prsm.mechanism.OperatingPoint(100.0, 12e3))


@pytest.fixture(scope="module")
def elastic():
    return {k: float(v) for k, v in _compute(_mechanism(), NAMES).items()}


def test_without_the_table_contacts_alone_in_closed_form():
    """Two Hertz points in series, N z of them beside each other, from the approaches."""
    mechanism = example("actuator")
    stage = dataclasses.replace(mechanism.stages[0], load_sharing=None)
    mechanism = dataclasses.replace(mechanism, stages=(stage,), design_problem=None)
    names = ("contact_axial_stiffness_secant", "contact_axial_stiffness_tangent")
    found = _compute(mechanism, names)
    pair = prsm.thread_contacts(mechanism)[0]
    axial_force = 12e3 / (10 * 20)
    # Approaches are along the normal; work has F_n δ = F_a δ_a.
    travel = sum(
        float(side.hertz.approach * side.normal_force) / axial_force
        for side in (pair.screw, pair.nut)
    )
    assert float(found[names[0]]) == pytest.approx(12e3 / travel, rel=1e-12)
    assert float(found[names[1]]) == pytest.approx(1.5 * 12e3 / travel, rel=1e-12)


def test_given_stiffnesses_are_linear_springs():
    found = _compute(example("wu2022"), NAMES[:2])
    stage = example("wu2022").stages[0]
    springs = [
        float(present(stage.stiffness.screw_roller)),
        float(present(stage.stiffness.nut_roller)),
    ]
    expected = stage.roller_count / sum(1 / one for one in springs)
    for value in found.values():
        assert float(value) == pytest.approx(expected, rel=1e-14)


def test_rigid_shafts_and_teeth_leave_the_contacts():
    """Then the nut is its contacts: secants and tangents agree, and the tangent is 3/2."""
    found = {k: float(v) for k, v in _compute(_mechanism(rigid=True), NAMES).items()}
    # Segments a million times as stiff as a contact, in 19 places.
    near: dict[str, Any] = {"rel": 1e-5}
    assert found["nut_axial_stiffness_secant"] == pytest.approx(
        found["contact_axial_stiffness_secant"], **near
    )
    assert found["nut_axial_stiffness_tangent"] == pytest.approx(
        found["contact_axial_stiffness_tangent"], **near
    )
    ratio = found["contact_axial_stiffness_tangent"] / found["contact_axial_stiffness_secant"]
    assert ratio == pytest.approx(1.5, rel=1e-12)


@pytest.mark.parametrize("kind", ["secant", "tangent"])
def test_what_gives_way_in_more_places_is_softer(elastic, kind):
    contact, nut, axis = (
        elastic[f"{part}_axial_stiffness_{kind}"] for part in ("contact", "nut", "axis")
    )
    assert contact > nut > axis


@pytest.mark.parametrize("part", ["contact", "nut", "axis"])
def test_contacts_harden_so_tangents_are_larger(elastic, part):
    secant, tangent = (elastic[f"{part}_axial_stiffness_{kind}"] for kind in ("secant", "tangent"))
    # Teeth and shafts do not harden, so the ratio is below that of Hertz.
    assert secant < tangent < 1.5 * secant


def test_tangent_and_secant_of_the_nut_from_its_travel():
    loads = jnp.asarray([12e3, 12e3 * (1 - 1e-4), 12e3 * (1 + 1e-4)])
    here, below, above = _at_loads(_mechanism(), loads)
    travel = [float(one["axial_deflection"]) for one in (below, here, above)]
    slope = (float(loads[2]) - float(loads[1])) / (travel[2] - travel[0])
    # Central differences with steps of 1e-4: 1e-8 of truncation, 1e-9 of rounding.
    assert float(here["nut_axial_stiffness_tangent"]) == pytest.approx(slope, rel=1e-7)
    secant = 12e3 / travel[1]
    assert float(here["nut_axial_stiffness_secant"]) == pytest.approx(secant, rel=1e-12)


def test_the_axis_is_springs_in_series(elastic):
    shaft = YOUNG * np.pi * (ROOT**2 - BORE**2) / LENGTH
    supports: dict[str, Any] = {
        "screw": Support(axial_stiffness=3e8),
        "nut": Support(axial_stiffness=2e9),
    }
    held = _compute(_mechanism(**supports), NAMES[2:])
    for kind in ("secant", "tangent"):
        nut = elastic[f"nut_axial_stiffness_{kind}"]
        alone = 1 / (1 / nut + 1 / shaft)
        assert elastic[f"axis_axial_stiffness_{kind}"] == pytest.approx(alone, rel=1e-12)
        whole = 1 / (1 / nut + 1 / shaft + 1 / 3e8 + 1 / 2e9)
        assert float(held[f"axis_axial_stiffness_{kind}"]) == pytest.approx(whole, rel=1e-12)


def test_former_names_are_other_names_of_these():
    pairs = {
        "axial_stiffness": "contact_axial_stiffness_secant",
        "axial_stiffness_shared": "nut_axial_stiffness_tangent",
    }
    found = _compute(_mechanism(), tuple(pairs) + tuple(pairs.values()))
    words = {one.name: one.description for one in prsm.quantities.catalogue()}
    for former, name in pairs.items():
        assert float(found[former]) == float(found[name])
        assert name in words[former]


def test_names_say_secant_or_tangent_and_descriptions_what_gives_way():
    words = {one.name: one.description for one in prsm.quantities.catalogue() if one.name in NAMES}
    assert set(words) == set(NAMES)
    for name, text in words.items():
        assert ("secant F/x" in text) == name.endswith("secant")
        assert ("tangent dF/dx" in text) == name.endswith("tangent")


def test_what_is_missing_is_named():
    base = example("wu2022")
    with pytest.raises(prsm.MissingDataError, match="load_sharing"):
        prsm.compute(base, ["nut_axial_stiffness_secant"])
    bare = dataclasses.replace(_mechanism().stages[0], strength=None)
    with pytest.raises(prsm.MissingDataError, match=r"stage\.strength"):
        prsm.compute(prsm.Mechanism((bare,), base.operating_point), ["axis_axial_stiffness_secant"])
