"""What the contacts excite: orders from the kinematics, phases, forces, crossings."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from response_scenes import (
    LAWS,
    SCENES,
    chart,
    matrices,
    network_of,
    replaced,
    vibration,
    with_rollers,
)
from scenes import example

import prsm_jax as prsm
from prsm_jax.dynamics import ideal_carrier_ratio
from prsm_jax.mechanism import UnequalRoller
from prsm_jax.response import (
    excitation_orders,
    excited_response,
    find_order,
    mesh_response,
    phasing,
    working_carrier_ratio,
)
from prsm_jax.vibration import family_shares, stage_system

_EPS = np.finfo(float).eps
#: κ of rolling without slip for five starts, (n − 2) / (2 (n − 1)).
_IDEAL = 0.375


_respond_compiled = eqx.filter_jit(excited_response)


def _respond(system, order, speed, harmonic=1):
    """One program for all excitations of the same contacts: the harmonic is part of the order."""
    one = dataclasses.replace(
        order, order=harmonic * order.order, lobes=harmonic * order.lobes, name="", description=""
    )
    return _respond_compiled(system, one, speed, jnp.asarray(1e-6), damping=LAWS["rayleigh"])


def _family_shares(system, network, displacement):
    """Share of the kinetic energy of a complex vibration in each family."""
    shares = family_shares(system, network, displacement.real[:, None])
    shares = shares + family_shares(system, network, displacement.imag[:, None])
    return dict(
        zip(
            ("carrier", "torsional", "transverse", "roller"),
            np.asarray(shares / shares.sum())[:, 0],
            strict=True,
        )
    )


def test_orders_are_those_of_ideal_rolling():
    """Five starts, z_R = 16: the kinematics of a planetary gear with sun n − 2 and ring n."""
    stage = example("wu2022").stages[0]
    orders = {one.name: one for one in excitation_orders(stage)}
    expected = {
        "carrier": (0.375, 1),
        "deviating_start": (0.375, 1),
        "screw_rotation": (0.625, 1),
        "roller_passing_nut": (7 * 0.375, 7),
        "roller_passing_screw": (7 * 0.625, 7),
        "thread_passing": (5 * 0.375, 5),
        "ring_gear_mesh": (80 * 0.375, 80),
    }
    assert set(orders) == set(expected)
    for name, (order, lobes) in expected.items():
        np.testing.assert_allclose([orders[name].order, orders[name].lobes], [order, lobes])
    # Teeth of a roller meet the ring gear as often as its own spin n κ brings them there.
    spin = 5 * 0.375
    np.testing.assert_allclose(orders["ring_gear_mesh"].order, 16 * spin)


def test_a_stage_without_teeth_has_no_gear_mesh():
    one = replaced(example("wu2022"), gear=None)
    names = [order.name for order in excitation_orders(one.stages[0])]
    assert "ring_gear_mesh" not in names
    with pytest.raises(ValueError, match="no ring gear with teeth"):
        find_order(excitation_orders(one.stages[0]), "ring_gear_mesh")


def test_the_carrier_ratio_is_that_of_the_steady_state():
    """Geometry where only thread friction acts; the operating point where losses resist."""
    simple = example("wu2022")
    ratio = float(working_carrier_ratio(simple))
    assert ratio == pytest.approx(
        float(prsm.compute(simple, ["carrier_ratio"])["carrier_ratio"][0])
    )
    assert ratio != pytest.approx(_IDEAL, rel=1e-4)
    # Losses, but no operating point: what is left is rolling.
    idle = dataclasses.replace(example("actuator"), operating_point=None)
    expected = float(ideal_carrier_ratio(idle.stages[0].thread))
    assert float(working_carrier_ratio(idle)) == expected == _IDEAL


@pytest.mark.parametrize("roller_count", [7, 9, 10])
def test_phases_of_the_rollers_decide_which_family_is_excited(roller_count):
    """Teeth divisible by N: torsional; remainder ±1: transverse; else only the rollers move.

    80 teeth of the ring gear on 7 (remainder 3), 9 (−1) and 10 (0) rollers.
    """
    one = prsm.set_parameter(example("wu2022"), "roller_count", roller_count)
    system, network = stage_system(one, 1), network_of(one)
    for name in ("ring_gear_mesh", "roller_passing_screw", "screw_rotation", "thread_passing"):
        order = find_order(excitation_orders(one.stages[0]), name)
        for harmonic in (1, 2):
            found = _respond(system, order, jnp.asarray([230.0]), harmonic)
            shares = _family_shares(system, network, found.displacement[0])
            family = phasing(harmonic * float(order.lobes), roller_count)
            # The share of the rollers is a difference of energies, exact to rounding.
            assert shares[family] == pytest.approx(1.0, abs=100 * _EPS)
    expected = {7: "roller", 9: "transverse", 10: "torsional"}
    assert phasing(80, roller_count) == expected[roller_count]


def test_phasing_needs_a_whole_number():
    assert phasing(81, 10) == phasing(-1, 10) == phasing(79.0000001, 10) == "transverse"
    with pytest.raises(ValueError, match=r"lobes is 80\.5"):
        phasing(80.5, 10)


def test_one_unequal_roller_mixes_the_families():
    one = with_rollers(UnequalRoller(2, stiffness_factor=0.7))
    system, network = stage_system(one, 1), network_of(one)
    order = find_order(excitation_orders(one.stages[0]), "ring_gear_mesh")
    found = _respond(system, order, jnp.asarray([230.0]))
    shares = _family_shares(system, network, found.displacement[0])
    assert min(shares[name] for name in ("torsional", "transverse", "roller")) > 1e-6
    assert shares["carrier"] == 0


@pytest.mark.parametrize("scene", SCENES)
def test_forces_balance(scene):
    """What the springs carry, damping and inertia add up to nothing on every coordinate."""
    one = SCENES[scene]()
    system, network = stage_system(one, 1), network_of(one)
    order = find_order(excitation_orders(one.stages[0]), "ring_gear_mesh")
    speed = jnp.asarray([20.0, 230.0, 470.0])
    found = _respond(system, order, speed)
    _, mass, viscous, _ = matrices(network, LAWS["rayleigh"])
    rows = np.asarray(network.rows)
    for hertz, moved, force in zip(
        np.asarray(found.frequency),
        np.asarray(found.displacement),
        np.asarray(found.spring_force),
        strict=True,
    ):
        omega = 2 * np.pi * hertz
        rest = rows.T @ force + 1j * omega * viscous @ moved - omega**2 * mass @ moved
        # Forces of up to 250 N a roller; the solution's rounding by a condition below 1e5.
        assert np.abs(rest).max() < 1e5 * _EPS * np.abs(force).max()
    np.testing.assert_allclose(found.frequency, 80 * _IDEAL * np.asarray(speed) / (2 * np.pi))


def test_slow_turning_gives_the_static_forces():
    """Without inertia, equal errors in phase leave one spring chain: the loads of statics."""
    one = prsm.set_parameter(example("wu2022"), "roller_count", 10)
    found = vibration(one, jnp.zeros(3), carrier_ratio=_IDEAL, amplitude=2e-6)
    network = network_of(one)
    errors = np.array([2e-6 if s.name == "ring_roller" else 0.0 for s in network.springs])
    stiffness, rows = np.asarray(network.stiffness), np.asarray(network.rows)
    moved = np.linalg.solve(rows.T @ np.diag(stiffness) @ rows, rows.T @ (stiffness * errors))
    force = stiffness * (rows @ moved - errors)
    np.testing.assert_allclose(found.spring_force[0].real, force, atol=1e-9 * np.abs(force).max())
    ring = [k for k, spring in enumerate(network.springs) if spring.name == "ring_roller"]
    assert float(found.force("ring_roller")[0]) == pytest.approx(np.abs(force[ring]).max())
    assert float(found.force("ring_roller 3")[0]) == pytest.approx(
        float(found.force("ring_roller")[0]), rel=1e-10
    )
    screw = float(found.amplitude("screw u")[0])
    assert screw == pytest.approx(abs(moved[network.index("screw u")]), rel=1e-10)


def test_a_crossing_is_a_resonance():
    """At an excited crossing the undamped stage is at a pole, and beside it large; finite where
    the phases do not reach the family."""
    one = prsm.set_parameter(example("wu2022"), "roller_count", 10)
    found = chart(one, harmonics=1, carrier_ratio=_IDEAL)
    crossings = found.crossings(3000.0)
    excited = [c for c in crossings if c.order == "ring_gear_mesh" and c.excited]
    assert {c.family for c in excited} == {"torsional"}
    for crossing in excited:
        speeds = crossing.speed * jnp.asarray([1.0, 1.0001, 1.01])
        moved = vibration(one, speeds, carrier_ratio=_IDEAL)
        assert moved.at_pole.tolist() == [True, False, False]
        largest = np.abs(np.asarray(moved.displacement)).max(axis=1)
        assert np.isinf(largest[0])
        # Amplitude goes with one over the distance: 100 times nearer, and other modes beside it.
        assert largest[1] > 50 * largest[2]
        assert not np.isnan(np.asarray(moved.spring_force)).any()


def test_crossings_are_where_the_lines_meet():
    one = example("wu2022")
    found = chart(one, harmonics=3, carrier_ratio=_IDEAL)
    orders = {order.name: order for order in found.orders}
    every = found.crossings()
    # Nine distinct frequencies of N = 7 (two times four, roller, carrier), seven orders, three
    # harmonics each.
    assert len(every) == 10 * 7 * 3
    assert [c.speed for c in every] == sorted(c.speed for c in every)
    for crossing in every:
        rate = crossing.harmonic * float(orders[crossing.order].order) / (2 * np.pi)
        assert crossing.speed * rate == pytest.approx(crossing.frequency, rel=1e-14)
        lobes = crossing.harmonic * float(orders[crossing.order].lobes)
        assert crossing.excited == (crossing.family == phasing(lobes, 7))
    below = found.crossings(600.0, min_speed=100.0)
    assert {c.speed for c in below} == {c.speed for c in every if 100 <= c.speed <= 600}
    assert all(c.excited for c in found.crossings(excited_only=True))
    assert below[0].speed_rpm == pytest.approx(below[0].speed * 60 / (2 * np.pi))
    only = chart(one, harmonics=1, carrier_ratio=_IDEAL, orders=("thread_passing",))
    assert {c.order for c in only.crossings()} == {"thread_passing"}


def test_without_symmetry_every_family_may_be_excited():
    found = chart(SCENES["unequal"](), harmonics=1, carrier_ratio=_IDEAL)
    crossings = found.crossings()
    assert {c.multiplicity for c in crossings} == {1}
    for crossing in crossings:
        assert crossing.excited == (crossing.family != "carrier")
    assert {"carrier", "torsional", "transverse", "roller"} <= {c.family for c in crossings}


def test_wrong_requests_name_the_remedy(unchecked):
    one = example("wu2022")
    with pytest.raises(ValueError, match="choose one of carrier, deviating_start"):
        mesh_response(one, [1.0], order="belt", carrier_ratio=_IDEAL)
    with pytest.raises(ValueError, match="harmonic is 0; the first is 1"):
        mesh_response(one, [1.0], harmonic=0, carrier_ratio=_IDEAL)
    with pytest.raises(ValueError, match="harmonics is 0"):
        prsm.campbell(one, harmonics=0, carrier_ratio=_IDEAL)
    moved = vibration(prsm.set_parameter(one, "roller_count", 10), jnp.zeros(3), carrier_ratio=0.3)
    with pytest.raises(ValueError, match="'screw z' does not exist; choose one of screw x"):
        moved.amplitude("screw z")
    with pytest.raises(ValueError, match="'belt' does not exist"):
        moved.force("belt")
