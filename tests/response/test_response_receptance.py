"""Receptances: closed forms, two ways to one answer, reciprocity, power, poles."""

import re
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from response_scenes import (
    LAWS,
    SCENES,
    all_receptances,
    matrices,
    modal,
    natural,
    network_of,
    replaced,
    response,
    with_rollers,
)
from scenes import example

import prsm_jax as prsm
from prsm_jax.mechanism import ModalDamping, RayleighDamping, StructuralDamping
from prsm_jax.response import (
    Dissipation,
    axis_compliance,
    dissipation,
    frequency_response,
    mesh_response,
    receptance_matrix,
    spring_damping,
)

_EPS = np.finfo(float).eps
# From rest to beyond the highest mode, between and beside the resonances.
OMEGA = jnp.asarray(2 * np.pi * np.array([0.0, 150.0, 291.0, 1e3, 2.3e3, 3.7e3, 2e4, 3.4e4, 6e4]))


def _conditions(network, damping):
    """Condition number of the scaled dynamic stiffness at each frequency of OMEGA."""
    stiffness, mass, viscous, hysteretic = matrices(network, damping)
    weight = 1 / np.sqrt(np.diag(mass))
    scale = np.outer(weight, weight)
    found = []
    for omega in np.asarray(OMEGA):
        matrix = stiffness - omega**2 * mass + 1j * (omega * viscous + hysteretic)
        found.append(np.linalg.cond(matrix * scale))
    return np.array(found)


@pytest.mark.parametrize(
    ("scene", "law"),
    [*(("unequal", law) for law in LAWS), ("symmetric", "undamped"), ("translating", "modal")],
)
def test_direct_solution_and_modal_sum_agree(scene, law):
    """To rounding of ω_k² and of the factors, which the condition number magnifies."""
    network = network_of(SCENES[scene]())
    direct, at_pole = all_receptances(network, OMEGA, LAWS[law], "direct")
    summed, also = all_receptances(network, OMEGA, LAWS[law], "modal")
    assert not at_pole.any()
    assert not also.any()
    weight = np.sqrt(np.asarray(network.mass))
    # In scaled coordinates, where the condition number is that of the equations solved.
    scale = weight[:, None] * weight[None, :]
    error = np.abs(np.asarray(direct - summed) * scale).max(axis=(1, 2))
    size = np.abs(np.asarray(direct) * scale).max(axis=(1, 2))
    # Eigenvectors of rotations are orthogonal to a few units more than those of LAPACK.
    assert (error <= 40 * _EPS * _conditions(network, LAWS[law]) * size).all()


@pytest.mark.parametrize("law", LAWS)
def test_reciprocity(law):
    """Force and displacement exchange places: H_ij = H_ji."""
    network = network_of(SCENES["unequal"]())
    found, _ = all_receptances(network, OMEGA, LAWS[law], "direct")
    weight = np.sqrt(np.asarray(network.mass))
    scaled = np.asarray(found) * weight[:, None] * weight[None, :]
    error = np.abs(scaled - scaled.transpose(0, 2, 1)).max(axis=(1, 2))
    size = np.abs(scaled).max(axis=(1, 2))
    assert (error <= 10 * _EPS * _conditions(network, LAWS[law]) * size).all()


@pytest.mark.parametrize("law", ["modal", "rayleigh", "structural"])
def test_the_power_of_the_force_is_what_damping_takes(law):
    """½ Re(f* iω q) = ½ q*(ω² C + ω H) q."""
    network = network_of(SCENES["unequal"]())
    _, _, viscous, hysteretic = matrices(network, LAWS[law])
    found, _ = all_receptances(network, OMEGA, LAWS[law], "direct")
    conditions = _conditions(network, LAWS[law])
    for omega, moved, condition in zip(
        np.asarray(OMEGA), np.asarray(found), conditions, strict=True
    ):
        given = np.real(1j * omega * np.diagonal(moved)) / 2
        taken = np.real(
            np.einsum(
                "ki,kl,li->i",
                moved.conj(),
                omega**2 * viscous + omega * hysteretic,
                moved,
            )
        )
        # Of the reactive power, of which the power taken may be a small part.
        size = omega * np.abs(np.diagonal(moved)).max()
        assert np.abs(given - taken / 2).max() <= 10 * _EPS * condition * size


def test_at_rest_the_response_is_the_compliance():
    """K⁻¹, and not nearly so: at 0 Hz the mass has no part."""
    network = network_of(SCENES["unequal"]())
    found, _ = all_receptances(network, OMEGA[:1], None, "direct")
    stiffness = np.asarray(network.stiffness_matrix())
    identity = stiffness @ np.asarray(found)[0].real
    assert np.abs(identity - np.eye(len(stiffness))).max() <= _EPS * np.linalg.cond(stiffness)
    assert not np.imag(np.asarray(found)).any()


def test_the_carrier_is_an_oscillator_of_one_degree_of_freedom():
    """1 / (k(1 + iη) + iωc − ω²m), with what each law means for one mass and one spring."""
    network = network_of(SCENES["unequal"]())
    place = network.index("carrier u")
    mass, stiffness = float(network.mass[place]), 6.983e6
    # Six rollers, one of them a tenth heavier.
    assert mass == pytest.approx(5.888e-6 / 16e-3**2 + 6.1 * 0.0326, rel=1e-14)
    omega = np.asarray(OMEGA)
    natural_ = np.sqrt(stiffness / mass)
    damping = {
        "undamped": 0 * omega,
        "modal": omega * 2 * 0.02 * natural_ * mass,
        "rayleigh": omega * (50.0 * mass + 1e-7 * stiffness),
        "structural": 0.03 * stiffness + 0 * omega,
    }
    for law, lost in damping.items():
        for method in ("direct", "modal"):
            found, _ = all_receptances(network, OMEGA, LAWS[law], method)
            expected = 1 / (stiffness - omega**2 * mass + 1j * lost)
            # The carrier's equation is one row of its own: rounding of a few operations, and of
            # the square root of K, whose size is that of the stiffest mode.
            tolerance = 1e-12 if law == "modal" else 1e-14
            np.testing.assert_allclose(found[:, place, place], expected, rtol=tolerance)


def test_rayleigh_equals_modal_damping_where_their_ratios_agree():
    """α and β that give ζ at ω₁ and ω₂ act on the modes at these two as modal damping does."""
    scene = SCENES["unequal"]()
    network = network_of(scene)
    first, second = natural("unequal")[[1, 6]]
    ratio = 0.03
    mass = 2 * ratio * first * second / (first + second)
    stiffness = 2 * ratio / (first + second)
    one, other = RayleighDamping(mass, stiffness), ModalDamping(ratio)
    shapes = np.asarray(modal(scene).shapes)
    for law in (one, other):
        viscous = matrices(network, law)[2]
        by_mode = shapes.T @ viscous @ shapes
        for omega, column in ((first, 1), (second, 6)):
            # Rounding of C, whose largest modal entry is that of the stiffest mode.
            error = 20 * _EPS * np.abs(by_mode).max()
            assert abs(by_mode[column, column] - 2 * ratio * omega) < error
    # Elsewhere they differ, so the agreement above is no accident.
    difference = matrices(network, one)[2] - matrices(network, other)[2]
    assert np.abs(difference).max() > 0.1 * np.abs(matrices(network, other)[2]).max()


def test_modal_damping_gives_every_mode_its_ratio():
    scene = SCENES["unequal"]()
    network = network_of(scene)
    modes = modal(scene)
    viscous = matrices(network, ModalDamping(0.02))[2]
    found = np.asarray(modes.shapes.T) @ viscous @ np.asarray(modes.shapes)
    expected = np.diag(2 * 0.02 * natural("unequal"))
    assert np.abs(found - expected).max() < 40 * _EPS * expected.max()


def test_any_matrix_damps_the_direct_solution():
    """A dashpot at one spring is not proportional; NumPy's solution of the same equations."""
    network = network_of(SCENES["symmetric"]())
    losses = spring_damping(
        network, {"screw_roller": 300.0, "nut_roller 3": 5e3}, {"ring_roller": 0.05}
    )
    stiffness, mass, viscous, hysteretic = matrices(network, losses)
    rows = np.asarray(network.rows)
    constant = np.array(
        [
            300.0 if s.name == "screw_roller" else 5e3 if str(s) == "nut_roller 3" else 0.0
            for s in network.springs
        ]
    )
    np.testing.assert_allclose(viscous, rows.T @ np.diag(constant) @ rows, rtol=1e-14, atol=1e-9)
    found, _ = all_receptances(network, OMEGA, losses, "direct")
    conditions = _conditions(network, losses)
    for omega, moved, condition in zip(
        np.asarray(OMEGA), np.asarray(found), conditions, strict=True
    ):
        matrix = stiffness - omega**2 * mass + 1j * (omega * viscous + hysteretic)
        weight = np.sqrt(np.diag(mass))
        residual = matrix / np.outer(weight, weight) @ (moved * np.outer(weight, weight))
        assert np.abs(residual - np.eye(len(matrix))).max() <= 10 * _EPS * condition
    with pytest.raises(ValueError, match="a damping matrix couples the modes"):
        all_receptances(network, OMEGA, losses, "modal")
    with pytest.raises(prsm.UnknownNameError, match="did you mean screw_roller"):
        spring_damping(network, {"screw_rollers": 1.0})


def test_a_gyroscopic_matrix_is_not_taken_for_symmetric():
    """The transposed equations have a solution of their own, which derivatives need."""
    network = network_of(SCENES["symmetric"]())
    size = len(network.coordinates)
    turning = np.zeros((size, size))
    turning[0, 1], turning[1, 0] = 2e3, -2e3
    losses = Dissipation(jnp.asarray(turning + 100 * np.eye(size)))
    omega = jnp.asarray([1e4])

    @jax.jit
    def real_part(scale):
        scaled = Dissipation(losses.viscous * scale)
        found, _ = receptance_matrix(network, omega, ("screw x",), ("screw y",), scaled)
        return found[0, 0, 0].real

    step = 1e-5
    slope = (real_part(1 + step) - real_part(1 - step)) / (2 * step)
    # A difference of second order: 1e-10, and its rounding 1e-11.
    np.testing.assert_allclose(jax.jit(jax.grad(real_part))(1.0), slope, rtol=1e-8)
    np.testing.assert_allclose(jax.jit(jax.jacfwd(real_part))(1.0), slope, rtol=1e-8)


def test_matrices_that_do_not_fit_are_refused():
    network = network_of(SCENES["symmetric"]())
    with pytest.raises(ValueError, match=r"shape \(3, 3\); the stage has 17 degrees"):
        dissipation(network, jnp.eye(3))


def test_mobility_and_accelerance_are_the_receptance_over_time():
    one = example("wu2022")
    hertz = [0.0, 100.0, 5e3]
    omega = 2 * np.pi * np.asarray(hertz)
    law = StructuralDamping(0.02)
    receptance = response(one, "screw u", "nut u", hertz, damping=law)
    for kind, power, unit in (("mobility", 1, "m/(N·s)"), ("accelerance", 2, "m/(N·s²)")):
        found = response(one, "screw u", "nut u", hertz, damping=law, kind=kind)  # pyright: ignore[reportArgumentType]
        assert found.unit == unit
        np.testing.assert_allclose(found.value, (1j * omega) ** power * receptance.value)
    np.testing.assert_allclose(receptance.decibel, 20 * np.log10(np.abs(receptance.value)))
    np.testing.assert_allclose(receptance.phase, np.angle(receptance.value))


def test_what_symmetry_keeps_apart_is_exactly_zero():
    one = example("wu2022")
    for pair in (("screw u", "nut x"), ("screw x", "ring_gear y")):
        found = response(one, *pair, [0.0, 1e3])
        assert not np.asarray(found.value).any()
        assert not found.at_pole.any()
        assert np.isneginf(found.decibel).all()
    coupled = with_rollers(translating=True)
    assert np.asarray(response(coupled, "carrier u", "nut u", [1e3]).value).all()
    assert np.asarray(response(coupled, "screw x", "nut y", [1e3]).value).all()
    unequal = SCENES["unequal"]()
    assert np.asarray(response(unequal, "screw u", "nut x", [1e3]).value).all()


def test_the_damping_of_the_file_is_taken_unless_another_is_given(unchecked):
    damped = replaced(example("wu2022"), damping=ModalDamping(0.02))
    given = response(damped, "screw u", "nut u", [300.0])
    own = response(example("wu2022"), "screw u", "nut u", [300.0], damping=ModalDamping(0.02))
    none = response(damped, "screw u", "nut u", [300.0], damping=None)
    assert complex(given.value[0]) == complex(own.value[0])
    assert not np.imag(np.asarray(none.value)).any()
    for wrong, message in (
        ({"excitation": "screw z"}, "choose one of screw x, screw y"),
        ({"kind": "impedance"}, "choose one of receptance, mobility, accelerance"),
        ({"method": "fft"}, 'choose "direct" or "modal"'),
        ({"stage": 2}, "the mechanism has stages 1 to 1"),
    ):
        arguments: dict[str, Any] = {
            "excitation": "screw u",
            "response": "nut u",
            "frequency": [1.0],
        } | wrong
        with pytest.raises(ValueError, match=message):
            frequency_response(damped, **arguments)


def test_many_frequencies_are_solved_in_turns():
    """Chunks change nothing but the memory."""
    network = network_of(SCENES["symmetric"]())
    omega = jnp.linspace(1.0, 2e5, 600)
    many, _ = receptance_matrix(network, omega, ("screw u",), ("screw u",), LAWS["rayleigh"])
    few, _ = receptance_matrix(network, omega[-9:], ("screw u",), ("screw u",), LAWS["rayleigh"])
    # Batches of another size may be added up in another order.
    np.testing.assert_allclose(many[-9:], few, rtol=1e-11)


@pytest.mark.usefixtures("unchecked")
def test_a_number_is_one_frequency():
    one = example("wu2022")
    listed = response(one, "screw u", "nut u", [293.0])
    for number in (293.0, 293, np.float64(293.0), jnp.asarray(293.0)):
        found = response(one, "screw u", "nut u", number)
        np.testing.assert_array_equal(found.value, listed.value)


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize(
    ("frequency", "message"),
    [
        ([[293.0, 300.0]], r"frequency has the shape (1, 2); give one list of frequencies [Hz]"),
        ([[293.0, 300.0], 1.0], "frequency is [[293.0, 300.0], 1.0]; give one list of frequencies"),
        ([293 + 1j], "frequency is complex: (293+1j); give real numbers"),
        (jnp.asarray([1j]), "frequency is complex: 1j; give real numbers"),
        (["293 Hz"], "frequency is ['293 Hz']; give one list of frequencies [Hz]"),
        ([293.0, np.nan], "frequency is nan at place 2; give finite numbers"),
        ([np.inf, 293.0], "frequency is inf at place 1; give finite numbers"),
        (np.nan, "frequency is nan at place 1; give finite numbers"),
    ],
)
def test_frequencies_that_are_none_are_refused(frequency, message):
    one = example("wu2022")
    with pytest.raises(ValueError, match=re.escape(message)):
        frequency_response(one, "screw u", "nut u", frequency)
    with pytest.raises(ValueError, match=re.escape(message)):
        axis_compliance(example("actuator_axis"), frequency)
    words = message.replace("frequency", "speed").replace("frequencies", "speeds")
    with pytest.raises(ValueError, match=re.escape(words.replace("Hz]", "rad/s]"))):
        mesh_response(one, frequency)


@pytest.mark.parametrize("method", ["direct", "modal"])
def test_a_frequency_that_is_not_a_number_is_no_pole(method):
    """It has no amplitude, and no verdict either."""
    one = example("wu2022")

    def of(hertz):
        return response(one, "screw u", "nut u", hertz, method=method)

    found = jax.jit(of)(jnp.array([np.nan, 293.0, np.inf]))
    assert not found.at_pole.any()
    assert np.isnan(found.magnitude).tolist() == [True, False, True]


@pytest.mark.usefixtures("unchecked")
def test_damping_that_is_a_number_is_refused_with_the_law():
    one = example("wu2022")
    with pytest.raises(ValueError, match=r"damping is 0\.02; give a law.*ModalDamping\(0\.02\)"):
        frequency_response(one, "screw u", "nut u", [293.0], damping=0.02)  # pyright: ignore
    with pytest.raises(ValueError, match="damping is 'modal'; give a law"):
        frequency_response(one, "screw u", "nut u", [293.0], damping="modal")  # pyright: ignore[reportArgumentType]
