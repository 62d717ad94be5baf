"""The axis around a stage: against an assembly from vectors, textbooks' springs, closed forms."""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from scenes import example
from spatial_assembly import assembled, assert_assembled
from spatial_scenes import (
    AXIS,
    THREADS,
    axis_stage,
    frequencies_of,
    modes_of,
    network_of,
    number,
    rolling_stage,
    system_of,
)

import prsm_jax as prsm
from prsm_jax.load_sharing import stage_load_distribution
from prsm_jax.mechanism import Axis, AxisLoad, LoadSharing, Motor, Support
from prsm_jax.response import axis_compliance
from prsm_jax.stiffness import ThreadStiffness, axial_stiffness
from prsm_jax.vibration import (
    Coordinate,
    axial_torsional_modes,
    spatial_harmonic_network,
    static_compliance,
)

_axial = eqx.filter_jit(axial_torsional_modes)
statics = eqx.filter_jit(
    lambda system, place: static_compliance(spatial_harmonic_network(system, 0), place)
)


def springs_of(axis, stage):
    """Torsional stiffness of the train [N·m/rad], bars [N/m] and shaft [N·m/rad] by textbooks."""
    material, screw = present(stage.material), stage.screw
    modulus, poisson = number(material.youngs_modulus), number(material.poisson_ratio)
    outer = 2 * (number(stage.thread.screw_radius) - number(stage.thread.roller_addendum))
    inner = 2 * number(screw.bore_radius)
    area = np.pi / 4 * (outer**2 - inner**2)
    polar = np.pi / 32 * (outer**4 - inner**4)
    shear = modulus / (2 * (1 + poisson))
    near = number(axis.shaft.nut_distance)
    motor = present(axis.motor)
    pair = number(motor.shaft_stiffness), number(motor.coupling_stiffness)
    return {
        "train": pair[0] * pair[1] / sum(pair),
        "bar": modulus * area / near,
        "twist": shear * polar / near,
        "bar_per_length": modulus * area,
    }


def axis_assembled(axis, stage):
    """Stage and axis from vectors: three more bodies, of which some coordinates stay unused."""
    held = present(stage.screw.support)
    bearing = number(held.axial_stiffness)
    bare = dataclasses.replace(held, axial_stiffness=None)
    screw = dataclasses.replace(stage.screw, support=bare)
    assembly = assembled(dataclasses.replace(stage, screw=screw))
    springs = springs_of(axis, stage)
    length, near = number(stage.screw.length), number(axis.shaft.nut_distance)
    far = axis.shaft.far_bearing
    beyond = number(far.distance) - near
    mass, inertia = number(stage.screw.mass), number(stage.screw.inertia)
    ends = mass / length * np.array([near / 2, beyond / 2 + length - number(far.distance)])
    at = assembly.places["screw"].start
    assembly.masses[at + 2] = mass - ends.sum()
    assembly.masses[at + 3] = inertia * (1 - near / 2 / length)
    assembly.add_body("screw_end", np.zeros(3), [1, 1, ends[0], inertia * near / 2 / length])
    assembly.add_body("screw_far_end", np.zeros(3), [1, 1, ends[1], 1])
    assembly.add_body("motor", np.zeros(3), [1, 1, 1, number(axis.motor.inertia)])
    assembly.add_body("load", np.zeros(3), [1, 1, number(axis.load.mass), 1])
    along, turn = np.array([0.0, 0.0, 1.0, 0.0]), np.array([0.0, 0.0, 0.0, 1.0])
    for first, second, way, stiffness in (
        ("screw_end", "screw", along, springs["bar"]),
        ("screw_end", "screw", turn, springs["twist"]),
        ("screw_far_end", "screw", along, springs["bar_per_length"] / beyond),
        ("motor", "screw_end", turn, springs["train"]),
        ("load", "nut", along, number(axis.load.tube_stiffness)),
    ):
        assembly.rows.append(assembly.row((first, way), (second, -way)))
        assembly.stiffness.append(stiffness)
    assembly.ground("screw_end", 2, bearing)
    assembly.ground("screw_far_end", 2, number(far.axial_stiffness))
    assembly.ground("motor", 3, number(axis.motor.controller.proportional_gain))
    return assembly


@functools.cache
def _whole(count=7):
    return system_of(axis_stage(count), THREADS, axis=AXIS)


def test_matrices_are_those_of_an_assembly_from_vectors():
    stage = axis_stage(3)
    network = network_of(_whole(3))
    found, expected, _ = assert_assembled(network, axis_assembled(AXIS, stage), stage)
    # The soft springs too: those of the motor are a millionth of the largest.
    for name in ("motor u", "load z", "screw_end z", "screw_end u", "screw_far_end z"):
        at = network.index(name)
        np.testing.assert_allclose(found[at], expected[at], rtol=1e-13, atol=1e-13 * found[at, at])


def test_modes_by_symmetry_are_those_of_all_coordinates():
    network = network_of(_whole(3))
    expected = frequencies_of(network.stiffness, network.rows, network.mass)
    # LAPACK's singular values have an error of 1e-15 of the largest one; the lowest mode, the motor
    # on its gain, has a frequency of 1e-4 of it.
    np.testing.assert_allclose(modes_of(_whole(3)).frequencies, expected, rtol=1e-11)


@pytest.fixture(scope="module")
def modes():
    return modes_of(_whole(), shapes=True)


def test_shapes_and_energies_of_the_axis(modes):
    network, shapes = modes.network, np.asarray(modes.shapes)
    values = (2 * np.pi * np.asarray(modes.frequencies)) ** 2
    mass = np.asarray(network.mass)
    force = np.asarray(network.stiffness_matrix()) @ shapes
    size = np.abs(values * mass[:, None] * shapes).max()
    np.testing.assert_allclose(force, values * mass[:, None] * shapes, atol=1e-12 * size)
    elastic = modes.elastic_modes()
    assert [mode.number for mode in elastic] == list(range(1, len(elastic) + 1))
    # All springs of the pair in series carry the same torque.
    for mode in elastic[:4]:
        ratio = mode.strain["coupling"] / mode.strain["motor_shaft"]
        assert ratio == pytest.approx(1.2e5 / 4e4, rel=1e-12)
        assert sum(mode.strain.values()) == pytest.approx(1.0, rel=1e-12)
        assert sum(mode.kinetic.values()) == pytest.approx(1.0, rel=1e-12)
    # The motor on its gain turns everything; the load then vibrates along the axis.
    assert (elastic[0].family, elastic[1].family) == ("torsional", "axial")
    assert next(iter(elastic[0].strain)) == "position_gain"
    assert "load" in list(elastic[1].kinetic)[:2]


def _logs(axis, stage, changes):
    """Axis and stage with stiffnesses changed by factors e^change, by the name of the spring."""
    grown = {name: jnp.exp(value) for name, value in changes.items()}
    places = {
        "coupling": lambda a, s: a.motor.coupling_stiffness,
        "motor_shaft": lambda a, s: a.motor.shaft_stiffness,
        "position_gain": lambda a, s: a.motor.controller.proportional_gain,
        "thrust_tube": lambda a, s: a.load.tube_stiffness,
        "far_bearing": lambda a, s: a.shaft.far_bearing.axial_stiffness,
        "screw_support_axial": lambda a, s: s.screw.support.axial_stiffness,
        "nut_support_torsional": lambda a, s: s.nut.support.torsional_stiffness,
        "pin_axial": lambda a, s: s.roller.support.axial_stiffness,
    }
    pair = axis, stage
    for name, factor in grown.items():
        if name in places:
            where = places[name]
            pair = eqx.tree_at(lambda p, w=where: w(*p), pair, replace_fn=lambda x, f=factor: f * x)
    return pair


def test_energies_are_elasticities_of_the_frequencies(modes):
    """d ln f/d ln k is half the share of the spring: what to stiffen."""
    stage = axis_stage()
    names = (
        *("coupling", "motor_shaft", "position_gain", "thrust_tube", "far_bearing"),
        *("screw_support_axial", "pin_axial", "screw_roller"),
    )

    def frequencies(logs):
        changes = dict(zip(names, logs, strict=True))
        axis, changed = _logs(AXIS, stage, changes)
        threads = ThreadStiffness(
            THREADS.screw_roller * jnp.exp(changes["screw_roller"]), THREADS.nut_roller
        )
        system = prsm.vibration.spatial_system(changed, threads, axis=axis)
        return jnp.log(axial_torsional_modes(system)[0].frequencies)

    slopes = np.asarray(jax.jit(jax.jacfwd(frequencies))(jnp.zeros(len(names))))
    elastic = modes.elastic_modes()
    assert len(elastic) == len(slopes)
    # A supported nut and carrier, pins: no rigid motion. Roots of the motor are simple.
    expected = np.array([[mode.strain[name] / 2 for name in names] for mode in elastic])
    np.testing.assert_allclose(slopes, expected, rtol=1e-9, atol=1e-12)
    # The low modes use all of these springs.
    assert (expected[:4].max(axis=0) > 1e-4).all()


def test_motor_and_load_on_threads_vibrate_like_two_masses_and_a_spring():
    """J (2π/L)² against M on the spring of the threads; everything else is 1e9 times as stiff."""
    stage = rolling_stage()
    soft = 2e7
    rigid = 1e9 * soft
    nut = dataclasses.replace(stage.nut, support=Support(torsional_stiffness=rigid))
    screw = dataclasses.replace(stage.screw, support=Support(axial_stiffness=rigid))
    stage = dataclasses.replace(stage, nut=nut, screw=screw)
    axis = Axis(motor=Motor(inertia=3e-3), load=AxisLoad(mass=5000.0))
    threads = ThreadStiffness(jnp.asarray(soft), jnp.asarray(rigid))
    group, share = _axial(system_of(stage, threads, axis=axis))
    frequencies = np.asarray(group.frequencies)
    elastic = frequencies > 1e-12 * frequencies[-1]
    count = stage.roller_count
    # The screw turns, and the nut moves with its rollers, ring, carrier and load.
    inertia = 3e-3 + number(stage.screw.inertia)
    mass = 5000.0 + number(stage.nut.mass) + number(present(stage.ring_gear).mass)
    mass += number(present(stage.carrier).mass) + count * number(stage.roller.mass)
    turns_per_metre = 2 * np.pi / number(stage.thread.lead)
    mobility = 1 / mass + 1 / (inertia * turns_per_metre**2)
    expected = np.sqrt(count * soft * mobility) / (2 * np.pi)
    # What is 1e9 times as stiff is not rigid.
    assert frequencies[elastic][0] == pytest.approx(expected, rel=1e-8)
    # Along the axis, although the motor, as the lighter one, has more of the kinetic energy.
    assert inertia * turns_per_metre**2 < mass / 3
    assert np.asarray(share)[elastic][0] > 0.99
    # The screw's turn with the nut, and rolling.
    assert (~elastic).sum() == 2


def test_static_stiffness_is_that_of_springs_in_series():
    """The motor's springs act through the lead: a torque F L/2π twists by φ and moves by φ L/2π."""
    stage = rolling_stage()
    axis = dataclasses.replace(
        AXIS, shaft=dataclasses.replace(present(AXIS.shaft), far_bearing=None)
    )
    springs = springs_of(axis, stage)
    lever = number(stage.thread.lead) / (2 * np.pi)
    meshing = prsm.mesh(stage.thread)
    screw, nut = np.asarray(meshing.screw.normal), np.asarray(meshing.nut.normal)
    cosine = screw @ nut
    normal = number(THREADS.nut_roller) / nut[2] ** 2
    poisson = number(present(stage.material).poisson_ratio)
    tangential = 2 * (1 - poisson) / (2 - poisson) * normal
    # Of a free roller, as in docs/vibration.md.
    threads = screw[2] ** 2 / number(THREADS.screw_roller)
    threads += cosine**2 / normal + (1 - cosine**2) / tangential
    threads /= stage.roller_count * screw[2] ** 2
    # The nut's key takes the torque of the threads.
    key = number(present(stage.nut.support).torsional_stiffness)
    key *= number(stage.thread.nut_radius) ** 2
    along = threads + 1 / 4.5e8 + 1 / springs["bar"]
    along += 1 / number(present(stage.screw.support).axial_stiffness)
    around = 1 / springs["train"] + 1 / springs["twist"] + 1 / key
    held = along + lever**2 * around
    place = Coordinate("load", "z")
    found = statics(system_of(stage, THREADS, axis=axis, motor_held=True), place)
    # The moment arm of a force is the rounding of a root; rollers that roll freely are no spring.
    assert float(found) == pytest.approx(held, rel=1e-10)
    found = statics(system_of(stage, THREADS, axis=axis), place)
    assert float(found) == pytest.approx(held + lever**2 / 60.0, rel=1e-10)


def test_static_stiffness_is_that_of_the_load_sharing_where_shafts_are_rigid():
    """Rollers held sideways: threads of both rooms; each room's own way to the sum."""
    given = dataclasses.replace(
        present(rolling_stage().stiffness), screw_roller=None, nut_roller=None
    )
    rigid = 1e21
    sharing = LoadSharing(
        thread_count=4,
        screw_segment_stiffness=rigid,
        roller_segment_stiffness=rigid,
        nut_segment_stiffness=rigid,
    )
    stage = dataclasses.replace(
        rolling_stage(), stiffness=given, curvature="exact", load_sharing=sharing
    )
    distribution = eqx.filter_jit(stage_load_distribution)(stage, jnp.asarray(7e3))
    side = distribution.screw.roller_tangent_stiffness, distribution.nut.roller_tangent_stiffness
    threads = ThreadStiffness(*side)
    expected = number(distribution.tangent_stiffness)
    assert number(axial_stiffness(stage, threads)) == pytest.approx(expected, rel=1e-9)
    stiff = Support(radial_stiffness=1e18, axial_stiffness=1e18, torsional_stiffness=1e18)
    pins = Support(radial_stiffness=1e18)
    held = dataclasses.replace(
        stage,
        roller=dataclasses.replace(stage.roller, support=pins),
        carrier=dataclasses.replace(present(stage.carrier), support=stiff),
        screw=dataclasses.replace(stage.screw, support=stiff),
        nut=dataclasses.replace(stage.nut, support=Support(torsional_stiffness=1e18)),
    )
    # An axial support of the carrier would hold the nut.
    held = eqx.tree_at(lambda s: s.carrier.support.axial_stiffness, held, jnp.asarray(0.0))
    system = system_of(held, threads, sticking=False, axis=Axis(load=AxisLoad(mass=1.0)))
    found = 1 / float(statics(system, Coordinate("nut", "z")))
    # What holds the rollers is 1e9 times as stiff as their threads.
    assert found == pytest.approx(expected, rel=1e-9)


def test_zeros_of_the_compliance_at_the_motor_are_modes_with_the_motor_held(modes):
    mechanism = _mechanism()
    held = prsm.spatial_modal(mechanism, motor_held=True, shapes=True)
    zeros = [mode.frequency for mode in held.elastic_modes()][:3]
    poles = [mode.frequency for mode in modes.elastic_modes()][:4]
    for low, zero, high in zip(poles[:-1], zeros, poles[1:], strict=True):
        assert low < zero < high
    undamped = dataclasses.replace(
        AXIS,
        motor=eqx.tree_at(
            lambda m: m.controller.derivative_gain, present(AXIS.motor), jnp.asarray(0.0)
        ),
    )
    found = _compliance(dataclasses.replace(mechanism, axis=undamped), jnp.asarray([*zeros, 1.0]))
    size = found.magnitudes["motor"]
    # A root found to 1e-12, where the slope is that of a compliance over its frequency.
    assert np.all(np.asarray(size)[:3] < 1e-9 * float(size[3]))


_compliance = eqx.filter_jit(axis_compliance)


def _mechanism():
    return dataclasses.replace(example("wu2022"), stages=(axis_stage(),), axis=AXIS)


def test_compliance_is_the_inverse_of_the_dynamic_stiffness_from_vectors():
    """With both gains of the controller; N = 7 rollers, of which the package uses harmonic 0."""
    stage = axis_stage()
    network = network_of(_whole())
    _, stiffness, mass = assert_assembled(network, axis_assembled(AXIS, stage), stage)
    radius = number(stage.thread.screw_radius)
    hertz = np.array([3.0, 20.0, 140.0, 900.0, 6000.0])
    found = _compliance(_mechanism(), jnp.asarray(hertz))
    damping = np.zeros_like(stiffness)
    rotor = network.index("motor u")
    damping[rotor, rotor] = 0.7 / radius**2
    places = {"nut": "nut z", "load": "load z", "motor": "motor u"}
    for at, omega in enumerate(2 * np.pi * hertz):
        inverse = np.linalg.inv(stiffness + 1j * omega * damping - omega**2 * mass)
        for name, place in places.items():
            row = network.index(place)
            expected = inverse[row, row] / (radius**2 if name == "motor" else 1.0)
            value = complex(getattr(found, name)[at])
            # Condition of the dynamic stiffness, 1e6, times the rounding of its entries.
            assert value == pytest.approx(expected, rel=1e-9)
    assert not np.any(found.at_pole)
    # The derivative gain matters where the motor turns.
    assert abs(complex(found.motor[1]).imag) > 0.1 * abs(complex(found.motor[1]))
