"""Made-up results for the charts, which need no physics."""

from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np

from prsm_jax.contact import HertzContact, StageContact, ThreadContactSide
from prsm_jax.dynamics import SolverReport, SteadyState, Transient
from prsm_jax.mechanism import Constraint, DesignProblem, Objective, Variable
from prsm_jax.optimisation import ConstraintReport, Design, Optimum, Run
from prsm_jax.vibration import ModeGroup, Modes


def make_modes(scale: float) -> Modes:
    return Modes(
        (
            ModeGroup(jnp.array([840.0 * scale]), jnp.zeros(1), 1, "carrier"),
            ModeGroup(scale * jnp.array([0.0, 4800.0, 13e3, 27e3]), jnp.ones(4), 1, "torsional"),
            ModeGroup(scale * jnp.array([2e3, 3e3, 21e3, 34e3]), jnp.ones(4), 2, "transverse"),
            ModeGroup(jnp.array([22e3 * scale]), jnp.ones(1), 4, "roller"),
        )
    )


def make_steady(output: float, **losses: float) -> SteadyState:
    one = jnp.ones(1)
    total = output + sum(losses.values())
    return SteadyState(
        efficiency=jnp.asarray(output / total if total else 0.0),
        carrier_ratio=0.37 * one,
        drive_torque=jnp.asarray(20.0),
        contact_force=1e3 * one,
        screw_roller_axial_force=700 * one,
        nut_load=7e3 * one,
        slip_speed=0.3 * one,
        ring_gear_force=one,
        carrier_force=one,
        spline_friction=0 * one,
        losses={name: jnp.asarray(value) for name, value in losses.items()},
        input_power=jnp.asarray(total),
        output_power=jnp.asarray(output),
        power_balance_residual=jnp.asarray(0.0),
        valid=jnp.asarray(True),
        screw_speed=jnp.asarray(100.0),
        slip_direction=jnp.zeros((*one.shape, 3)),
    )


def make_transient(stages: int = 2) -> Transient:
    time = jnp.linspace(0, 2e-3, 201)
    rise = 1 - jnp.exp(-time / 1e-4)
    per_stage = jnp.stack([0.37 * rise] * stages)
    return Transient(
        time=time,
        screw_speed=100.0 + 0 * time,
        carrier_speed=100 * per_stage,
        carrier_ratio=per_stage,
        efficiency=0.6 + 0.25 * rise,
        drive_torque=30 - 8 * rise,
        contact_force=per_stage,
        screw_roller_axial_force=per_stage,
        ring_gear_force=per_stage,
        carrier_force=per_stage,
        spline_friction=per_stage,
        stage_torque=per_stage,
        losses={},
        power_balance_residual=0 * time,
        newton_residual=0 * per_stage,
        carrier_acceleration=0 * per_stage,
        load=7e3 + 0 * time,
        slip_direction=jnp.zeros((stages, 201, 3)),
        solver=SolverReport(jnp.asarray(50), jnp.asarray(0), jnp.asarray(0), "Kvaerno5"),
    )


def make_contact(major: float, minor: float, pressure: float) -> StageContact:
    one = jnp.asarray(1.0)
    hertz = HertzContact(
        jnp.asarray(major), jnp.asarray(minor), jnp.asarray(pressure), one, one, one, one
    )
    side = ThreadContactSide(hertz, one, one, one)
    return StageContact(side, side)


def make_sensitivity():
    quantities = ("efficiency", "max_pressure", "lowest_mesh_torsional_frequency", "mass")
    parameters = ("lead", "contact_angle", "roller_radius", "roller_profile_radius")
    elasticity = np.array(
        [[0.02, -0.01, 2e-4, 0.0], [0.1, -0.6, -1.2, -0.4], [0.3, 0.7, 0.0, 0.1], [0, 0, 2.1, 0]]
    )
    return SimpleNamespace(
        quantities=quantities,
        parameters=parameters,
        quantity_units=("1", "Pa", "Hz", "kg"),
        parameter_units=("m", "rad", "m", "m"),
        parameter_values=tuple(np.array([v]) for v in (0.01, 0.785, 0.004, 0.0057)),
        values=np.array([0.85, 2e9, 8e3, 0.0]),
        gradient=np.array([[3.0, 0.1, 1.0, 0.0]] * 4),
        elasticity=elasticity,
        elasticity_defined=np.array([True, True, True, False]),
        valid=np.array(True),
    )


def make_optimum(mechanism, converged: bool = True) -> Optimum:
    problem = DesignProblem(
        (Variable("lead", 0.005, 0.02), Variable("contact_angle", 0.5, 1.0)),
        (Objective("efficiency", "maximise"),),
        (
            Constraint("max_pressure", upper=3e9),
            Constraint("lowest_mesh_torsional_frequency", lower=1e3),
            Constraint("nut_outer_diameter", upper=0.064),
        ),
    )

    def design(lead, angle, objective, pressure, frequency, diameter):
        limits = {
            "max_pressure": pressure,
            "lowest_mesh_torsional_frequency": frequency,
            "nut_outer_diameter": diameter,
        }
        variables = {"lead": lead, "contact_angle": angle}
        return Design(variables, objective, limits, True, 0.0)

    start = design(0.01, 0.785, 0.85, 2e9, 8e3, 0.06)
    end = design(0.02, 0.9, 0.87, 3e9, 1e4, 0.05)
    rows = (("max_pressure", "Pa", 3e9, None, 3e9, True, 1e-12),)
    rows += (("lowest_mesh_torsional_frequency", "Hz", 1e4, 1e3, None, False, 0.0),)
    rows += (("nut_outer_diameter", "m", 0.05, None, 0.064, False, 0.0),)
    constraints = tuple(
        ConstraintReport(
            name, unit, value, low, high, None, low or high or 0.0, active, True, multiplier
        )
        for name, unit, value, low, high, active, multiplier in rows
    )
    run = Run(start, end, (0.85, 0.88, 0.87), (0.0, 0.1, 0.0), (), (), 1e-9, 0, 3, "done")
    return Optimum(
        mechanism=mechanism,
        problem=problem,
        method="slsqp",
        start=start,
        optimum=end,
        constraints=constraints,
        bounds_active={"lead": "upper"},
        bound_multipliers={"lead": 1.0},
        converged=converged,
        kkt_residual=1e-9,
        stationarity=1e-9,
        message="KKT residual small",
        runs=(run,),
        best_run=0,
        evaluations=3,
        derivative_evaluations=3,
        variable_units={"lead": "m", "contact_angle": "rad"},
    )
