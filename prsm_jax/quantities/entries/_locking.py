"""Quantities of jamming and self-locking: margins to constrain, limits in closed form."""

import jax.numpy as jnp

from ...dynamics import (
    friction_needs_load,
    friction_sets_motion,
    jamming_coefficient,
    jamming_margin as _jamming_margin,
    locking_coefficient,
    self_locking_margin as _self_locking_margin,
)
from ...mechanism import require_type
from .._analysis import Analysis
from .._catalogue import quantity

#: Types whose slip does not depend on friction.
_WITH_LEAD = ("standard", "inverted")


@quantity(
    "jamming_margin",
    "j",
    "1",
    "1 − μ/μ_jam, smallest of all stages: 1 without friction; at 0 a driving screw jams",
)
def jamming_margin(analysis: Analysis):
    mechanism = analysis.mechanism
    needs_load = friction_needs_load(mechanism) or friction_sets_motion(mechanism)
    load = analysis.load if needs_load else None
    margin, found = _jamming_margin(mechanism, analysis.kinematics, analysis.speed, load)
    analysis.require(found)
    return margin


@quantity(
    "self_locking_margin",
    "s",
    "1",
    "1 − 1/(factor on all friction at which the load just holds): positive if the load drives the "
    "screw back, negative if self-locking",
)
def self_locking_margin(analysis: Analysis):
    margin, solved = _self_locking_margin(
        analysis.mechanism, analysis.kinematics, analysis.speed, analysis.load
    )
    analysis.require(solved)
    return margin


@quantity(
    "critical_friction_coefficient",
    "μ_lock",
    "1",
    "thread friction coefficient above which a load does not turn screw or nut",
    ("stage",),
)
def critical_friction_coefficient(analysis: Analysis):
    require_type(analysis.mechanism.stages, "a friction coefficient that locks is", _WITH_LEAD)
    return jnp.stack([locking_coefficient(geometry) for geometry in analysis.kinematics])


@quantity(
    "jamming_friction_coefficient",
    "μ_jam",
    "1",
    "thread friction coefficient at which a driving screw jams",
    ("stage",),
)
def jamming_friction_coefficient(analysis: Analysis):
    require_type(analysis.mechanism.stages, "a friction coefficient that jams is", _WITH_LEAD)
    return jnp.stack([jamming_coefficient(geometry) for geometry in analysis.kinematics])
