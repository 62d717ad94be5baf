"""The verb simulate: time histories of a mission, and its demands on motor and mechanism."""

import dataclasses
import math
from pathlib import Path
from typing import Annotated, Any

import jax.numpy as jnp
import numpy as np
from cyclopts import Parameter

from ...dynamics import (
    MethodName,
    Transient,
    coarse_samples,
    default_scenario,
    energy,
    error_in_words,
    integral,
    known_efficiency,
    mean_efficiency,
    neglected_inertia,
    simulate as run_transient,
)
from ...mechanism import Mechanism
from ...programs import one_program_where_possible
from ...quantities import assumptions
from .._app import app
from .._common import TRANSIENT, Common, checked, emit
from .._counts import MOST_VALUES, count
from .._progress import doing, expect_programs
from .._tables import Line, in_units, prose, table

_DEFAULT = Common()
#: Share of all energy that flows below which a direction counts as absent: rounding.
_NOTHING = 1e-6


def _transient(
    mechanism: Mechanism,
    method: MethodName,
    samples: int | None,
    rtol: float | None,
    atol: float | None,
    steps: int | None,
) -> Transient:
    scenario = default_scenario(mechanism)
    if samples is not None:
        scenario = dataclasses.replace(scenario, samples=samples)
    return run_transient(
        mechanism,
        scenario,
        method=method,
        rtol=rtol,
        atol=atol,
        max_steps=steps,
        throw=False,
    )


def transient_results(run: Transient) -> dict[str, Any]:
    """A transient by the names of the JSON; three more if the torque is prescribed."""
    results = {
        "summary": _summary(run),
        "time_s": run.time,
        "screw_speed_rad_per_s": run.screw_speed,
        "load_n": run.load,
        "carrier_ratio": run.carrier_ratio,
        "carrier_speed_rad_per_s": run.carrier_speed,
        "efficiency": known_efficiency(run),
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
            "error_estimate": _number_or_none(run.solver.error_estimate),
            "error_time_s": _error_time(run),
            "time_constant_s": _number_or_none(run.solver.time_constant),
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


def _error_time(run: Transient) -> float | None:
    """Time of the largest estimated error [s]; `None` where no sample has one above 0."""
    history = run.solver.error_over_time
    if history is None or not np.any(np.asarray(history) > 0):
        return None
    return float(run.time[int(np.argmax(np.asarray(history)))])


def _number_or_none(value: Any) -> float | None:
    """A number for the JSON; `None` where the method has none."""
    return None if value is None else float(value)


_MODES = {1: "forward", -1: "backward", 0: "sticking"}


@one_program_where_possible
def _numbers(run: Transient) -> dict[str, Any]:
    drive_power = run.drive_torque * run.screw_speed
    mean_square = integral(run.time, run.drive_torque**2) / (run.time[-1] - run.time[0])
    known = run.load_power is not None
    return {
        "peak_drive_torque_nm": jnp.max(jnp.abs(run.drive_torque)),
        "rms_drive_torque_nm": jnp.sqrt(jnp.maximum(mean_square, 0.0)),
        "peak_drive_power_w": jnp.max(jnp.abs(drive_power)),
        "peak_screw_speed_rad_per_s": jnp.max(jnp.abs(run.screw_speed)),
        "peak_contact_force_n": jnp.max(jnp.abs(run.contact_force)),
        "drive_energy_j": energy(run, "drive"),
        "load_energy_j": energy(run, "load") if known else None,
        "loss_energy_j": energy(run, "loss"),
        "mission_efficiency": mean_efficiency(run) if known else None,
        "energy_from_drive_j": energy(run, "from_drive"),
        "energy_to_drive_j": energy(run, "to_drive"),
        "energy_to_load_j": energy(run, "to_load") if known else None,
        "energy_from_load_j": energy(run, "from_load") if known else None,
    }


def _summary(run: Transient) -> dict[str, Any]:
    """Demands of a mission on motor and mechanism; peaks are those of the samples."""
    return {"duration_s": run.time[-1] - run.time[0], **_numbers(run)}


def _takes_power(run: Transient) -> np.ndarray:
    """Whether power goes in at each time, from the drive or from the load."""
    load_power = 0.0 if run.load_power is None else np.asarray(run.load_power)
    return (np.asarray(run.drive_torque * run.screw_speed) > 0) | (load_power < 0)


def _mission(run: Transient, summary: dict[str, Any], turning: str) -> list[Line]:
    # Without input work its ratio to the output is 0/0.
    efficiency = summary["mission_efficiency"] if _takes_power(run).any() else None
    return [
        ("duration", summary["duration_s"], "s"),
        ("peak drive torque", summary["peak_drive_torque_nm"], "N·m"),
        ("RMS drive torque", summary["rms_drive_torque_nm"], "N·m"),
        ("peak drive power", summary["peak_drive_power_w"], "W"),
        (f"peak {turning} speed", summary["peak_screw_speed_rad_per_s"], "rad/s"),
        ("largest contact force", summary["peak_contact_force_n"], "N"),
        *_energies(summary),
        ("energy lost", summary["loss_energy_j"], "J"),
        ("efficiency over the mission", efficiency, "1", "efficiency"),
    ]


def _both_ways(summary: dict[str, Any], end: str) -> bool:
    """Whether energy flows in both directions at an end, more than rounding."""
    ways = [summary[f"energy_{way}_{end}_j"] for way in ("from", "to")]
    total = sum(
        float(summary[f"energy_{way}_{at}_j"] or 0.0)
        for way in ("from", "to")
        for at in ("drive", "load")
    )
    return all(one is not None and float(one) > _NOTHING * total for one in ways)


#: By end: what flows in each direction and what remains, with their keys; and the net energy
#: where all of it flows in one direction.
_ENERGIES = {
    "drive": (
        ("energy supplied by the drive", "energy_from_drive_j"),
        ("energy taken back by the drive", "energy_to_drive_j"),
        ("net energy from the drive", "drive_energy_j"),
        "energy from the drive",
    ),
    "load": (
        ("energy taken by the load", "energy_to_load_j"),
        ("energy given back by the load", "energy_from_load_j"),
        ("net energy to the load", "load_energy_j"),
        "energy to the load",
    ),
}


def _energies(summary: dict[str, Any]) -> list[Line]:
    """Energies at drive and load: one line where they flow in one direction, or their parts."""
    rows: list[Line] = []
    for end, (*parts, alone) in _ENERGIES.items():
        shown = parts if _both_ways(summary, end) else [(alone, parts[-1][1])]
        rows += [(words, summary[key], "J") for words, key in shown]
    return rows


def _efficiency_in_words(summary: dict[str, Any]) -> str:
    """Definition of the efficiency with its numbers; empty where energy flows in one direction."""
    back, load_back = _both_ways(summary, "drive"), _both_ways(summary, "load")
    if not (back or load_back) or summary["mission_efficiency"] is None:
        return ""
    from_drive, to_drive, to_load, from_load = (
        f"{float(summary[f'energy_{name}_j']):.6g}"
        for name in ("from_drive", "to_drive", "to_load", "from_load")
    )
    words = (
        "Efficiency over the mission: energy put out over energy put in, both directions counted: "
        f"({to_load} + {to_drive}) / ({from_drive} + {from_load})."
    )
    if back:
        words += f" A drive that cannot take energy back has to supply {from_drive} J."
    return words


@app.command
def simulate(
    file: str,
    *,
    method: Annotated[
        MethodName, Parameter(help="Method for the motion of the carriers over time.")
    ] = "auto",
    samples: Annotated[
        int | None,
        count(2, MOST_VALUES, help="Number of points in time; default the file's, or 201."),
    ] = None,
    rtol: Annotated[
        float | None,
        Parameter(help="Relative tolerance of the steps, if the method takes one; default 1e-8."),
    ] = None,
    atol: Annotated[
        float | None, Parameter(help="Absolute tolerance of the steps; default 1e-10.")
    ] = None,
    max_steps: Annotated[
        int | None, count(1, 2**31 - 1, help="Largest number of steps; default 4096.")
    ] = None,
    animation: Annotated[
        bool, Parameter(help="With --out: an animated GIF of the stages in motion.")
    ] = True,
    common: Common = _DEFAULT,
) -> int:
    """Time histories of the file's [scenario]; without one, after a step to the operating point.

    The step needs a duration of the operating point.
    """
    mechanism = common.load(file)
    expect_programs("_transient", "_numbers")
    run = _transient(mechanism, method, samples, rtol, atol, max_steps)
    results = transient_results(run)
    turning = mechanism.stages[0].thread.family.turning
    pictures: tuple[Path, ...] = ()
    if common.out is not None:
        from ...report import save_transient_pictures

        doing("drawing")
        pictures = save_transient_pictures(common.out, mechanism, run, animation=animation)
        results["pictures"] = list(pictures)

    def text() -> str:
        mission = in_units(_mission(run, results["summary"], turning))
        words = table(f"Transient: {file}", ("", "", ""), mission)
        if _moves_at_an_end(run):
            words += table("", ("", "start", "end"), _ends(run))
        words += prose(_efficiency_in_words(results["summary"]))
        words += prose(_solver(results["solver"], error_in_words(run, turning)))
        if run.sticking is None and not np.any(np.asarray(run.screw_speed)):
            words += prose(
                f"The {turning} stands still: torques are those that hold the load without thread "
                "friction; prsm steady gives those of the motion that is about to begin."
            )
        return words + (f"{len(pictures)} pictures in {common.out}" if pictures else "")

    results["valid"] = bool(run.solver.code == 0)
    own = (*neglected_inertia(run, mechanism), *coarse_samples(run))
    rests_on = (*assumptions(mechanism, TRANSIENT), *own)
    return int(not emit(common, results, text, rests_on, checked(mechanism)))


def _moves_at_an_end(run: Transient) -> bool:
    """Whether it moves at start or end; a mission stands still at both, up to rounding."""
    speed = np.abs(np.asarray(run.screw_speed))
    return bool(speed[[0, -1]].max() > 1e-9 * speed.max())


def _ends(run: Transient) -> list[tuple[str, float | None, float | None]]:
    efficiency = known_efficiency(run)
    speed, carriers = np.asarray(run.screw_speed), np.asarray(run.carrier_speed)
    ends = (0, -1)
    first, last = (None if np.isnan(efficiency[k]) else 100 * float(efficiency[k]) for k in ends)
    rows: list[tuple[str, float | None, float | None]] = [
        ("efficiency %", first, last),
        ("drive torque N·m", float(run.drive_torque[0]), float(run.drive_torque[-1])),
    ]
    for number, (ratios, turning) in enumerate(
        zip(np.asarray(run.carrier_ratio), carriers, strict=True), start=1
    ):
        coasts = [speed[k] == 0 and turning[k] != 0 for k in ends]
        first, last = (None if coasts[k] else float(ratios[k]) for k in ends)
        rows.append((f"stage {number}: carrier ratio", first, last))
        if any(coasts):
            first, last = (float(turning[k]) * 30 / math.pi for k in ends)
            rows.append((f"stage {number}: carrier speed rpm", first, last))
    return rows


def _solver(solver: dict[str, Any], error: str | None) -> str:
    """Summary of the integration; a closed form has no steps."""
    words = solver["name"]
    if solver["steps"]:
        words += f": {solver['steps']} steps, {solver['rejected']} rejected"
    words = f"{words}, {solver['result']}"
    return words if error is None else f"{words}; {error}"
