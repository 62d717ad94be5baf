"""A study of drivers as a report."""

import re
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ...mechanism import find_parameters
from ...studies import DriverStudy
from ...text import MINUS, NOT_DEFINED, TextTable, number
from ..results import Origin
from ..study_charts import (
    conflict_maps,
    front_gradient_chart,
    study_maps,
    variant_changes,
    variant_fronts,
)
from ._foundations import provenance_of
from ._mechanism_section import speed_and_load
from ._section import Picture, Section, Table
from ._write import write_document


def study_sections(
    study: DriverStudy, command: str = "", *, source: str = "", origin: Origin | None = None
) -> tuple[Section, ...]:
    """A study as sections of a document, in the order of reading.

    **Arguments:**

    - `study`: result of `prsm_jax.study`.
    - `command`: how it was made, if by a command.
    - `source`: what was given to `prsm_jax.load`, if the mechanism came from there.
    - `origin`: the file of the mechanism, and author, revision and date.
    """
    said = study.sentences()
    tables = {part: tuple(map(_table, some)) for part, some in study.tables().items()}
    pictures = _pictures(study)
    gradients = Table(
        "Changes by the gradient at each point",
        ("design", "change of the quantities, active limits, and exchange rate of the objectives"),
        tuple((str(i), one.sentence) for i, one in enumerate(study.gradients, start=1)),
    )
    summary = (
        said["drivers"][-1],
        *said["conflict"][:1],
        *said["front"][:1],
        *said["variants"],
    )
    front_tables = (*tables["front"], *((gradients,) if study.gradients else ()))
    follows = tuple(f"{one.follows}." for one in study.problem.drivers if one.follows)
    sections = [
        Section("summary", "In short", summary),
        Section(
            "drivers",
            "Drivers and quantities",
            (*said["drivers"], *follows),
            (*_operating_point(study), *tables["drivers"]),
            pictures["drivers"],
            study.assumptions,
        ),
        Section(
            "conflict",
            "Conflicts",
            (
                "The cosine is that of the angle between the elasticities of two quantities, each "
                "with the sign of its sense. At +1 one change of the drivers is the best for both; "
                "below 0 a step along the gradient of one worsens the other. A limited quantity "
                "has the sense that moves it away from its limit.",
                *said["conflict"],
            ),
            tables["conflict"],
            pictures["conflict"],
        ),
        Section("front", "Front", tuple(said["front"]), front_tables, pictures["front"]),
    ]
    if study.variants:
        words = tuple(said["variants"])
        sections.append(
            Section(
                "variants",
                "Physics left out",
                words,
                tables["variants"],
                pictures["variants"],
            )
        )
    made = provenance_of(study.front.mechanism, origin or Origin(), source, command)
    return (*sections, made)


def write_study(
    directory: str | Path,
    study: DriverStudy,
    *,
    command: str = "",
    source: str = "",
    origin: Origin | None = None,
    attachments: Mapping[str, str] | None = None,
    dpi: int = 200,
    on_fault: Callable[[str], None] = warnings.warn,
) -> Path:
    """Write the report on a study into a directory, as `write_document` does.

    **Arguments:**

    - `directory`: where to write; made if it is not there.
    - `study`, `command`, `source`, `origin`: as for `study_sections`.
    - `attachments`, `dpi`, `on_fault`: as for `write_document`.

    **Returns:** the path of `report.html`.

    **Raises:** as `write_document`.
    """
    return write_document(
        directory,
        study.title or "Study",
        "study of design drivers",
        lambda: study_sections(study, command, source=source, origin=origin),
        attachments=attachments,
        dpi=dpi,
        on_fault=on_fault,
    )


def _operating_point(study: DriverStudy) -> tuple[Table, ...]:
    """Speed and load of all designs, but for one that is a driver."""
    mechanism = study.front.mechanism
    drivers = [one.name for one in study.problem.drivers]
    varied = {one.path for name in drivers for one in find_parameters(mechanism, name)}
    rows = tuple(
        (words, "a driver" if path in varied else value)
        for (words, value), path in speed_and_load(mechanism)
    )
    return (Table("Operating point", ("", ""), rows),) if rows else ()


def _cell(value: Any) -> str:
    if value is None or value != value:
        return NOT_DEFINED
    if isinstance(value, float):
        return number(value)
    text = str(value)
    return text.replace("-", MINUS, 1) if text[:1] == "-" else text


def _heading(text: str) -> str:
    """A name with its unit as reports write it: "lead in mm"."""
    return re.sub(r" \[(.+)\]$", r" in \1", text)


def _table(table: TextTable) -> Table:
    rows = tuple((_heading(_cell(row[0])), *map(_cell, row[1:])) for row in table.rows)
    return Table(table.title, tuple(map(_heading, table.columns)), rows)


def _pictures(study: DriverStudy) -> dict[str, tuple[Picture, ...]]:
    """Pictures of each part that there are data for."""
    found: dict[str, list[Picture]] = {"drivers": [], "conflict": [], "front": [], "variants": []}

    def add(part: str, name: str, caption: str, draw: Callable[[], Any]) -> None:
        found[part].append(Picture(name, caption, draw))

    if len(study.problem.drivers) > 1:
        add(
            "drivers",
            "map",
            "Quantities over every two drivers, the others nearest to their present values. Dots: "
            "designs that break a limit or have an error. The front is projected: its points have "
            "other values of the third driver. Values beyond a pointed end of a colour scale have "
            "its last colour.",
            lambda: study_maps(study),
        )
        add(
            "conflict",
            "conflict",
            "Cosine of the angle between the elasticities of two quantities: below 0 they "
            "conflict.",
            lambda: conflict_maps(study),
        )
        if study.problem.limited:
            add(
                "conflict",
                "conflict_limits",
                "The same for each objective and each limited quantity.",
                lambda: conflict_maps(study, limits=True),
            )
    if study.front.points:
        add(
            "front",
            "front",
            "The front, and by the gradient the change of both objectives if one driver alone "
            "grows.",
            lambda: front_gradient_chart(study),
        )
    if any(one.changes for one in study.variants):
        add(
            "variants",
            "changes",
            "Change of each quantity without a part of the physics.",
            lambda: variant_changes(study),
        )
    if any(one.front is not None and one.front.points for one in study.variants):
        add(
            "variants",
            "fronts",
            "Fronts found without a part of the physics, and their designs with complete physics.",
            lambda: variant_fronts(study),
        )
    return {part: tuple(some) for part, some in found.items()}
