"""The verb contact: thread contacts, stress below them, line contact, shared loads, pictures."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ...contact import (
    HertzContact,
    LineContactResult,
    StageContact,
    line_contact,
    load_of,
    stress_peak_on_axis,
    thread_contacts,
)
from ...fields import Scalar
from ...geometry import Meshing, mesh
from ...load_sharing import LoadDistribution, SideLoads, load_distribution
from ...mechanism import Mechanism, Stage, material_of
from ...quantities import assumptions
from ...strength import SideOnset, side_onsets, truncated_pressure
from .._app import app
from .._common import CONTACT, Common, checked, emit, plain
from .._programs import run_stored
from .._progress import doing
from .._tables import Line, in_units, table

_DEFAULT = Common()


def _stress(hertz: HertzContact, poisson_ratio: Scalar) -> dict[str, Any]:
    peaks = {
        measure: stress_peak_on_axis(
            hertz.semi_major, hertz.semi_minor, hertz.max_pressure, poisson_ratio, measure
        )
        for measure in ("von_mises", "max_shear")
    }
    return {
        "max_von_mises_stress_pa": peaks["von_mises"].value,
        "max_von_mises_depth_m": peaks["von_mises"].depth,
        "max_shear_stress_pa": peaks["max_shear"].value,
        "max_shear_depth_m": peaks["max_shear"].depth,
    }


def contact_results(
    stages: Sequence[Stage], meshings: Sequence[Meshing], contacts: Sequence[StageContact]
) -> dict[str, Any]:
    """Thread contacts by the names of the JSON."""
    results = []
    for stage, meshing, pair in zip(stages, meshings, contacts, strict=True):
        onsets = side_onsets(stage, meshing) or (None, None)
        sides: dict[str, Any] = {"stage": len(results) + 1, "converged": meshing.converged}
        for name, onset in zip(("screw", "nut"), onsets, strict=True):
            where, result = getattr(meshing, name), getattr(pair, name)
            hertz = result.hertz
            sides[name] = {
                "contact_radius_m": where.contact_radius,
                "contact_angle_position_rad": where.contact_angle_position,
                "roller_contact_radius_m": where.roller_contact_radius,
                "roller_angle_position_rad": where.roller_angle_position,
                "normal_force_n": result.normal_force,
                "semi_major_m": hertz.semi_major,
                "semi_minor_m": hertz.semi_minor,
                # As the quantity max_pressure: above Hertz's where a flank's end cuts the ellipse.
                "max_pressure_pa": truncated_pressure(onset, hertz.max_pressure),
                "whole_ellipse_max_pressure_pa": hertz.max_pressure,
                "approach_m": hertz.approach,
                "stiffness_n_per_m": hertz.stiffness,
                "stiffness_tangent_n_per_m": hertz.stiffness_tangent,
                "axial_stiffness_n_per_m": result.axial_stiffness,
                "roller_stiffness_n_per_m": result.roller_stiffness,
                **_stress(hertz, material_of(stage, name).poisson_ratio),
            }
        results.append(sides)
    return {"stages": results}


def line_contact_results(line: LineContactResult) -> dict[str, Any]:
    """A line contact by the names of the JSON."""
    return {
        "converged": line.converged,
        "radius_m": line.slices.radius,
        "line_load_n_per_m": line.line_load,
        "half_width_m": line.half_width,
        "pressure_pa": line.pressure,
        "axial_force_n": line.axial_force,
        "normal_force_n": line.normal_force,
        "approach_m": line.approach,
        "stiffness_tangent_n_per_m": line.stiffness_tangent,
        "max_pressure_pa": line.max_pressure,
        "max_half_width_m": line.max_half_width,
        "loaded_share": line.loaded_share,
        "edge_ratio": line.edge_ratio,
        "parabola_fit": line.parabola_fit,
    }


def load_sharing_results(
    shared: LoadDistribution, onsets: tuple[SideOnset | None, SideOnset | None]
) -> dict[str, Any]:
    """A load distribution by the names of the JSON; one row of loads for each class of rollers."""
    pressures = [
        truncated_pressure(onset, side.max_pressure)
        for onset, side in zip(onsets, (shared.screw, shared.nut), strict=True)
    ]

    def side(loads: SideLoads, pressure: Array) -> dict[str, Any]:
        return {
            "thread_load_n": loads.forward,
            "reverse_thread_load_n": loads.reverse,
            "thread_pressure_pa": pressure,
            "whole_ellipse_thread_pressure_pa": loads.max_pressure,
            "roller_load_n": loads.roller_load,
            "thread_sharing_factor": loads.thread_sharing_factor,
            "roller_sharing_factor": loads.roller_sharing_factor,
            "roller_stiffness_n_per_m": loads.roller_stiffness,
            "class_stiffness_n_per_m": loads.stiffness,
        }

    elastic = shared.elastic
    return {
        "rollers": [list(numbers) for numbers in shared.rollers],
        "converged": shared.converged & elastic.converged,
        "screw": side(shared.screw, pressures[0]),
        "nut": side(shared.nut, pressures[1]),
        # As the quantity max_pressure_shared.
        "max_pressure_pa": jnp.maximum(*(jnp.max(one) for one in pressures)),
        "whole_ellipse_max_pressure_pa": shared.max_pressure,
        "deflection_m": elastic.deflection,
        "unloaded_deflection_m": elastic.unloaded_position,
        "secant_stiffness_n_per_m": elastic.secant_stiffness,
        "tangent_stiffness_n_per_m": shared.tangent_stiffness,
        "spacer_force_n": shared.spacer_force,
        **_across_results(shared),
        **_bent_results(shared),
    }


def _across_results(shared: LoadDistribution) -> dict[str, Any]:
    """Loads across the axis by the names of the JSON, components at 0 and 90 degrees."""
    if shared.nut_radial_force is None:
        return {}
    return {
        "roller_load_unbalance": shared.nut.roller_load_unbalance,
        "nut_radial_force_n": shared.nut_radial_force,
        "nut_overturning_moment_nm": shared.nut_overturning_moment,
        "nut_displacement_m": shared.nut_displacement,
        "nut_lean_rad": shared.nut_lean,
    }


def _bent_results(shared: LoadDistribution) -> dict[str, Any]:
    """How rollers lean and bend, by the names of the JSON, a row per class of rollers."""
    if shared.roller_lean is None or shared.roller_deflection is None:
        return {}
    return {
        "roller_lean_rad": shared.roller_lean,
        "roller_deflection_m": shared.roller_deflection,
    }


def _contacts(mechanism: Mechanism) -> dict[str, Any]:
    meshings = [mesh(stage.thread) for stage in mechanism.stages]
    results = contact_results(mechanism.stages, meshings, thread_contacts(mechanism))
    load = load_of(mechanism, None)
    for number, (stage, meshing, stage_results) in enumerate(
        zip(mechanism.stages, meshings, results["stages"], strict=True), start=1
    ):
        if stage.line_contact is not None:
            stage_results["line_contact"] = line_contact_results(line_contact(stage, load))
        if stage.load_sharing is not None:
            shared = load_distribution(mechanism, load, stage=number)
            onsets = side_onsets(stage, meshing) or (None, None)
            stage_results["load_sharing"] = load_sharing_results(shared, onsets)
    return results


@app.command
def contact(file: str, *, common: Common = _DEFAULT) -> int:
    """Thread contacts under the operating load: position, ellipse, pressure, stress, stiffness.

    With [stage.line_contact] the line contact of rings, with [stage.load_sharing] the loads of
    threads and rollers. --out draws them, and the pressure on the true flanks.
    """
    mechanism = common.load(file)
    results = plain(run_stored("contact", _contacts, mechanism))
    pictures: tuple[Path, ...] = ()
    if common.out is not None:
        from ...report import save_contact_pictures

        doing("solving contacts on the true flanks and drawing them")
        pictures = save_contact_pictures(common.out, mechanism)
        results["pictures"] = [str(path) for path in pictures]

    def text() -> str:
        words = _tables(file, results["stages"])
        return words + (f"\n{len(pictures)} pictures in {common.out}" if pictures else "")

    parts = [
        part
        for stage in results["stages"]
        for part in (stage, stage.get("line_contact"), stage.get("load_sharing"))
        if part is not None
    ]
    results["valid"] = all(part["converged"] for part in parts)
    return int(not emit(common, results, text, assumptions(mechanism, CONTACT), checked(mechanism)))


def _times(value: float | None, factor: float) -> float | None:
    """A number in another unit; `None` stays `None`."""
    return None if value is None else value * factor


#: Columns of the table of contacts: heading, key of the JSON, factor from SI to the unit.
_COLUMNS = (
    ("r mm", "contact_radius_m", 1e3),
    ("φ deg", "contact_angle_position_rad", 180 / math.pi),
    ("F_n N", "normal_force_n", 1.0),
    ("a mm", "semi_major_m", 1e3),
    ("b mm", "semi_minor_m", 1e3),
    ("p₀ MPa", "max_pressure_pa", 1e-6),
    ("δ µm", "approach_m", 1e6),
    ("F/δ N/µm", "stiffness_n_per_m", 1e-6),
)
#: Added where the end of a flank cuts an ellipse: a, b, δ and F/δ belong to the whole ellipse.
_WHOLE = (("p₀ of the whole ellipse MPa", "whole_ellipse_max_pressure_pa", 1e-6),)
_BELOW = (
    ("von Mises MPa", "max_von_mises_stress_pa", 1e-6),
    ("at depth mm", "max_von_mises_depth_m", 1e3),
    ("shear MPa", "max_shear_stress_pa", 1e-6),
    ("at depth mm", "max_shear_depth_m", 1e3),
)


def _tables(file: str, stages: list[dict[str, Any]]) -> str:
    sides = [
        (f"{number} {name}", stage[name])
        for number, stage in enumerate(stages, start=1)
        for name in ("screw", "nut")
    ]

    def of_sides(title: str, columns: Sequence[tuple[str, str, float]]) -> str:
        heads = ("stage side", *(head for head, _, _ in columns))
        rows = [(label, *(_times(side[k], by) for _, k, by in columns)) for label, side in sides]
        return table(title, heads, rows)

    cut = any(s["max_pressure_pa"] != s["whole_ellipse_max_pressure_pa"] for _, s in sides)
    text = of_sides(f"Thread contacts: {file}", _COLUMNS + (_WHOLE if cut else ()))
    text += of_sides("Largest stress below them, without friction", _BELOW)
    totals: list[Line] = []
    for number, stage in enumerate(stages, start=1):
        totals += _lines_of_line(number, stage.get("line_contact"))
        totals += _lines_of_sharing(number, stage.get("load_sharing"))
        if not stage["converged"]:
            text += f"stage {number} is not valid: the meshing has no solution\n"
    return text + (table("As a whole", ("", "", ""), in_units(totals)) if totals else "")


def _lines_of_line(number: int, line: dict[str, Any] | None) -> list[Line]:
    if line is None:
        return []
    lines: list[Line] = [
        ("largest pressure", line["max_pressure_pa"], "Pa"),
        ("largest half-width", line["max_half_width_m"], "m"),
        ("approach", line["approach_m"], "m"),
        ("axial force", line["axial_force_n"], "N"),
        ("share of the flank that carries", line["loaded_share"], "1"),
        ("largest line load over its mean", line["edge_ratio"], "1"),
        ("R² of the parabola", line["parabola_fit"], "1"),
    ]
    return [(f"stage {number}: line contact, {one[0]}", *one[1:]) for one in lines]


def _lines_of_sharing(number: int, shared: dict[str, Any] | None) -> list[Line]:
    if shared is None:
        return []
    # The stiffness goes to 0 with the load; at 0 the result has that of a trace of a load.
    stiffness = shared["tangent_stiffness_n_per_m"] if shared["max_pressure_pa"] != 0 else 0.0
    lines: list[Line] = [
        ("largest over mean thread load, screw", shared["screw"]["thread_sharing_factor"], "1"),
        ("largest over mean thread load, nut", shared["nut"]["thread_sharing_factor"], "1"),
        ("largest over mean roller load", shared["screw"]["roller_sharing_factor"], "1"),
        ("largest pressure", shared["max_pressure_pa"], "Pa"),
        ("deflection", shared["deflection_m"], "m"),
        ("axial stiffness dF/dx", stiffness, "N/m"),
    ]
    pressure = shared["whole_ellipse_max_pressure_pa"]
    if pressure != shared["max_pressure_pa"]:
        lines.insert(4, ("largest pressure of a whole ellipse", pressure, "Pa"))
    if shared["spacer_force_n"] is not None:
        lines.append(("force in the spacer", shared["spacer_force_n"], "N"))
    if "nut_radial_force_n" in shared:
        lines += _lines_across(shared)
    if "roller_lean_rad" in shared:
        lines += _lines_bent(shared)
    return [(f"stage {number}: load sharing, {one[0]}", *one[1:]) for one in lines]


def _lines_bent(shared: dict[str, Any]) -> list[Line]:
    """The largest lean and the largest bending of a roller."""
    lean, bow = (
        float(np.max(np.abs(shared[name]))) for name in ("roller_lean_rad", "roller_deflection_m")
    )
    return [("largest lean of a roller", lean, "rad"), ("largest bending of a roller", bow, "m")]


def _lines_across(shared: dict[str, Any]) -> list[Line]:
    """Lengths of the vectors across the axis, and the unbalance of the rollers."""
    lines: list[Line] = [
        ("standard deviation over mean roller load", shared["roller_load_unbalance"], "1"),
        ("radial force of the rollers on the nut", math.hypot(*shared["nut_radial_force_n"]), "N"),
        (
            "moment of the rollers on the nut",
            math.hypot(*shared["nut_overturning_moment_nm"]),
            "N·m",
        ),
    ]
    if shared["nut_displacement_m"] is not None:
        lines.append(("displacement of the nut", math.hypot(*shared["nut_displacement_m"]), "m"))
        lines.append(("lean of the nut", math.hypot(*shared["nut_lean_rad"]), "rad"))
    return lines
