"""Second derivatives of every quantity along a change of all numbers, against differences.

One direction meets all second derivatives that are not numbers: a NaN of any of them is in the sum.
"""

import numpy as np
import pytest
from every_number import OF_AN_AXIS, quantities_of, sizes

import prsm_jax as prsm
from prsm_jax import file

#: Relative, of a second derivative and of its quantity, beyond what differences know of their own
#: error; 3e-11 and 2e-12 are reached.
_AGREE, _OF_VALUE = 1e-9, 1e-10

#: Of a single contact: the first example has their second derivatives.
_OF_CONTACTS = ("approach_", "contact_axial_", "max_", "semi_", "thread_stiffness_")


def _beside_contacts(name):
    available = prsm.quantities.available_quantities(file.load(name))
    return tuple(one for one in available if not one.startswith(_OF_CONTACTS))


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("wu2022", None),
        ("li2020_two_stage", _beside_contacts),
        ("li2020_single_stage_viscous", _beside_contacts),
        ("ring_roller", _beside_contacts),
        # Its flanks end, on one side within the contact ellipses.
        ("actuator", ("dynamic_capacity", "phase_damage", "rating_life", "natural_frequencies")),
        ("actuator_load_sharing", ("max_pressure_shared", "axial_deflection")),
        ("actuator_axis", OF_AN_AXIS[:4]),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
@pytest.mark.usefixtures("memory_for_large_programs")
def test_second_derivatives_of_quantities(name, wanted):
    program = quantities_of(name, wanted(name) if callable(wanted) else wanted)
    rng = np.random.default_rng(11)
    direction = rng.uniform(-1, 1, len(program.values)) * sizes(program.names, program.values)
    found = program.second_derivative(direction)
    assert [label for label, one in zip(program.labels, found, strict=True) if one != one] == []
    expected, error = program.second_difference(direction)
    base = np.abs(program(program.values[None])[0][0])
    apart = np.abs(found - expected) > 5 * error + _AGREE * np.abs(expected) + _OF_VALUE * base
    wrong = [
        f"{program.labels[j]}: {found[j]:.9g}, differences {expected[j]:.9g} ± {error[j]:.1g}"
        for j in np.flatnonzero(apart)
    ]
    assert not wrong
    # Differences are good to a thousandth, but for one of infinite quantities in 74.
    blind = error > 1e-3 * np.maximum(np.abs(expected), 1e-6 * base)
    assert blind.mean() <= 0.02
