"""The axis around an inverted roller screw: against an assembly from vectors, and closed forms.

The motor turns the nut, and the load moves with the end of the screw.
"""

import dataclasses

import numpy as np
import pytest
from present import present
from scenes import example
from spatial_assembly import assembled, assert_assembled
from spatial_scenes import THREADS, frequencies_of, modes_of, network_of, number, system_of
from test_analytic_types_in_space import free, held

import prsm_jax as prsm
from prsm_jax.mechanism import Axis, AxisLoad, AxisShaft, Motor, PositionController, Support
from prsm_jax.response import axis_compliance

AXIS = Axis(
    motor=Motor(
        inertia=3e-4, shaft_stiffness=1.2e5, coupling_stiffness=4e4,
        controller=PositionController(proportional_gain=60.0),
    ),
    shaft=AxisShaft(nut_distance=0.11),
    load=AxisLoad(mass=40.0, tube_stiffness=6e7),
)  # fmt: skip


def _stage(count=3, mounting=None, carriers_held=False):
    """Held along the axis at its nut, and against turning at its screw; mounted to its load."""
    stage = held("inverted", count)
    if not carriers_held:
        carrier = present(stage.carrier)
        support = dataclasses.replace(present(carrier.support), axial_stiffness=None)
        stage = dataclasses.replace(stage, carrier=dataclasses.replace(carrier, support=support))
    return dataclasses.replace(
        stage,
        screw=dataclasses.replace(
            stage.screw,
            support=Support(
                radial_stiffness=4e8, torsional_stiffness=3e7, axial_stiffness=mounting
            ),
        ),
        nut=dataclasses.replace(
            stage.nut, support=Support(radial_stiffness=3e8, axial_stiffness=2.5e8)
        ),
    )


def _assembled(stage):
    """Stage and axis from vectors, with bars and shafts of textbooks."""
    held_by, carrier = present(stage.screw.support), present(stage.carrier)
    bare = dataclasses.replace(held_by, torsional_stiffness=None, axial_stiffness=None)
    cage = dataclasses.replace(present(carrier.support), axial_stiffness=None)
    assembly = assembled(
        dataclasses.replace(
            stage,
            screw=dataclasses.replace(stage.screw, support=bare),
            carrier=dataclasses.replace(carrier, support=cage),
        )
    )
    # The screw and the carriers on it are mounted to the load, behind the joint.
    supports = held_by.axial_stiffness, present(carrier.support).axial_stiffness
    mounting = sum(number(one) for one in supports if one is not None)
    tube = number(present(AXIS.load).tube_stiffness)
    if mounting > 0:
        tube = tube * mounting / (tube + mounting)
    material, thread = present(stage.material), stage.thread
    outer = 2 * (number(thread.screw_radius) - number(thread.roller_addendum))
    inner, near = 2 * number(stage.screw.bore_radius), number(present(AXIS.shaft).nut_distance)
    bar = number(material.youngs_modulus) * np.pi / 4 * (outer**2 - inner**2) / near
    shear = number(material.youngs_modulus) / (2 * (1 + number(material.poisson_ratio)))
    twist = shear * np.pi / 32 * (outer**4 - inner**4) / near
    share = near / (2 * number(stage.screw.length))
    at = assembly.places["screw"].start
    body = prsm.mechanism
    end = [share * number(law(stage, "screw")) for law in (body.body_mass, body.body_inertia)]
    # The carriers move along the axis with the screw at the nut: their mass stays there.
    for place, mass in zip((at + 2, at + 3), end, strict=True):
        assembly.masses[place] -= mass
    assembly.add_body("screw_end", np.zeros(3), [1, 1, *end])
    motor, load = present(AXIS.motor), present(AXIS.load)
    assembly.add_body("motor", np.zeros(3), [1, 1, 1, number(motor.inertia)])
    assembly.add_body("load", np.zeros(3), [1, 1, number(load.mass), 1])
    train = 1 / (1 / number(motor.shaft_stiffness) + 1 / number(motor.coupling_stiffness))
    along, turn = np.eye(4)[2], np.eye(4)[3]
    for first, second, way, stiffness in (
        ("screw_end", "screw", along, bar),
        ("screw_end", "screw", turn, twist),
        ("motor", "nut", turn, train),
        ("load", "screw_end", along, tube),
    ):
        assembly.rows.append(assembly.row((first, way), (second, -way)))
        assembly.stiffness.append(stiffness)
    radius = number(thread.screw_radius)
    assembly.ground("screw_end", 3, number(held_by.torsional_stiffness), radius)
    assembly.ground("motor", 3, number(present(motor.controller).proportional_gain))
    return assembly


@pytest.mark.parametrize(("mounting", "carriers_held"), [(None, False), (3e7, False), (3e7, True)])
def test_matrices_are_those_of_an_assembly_from_vectors(mounting, carriers_held):
    stage = _stage(mounting=mounting, carriers_held=carriers_held)
    system = system_of(stage, THREADS, axis=AXIS)
    network = network_of(system)
    found, expected, _ = assert_assembled(network, _assembled(stage), stage)
    for name in ("motor u", "load z", "screw_end z", "screw_end u"):
        at = network.index(name)
        np.testing.assert_allclose(found[at], expected[at], rtol=1e-13, atol=1e-13 * found[at, at])
    whole = frequencies_of(network.stiffness, network.rows, network.mass)
    # LAPACK's singular values have an error of 1e-15 of the largest one.
    np.testing.assert_allclose(
        modes_of(system).frequencies, whole, rtol=1e-11, atol=1e-14 * whole[-1]
    )


@pytest.fixture(scope="module")
def mechanism():
    """The example with stiffnesses of the threads given."""
    one = example("humanoid_leg")
    return dataclasses.replace(one, stages=(_stage(10),), axis=AXIS)


def test_static_stiffness_is_the_inverse_of_the_assembly(mechanism):
    stage = mechanism.stages[0]
    network = network_of(system_of(stage, THREADS, axis=AXIS))
    _, stiffness, _ = assert_assembled(network, _assembled(stage), stage)
    load, rotor = network.index("load z"), network.index("motor u")

    def at_the_load(kept):
        return 1 / np.linalg.inv(stiffness[np.ix_(kept, kept)])[kept.index(load), kept.index(load)]

    every = list(range(len(stiffness)))
    values = prsm.compute(mechanism, ["servo_stiffness", "held_motor_stiffness"])
    # Pins of carriers leave no rigid motion; the inverse has a condition of about 1e6.
    assert float(values["servo_stiffness"]) == pytest.approx(at_the_load(every), rel=1e-8)
    held = at_the_load([at for at in every if at != rotor])
    assert float(values["held_motor_stiffness"]) == pytest.approx(held, rel=1e-8)
    # At 0 Hz the rollers, which roll freely, are a pole; 0.01 Hz is 2e-4 of the lowest mode's.
    compliance = axis_compliance(mechanism, np.array([0.01]), damping=None).magnitudes
    assert float(compliance["load"][0]) == pytest.approx(1 / at_the_load(every), rel=1e-6)
    # Nothing else holds the load along the axis, so that the motor turns against its gain alone.
    gain = number(present(present(AXIS.motor).controller).proportional_gain)
    assert float(compliance["motor"][0]) == pytest.approx(1 / gain, rel=1e-6)


def test_position_loop_has_the_inertia_of_all_that_moves(mechanism):
    stage = mechanism.stages[0]
    mass = {
        name: number(prsm.mechanism.body_mass(stage, name))
        for name in ("screw", "roller", "carrier")
    }
    lead = number(stage.thread.lead) / (2 * np.pi)
    moving = mass["screw"] + 10 * mass["roller"] + stage.carrier.count * mass["carrier"]
    moving += number(present(AXIS.load).mass)
    inertia = number(present(AXIS.motor).inertia) + number(
        prsm.mechanism.body_inertia(stage, "nut")
    )
    expected = np.sqrt(60.0 / (inertia + moving * lead**2)) / (2 * np.pi)
    values = prsm.compute(mechanism, ["position_loop_frequency", "first_torsional_frequency"])
    assert float(values["position_loop_frequency"]) == pytest.approx(expected, rel=1e-12)
    # The lowest mode is that loop on springs that are a little elastic, with the rollers' turning.
    assert float(values["first_torsional_frequency"]) == pytest.approx(expected, rel=0.05)


def test_two_masses_and_a_nut_that_turns():
    """Rollers and load rigid on the screw, whose contacts are stiff: one spring at the nut."""
    stage = free("inverted", 7)
    soft = 2e8
    threads = dataclasses.replace(
        THREADS, screw_roller=THREADS.screw_roller * 1e9, nut_roller=THREADS.nut_roller * 0 + soft
    )
    bare = dataclasses.replace(
        stage,
        gear=None,
        stiffness=dataclasses.replace(present(stage.stiffness), ring_roller=None),
    )
    system = system_of(bare, threads, axis=Axis(load=AxisLoad(mass=4.0)))
    found = np.asarray(present(modes_of(system).group("axial_torsional")).frequencies)
    body = prsm.mechanism
    mass, inertia = (number(law(bare, "roller")) for law in (body.body_mass, body.body_inertia))
    thread, count = bare.thread, 7
    rolling = 1 / (1 / mass + number(thread.roller_radius) ** 2 / inertia)
    screw = number(body.body_mass(bare, "screw")) + count * mass + 4.0
    screw += bare.carrier.count * number(body.body_mass(bare, "carrier"))
    turning = number(body.body_inertia(bare, "screw"))
    turning += count * rolling * number(thread.screw_radius) ** 2
    reduced = number(thread.lead) / (2 * np.pi)
    mobility = 1 / number(body.body_mass(bare, "nut")) + 1 / screw
    mobility += reduced**2 * (1 / number(body.body_inertia(bare, "nut")) + 1 / turning)
    expected = np.sqrt(count * soft * mobility) / (2 * np.pi)
    # Rigid: z and u of all, nut against screw, rollers that roll.
    assert np.all(found[:4] < 1e-12 * expected)
    np.testing.assert_allclose(found[4], expected, rtol=1e-8)


def test_what_an_inverted_axis_cannot_have():
    one = example("humanoid_leg")
    stage = one.stages[0]
    held_nut = dataclasses.replace(
        stage, nut=dataclasses.replace(stage.nut, support=Support(torsional_stiffness=1e8))
    )
    with pytest.raises(ValueError, match=r"axis\.motor turns the nut, which stage\.nut"):
        dataclasses.replace(one, stages=(held_nut,))
    far = prsm.mechanism.FarBearing(0.17, 2e8)
    shaft = dataclasses.replace(present(present(one.axis).shaft), far_bearing=far)
    with pytest.raises(ValueError, match=r"far_bearing is given, but with type = .inverted."):
        dataclasses.replace(one, axis=dataclasses.replace(present(one.axis), shaft=shaft))
    loose = dataclasses.replace(stage, nut=dataclasses.replace(stage.nut, support=None))
    with pytest.raises(prsm.MissingDataError, match="nothing holds the nut along the axis"):
        prsm.compute(dataclasses.replace(one, stages=(loose,)), ["servo_stiffness"])
    loose = dataclasses.replace(stage, screw=dataclasses.replace(stage.screw, support=None))
    with pytest.raises(prsm.MissingDataError, match="nothing keeps the screw from turning"):
        prsm.compute(dataclasses.replace(one, stages=(loose,)), ["held_motor_stiffness"])
