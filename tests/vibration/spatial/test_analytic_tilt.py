"""Tilts in space: against rigid bodies whose threads, teeth and pins are springs one by one."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import example
from spatial_scenes import (
    THREADS,
    assert_shapes_solve,
    axis_stage,
    free_stage,
    frequencies_of,
    held_system,
    modes_of,
    network_of,
    number,
    system_of,
)
from test_analytic_types_in_space import EXAMPLES, held
from tilt_assembly import of_coordinates, rigid_bodies, tilting_stage, with_tilt_data

import prsm_jax as prsm
from prsm_jax.mechanism import Support, body_mass, tilting_inertia
from prsm_jax.response import axis_compliance
from prsm_jax.stiffness import ThreadStiffness
from prsm_jax.vibration import thread_spread


def tilted(stage, threads=THREADS, **options):
    return system_of(stage, threads, tilt=True, **options)


def assert_rigid_bodies(stage, standstill=False):
    network = network_of(tilted(stage, standstill=standstill))
    bodies = rigid_bodies(stage, standstill)
    change = of_coordinates(bodies, stage, network.coordinates)
    stiffness, masses = bodies.matrices()
    expected = change.T @ stiffness @ change
    found = np.asarray(network.stiffness_matrix())
    # Sums of some hundreds of doubles; the contact comes from a root found to about 1e-15.
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max(), rtol=0)
    inertias = change.T @ (masses[:, None] * change)
    np.testing.assert_allclose(np.diag(np.asarray(network.mass)), inertias, rtol=1e-13, atol=1e-16)


@pytest.mark.parametrize("standstill", [False, True])
@pytest.mark.parametrize("count", [3, 8])
def test_matrices_are_those_of_rigid_bodies(count, standstill):
    assert_rigid_bodies(tilting_stage(count), standstill)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_matrices_of_every_type_are_those_of_rigid_bodies(kind):
    assert_rigid_bodies(with_tilt_data(held(kind)))


@pytest.mark.parametrize("count", [3, 5, 8])
def test_modes_by_symmetry_are_those_of_all_coordinates(count):
    system = tilted(tilting_stage(count))
    network = network_of(system)
    expected = frequencies_of(network.stiffness, network.rows, network.mass)
    modes = modes_of(system)
    # Six of screw, nut and each roller; three of each carrier, in its plane.
    assert len(expected) == 6 * count + 2 * 6 + 2 * 3
    # LAPACK's singular values have an error of about 1e-15 of the largest one, which is 190 times
    # the smallest one.
    np.testing.assert_allclose(modes.frequencies, expected, rtol=1e-12)


def test_shapes_of_the_whole_stage_solve_its_equations():
    found = modes_of(tilted(tilting_stage()), shapes=True)
    network = network_of(tilted(tilting_stage()))
    assert found.coordinates == network.coordinates
    assert_shapes_solve(found, network)
    # Tilts of screw and nut, sideways and opposite motion of the carriers belong to harmonic 1.
    assert found.families.count("transverse") == 2 * (2 + 2 + 1 + 1 + 6)


def _rigid_count(stage):
    network = network_of(tilted(stage))
    found = frequencies_of(network.stiffness, network.rows, network.mass)
    return int(np.sum(found < 1e-12 * found[-1]))


@pytest.mark.parametrize("count", [3, 7])
def test_rigid_motions_of_a_free_mechanism(count):
    """Six of the whole, the screw's turn by the lead, and rolling."""
    pinned = free_stage(tilting_stage(count))
    assert _rigid_count(pinned) == 6 + 1 + 1
    unpinned = dataclasses.replace(pinned, roller=dataclasses.replace(pinned.roller, support=None))
    assert _rigid_count(unpinned) == 6 + 1 + count


def test_bodies_on_springs_have_textbook_frequencies():
    """Without threads and teeth, and with carriers that hardly move, each body vibrates alone."""
    stage = tilting_stage()
    given = dataclasses.replace(present(stage.stiffness), ring_roller=None)
    roller = dataclasses.replace(stage.roller, support=Support(radial_stiffness=3e7))
    carrier = dataclasses.replace(present(stage.carrier), mass=1e9, inertia=1e9, support=None)
    alone = dataclasses.replace(
        stage, stiffness=given, gear=None, ring_gear=None, roller=roller, carrier=carrier
    )
    soft = ThreadStiffness(jnp.asarray(0.0), jnp.asarray(0.0))
    found = np.asarray(modes_of(tilted(alone, soft)).frequencies)
    mass, across = number(body_mass(alone, "roller")), number(tilting_inertia(alone, "roller"))
    lever = number(stage.roller.length) / 2
    support = present(stage.screw.support)
    expected = {
        # Two pins in parallel, at either end.
        "roller sideways": np.sqrt(3e7 / mass),
        "roller tilting": np.sqrt(3e7 * lever**2 / across),
        "screw tilting": np.sqrt(3e4 / number(tilting_inertia(alone, "screw"))),
        "screw sideways": np.sqrt(number(support.radial_stiffness) / number(stage.screw.mass)),
    }
    for name, omega in expected.items():
        near = np.abs(found / (omega / (2 * np.pi)) - 1) < 1e-7
        times = 2 * stage.roller_count if name.startswith("roller") else 2
        assert near.sum() >= times, name


def test_a_cylinder_has_the_moment_of_inertia_of_a_textbook():
    stage = tilting_stage()
    roller = dataclasses.replace(stage.roller, mass=0.4, inertia=0.4 * 5e-3**2 / 2)
    one = dataclasses.replace(stage, roller=roller)
    expected = 0.4 * (3 * 5e-3**2 + 0.057**2) / 12
    assert number(tilting_inertia(one, "roller")) == pytest.approx(expected, rel=1e-15)


def test_with_an_axis_the_tilts_stay_those_of_the_stage():
    """Motor and load move harmonic 0; transverse modes are those without an axis."""
    stage = with_tilt_data(axis_stage())
    without = dataclasses.replace(example("wu2022"), stages=(stage,))
    modes = prsm.spatial_modal(without, tilt=True)
    plain = prsm.spatial_modal(without)
    assert len(present(modes.group("transverse")).frequencies) == 12
    assert len(present(plain.group("transverse")).frequencies) == 7
    # Axial–torsional: two tilts of the rollers, and carriers that turn oppositely.
    added = len(modes.groups[0].frequencies) - len(plain.groups[0].frequencies)
    assert added == 3


def test_without_tilt_nothing_of_it_is_computed():
    system = held_system()
    assert system.roller_tilt_mass is None
    assert all(spring.roller_tilt is None for spring in system.springs)
    assert all(body.tilt_mass is None for body in system.bodies)
    assert not any("tilt" in one.direction for one in network_of(system).coordinates)


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"engaged_threads": None}, prsm.MissingDataError, "give stage.engaged_threads"),
        ("roller", prsm.MissingDataError, "give stage.roller.length"),
        ("nut", prsm.MissingDataError, "give stage.nut.length"),
        ("carrier", ValueError, "carrier.count is 1"),
    ],
)
def test_what_a_tilt_needs_is_named(change, error, words):
    stage = tilting_stage()
    if isinstance(change, str):
        changed = {"count": 1} if change == "carrier" else {"length": None}
        change = {change: dataclasses.replace(getattr(stage, change), **changed)}
    one = dataclasses.replace(example("wu2022"), stages=(dataclasses.replace(stage, **change),))
    with pytest.raises(error, match=words):
        prsm.spatial_modal(one, tilt=True)


def test_a_single_thread_has_no_extent():
    one = dataclasses.replace(tilting_stage(), engaged_threads=jnp.asarray(1.0))

    def spread(count):
        return thread_spread(eqx.tree_at(lambda s: s.engaged_threads, one, count))

    value, slope = jax.value_and_grad(spread)(jnp.asarray(1.0))
    assert (float(value), float(slope)) == (0.0, 0.0)


def test_a_negative_tilting_stiffness_is_refused():
    with pytest.raises(ValueError, match="tilting_stiffness"):
        Support(tilting_stiffness=-1.0)


def test_pins_hold_a_roller_against_a_tilt_by_themselves():
    with pytest.raises(ValueError, match=r"roller\.support has tilting_stiffness"):
        dataclasses.replace(
            tilting_stage().roller, support=Support(radial_stiffness=1e7, tilting_stiffness=1.0)
        )


def test_tilting_rollers_lower_the_first_transverse_mode_of_the_actuator():
    """Nothing but its threads holds the nut against a tilt on the screw."""
    one = example("actuator")
    run = eqx.filter_jit(prsm.spatial_modal)
    plain, tilting = run(one), run(one, tilt=True)
    lowest = [
        np.asarray(present(modes.group("transverse")).frequencies) for modes in (plain, tilting)
    ]
    first = [values[values > 1.0][0] for values in lowest]
    # More freedom never raises the lowest frequency of the same springs (Rayleigh).
    assert first[1] < 0.6 * first[0]


def test_the_file_says_that_bodies_tilt_for_all_that_is_computed():
    """Modes, quantities, compliance; and an argument overrides it."""
    one = example("actuator_axis")
    tilting = dataclasses.replace(one, axis=dataclasses.replace(present(one.axis), tilt=True))
    modes = prsm.spatial_modal(tilting, shapes=True)
    expected = prsm.spatial_modal(one, tilt=True)
    for found, group in zip(modes.groups, expected.groups, strict=True):
        np.testing.assert_array_equal(found.frequencies, group.frequencies)
    axial = next(mode for mode in modes.elastic_modes() if mode.family == "axial")
    names = ["first_axial_frequency", "servo_stiffness"]
    numbers, rigid = (prsm.compute(which, names) for which in (tilting, one))
    assert float(numbers["first_axial_frequency"]) == pytest.approx(axial.frequency, rel=1e-12)
    # A mechanism with more freedoms is softer.
    assert float(numbers["servo_stiffness"]) < float(rigid["servo_stiffness"]) * (1 - 1e-6)
    assert len(prsm.spatial_modal(tilting, tilt=False).groups[0].frequencies) < len(
        modes.groups[0].frequencies
    )
    compliance = axis_compliance(tilting, np.array([60.0]), damping=None)
    same = axis_compliance(one, np.array([60.0]), damping=None, tilt=True)
    np.testing.assert_array_equal(compliance.nut, same.nut)
