"""Findings, and whether the parts of a stage fit: gaps and ranges as numbers."""

from dataclasses import dataclass
from typing import Literal

import jax.numpy as jnp
from jaxtyping import Array, Bool

from ..fields import Scalar
from ..mechanism import Axis, Stage, Thread, numbers_possible
from ..numerics import below_or_nan

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """One result of a check of a mechanism.

    `error`: the mechanism cannot exist, cannot be assembled as drawn, or fails under its load;
    `warning`: it may fail or wear early, or its numbers contradict each other; `note`: for
    information.
    """

    name: str
    severity: Severity
    stage: int
    value: float
    limit: float
    message: str
    #: Whether the mechanism cannot exist, or cannot be assembled as drawn.
    impossible: bool = False


def roller_clearance(stage: Stage) -> Scalar:
    """Free gap between neighbouring rollers, 2 a sin(π/N) − 2 r_major [m].

    Without an addendum the major radius is the nominal radius.
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


def carrier_clearance(stage: Stage) -> Scalar:
    """Radial gap between the carrier's annulus, centred on the roller axes, and the screw [m].

    Without an addendum the screw ends at its nominal radius; without a radial width of the carrier,
    width 0 is used.
    """
    thread, carrier = stage.thread, stage.carrier
    gap = thread.centre_distance - thread.screw_radius
    if carrier is not None and carrier.radial_width is not None:
        gap = gap - carrier.radial_width / 2
    return gap if thread.screw_addendum is None else gap - thread.screw_addendum


def dimension_names(thread: Thread) -> tuple[str, ...]:
    """Names of the numbers that `dimension_margins` gives; nothing is traced."""
    optional = ("radius_ratio", "roller_profile_radius")
    last = tuple(name for name in optional if getattr(thread, name) is not None)
    return ("lead", "starts", "roller_radius", "contact_angle", *last)


def _starts_margin(thread: Thread) -> Scalar:
    """Margin of the number of starts within the range of its type of roller screw.

    Ends that are allowed are half a start away: that the number is whole is checked by itself.
    """
    limit = thread.starts_limit
    if not limit.lower_allowed:
        return thread.starts - limit.lower
    return jnp.minimum(thread.starts - limit.lower, limit.upper - thread.starts) + 0.5


def dimension_margins(thread: Thread) -> dict[str, Scalar]:
    """Margin of each number of the thread within its physical range, by name; 0 at the end.

    Lead and radii are above 0, starts above 2 (the screw's radius is (n − 2) r_R) where they
    determine the radii, and the contact angle lies between 0 and π/2. These are the limits that
    apply to files, here for numbers that are set in Python or traced.
    """
    angle = thread.contact_angle
    margins = {
        "lead": thread.lead,
        "starts": _starts_margin(thread),
        "roller_radius": thread.roller_radius,
        "contact_angle": jnp.minimum(angle, jnp.pi / 2 - angle),
    }
    if thread.radius_ratio is not None:
        margins["radius_ratio"] = thread.radius_ratio - 2
    if thread.roller_profile_radius is not None:
        margins["roller_profile_radius"] = thread.roller_profile_radius
    return margins


def bore_margins(stage: Stage) -> dict[str, Scalar]:
    """Wall thickness between bore and thread of the bodies with a bore, by body [m].

    For the screw it is measured to the root if given, else to the nominal radius, as in the check
    of files.
    """
    margins = {}
    if stage.screw.bore_radius is not None:
        shaft = None if stage.strength is None else stage.strength.shaft
        root = None if shaft is None else shaft.root_radius
        outer = stage.thread.screw_radius if root is None else root
        margins["screw"] = jnp.minimum(stage.thread.screw_radius, outer) - stage.screw.bore_radius
    if stage.roller.bore_radius is not None:
        margins["roller"] = stage.thread.roller_radius - stage.roller.bore_radius
    return margins


def dimensions_possible(stage: Stage) -> Bool[Array, ""]:
    """Whether numbers are in range and bores fit; false where numbers of the thread are NaN."""
    margins = dimension_margins(stage.thread) | bore_margins(stage)
    within = jnp.stack([margin > 0 for margin in margins.values()]).all()
    return within & numbers_possible(stage)


def axis_possible(axis: Axis, stage: Stage) -> Bool[Array, ""]:
    """Whether numbers are in range and the nut lies on the screw, between its bearings.

    The check of files for traced numbers. NaN passes: results that depend on it are NaN.
    """
    possible = numbers_possible(axis)
    shaft, length = axis.shaft, stage.screw.length
    if shaft is None:
        return possible
    far = shaft.far_bearing
    if far is not None:
        possible &= below_or_nan(shaft.nut_distance, far.distance)
        if length is not None:
            possible &= jnp.logical_not(far.distance > length)
    elif length is not None:
        possible &= below_or_nan(shaft.nut_distance, length)
    return possible


def rollers_fit(stage: Stage) -> Bool[Array, ""]:
    """Whether neighbouring rollers leave a gap."""
    return roller_clearance(stage) > 0
