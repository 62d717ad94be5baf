"""Derivatives of modes where roots repeat: what is differentiable is right, the rest is named.

The stage of Wu et al. 2022 with 7 rollers has five repeated roots, four of them double and one
fourfold. It is moved along paths that split them (unequal rollers) and that do not (one spring of
all rollers).
"""

import dataclasses
import functools
import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, example

import prsm_jax as prsm
from prsm_jax.vibration import (
    RollerScatter,
    clusters,
    dense_matrices,
    dense_modes,
    directional_derivatives,
    kinetic_energies,
    spring_network,
    strain_energies,
    symmetric_modes,
)
from prsm_jax.vibration.arrowhead._arrowhead import arrowhead_modes
from tests.present import present

DIRECTION = np.array([0.3, -0.5, 0.9, 0.1, -0.7, 0.4, 1.1])
PATHS = ("stiffness", "mass", "position", "support", "equal")


@functools.cache
def _system():
    # The file is read outside of any trace.
    with jax.ensure_compile_time_eval():
        return prsm.modal(example("wu2022"), shapes=True).system


def _system_at(t, path):
    """The stage a little way along a path; the first three make rollers unequal."""
    system, numbers = _system(), tuple(range(1, 8))
    one = 1 + t * jnp.asarray(DIRECTION)
    even = system.roller_positions
    scatter = {
        "stiffness": RollerScatter(even, stiffness_factor=one, numbers=numbers),
        "mass": RollerScatter(even, mass_factor=one, numbers=numbers),
        "position": RollerScatter(even + t * jnp.asarray(DIRECTION), numbers=numbers),
    }.get(path)
    screw, *others = system.bodies
    if path == "support":
        screw = dataclasses.replace(screw, radial_support_y=screw.radial_support * (1 + 100 * t))
    if path == "equal":
        screw = dataclasses.replace(screw, mesh_stiffness=screw.mesh_stiffness * (1 + t))
    return dataclasses.replace(
        present(system), bodies=(screw, *others), scatter=scatter, carrier=None
    )


def _observed(t, path):
    """Frequencies, and energies of each mode as shares of one scale."""
    system = _system_at(t, path)
    group = dense_modes(system).group("coupled")
    network, shapes = spring_network(system), group.shapes[..., 0]
    strain = strain_energies(network, shapes)["screw_roller"] / 1e10
    kinetic = kinetic_energies(network, shapes, each_roller=True)["roller 2"]
    return jnp.stack([group.frequencies / 1e4, strain, kinetic])


@functools.cache
def _compiled(path):
    observed = functools.partial(_observed, path=path)
    return (
        jax.jit(observed),
        jax.jit(jax.jacfwd(observed)),
        jax.jit(jax.jacrev(observed)),
        jax.jit(jax.jacfwd(jax.jacrev(observed))),
    )


def _means(rows):
    """Mean over the members of each repeated root of the equal stage."""
    values = np.asarray(_compiled("equal")[0](array(0.0)))[0] ** 2
    members = np.asarray(clusters(jnp.asarray(values))).astype(float)
    assert sorted(members.sum(1)) == [1.0] * 4 + [2.0] * 8 + [4.0] * 4
    return np.asarray(rows) @ (members / members.sum(1)).T


@pytest.mark.parametrize("path", PATHS)
def test_clusters(path):
    """First and second derivatives of sums over a cluster, against central differences.

    The path through a repeated root is smooth for them whether it splits or not. Differences with
    a step of 1e-4 are good to 1e-8 of third derivatives, which reach 1e3 where energies of
    a single roller are concerned, and the second ones to 1e-16/1e-8 besides.
    """
    value, forward, reverse, second = _compiled(path)
    zero, step = array(0.0), 1e-4
    before, here, after = (_means(value(array(t))) for t in (-step, 0.0, step))
    first = _means(forward(zero))
    np.testing.assert_allclose(_means(reverse(zero)), first, atol=1e-13 * np.abs(first).max())
    np.testing.assert_allclose(first, (after - before) / (2 * step), atol=2e-5)
    found = _means(second(zero))
    difference = (after - 2 * here + before) / step**2
    np.testing.assert_allclose(found, difference, atol=1e-5 * max(np.abs(found).max(), 1.0))


@pytest.mark.parametrize("path", PATHS)
def test_members_part_along_a_direction(path):
    """One-sided slopes of every frequency, sorted, against one-sided differences.

    The single member of a split cluster has these only: no gradient could give both of them.
    """
    slopes = jax.jit(lambda t: directional_derivatives(functools.partial(_system_at, path=path), t))
    found, value = slopes(array(0.0)), _compiled(path)[0]
    step = 1e-6
    before, here, after = (np.asarray(value(array(t)))[0] * 1e4 for t in (-step, 0.0, step))
    np.testing.assert_allclose(found.frequencies, here, rtol=1e-13)
    # Curvature times the step, and the rounding of 1e4 Hz over it.
    np.testing.assert_allclose(found.forward, (after - here) / step, atol=0.2)
    np.testing.assert_allclose(found.backward, (here - before) / step, atol=0.2)
    parted = not np.allclose(found.forward, found.backward, rtol=1e-6, atol=1e-2)
    assert parted == (path != "equal")


def test_a_dense_eigensolver_fails_where_this_does_not():
    """Why: JAX's own derivatives are wrong or not finite at the same point.

    They divide by the gaps of equal frequencies: zero, or what rounding leaves of them.
    """

    def plain(t):
        stiffness, mass = dense_matrices(_system_at(t, "stiffness"))
        weight = 1 / jnp.sqrt(mass)
        values, vectors = jnp.linalg.eigh(stiffness * weight[:, None] * weight[None, :])
        return jnp.sqrt(values), vectors[0] ** 2

    frequencies, energy = jax.jit(jax.jacfwd(plain))(array(0.0))
    assert not np.all(np.abs(energy) < 1e6)
    ours = directional_derivatives(functools.partial(_system_at, path="stiffness"))
    # Single members of the clusters: not what they do on either side.
    assert np.max(np.abs(frequencies / (2 * np.pi) - ours.forward)) > 100


def test_equal_rollers_by_both_paths():
    """Where the change keeps the symmetry, each dense derivative is that of the reduced path."""

    def reduced(t):
        return symmetric_modes(_system_at(t, "equal")).frequencies

    first = jax.jit(jax.jacfwd(reduced))(array(0.0))
    dense = _compiled("equal")[1](array(0.0))[0] * 1e4
    np.testing.assert_allclose(dense, first, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("ratio", [1.0, 1e-12])
def test_closed_form_of_the_second_derivative(ratio):
    """λ″ of the reduced path: 2 Σ (φ_aᵀ K′ φ_i)² / (λ_i − λ_a) for K″ = M′ = 0, by NumPy.

    Also where the supports are 1e12 times softer than the contacts.
    """
    system = dataclasses.replace(present(_system()), carrier=None)
    system = dataclasses.replace(
        system,
        bodies=tuple(
            dataclasses.replace(body, torsional_support=body.torsional_support * ratio)
            for body in system.bodies
        ),
    )

    def squares(t):
        screw, *others = system.bodies
        screw = dataclasses.replace(screw, mesh_stiffness=screw.mesh_stiffness * (1 + t))
        moved = dataclasses.replace(system, bodies=(screw, *others))
        return (2 * jnp.pi * symmetric_modes(moved).group("torsional").frequencies) ** 2

    second = np.asarray(jax.jit(jax.hessian(squares))(array(0.0)))
    modes = symmetric_modes(system, shapes=True)
    shapes = np.asarray(modes.group("torsional").shapes[..., 0])
    values = np.asarray(squares(array(0.0)))
    network = spring_network(system)
    screw = np.array([spring.name == "screw_roller" for spring in network.springs])
    stretch = np.asarray(network.rows)[screw] @ shapes
    projected = stretch.T @ (np.asarray(network.stiffness)[screw][:, None] * stretch)
    gaps = values[None, :] - values[:, None] + np.eye(len(values))
    expected = 2 * np.sum(np.where(np.eye(len(values)) > 0, 0.0, projected**2 / gaps), axis=0)
    # The softest mode's is a difference of larger terms at most as large as itself over 1e-12.
    np.testing.assert_allclose(second, expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())


def _three_bodies(factor):
    """Three bodies on supports, meshing with one roller: K, its spring rows and their stiffness."""
    support, mesh = np.array([2e8, 5e8, 1.1e9]), np.array([1e8, 2.5e8, 1.5e8])
    rows = np.hstack([factor * np.eye(3), np.ones((3, 1))])
    stiffness = np.diag([*support, 0.0]) + rows.T @ (mesh[:, None] * rows)
    return support, mesh, np.array([1.0, 0.8, 0.9, 0.2]), rows, stiffness


def _dense(factor):
    """Eigenvalues and stretches of the meshes, the roller moving forward, by NumPy."""
    _, _, mass, rows, stiffness = _three_bodies(factor)
    root = np.sqrt(mass)
    values, shapes = np.linalg.eigh(stiffness / root[:, None] / root[None])
    shapes = shapes / root[:, None]
    shapes = shapes * np.sign(shapes[-1])
    return values, (rows @ shapes).T


def test_modes_follow_the_number_of_rollers():
    """√N is the factor between a body and the roller coordinate: against differences of NumPy.

    Of the eigenvalues the closed form too: dλ/dF = 2 Σ k q e.
    """
    factor = math.sqrt(5.0)
    support, mesh, mass, _, stiffness = _three_bodies(factor)

    def modes(factor):
        found = arrowhead_modes(
            *(tuple(array(v) for v in values) for values in (support, mesh, mass)), factor
        )
        signs = [jnp.sign(shape[-1]) for shape in found.shapes]
        stretches = [
            jnp.stack([sign * e for e in row])
            for sign, row in zip(signs, found.stretches, strict=True)
        ]
        return jnp.stack(found.values), jnp.stack(stretches)

    values, stretches = jax.jit(modes)(array(factor))
    np.testing.assert_allclose(values, _dense(factor)[0], rtol=1e-12)
    np.testing.assert_allclose(stretches, _dense(factor)[1], rtol=1e-9)
    forward = jax.jit(jax.jacfwd(modes))(array(factor))
    reverse = jax.jit(jax.jacrev(modes))(array(factor))
    step = 1e-5
    sides = [_dense(factor + x) for x in (step, -step)]
    for ours, theirs, above, below in zip(forward, reverse, *sides, strict=True):
        np.testing.assert_allclose(theirs, ours, rtol=1e-10)
        # Truncation, and rounding over the step.
        difference = (above - below) / (2 * step)
        np.testing.assert_allclose(ours, difference, rtol=1e-6, atol=1e-9 * np.max(np.abs(above)))
    bodies = (np.asarray(stretches) - _roller(stiffness, mass)[:, None]) / factor
    closed = 2 * np.sum(mesh * bodies * np.asarray(stretches), axis=1)
    np.testing.assert_allclose(forward[0], closed, rtol=1e-10)


def _roller(stiffness, mass):
    """The roller's amplitude in every mode, forward."""
    root = np.sqrt(mass)
    _, shapes = np.linalg.eigh(stiffness / root[:, None] / root[None])
    return np.abs(shapes[-1]) / root[-1]


def test_unequal_rollers_by_name():
    """A gradient with respect to one roller's stiffness, from the mechanism on."""
    unequal = (prsm.mechanism.UnequalRoller(3, stiffness_factor=0.9),)
    wu = eqx.tree_at(lambda m: m.stages[0].unequal_roller, example("wu2022"), unequal)

    def frequencies(factor):
        moved = prsm.set_parameter(wu, "unequal_roller.3.stiffness_factor", factor)
        return prsm.compute(moved, ["natural_frequencies", "lowest_transverse_frequency"])

    point, step = array(0.9), 1e-5
    evaluate = jax.jit(frequencies)
    after, before = evaluate(point + step), evaluate(point - step)
    forward = jax.jit(jax.jacfwd(frequencies))(point)
    reverse = jax.jit(jax.jacrev(frequencies))(point)
    for name, slope in forward.items():
        difference = (np.asarray(after[name]) - np.asarray(before[name])) / (2 * step)
        # Roots of a stage with one odd roller still repeat three times for the roller modes, but
        # this change keeps them together. Rounding: 1e-11 Hz over the step.
        np.testing.assert_allclose(slope, difference, rtol=1e-6, atol=1e-4)
        np.testing.assert_allclose(reverse[name], slope, rtol=1e-10, atol=1e-8)
