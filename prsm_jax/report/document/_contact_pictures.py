"""All pictures of the contacts of one mechanism, written into a folder."""

from pathlib import Path

import jax.numpy as jnp

from ...contact import contact_modulus, line_contact, load_of, thread_contacts
from ...friction import Sliding
from ...halfspace import FlankContact, flank_contact, ring_contact
from ...mechanism import Mechanism, Stage, material_of
from ...programs import one_program_where_possible
from ...strength import side_onsets
from ...text import short_label
from .._style import Figure, save_figures
from ..contact_charts import (
    contact_ellipses,
    flank_lines,
    force_deflection_chart,
    line_contact_chart,
    pressure_map,
    pressure_profiles,
    roller_force_chart,
    shared_loads,
    subsurface_chart,
    thread_load_chart,
)
from ..results import truncated_pressures, untruncated_pressures

_SIDES = ("screw", "nut")
#: Friction coefficient for the stress below contacts if the thread has no Coulomb friction.
_USUAL_FRICTION = 0.1

_flank_contact = one_program_where_possible(flank_contact)
_line = one_program_where_possible(line_contact)
_ring_contact = one_program_where_possible(ring_contact)
_side_onsets = one_program_where_possible(side_onsets)


def _friction(stage: Stage) -> float:
    law = stage.thread_law
    if law is None or not law.constant:
        return _USUAL_FRICTION
    return float(law.friction_coefficient(Sliding(jnp.ones(()))))


def _true_flanks(stage: Stage, load, cells: int) -> dict[str, FlankContact]:
    contacts = {}
    for side in _SIDES:
        contact = _flank_contact(stage, side, load, (cells, cells))
        # Nothing to draw: no load, or a flank outside the grid.
        if int(contact.surface.code) == 0:
            contacts[f"{side} side"] = contact
    return contacts


def _line_contact(stage: Stage, load) -> Figure:
    assert stage.line_contact is not None
    line = _line(stage, load)
    modulus = contact_modulus(material_of(stage, "screw"), material_of(stage, "roller"))
    surface = _ring_contact(stage.line_contact, line.axial_force, modulus, slices=line)
    # A surface without a solution is not drawn.
    return line_contact_chart(
        stage.line_contact, line, surface if bool(surface.converged) else None
    )


def contact_pictures(
    mechanism: Mechanism, load: float | None = None, *, cells: int = 128
) -> dict[str, Figure]:
    """Draw the contacts of every stage under an axial load.

    For each stage: `contact-ellipses`; `pressure-map` and `pressure-profiles` on the true flanks;
    `stress-screw` and `stress-nut` below the surfaces; `line-contact` of rings;
    `thread-loads` and `force-deflection` if the stage models load sharing, and `roller-forces` if
    it has errors of parts or a free nut.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `load`: axial load [N]; default that of the operating point.
    - `cells`: cells along each axis of the grid on the true flanks.

    **Returns:** figures by name; with several stages the names end with the stage's number.

    **Raises:** `MissingDataError` if materials, engaged threads or the load are not given;
    `MissingExtraError` without matplotlib.
    """
    shared = load_of(mechanism, load)
    figures: dict[str, Figure] = {}
    for number, (stage, pair) in enumerate(
        zip(mechanism.stages, thread_contacts(mechanism, shared), strict=True), start=1
    ):
        suffix = f"-stage-{number}" if len(mechanism.stages) > 1 else ""
        label = short_label(mechanism.title) or "thread contact"
        pressures = truncated_pressures(_side_onsets(stage), untruncated_pressures(pair))
        figures["contact-ellipses" + suffix] = contact_ellipses(
            {label: pair}, {label: pressures}, {label: flank_lines(stage, jnp.abs(shared))}
        )
        flank_contacts = _true_flanks(stage, shared, cells)
        if flank_contacts:
            figures["pressure-map" + suffix] = pressure_map(flank_contacts)
            figures["pressure-profiles" + suffix] = pressure_profiles(flank_contacts)
        for side in _SIDES:
            hertz = getattr(pair, side).hertz
            if float(hertz.max_pressure) > 0:
                ratio = material_of(stage, side).poisson_ratio
                figures[f"stress-{side}{suffix}"] = subsurface_chart(hertz, ratio, _friction(stage))
        if stage.line_contact is not None:
            figures["line-contact" + suffix] = _line_contact(stage, shared)
        if stage.load_sharing is not None:
            distribution, curve = shared_loads(mechanism, shared, number)
            figures["thread-loads" + suffix] = thread_load_chart(distribution)
            if distribution.roller_angle is not None:
                figures["roller-forces" + suffix] = roller_force_chart(distribution)
            figures["force-deflection" + suffix] = force_deflection_chart({label: curve})
    return figures


def save_contact_pictures(
    folder: str | Path, mechanism: Mechanism, load: float | None = None, *, cells: int = 128
) -> tuple[Path, ...]:
    """Write every picture of the contacts, as PNG and SVG.

    **Arguments:**

    - `folder`: where to write; made if it is not there.
    - `mechanism`, `load`, `cells`: as in `contact_pictures`.

    **Returns:** the paths written.

    **Raises:** as `contact_pictures`.
    """
    # Everything that can fail runs before the folder is made.
    return save_figures(folder, contact_pictures(mechanism, load, cells=cells))
