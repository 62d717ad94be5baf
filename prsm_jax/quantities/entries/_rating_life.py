"""Quantities of rating life; descriptions name the standards taken from other machines."""

import functools

import jax.numpy as jnp

from ... import strength
from ..._errors import MissingDataError
from ...fields import Scalar
from ...mechanism import Stage
from .._analysis import Analysis
from .._catalogue import quantity
from ._strength import dynamic_capacity_of, on_one_flank, per_stage, truncated_fatigue_of

_life = functools.partial(
    quantity,
    assumes=("dynamic_sharing", "life_theory", "flanks_of_dynamic"),
    shares=("equivalent",),
)


@quantity(
    "equivalent_load",
    "F_m",
    "N",
    "cubic mean load of the duty cycle, weighted by travel (as ISO 3408-5 for ball screws)",
)
def equivalent_load(analysis: Analysis):
    analysis.require_duty_cycle()
    return strength.equivalent_load(analysis.spectrum)


@quantity(
    "equivalent_speed",
    "Ω_m",
    "rad/s",
    "mean speed of the body that turns, as a magnitude, over the duty cycle (as ISO 3408-5 for "
    "ball screws)",
)
def equivalent_speed(analysis: Analysis):
    analysis.require_duty_cycle()
    return analysis.spectrum.mean_speed


def _fatigue_of(analysis: Analysis, index: int, stage: Stage):
    """Arguments of `strength.rating_life` and `strength.damage`."""
    fatigue = truncated_fatigue_of(analysis, index, stage)
    # The search for a capacity with cut ellipses would be two fifths of the program of a life.
    capacity = None if fatigue is not None else dynamic_capacity_of(analysis, index, stage)
    return stage, capacity, analysis.spectrum, fatigue


def rating_life_of(analysis: Analysis, index: int, stage: Stage) -> strength.RatingLife:
    """Basic rating life of a stage under the loads of the analysis."""
    return strength.rating_life(*_fatigue_of(analysis, index, stage))


def _rating_life(analysis: Analysis, name: str):
    return per_stage(analysis, lambda i, stage: getattr(rating_life_of(analysis, i, stage), name))


@_life(
    "rating_life",
    "L_10",
    "1",
    "revolutions of the body that turns at 90 % reliability, under the duty cycle, or the "
    "operating point without one (as ISO 3408-5 for ball screws); ∞ without load",
    ("stage",),
)
def rating_life(analysis: Analysis):
    return _rating_life(analysis, "revolutions")


@_life(
    "rating_life_time",
    "L_10h",
    "s",
    "operating time at 90 % reliability, including standstill of the duty cycle (as ISO 3408-5)",
    ("stage",),
)
def rating_life_time(analysis: Analysis):
    return _rating_life(analysis, "time")


@_life(
    "rating_life_distance",
    "L_10s",
    "m",
    "travel of the nut on its screw at 90 % reliability (as ISO 3408-5)",
    ("stage",),
)
def rating_life_distance(analysis: Analysis):
    return _rating_life(analysis, "distance")


def _life_factor(stage: Stage) -> Scalar:
    factor = strength.life_factor(stage)
    if factor is None:
        raise MissingDataError(
            "the stage has no factor that modifies its rating life; give reliability, "
            "life_modification_factor or oscillation_amplitude in [stage.strength]"
        )
    return factor


@_life(
    "modified_rating_life",
    "L_nm",
    "1",
    "revolutions of the body that turns at the required reliability, with the given factors for "
    "lubrication and material and the factor for oscillation (as ISO 281 for bearings)",
    ("stage",),
)
def modified_rating_life(analysis: Analysis):
    factors = per_stage(analysis, lambda _, stage: _life_factor(stage))
    return strength.modified_life(_rating_life(analysis, "revolutions"), factors)


def _required_life(stage: Stage) -> Scalar:
    if stage.strength is None or stage.strength.required_life is None:
        raise MissingDataError("no required life; give stage.strength.required_life")
    return stage.strength.required_life


@_life(
    "life_ratio",
    "L/L_req",
    "1",
    "rating life in time, modified by the factors that are given, over the required life; smallest "
    "of all stages (as ISO 3408-5 for ball screws and ISO 281 for bearings)",
)
def life_ratio(analysis: Analysis):
    def factor(stage: Stage) -> Scalar:
        modification = strength.life_factor(stage)
        return (1 if modification is None else modification) / _required_life(stage)

    factors = per_stage(analysis, lambda _, stage: factor(stage))
    return jnp.min(strength.modified_life(_rating_life(analysis, "time"), factors))


@_life(
    "phase_damage",
    "D_i",
    "1",
    "share of the basic rating life (as ISO 3408-5 for ball screws) that each phase of one duty "
    "cycle uses up (Palmgren–Miner)",
    ("stage", "phase"),
)
def phase_damage(analysis: Analysis):
    analysis.require_duty_cycle()
    return per_stage(analysis, lambda i, stage: strength.damage(*_fatigue_of(analysis, i, stage)))


@_life(
    "duty_cycle_damage",
    "D",
    "1",
    "share of the basic rating life (as ISO 3408-5 for ball screws) that one duty cycle uses up "
    "(Palmgren–Miner)",
    ("stage",),
)
def duty_cycle_damage(analysis: Analysis):
    return jnp.sum(phase_damage(analysis), axis=1)


@quantity(
    "minimum_oscillation_amplitude",
    "φ_min",
    "rad",
    "amplitude of an oscillating screw below which contacts stay within their own ellipse under "
    "the largest load, so false brinelling is to be expected (as seen in bearings)",
    ("stage",),
    assumes=("equal_contacts",),
)
def minimum_oscillation_amplitude(analysis: Analysis):
    return per_stage(analysis, lambda i, stage: minimum_amplitude_of(analysis, i, stage))


def minimum_amplitude_of(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    return strength.minimum_oscillation_amplitude(
        stage, on_one_flank(analysis, stage), contact=analysis.reference_contact(index)
    )
