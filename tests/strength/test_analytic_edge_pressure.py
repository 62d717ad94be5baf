"""The peak of pressure at a rounded crest: half-plane in closed form, half-spaces, limits."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from truncation_scenes import screw_of_30_mm, without_addenda

import prsm_jax as prsm
from benchmarks.references.meshing import Design
from benchmarks.references.truncated import hertz_pressure, pressures
from prsm_jax import strength
from prsm_jax.contact import (
    RoundedEdge,
    edge_ratio,
    largest_pressure,
    opposite_onset,
    pressure_ratio,
)
from prsm_jax.halfspace import flank_contact
from tests.present import present
from tests.roots import root_between

_compute = eqx.filter_jit(prsm.compute)
_MODULUS = 210e9 / (1 - 0.3**2) / 2


def _rounded(one, radius=0.1e-3):
    thread = dataclasses.replace(one.stages[0].thread, edge_radius=array(radius))
    stage = dataclasses.replace(one.stages[0], thread=thread)
    return dataclasses.replace(one, stages=(stage,))


def _half_plane(steepness, intensity, share):
    """Largest pressure of the half-plane with a parabola past its edge, by quadrature.

    Lengths over the half-extent, pressures over that of Hertz. The slope (l − u)/ρ along the part
    u < l past the edge makes the pressure √y/2π ∫ (l − u)/(√u (y − u)) du, beside 2K/g √y.
    """
    stress = intensity * share / np.sqrt(2)

    def far(length):
        # What is left of K, which the far field of that pressure has to be.
        whole = quad(lambda w: 2 * (length - w**2), 0, np.sqrt(length))[0]
        return stress * (1 - length / share) - steepness / (2 * np.pi) * whole

    length = root_between(far, 1e-14, share)

    def pressure(depth):
        # The principal value, with u = w² so that only that place is singular.
        middle = np.sqrt(depth)
        part = quad(
            lambda w: -2 * (length - w**2) / (middle + w),
            0,
            np.sqrt(length),
            weight="cauchy",
            wvar=middle,
        )[0]
        return steepness / (2 * np.pi) * middle * part + 2 * stress / share * middle

    # Of the part from the edge alone the place is known; that of the sum is near it.
    found: Any = minimize_scalar(
        lambda v: -pressure(v * length), bounds=(0.5, 0.95), method="bounded"
    )
    at_peak = pressure(length / 1.1996786402577338**2)
    return at_peak, -found.fun


@pytest.mark.parametrize("share", [0.05, 0.3, 0.7])
@pytest.mark.parametrize("steepness", [30.0, 300.0])
def test_the_law_is_that_of_a_half_plane(steepness, share):
    """By quadrature with the intensity of the law; at the place of the peak of the edge's part."""
    edge = RoundedEdge(array(2e9), array(steepness), array(1.2), "to_roller_axis")
    pressure = array(2e9 / (1 - share))
    blunt = 1 + 3.02 / (steepness * np.sqrt(share))
    intensity = 1 - 0.284 * np.sqrt(share / 1.2) / blunt
    expected, highest = _half_plane(steepness, intensity, share)
    found = float(edge_ratio(pressure, edge))
    np.testing.assert_allclose(found, expected, rtol=1e-8)
    # Where the whole pressure is largest it is hardly larger, but for a slight and blunt cut.
    assert found <= highest * (1 + 1e-6)
    if share > 0.1:
        assert found > 0.97 * highest
    # What is cut off at the other end presses this one harder.
    both = float(edge_ratio(pressure, edge, array(2e9)))
    assert 1 < both / found < 1 + 0.25 * share**2


@pytest.mark.parametrize(
    ("lead", "pressure", "radius"),
    [(5e-3, 4.2e9, 1e-4), (3e-3, 3.5e9, 3e-5), (3e-3, 3.5e9, 3e-4), (2e-3, 4.2e9, 1e-4)],
)
@pytest.mark.parametrize("side", ["screw", "nut"])
def test_peaks_on_true_flanks_against_half_spaces_of_numpy(side, lead, pressure, radius):
    """Cut by 0.3 to 0.7 of the half-extent; 128 cells a side resolve the peaks to 4 %."""
    design = Design(lead, 5.0, 5e-3, np.pi / 4, 5e-3 / np.sin(np.pi / 4))
    unit, _, _ = hertz_pressure(design, side, 100.0, _MODULUS)
    force, height = 100.0 * (pressure / unit) ** 3, 0.2 * lead / 5
    _, expected = pressures(design, side, (height, height), force, _MODULUS, 128, radius)
    one = _rounded(screw_of_30_mm(lead), radius).stages[0]
    index = ("screw", "nut").index(side)
    onset, edges = strength.side_onsets(one)[index], strength.side_edges(one)[index]
    found = largest_pressure(array(pressure), onset.onsets, edges) / pressure
    # The law's own 4 %, and that of the grid.
    np.testing.assert_allclose(found, expected, rtol=0.08)
    assert expected > 1.3 * float(pressure_ratio(array(pressure), onset.onsets)) or radius > 1e-4


def test_the_solver_on_the_flanks_takes_the_radius_of_the_thread():
    one = _rounded(screw_of_30_mm(3e-3, load=3e5)).stages[0]

    @eqx.filter_jit
    def largest(one):
        found = flank_contact(one, "nut", 3e5, (48, 192), extent=1.3, tolerance=1e-5)
        return found.surface.max_pressure / found.hertz.max_pressure, found.surface.code

    found, code = largest(one)
    assert int(code) == 0
    onset, edges = strength.side_onsets(one)[1], strength.side_edges(one)[1]
    pressure = onset.pressure(array(3e5))
    law = largest_pressure(pressure, onset.onsets, edges) / pressure
    # The edge, not the middle.
    assert float(found) > 1.3
    # Twice as many cells change it by 1 %; the law's own 4 %.
    np.testing.assert_allclose(law, found, rtol=0.05)


def test_quantities_are_those_of_the_worst_contact():
    """Under the operating and the largest load, which a duty cycle has."""
    one = _rounded(screw_of_30_mm(3e-3, load=1e5))
    cycle = prsm.mechanism.DutyCycle(jnp.ones(2), jnp.ones(2), jnp.asarray([4e5, -2e5]))
    one = eqx.tree_at(lambda m: m.duty_cycle, one, cycle, is_leaf=lambda x: x is None)
    names = ["edge_pressure", "edge_pressure_largest", "max_pressure"]
    found = {k: float(np.ravel(v)[0]) for k, v in _compute(one, names).items()}
    sides, edges = strength.side_onsets(one.stages[0]), strength.side_edges(one.stages[0])
    for name, load in (("edge_pressure", 1e5), ("edge_pressure_largest", 4e5)):
        values = []
        for side, of_side in zip(present(sides), edges, strict=True):
            hertz = side.pressure(array(load))
            values.append(float(hertz * pressure_ratio(hertz, side.onsets)))
            for edge in of_side:
                values.append(float(hertz * edge_ratio(hertz, edge, opposite_onset(edge, of_side))))
        np.testing.assert_allclose(found[name], max(values), rtol=1e-12)
    assert found["edge_pressure_largest"] > 1.5 * found["max_pressure"]


def test_a_whole_ellipse_has_no_edge():
    """Below the onset the largest pressure is that of Hertz; there it goes over steadily."""
    one = _rounded(screw_of_30_mm(5e-3))
    side, edges = strength.side_onsets(one.stages[0])[0], strength.side_edges(one.stages[0])[0]
    first = min(float(x) for x in side.onsets)
    for share in (0.0, 0.5, 1 - 1e-9, 1 + 1e-6):
        pressure = array(first * share)
        found = float(largest_pressure(pressure, side.onsets, edges))
        np.testing.assert_allclose(found, float(pressure), rtol=1e-9)
        slope = jax.grad(lambda p: largest_pressure(p, side.onsets, edges))(pressure)
        np.testing.assert_allclose(slope, 1.0, rtol=1e-3)


@pytest.mark.parametrize("pressure", [2.5e9, 4e9, 2e10])
def test_derivatives_against_differences(pressure):
    """To the load, the place of the edge, its radius and the ellipse, both modes."""
    given = jnp.asarray([pressure, 2e9, 120.0, 0.9, 2.2e9])

    def of(x):
        edge = RoundedEdge(x[1], x[2], x[3], "to_roller_axis")
        return edge_ratio(x[0], edge, x[4])

    slope = np.asarray(jax.jit(jax.jacrev(of))(given))
    np.testing.assert_allclose(slope, np.asarray(jax.jit(jax.jacfwd(of))(given)), rtol=1e-12)
    step, value = 1e-6, jax.jit(of)
    for k in range(5):
        ends = [value(given.at[k].mul(1 + s * step)) for s in (1, -1)]
        difference = float(ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(slope[k] * float(given[k]), difference, rtol=1e-6, atol=1e-8)


def test_sharp_edges_have_no_finite_value():
    one = screw_of_30_mm(3e-3)
    with pytest.raises(prsm.MissingDataError, match="edge_radius"):
        prsm.compute(one, ["edge_pressure"])
    with pytest.raises(prsm.MissingDataError, match="screw_addendum"):
        prsm.compute(without_addenda(_rounded(one)), ["edge_pressure"])
    (sentence,) = [s for s in prsm.assumptions(one, ["max_pressure"]) if "edge" in s]
    assert "no finite value at a sharp edge" in sentence
    rounded = _rounded(one)
    (sentence,) = [s for s in prsm.assumptions(rounded, ["max_pressure"]) if "edge" in s]
    assert "which edge_pressure includes" in sentence
    (sentence,) = [s for s in prsm.assumptions(rounded, ["edge_pressure"]) if "crests" in s]
    assert "yielding of the steel is left out" in sentence


def test_the_finding_names_the_pressure_at_the_edge():
    """Beside the share that is cut, for each load; none where edges are sharp."""
    one = screw_of_30_mm(5e-3, load=1e3)
    assert all("MPa" not in f.message for f in _cut(one))
    rounded = _rounded(one)
    capacity = float(_compute(rounded, ["static_capacity"])["static_capacity"][0])
    reaches = strength.end_reaches(rounded.stages[0])
    found = _cut(rounded)
    assert len(found) == len(reaches) == 4
    for reach in reaches:
        value = float(reach.edge_pressure(array(capacity)))
        assert any(f"{value * 1e-6:.4g} MPa at the rounded edge" in f.message for f in found)


def _cut(one):
    return [f for f in prsm.check(one) if f.name == "contact_truncation"]
