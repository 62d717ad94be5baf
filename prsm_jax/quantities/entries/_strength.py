"""Quantities of strength: capacities, static safety, buckling, critical speed.

No standard exists for planetary roller screws: static safety and capacities are those of rolling
bearings (ISO 76, ISO 281) and ball screws (ISO 3408-5), and say so.
"""

from collections.abc import Callable

import jax.numpy as jnp

from ... import strength
from ...fields import Scalar
from ...geometry import flanks_end
from ...load_sharing import SideLoads
from ...mechanism import Stage
from .._analysis import Analysis, SharedLoad
from .._assumptions import assumption, derives_static_capacity
from .._catalogue import quantity
from .._onsets import onsets_anywhere


@assumption("static_load")
def static_load(stage: Stage) -> str | None:
    """Load under which threads share for the static capacity."""
    sharing = stage.load_sharing
    if sharing is None or sharing.split_nut is not None or not derives_static_capacity(stage):
        return None
    return (
        "The static capacity is that of threads that share the load as under the largest load of "
        "the file; where sharing changes with the load, compute the capacity at a load near it."
    )


@assumption("euler")
def euler(stage: Stage) -> str | None:
    """For the buckling of a screw whose yield strength is not given."""
    shaft = None if stage.strength is None else stage.strength.shaft
    if shaft is None or shaft.yield_strength is not None:
        return None
    return (
        "The buckling load is that of a slender elastic screw (Euler), since the file gives no "
        "yield strength; a short screw yields below it."
    )


def per_stage(analysis: Analysis, function: Callable[[int, Stage], Scalar]):
    return jnp.stack([function(i, stage) for i, stage in enumerate(analysis.mechanism.stages)])


def on_one_flank(analysis: Analysis, stage: Stage) -> Scalar:
    """Largest load on one flank, of operating point and duty cycle, preload included [N]."""
    return strength.largest_flank_load(stage, analysis.demand[1])


def _sides(analysis: Analysis, index: int, under: SharedLoad) -> tuple[SideLoads, ...]:
    """Thread loads on both sides of a stage that models load sharing, else empty.

    Empty for a split nut, too, whose threads also carry its preload.
    """
    sharing = analysis.mechanism.stages[index].load_sharing
    if sharing is None or sharing.split_nut is not None:
        return ()
    distribution = analysis.distribution(index, under)
    return distribution.screw, distribution.nut


def sharing_factor_of(
    analysis: Analysis, index: int, under: SharedLoad = "largest"
) -> Scalar | float:
    """Load of the most loaded thread over the mean, on the worse side, under one of the loads."""
    factors = [side.thread_sharing_factor for side in _sides(analysis, index, under)]
    return jnp.max(jnp.stack(factors)) if factors else 1.0


def _fatigue_factor(analysis: Analysis, index: int) -> Scalar | float:
    """Factor of unequal thread loads on the capacity, worse side, under the equivalent load."""
    factors = [
        strength.fatigue_sharing_factor(
            jnp.where(side.loaded, side.thread_load, 0.0),
            jnp.broadcast_to(side.weight[:, None], side.thread_load.shape),
        )
        for side in _sides(analysis, index, "equivalent")
    ]
    return jnp.max(jnp.stack(factors)) if factors else 1.0


def _thread_shares(
    analysis: Analysis, index: int
) -> tuple[strength.ThreadShares, strength.ThreadShares] | None:
    """Thread loads over their mean under the equivalent load; `None` if all are equal."""
    shares = []
    for side in _sides(analysis, index, "equivalent"):
        loads = jnp.ravel(side.thread_load)
        weights = jnp.ravel(jnp.broadcast_to(side.weight[:, None], side.thread_load.shape))
        weights = weights / jnp.sum(weights)
        mean = jnp.sum(weights * loads)
        # Without load all shares are 1.
        divisor = jnp.where(side.loaded, mean, 1.0)
        shares.append(strength.ThreadShares(jnp.where(side.loaded, loads / divisor, 1.0), weights))
    return (shares[0], shares[1]) if shares else None


def static_capacity_of(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    # A given capacity needs no contacts.
    if stage.strength is None or stage.strength.static_capacity is not None:
        return strength.static_capacity(stage)
    return analysis.once(
        ("static_capacity", index),
        lambda: strength.static_capacity(
            stage,
            analysis.meshing(index),
            analysis.reference_contact(index),
            sharing_factor_of(analysis, index),
            onsets_anywhere(analysis, index),
        ),
    )


@quantity(
    "static_capacity",
    "C_0a",
    "N",
    "static axial capacity: given, or at the permissible Hertz pressure (as ISO 76 for bearings), "
    "threads sharing as under the largest load",
    ("stage",),
    assumes=("static_sharing", "static_criterion", "static_load", "flanks_of_static"),
    shares=("largest",),
)
def static_capacity(analysis: Analysis):
    return per_stage(analysis, lambda i, stage: static_capacity_of(analysis, i, stage))


def static_safety_of(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    return strength.static_safety(
        static_capacity_of(analysis, index, stage), on_one_flank(analysis, stage)
    )


@quantity(
    "static_safety",
    "s_0",
    "1",
    "static capacity over the largest load of operating point and duty cycle, smallest of all "
    "stages (as ISO 76 for bearings); ∞ without load",
    assumes=("static_sharing", "static_criterion", "static_load", "flanks_of_static"),
    shares=("largest",),
)
def static_safety(analysis: Analysis):
    return jnp.min(per_stage(analysis, lambda i, stage: static_safety_of(analysis, i, stage)))


@quantity(
    "permanent_deformation",
    "δ_p/D_w",
    "1",
    "dent under the largest load over the rolling element's diameter, for hardened bearing steel "
    "(Palmgren; ISO 76 accepts 1e-4)",
    assumes=("dent_sharing", "flanks_of_contacts"),
    shares=("largest",),
)
def permanent_deformation(analysis: Analysis):
    return jnp.max(
        per_stage(
            analysis,
            lambda i, stage: strength.permanent_deformation(
                stage,
                on_one_flank(analysis, stage),
                analysis.meshing(i),
                sharing_factor_of(analysis, i),
            ),
        )
    )


def dynamic_capacity_of(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    if stage.strength is None or stage.strength.material_factor is None:
        return strength.dynamic_capacity(stage)
    if stage.strength.dynamic_capacity is not None:
        return strength.dynamic_capacity(stage)
    return analysis.once(
        ("dynamic_capacity", index),
        lambda: strength.dynamic_capacity(
            stage,
            analysis.meshing(index),
            analysis.reference_contact(index),
            _fatigue_factor(analysis, index),
            truncated_fatigue_of(analysis, index, stage),
        ),
    )


def truncated_fatigue_of(
    analysis: Analysis, index: int, stage: Stage
) -> strength.TruncatedFatigue | None:
    """Effect of the ends of flanks on the fatigue of a stage; `None` where they have none."""
    if not (flanks_end(stage) and strength.cuts_fatigue(stage)):
        return None
    return analysis.once(
        ("truncated_fatigue", index),
        lambda: strength.truncated_fatigue(
            stage,
            analysis.meshing(index),
            analysis.reference_contact(index),
            _fatigue_factor(analysis, index),
            onsets_anywhere(analysis, index),
            _thread_shares(analysis, index),
        ),
    )


@quantity(
    "dynamic_capacity",
    "C_a",
    "N",
    "dynamic axial capacity for 1e6 turns: given, or estimated by the theory of ball bearings "
    "(Lundberg and Palmgren) or the formula of ball screws, as no standard exists for roller "
    "screws; load sharing under the equivalent load",
    ("stage",),
    assumes=("dynamic_sharing", "life_theory", "flanks_of_dynamic"),
    shares=("equivalent",),
)
def dynamic_capacity(analysis: Analysis):
    return per_stage(analysis, lambda i, stage: dynamic_capacity_of(analysis, i, stage))


#: Name, symbol, unit, description, function and assumptions of quantities of the screw alone.
_OF_THE_SCREW = (
    (
        "buckling_load",
        "F_k",
        "N",
        "axial load at which the screw buckles (Euler; Johnson for a short screw whose yield "
        "strength is given)",
        strength.buckling_load,
        ("euler",),
    ),
    (
        "slenderness_ratio",
        "λ_k",
        "1",
        "effective length of the screw over its radius of gyration at the thread's root",
        strength.slenderness_ratio,
        (),
    ),
    (
        "critical_speed",
        "Ω_k",
        "rad/s",
        "screw speed at its first bending frequency (whirling), nut at the worst position",
        strength.critical_speed,
        (),
    ),
    (
        "permissible_speed",
        "Ω_perm",
        "rad/s",
        "permissible share of the critical speed, or the speed of the DN limit if that is lower "
        "(as catalogues of ball screws)",
        strength.permissible_speed,
        (),
    ),
)


def _of_every_stage(function: Callable[[Stage], Scalar]):
    return lambda analysis: per_stage(analysis, lambda _, stage: function(stage))


for _name, _symbol, _unit, _description, _function, _assumes in _OF_THE_SCREW:
    _of_stages = quantity(_name, _symbol, _unit, _description, ("stage",), assumes=_assumes)
    _of_stages(_of_every_stage(_function))


@quantity(
    "buckling_safety",
    "s_k",
    "1",
    "buckling load over the largest load, taken as compressive; smallest of all stages (catalogues "
    "of ball screws require 2); ∞ without load",
    assumes=("euler",),
)
def buckling_safety(analysis: Analysis):
    loads = per_stage(analysis, lambda _, stage: strength.buckling_load(stage))
    return strength.static_safety(jnp.min(loads), analysis.demand[1])


@quantity(
    "critical_speed_margin",
    "m_Ω",
    "1",
    "1 − largest speed over permissible speed, smallest of all stages (as catalogues of ball "
    "screws): at 0 the limit is reached",
)
def critical_speed_margin(analysis: Analysis):
    limits = per_stage(analysis, lambda _, stage: strength.permissible_speed(stage))
    return 1 - analysis.demand[0] / jnp.min(limits)


@quantity(
    "dn_value",
    "d Ω",
    "m·rad/s",
    "nominal screw diameter times the largest speed (DN value, as catalogues of ball screws)",
    ("stage",),
)
def dn_value(analysis: Analysis):
    return per_stage(analysis, lambda _, stage: strength.dn_value(stage, analysis.demand[0]))
