"""Findings: does the mechanism fit together? Reported by name, never raised."""

from dataclasses import dataclass
from typing import Literal

import jax.numpy as jnp

from ..mechanism import Mechanism, Scalar, Stage, Thread
from ._meshing import mesh

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """One thing an engineer should know about a mechanism.

    `error`: it cannot be built, does not mesh or is no structure; `warning`: it can, but not as
    drawn, or its numbers contradict each other; `note`: for information.
    """

    name: str
    severity: Severity
    stage: int
    value: float
    limit: float
    message: str


def roller_clearance(stage: Stage) -> Scalar:
    """Free gap between neighbouring rollers, 2 a sin(π/N) − 2 r_major [m].

    The major radius is the nominal one where no addendum is given.
    """
    thread = stage.thread
    return 2 * thread.centre_distance * jnp.sin(
        jnp.pi / stage.roller_count
    ) - 2 * roller_major_radius(thread)


def roller_major_radius(thread: Thread) -> Scalar:
    """Outer radius of the roller's thread: nominal plus addendum, if given [m]."""
    if thread.roller_addendum is None:
        return thread.roller_radius
    return thread.roller_radius + thread.roller_addendum


def _whole(value: float) -> bool:
    # Starts derived from measured radii carry their rounding with them.
    return abs(value - round(value)) < 1e-6


def _check_ratio(stage: Stage, number: int) -> Finding | None:
    starts = float(stage.thread.starts)
    if _whole(starts) and starts > 2:
        return None
    return Finding(
        "feasible_ratio",
        "error",
        number,
        starts,
        float(max(3, round(starts))),
        f"the ratio of nut to roller radius, and with it the number of thread starts, is "
        f"{starts:.6g}; it must be a whole number of at least 3 (nearest: "
        f"{max(3, round(starts))})",
    )


def _check_clearance(stage: Stage, number: int) -> Finding | None:
    clearance = float(roller_clearance(stage))
    if clearance > 0:
        return None
    return Finding(
        "roller_clearance",
        "error",
        number,
        clearance,
        0.0,
        f"{stage.roller_count} neighbouring rollers overlap by {-clearance * 1e3:.4g} mm; use "
        "fewer or smaller rollers",
    )


def _check_gear(stage: Stage, number: int) -> Finding | None:
    """The thread fixes how a roller turns from one place to the next; the teeth must agree.

    Rolled from one place to the next, by 2π/N about the axis, a roller turns by 2π n/N against
    the carrier, which is z_R n/N of its teeth; the ring gear offers z_r/N teeth there. Rollers
    cut alike fit everywhere if z_r = n z_R, which holds by construction, and both are whole.
    """
    gear = stage.gear
    if gear is None or gear.roller_teeth is None:
        return None
    roller, ring = float(gear.roller_teeth), float(gear.roller_teeth * stage.thread.starts)
    if not (_whole(roller) and _whole(ring)):
        return Finding(
            "gear_assembly",
            "error",
            number,
            ring,
            float(round(ring)),
            f"the ring gear would have n z_R = {ring:.6g} teeth on {roller:.6g} roller teeth; "
            "both must be whole numbers",
        )
    step = round(ring) % stage.roller_count
    if step == 0:
        return None
    return Finding(
        "gear_assembly",
        "note",
        number,
        ring / stage.roller_count,
        float(round(ring / stage.roller_count)),
        f"{round(ring)} ring gear teeth are not divisible by {stage.roller_count} rollers: each "
        f"roller must be mounted turned by {step}/{stage.roller_count} of a tooth against the "
        "one before, with thread and gear of all rollers cut in the same phase",
    )


def _check_carrier(stage: Stage, number: int) -> Finding | None:
    """The carrier's annulus, centred on the roller axes, must pass between screw and nut."""
    carrier, thread = stage.carrier, stage.thread
    if carrier is None or carrier.radial_width is None:
        return None
    addendum = 0.0 if thread.screw_addendum is None else thread.screw_addendum
    inner = thread.centre_distance - carrier.radial_width / 2
    gap = float(inner - thread.screw_radius - addendum)
    if gap > 0:
        return None
    return Finding(
        "carrier_clearance",
        "error",
        number,
        gap,
        0.0,
        f"the carrier, {float(carrier.radial_width) * 1e3:.4g} mm wide, cuts {-gap * 1e3:.4g} mm "
        "into the screw's thread; make it narrower",
    )


def _check_meshing(stage: Stage, number: int) -> list[Finding]:
    meshing, thread = mesh(stage.thread), stage.thread
    if not bool(meshing.converged):
        return [
            Finding(
                "meshing",
                "error",
                number,
                float(thread.profile_radius),
                float(thread.roller_radius / jnp.sin(thread.flank_angle)),
                "screw and roller flanks do not touch in a point; the roller's profile radius "
                f"{float(thread.profile_radius) * 1e3:.4g} mm is too large (the profile too flat) "
                "for this lead and contact angle",
            )
        ]
    found = []
    limits = (
        ("screw", meshing.screw.contact_radius, thread.screw_radius, thread.screw_addendum),
        (
            "roller",
            meshing.screw.roller_contact_radius,
            thread.roller_radius,
            thread.roller_addendum,
        ),
    )
    for body, radius, nominal, addendum in limits:
        if addendum is not None and radius > nominal + addendum:
            found.append(
                Finding(
                    "contact_on_flank",
                    "warning",
                    number,
                    float(radius),
                    float(nominal + addendum),
                    f"the contact radius {float(radius) * 1e3:.4g} mm lies outside the {body}'s "
                    f"thread, which ends at {float(nominal + addendum) * 1e3:.4g} mm; raise the "
                    "addendum or lower the lead",
                )
            )
    gap = float(meshing.axial_gap)
    if gap < 0:
        found.append(
            Finding(
                "tooth_thickness",
                "note",
                number,
                gap,
                0.0,
                f"teeth of half a pitch would interfere by {-gap * 1e3:.4g} mm per flank; "
                "thin the teeth by at least that",
            )
        )
    return found


def geometric_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Kinematic and geometric checks of a mechanism, as named findings.

    Names: `feasible_ratio`, `roller_clearance`, `gear_assembly`, `carrier_clearance`, `meshing`,
    `contact_on_flank`, `tooth_thickness`. Nothing is raised.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    """
    findings: list[Finding] = []
    for number, stage in enumerate(mechanism.stages, start=1):
        single = (_check_ratio, _check_clearance, _check_gear, _check_carrier)
        findings += [f for f in (c(stage, number) for c in single) if f is not None]
        findings += _check_meshing(stage, number)
    return tuple(findings)
