"""Vibration in space: against an assembly from vectors, closed forms, and Wu's assumptions."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import example
from spatial_assembly import assembled, assert_assembled
from spatial_scenes import (
    THREADS,
    assert_shapes_solve,
    free_stage,
    frequencies_of,
    held_stage,
    held_system,
    modes_of,
    network_of,
    number,
    system_of,
)

import prsm_jax as prsm
from prsm_jax.mechanism import Material, Support, UnequalRoller, body_inertia, body_mass
from prsm_jax.stiffness import ThreadStiffness, axial_stiffness
from prsm_jax.vibration.spatial import contact_spring, tangential_ratio


@pytest.mark.parametrize("count", [3, 7])
def test_matrices_are_those_of_an_assembly_from_vectors(count):
    stage = held_stage(count)
    network = network_of(held_system(count))
    assert_assembled(network, assembled(stage), stage)


@pytest.mark.parametrize("count", [3, 5, 8])
def test_modes_by_symmetry_are_those_of_all_coordinates(count):
    system = held_system(count)
    network = network_of(system)
    expected = frequencies_of(network.stiffness, network.rows, network.mass)
    modes = modes_of(system)
    assert len(expected) == 4 * count + 11
    # LAPACK's singular values have an error of about 1e-15 of the largest one, which is 190 times
    # the smallest one.
    np.testing.assert_allclose(modes.frequencies, expected, rtol=1e-12)


@pytest.fixture(scope="module")
def held():
    return modes_of(held_system(), shapes=True)


def test_shapes_of_the_whole_stage_solve_its_equations(held):
    network = network_of(held_system())
    assert_shapes_solve(held, network)


def test_families_follow_from_the_harmonics_and_the_axial_share(held):
    # Along the axis and radially: screw, nut and rollers; around it: those and the carrier.
    expected = {"transverse": 14, "roller": 16, "axial": 4, "torsional": 5}
    assert {name: held.families.count(name) for name in set(held.families)} == expected
    assert held.multiplicities.count(2) == 14
    names = [str(coordinate) for coordinate in held.coordinates]
    axial = [name.endswith((" z", " radial")) for name in names]
    energy = np.asarray(held.network.mass)[:, None] * np.asarray(held.shapes) ** 2
    for name, share in zip(held.families, energy[np.array(axial)].sum(axis=0), strict=True):
        if name in ("axial", "torsional"):
            assert (share > 0.5) == (name == "axial")


def test_two_masses_and_a_spring_with_lead_coupling():
    """Rollers that are rigid on the nut: δ = z_s − z_n − h (θ_s − θ_n), with h = L/2π."""
    stage = held_stage()
    roller = dataclasses.replace(stage.roller, support=Support(radial_stiffness=0.0))
    free = free_stage(dataclasses.replace(stage, roller=roller))
    soft = 2e8
    threads = ThreadStiffness(jnp.asarray(soft), jnp.asarray(1e9 * soft))
    system = system_of(free, threads)
    found = np.asarray(present(modes_of(system).group("axial_torsional")).frequencies)
    mass, inertia = (number(law(stage, "roller")) for law in (body_mass, body_inertia))
    thread, count = stage.thread, stage.roller_count
    radius = number(thread.roller_radius)
    # A roller rolls in the nut: seen at the contact, a turn of the nut moves 1/(1/m + r²/J).
    rolling = 1 / (1 / mass + radius**2 / inertia)
    nut_mass = number(stage.nut.mass) + number(present(stage.ring_gear).mass) + count * mass
    nut_mass += number(present(stage.carrier).mass)
    nut_inertia = number(stage.nut.inertia) + number(present(stage.ring_gear).inertia)
    nut_inertia += count * rolling * number(thread.nut_radius) ** 2
    reduced = number(thread.lead) / (2 * np.pi)
    mobility = 1 / number(stage.screw.mass) + 1 / nut_mass
    mobility += reduced**2 * (1 / number(stage.screw.inertia) + 1 / nut_inertia)
    expected = np.sqrt(count * soft * mobility) / (2 * np.pi)
    # Rigid motions: z and u of all, screw against nut, rollers rolling, carrier.
    assert np.all(found[:5] < 1e-12 * expected)
    # The contacts at the nut are 1e9 times as stiff, and not rigid.
    np.testing.assert_allclose(found[5], expected, rtol=1e-8)
    assert found[6] > 1e3 * expected


def test_static_stiffness_is_that_of_contacts_in_series():
    """Rollers held against sideways motion: the stiffness room's own assumption."""
    stage = held_stage()
    network = network_of(system_of(stage, THREADS, sticking=False))
    threads = [s.name in ("screw_roller", "nut_roller") for s in network.springs]
    axial = [c.direction == "z" for c in network.coordinates]
    names = [c.body for c in network.coordinates if c.direction == "z"]
    found = _between_screw_and_nut(network, np.array(threads), np.array(axial), names)
    np.testing.assert_allclose(found, axial_stiffness(stage, THREADS), rtol=1e-13)


def _between_screw_and_nut(network, springs, coordinates, names):
    """Axial force on the screw per displacement, nut and turns held, rollers in equilibrium."""
    rows = np.sqrt(np.asarray(network.stiffness))[springs, None]
    rows = rows * np.asarray(network.rows)[np.ix_(springs, coordinates)]
    matrix = rows.T @ rows
    screw = names.index("screw")
    rest = [at for at, name in enumerate(names) if name.startswith("roller")]
    coupling = matrix[screw, rest]
    solved = np.linalg.lstsq(matrix[np.ix_(rest, rest)], coupling, rcond=None)[0]
    return matrix[screw, screw] - coupling @ solved


def test_static_stiffness_of_free_rollers_has_a_closed_form():
    """A free roller hands the force on the screw's normal to the nut, where it is oblique.

    Its moment vanishes, because rolling does not stretch the contact with the screw.
    """
    stage = held_stage()
    network = network_of(system_of(stage, THREADS))
    contacts = ("screw_roller", "nut_roller", "sticking_nut_roller")
    springs = np.array([s.name in contacts for s in network.springs])
    kept = [
        (c.body == "screw" and c.direction == "z") or c.body.startswith("roller")
        for c in network.coordinates
    ]
    names = [c.body for c, keep in zip(network.coordinates, kept, strict=True) if keep]
    found = _between_screw_and_nut(network, springs, np.array(kept), names)
    meshing = prsm.mesh(stage.thread)
    screw, nut = np.asarray(meshing.screw.normal), np.asarray(meshing.nut.normal)
    cosine = screw @ nut
    normal = number(THREADS.nut_roller) / nut[2] ** 2
    poisson = number(present(stage.material).poisson_ratio)
    tangential = 2 * (1 - poisson) / (2 - poisson) * normal
    compliance = screw[2] ** 2 / number(THREADS.screw_roller)
    compliance += cosine**2 / normal + (1 - cosine**2) / tangential
    expected = stage.roller_count * screw[2] ** 2 / compliance
    # The moment arm of a force of 1 is the rounding of a root, about 1e-15 of the radius.
    np.testing.assert_allclose(found, expected, rtol=1e-11)
    held = number(axial_stiffness(stage, THREADS))
    # Rollers held sideways pass on the axial force alone: the steeper normal makes the difference.
    assert 1e-3 < abs(found / held - 1) < 5e-3


def test_with_wus_assumptions_the_frequencies_are_those_of_modal():
    """Contacts of stiffness k cos²β_R in the transverse plane, along lines at the contact angle."""
    stage = held_stage()
    given = dataclasses.replace(present(stage.stiffness), ring_roller=None)
    flat = dataclasses.replace(stage, ring_gear=None, gear=None, stiffness=given)
    mechanism = dataclasses.replace(example("wu2022"), stages=(flat,))
    expected = np.asarray(prsm.modal(mechanism).frequencies)
    thread = flat.thread
    angle, roller = number(thread.contact_angle), number(thread.roller_radius)
    projection = number(jnp.cos(thread.roller_helix_angle)) ** 2

    def in_plane(name, body, sign, stiffness, radius):
        sine, cosine = sign * jnp.sin(angle), jnp.cos(angle)

        def foot(arm):
            """Nearest point of the line of action to an axis."""
            return arm * cosine, -arm * sine

        return contact_spring(
            name,
            body,
            projection * stiffness,
            (sine, cosine, jnp.zeros(())),
            (foot(radius), foot(-sign * roller)),
            (jnp.asarray(radius), jnp.asarray(roller)),
        )

    system = system_of(stage, THREADS)
    screw, nut = number(thread.screw_radius), number(thread.nut_radius)
    wu = [
        in_plane("screw_roller", "screw", 1, THREADS.screw_roller, screw),
        in_plane("nut_roller", "nut", -1, THREADS.nut_roller, nut),
    ]
    others = [
        eqx.tree_at(lambda spring: spring.stiffness, spring, jnp.asarray(0.0))
        if not spring.name.startswith("pin_")
        else spring
        for spring in system.springs[2:]
    ]
    body = system_of(flat, THREADS).bodies[1]
    bodies = (system.bodies[0], body, system.bodies[2])
    system = dataclasses.replace(system, springs=(*wu, *others), bodies=bodies)
    system = eqx.tree_at(
        lambda s: [spring.stiffness for spring in s.springs if spring.name == "pin_axial"],
        system,
        [jnp.asarray(0.0)],
    )
    # Along the axis only the supports of screw and nut are left: they are no modes of Wu's model.
    network = network_of(system)
    across = np.array([c.direction != "z" for c in network.coordinates])
    acting = np.asarray(network.stiffness) > 0
    rows, mass = np.asarray(network.rows)[acting], np.asarray(network.mass)
    along = rows[:, ~across].any(axis=1)
    assert not rows[np.ix_(along, across)].any()
    springs = np.asarray(network.stiffness)[acting]
    alone = frequencies_of(springs[~along], rows[np.ix_(~along, across)], mass[across])
    np.testing.assert_allclose(alone, expected, rtol=1e-12)
    held = np.sqrt(springs[along] / mass[[c.direction == "z" for c in network.coordinates]][:2])
    both = np.sort(np.concatenate([expected, held / (2 * np.pi), np.zeros(stage.roller_count)]))
    # Frequency 0 of rollers along the axis is found as 1e-16 of the largest one.
    np.testing.assert_allclose(
        modes_of(system).frequencies, both, rtol=1e-12, atol=1e-14 * both[-1]
    )


def _rigid_count(stage, **options):
    network = network_of(system_of(stage, THREADS, **options))
    found = frequencies_of(network.stiffness, network.rows, network.mass)
    return int(np.sum(found < 1e-12 * found[-1])), network


@pytest.mark.parametrize("count", [3, 7])
def test_rigid_motions_of_a_free_mechanism(count):
    """Four of the whole, the screw's turn by the lead, and rolling."""
    pinned = free_stage(held_stage(count))
    assert _rigid_count(pinned)[0] == 4 + 1 + 1
    unpinned = dataclasses.replace(pinned, roller=dataclasses.replace(pinned.roller, support=None))
    assert _rigid_count(unpinned)[0] == 4 + 1 + count


def test_turning_the_screw_moves_the_nut_by_the_lead_without_stretching_any_contact():
    stage = free_stage(held_stage())
    _, network = _rigid_count(stage)
    thread = stage.thread
    reduced = number(thread.lead) / (2 * np.pi)
    radius, distance = number(thread.roller_radius), number(thread.centre_distance)
    for ratio in (0.0, 0.374, -1.0):
        # Per radian of the screw, with the carriers at any ratio: rollers roll in the nut.
        moved = {
            "screw u": number(thread.screw_radius),
            "nut z": -reduced,
            "carrier u": distance * ratio,
            "roller z": -reduced,
            "roller tangential": distance * ratio,
            "roller u": -(number(thread.starts) - 1) * ratio * radius,
        }
        names = [
            str(c) if not c.body.startswith("roller") else f"roller {c.direction}"
            for c in network.coordinates
        ]
        motion = np.array([moved.get(name, 0.0) for name in names])
        stretch = (np.asarray(network.rows) @ motion)[np.asarray(network.stiffness) > 0]
        # The common normal is a root, found to its rounding; turned without the lead the contacts
        # at the screw would stretch by 1 mm.
        assert np.abs(stretch).max() < 1e-15


def test_tangential_stiffness_of_equal_and_unlike_bodies():
    steel, bronze = Material(212e9, 0.29), Material(110e9, 0.34)
    np.testing.assert_allclose(tangential_ratio(steel, steel), 2 * 0.71 / 1.71, rtol=1e-15)
    # By its definition, 8 G* over 2 E*.
    shear = [body.youngs_modulus / (2 * (1 + body.poisson_ratio)) for body in (steel, bronze)]
    ratios = [body.poisson_ratio for body in (steel, bronze)]
    tangential = 8 / sum((2 - nu) / g for nu, g in zip(ratios, shear, strict=True))
    plane = sum((1 - nu) / (2 * g) for nu, g in zip(ratios, shear, strict=True))
    np.testing.assert_allclose(tangential_ratio(steel, bronze), tangential * plane / 2, rtol=1e-14)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"roller_count": 2}, "roller_count is 2"),
        ({"unequal_roller": (UnequalRoller(3, missing=True),)}, "lists roller 3"),
        ("radial_stiffness_y", "screw.support has radial_stiffness_y"),
    ],
)
def test_a_stage_without_symmetry_is_refused(change, word):
    stage = example("wu2022").stages[0]
    if isinstance(change, str):
        support = dataclasses.replace(present(stage.screw.support), **{change: 1e8})
        change = {"screw": dataclasses.replace(stage.screw, support=support)}
    mechanism = dataclasses.replace(
        example("wu2022"), stages=(dataclasses.replace(stage, **change),)
    )
    with pytest.raises(ValueError, match=word):
        prsm.spatial_modal(mechanism)
