"""Where the flanks of a thread contact end: crests and roots, seen from the contact point."""

from collections.abc import Iterator
from typing import Literal, TypeAlias

import equinox as eqx
import jax.numpy as jnp

from ..fields import Scalar
from ..mechanism import Stage, Thread
from ..numerics import inverse_root
from ..programs import physics
from ._curvature import direction_coefficient
from ._flanks import flanks_of
from ._meshing import Meshing, ThreadContact

#: Direction of an end from the contact point: towards the roller axis or away from it.
Way: TypeAlias = Literal["to_roller_axis", "from_roller_axis"]


class FlankEnd(eqx.Module):
    """One end of the flanks at a thread contact."""

    #: From the contact point to the end, along the tangent plane and at right angles to the end;
    #: negative where the contact lies beyond it [m].
    distance: Scalar
    #: Coefficient of the gap in that direction, between A and B; `None` stands for the direction
    #: across rolling [1/m].
    coefficient: Scalar | None
    #: Growth of the distance per height of a crest or depth of a root [1].
    lengthening: Scalar
    #: `"crest"` or `"root"`, and of which body: `"screw"`, `"nut"` or `"roller"`.
    kind: str = eqx.field(static=True)
    body: str = eqx.field(static=True)
    way: Way = eqx.field(static=True)


class _Radius(eqx.Module):
    """A radius at which a flank of one body ends; on the screw side unless the body is the nut."""

    radius: Scalar
    kind: str = eqx.field(static=True)
    body: str = eqx.field(static=True)


def _root_bodies(stage: Stage) -> tuple[str, ...]:
    """Bodies whose root is known."""
    if stage.load_sharing is not None and stage.load_sharing.tooth is not None:
        return ("screw", "roller", "nut")
    shaft = None if stage.strength is None else stage.strength.shaft
    return ("screw",) if shaft is not None and shaft.root_radius is not None else ()


def _roots(stage: Stage) -> dict[str, Scalar]:
    """Depths of the threads below their nominal radii, as far as known [m]."""
    depths: dict[str, Scalar] = {}
    if stage.load_sharing is not None and stage.load_sharing.tooth is not None:
        tooth = stage.load_sharing.tooth
        depths = {b: getattr(tooth, f"{b}_dedendum") for b in ("screw", "roller", "nut")}
    shaft = None if stage.strength is None else stage.strength.shaft
    if shaft is not None and shaft.root_radius is not None:
        depths["screw"] = stage.thread.screw_radius - shaft.root_radius
    return depths


def _radii(stage: Stage, side: str) -> Iterator[_Radius]:
    thread, roots = stage.thread, _roots(stage)
    # The nut's thread points inwards, and is as high as the screw's.
    outward = 1.0 if side == "screw" else -1.0
    nominal = thread.screw_radius if side == "screw" else thread.nut_radius
    if thread.screw_addendum is not None:
        yield _Radius(nominal + outward * thread.screw_addendum, "crest", side)
    if side in roots:
        yield _Radius(nominal - outward * roots[side], "root", side)
    if thread.roller_addendum is not None:
        yield _Radius(thread.roller_radius + thread.roller_addendum, "crest", "roller")
    if "roller" in roots:
        yield _Radius(thread.roller_radius - roots["roller"], "root", "roller")


def _from_nominal(thread: Thread, end: _Radius) -> tuple[Scalar, None, Scalar]:
    """Distance from the nominal point along a flank without a lead [m], and its growth [1]."""
    nominal, cosine = getattr(thread, f"{end.body}_radius"), jnp.cos(thread.flank_angle)
    return jnp.abs(end.radius - nominal) / cosine, None, 1 / cosine


class _Direction(eqx.Module):
    """The steepest direction of one body's flank in the tangent plane of a contact."""

    #: Distance of the contact from the axis of the body [m].
    radius: Scalar
    #: Length along the direction per growth of this distance.
    lengthening: Scalar
    #: Coefficient of the gap in the direction [1/m].
    coefficient: Scalar


def _direction(
    contact: ThreadContact, radius: Scalar, lead: Scalar, slope: Scalar | None
) -> _Direction:
    """The direction in the tangent plane in which the radius of a flank grows fastest.

    A flank z = f(r) + (lead/2π) θ has a gradient g with the radial part f' and the tangential part
    k = (lead/2π)/r.
    So the radial direction has the parts f'/|g| along g and −k/|g| across it; in the tangent plane,
    which is steeper along g, the first is cos γ times that.

    **Arguments:**

    - `contact`: the contact.
    - `radius`: its distance from the axis of the body [m].
    - `lead`: of the flank over 2π [m/rad].
    - `slope`: f'; `None` for the one that is negative and has the steepness of the contact.
    """
    cosine, helix = jnp.abs(contact.normal_parts[2]), lead / radius
    steep = cosine**2
    if slope is None:
        slope = -jnp.sqrt(1 / steep - 1 - helix**2)
    # Parts times |g|, and the square of their length. The sense has no effect.
    across = slope * cosine
    length = helix**2 + across**2
    coefficient = direction_coefficient(contact.curvature, -helix, across)
    lengthening = inverse_root(steep * (1 + helix**2))
    return _Direction(radius, lengthening, coefficient / length)


def _directions(
    thread: Thread, contact: ThreadContact, side: str, of_roller: bool
) -> dict[str, _Direction]:
    """Directions of the body on one side and, if asked for, of the roller."""
    flanks, radius = flanks_of(thread), contact.roller_contact_radius
    lead = flanks.reduced_lead if side == "screw" else flanks.nut_reduced_lead
    body = _direction(contact, contact.contact_radius, lead, flanks.slope)
    if not of_roller:
        return {side: body}
    if side not in thread.family.sliding:
        # On the line of centres both flanks have the same slopes.
        return {side: body, "roller": _Direction(radius, body.lengthening, body.coefficient)}
    # The flank of a roller descends outwards where that of the screw ascends; it ascends with that
    # of the nut, where the other sign of both parts has the same effect.
    lead = flanks.roller_reduced_lead if side == "screw" else -flanks.roller_reduced_lead
    return {side: body, "roller": _direction(contact, radius, lead, None)}


def _from_contact(
    thread: Thread, contact: ThreadContact, ends: tuple[_Radius, ...], side: str
) -> Iterator[tuple[Scalar, Scalar, Scalar]]:
    """Distances from the contact point in the tangent plane, the gap's coefficients there, and the
    growth of the distances.
    """
    directions = _directions(thread, contact, side, any(end.body == "roller" for end in ends))
    for end in ends:
        seen = directions[end.body]
        outer = (end.kind == "crest") != (end.body == "nut")
        distance = end.radius - seen.radius if outer else seen.radius - end.radius
        yield distance * seen.lengthening, seen.coefficient, seen.lengthening


def _way(end: _Radius) -> Way:
    """Threads of screw and nut point towards the roller axis, those of the roller away from it."""
    towards = (end.kind == "crest") != (end.body == "roller")
    return "to_roller_axis" if towards else "from_roller_axis"


def end_names(stage: Stage) -> tuple[tuple[str, str, str], ...]:
    """Side, kind and body of the ends that `flank_ends` gives; nothing is traced."""
    thread, names = stage.thread, []
    crests = {"screw": thread.screw_addendum, "nut": thread.screw_addendum}
    crests["roller"] = thread.roller_addendum
    roots = _root_bodies(stage)
    for side in ("screw", "nut"):
        for body in (side, "roller"):
            if crests[body] is not None:
                names.append((side, "crest", body))
            if body in roots:
                names.append((side, "root", body))
    return tuple(names)


def flanks_end(stage: Stage) -> bool:
    """Whether a stage defines an end of its flanks, by an addendum or a root."""
    return bool(end_names(stage))


@physics("flank_ends")
def _ends(
    stage: Stage, side: str, radii: tuple[_Radius, ...], meshing: Meshing | None
) -> tuple[FlankEnd, ...]:
    thread = stage.thread
    if meshing is None:
        return tuple(
            FlankEnd(*_from_nominal(thread, end), end.kind, end.body, _way(end)) for end in radii
        )
    seen = _from_contact(thread, getattr(meshing, side), radii, side)
    return tuple(
        FlankEnd(*numbers, end.kind, end.body, _way(end))
        for end, numbers in zip(radii, seen, strict=True)
    )


def flank_ends(
    stage: Stage, meshing: Meshing | None = None
) -> tuple[tuple[FlankEnd, ...], tuple[FlankEnd, ...]]:
    """Ends of the flanks on the screw and on the nut side, as far as the stage defines them.

    Crests by `screw_addendum` (the nut's thread is as high as the screw's) and `roller_addendum`;
    roots by the dedenda of `load_sharing.tooth` and by `strength.shaft.root_radius`. An end is a
    helix; within a contact it is taken as a straight line in the tangent plane, with an error of
    the order of the contact's size over the body's radius.

    **Arguments:**

    - `stage`: the stage.
    - `meshing`: its meshing; without it contacts lie at the nominal radii, as in curvature
      conventions other than `"exact"`.

    **Returns:** the ends of each side; without any, nothing is traced.
    """
    sides = []
    for side in ("screw", "nut"):
        radii = tuple(_radii(stage, side))
        sides.append(_ends(stage, side, radii, meshing) if radii else ())
    return sides[0], sides[1]
