"""Quantities of size, mass and fit."""

import jax.numpy as jnp

from ..._errors import MissingDataError
from ...geometry import roller_clearance as stage_roller_clearance
from ...mechanism import (
    body_mass,
    nut_outer_radius,
    nut_unit_mass as stage_nut_unit_mass,
    stage_mass,
)
from .._analysis import Analysis
from .._catalogue import quantity


def _per_stage(analysis: Analysis, function):
    return jnp.stack([function(stage) for stage in analysis.mechanism.stages])


@quantity("mass", "m", "kg", "mass of all bodies of all stages", assumes=("masses",))
def mass(analysis: Analysis):
    return jnp.sum(_per_stage(analysis, stage_mass))


@quantity(
    "nut_unit_mass",
    "m_n",
    "kg",
    "mass of what moves along the axis: nuts (the screw of an inverted roller screw), rollers, "
    "carriers and ring gears of all stages, and the screws from stage 2 on, which ride on nuts",
    assumes=("masses",),
)
def nut_unit_mass(analysis: Analysis):
    stages = analysis.mechanism.stages
    riding = [body_mass(stage, "screw") for stage in stages[1:]]
    return jnp.sum(jnp.stack([*map(stage_nut_unit_mass, stages), *riding]))


@quantity("nut_outer_diameter", "D_n", "m", "outer diameter of the largest nut")
def nut_outer_diameter(analysis: Analysis):
    return jnp.max(2 * _per_stage(analysis, nut_outer_radius))


@quantity("roller_clearance", "c_R", "m", "smallest gap between neighbouring rollers")
def roller_clearance(analysis: Analysis):
    return jnp.min(_per_stage(analysis, stage_roller_clearance))


def _of_thread(name: str):
    return lambda analysis: _per_stage(analysis, lambda stage: getattr(stage.thread, name))


for _name, _symbol, _unit, _description in (
    ("centre_distance", "a", "m", "distance of screw and roller axes"),
    ("screw_radius", "r_s", "m", "nominal screw radius"),
    ("nut_radius", "r_n", "m", "nominal nut radius"),
    ("screw_helix_angle", "λ_s", "rad", "helix angle of the screw"),
    ("roller_helix_angle", "β_R", "rad", "helix angle of roller and nut"),
):
    quantity(_name, _symbol, _unit, _description, ("stage",))(_of_thread(_name))


@quantity("gear_module", "m_R", "m", "module of the roller's gear, 2 r_R / z_R", ("stage",))
def gear_module(analysis: Analysis):
    modules = [stage.gear_module for stage in analysis.mechanism.stages]
    if any(module is None for module in modules):
        raise MissingDataError("a stage has no gear teeth; give roller_teeth in [stage.gear]")
    return jnp.stack([module for module in modules if module is not None])


@quantity("screw_contact_radius", "r_sR", "m", "radius of the screw at its contact", ("stage",))
def screw_contact_radius(analysis: Analysis):
    return jnp.stack([k.meshing.screw.contact_radius for k in analysis.kinematics])


@quantity(
    "axial_gap", "g", "m", "axial gap per flank with all teeth half a pitch thick", ("stage",)
)
def axial_gap(analysis: Analysis):
    return jnp.stack([k.meshing.axial_gap for k in analysis.kinematics])
