"""Derivatives of every shipped example, forward and reverse, against central differences."""

import functools

import jax.numpy as jnp
import numpy as np
import pytest
from derivatives import QUANTITIES, VARIABLES, forward, reverse, shipped, value_and_slope

import prsm_jax as prsm
from prsm_jax import file

#: Central differences of eighth order: weights of f(x + k h) − f(x − k h), k = 1 … 4.
WEIGHTS = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
#: With 1 % of each variable the stencil's error is of order 1e-16, its rounding 1e-13.
STEP = 1e-2


def _differences(mechanism, quantities):
    columns = []
    for direction in np.eye(len(VARIABLES)):
        steps = [
            value_and_slope(
                mechanism,
                jnp.asarray(sign * k * STEP * direction),
                jnp.asarray(direction),
                quantities,
            )[0]
            for k in range(1, 5)
            for sign in (1, -1)
        ]
        moved = np.asarray(steps).reshape(4, 2, -1)
        columns.append(WEIGHTS @ (moved[:, 0] - moved[:, 1]) / STEP)
    return np.stack(columns, axis=1)


@functools.cache
def _results(name):
    """Chosen quantities, values, both Jacobians and differences, all to relative changes."""
    mechanism = shipped(name)
    available = prsm.quantities.available_quantities(mechanism)
    chosen = tuple(quantity for quantity in QUANTITIES if quantity in available)
    values, by_forward = forward(mechanism, chosen)
    _, by_reverse = reverse(mechanism, chosen, values.size)
    return chosen, values, by_forward, by_reverse, _differences(mechanism, chosen)


#: Left out are those whose physics another has: the mechanisms of the mission and of the tolerances
#: are parts of the actuator, the stage within the axis is a simpler one, Li's second pair of stages
#: has the laws of the first, and the annular rollers' nearest threaded mechanism those of the
#: actuator. Load sharing, errors of parts, the axis and the motion of recirculating and
#: differential roller screws have tests of their own.
_LIKE_OTHERS = {
    *("actuator_axis", "actuator_mission", "actuator_tolerances", "actuator_load_sharing"),
    "actuator_part_errors",
    *("li2021_two_stage", "ring_roller", "recirculating_stage", "differential_stage"),
}
NAMES = [name for name in file.example_names() if name not in _LIKE_OTHERS]


@pytest.mark.parametrize("name", NAMES)
def test_forward_and_reverse_against_central_differences(name):
    """To 1e-7 of the derivative; 1e-11 of the value per relative change is the differences' noise.

    Which quantities an example has the data for is part of the test: efficiency, pressure and
    stiffness everywhere, frequencies where masses are given.
    """
    chosen, values, by_forward, by_reverse, differences = _results(name)
    assert {"efficiency", "max_pressure_screw", "axial_stiffness"} <= set(chosen)
    if name in ("actuator", "wu2022"):
        assert set(chosen) == set(QUANTITIES)
    assert np.all(np.isfinite(by_forward))
    # A stage without supports has rigid modes, with noise for a frequency.
    elastic = np.abs(values) > 1e-9
    assert np.all(np.abs(by_forward[~elastic]) < 1e-9)
    noise = np.where(elastic, 1e-11 * np.abs(values), 1e-9)
    allowed = 1e-7 * np.abs(differences) + noise[:, None]
    assert np.all(np.abs(by_forward - differences) <= allowed)
    assert np.all(np.abs(by_reverse - differences) <= allowed)
    # The same sums in another order.
    scale = np.maximum(np.abs(values)[:, None], np.abs(by_forward))
    assert np.all(np.abs(by_forward - by_reverse) <= 1e-12 * scale)


def test_derivatives_are_not_zero():
    """The comparison would pass for constants; in the actuator everything depends on something.

    The lead moves efficiency, and all three variables move pressure and stiffness.
    """
    chosen, values, by_forward, _, _ = _results("actuator")
    assert chosen == QUANTITIES
    elasticity = np.abs(by_forward / values[:, None])
    # Four torsional and four transverse frequencies come before the single numbers.
    by_name = dict(zip(chosen[2:], elasticity[8:], strict=True))
    assert by_name["efficiency"][0] > 1e-3
    assert np.all(by_name["max_pressure_screw"] > 1e-4)
    assert np.all(by_name["axial_stiffness"] > 1e-4)
    assert np.all(elasticity[:8].max(axis=1) > 1e-4)
