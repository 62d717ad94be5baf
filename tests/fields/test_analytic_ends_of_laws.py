"""Where a law ends: powers of nothing, threads without a load, the ends of a range."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array

from prsm_jax import halfspace, strength
from prsm_jax.fields._limits import Limit
from prsm_jax.load_sharing._flank_law import flank_force_and_slope
from prsm_jax.strength._powers import positive_power, ratio_or_infinity, scaled_unless_infinite


@pytest.mark.parametrize("exponent", [1 / 3, 0.5, 2.0, 10 / 9])
def test_powers_of_what_is_never_negative(exponent):
    """Below and above one as at one, with b^{e−1} e as the derivative, and 0 at nothing."""
    base = np.array([1e-12, 0.3, 0.999, 1.0, 1.001, 7.0, 1e9])
    value, slope = jax.vmap(jax.value_and_grad(lambda b: positive_power(b, exponent)))(
        jnp.asarray(base)
    )
    np.testing.assert_allclose(value, base**exponent, rtol=1e-14)
    np.testing.assert_allclose(slope, exponent * base ** (exponent - 1), rtol=1e-13)
    for nothing in (0.0, -0.5):
        found = jax.value_and_grad(lambda b: positive_power(b, exponent))(array(nothing))
        assert tuple(map(float, found)) == (0.0, 0.0)


def test_ratios_and_products_with_infinity():
    ratio = jax.value_and_grad(ratio_or_infinity, argnums=(0, 1))
    value, slopes = ratio(array(3.0), array(0.4))
    assert float(value) == pytest.approx(7.5, rel=1e-15)
    np.testing.assert_allclose(slopes, (2.5, -18.75), rtol=1e-14)
    for below in (0.0, -2.0):
        value, slopes = ratio(array(3.0), array(below))
        assert float(value) == math.inf
        np.testing.assert_array_equal(slopes, (0.0, 0.0))
    product = jax.value_and_grad(scaled_unless_infinite, argnums=(0, 1))
    value, slopes = product(array(3.0), array(0.4))
    np.testing.assert_allclose([value, *slopes], [1.2, 0.4, 3.0], rtol=1e-15)
    value, slopes = product(array(math.inf), array(0.4))
    assert float(value) == math.inf
    np.testing.assert_array_equal(slopes, (0.0, 0.0))


def test_unequal_threads_by_their_tenth_over_third_power():
    """(mean of q^{10/3})^{3/10}, weighted; exactly 1 for equal threads and for none that bears."""
    loads, weights = np.array([4.0, 1.0, 2.5]), np.array([1.0, 3.0, 2.0])
    shares = weights / weights.sum()
    relative = loads / (shares @ loads)
    expected = (shares @ relative ** (10 / 3)) ** 0.3
    factor = strength.fatigue_sharing_factor
    assert float(factor(jnp.asarray(loads), jnp.asarray(weights))) == pytest.approx(
        expected, rel=1e-14
    )
    assert float(factor(jnp.zeros(4))) == 1.0
    assert float(factor(jnp.full(4, 7e-3))) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("lowest", [False, True])
@pytest.mark.parametrize("highest", [False, True])
def test_a_range_admits_what_lies_inside_and_no_more(lowest, highest):
    limit = Limit(1.0, 4.0, "some", lowest, highest)
    admitted = {value: limit.admits(value) for value in (0.9, 1.0, 2.0, 4.0, 4.1)}
    assert admitted == {0.9: False, 1.0: lowest, 2.0: True, 4.0: highest, 4.1: False}
    wide = Limit(-math.inf, math.inf, "finite", lowest, highest)
    assert [wide.admits(v) for v in (-1e300, 0.0, math.inf, -math.inf, math.nan)] == [
        *(True, True),
        *(False, False, False),
    ]


@pytest.mark.parametrize("approach", [1e-9, 3e-6, 2e-3])
def test_flanks_of_contacts_alone_and_of_teeth_alone(approach):
    """δ = b f^{2/3}, so f = (δ/b)^{3/2} and df/dδ = 3f/2δ; δ = c f; and nothing apart."""
    hertz, tooth, given = 1e-7, 3e-9, array(approach)
    force, slope = flank_force_and_slope(given, array(hertz), None)
    assert float(force) == pytest.approx((approach / hertz) ** 1.5, rel=1e-13)
    assert float(slope) == pytest.approx(1.5 * (approach / hertz) ** 1.5 / approach, rel=1e-13)
    force, slope = flank_force_and_slope(given, None, array(tooth))
    np.testing.assert_allclose([force, slope], [approach / tooth, 1 / tooth], rtol=1e-13)
    force, slope = flank_force_and_slope(given, array(hertz), array(tooth))
    force, slope = float(force), float(slope)
    assert tooth * force + hertz * force ** (2 / 3) == pytest.approx(approach, rel=1e-13)
    assert slope == pytest.approx(1 / (tooth + 2 / 3 * hertz * force ** (-1 / 3)), rel=1e-13)
    for parts in ((hertz, None), (None, tooth), (hertz, tooth)):
        laws = [None if part is None else array(part) for part in parts]
        apart = flank_force_and_slope(-given, *laws)
        assert tuple(map(float, apart)) == (0.0, 0.0)


def test_codes_of_surface_contacts_mean_what_happens():
    """Found; no number for the modulus; at the edge of the grid; nothing that presses."""
    place = jnp.arange(8.0) - 3.5
    gap = 1e-8 * (place[:, None] ** 2 + place[None, :] ** 2)
    grid = halfspace.Grid((8, 8), 1e-5, 1e-5)

    def code(load, modulus):
        return halfspace.solve_contact(grid, gap, modulus, load=load).code

    loads, moduli = jnp.asarray([0.3, 0.3, 1e3, 0.0]), jnp.asarray([1e11, jnp.nan, 1e11, 1e11])
    codes = [int(code) for code in jax.jit(jax.vmap(code))(loads, moduli)]
    assert [halfspace.RESULTS[code].partition(":")[0] for code in codes] == [
        "contact found",
        "not converged",
        "the contact reaches the edge of the grid",
        "no contact",
    ]
    # The other two are those of flanks, tested there.
    assert set(codes) == {0, 1, 2, 3}
