"""Friction of an ellipse that slides and spins: against direct integration, limits, derivatives.

The reference integrates friction over the ellipse as it is, in polar coordinates about the
instantaneous centre; the law under test is an integral over confocal ellipses.
"""

import functools

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
import scipy.special
from scenes import array

from benchmarks.references.slip_and_spin import slip_and_spin as integrated
from prsm_jax.contact import EllipseShape, ellipse_shape, hertz_contact, slip_and_spin
from prsm_jax.geometry import RelativeCurvature

#: Points: as the dynamics use it, and for long ellipses.
PLAIN, LONG = 20, 32


def _shape(major, minor, angle):
    """An ellipse whose major axis is turned by an angle from the first axis."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return EllipseShape(
        array(major**2 * cosine**2 + minor**2 * sine**2),
        array(major**2 * sine**2 + minor**2 * cosine**2),
        array((major**2 - minor**2) * cosine * sine),
        array(major * minor),
    )


@functools.cache
def _law(order):
    def law(shape, slip, spin):
        force, moment = slip_and_spin(shape, (slip[0], slip[1]), spin, order)
        return jnp.stack([*force, moment])

    return law


@functools.cache
def _batch(order):
    return jax.jit(jax.vmap(_law(order)))


def _cases(ratios, distances, count, seed, reference=integrated):
    """Random ellipses in random motion, the centre this many radii away; and their reference."""
    rng = np.random.default_rng(seed)
    shapes, slips, spins, expected = [], [], [], []
    for index in range(count):
        minor = 10 ** rng.uniform(-5, -3)
        major, turned = minor * ratios(rng), rng.uniform(0, 2 * np.pi)
        angle, spin = rng.uniform(0, 2 * np.pi), rng.choice([-1, 1]) * 10 ** rng.uniform(-2, 3)
        own = np.array([np.cos(angle), np.sin(angle)])
        away = distances(rng, index)
        if away == np.inf:
            spin = 0.0
        else:
            own = own * away * abs(spin) / np.hypot(own[0] / minor, own[1] / major)
        turn = np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
        along, across, moment = reference(major, minor, own, spin)
        shapes.append(_shape(major, minor, turned))
        slips.append(turn @ own)
        spins.append(spin)
        expected.append([*(turn @ [along, across]), moment])
    batch = jax.tree.map(lambda *leaves: jnp.stack(leaves), *shapes)
    return batch, jnp.asarray(slips), jnp.asarray(spins), np.asarray(expected)


def _errors(found, slips, spins, expected):
    """Relative: of the power, of the force as a vector, of the moment."""
    slips, spins = np.asarray(slips), np.asarray(spins)
    power, right = (np.sum(x[:, :2] * slips, 1) + x[:, 2] * spins for x in (found, expected))
    force = np.hypot(*(found - expected)[:, :2].T)
    size, moments = np.hypot(*expected[:, :2].T), np.abs(expected[:, 2])
    some = size > 1e-9
    return (
        np.max(np.abs(power / right - 1)),
        np.max(force[some] / size[some], initial=0.0),
        np.max(np.abs(found - expected)[moments > 0, 2] / moments[moments > 0], initial=0.0),
    )


def _anywhere(rng, index):
    """From the middle of the ellipse to far away; pure spin and pure sliding among them.

    Beyond a thousand radii the reference loses digits.
    """
    return (0.0, np.inf, rng.uniform(0, 1), 1 + 10 ** rng.uniform(-5, 0), 10 ** rng.uniform(0, 3))[
        index % 5
    ]


def test_long_ellipses_against_direct_integration():
    """a/b from 1 to 50, any direction, ω a/v from 0 to infinity: 1e-6 asked for."""
    shape, slip, spin, expected = _cases(
        lambda rng: 50 ** rng.uniform(0, 1), _anywhere, 120, seed=1
    )
    found = np.asarray(_batch(LONG)(shape, slip, spin))
    assert max(_errors(found, slip, spin, expected)) < 2e-7


def _near_the_edge(rng, index):
    """Where the centre crosses the edge of the ellipse: within 1e-6 to 0.1 of it, both sides."""
    return 1 + rng.choice([-1, 1]) * 10 ** rng.uniform(-6, -1)


@pytest.mark.parametrize("ratio", [1.0, 1.5, 3.0, 5.0, 10.0])
def test_the_rule_of_the_dynamics_against_direct_integration(ratio):
    """Wherever the centre lies, also at the edge of the ellipse: 1e-6 asked for.

    The reference is good to 2e-8 near the edge, where chords vanish like a root.
    """
    for places, seed in ((_anywhere, 2), (_near_the_edge, 3)):
        shape, slip, spin, expected = _cases(lambda rng: ratio, places, 20, seed=seed)
        found = np.asarray(_batch(PLAIN)(shape, slip, spin))
        assert max(_errors(found, slip, spin, expected)) < 2e-7


def test_the_rule_of_the_dynamics_converges():
    """Twice as many points change nothing: far from the edge, and at it, up to a/b = 5."""
    for places, seed in ((_anywhere, 5), (_near_the_edge, 6)):
        shape, slip, spin, _ = _cases(
            lambda rng: 5 ** rng.uniform(0, 1), places, 60, seed, lambda *_: (0.0, 0.0, 0.0)
        )
        found, more = (np.asarray(_batch(order)(shape, slip, spin)) for order in (PLAIN, 48))
        assert max(_errors(found, slip, spin, more)) < 2e-10


def test_pure_spin_and_pure_sliding_in_closed_form():
    """3/8 a E(m) and no force; the direction of the slip and no moment; nothing at rest."""
    for major, minor in ((3e-4, 3e-4), (3e-4, 2e-4), (4e-4, 1e-5)):
        shape, law = _shape(major, minor, 0.7), _law(LONG)
        spinning = law(shape, jnp.zeros(2), array(-20.0))
        expected = -3 / 8 * major * scipy.special.ellipe(1 - (minor / major) ** 2)
        assert spinning[2] == pytest.approx(expected, rel=1e-7)
        np.testing.assert_allclose(spinning[:2], 0.0, atol=1e-15)
        np.testing.assert_allclose(
            law(shape, jnp.asarray([3.0, -4.0]), array(0.0)), [0.6, -0.8, 0.0], atol=1e-13
        )
        np.testing.assert_array_equal(law(shape, jnp.zeros(2), array(0.0)), 0.0)


@pytest.mark.parametrize(("share", "accuracy"), [(0.02, 1e-4), (0.2, 5e-3), (0.5, 0.04)])
def test_slow_spin_adds_the_second_moment_along_the_slip(share, accuracy):
    """Φ − v → ω² ⟨x'²⟩/2v with ⟨x'²⟩ = (a² cos²φ + b² sin²φ)/5; within 4 % up to ω a/v = 0.5."""
    major, minor = 4e-4, 3e-4
    for angle in (0.0, 0.6, np.pi / 2):
        slip, spin = np.array([np.cos(angle), np.sin(angle)]), share / major
        found = np.asarray(_law(PLAIN)(_shape(major, minor, 0.0), jnp.asarray(slip), array(spin)))
        added = found[:2] @ slip + found[2] * spin - 1
        second = (major**2 * np.cos(angle) ** 2 + minor**2 * np.sin(angle) ** 2) / 5
        assert added == pytest.approx(spin**2 * second / 2, rel=accuracy)
        # Local slip lowers the force along the slip, by as much as the moment takes half of.
        assert found[:2] @ slip < 1


def test_force_and_moment_are_the_gradient_of_the_power():
    """With Φ = F_t·v + M ω (Euler), ∂Φ/∂v = F_t and ∂Φ/∂ω = M: limited by the rule's order."""
    law = _law(LONG)

    @jax.jit
    @jax.vmap
    def gradient(shape, motion):
        def potential(motion):
            return law(shape, motion[:2], motion[2]) @ motion

        return jax.grad(potential)(motion), law(shape, motion[:2], motion[2])

    shape, slip, spin, _ = _cases(
        lambda rng: 20 ** rng.uniform(0, 1), _anywhere, 60, 4, lambda *_: (0.0, 0.0, 0.0)
    )
    found, direct = gradient(shape, jnp.concatenate([slip, spin[:, None]], axis=1))
    for part in (slice(0, 2), slice(2, 3)):
        scale = np.maximum(np.linalg.norm(direct[:, part], axis=1, keepdims=True), 1e-9)
        assert np.max(np.abs(found - direct)[:, part] / scale) < 1e-5


POINTS = {
    "ordinary": (4e-4, 3e-4, (0.9, 0.3), 600.0),
    "standstill of the slip": (4e-4, 3e-4, (0.0, 0.0), 600.0),
    "no spin": (4e-4, 3e-4, (0.9, 0.3), 0.0),
    "circle": (3e-4, 3e-4, (0.9, 0.3), 600.0),
    "circle, centre inside": (3e-4, 3e-4, (0.01, 0.02), 600.0),
    "centre inside": (4e-4, 3e-4, (0.05, 0.02), 600.0),
}


@pytest.mark.parametrize("point", POINTS)
def test_derivatives_forward_and_reverse(point):
    """Of force and moment by slip, spin and the curvatures, against central differences.

    The curvatures move the ellipse through Hertz's theory; at a circle they split its axes.
    """
    major, minor, slip, spin = POINTS[point]
    split = 0.0 if major == minor else 0.15

    def law(numbers):
        # Curvatures of an ellipse of about these axes, in axes that are not its own.
        total = 300.0 * (1 + numbers[3])
        deviation, twist = 150.0 * (split + numbers[4]), 150.0 * (split / 2 + numbers[5])
        curvature = RelativeCurvature(total, deviation**2 + twist**2, total / 2 + deviation, twist)
        hertz = hertz_contact(
            array(1.15e11 * 400 * major**3), total, curvature.difference_squared, array(1.15e11)
        )
        shape = ellipse_shape(hertz, curvature)
        moved = (slip[0] + numbers[0], slip[1] + numbers[1])
        force, moment = slip_and_spin(shape, moved, spin + 1e3 * numbers[2], LONG)
        return jnp.stack([*force, 1e4 * moment])

    nothing, step = jnp.zeros(6), 1e-5
    forward, reverse = (jax.jit(f(law))(nothing) for f in (jax.jacfwd, jax.jacrev))
    evaluate = jax.jit(jax.vmap(law))
    ahead, behind = evaluate(step * jnp.eye(6)), evaluate(-step * jnp.eye(6))
    expected = np.asarray((ahead - behind) / (2 * step)).T
    assert np.all(np.isfinite(forward))
    assert np.all(np.isfinite(reverse))
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(reverse, forward, atol=1e-9 * scale)
    # Third derivatives over six: the truncation of the differences.
    np.testing.assert_allclose(forward, expected, atol=2e-6 * scale)


def test_the_ellipse_lies_where_the_gap_is_flat():
    """Semi-axes and direction of the major axis from the gap's tensor, by an eigenproblem."""
    tensor = np.array([[140.0, 25.0], [25.0, 190.0]])
    values, vectors = np.linalg.eigh(tensor)
    total = values.sum()
    hertz = hertz_contact(
        array(50.0), array(total), array((values[1] - values[0]) ** 2), array(1.15e11)
    )
    curvature = RelativeCurvature(
        array(total), array((values[1] - values[0]) ** 2), array(140.0), array(25.0)
    )
    shape = ellipse_shape(hertz, curvature)
    matrix = [[shape.first, shape.mixed], [shape.mixed, shape.second]]
    axes, directions = np.linalg.eigh(np.asarray(matrix))
    np.testing.assert_allclose(np.sqrt(axes), [hertz.semi_minor, hertz.semi_major], rtol=1e-12)
    assert abs(directions[:, 1] @ vectors[:, 0]) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("thinner", [1e-7, 6e-6, 1.2e-5, 1.4e-5, 5e-5])
def test_nearly_round_ellipses_keep_their_axes(thinner):
    """(a² − b²)/(B − A) of κ = 1 − `thinner`, whose B/A follows in 40 digits, on either branch."""
    with mpmath.workdps(40):
        ratio = 1 - mpmath.mpf(thinner)
        m = 1 - ratio**2
        first, second = mpmath.ellipk(m), mpmath.ellipe(m)
        quotient = (first - second) / (second / ratio**2 - first)
        anisotropy = (1 - quotient) / (1 + quotient)
        expected = float(m / anisotropy)
    total, twist, squared = array(330.0), array(1.0), array((330.0 * float(anisotropy)) ** 2)
    hertz = hertz_contact(array(50.0), total, squared, array(1.15e11))
    shape = ellipse_shape(hertz, RelativeCurvature(total, squared, total / 2, twist))
    found = float(-shape.mixed * total / hertz.semi_major**2)
    # Where the ellipse counts as long the difference a² − b² loses 1e-16/τ.
    assert found == pytest.approx(expected, rel=2e-10)
