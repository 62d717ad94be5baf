"""Margins of geometry: are the dimensions possible, do the parts fit, do the threads mesh?"""

from collections.abc import Callable, Iterator

import jax.numpy as jnp

from ..fields import Scalar
from ..geometry import (
    bore_margins,
    carrier_clearance,
    dimension_margins,
    dimension_names,
    roller_clearance,
)
from ..mechanism import Mechanism, Stage
from ..quantities import Analysis
from ..strength import thins_teeth
from ._agreement import (
    held_threads,
    keys_of_counts,
    most_threads,
    possible_threads,
    thread_counts,
)
from ._margin import Kind, Margin, Reading, margin_source

#: Gap that the optimiser keeps, so that rounding in a file does not close it [m].
_CLOSE = 1e-6
#: Difference of lengths that is rounding [m].
_SAME_LENGTH = 1e-7

#: Permitted ranges of thread parameters, in words.
_WORDS = {
    "lead": "more than 0",
    "starts": "more than 2",
    "radius_ratio": "more than 2",
    "roller_radius": "more than 0",
    "contact_angle": "between 0 and pi/2 (90 deg)",
    "roller_profile_radius": "more than 0",
}
#: Their SI units.
_UNITS = {"starts": "1", "radius_ratio": "1", "contact_angle": "rad"}


def _words(stage: Stage, name: str) -> str:
    """The permitted range of a number of the thread, in words."""
    if name == "starts" and stage.thread.family.starts is not None:
        return stage.thread.starts_limit.words
    return _WORDS[name]


def _clearance(
    name: str,
    index: int,
    value: Callable[[Stage], Scalar],
    message: Callable[[Reading], str],
    kind: Kind,
) -> Margin:
    """A margin that is an error where two parts touch or overlap."""
    return Margin(
        name,
        index + 1,
        lambda analysis: value(analysis.mechanism.stages[index]),
        (("error", 0.0),),
        message,
        unit="m",
        kind=kind,
        reserve=_CLOSE,
        strict=True,
    )


@margin_source
def _dimensions(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Thread parameters outside their permitted ranges."""
    for name in dimension_names(mechanism.stages[index].thread):
        unit = _UNITS.get(name, "m")

        def present_value(analysis: Analysis, name=name) -> dict[str, Scalar]:
            return {"given": getattr(analysis.mechanism.stages[index].thread, name)}

        yield Margin(
            "dimension",
            index + 1,
            lambda a, name=name: dimension_margins(a.mechanism.stages[index].thread)[name],
            (("error", 0.0),),
            lambda r, name=name, after="" if unit == "1" else f" {unit}": (
                f"stage.thread.{name} is {r.details['given']:.6g}{after}; it must be "
                f"{_words(r.mechanism.stages[index], name)}: such a thread cannot exist"
            ),
            unit=unit,
            kind="existence",
            details=present_value,
            shown=lambda r: (r.details["given"], r.details["given"] - r.value),
            reserve=0.0,
            strict=True,
            subject=name,
        )


@margin_source
def _bores(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Bores that are wider than the core of the thread."""
    for body in bore_margins(mechanism.stages[index]):

        def radius(analysis: Analysis, body=body) -> dict[str, Scalar]:
            return {"bore": getattr(analysis.mechanism.stages[index], body).bore_radius}

        yield Margin(
            "bore",
            index + 1,
            lambda a, body=body: bore_margins(a.mechanism.stages[index])[body],
            (("error", 0.0),),
            lambda r, body=body: (
                f"stage.{body}.bore_radius is {r.details['bore'] * 1e3:.6g} mm, but inside the "
                f"{body}'s thread there are only {(r.details['bore'] + r.value) * 1e3:.6g} mm: "
                f"such a {body} cannot exist; make the bore smaller"
            ),
            unit="m",
            kind="existence",
            details=radius,
            shown=lambda r: (r.details["bore"], r.details["bore"] + r.value),
            reserve=_CLOSE,
            strict=True,
            subject=body,
        )


@margin_source
def _ratio(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Roller and nut threads roll without slip only with a whole number of starts."""
    if mechanism.stages[index].line_contact is not None:
        # Rollers with rings have no thread.
        return

    # Starts that do not determine the radii are few.
    free = mechanism.stages[index].thread.family.ratio_beyond_starts is None
    least = 1 if free else 3

    def message(r: Reading) -> str:
        whole = f"{r.value:.6g}; it must be a whole number of at least {least} (nearest: "
        what = (
            "the number of thread starts is "
            if mechanism.stages[index].type != "standard"
            else "the ratio of nut to roller radius, and with it the number of thread starts, is "
        )
        return f"{what}{whole}{max(least, round(r.value))})"

    yield Margin(
        "feasible_ratio",
        index + 1,
        lambda analysis: analysis.mechanism.stages[index].thread.starts,
        # Below it by more than the rounding error of a whole number.
        (("error", least - 1e-6),),
        message,
        kind="assembly",
        shown=lambda r: (r.value, float(max(least, round(r.value)))),
        reserve=0.0,
        integer=True,
    )


@margin_source
def _rollers(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    count = mechanism.stages[index].roller_count

    def message(r: Reading) -> str:
        return (
            f"{count} neighbouring rollers overlap by {-r.value * 1e3:.4g} mm; use fewer "
            "rollers, or a larger ratio of nut to roller radius (starts, or radius_ratio)"
        )

    yield _clearance("roller_clearance", index, roller_clearance, message, "existence")


@margin_source
def _carrier(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """The carrier's annulus, centred on the roller axes, must pass between screw and nut."""
    carrier = mechanism.stages[index].carrier
    if carrier is None or carrier.radial_width is None:
        return

    def message(r: Reading) -> str:
        part = r.mechanism.stages[index].carrier
        assert part is not None
        assert part.radial_width is not None
        return (
            f"the carrier, {float(part.radial_width) * 1e3:.4g} mm wide, cuts "
            f"{-r.value * 1e3:.4g} mm into the screw's thread; make it narrower"
        )

    yield _clearance("carrier_clearance", index, carrier_clearance, message, "assembly")


@margin_source
def _meshing(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    sides = " or ".join(mechanism.stages[index].thread.family.sliding)

    def message(r: Reading) -> str:
        return (
            f"{sides} and roller flanks do not touch in a point; the roller's profile radius "
            f"{r.details['profile_radius'] * 1e3:.4g} mm is too large (too flat a profile) "
            "for this lead and contact angle"
        )

    def details(analysis: Analysis) -> dict[str, Scalar]:
        thread = analysis.mechanism.stages[index].thread
        return {
            "profile_radius": thread.profile_radius,
            "centred": thread.roller_radius / jnp.sin(thread.flank_angle),
        }

    def touches(analysis: Analysis) -> Scalar:
        converged = analysis.kinematics[index].meshing.converged
        return jnp.where(converged, 1.0, -1.0).astype(
            analysis.mechanism.stages[index].thread.lead.dtype
        )

    yield Margin(
        "meshing",
        index + 1,
        touches,
        (("error", 0.0),),
        message,
        kind="existence",
        details=details,
        shown=lambda r: (r.details["profile_radius"], r.details["centred"]),
        smooth=False,
    )


@margin_source
def _on_flank(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    thread, family = mechanism.stages[index].thread, mechanism.stages[index].thread.family
    # The contact with a body on which rollers slide lies aside of the line of centres: nearer to
    # the crests of both.
    for body in (*family.sliding, "roller"):
        # The nut's thread is as high as the screw's.
        height = "roller_addendum" if body == "roller" else "screw_addendum"
        if getattr(thread, height) is None:
            continue

        def details(analysis: Analysis, body=body, height=height) -> dict[str, Scalar]:
            current = analysis.mechanism.stages[index].thread
            meshing = analysis.kinematics[index].meshing
            sides = [getattr(meshing, side) for side in family.sliding]
            if body == "roller":
                radii = [side.roller_contact_radius for side in sides]
                radius = radii[0] if len(radii) == 1 else jnp.maximum(*radii)
            else:
                radius = getattr(meshing, body).contact_radius
            nominal, addendum = getattr(current, f"{body}_radius"), getattr(current, height)
            return {
                "radius": radius,
                "crest": nominal - addendum if body == "nut" else nominal + addendum,
            }

        def value(analysis: Analysis, body=body, details=details) -> Scalar:
            radii = details(analysis)
            difference = radii["crest"] - radii["radius"]
            return -difference if body == "nut" else difference

        yield Margin(
            "contact_on_flank",
            index + 1,
            value,
            (("warning", 0.0),),
            lambda r, body=body: (
                f"the contact radius {r.details['radius'] * 1e3:.4g} mm lies outside the {body}'s "
                f"thread, which ends at {r.details['crest'] * 1e3:.4g} mm; raise the addendum or "
                "lower the lead"
            ),
            unit="m",
            details=details,
            shown=lambda r: (r.details["radius"], r.details["crest"]),
            reserve=_CLOSE,
            subject=body,
        )


@margin_source
def _tooth_thickness(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Interference of teeth half a pitch thick; skipped where thinning or play is given."""
    stage = mechanism.stages[index]
    play = None if stage.strength is None else stage.strength.play
    if play is not None and (play.axial_backlash is not None or thins_teeth(play)):
        return
    if stage.load_sharing is not None and stage.load_sharing.backlash is not None:
        return
    yield Margin(
        "tooth_thickness",
        index + 1,
        lambda analysis: analysis.kinematics[index].meshing.axial_gap,
        (("note", 0.0),),
        lambda r: (
            f"teeth half a pitch thick would interfere by {-r.value * 1e3:.4g} mm per flank; thin "
            "the teeth by at least this amount"
        ),
        unit="m",
    )


@margin_source
def _thread_length(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Roller and nut must be as long as the threads that carry load, N p."""
    stage = mechanism.stages[index]
    if not thread_counts(stage):
        return

    def needed(analysis: Analysis, spaces: float = 0.0) -> Scalar:
        current = analysis.mechanism.stages[index]
        counts = thread_counts(current).values()
        return (jnp.max(jnp.stack(list(counts))) - spaces) * current.thread.pitch

    def body_length(analysis: Analysis, body: str) -> Scalar:
        return getattr(analysis.mechanism.stages[index], body).length

    def too_short(r: Reading, body: str) -> str:
        current, have = r.mechanism.stages[index], r.details["needed"] + r.value
        count = possible_threads(current)
        lower = f"lower {keys_of_counts(current)} to {count}, " if count > 0 else ""
        return (
            f"{most_threads(current)} are {r.details['needed'] * 1e3:.4g} mm long, but "
            f"stage.{body}.length is {have * 1e3:.4g} mm, which holds "
            f"{held_threads(current, have)}: such a {body} cannot be made; {lower}lower the lead, "
            f"or lengthen the {body}"
        )

    for body in ("roller", "nut"):
        if getattr(stage, body).length is None:
            continue
        yield Margin(
            "thread_length",
            index + 1,
            lambda a, body=body: body_length(a, body) - needed(a),
            (("error", -_SAME_LENGTH),),
            lambda r, body=body: too_short(r, body),
            unit="m",
            kind="assembly",
            details=lambda a: {"needed": needed(a)},
            shown=lambda r: (r.details["needed"], r.details["needed"] + r.value),
            at_most=True,
            reserve=_CLOSE + _SAME_LENGTH,
            subject=body,
        )

    if stage.roller.length is None or stage.gear is None or stage.gear.face_width is None:
        return

    def between(analysis: Analysis) -> Scalar:
        gear = analysis.mechanism.stages[index].gear
        assert gear is not None
        assert gear.face_width is not None
        return body_length(analysis, "roller") - 2 * gear.face_width

    def over_gears(r: Reading) -> str:
        current, have = r.mechanism.stages[index], r.details["between"]
        return (
            f"{most_threads(current)} reach over {r.details['reach'] * 1e3:.4g} mm from the first "
            f"to the last, but between its gears a roller has {max(have, 0.0) * 1e3:.4g} mm "
            "(stage.roller.length less twice stage.gear.face_width): the outermost lie under gear "
            f"teeth, which cut them; engage the {held_threads(current, have)} that lie wholly "
            "between them, lengthen the roller, or make the gears narrower"
        )

    # From the first to the last contact of N threads there are N − 1 pitches. Gear teeth may be cut
    # over a thread, which then still carries a part of its load.
    yield Margin(
        "thread_length",
        index + 1,
        lambda a: between(a) - needed(a, 1.0),
        (("warning", -_SAME_LENGTH),),
        over_gears,
        unit="m",
        details=lambda a: {"reach": needed(a, 1.0), "between": between(a)},
        shown=lambda r: (r.details["reach"], r.details["between"]),
        at_most=True,
        reserve=_CLOSE + _SAME_LENGTH,
        subject="roller",
    )
