"""Derivatives stay finite where formulas tend to be 0/0, and whole programs transform."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from derivatives import QUANTITIES, forward, reverse, shipped
from scenes import example, mesh

import prsm_jax as prsm

#: ρ at which the screw side is circular at zero lead: 1/ρ = sin α (1/r_R + 1/r_s).
CIRCULAR = 1 / (np.sqrt(0.5) * (1 / 4e-3 + 1 / 12e-3))

CASES = {
    "circular contact": ("actuator", {"lead": 1e-6, "roller_profile_radius": CIRCULAR}),
    "lead of a micrometre": ("actuator", {"lead": 1e-6}),
    "no load": ("actuator", {"operating_point.load": 0.0}),
    "standstill": ("actuator", {"operating_point.speed": 0.0}),
    "both": ("actuator", {"operating_point.load": 0.0, "operating_point.speed": 0.0}),
    "driven back": ("actuator", {"operating_point.speed": -100.0}),
    "three rollers": ("wu2022", {"roller_count": 3}),
    "thirty rollers": ("wu2022", {"roller_count": 30}),
}


def _case(name):
    shipped_name, changes = CASES[name]
    mechanism = shipped(shipped_name)
    for parameter, value in changes.items():
        mechanism = prsm.set_parameter(mechanism, parameter, value)
    return mechanism


@pytest.mark.parametrize("name", CASES)
def test_values_and_derivatives_are_finite(name):
    """Forward to the design variables, and reverse to every number of the mechanism."""
    mechanism = _case(name)
    quantities = QUANTITIES
    if name == "three rollers":
        quantities = tuple(q for q in QUANTITIES if q != "roller_frequency")
    values, by_forward = forward(mechanism, quantities)
    gradients, by_reverse = reverse(mechanism, quantities, values.size)
    assert np.all(np.isfinite(values))
    assert np.all(np.isfinite(by_forward))
    numbers = len(jax.tree.leaves(eqx.filter(mechanism, eqx.is_inexact_array)))
    for gradient in gradients:
        leaves = jax.tree.leaves(gradient)
        assert len(leaves) == numbers
        assert all(np.all(np.isfinite(leaf)) for leaf in leaves)
    scale = np.maximum(np.abs(values)[:, None], np.abs(by_forward))
    # At a lead of a micrometre the slip is 1e-5 of the velocities that it is the difference of.
    tolerance = 1e-8 if float(mechanism.stages[0].thread.lead) < 1e-5 else 1e-11
    assert np.all(np.abs(by_reverse - by_forward) <= tolerance * scale)


def test_circular_case_is_circular():
    curvature = mesh(_case("circular contact").stages[0].thread).screw.curvature
    assert curvature.difference_squared < 1e-7 * curvature.total**2


def _vector(mechanism):
    names = ("efficiency", "max_pressure", "torsional_frequencies")
    found = prsm.compute(mechanism, names)
    return jnp.concatenate([jnp.ravel(found[name]) for name in names])


def test_vmap_over_a_batched_mechanism_equals_a_loop():
    """A batch is a mechanism whose leaves have one axis more."""
    singles = []
    for lead, angle in ((5e-3, 40.0), (10e-3, 45.0), (17e-3, 52.0)):
        moved = prsm.set_parameter(example("wu2022"), "lead", lead)
        singles.append(prsm.set_parameter(moved, "contact_angle", np.radians(angle)))
    batch = jax.tree.map(lambda *leaves: jnp.stack(leaves), *singles)
    together = np.asarray(eqx.filter_jit(eqx.filter_vmap(_vector))(batch))
    alone = eqx.filter_jit(_vector)
    # The same operations, fused in another order.
    for row, single in zip(together, singles, strict=True):
        np.testing.assert_allclose(row, alone(single), rtol=1e-12)


def test_jit_does_not_change_the_result():
    one = example("li2020_single_stage_viscous")
    names = ["efficiency", "max_pressure"]
    eager = prsm.compute(one, names)
    compiled = eqx.filter_jit(lambda m: prsm.compute(m, names))(one)
    for name in names:
        assert compiled[name] == pytest.approx(float(eager[name]), rel=1e-13)


def test_grad_of_the_readme():
    """`jax.grad` of a scalar to the whole mechanism; integers and names stay as they are."""

    def efficiency(mechanism):
        return prsm.steady_state(mechanism, speed=100.0, load=7000.0).efficiency

    one = example("wu2022")
    gradient = jax.jit(jax.grad(efficiency))(one)
    assert jax.tree.structure(gradient) == jax.tree.structure(one)
    # Closed form to O(λ²): η = (1 − μ)/(1 + μ) at 45°, dη/dμ = −2/(1 + μ)².
    slope = gradient.stages[0].friction.thread.coefficient
    assert slope == pytest.approx(-2 / 1.05**2, rel=1e-3)
    assert prsm.get_parameter(gradient, "screw.mass") == 0
