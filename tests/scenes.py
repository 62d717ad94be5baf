"""Mechanisms that several tests use, and the compiled functions that they share.

A compiled function takes the mechanism as an argument, so every mechanism of the same structure
uses the same program: build variants with `prsm.set_parameter` or `eqx.tree_at`.
"""

import dataclasses
import functools
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import ArrayLike

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.contact import stage_contact as _stage_contact
from prsm_jax.friction import (
    CoulombFriction,
    Drag,
    Friction,
    RollingHysteresis,
    SpinFriction,
    SplineFriction,
    ThrustBearingFriction,
)
from prsm_jax.mechanism import (
    Carrier,
    Gear,
    Material,
    Mechanism,
    Nut,
    OperatingPoint,
    Roller,
    Screw,
    Stage,
    Thread,
)

STEEL = Material(210e9, 0.3, 7850.0)

ALL_LOSSES = Friction(
    thread=CoulombFriction(0.06),
    spin=SpinFriction(0.05),
    rolling_hysteresis=RollingHysteresis(0.01),
    spline=SplineFriction(0.1, 12e-3),
    thrust_bearing=ThrustBearingFriction(0.005, 20e-3),
    drag=Drag(0.05),
)
#: Those that a first stage can have: its screw does not slide in a spline.
FIRST_STAGE_LOSSES = eqx.tree_at(lambda f: f.spline, ALL_LOSSES, None)
LOSS_NAMES = {"thread_sliding", "spin", "rolling_hysteresis", "spline", "thrust_bearing", "drag"}

#: Every test that reads a shipped example gets the same object.
example = functools.cache(file.load)


def equal_shares(name):
    """A shipped example whose threads share equally, for tests of everything else."""
    mechanism = example(name)
    stages = tuple(
        dataclasses.replace(stage, load_sharing=None, sharing="equal") for stage in mechanism.stages
    )
    return dataclasses.replace(mechanism, stages=stages)


mesh, modal = prsm.mesh, prsm.modal
stage_contact = eqx.filter_jit(_stage_contact)


class Swing(eqx.Module):
    """mean + amplitude sin(2π f t); one structure for all tests, so that they share a program."""

    mean: jax.Array
    amplitude: jax.Array
    frequency: jax.Array

    def __call__(self, time):
        return self.mean + self.amplitude * jnp.sin(2 * jnp.pi * self.frequency * time)


def array(value):
    """A float64 array; a Python float would be a static argument and compile anew."""
    return jnp.asarray(value, jnp.float64)


def steady_state(mechanism, speed=None, load=None):
    """`prsm.steady_state` at a speed and a load, or at the operating point."""
    point = mechanism.operating_point
    return prsm.steady_state(
        mechanism,
        array(point.speed if speed is None else speed),
        array(point.load if load is None else load),
    )


def simulate(mechanism, scenario=None, **options):
    """`prsm.simulate`; the caller looks at `solver.code`."""
    return prsm.simulate(mechanism, scenario, throw=False, **options)


def thread(
    roller_radius: ArrayLike = 4e-3,
    lead: ArrayLike = 10e-3,
    contact_angle: ArrayLike = np.pi / 4,
    starts: ArrayLike = 5.0,
    **more: Any,
) -> Thread:
    """Thread geometry in metres and radians."""
    return Thread(
        lead=lead,
        starts=starts,
        roller_radius=roller_radius,
        contact_angle=contact_angle,
        **more,
    )


def stage(roller_count=10, friction=None, geometry=None, **more):
    """A stage with masses, materials and engaged threads; Coulomb friction unless given."""
    defaults = {
        "screw": Screw(mass=0.76, inertia=1.7e-4),
        "roller": Roller(mass=0.03, inertia=4e-7),
        "nut": Nut(mass=2.2, inertia=9e-4),
        "carrier": Carrier(inertia=1e-5),
        "gear": Gear(np.radians(20)),
        "material": STEEL,
        "engaged_threads": 20.0,
    }
    if friction is None:
        friction = Friction(thread=CoulombFriction(0.05))
    return Stage(
        thread=thread() if geometry is None else geometry,
        roller_count=roller_count,
        friction=friction,
        **(defaults | more),
    )


def frictionless(**parts):
    """For problems whose answer is in their own quantities: margins of `check` compile fast."""
    return mechanism(dataclasses.replace(stage(**parts), friction=None))


def mechanism(*stages, speed=100.0, load=7000.0, duration=None):
    """A mechanism of stages, one by default."""
    return Mechanism(stages or (stage(),), OperatingPoint(speed, load, duration))


def changed(one, names, changes):
    """The mechanism with numbers, by name, that are larger by these parts of themselves."""
    moved = one
    for name, change in zip(names, changes, strict=True):
        moved = prsm.set_parameter(moved, name, prsm.get_parameter(one, name) * (1 + change))
    return moved
