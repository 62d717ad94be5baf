"""The bending–torsional spring–mass system of one stage, before any symmetry is used."""

import equinox as eqx
import jax.numpy as jnp

from ..mechanism import Scalar, Stage, Support, body_inertia, body_mass
from ..stiffness import ThreadStiffness, ring_roller_stiffness


class CentralBody(eqx.Module):
    """A body on the axis (screw, ring gear or nut) with its springs to housing and rollers."""

    mass: Scalar
    #: J/r² [kg].
    equivalent_mass: Scalar
    #: Stiffness of the spring to one roller, along the tangent [N/m].
    mesh_stiffness: Scalar
    radial_support: Scalar
    torsional_support: Scalar
    #: +1 if the roller's rotation stretches the spring in the same sense (screw), −1 otherwise.
    roller_sign: int = eqx.field(static=True)
    name: str = eqx.field(static=True)


class CarrierBody(eqx.Module):
    """The carrier with the masses of the rollers it leads; uncoupled from the rest."""

    equivalent_mass: Scalar
    torsional_support: Scalar


class VibrationSystem(eqx.Module):
    """Masses and springs of one stage with equal rollers, evenly spaced."""

    bodies: tuple[CentralBody, ...]
    roller_equivalent_mass: Scalar
    carrier: CarrierBody | None
    roller_count: int = eqx.field(static=True)


def _support(support: Support | None, name: str, like: Scalar) -> Scalar:
    value = None if support is None else getattr(support, name)
    return jnp.zeros_like(like) if value is None else value


def vibration_system(stage: Stage, threads: ThreadStiffness) -> VibrationSystem:
    """Collect the masses and springs of one stage.

    The thread springs act in the transverse plane: their stiffness on tangential displacements
    u = r θ is k cos²β_R (Wu et al. 2022, equations 7 to 13). Without a ring gear, or without
    a carrier, those degrees of freedom are not there.

    **Arguments:**

    - `stage`: the stage; needs masses and inertias (given or from dimensions).
    - `threads`: thread contact stiffness of one roller.

    **Raises:** `MissingDataError` if masses are missing; `ValueError` for fewer than 3 rollers.
    """
    if stage.roller_count < 3:
        raise ValueError(
            f"roller_count is {stage.roller_count}; the symmetric vibration model needs at least 3"
        )
    thread = stage.thread
    projection = jnp.cos(thread.roller_helix_angle) ** 2
    ring_stiffness = None if stage.ring_gear is None else ring_roller_stiffness(stage)

    def central(name: str, radius: Scalar, stiffness: Scalar, sign: int) -> CentralBody:
        mass = body_mass(stage, name)
        support = getattr(stage, name).support
        return CentralBody(
            mass=mass,
            equivalent_mass=body_inertia(stage, name) / radius**2,
            mesh_stiffness=stiffness,
            radial_support=_support(support, "radial_stiffness", mass),
            torsional_support=_support(support, "torsional_stiffness", mass),
            roller_sign=sign,
            name=name,
        )

    bodies = [central("screw", thread.screw_radius, threads.screw_roller * projection, 1)]
    if ring_stiffness is not None:
        # The pitch circle of the ring gear is the nominal circle of the nut's thread.
        bodies.append(central("ring_gear", thread.nut_radius, ring_stiffness, -1))
    bodies.append(central("nut", thread.nut_radius, threads.nut_roller * projection, -1))

    carrier = None
    if stage.carrier is not None:
        inertia = stage.carrier.count * body_inertia(stage, "carrier")
        equivalent = inertia / thread.centre_distance**2
        equivalent = equivalent + stage.roller_count * body_mass(stage, "roller")
        support = _support(stage.carrier.support, "torsional_stiffness", equivalent)
        carrier = CarrierBody(equivalent, support)
    return VibrationSystem(
        bodies=tuple(bodies),
        roller_equivalent_mass=body_inertia(stage, "roller") / thread.roller_radius**2,
        carrier=carrier,
        roller_count=stage.roller_count,
    )
