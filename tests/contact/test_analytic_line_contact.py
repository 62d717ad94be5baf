"""Line contact of rings by shape functions: gap, closed forms, force balance, derivatives."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, example

import prsm_jax as prsm
from prsm_jax.contact import line_contact, line_contact_under_force
from prsm_jax.geometry import (
    fit_parabola,
    matched_profile_angle,
    ring_gap,
    ring_vertex,
)
from prsm_jax.halfspace import ring_contact
from tests.present import present

MODULUS = 210e9 / (2 * (1 - 0.3**2))
FLANKS = example("ring_roller").stages[0].line_contact

_under = eqx.filter_jit(line_contact_under_force)
_vertex = eqx.filter_jit(ring_vertex)


def flanks(lead_angle=5.0, **angles):
    """The example's flanks with other angles [deg]."""
    changed = {"lead_angle": lead_angle, **angles}
    return eqx.tree_at(
        lambda c: [getattr(c, name) for name in changed],
        FLANKS,
        [array(np.radians(value)) for value in changed.values()],
    )


def under(contact, force=55.0):
    return _under(contact, array(force), array(MODULUS))


def test_coefficient_in_closed_form():
    """tan j d/(2 r (d − r)) is exact without a lead, and 1.4 % low with 5°."""
    radius = array(9e-3)
    ring = flanks()
    slope, distance = jnp.tan(ring.screw_profile_angle), ring.centre_distance
    closed = slope * distance / (2 * radius * (distance - radius))
    without, with_lead = (_vertex(flanks(psi), radius) for psi in (0.0, 5.0))
    assert float(without.coefficient) == pytest.approx(float(closed), rel=1e-12)
    assert abs(float(without.arc)) < 1e-15
    assert float(with_lead.coefficient / closed) == pytest.approx(1.0139, abs=2e-4)


def test_vertex_is_the_minimum_of_the_exact_gap():
    """Against a fine grid, and its place against the small-angle L/(2π d tan j)."""
    radius, contact = array(8.5e-3), flanks()
    vertex = _vertex(contact, radius)
    arcs = vertex.arc + jnp.linspace(-1e-4, 1e-4, 2001)
    gaps = jax.vmap(lambda y: ring_gap(contact, radius, y))(arcs)
    assert int(jnp.argmin(gaps)) == 1000
    small = -11e-3 * np.tan(np.radians(5)) / (20e-3 * np.tan(np.radians(30)))
    assert float(vertex.arc / radius) == pytest.approx(small, rel=0.02)
    fit = fit_parabola(contact, radius, vertex, array(1e-4))
    assert float(fit.coefficient) == pytest.approx(float(vertex.coefficient), rel=1e-4)
    assert 0.999 <= float(fit.determination) <= 1


def test_determination_is_that_of_least_squares():
    """R² of NumPy's parabola through the same gaps, over a width where it is visibly below 1."""
    radius, contact, half = array(8.5e-3), flanks(), 2e-3
    vertex = _vertex(contact, radius)
    share = np.linspace(-1, 1, 33)
    gap = jax.vmap(lambda y: ring_gap(contact, radius, y))(vertex.arc + jnp.asarray(share * half))
    gap = np.asarray(gap - vertex.gap)
    best = np.polynomial.Polynomial.fit(share, gap, 2, domain=[-1, 1])
    missed = np.sum((gap - best(share)) ** 2) / np.sum((gap - gap.mean()) ** 2)
    assert missed > 1e-7
    fit = fit_parabola(contact, radius, vertex, array(half))
    assert float(fit.coefficient) == pytest.approx(best.coef[2] / half**2, rel=1e-9)
    # 1 − R² is a difference of numbers near 1.
    assert float(1 - fit.determination) == pytest.approx(missed, rel=1e-6, abs=1e-14)


def test_without_a_lead_all_slices_bear_alike():
    """P = F/(zone n_z/cos k) and Hertz's line contact in every slice."""
    found = under(flanks(0.0))
    line_load = 55.0 / 2e-3
    np.testing.assert_allclose(found.line_load, line_load, rtol=1e-9)
    assert float(found.approach) == pytest.approx(2 * line_load / (np.pi * MODULUS), rel=1e-9)
    assert float(found.loaded_share) == 1
    assert float(found.edge_ratio) == pytest.approx(1, abs=1e-9)
    curvature = np.asarray(found.slices.coefficient)
    half_width = np.sqrt(2 * line_load / (np.pi * MODULUS * curvature))
    np.testing.assert_allclose(found.half_width, half_width, rtol=1e-9)
    np.testing.assert_allclose(found.pressure, 2 * line_load / (np.pi * half_width), rtol=1e-9)


@pytest.mark.parametrize("lead_angle", [0.0, 0.3, 5.0])
@pytest.mark.parametrize("force", [1e-6, 55.0, 5e4])
def test_force_is_carried_and_stiffness_is_its_derivative(lead_angle, force):
    contact = flanks(lead_angle)
    found = under(contact, force)
    assert bool(found.converged)
    assert float(found.axial_force) == pytest.approx(force, rel=1e-10)
    assert float(found.normal_force) > float(found.axial_force)
    step = 1e-4 * force
    ahead, behind = under(contact, force + step), under(contact, force - step)
    slope = 2 * step / float(ahead.approach - behind.approach)
    normal = float(np.mean(found.slices.normal))
    # Axial approach and force; the normal varies by 0.1 % over the zone, the slices are finite.
    assert float(found.stiffness_tangent) == pytest.approx(slope * normal, rel=5e-3)


def test_slices_are_fine_enough():
    """Twice as many slices change the largest pressure of an edge contact by little."""
    contact = flanks()
    finer = line_contact_under_force(contact, array(55.0), array(MODULUS), 257)
    assert float(finer.max_pressure) == pytest.approx(float(under(contact).max_pressure), rel=1e-3)


def test_equal_angles_bear_at_the_crest_and_matched_ones_at_both_ends():
    """tan²k = tan²j + (L/2πρ)²: parallel in the middle, hollow by half a micrometre."""
    contact = flanks()
    equal = under(contact)
    assert float(equal.loaded_share) < 0.2
    assert int(jnp.argmax(equal.pressure)) == len(equal.pressure) - 1
    angle = jax.jit(matched_profile_angle)(contact)
    closed = np.arctan(np.sqrt(np.tan(np.pi / 6) ** 2 + np.tan(np.radians(5)) ** 2))
    assert float(angle) == pytest.approx(closed, abs=1e-4)
    matched = under(flanks(roller_profile_angle=float(np.degrees(angle))))
    assert float(matched.max_pressure) < 0.6 * float(equal.max_pressure)
    assert float(matched.pressure[0]) > 0
    assert float(matched.pressure[-1]) > 0
    assert float(matched.pressure[64]) < float(matched.pressure[0])


NAMES = ("lead_angle", "centre_distance", "screw_profile_angle", "roller_profile_angle")


def test_derivatives_of_the_largest_pressure():
    """Forward, reverse and differences, at fixed load, bearing on a part of the zone."""
    contact = flanks(4.0)

    def pressure(values):
        moved = eqx.tree_at(lambda c: [getattr(c, n) for n in NAMES], contact, list(values))
        return line_contact_under_force(moved, array(55.0), array(MODULUS)).max_pressure

    here = tuple(getattr(contact, name) for name in NAMES)
    reverse = np.array(jax.jit(jax.grad(pressure))(here))
    tangents = tuple(array(w) for w in (0.3, 1e-3, -0.2, 0.1))
    _, forward = jax.jit(lambda h: jax.jvp(pressure, (h,), (tangents,)))(here)
    assert float(forward) == pytest.approx(float(np.dot(reverse, tangents)), rel=1e-10)
    program, step = jax.jit(pressure), 1e-6
    ends = [program(tuple(h + s * step * t for h, t in zip(here, tangents, strict=True)))
            for s in (1, -1)]  # fmt: skip
    assert float(forward) == pytest.approx(float(ends[0] - ends[1]) / (2 * step), rel=1e-5)


def test_open_contact_is_finite():
    found = under(FLANKS, 0.0)
    leaves = [leaf for leaf in jax.tree.leaves(found) if leaf.dtype != bool]
    assert all(np.all(np.isfinite(leaf)) for leaf in leaves)
    assert float(found.max_pressure) == 0
    slope = jax.jit(
        jax.grad(
            lambda f: line_contact_under_force(present(FLANKS), f, array(MODULUS)).max_pressure
        )
    )
    assert float(slope(array(-1.0))) == 0


def test_a_stage_shares_its_load():
    """2.75 kN on 5 rollers with 10 rings each: 55 N; and the words without flanks."""
    stage = example("ring_roller").stages[0]
    found = eqx.filter_jit(line_contact)(stage, array(2750.0))
    assert float(found.axial_force) == pytest.approx(55.0, rel=1e-10)
    with pytest.raises(prsm.MissingDataError, match="line_contact"):
        line_contact(example("lisowski2014").stages[0], array(1.0))


def test_slices_against_the_half_space():
    """In the middle of a parallel pair as the slices say, less what the ends take; more at them."""
    solve = eqx.filter_jit(lambda c: ring_contact(c, array(55.0), array(MODULUS), shape=(64, 32)))
    straight, skewed = solve(flanks(0.0)), solve(flanks(5.0))
    for found, contact in ((straight, flanks(0.0)), (skewed, flanks(5.0))):
        assert int(found.code) == 0
        slices = under(contact)
        assert float(found.load) == pytest.approx(float(slices.normal_force), rel=1e-6)
        assert float(found.max_pressure) > 1.5 * float(slices.max_pressure)
    rows = np.max(np.asarray(straight.pressure), axis=1)
    slices = under(flanks(0.0))
    assert 0.9 < rows[32] / float(slices.pressure[64]) < 1
    loaded = rows[rows > 0]
    assert min(loaded[0], loaded[-1]) > 1.5 * rows[32]
    # A contact at the crest reaches about as far as the slices say.
    rows = np.max(np.asarray(skewed.pressure), axis=1)
    reach = np.sum(rows > 0) * float(skewed.grid.spacing_x)
    length = 2e-3 / np.cos(np.pi / 6)
    assert reach == pytest.approx(float(under(flanks(5.0)).loaded_share) * length, rel=0.15)
