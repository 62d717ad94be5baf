"""Quantities of load sharing among threads and rollers."""

import functools

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._errors import MissingDataError
from ...fields import Scalar
from ...numerics import root_or_zero
from .._analysis import Analysis
from .._catalogue import quantity
from .._nut_travel import elastic_of
from .._onsets import truncated_pressure

_by_stage = functools.partial(
    quantity,
    dimensions=("stage",),
    shares=("operating_point",),
    assumes=("held_rollers", "shared_without_preload"),
)


def _per_stage(analysis: Analysis, function):
    return jnp.stack([function(one) for one in analysis.distributions])


@_by_stage(
    "thread_sharing_factor_screw", "K_s", "1", "largest thread load over the mean, screw side"
)
def thread_sharing_factor_screw(analysis: Analysis):
    return _per_stage(analysis, lambda one: one.screw.thread_sharing_factor)


@_by_stage("thread_sharing_factor_nut", "K_n", "1", "largest thread load over the mean, nut side")
def thread_sharing_factor_nut(analysis: Analysis):
    return _per_stage(analysis, lambda one: one.nut.thread_sharing_factor)


@_by_stage("roller_sharing_factor", "K_R", "1", "largest load of a roller over the mean")
def roller_sharing_factor(analysis: Analysis):
    return _per_stage(analysis, lambda one: one.nut.roller_sharing_factor)


def _across(analysis: Analysis, function):
    """A function of each distribution whose rollers have loads of their own by their places."""
    if any(one.nut_radial_force is None for one in analysis.distributions):
        raise MissingDataError(
            "rollers are equal around the screw; give [stage.load_sharing.part_errors] or "
            "[stage.load_sharing.free_nut]"
        )
    return _per_stage(analysis, function)


@_by_stage(
    "roller_load_unbalance",
    "s_R",
    "1",
    "standard deviation of the loads of rollers over their mean, with errors of parts",
)
def roller_load_unbalance(analysis: Analysis):
    return _across(analysis, lambda one: one.nut.roller_load_unbalance)


@_by_stage(
    "nut_radial_force", "F_r", "N", "radial force of the rollers on the nut, with errors of parts"
)
def nut_radial_force(analysis: Analysis):
    return _across(analysis, lambda one: _length(one.nut_radial_force))


@_by_stage(
    "nut_overturning_moment",
    "M_r",
    "N·m",
    "moment of the rollers that tips the nut, with errors of parts",
)
def nut_overturning_moment(analysis: Analysis):
    return _across(analysis, lambda one: _length(one.nut_overturning_moment))


def _length(vector) -> Scalar:
    return root_or_zero(jnp.sum(vector**2))


@_by_stage("largest_thread_load", "F_max", "N", "largest axial load of a thread, either side")
def largest_thread_load(analysis: Analysis):
    return _per_stage(
        analysis,
        lambda one: jnp.maximum(jnp.max(one.screw.thread_load), jnp.max(one.nut.thread_load)),
    )


@quantity(
    "max_pressure_shared",
    "p₀_max",
    "Pa",
    "largest pressure of all threads under the thread loads of [stage.load_sharing]; cut ellipses "
    "as in `max_pressure`",
    assumes=(
        "held_rollers",
        "flanks_of_contacts",
        "shared_without_preload",
        "contacts_without_friction",
    ),
    shares=("operating_point",),
)
def max_pressure_shared(analysis: Analysis):
    return jnp.max(shared_stage_pressures(analysis))


def shared_stage_pressures(analysis: Analysis) -> Float[Array, " stages"]:
    """`max_pressure_shared` of every stage [Pa]."""

    def on(side: str) -> Float[Array, " stages"]:
        return jnp.stack(
            [
                truncated_pressure(analysis, i, side, jnp.max(getattr(one, side).max_pressure))
                for i, one in enumerate(analysis.distributions)
            ]
        )

    return jnp.maximum(on("screw"), on("nut"))


@quantity(
    "axial_deflection",
    "x",
    "m",
    "axial deflection of the nut under the load, from its unloaded position: preloaded, or at the "
    "first contact after play and errors are taken up; sum of all stages",
    assumes=("held_rollers", "shared_without_preload"),
    shares=("operating_point", "none"),
)
def axial_deflection(analysis: Analysis):
    stages = range(len(analysis.mechanism.stages))
    return jnp.sum(jnp.stack([elastic_of(analysis, i).deflection for i in stages]))


@_by_stage("spacer_force", "F_v", "N", "force in the spacer of a split nut under the load")
def spacer_force(analysis: Analysis):
    forces: list[Scalar] = []
    for one in analysis.distributions:
        if one.spacer_force is None:
            raise MissingDataError(
                "the nut is not split; give [stage.load_sharing.split_nut] with preload or offset"
            )
        forces.append(one.spacer_force)
    return jnp.stack(forces)
