"""Verbs that analyse one mechanism: check, contact, modal, steady, simulate."""

import math
from typing import Annotated, Any, Literal

import equinox as eqx
import numpy as np
from cyclopts import Parameter

from ..contact import thread_contacts
from ..dynamics import default_scenario, simulate as run_transient, steady_state
from ..geometry import check as run_checks, mesh
from ..mechanism import Mechanism
from ..modal import modal as run_modal
from ._app import app
from ._common import Common, emit, table

_DEFAULT = Common()


@app.command
def check(file: str, *, common: Common = _DEFAULT) -> int:
    """Does the mechanism fit together? Prints findings; exit status 1 if one is an error."""
    findings = run_checks(common.load(file))
    rows = [(f.name, f.severity, f.stage, f.message) for f in findings]
    text = table("Findings", ["name", "severity", "stage", "what"], rows) if rows else "no findings"
    keys = ("name", "severity", "stage", "value", "limit", "message")
    emit(common, {"findings": [{k: getattr(f, k) for k in keys} for f in findings]}, text)
    return int(any(f.severity == "error" for f in findings))


@eqx.filter_jit
def _contacts(mechanism: Mechanism):
    meshings = tuple(mesh(stage.thread) for stage in mechanism.stages)
    return meshings, thread_contacts(mechanism)


@app.command
def contact(file: str, *, common: Common = _DEFAULT) -> int:
    """Thread contacts under the operating load: position, ellipse, pressure, stiffness."""
    mechanism = common.load(file)
    meshings, contacts = _contacts(mechanism)
    stages, rows = [], []
    for number, (meshing, pair) in enumerate(zip(meshings, contacts, strict=True), start=1):
        sides: dict[str, Any] = {"stage": number, "converged": bool(meshing.converged)}
        for name in ("screw", "nut"):
            where, result = getattr(meshing, name), getattr(pair, name)
            hertz = result.hertz
            side = {
                "contact_radius_m": where.contact_radius,
                "contact_angle_position_rad": where.contact_angle_position,
                "roller_contact_radius_m": where.roller_contact_radius,
                "roller_angle_position_rad": where.roller_angle_position,
                "normal_force_n": result.normal_force,
                "semi_major_m": hertz.semi_major,
                "semi_minor_m": hertz.semi_minor,
                "max_pressure_pa": hertz.max_pressure,
                "approach_m": hertz.approach,
                "stiffness_n_per_m": hertz.stiffness,
                "stiffness_tangent_n_per_m": hertz.stiffness_tangent,
                "axial_stiffness_n_per_m": result.axial_stiffness,
                "roller_stiffness_n_per_m": result.roller_stiffness,
            }
            sides[name] = {key: float(value) for key, value in side.items()}
            side = sides[name]
            rows.append(
                (
                    f"{number} {name}",
                    side["contact_radius_m"] * 1e3,
                    math.degrees(side["contact_angle_position_rad"]),
                    side["normal_force_n"],
                    side["semi_major_m"] * 1e3,
                    side["semi_minor_m"] * 1e3,
                    side["max_pressure_pa"] / 1e6,
                    side["approach_m"] * 1e6,
                    side["stiffness_n_per_m"] / 1e6,
                )
            )
        stages.append(sides)
    columns = ["stage side", "r mm", "φ deg", "F_n N", "a mm", "b mm", "p₀ MPa", "δ µm", "F/δ N/µm"]
    emit(common, {"stages": stages}, table(f"Thread contacts: {file}", columns, rows))
    return int(not all(stage["converged"] for stage in stages))


@app.command
def modal(
    file: str,
    *,
    stage: Annotated[int, Parameter(help="Which stage, counted from 1.")] = 1,
    common: Common = _DEFAULT,
) -> int:
    """Natural frequencies and families of one stage."""
    modes = eqx.filter_jit(lambda m: run_modal(m, stage=stage))(common.load(file))
    frequencies = np.asarray(modes.frequencies)
    families, multiplicities = modes.families, modes.multiplicities
    results = {
        "stage": stage,
        "frequencies_hz": frequencies,
        "families": families,
        "multiplicities": multiplicities,
    }
    rows, index = [], 0
    while index < len(frequencies):
        rows.append((families[index], float(frequencies[index]), multiplicities[index]))
        index += multiplicities[index]
    text = table(f"Natural frequencies: {file}, stage {stage}", ["family", "f Hz", "times"], rows)
    emit(common, results, text)
    return 0


_steady = eqx.filter_jit(lambda mechanism: steady_state(mechanism))


@app.command
def steady(file: str, *, common: Common = _DEFAULT) -> int:
    """Steady state: efficiency, torque, forces, every loss by name, power balance."""
    mechanism = common.load(file)
    state = _steady(mechanism)
    point = mechanism.operating_point
    results = {
        "speed_rad_per_s": None if point is None else point.speed,
        "load_n": None if point is None else point.load,
        "efficiency": state.efficiency,
        "carrier_ratio": state.carrier_ratio,
        "drive_torque_nm": state.drive_torque,
        "contact_force_n": state.contact_force,
        "screw_roller_axial_force_n": state.screw_roller_axial_force,
        "ring_gear_force_n": state.ring_gear_force,
        "carrier_force_n": state.carrier_force,
        "slip_speed_m_per_s": state.slip_speed,
        "losses_w": state.losses,
        "input_power_w": state.input_power,
        "output_power_w": state.output_power,
        "power_balance_residual": state.power_balance_residual,
        "valid": bool(state.valid),
    }
    rows: list[tuple[str, Any]] = [
        ("efficiency", float(state.efficiency)),
        ("drive torque N·m", float(state.drive_torque)),
        ("input power W", float(state.input_power)),
        ("output power W", float(state.output_power)),
        *((f"loss: {name} W", float(power)) for name, power in state.losses.items()),
        ("power balance residual", f"{float(state.power_balance_residual):.1e}"),
    ]
    for number, (ratio, force) in enumerate(
        zip(state.carrier_ratio, state.contact_force, strict=True), start=1
    ):
        rows.append((f"stage {number}: carrier ratio", float(ratio)))
        rows.append((f"stage {number}: contact force of one roller N", float(force)))
    if not state.valid:
        rows.append(("valid", "no: the thread locks, or the meshing has no solution"))
    emit(common, results, table(f"Steady state: {file}", ["", ""], rows))
    return int(not state.valid)


@app.command
def simulate(
    file: str,
    *,
    method: Annotated[
        Literal["implicit", "explicit"], Parameter(help="Integrator.")
    ] = "implicit",
    samples: Annotated[int, Parameter(help="Number of times in the result.")] = 201,
    common: Common = _DEFAULT,
) -> int:
    """Transient after a step of the screw speed, from rollers at rest."""
    mechanism = common.load(file)
    scenario = eqx.tree_at(lambda s: s.speed, default_scenario(mechanism), replace_fn=lambda s: s)
    scenario = type(scenario)(scenario.speed, scenario.load, scenario.duration, samples=samples)
    run = eqx.filter_jit(
        lambda m, s: run_transient(m, s, method=method, gradient="reverse", throw=False)
    )(mechanism, scenario)
    solver = {
        "name": run.solver.name,
        "steps": int(run.solver.steps),
        "rejected": int(run.solver.rejected),
        "result": run.solver.result,
    }
    results = {
        "time_s": run.time,
        "carrier_ratio": run.carrier_ratio,
        "efficiency": run.efficiency,
        "drive_torque_nm": run.drive_torque,
        "screw_roller_axial_force_n": run.screw_roller_axial_force,
        "contact_force_n": run.contact_force,
        "ring_gear_force_n": run.ring_gear_force,
        "carrier_force_n": run.carrier_force,
        "spline_friction_n": run.spline_friction,
        "losses_w": run.losses,
        "power_balance_residual": run.power_balance_residual,
        "solver": solver,
    }
    rows: list[tuple[Any, ...]] = [
        ("efficiency", float(run.efficiency[0]), float(run.efficiency[-1])),
        ("drive torque N·m", float(run.drive_torque[0]), float(run.drive_torque[-1])),
    ]
    for number, ratios in enumerate(run.carrier_ratio, start=1):
        rows.append((f"stage {number}: carrier ratio", float(ratios[0]), float(ratios[-1])))
    text = table(f"Transient: {file}", ["", "start", "end"], rows)
    text += f"{solver['name']}: {solver['steps']} steps, {solver['rejected']} rejected, "
    text += solver["result"]
    if common.out is not None:
        from ..report import transient_chart

        common.out.mkdir(parents=True, exist_ok=True)
        transient_chart(run).savefig(common.out / "transient.png")
        text += f"\npicture: {common.out / 'transient.png'}"
    emit(common, results, text)
    return int(run.solver.code != 0)
