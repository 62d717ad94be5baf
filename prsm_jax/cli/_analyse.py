"""Verbs that analyse one mechanism: check, steady, simulate."""

import dataclasses
from pathlib import Path
from typing import Annotated, Any

import equinox as eqx
import numpy as np
from cyclopts import Parameter

from ..dynamics import (
    Method,
    Scenario,
    SteadyState,
    Transient,
    choose_method,
    default_scenario,
    simulate as run_transient,
    steady_state,
)
from ..findings import check as run_checks
from ..mechanism import Mechanism, OperatingPoint
from ..quantities import assumptions
from ._app import app
from ._assumed import STEADY, TRANSIENT
from ._common import Common, emit, plain
from ._programs import run_stored
from ._tables import Line, in_units, table

_DEFAULT = Common()


@app.command
def check(file: str, *, common: Common = _DEFAULT) -> int:
    """Does it fit together, and do its numbers make sense? Exit status 1 if one is an error."""
    mechanism = common.load(file)
    findings = run_checks(mechanism)
    rows = [(f.name, f.severity, f.stage, f.message) for f in findings]

    def text() -> str:
        columns = ["name", "severity", "stage", "what"]
        return table("Findings", columns, rows) if rows else "no findings"

    keys = ("name", "severity", "stage", "value", "limit", "message")
    results = {"findings": [{k: getattr(f, k) for k in keys} for f in findings]}
    emit(common, results, text, assumptions(mechanism))
    return int(any(f.severity == "error" for f in findings))


def steady_results(state: SteadyState, point: OperatingPoint | None) -> dict[str, Any]:
    """A steady state by the names of the JSON."""
    results = {
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
        "valid": state.valid,
    }
    if point is not None:
        results |= {"speed_rad_per_s": point.speed, "load_n": point.load}
    return results


def _steady(mechanism: Mechanism) -> dict[str, Any]:
    return steady_results(steady_state(mechanism), mechanism.operating_point)


@app.command
def steady(file: str, *, common: Common = _DEFAULT) -> int:
    """Steady state: efficiency, torque, forces, every loss by name, power balance."""
    mechanism = common.load(file)
    results = plain(run_stored("steady", _steady, mechanism))
    emit(common, results, lambda: _steady_table(file, results), assumptions(mechanism, STEADY))
    return int(not results["valid"])


def _steady_table(file: str, results: dict[str, Any]) -> str:
    lines: list[Line] = [
        ("efficiency", results["efficiency"], "1", "efficiency"),
        ("drive torque", results["drive_torque_nm"], "N·m"),
        ("input power", results["input_power_w"], "W"),
        ("output power", results["output_power_w"], "W"),
        *((f"loss: {name}", power, "W") for name, power in results["losses_w"].items()),
        ("power balance residual", results["power_balance_residual"], "1"),
    ]
    for number, (ratio, force) in enumerate(
        zip(results["carrier_ratio"], results["contact_force_n"], strict=True), start=1
    ):
        lines.append((f"stage {number}: carrier ratio", ratio, "1"))
        lines.append((f"stage {number}: contact force of one roller", force, "N"))
    words = table(f"Steady state: {file}", ("", "", ""), in_units(lines))
    if not results["valid"]:
        words += "not valid: the thread locks, or the meshing has no solution\n"
    return words


def _transient(
    mechanism: Mechanism, method: Method, samples: int | None, rtol: float, atol: float, steps: int
) -> Transient:
    scenario = default_scenario(mechanism)
    if samples is not None:
        scenario = dataclasses.replace(scenario, samples=samples)
    # It is an argument of its own: twice it would be traced twice.
    mechanism = dataclasses.replace(mechanism, scenario=None)
    if method == "auto" and isinstance(scenario, Scenario):
        # Out here, where numbers are known, and not in the compiled program.
        method = choose_method(mechanism, scenario, rtol=rtol).method
    return _simulate(
        mechanism,
        scenario,
        method=method,
        # Nothing is differentiated; the loop of forward mode stops when it is done.
        gradient="forward",
        rtol=rtol,
        atol=atol,
        max_steps=steps,
        throw=False,
    )


_simulate = eqx.filter_jit(run_transient)


def transient_results(run: Transient) -> dict[str, Any]:
    """A transient by the names of the JSON; three more of them where the torque is prescribed."""
    results = {
        "time_s": run.time,
        "screw_speed_rad_per_s": run.screw_speed,
        "load_n": run.load,
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
        "solver": {
            "name": run.solver.name,
            "steps": int(run.solver.steps),
            "rejected": int(run.solver.rejected),
            "result": run.solver.result,
        },
    }
    if run.position is not None:
        results["position_m"] = run.position
    if run.sticking is not None:
        results["sticking"] = run.sticking
    if run.phases is not None:
        results["phases"] = [
            {"start_s": start, "end_s": end, "mode": _MODES[round(mode)]}
            for start, end, mode in zip(
                *(np.asarray(x).tolist() for x in (run.phases.start, run.phases.end)),
                np.asarray(run.phases.mode).tolist(),
                strict=True,
            )
            if end > start
        ]
    return results


_MODES = {1: "forward", -1: "backward", 0: "sticking"}


@app.command
def simulate(
    file: str,
    *,
    method: Annotated[Method, Parameter(help="How carriers are found over time.")] = "auto",
    samples: Annotated[
        int | None, Parameter(help="Number of times in the result; default the file's, or 201.")
    ] = None,
    rtol: Annotated[float, Parameter(help="Relative tolerance of the steps.")] = 1e-8,
    atol: Annotated[float, Parameter(help="Absolute tolerance of the steps.")] = 1e-10,
    max_steps: Annotated[int, Parameter(help="Steps allowed.")] = 4096,
    animation: Annotated[
        bool, Parameter(help="With --out: an animated GIF of the stages in motion.")
    ] = True,
    common: Common = _DEFAULT,
) -> int:
    """Time histories of the file's [scenario]; without one, after a step to the operating point."""
    mechanism = common.load(file)
    run = _transient(mechanism, method, samples, rtol, atol, max_steps)
    results = transient_results(run)
    solver = results["solver"]
    rows: list[tuple[Any, ...]] = [
        ("efficiency", float(run.efficiency[0]), float(run.efficiency[-1])),
        ("drive torque N·m", float(run.drive_torque[0]), float(run.drive_torque[-1])),
    ]
    for number, ratios in enumerate(run.carrier_ratio, start=1):
        rows.append((f"stage {number}: carrier ratio", float(ratios[0]), float(ratios[-1])))
    pictures: tuple[Path, ...] = ()
    if common.out is not None:
        from ..report import save_transient_pictures

        pictures = save_transient_pictures(common.out, mechanism, run, animation=animation)
        results["pictures"] = list(pictures)

    def text() -> str:
        summary = f"{solver['name']}: {solver['steps']} steps, {solver['rejected']} rejected, "
        summary += solver["result"] + (
            f"\n{len(pictures)} pictures in {common.out}" if pictures else ""
        )
        return table(f"Transient: {file}", ["", "start", "end"], rows) + summary

    emit(common, results, text, assumptions(mechanism, TRANSIENT))
    return int(run.solver.code != 0)
