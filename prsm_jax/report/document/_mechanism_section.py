"""The mechanism, its operating point, and the findings of the checks."""

import math
from collections.abc import Iterator

from ..._errors import MissingDataError
from ...geometry import roller_clearance
from ...mechanism import Mechanism, Stage, body_mass, stage_mass
from ...text import show, trimmed, with_label
from ..drawings import cross_section
from ..results import ReportData
from ._section import Picture, Section, Table


def mechanism_section(data: ReportData) -> Section:
    """The mechanism and its operating point."""
    stages = data.mechanism.stages
    columns = [dict(stage_rows(stage)) for stage in stages]
    names = list(dict.fromkeys(name for column in columns for name in column))
    rows = tuple((name, *(column.get(name, "not given") for column in columns)) for name in names)
    head = ("", *(f"stage {i}" for i in range(1, len(stages) + 1))) if len(stages) > 1 else ("", "")
    tables = [Table("Mechanism", head, rows)]
    point = data.mechanism.operating_point
    if point is not None:
        operating = [row for row, _ in speed_and_load(data.mechanism)]
        if point.duration is not None:
            operating.append(("simulated time", show(float(point.duration), "s", digits=3)))
        tables.append(Table("Operating point", ("", ""), tuple(operating)))
    pictures = []
    for i in range(len(stages)):
        suffix, words = data.of_stage(i)
        what = f"Stage {i + 1}" if words else "The mechanism"
        pictures.append(
            Picture(
                f"cross_section{suffix}",
                f"{what} to scale: across and along its axis, and its threads.",
                lambda i=i, label=data.label + words: cross_section(
                    {label: data.mechanism}, stage=i + 1
                ),
            )
        )
    return Section("mechanism", "Mechanism", (), tuple(tables), tuple(pictures))


def speed_and_load(mechanism: Mechanism) -> Iterator[tuple[tuple[str, str], str]]:
    """Speed and load of the operating point, if there is one: words, value, and full name."""
    point = mechanism.operating_point
    if point is not None:
        turning = mechanism.stages[0].thread.family.turning
        yield (f"{turning} speed", show(float(point.speed), "rad/s")), "operating_point.speed"
        yield ("axial load", show(float(point.load), "N")), "operating_point.load"


def findings_section(data: ReportData) -> Section:
    """Findings of the checks, for the design and for the optimised one."""
    designs = {name: one.findings for name, one in data.designs.items()}
    many = len(data.mechanism.stages) > 1
    head = ("severity", *(("stage",) if many else ()), "check", "message")
    words, tables = [], []
    for name, findings in designs.items():
        if findings is None:
            words.append(f"{name.capitalize()}: the checks could not be made.".removeprefix(": "))
            continue
        if not findings:
            found = "the checks found no errors, warnings or notes."
            words.append(f"{name.capitalize()}: {found}" if name else found.capitalize())
            continue
        rows = tuple(
            (f.severity, *((str(f.stage),) if many else ()), f.name.replace("_", " "), f.message)
            for f in findings
        )
        tables.append(Table(f"Findings: {name}" if name else "Findings", head, rows))
    return Section("findings", "Findings", tuple(words), tuple(tables))


def stage_rows(stage: Stage) -> Iterator[tuple[str, str]]:
    """Name and value with its unit of everything that describes a stage."""
    thread = stage.thread

    def length(value) -> str:
        return with_label(trimmed(1e3 * float(value)), "mm", " ")

    def angle(value) -> str:
        return with_label(trimmed(math.degrees(float(value)), 2), "°", "")

    if stage.type != "standard":
        yield "type", f"{stage.type}: {thread.family.radii}; travel per turn {thread.family.travel}"
        yield "body that turns", thread.family.turning
    present, positions = stage.present_roller_count, stage.roller_count
    yield "rollers", str(present) if present == positions else f"{present} in {positions} places"
    yield "thread starts of screw and nut", trimmed(float(thread.starts))
    yield "lead", length(thread.lead)
    yield "pitch", length(thread.pitch)
    yield "screw diameter", length(2 * thread.screw_radius)
    yield "roller diameter", length(2 * thread.roller_radius)
    yield "nut thread diameter", length(2 * thread.nut_radius)
    if stage.nut.wall_thickness is not None:
        yield "nut outer diameter", length(2 * (thread.nut_radius + stage.nut.wall_thickness))
    yield "centre distance", length(thread.centre_distance)
    yield "contact angle (from the transverse plane)", angle(thread.contact_angle)
    yield "flank angle", angle(thread.flank_angle)
    yield "roller profile radius", length(thread.profile_radius)
    yield "helix angle of the screw", angle(thread.screw_helix_angle)
    yield "clearance between rollers", length(roller_clearance(stage))
    for body, label in (("screw", "screw"), ("roller", "roller"), ("nut", "nut")):
        value = getattr(stage, body).length
        if value is not None:
            yield f"length of the {label}", length(value)
    if stage.engaged_threads is not None:
        yield "loaded threads of a roller, each side", trimmed(float(stage.engaged_threads))
    if stage.material is not None:
        modulus = float(stage.material.youngs_modulus) * 1e-9
        yield "Young's modulus", with_label(trimmed(modulus), "GPa", " ")
        yield "Poisson's ratio", trimmed(float(stage.material.poisson_ratio))
    yield "curvatures of the contact", stage.curvature
    try:
        roller, total = float(body_mass(stage, "roller")), float(stage_mass(stage))
    except MissingDataError:
        return
    yield "mass of a roller", show(roller, "kg", digits=3)
    yield "mass of the stage", show(total, "kg")
