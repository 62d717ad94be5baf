"""Vibration in space of every type: against an assembly from vectors, and their rigid motions."""

import dataclasses
import functools

import equinox as eqx
import numpy as np
import pytest
from present import present
from scenes import example
from spatial_assembly import assembled, assert_assembled
from spatial_scenes import THREADS, frequencies_of, modes_of, network_of, number, system_of

import prsm_jax as prsm
from prsm_jax.mechanism import Carrier, GivenStiffness, Support
from prsm_jax.vibration import Coordinate, spatial_harmonic_network, static_compliance

EXAMPLES = {
    "standard": "wu2022",
    "inverted": "humanoid_leg",
    "recirculating": "recirculating_stage",
    "differential": "differential_stage",
}
_statics = eqx.filter_jit(
    lambda system, place: static_compliance(spatial_harmonic_network(system, 0), place)
)

#: Teeth of the one that has them on its screw.
_TEETH = 1.6e8


@functools.cache
def free(kind, roller_count=3):
    """A stage of a type with teeth if it may have them, without supports and pins."""
    stage = example(EXAMPLES[kind]).stages[0]
    bodies = {
        name: dataclasses.replace(getattr(stage, name), support=None)
        for name in ("screw", "nut", "roller", "carrier", "ring_gear")
        if getattr(stage, name) is not None
    }
    teeth = _TEETH if stage.gear is not None else None
    given = GivenStiffness(number(THREADS.screw_roller), number(THREADS.nut_roller), teeth)
    return dataclasses.replace(stage, **bodies, stiffness=given, roller_count=roller_count)


@functools.cache
def held(kind, roller_count=3):
    """The same with pins, carriers and supports of all bodies."""
    stage = free(kind, roller_count)

    def supported(body, **stiffness):
        return dataclasses.replace(body, support=Support(**stiffness))

    carrier = stage.carrier or Carrier(count=2, mass=0.03, inertia=9e-6)
    return dataclasses.replace(
        stage,
        screw=supported(stage.screw, radial_stiffness=4e8, axial_stiffness=3e8),
        nut=supported(stage.nut, radial_stiffness=3e8, torsional_stiffness=2e8),
        roller=supported(stage.roller, radial_stiffness=2.2e7, axial_stiffness=4e6),
        carrier=supported(carrier, radial_stiffness=5e7, axial_stiffness=2e7),
    )


@pytest.mark.parametrize("standstill", [False, True])
@pytest.mark.parametrize("kind", EXAMPLES)
def test_matrices_are_those_of_an_assembly_from_vectors(kind, standstill):
    stage = held(kind)
    system = system_of(stage, THREADS, standstill=standstill)
    network = network_of(system)
    assert_assembled(network, assembled(stage, standstill), stage)
    whole = frequencies_of(network.stiffness, network.rows, network.mass)
    # LAPACK's singular values have an error of about 1e-15 of the largest one, which is about a
    # thousand times the smallest one.
    found = np.asarray(modes_of(system).frequencies)
    np.testing.assert_allclose(found, whole, rtol=1e-11, atol=1e-13 * whole[-1])


def _motion(stage, ratio, spin):
    """Displacements per radian of the body that turns, the carriers at any ratio.

    Rollers roll where they keep their place; on both sides of a recirculating one they slide, and
    their own speed is free.
    """
    thread = stage.thread
    reduced = number(thread.lead) / (2 * np.pi)
    radii = number(thread.screw_radius), number(thread.nut_radius), number(thread.roller_radius)
    screw, nut, roller = radii
    moved = {"carrier u": (screw + roller) * ratio, "roller tangential": (screw + roller) * ratio}
    if stage.type == "inverted":
        # Around a screw that is held.
        moved |= {"nut u": nut, "screw z": -reduced, "roller z": -reduced}
        own = (1 + screw / roller) * ratio
    else:
        travel = -reduced * ((1 - ratio) if stage.type == "differential" else 1)
        moved |= {"screw u": screw, "nut z": travel, "roller z": travel}
        own = (1 - nut / roller) * ratio
    if stage.type == "recirculating":
        moved["roller z"], own = -reduced * (1 - ratio), spin
    return moved | {"roller u": own * roller}


@pytest.mark.parametrize("kind", EXAMPLES)
def test_a_turn_moves_along_the_axis_without_stretching_any_contact(kind):
    stage = free(kind)
    network = network_of(system_of(stage, THREADS))
    contacts = np.array([s.name != "ring_roller" for s in network.springs])
    contacts &= np.asarray(network.stiffness) > 0
    names = [
        str(c) if not c.body.startswith("roller") else f"roller {c.direction}"
        for c in network.coordinates
    ]
    for ratio, spin in ((0.0, 0.0), (0.374, -2.0), (-1.0, 3.0)):
        moved = _motion(stage, ratio, spin)
        motion = np.array([moved.get(name, 0.0) for name in names])
        stretch = np.asarray(network.rows)[contacts] @ motion
        # The common normal is a root, found to its rounding; along the axis bodies move by 1e-3 m.
        assert np.abs(stretch).max() < 2e-15
    # At standstill the same turn does stretch contacts.
    stuck = network_of(system_of(stage, THREADS, standstill=True))
    moved = _motion(stage, 0.374, -2.0)
    motion = np.array([moved.get(name, 0.0) for name in names])
    assert np.abs(np.asarray(stuck.rows) @ motion).max() > 1e-4


@pytest.mark.parametrize("kind", EXAMPLES)
def test_number_of_rigid_motions(kind):
    """Of 8 + 4 N freedoms each contact takes one, or three where it sticks.

    Rollers with a thread may roll one by one without stretching the contact that slides: of their
    N constraints there only 3 are independent, those of the bodies on the axis.
    """
    count = 5
    expected = {
        "standard": 8 + count - 3,
        "inverted": 8 + count - 3,
        "recirculating": 8 + 2 * count,
        "differential": 8,
    }[kind]
    system = system_of(free(kind, count), THREADS)
    network = network_of(system)
    found = frequencies_of(network.stiffness, network.rows, network.mass)
    # Teeth add no rigid motion and take none: their pitch circles roll as the threads do.
    elastic = np.sum(found > 1e-11 * found[-1])
    assert len(network.coordinates) - elastic == expected
    assert modes_of(system).families.count("rigid") == expected
    # The whole along x, y, z, and around the axis.
    stuck = system_of(free(kind, count), THREADS, standstill=True)
    assert modes_of(stuck).families.count("rigid") == 4


def test_friction_alone_holds_a_differential_roller_screw():
    """Its nut moves along the axis as the rollers roll; at standstill the contacts hold it."""
    stage = free("differential")
    fixed = dataclasses.replace(
        stage,
        screw=dataclasses.replace(
            stage.screw, support=Support(axial_stiffness=1e9, torsional_stiffness=1e9)
        ),
        nut=dataclasses.replace(stage.nut, support=Support(torsional_stiffness=1e9)),
    )
    coordinate = Coordinate("nut", "z")

    def compliance(**options):
        return float(_statics(system_of(fixed, THREADS, **options), coordinate))

    assert compliance() == np.inf
    at_rest = compliance(standstill=True)
    count, poisson = stage.roller_count, number(present(stage.material).poisson_ratio)
    ratio, meshing = 2 * (1 - poisson) / (2 - poisson), prsm.mesh(stage.thread)
    contacts = 0.0
    for side in ("screw", "nut"):
        axial = number(getattr(meshing, side).normal[2]) ** 2
        stiffness = number(getattr(THREADS, f"{side}_roller"))
        contacts += 1 / (count * stiffness * (1 + ratio * (1 - axial) / axial))
    # Support and contacts in series, as if the rollers moved along the axis only. Radially they
    # move a little, because the two contacts differ by 6 %.
    assert at_rest == pytest.approx(1e-9 + contacts, rel=5e-3)


def test_verbs_take_every_type():
    for name in EXAMPLES.values():
        modes = prsm.spatial_modal(example(name))
        assert np.all(np.isfinite(np.asarray(modes.frequencies)))
        assert "axial" in modes.families
