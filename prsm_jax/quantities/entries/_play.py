"""Quantities of axial play: backlash, lost motion, preload."""

import equinox as eqx
import jax
import jax.numpy as jnp

from ... import strength
from ..._errors import MissingDataError
from ...dynamics import steady_state
from ...fields import Scalar
from ...friction import Friction
from ...mechanism import Mechanism, Stage, require_type
from ...numerics import above_or_nan
from .._analysis import Analysis
from .._catalogue import quantity
from .._onsets import pressure_under
from ._strength import per_stage

#: Speed at standstill, where the torque is that of the motion about to begin [rad/s].
_CREEP = 1e-6


@quantity(
    "axial_backlash",
    "j_a",
    "m",
    "free travel of the unloaded nut: measured, computed from thinned teeth and the meshing, or "
    "that of load sharing; 0 with preload",
    ("stage",),
)
def axial_backlash(analysis: Analysis):
    def of(index: int, stage: Stage) -> Scalar:
        thinned = strength.needs_meshing_for_backlash(stage)
        return strength.backlash(stage, analysis.kinematics[index].meshing if thinned else None)

    return per_stage(analysis, of)


@quantity(
    "lost_motion",
    "j_F",
    "m",
    "travel of the nut when the load reverses and the screw is at rest: backlash and approach of "
    "the contacts, shafts rigid",
    ("stage",),
    assumes=("equal_contacts",),
)
def lost_motion(analysis: Analysis):
    def of(index: int, stage: Stage) -> Scalar:
        thinned = strength.needs_meshing_for_backlash(stage)
        return strength.lost_motion(
            stage,
            analysis.load,
            analysis.kinematics[index].meshing if thinned else None,
            analysis.reference_contact(index),
        )

    return per_stage(analysis, of)


@quantity(
    "preload_opening_load",
    "F_lim",
    "N",
    "axial load that unloads one of two preloaded nuts, 2^{3/2} times the preload (as ISO 3408-5 "
    "for ball screws)",
    ("stage",),
)
def preload_opening_load(analysis: Analysis):
    return per_stage(
        analysis, lambda _, stage: strength.preload_opening_load(strength.preload_force(stage))
    )


@quantity(
    "preloaded_stiffness",
    "K_pr",
    "N/m",
    "tangent stiffness of a pair of preloaded nuts under the load, contacts only",
    ("stage",),
    assumes=("equal_contacts",),
)
def preloaded_stiffness(analysis: Analysis):
    def of(index: int, stage: Stage) -> Scalar:
        strength.preload_force(stage)
        return strength.preloaded_stiffness(stage, analysis.load, analysis.reference_contact(index))

    return per_stage(analysis, of)


@quantity(
    "preloaded_pressure",
    "p₀_pr",
    "Pa",
    "largest pressure of the more loaded of two preloaded nuts under the load, all its threads "
    "equally loaded; cut ellipses as in `max_pressure`",
    ("stage",),
    assumes=("equal_contacts", "flanks_of_contacts", "contacts_without_friction"),
)
def preloaded_pressure(analysis: Analysis):
    return per_stage(analysis, lambda index, _: stage_preloaded_pressure(analysis, index))


def stage_preloaded_pressure(analysis: Analysis, index: int) -> Scalar:
    """`preloaded_pressure` of one stage (from 0) [Pa].

    **Raises:** `MissingDataError` if its nut is not preloaded.
    """
    load = strength.preloaded_load(analysis.mechanism.stages[index], analysis.load)
    return jnp.maximum(*(pressure_under(analysis, index, side, load) for side in ("screw", "nut")))


@quantity(
    "preload_torque",
    "M_pr",
    "N·m",
    "drag torque of the preload: friction of the threads of both nuts, without bearings and drag",
    ("stage",),
    assumes=("equal_friction",),
)
def preload_torque(analysis: Analysis):
    return per_stage(analysis, lambda i, stage: _preload_torque(analysis, i, stage))


def _preload_torque(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    preload = strength.preload_force(stage)
    require_type((stage,), "the drag of a preload is", ("standard", "inverted", "recirculating"))
    if stage.friction is None:
        raise MissingDataError("the stage has no friction; give [stage.friction.thread]")
    # Not `dataclasses.replace`: that would run converters, which a batched leaf may not pass.
    friction: Friction = eqx.tree_at(
        lambda f: (f.spline, f.thrust_bearing, f.drag),
        stage.friction,
        (None, None, None),
        is_leaf=lambda leaf: leaf is None,
    )
    single_stage = Mechanism((eqx.tree_at(lambda s: s.friction, stage, friction),))
    kinematics = (analysis.kinematics[index],)
    speed = jnp.abs(analysis.speed)
    speed = jnp.where(above_or_nan(speed), speed, _CREEP)
    # The preload resists the turning of the screw in one nut and assists it in the other.
    states = jax.vmap(lambda load: steady_state(single_stage, speed, load, kinematics))(
        jnp.stack([preload, -preload])
    )
    analysis.require(states.computed.all())
    return jnp.sum(states.drive_torque)
