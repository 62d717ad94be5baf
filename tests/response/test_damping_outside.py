"""A law of damping of a user's own, in everything that the package's laws work in."""

import dataclasses

import jax
import numpy as np
import pytest
from response_scenes import SCENES, all_receptances, matrices, modal, natural, network_of, response
from scenes import example

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.fields import Number, number
from prsm_jax.mechanism import DampingLaw

_EPS = np.finfo(float).eps


class CaugheyDamping(DampingLaw):
    """C = γ K M⁻¹ K, the third term of Caughey's series (1960): ratios ζ_k = γ ω_k³ / 2."""

    factor: Number = number("s^3", "coefficient of the third term, γ")

    def modal_loss(self, natural, omega):
        return omega * self.factor * natural**4

    def viscous_matrix(self, of):
        stiffness = of.stiffness_matrix()
        return self.factor * (stiffness / of.mass[None, :]) @ stiffness


#: A ratio of about 2 % at the highest frequency.
LAW = CaugheyDamping(0.04 / natural("unequal")[-1] ** 3)


def test_every_mode_has_the_ratio_of_the_law():
    scene = SCENES["unequal"]()
    shapes = np.asarray(modal(scene).shapes)
    by_mode = shapes.T @ matrices(network_of(scene), LAW)[2] @ shapes
    expected = np.diag(float(LAW.factor) * natural("unequal") ** 4)
    # Rounding of products of K, whose largest modal entry is that of the stiffest mode.
    assert np.abs(by_mode - expected).max() < 40 * _EPS * expected.max()


def test_direct_solution_and_modal_sum_agree_with_the_matrix():
    network = network_of(SCENES["unequal"]())
    omega = np.array([0.3, 0.999, 1.0, 2.0]) * natural("unequal")[6]
    stiffness, mass, viscous, _ = matrices(network, LAW)
    for method in ("direct", "modal"):
        amplitudes, at_pole = all_receptances(network, omega, LAW, method)
        assert not at_pole.any()
        for one, w in zip(np.asarray(amplitudes), omega, strict=True):
            matrix = stiffness - w**2 * mass + 1j * w * viscous
            error = np.abs(matrix @ one - np.eye(len(mass))).max()
            assert error < 40 * _EPS * np.linalg.cond(matrix)


def _damped(law):
    one = example("wu2022")
    stage = dataclasses.replace(one.stages[0], damping=law)
    return dataclasses.replace(one, stages=(stage,))


def test_a_mechanism_holds_the_law_and_derivatives_pass_it():
    omega = natural("symmetric")[3:4]
    frequency = 0.97 * omega / (2 * np.pi)

    def magnitude(factor):
        damped = _damped(CaugheyDamping(factor))
        return response(damped, "screw u", "nut u", frequency, method="modal").magnitude[0]

    # A ratio of 10 %, so that damping shows in the magnitude.
    at = 0.2 / omega[0] ** 3
    step = 1e-4 * at
    expected = (magnitude(at + step) - magnitude(at - step)) / (2 * step)
    # The error of the difference is about the square of the relative step.
    assert float(jax.grad(magnitude)(at)) == pytest.approx(float(expected), rel=1e-7)


def test_a_file_does_not_hold_the_law_and_says_so():
    with pytest.raises(prsm.FileError, match=r"CaugheyDamping.*modal, rayleigh, structural"):
        file.dumps(_damped(LAW))
