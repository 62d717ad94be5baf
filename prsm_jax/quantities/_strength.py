"""Quantities of strength and life; what rests on standards of other machines says so.

No standard exists for planetary roller screws: static safety, rating life and their factors are
those of rolling bearings (ISO 76, ISO 281) and ball screws (ISO 3408-5).
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp

from .. import strength
from .._errors import MissingDataError
from ..dynamics import steady_state
from ..mechanism import Friction, Mechanism, Scalar, Stage
from ._analysis import Analysis
from ._catalogue import quantity

#: At standstill the torque is that of the motion about to begin [rad/s].
_CREEP = 1e-6


def _per_stage(analysis: Analysis, function: Callable[[int, Stage], Scalar]):
    return jnp.stack([function(i, stage) for i, stage in enumerate(analysis.mechanism.stages)])


def _on_one_flank(analysis: Analysis, stage: Stage) -> Scalar:
    """Largest load on one flank, preload included [N]."""
    return strength.largest_flank_load(stage, analysis.demand[1])


def _static_capacity(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    # What is given needs no contacts.
    if stage.strength is None or stage.strength.static_capacity is not None:
        return strength.static_capacity(stage)
    return strength.static_capacity(
        stage, analysis.meshing(index), analysis.reference_contacts[index]
    )


@quantity(
    "static_capacity",
    "C_0a",
    "N",
    "static axial capacity: given, or at the permissible Hertz pressure (as in ISO 76)",
    ("stage",),
)
def static_capacity(analysis: Analysis):
    return _per_stage(analysis, lambda i, stage: _static_capacity(analysis, i, stage))


@quantity(
    "static_safety",
    "s_0",
    "1",
    "static capacity over the largest load of operating point and duty cycle, smallest of all "
    "stages; ∞ without load",
)
def static_safety(analysis: Analysis):
    return jnp.min(
        _per_stage(
            analysis,
            lambda i, stage: strength.static_safety(
                _static_capacity(analysis, i, stage), _on_one_flank(analysis, stage)
            ),
        )
    )


@quantity(
    "permanent_deformation",
    "δ_p/D_w",
    "1",
    "dent under the largest load over the rolling element's diameter, for hardened bearing steel "
    "(Palmgren; ISO 76 accepts 1e-4)",
)
def permanent_deformation(analysis: Analysis):
    return jnp.max(
        _per_stage(
            analysis,
            lambda i, stage: strength.permanent_deformation(
                stage, _on_one_flank(analysis, stage), analysis.meshing(i)
            ),
        )
    )


def _dynamic_capacity(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    if stage.strength is None or stage.strength.material_factor is None:
        return strength.dynamic_capacity(stage)
    if stage.strength.dynamic_capacity is not None:
        return strength.dynamic_capacity(stage)
    return strength.dynamic_capacity(
        stage, analysis.meshing(index), analysis.reference_contacts[index]
    )


@quantity(
    "dynamic_capacity",
    "C_a",
    "N",
    "dynamic axial capacity for 1e6 turns: given, or estimated by the theory of ball bearings "
    "(Lundberg and Palmgren), as no standard exists for roller screws",
    ("stage",),
)
def dynamic_capacity(analysis: Analysis):
    return _per_stage(analysis, lambda i, stage: _dynamic_capacity(analysis, i, stage))


@quantity("equivalent_load", "F_m", "N", "cubic mean load of the duty cycle, weighted by travel")
def equivalent_load(analysis: Analysis):
    _needs_duty_cycle(analysis)
    return strength.equivalent_load(analysis.spectrum)


@quantity(
    "equivalent_speed", "Ω_m", "rad/s", "mean magnitude of the screw speed over the duty cycle"
)
def equivalent_speed(analysis: Analysis):
    _needs_duty_cycle(analysis)
    return analysis.spectrum.mean_speed


def _needs_duty_cycle(analysis: Analysis) -> None:
    if analysis.mechanism.duty_cycle is None:
        raise MissingDataError("the mechanism has no duty cycle; give [[duty_cycle]] phases")


def _rating_life(analysis: Analysis, name: str):
    return _per_stage(
        analysis,
        lambda i, stage: getattr(
            strength.rating_life(stage, _dynamic_capacity(analysis, i, stage), analysis.spectrum),
            name,
        ),
    )


@quantity(
    "rating_life",
    "L_10",
    "1",
    "turns of the screw with a survival of 90 %, under the duty cycle or else the operating point "
    "(as ISO 3408-5 for ball screws); ∞ without load",
    ("stage",),
)
def rating_life(analysis: Analysis):
    return _rating_life(analysis, "revolutions")


@quantity(
    "rating_life_time",
    "L_10h",
    "s",
    "operating time with a survival of 90 %, standstill of the duty cycle included (as ISO 3408-5)",
    ("stage",),
)
def rating_life_time(analysis: Analysis):
    return _rating_life(analysis, "time")


@quantity(
    "rating_life_distance",
    "L_10s",
    "m",
    "travel of the nut on its screw with a survival of 90 % (as ISO 3408-5)",
    ("stage",),
)
def rating_life_distance(analysis: Analysis):
    return _rating_life(analysis, "distance")


def _life_factor(stage: Stage) -> Scalar:
    factor = strength.life_factor(stage)
    if factor is None:
        raise MissingDataError(
            "the stage modifies its rating life by nothing; give reliability, "
            "life_modification_factor or oscillation_amplitude in [stage.strength]"
        )
    return factor


@quantity(
    "modified_rating_life",
    "L_nm",
    "1",
    "turns of the screw at the reliability asked for, with given factors of lubrication and "
    "material and that of oscillation (as ISO 281 for bearings)",
    ("stage",),
)
def modified_rating_life(analysis: Analysis):
    factors = _per_stage(analysis, lambda _, stage: _life_factor(stage))
    return strength.modified_life(_rating_life(analysis, "revolutions"), factors)


def _required_life(stage: Stage) -> Scalar:
    if stage.strength is None or stage.strength.required_life is None:
        raise MissingDataError("no life is asked for; give stage.strength.required_life")
    return stage.strength.required_life


@quantity(
    "life_ratio",
    "L/L_req",
    "1",
    "rating life in time, modified as far as factors are given, over the life asked for, smallest "
    "of all stages",
)
def life_ratio(analysis: Analysis):
    def factor(stage: Stage) -> Scalar:
        found = strength.life_factor(stage)
        return 1 / _required_life(stage) if found is None else found / _required_life(stage)

    factors = _per_stage(analysis, lambda _, stage: factor(stage))
    return jnp.min(strength.modified_life(_rating_life(analysis, "time"), factors))


def _phase_damage(analysis: Analysis):
    _needs_duty_cycle(analysis)
    return _per_stage(
        analysis,
        lambda i, stage: strength.damage(
            stage, _dynamic_capacity(analysis, i, stage), analysis.spectrum
        ),
    )


@quantity(
    "phase_damage",
    "D_i",
    "1",
    "share of the basic rating life that each phase of one duty cycle uses up (Palmgren–Miner)",
    ("stage", "phase"),
)
def phase_damage(analysis: Analysis):
    return _phase_damage(analysis)


@quantity(
    "duty_cycle_damage",
    "D",
    "1",
    "share of the basic rating life that one duty cycle uses up (Palmgren–Miner)",
    ("stage",),
)
def duty_cycle_damage(analysis: Analysis):
    return jnp.sum(_phase_damage(analysis), axis=1)


@quantity(
    "minimum_oscillation_amplitude",
    "φ_min",
    "rad",
    "amplitude of a swinging screw below which contacts do not leave their own ellipse, and false "
    "brinelling is to be expected",
    ("stage",),
)
def minimum_oscillation_amplitude(analysis: Analysis):
    return _per_stage(
        analysis,
        lambda i, stage: strength.minimum_oscillation_amplitude(
            stage, analysis.load, contact=analysis.reference_contacts[i]
        ),
    )


@quantity(
    "buckling_load",
    "F_k",
    "N",
    "axial load at which the screw buckles (Euler; Johnson where short and its yield strength is "
    "given)",
    ("stage",),
)
def buckling_load(analysis: Analysis):
    return _per_stage(analysis, lambda _, stage: strength.buckling_load(stage))


@quantity(
    "buckling_safety",
    "s_k",
    "1",
    "buckling load over the largest load, as if it pressed, smallest of all stages; ∞ without load",
)
def buckling_safety(analysis: Analysis):
    loads = _per_stage(analysis, lambda _, stage: strength.buckling_load(stage))
    return strength.static_safety(jnp.min(loads), analysis.demand[1])


@quantity(
    "slenderness_ratio",
    "λ_k",
    "1",
    "effective length of the screw over its radius of gyration at the thread's root",
    ("stage",),
)
def slenderness_ratio(analysis: Analysis):
    return _per_stage(analysis, lambda _, stage: strength.slenderness_ratio(stage))


@quantity(
    "critical_speed",
    "Ω_k",
    "rad/s",
    "screw speed at its first bending frequency, where it whirls, the nut at its worst place",
    ("stage",),
)
def critical_speed(analysis: Analysis):
    return _per_stage(analysis, lambda _, stage: strength.critical_speed(stage))


@quantity(
    "permissible_speed",
    "Ω_perm",
    "rad/s",
    "permissible share of the critical speed, or the speed of the DN limit if that is lower",
    ("stage",),
)
def permissible_speed(analysis: Analysis):
    return _per_stage(analysis, lambda _, stage: strength.permissible_speed(stage))


@quantity(
    "critical_speed_margin",
    "m_Ω",
    "1",
    "1 − largest speed over permissible speed, smallest of all stages: at 0 the limit is reached",
)
def critical_speed_margin(analysis: Analysis):
    limits = _per_stage(analysis, lambda _, stage: strength.permissible_speed(stage))
    return 1 - analysis.demand[0] / jnp.min(limits)


@quantity(
    "dn_value",
    "d Ω",
    "m·rad/s",
    "nominal screw diameter times the largest speed (DN value)",
    ("stage",),
)
def dn_value(analysis: Analysis):
    return _per_stage(analysis, lambda _, stage: strength.dn_value(stage, analysis.demand[0]))


@quantity(
    "axial_backlash",
    "j_a",
    "m",
    "travel of the unloaded nut: measured, or from thinned teeth and the meshing; 0 with preload",
    ("stage",),
)
def axial_backlash(analysis: Analysis):
    def of(index: int, stage: Stage) -> Scalar:
        thinned = strength.needs_meshing_for_backlash(stage)
        return strength.backlash(stage, analysis.kinematics[index].meshing if thinned else None)

    return _per_stage(analysis, of)


@quantity(
    "lost_motion",
    "j_F",
    "m",
    "travel of the nut when the load turns round at a screw that stands still: backlash and "
    "approach of the contacts, shafts rigid",
    ("stage",),
)
def lost_motion(analysis: Analysis):
    def of(index: int, stage: Stage) -> Scalar:
        thinned = strength.needs_meshing_for_backlash(stage)
        return strength.lost_motion(
            stage,
            analysis.load,
            analysis.kinematics[index].meshing if thinned else None,
            analysis.reference_contacts[index],
        )

    return _per_stage(analysis, of)


@quantity(
    "preload_opening_load",
    "F_lim",
    "N",
    "axial load that frees one of two braced nuts, 2^{3/2} times the preload",
    ("stage",),
)
def preload_opening_load(analysis: Analysis):
    return _per_stage(
        analysis, lambda _, stage: strength.preload_opening_load(strength.preload_force(stage))
    )


@quantity(
    "preloaded_stiffness",
    "K_pr",
    "N/m",
    "tangent stiffness of a braced pair of nuts under the load, contacts alone",
    ("stage",),
)
def preloaded_stiffness(analysis: Analysis):
    def of(index: int, stage: Stage) -> Scalar:
        strength.preload_force(stage)
        return strength.preloaded_stiffness(
            stage, analysis.load, analysis.reference_contacts[index]
        )

    return _per_stage(analysis, of)


@quantity(
    "preload_torque",
    "M_pr",
    "N·m",
    "drag torque of the preload: friction of the threads of both nuts, without bearings and drag",
    ("stage",),
)
def preload_torque(analysis: Analysis):
    return _per_stage(analysis, lambda i, stage: _preload_torque(analysis, i, stage))


def _preload_torque(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    preload = strength.preload_force(stage)
    if stage.friction is None:
        raise MissingDataError("the stage has no friction; give [stage.friction.thread]")
    # Not `dataclasses.replace`: that would run converters, which a batched leaf may not pass.
    friction: Friction = eqx.tree_at(
        lambda f: (f.spline, f.thrust_bearing, f.drag),
        stage.friction,
        (None, None, None),
        is_leaf=lambda leaf: leaf is None,
    )
    alone = Mechanism((eqx.tree_at(lambda s: s.friction, stage, friction),))
    kinematics = (analysis.kinematics[index],)
    speed = jnp.abs(analysis.speed)
    speed = jnp.where(speed > 0, speed, _CREEP)
    # The screw drives one nut against the preload, which helps it to turn in the other.
    states = jax.vmap(lambda load: steady_state(alone, speed, load, kinematics))(
        jnp.stack([preload, -preload])
    )
    analysis.require(states.valid.all())
    return jnp.sum(states.drive_torque)
