"""Undamped poles: infinite where the modes take part, else the sum over the other modes."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from present import present
from response_scenes import (
    LAWS,
    SCENES,
    all_receptances,
    natural,
    network_of,
    replaced,
    response,
    vibration,
)
from scenes import example

import prsm_jax as prsm
from prsm_jax.response import _receptance, axis_compliance, direct_response

_compliance = eqx.filter_jit(axis_compliance)


def _modal_sum(network, omega, gap=1e-9):
    """Receptances by NumPy, without the modes at ω, and the residue of these, both scaled by √m."""
    spring, rows, mass = (np.asarray(x) for x in (network.stiffness, network.rows, network.mass))
    # Of the root of the matrix: soft modes keep their digits beside stiff ones.
    _, roots, vectors = np.linalg.svd(np.sqrt(spring)[:, None] * rows / np.sqrt(mass))
    squares = np.zeros(len(mass))
    squares[: len(roots)] = roots**2
    here = abs(squares - omega**2) < gap * (squares + omega**2)
    assert here.any()
    others, own = vectors[~here], vectors[here]
    return (others.T / (squares[~here] - omega**2)) @ others, own.T @ own


def _taking_part(residue):
    """Pairs of coordinates with more than 1e-18 of the energy of the modes, and a joint motion."""
    energy = np.diag(residue)
    moved = energy > 1e-18
    joint = abs(residue) > 1e-9 * np.sqrt(np.outer(energy, energy))
    return np.outer(moved, moved) & joint


@pytest.mark.parametrize("method", ["direct", "modal"])
@pytest.mark.parametrize("scene", ["symmetric", "unequal", "translating"])
def test_only_pairs_in_which_the_mode_takes_part_are_infinite(scene, method):
    """At every natural frequency, repeated ones too: all pairs against NumPy's modal sum."""
    network = network_of(SCENES[scene]())
    poles = natural(scene)
    found, at_pole = all_receptances(network, jnp.asarray(poles), None, method)
    assert at_pole.all()
    weight = np.sqrt(np.asarray(network.mass))
    scaled = np.real(np.asarray(found)) * np.outer(weight, weight)
    assert not np.imag(np.asarray(found)).any()
    partial = 0
    for omega, values in zip(poles, scaled, strict=True):
        limit, residue = _modal_sum(network, omega)
        infinite = _taking_part(residue)
        assert np.array_equal(np.isposinf(values), infinite)
        partial += infinite.any() and not infinite.all()
        error = abs(values - limit)[~infinite]
        assert (error <= 1e-8 * abs(limit).max()).all()
    assert partial or scene == "unequal"
    # Beside the poles nothing is infinite.
    beside, at_pole = all_receptances(network, jnp.asarray(poles * (1 + 1e-8)), None, method)
    assert not at_pole.any()
    assert np.isfinite(np.asarray(beside)).all()
    damped, at_pole = all_receptances(network, jnp.asarray(poles), LAWS["structural"], method)
    assert not at_pole.any()
    assert np.isfinite(np.asarray(damped)).all()


@pytest.mark.parametrize("method", ["direct", "modal"])
def test_a_pole_is_recognised_where_the_frequency_is_rounded(method):
    """A few units of rounding beside the highest and lowest root, and every root of the actuator.

    Independent: eigenvalues by LAPACK, participation by symmetry.
    """
    one = example("actuator")
    modes = prsm.modal(one, shapes=True)
    hertz = np.asarray(modes.frequencies)
    rotations = [name == "torsional" for name in modes.families]
    for units in (-4, 0, 4):
        beside = jnp.asarray(hertz * (1 + units * np.finfo(float).eps))
        turned = response(one, "screw u", "screw u", beside, damping=None, method=method)
        assert turned.at_pole.tolist() == rotations
        assert np.isinf(np.asarray(turned.value)).tolist() == rotations


def test_a_limit_is_approached_from_both_sides():
    one = example("actuator")
    modes = prsm.modal(one, shapes=True)
    hertz = np.asarray(modes.frequencies)
    still = [k for k in modes.distinct if modes.families[k] != "torsional"]
    at = hertz[still]
    found = response(one, "screw u", "nut u", jnp.asarray(at), damping=None)
    low, high = (
        response(one, "screw u", "nut u", jnp.asarray(at * (1 + step)), damping=None)
        for step in (-1e-4, 1e-4)
    )
    assert not found.at_pole.any()
    mean = (np.asarray(low.value) + np.asarray(high.value)) / 2
    # The curvature over a step of 1e-4: of size 1e-8 over the square of the distance of the
    # nearest pole, and near an antiresonance relative to a small value.
    np.testing.assert_allclose(found.value, mean, rtol=1e-4)
    assert float(found.decibel[1]) == pytest.approx(-170.239, abs=1e-3)


@pytest.mark.parametrize("near", [1e3, 0.0])
def test_very_near_a_pole_the_modes_are_separated(near, monkeypatch):
    """At 1e-12 of the frequency a sum with the mode is exact to the rounding of ω², 2e-16 of 2e-12.

    Without the separation pairs that the mode does not connect have lost all digits.
    """
    monkeypatch.setattr(_receptance, "_NEAR", near)
    network = network_of(SCENES["symmetric"]())
    root = natural("symmetric")[-1]
    omega = root * (1 + 1e-12)
    unit = jnp.eye(len(network.coordinates), dtype=complex)[None]
    found = jax.jit(lambda w: direct_response(network, w, unit))(jnp.asarray([omega]))
    assert not found.infinite.any()
    weight = np.sqrt(np.asarray(network.mass))
    scaled = np.real(np.asarray(found.displacement))[0] * np.outer(weight, weight)
    limit, residue = _modal_sum(network, root)
    expected = limit + residue / (root**2 - omega**2)
    still = ~_taking_part(residue)
    assert still.any()
    error = abs(scaled - limit)[still].max() / abs(limit).max()
    if near:
        assert abs(scaled - expected).max() < 1e-3 * abs(expected).max()
        # Rounding of shapes, 1e-16, over the distance.
        assert error < 1e-3
    else:
        assert error > 1.0


@pytest.mark.parametrize("method", ["direct", "modal"])
def test_a_limit_has_the_derivative_of_its_neighbours(method):
    """By a stiffness that keeps the symmetry: forward and reverse, and by the frequency."""
    one = example("wu2022")
    modes = prsm.modal(one)
    hertz = float(modes.frequencies[modes.families.index("roller")])

    def of(change, frequency):
        name = "nut.support.torsional_stiffness"
        moved = prsm.set_parameter(one, name, prsm.get_parameter(one, name) * (1 + change))
        found = prsm.frequency_response(
            moved, "screw u", "nut u", frequency[None], damping=None, method=method
        )
        return found.value[0].real * 1e9

    arguments = (jnp.asarray(0.0), jnp.asarray(hertz))
    beside = (jnp.asarray(0.0), jnp.asarray(hertz * (1 + 1e-7)))
    forward, reverse = (jax.jit(d(of, argnums=(0, 1))) for d in (jax.jacfwd, jax.jacrev))
    np.testing.assert_allclose(forward(*arguments), reverse(*arguments), rtol=1e-10)
    np.testing.assert_allclose(forward(*arguments), forward(*beside), rtol=1e-4)


def test_a_design_of_a_batch_at_a_pole_changes_no_other():
    one = example("wu2022")
    modes = prsm.modal(one)
    hertz = jnp.asarray([100.0, float(modes.frequencies[modes.families.index("torsional")])])

    def of(stiffness):
        moved = prsm.set_parameter(one, "stiffness.screw_roller", stiffness)
        found = prsm.frequency_response(moved, "screw u", "nut u", hertz, damping=None)
        return found.value, found.at_pole

    own = prsm.get_parameter(one, "stiffness.screw_roller")
    many = jax.jit(jax.vmap(of))
    values, at_pole = many(jnp.stack([1.1 * own, own]))
    assert at_pole.tolist() == [[False, False], [False, True]]
    others, at_pole = many(jnp.stack([1.1 * own, 1.2 * own]))
    assert not at_pole.any()
    np.testing.assert_array_equal(values[0], others[0])


def test_a_stage_that_nothing_holds_is_at_a_pole_at_rest():
    """No torsional support: a torque at rest turns the mechanism without end; a force does not."""
    stage = example("wu2022").stages[0]
    free = {
        name: eqx.tree_at(lambda b: b.support.torsional_stiffness, getattr(stage, name), None)
        for name in ("screw", "ring_gear", "nut")
    }
    one = replaced(example("wu2022"), **free)
    for law in ("structural", "undamped"):
        found = response(one, "screw u", "screw u", [0.0, 10.0], damping=LAWS[law])
        assert found.at_pole.tolist() == [True, False]
        assert np.isinf(found.magnitude[0])
        assert np.isfinite(found.magnitude[1])
        across = response(one, "screw x", "screw x", [0.0, 10.0], damping=LAWS[law])
        held = response(example("wu2022"), "screw x", "screw x", [0.0, 10.0], damping=LAWS[law])
        assert not across.at_pole.any()
        np.testing.assert_allclose(across.value, held.value, rtol=1e-9)


def test_forces_are_infinite_only_where_the_mode_moves_a_spring():
    """Errors in phase drive torsional modes: supports against sideways motion stay unloaded."""
    one = prsm.set_parameter(example("wu2022"), "roller_count", 10)
    modes = prsm.modal(one)
    hertz = float(modes.frequencies[modes.families.index("torsional")])
    order = next(o for o in prsm.campbell(one).orders if o.name == "ring_gear_mesh")
    speed = 2 * np.pi * hertz / abs(float(order.order))
    found = vibration(one, jnp.asarray([speed]), damping=None)
    assert found.at_pole.tolist() == [True]
    names = [str(spring) for spring in found.springs]
    force = np.abs(np.asarray(found.spring_force)[0])
    assert not np.isnan(force).any()
    contacts = [k for k, name in enumerate(names) if "roller" in name]
    assert np.isinf(force[contacts]).all()
    sideways = [k for k, name in enumerate(names) if name.endswith(("_x", "_y"))]
    assert len(sideways) == 6
    # Against some 1e8 N/m times an error of a micrometre in each contact.
    assert (force[sideways] < 1e-6).all()
    assert np.isinf(found.amplitude("screw u")[0])
    assert float(found.amplitude("screw x")[0]) < 1e-15


def test_rollers_that_spin_freely_leave_the_compliance_of_the_axis_finite():
    """The axis is held by its thrust bearing and by the servo: 1/k_servo in series, at 0 Hz too."""
    axis = example("actuator_axis")
    found = _compliance(axis, jnp.asarray([0.0, 1e-3, 2e-3]), damping=None)
    assert not found.at_pole.any()
    stiffness = float(prsm.compute(axis, quantities=["servo_stiffness"])["servo_stiffness"])
    for value in np.asarray(found.load):
        assert value.real == pytest.approx(1 / stiffness, rel=1e-7)
    for values in found.magnitudes.values():
        np.testing.assert_allclose(values, values[0], rtol=1e-6)
    # Without the controller the motor turns freely, and moves all three places.
    around = present(axis.axis)
    motor = dataclasses.replace(present(around.motor), controller=None)
    loose = dataclasses.replace(axis, axis=dataclasses.replace(around, motor=motor))
    free = _compliance(loose, jnp.asarray([0.0, 1.0]), damping=None)
    assert free.at_pole.tolist() == [True, False]
    for values in free.magnitudes.values():
        assert np.isinf(values[0])
        assert np.isfinite(values[1])
