"""Derivatives where ellipses pass the ends of their flanks: whole, at the onset, deeply cut."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from derivatives import along, by_all_numbers, central_slope, inner, some_direction
from scenes import array
from truncation_scenes import screw_of_30_mm

from prsm_jax.contact import pressure_ratio, risk_ratio, share_within

NAMES = (
    "static_capacity",
    "dynamic_capacity",
    "rating_life",
    "phase_damage",
    "permanent_deformation",
    "max_pressure_screw",
    "max_pressure_nut",
    "truncation_load",
    "contact_truncation",
    "contact_truncation_largest",
)


def _scene(lead, load):
    from prsm_jax.mechanism import DutyCycle

    cycle = DutyCycle(
        duration=jnp.asarray([1.0, 2.0]),
        speed=jnp.asarray([10.0, 100.0]),
        load=jnp.asarray([1.5, 0.5]) * load,
    )
    one = screw_of_30_mm(lead, load=load)
    return eqx.tree_at(lambda m: m.duty_cycle, one, cycle, is_leaf=lambda x: x is None)


@pytest.mark.parametrize(
    ("lead", "load"),
    [(15e-3, 20e3), (5e-3, 300e3), (2e-3, 600e3), (5e-3, 0.0)],
    ids=["whole", "cut", "deeply cut", "no load"],
)
def test_forward_reverse_and_differences_agree(lead, load):
    leaves, rest = eqx.partition(_scene(lead, load), eqx.is_inexact_array)
    direction = some_direction(leaves, 7)
    values, slopes = along(leaves, direction, rest, NAMES)
    assert not np.isnan(values).any()
    assert np.isfinite(slopes).all()
    finite = np.isfinite(np.asarray(values))
    found = central_slope(leaves, direction, rest, NAMES)
    scale = np.where(finite & (values != 0), np.abs(values), 1.0)
    # Second order in a step of 1e-6, and rounding of 1e-15 of the values over it.
    np.testing.assert_allclose(
        (slopes / scale)[finite], (found / scale)[finite], rtol=1e-6, atol=1e-8
    )
    if load:
        cut = np.asarray(values)[-1] > 0
        assert cut == (lead < 15e-3)
    weights = jnp.asarray(1 / scale)
    gradient = by_all_numbers(leaves, weights, rest, NAMES)
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(gradient))
    np.testing.assert_allclose(
        inner(gradient, direction), float(jnp.sum(slopes * weights)), rtol=1e-10
    )


@pytest.mark.parametrize("law", [pressure_ratio, risk_ratio, share_within])
def test_the_laws_are_smooth_at_the_onset(law):
    """Value and slope join where the ellipse reaches an end, from either side."""
    onsets = array(3e9), array(5e9)

    def of(pressure):
        return law(pressure, onsets)

    for place in (3e9, 5e9):
        below, above = array(place * (1 - 1e-9)), array(place * (1 + 1e-9))
        np.testing.assert_allclose(of(below), of(above), rtol=1e-7)
        slopes = [float(jax.grad(of)(p)) * place for p in (below, array(place), above)]
        # The second derivative is of order one to a hundred, over 2e-9.
        np.testing.assert_allclose(slopes, slopes[0], atol=1e-6)
    assert float(jax.grad(of)(array(0.0))) == 0.0


@pytest.mark.parametrize("law", [pressure_ratio, risk_ratio, share_within])
@pytest.mark.parametrize("pressure", [2e9, 3.5e9, 8e9, 3e10])
def test_the_laws_against_differences_in_all_arguments(law, pressure):
    given = jnp.asarray([pressure, 3e9, 5e9])

    def of(x):
        return law(x[0], (x[1], x[2]))

    slope = np.asarray(jax.jacrev(of)(given))
    np.testing.assert_allclose(slope, np.asarray(jax.jacfwd(of)(given)), rtol=1e-12, atol=1e-30)
    step = 1e-6
    for k in range(3):
        ends = [of(given.at[k].mul(1 + s * step)) for s in (1, -1)]
        found = float(ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(slope[k] * float(given[k]), found, rtol=1e-6, atol=1e-8)
