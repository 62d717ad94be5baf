"""Quantities of the natural vibration."""

import functools

import jax.numpy as jnp

from ..._errors import MissingDataError
from ...numerics import above_or_nan
from ...response import excitation_orders, gear_mesh_order, has_gear_teeth
from ...stiffness import ring_roller_stiffness
from .._analysis import Analysis
from .._catalogue import quantity
from ._operation import carrier_ratio

_STIFFNESS = ("equal_stiffness", "secant_stiffness", "stiffness_without_preload", "stages_alone")
_frequency = functools.partial(quantity, assumes=_STIFFNESS, shares=("operating_point",))
#: A mode is mesh-dominated when more than this share of its strain energy is in the contacts.
_DOMINANT = 0.5


def _lowest_mesh_dominated(groups):
    frequencies = [
        jnp.where(above_or_nan(group.mesh_energy_share, _DOMINANT), group.frequencies, jnp.inf)
        for group in groups
    ]
    return jnp.min(jnp.concatenate(frequencies))


def _all(groups):
    return jnp.concatenate([group.frequencies for group in groups])


def _needs_symmetry(analysis: Analysis) -> None:
    if not analysis.symmetric:
        raise MissingDataError(
            "a stage has unequal rollers, fewer than 3 rollers, or supports that differ in x and "
            "y, so its modes have no separate families; request natural_frequencies or a lowest_… "
            "frequency instead"
        )


@_frequency("natural_frequencies", "f", "Hz", "all natural frequencies, by stage", ("mode",))
def natural_frequencies(analysis: Analysis):
    return jnp.concatenate([modes.frequencies for modes in analysis.modes])


@_frequency(
    "torsional_frequencies", "f_t", "Hz", "torsional natural frequencies, by stage", ("mode",)
)
def torsional_frequencies(analysis: Analysis):
    _needs_symmetry(analysis)
    return _all(analysis.torsional)


@_frequency(
    "transverse_frequencies",
    "f_x",
    "Hz",
    "transverse natural frequencies (each double), by stage",
    ("mode",),
)
def transverse_frequencies(analysis: Analysis):
    _needs_symmetry(analysis)
    return _all(analysis.transverse)


@_frequency("roller_frequency", "f_R", "Hz", "roller natural frequency (N − 3 fold)", ("stage",))
def roller_frequency(analysis: Analysis):
    _needs_symmetry(analysis)
    groups = [group for group in analysis.roller if group is not None]
    if len(groups) < len(analysis.roller):
        raise MissingDataError("a stage with three rollers has no roller modes")
    return _all(groups)


@quantity(
    "carrier_frequency",
    "f_c",
    "Hz",
    "carrier natural frequency",
    ("stage",),
    shares=("operating_point",),
)
def carrier_frequency(analysis: Analysis):
    groups = [group for group in analysis.carrier if group is not None]
    if len(groups) < len(analysis.carrier):
        raise MissingDataError(
            "a stage has no carrier that moves on its own; give [stage.carrier], and no "
            "[stage.roller.support]"
        )
    return _all(groups)


@_frequency("lowest_torsional_frequency", "f_t1", "Hz", "lowest torsional natural frequency")
def lowest_torsional_frequency(analysis: Analysis):
    return jnp.min(_all(analysis.torsional))


@_frequency(
    "lowest_mesh_torsional_frequency",
    "f_tm",
    "Hz",
    "lowest torsional natural frequency with most of its strain energy in the contacts; jumps to "
    "another mode where the share of energy passes one half",
)
def lowest_mesh_torsional_frequency(analysis: Analysis):
    return _lowest_mesh_dominated(analysis.torsional)


@_frequency("lowest_transverse_frequency", "f_x1", "Hz", "lowest transverse natural frequency")
def lowest_transverse_frequency(analysis: Analysis):
    return jnp.min(_all(analysis.transverse))


@_frequency(
    "lowest_mesh_transverse_frequency",
    "f_xm",
    "Hz",
    "lowest transverse natural frequency with most of its strain energy in the contacts; jumps to "
    "another mode where the share of energy passes one half",
)
def lowest_mesh_transverse_frequency(analysis: Analysis):
    return _lowest_mesh_dominated(analysis.transverse)


@quantity("gear_mesh_stiffness", "k_rR", "N/m", "gear mesh stiffness of one roller", ("stage",))
def gear_mesh_stiffness(analysis: Analysis):
    stiffnesses = [ring_roller_stiffness(stage) for stage in analysis.mechanism.stages]
    if any(stiffness is None for stiffness in stiffnesses):
        raise MissingDataError("a stage has no gear; give [stage.gear]")
    return jnp.stack([stiffness for stiffness in stiffnesses if stiffness is not None])


@quantity(
    "lowest_critical_speed",
    "Ω_c",
    "rad/s",
    "lowest screw speed at which the gear mesh frequency equals that of a torsional or transverse "
    "mode with most of its strain energy in the contacts, for any phases of the rollers",
    assumes=(*_STIFFNESS, "equal_friction"),
    shares=("operating_point",),
)
def lowest_critical_speed(analysis: Analysis):
    ratios = carrier_ratio(analysis)
    speeds = []
    for index, stage in enumerate(analysis.mechanism.stages):
        if not has_gear_teeth(stage):
            raise MissingDataError(
                "a stage has no gear teeth; give roller_teeth in [stage.gear], and "
                "[stage.ring_gear] for a standard roller screw"
            )
        mesh = gear_mesh_order(excitation_orders(stage, ratios[index]))
        lowest = _lowest_mesh_dominated((analysis.torsional[index], analysis.transverse[index]))
        speeds.append(2 * jnp.pi * lowest / mesh.order)
    return jnp.min(jnp.stack(speeds))
