"""The carriers' equation of motion in the scalars of the reduced stages."""

from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...fields import Scalar
from ...mechanism import Mechanism
from .._kinematics import StageKinematics, travel_per_radian
from ._chain import ScrewForces, screw_forces
from ._reduced_stage import ReducedForces, ReducedStage, is_reducible, reduced_forces, reduced_stage
from ._stage_forces import axial_inertia


class ReducedChain(eqx.Module):
    """Stages by their scalars, and the inertias of their carriers."""

    mechanism: Mechanism
    stages: tuple[ReducedStage, ...]
    inertia: Float[Array, " stages"]


def reduced_chain(
    mechanism: Mechanism, kinematics: tuple[StageKinematics, ...], inertia: Float[Array, " stages"]
) -> ReducedChain | None:
    """The chain by its scalars, or `None` where these do not suffice for a stage."""
    if not all(is_reducible(stage) for stage in mechanism.stages):
        return None
    return ReducedChain(mechanism, tuple(reduced_stage(k) for k in kinematics), inertia)


def screw_of(
    mechanism: Mechanism,
    index: int,
    forces: ReducedForces,
    speed: Scalar,
    next_screw: ScrewForces | None,
    acceleration: Scalar | None,
) -> ScrewForces:
    """Torque and axial balance of one screw of the chain, from the forces of its rollers."""
    stages = mechanism.stages
    axial = None
    if acceleration is not None and index > 0:
        axial = -acceleration * travel_per_radian(stages, index)
    driver = stages[index - 1] if index > 0 else None
    return screw_forces(
        stages[index],
        forces.torque_on_screw,
        forces.axial_on_screw,
        speed,
        jnp.sign(speed),
        driver,
        next_screw,
        acceleration,
        axial,
    )


def reduced_rates(
    chain: ReducedChain,
    speed: Scalar,
    acceleration: Scalar | None,
    load: Scalar,
    carrier_speed: Float[Array, " stages"] | Sequence[Scalar],
) -> list[Scalar]:
    """Accelerations of the carriers, one by one [rad/s²].

    That of a stage depends on the carrier speeds of this stage and of those after it alone, because
    the load passes from the last nut to the first screw.

    **Arguments:**

    - `chain`: the mechanism by its scalars.
    - `speed`, `acceleration`: of the screw; [rad/s], and [rad/s²] or `None` if it is constant.
    - `load`: on the last nut [N].
    - `carrier_speed`: ω of every stage [rad/s].
    """
    stages = chain.mechanism.stages
    rates: list[Scalar] = []
    next_screw, nut_load = None, load
    for index in reversed(range(len(stages))):
        stage, axial_force = stages[index], nut_load
        if acceleration is not None:
            axial_force = axial_force + (
                axial_inertia(stage) * acceleration * travel_per_radian(stages, index + 1)
            )
        forces = reduced_forces(
            stage, chain.stages[index], speed, carrier_speed[index], axial_force
        )
        rates.append(forces.carrier_drive * (1 / chain.inertia[index]))
        if index > 0:
            next_screw = screw_of(chain.mechanism, index, forces, speed, next_screw, acceleration)
            nut_load = next_screw.support_force
    return rates[::-1]
