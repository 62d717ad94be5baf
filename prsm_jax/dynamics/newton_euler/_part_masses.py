"""Masses of the bodies of a stage, as Newton–Euler's equations need them."""

import contextlib

import equinox as eqx
import jax.numpy as jnp

from ..._errors import MissingDataError
from ...fields import Scalar
from ...mechanism import Stage, body_inertia, body_mass, mean_roller_inertia, mean_roller_mass


class PartMasses(eqx.Module):
    """Masses and inertias of the bodies of one stage; 0 where the motion does not need them."""

    roller_mass: Scalar
    roller_inertia: Scalar
    #: Roller mass for the centrifugal force; 0 if unknown.
    circling_mass: Scalar
    #: Of all carriers of the stage.
    carrier_mass: Scalar
    carrier_inertia: Scalar
    nut_mass: Scalar
    screw_mass: Scalar
    screw_inertia: Scalar
    #: Force per ω̇ that converts ω̇ to a force; only a scale [kg·m].
    reference: Scalar


def part_masses(stage: Stage, accelerates: bool, travels: bool, settled: bool) -> PartMasses:
    """Masses of the bodies of a stage.

    **Arguments:**

    - `stage`: the stage.
    - `accelerates`: whether the screw accelerates; else masses of nut and screw are not needed.
    - `travels`: whether the screw moves along its axis.
    - `settled`: whether carriers are known not to accelerate; then no mass is needed. Instead the
      equations get a roller of arbitrary inertia, whose acceleration results as 0.

    **Raises:** `MissingDataError` for a mass that is needed and not given.
    """
    thread = stage.thread
    zero = jnp.zeros_like(thread.lead)
    circling = carrier_mass = carrier_inertia = nut_mass = screw_mass = screw_inertia = zero
    if settled:
        with contextlib.suppress(MissingDataError):
            circling = mean_roller_mass(stage)
        roller_mass, roller_inertia = zero, jnp.ones_like(zero)
    else:
        roller_mass, roller_inertia = mean_roller_mass(stage), mean_roller_inertia(stage)
        circling = roller_mass
        if stage.carrier is not None:
            carrier_inertia = stage.carrier.count * body_inertia(stage, "carrier")
    if accelerates:
        family = thread.family
        nut_mass, screw_inertia = body_mass(stage, family.held), body_inertia(stage, family.turning)
        if travels:
            screw_mass = body_mass(stage, family.turning)
        if stage.carrier is not None:
            # Papers give the carriers' inertia without their mass, small next to that of the nut.
            with contextlib.suppress(MissingDataError):
                carrier_mass = stage.carrier.count * body_mass(stage, "carrier")
    radius = thread.roller_radius
    shared = stage.present_roller_count * thread.centre_distance
    reference = roller_inertia / radius + carrier_inertia / shared
    return PartMasses(
        roller_mass=roller_mass,
        roller_inertia=roller_inertia,
        circling_mass=circling,
        carrier_mass=carrier_mass,
        carrier_inertia=carrier_inertia,
        nut_mass=nut_mass,
        screw_mass=screw_mass,
        screw_inertia=screw_inertia,
        reference=reference + roller_mass * thread.centre_distance,
    )
