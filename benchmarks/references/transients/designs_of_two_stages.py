"""Random two-stage designs for transients, as JAX pytrees and as numbers for compiled rivals."""

import functools
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.dynamics import all_kinematics, axial_inertia, carrier_inertia
from prsm_jax.file import load
from prsm_jax.friction import (
    CoulombFriction,
    RegularisedCoulombFriction,
    SplineFriction,
    ThrustBearingFriction,
)
from prsm_jax.mechanism import Mechanism, body_inertia, body_mass

from .compiled import DRIVE, STAGE
from .dynamics import stage_numbers

MECHANISM = "li2020_two_stage"
#: What varies in each stage: lead, contact angle, roller radius, friction, inertia of the carriers.
VARIED = 5


class Designs(NamedTuple):
    """Numbers of all designs, one row each."""

    #: Factors on what varies: design × stage × quantity.
    factors: np.ndarray
    #: Amplitude of the screw speed [rad/s] and load [N].
    speed: np.ndarray
    load: np.ndarray


def random_designs(count: int) -> Designs:
    """The design of Li et al. 2020 first, then others around it."""
    random = np.random.default_rng(38)
    factors = random.uniform(0.7, 1.4, (count, 2, VARIED))
    factors[0] = 1.0
    speed, force = random.uniform(50, 200, count), random.uniform(3e3, 1e4, count)
    speed[0], force[0] = 100.0, 7000.0
    return Designs(factors, speed, force)


def _laws(mechanism: Mechanism) -> list[Any]:
    return [stage.friction and stage.friction.thread for stage in mechanism.stages]


def regularised(mechanism: Mechanism, width) -> Mechanism:
    """The mechanism with the jump of thread friction spread over a slip speed [m/s]."""
    width = jnp.asarray(width, float)
    smooth = [RegularisedCoulombFriction(law.coefficient, width) for law in _laws(mechanism)]
    return eqx.tree_at(_laws, mechanism, smooth)


@functools.cache
def base(width: float) -> Mechanism:
    """The mechanism that is varied; with a width, friction in the threads is regularised."""
    mechanism = load(MECHANISM)
    return mechanism if width == 0 else regularised(mechanism, width)


def _varied(mechanism: Mechanism) -> list[Any]:
    found = []
    for stage, law in zip(mechanism.stages, _laws(mechanism), strict=True):
        assert stage.carrier is not None
        thread = stage.thread
        found += [thread.lead, thread.contact_angle, thread.roller_radius]
        found += [law.coefficient, stage.carrier.inertia]
    return found


def design(mechanism: Mechanism, factors) -> Mechanism:
    """One design: the mechanism with factors (stage × quantity) on what varies."""
    flat = jnp.asarray(factors).reshape(-1)
    found = [flat[index] * leaf for index, leaf in enumerate(_varied(mechanism))]
    return eqx.tree_at(_varied, mechanism, found)


def kinematics_of(mechanism: Mechanism, designs: Designs):
    """Kinematics of all designs."""
    return jax.jit(jax.vmap(lambda f: all_kinematics(design(mechanism, f))))(designs.factors)


def _row(mechanism: Mechanism, kinematics, speed, force, frequency, width):
    row = [speed, frequency, force, width, jnp.zeros_like(speed)]
    travel = jnp.zeros_like(speed)
    for stage, geometry in zip(mechanism.stages, kinematics, strict=True):
        friction, normal = stage.friction, geometry.meshing.screw.normal
        assert friction is not None
        assert isinstance(friction.thread, CoulombFriction | RegularisedCoulombFriction)
        spline, bearing = friction.spline, friction.thrust_bearing
        assert isinstance(spline, SplineFriction | None)
        assert isinstance(bearing, ThrustBearingFriction | None)
        before, travel = travel, travel + stage.thread.lead / (2 * jnp.pi)
        sliding = before > 0
        row += [
            stage.roller_count,
            geometry.slip_per_screw[2],
            *geometry.slip_per_screw[:2],
            *geometry.drive,
            *normal,
            carrier_inertia(stage),
            friction.thread.coefficient,
            0.0 if spline is None else spline.coefficient / spline.radius,
            0.0 if bearing is None else bearing.coefficient * bearing.radius,
            axial_inertia(stage),
            # The first screw does not move along.
            body_mass(stage, "screw") if len(row) > DRIVE else 0.0,
            body_inertia(stage, "screw"),
            travel,
            jnp.where(sliding, before, 0.0),
        ]
    return jnp.stack([jnp.asarray(x, float) for x in row])


def numbers_of(mechanism: Mechanism, designs: Designs, kinematics, frequency, width) -> np.ndarray:
    """What `compiled` wants of all designs: the same right-hand side as the package."""

    def row(factors, geometry, speed, force):
        return _row(design(mechanism, factors), geometry, speed, force, frequency, width)

    found = jax.jit(jax.vmap(row))(designs.factors, kinematics, designs.speed, designs.load)
    return np.array(found)


def apart(mechanism: Mechanism, designs: Designs, numbers: np.ndarray, count: int) -> np.ndarray:
    """The first rows, with the geometry meshed anew in mpmath: for references."""
    rows = numbers[:count].copy()
    for row, factors in zip(rows, designs.factors, strict=False):
        for index, stage in enumerate(design(mechanism, factors).stages):
            found, at = stage_numbers(stage), DRIVE + index * STAGE
            rows_of_geometry = [found.lead / (2 * np.pi), *found.screw, *found.drive, *found.normal]
            row[at + 1 : at + 9] = rows_of_geometry
            row[at + 9] = found.inertia
    return rows
