"""A mechanism without any analysis, and quantities that are plain functions of its numbers."""

import jax.numpy as jnp

import prsm_jax as prsm
from prsm_jax.mechanism import Tolerance

MECHANISM = prsm.loads(
    """
[operating_point]
speed = 100.0
load = 5000.0

[[stage]]
roller_count = 7

[stage.thread]
lead = "10 mm"
starts = 5
roller_radius = "4 mm"
contact_angle = "45 deg"

[stage.friction.thread]
law = "coulomb"
coefficient = 0.1
"""
)


#: Quantities of these tests, which `conftest.py` puts into the catalogue for one test at a time.
QUANTITIES = []


def _quantity(*about):
    def add(function):
        QUANTITIES.append((about, function))
        return function

    return add


def numbers(analysis):
    """Lead in mm, angle in rad, load in kN, each relative to its nominal value."""
    thread = analysis.mechanism.stages[0].thread
    load = analysis.mechanism.operating_point.load
    return thread.lead * 1e3 - 10.0, thread.contact_angle - jnp.pi / 4, load / 1e3 - 5.0


@_quantity("uncertainty_linear", "q", "1", "3 + 2 x − 4 y + z")
def linear(analysis):
    x, y, z = numbers(analysis)
    return 3.0 + 2.0 * x - 4.0 * y + z


@_quantity("uncertainty_quadratic", "q", "1", "1 + x + 2 x² + 3 x y − y² / 2")
def quadratic(analysis):
    x, y, _ = numbers(analysis)
    return 1.0 + x + 2.0 * x**2 + 3.0 * x * y - 0.5 * y**2


@_quantity("uncertainty_pair", "q", "1", "x and NaN where x is above 0", ("component",))
def pair(analysis):
    x, y, _ = numbers(analysis)
    return jnp.stack([jnp.where(x > 0, jnp.nan, x), y])


#: Standard deviations 0.1, 0.05 and 0.2 of x, y and z.
TOLERANCES = (
    Tolerance("lead", -0.3e-3, 0.3e-3),
    Tolerance("contact_angle", -0.15, 0.15),
    Tolerance("load", -600.0, 600.0),
)


@_quantity("uncertainty_ishigami", "q", "1", "sin u + 7 sin² v + 0.1 w⁴ sin u")
def ishigami(analysis):
    point = analysis.mechanism.operating_point
    u, v = point.speed - 100.0, point.load - 5000.0
    w = analysis.mechanism.stages[0].thread.lead * 1e3 - 10.0
    return jnp.sin(u) + 7.0 * jnp.sin(v) ** 2 + 0.1 * w**4 * jnp.sin(u)
