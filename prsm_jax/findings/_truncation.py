"""Margins of crests: below the point of a tooth, and beyond the contact ellipses."""

import functools
from collections.abc import Iterator
from math import ceil, floor, isfinite, log10
from typing import Literal, TypeAlias

import jax.numpy as jnp

from .. import strength
from .._errors import MissingDataError
from ..contact import load_beyond
from ..fields import Scalar
from ..geometry import end_names
from ..mechanism import Mechanism, Stage, pointed_height
from ..quantities import (
    Analysis,
    SharedLoad,
    derives_dynamic_capacity,
    derives_static_capacity,
    dynamic_capacity_of,
    on_one_flank,
    sharing_factor_of,
    static_capacity_of,
    truncated_fatigue_of,
)
from ._margin import Margin, Reading, margin_source

#: Difference of heights that is rounding [m].
_ROUNDING = 1e-10
#: Height that the optimiser keeps below the point of a tooth, for rounding in a file [m].
_RESERVE = 1e-6
#: Loads for which the ellipses are checked, and their names in the message.
_LOADS = {
    "operating": "the operating load",
    "largest": "the largest load",
    "dynamic": "the dynamic capacity",
    "static": "the static capacity",
}


def _load(analysis: Analysis, index: int, stage: Stage, which: str) -> tuple[Scalar, Scalar]:
    """A load on one flank, and this load if all threads carried the largest thread load [N]."""
    if which == "operating":
        load = strength.largest_flank_load(stage, analysis.load)
        return load, load * sharing_factor_of(analysis, index, "operating_point")
    if which == "dynamic":
        load = dynamic_capacity_of(analysis, index, stage)
        return load, load * sharing_factor_of(analysis, index, "equivalent")
    if which == "largest":
        load = on_one_flank(analysis, stage)
    else:
        load = static_capacity_of(analysis, index, stage)
    return load, load * sharing_factor_of(analysis, index)


def _loads(analysis: Analysis, index: int) -> dict[str, tuple[Scalar, Scalar]]:
    """The loads for which the stage has data.

    **Raises:** `MissingDataError` if there is none.
    """
    loads, missing = {}, None
    for which in _LOADS:
        try:
            loads[which] = _load(analysis, index, analysis.mechanism.stages[index], which)
        except MissingDataError as error:
            missing = error
    if not loads:
        assert missing is not None
        raise missing
    return loads


def _whole_loads(analysis: Analysis, index: int) -> dict[str, Scalar]:
    """Loads as the second ones of `_load` where no ellipse is cut, so that capacities are higher.

    An addendum that is enough for the present capacity would be too low for the one it gives.
    """
    stage, loads = analysis.mechanism.stages[index], {}
    for which, (_, of_thread) in _loads(analysis, index).items():
        fatigue = truncated_fatigue_of(analysis, index, stage) if which == "dynamic" else None
        if fatigue is not None:
            factor = sharing_factor_of(analysis, index, "equivalent")
            loads[which] = fatigue.untruncated * factor
        elif which == "static" and derives_static_capacity(stage):
            factor, meshing = sharing_factor_of(analysis, index), analysis.meshing(index)
            contact = analysis.reference_contact(index)
            whole = strength.static_capacity(stage, meshing, contact, factor, (None, None))
            loads[which] = whole * factor
        else:
            loads[which] = of_thread
    return loads


def _whole_extents(analysis: Analysis, index: int, reach: strength.EndReach) -> dict[str, Scalar]:
    """Half-extents of the ellipses towards an end at all loads, if none is cut [m]."""
    loads = analysis.once(("whole_loads", index), lambda: _whole_loads(analysis, index))
    return {which: reach.half_extent(load) for which, load in loads.items()}


def _reaches(analysis: Analysis, index: int) -> tuple[strength.EndReach, ...]:
    stage = analysis.mechanism.stages[index]
    return analysis.once(
        ("end_reaches", index),
        lambda: strength.end_reaches(
            stage, analysis.meshing(index), analysis.reference_contact(index)
        ),
    )


def _shares(stage: Stage) -> tuple[SharedLoad, ...]:
    """Loads of `_LOADS` whose load distribution is needed."""
    data = stage.strength
    if data is None or (data.dynamic_capacity is None and data.material_factor is None):
        return ("operating_point", "largest")
    return ("operating_point", "largest", "equivalent")


_Body: TypeAlias = Literal["screw", "roller", "nut"]
_BODIES: tuple[_Body, ...] = ("screw", "roller", "nut")
#: Bodies whose threads have an addendum; the nut's thread is as high as the screw's.
_BODIES_OF: dict[str, tuple[_Body, ...]] = {
    "screw_addendum": ("screw", "nut"),
    "roller_addendum": ("roller",),
}


def _addendum_of(body: str) -> str:
    """Name of the height of a body's thread."""
    return "roller_addendum" if body == "roller" else "screw_addendum"


@margin_source
def _pointed_teeth(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """The two flanks of a tooth must not meet below its crest."""
    if mechanism.stages[index].line_contact is not None:
        # Rings have flanks of their own.
        return
    for body in _BODIES:
        name = _addendum_of(body)
        if getattr(mechanism.stages[index].thread, name) is None:
            continue

        def heights(analysis: Analysis, body: _Body = body, name=name) -> dict[str, Scalar]:
            stage = analysis.mechanism.stages[index]
            return {
                "addendum": getattr(stage.thread, name),
                "point": pointed_height(stage, body),
            }

        def value(analysis: Analysis, heights=heights) -> Scalar:
            found = heights(analysis)
            return found["point"] - found["addendum"]

        def message(r: Reading, body=body, name=name) -> str:
            thread = r.mechanism.stages[index].thread
            return (
                f"stage.thread.{name} is {r.details['addendum'] * 1e3:.6g} mm, but with a pitch of "
                f"{float(thread.pitch) * 1e3:.4g} mm the flanks of the {body}'s teeth meet "
                f"{r.details['point'] * 1e3:.4g} mm from the nominal radius, where a tooth is "
                "pointed: such a thread cannot exist; lower the addendum, or raise the lead or the "
                "contact angle"
            )

        yield Margin(
            "pointed_tooth",
            index + 1,
            value,
            (("error", -_ROUNDING),),
            message,
            unit="m",
            kind="existence",
            details=heights,
            shown=lambda r: (r.details["addendum"], r.details["point"]),
            at_most=True,
            reserve=_RESERVE + _ROUNDING,
            subject=body,
        )


@margin_source
def _contact_truncation(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    for place, (side, kind, body) in enumerate(end_names(mechanism.stages[index])):

        def details(analysis: Analysis, place=place, body=body) -> dict[str, Scalar]:
            reach = _reaches(analysis, index)[place]
            numbers = {"distance": reach.end.distance}
            stage, extents = (
                analysis.mechanism.stages[index],
                _whole_extents(analysis, index, reach),
            )
            if "static" in extents and derives_static_capacity(stage):
                # The ellipse at a Hertz pressure is as long as this pressure is high.
                assert stage.strength is not None
                permissible = stage.strength.permissible_pressure
                assert permissible is not None
                numbers["pressure"] = permissible * reach.end.distance / extents["static"]
            if reach.end.kind == "crest":
                longest = jnp.max(jnp.stack(list(extents.values())))
                lacking = longest - reach.end.distance
                present = getattr(stage.thread, _addendum_of(body))
                numbers["needed"] = present + lacking / reach.end.lengthening
                points = [pointed_height(stage, one) for one in _BODIES_OF[_addendum_of(body)]]
                numbers["point"] = functools.reduce(jnp.minimum, points)
            for which, (load, of_thread) in _loads(analysis, index).items():
                numbers[which] = load
                numbers[which + "_half_extent"] = reach.half_extent(of_thread)
                if reach.edge is not None:
                    numbers[which + "_edge_pressure"] = reach.edge_pressure(of_thread)
            return numbers

        def value(analysis: Analysis, place=place) -> Scalar:
            """Length of flank between the longest ellipse and the end [m]."""
            reach = _reaches(analysis, index)[place]
            loads = _loads(analysis, index).values()
            longest = jnp.max(jnp.stack([reach.half_extent(load) for _, load in loads]))
            return reach.end.distance - longest

        yield Margin(
            "contact_truncation",
            index + 1,
            value,
            (("warning", 0.0),),
            lambda r, side=side, kind=kind, body=body: _message(r, index, side, kind, body),
            unit="m",
            details=details,
            shown=lambda r: (-r.value / (r.details["distance"] - r.value), 0.0),
            shown_unit="1",
            at_load=_load_of_the_longest,
            at_most=True,
            reserve=_RESERVE,
            subject=f"{kind} of {body} on the {side} side",
            shares=_shares(mechanism.stages[index]),
        )


def _load_of_the_longest(reading: Reading) -> str:
    """The load whose ellipse reaches farthest; of equal ones the operating load."""
    known = [which for which in _LOADS if which in reading.details]
    return _LOADS[max(known, key=lambda which: reading.details[which + "_half_extent"])]


def _message(reading: Reading, index: int, side: str, kind: str, body: str) -> str:
    stage, numbers = reading.mechanism.stages[index], reading.details
    distance, place = numbers["distance"], f"the {kind} of the {body}"
    if not distance > 0:
        return (
            f"the contact on the {side} side lies beyond {place}: pressures and capacities are not "
            f"valid. Remedy: {_remedy(reading, index, kind, body)}"
        )
    parts = []
    for which in sorted((w for w in _LOADS if w in numbers), key=lambda w: numbers[w]):
        half = numbers[which + "_half_extent"]
        if half > distance:
            share = 1 - distance / half
            lost = float(load_beyond(jnp.asarray(distance / half)))
            parts.append(
                f"at {_LOADS[which]} of {numbers[which] * 1e-3:.4g} kN by "
                f"{(half - distance) * 1e3:.3g} of {half * 1e3:.3g} mm ({share:.2%} of its "
                f"half-extent, {lost:.2%} of its load)"
            )
            edge = numbers.get(which + "_edge_pressure")
            if edge is not None:
                parts[-1] += f", {edge * 1e-6:.4g} MPa at the rounded edge"
            # For the load distribution among threads at this load.
            onset = numbers[which] * (distance / half) ** 3
    return (
        f"above {onset * 1e-3:.4g} kN the contact ellipse on the {side} side passes {place}: "
        f"{', '.join(parts)}. {_taken(stage)}. Remedy: {_remedy(reading, index, kind, body)}"
    )


def _taken(stage: Stage) -> str:
    """Which results include the truncation, and which do not."""
    data = stage.strength
    static, cuts = derives_static_capacity(stage), strength.cuts_fatigue(stage)
    dynamic = derives_dynamic_capacity(stage)
    included = {
        (True, True): "Capacities, life and pressures",
        (True, False): "The static capacity and pressures",
        (False, True): "The dynamic capacity, life and pressures",
        (False, False): "Pressures",
    }[static, dynamic and cuts]
    left_out = []
    if data is not None and data.static_capacity is not None and data.dynamic_capacity is not None:
        left_out.append("the given capacities and the life")
    elif data is not None and data.static_capacity is not None:
        left_out.append("the given static capacity")
    elif data is not None and data.dynamic_capacity is not None:
        left_out.append("the given dynamic capacity and its life")
    if dynamic and not cuts:
        left_out.append("the dynamic capacity of equivalent balls and its life")
    left_out.append("the concentration of pressure at the edge")
    return f"{included} take this into account, but not {', nor '.join(left_out)}"


def _remedy(reading: Reading, index: int, kind: str, body: str) -> str:
    """What to change so that no ellipse passes an end of the flank."""
    others, aside = _without_the_thread(reading, index)
    if kind == "root":
        return _any_of(f"deepen the {body}'s thread", *others) + aside
    name = _addendum_of(body)
    present = float(getattr(reading.mechanism.stages[index].thread, name)) * 1e3
    needed, point = reading.details["needed"] * 1e3, reading.details["point"] * 1e3
    if not isfinite(needed):
        return _any_of(f"raise stage.thread.{name}", *others) + aside
    proposed = _round_up(needed, point)
    if proposed is not None:
        raised = f"raise stage.thread.{name} from {present:.6g} to {proposed} mm"
        return _any_of(raised, *others) + aside
    return (
        f"{_any_of('raise the pitch', *others)}{aside}; {needed:.4g} mm of stage.thread.{name} "
        f"({present:.6g} mm now) would be enough, but at this pitch the flanks of a tooth end at "
        f"{point:.4g} mm"
    )


def _any_of(*ways: str) -> str:
    """Ways of which one is enough."""
    *others, last = ways
    return f"{', '.join(others)}, or {last}" if others else last


def _without_the_thread(reading: Reading, index: int) -> tuple[list[str], str]:
    """What else shortens all ellipses that are cut, and what shortens only some of them.

    At a static capacity derived from the permissible pressure, the pressure determines the
    ellipse, whatever the number of threads; a dynamic capacity derived from the contacts grows
    with this number, so that the ellipse hardly changes. The load changes no capacity.
    """
    stage, numbers = reading.mechanism.stages[index], reading.details
    distance = numbers["distance"]
    if not distance > 0:
        # The contact itself, and the shortest ellipse, lies beyond the end.
        return [], ""
    cut = {w for w in _LOADS if numbers.get(w + "_half_extent", 0.0) > distance}
    derived = set()
    if derives_static_capacity(stage):
        derived.add("static")
    if derives_dynamic_capacity(stage):
        derived.add("dynamic")
    ways = []
    if not cut & derived:
        ways.append("engage more threads or rollers")
    if not cut & {"static", "dynamic"}:
        ways.append("lower the load")
    if cut == {"static"} & derived:
        assert stage.strength is not None
        assert stage.strength.permissible_pressure is not None
        present, needed = float(stage.strength.permissible_pressure), numbers["pressure"]
        ways.append(
            f"lower stage.strength.permissible_pressure from {present * 1e-9:.6g} to "
            f"{_round_down(needed * 1e-9)} GPa, and with it the static capacity"
        )
    under = cut & {"operating", "largest"}
    if not under or "lower the load" in ways:
        return ways, ""
    names = " and ".join(_LOADS[w] for w in _LOADS if w in under)
    partial = "a lower load" if ways else "more engaged threads or rollers, or a lower load,"
    return ways, f" ({partial} would help at {names} only)"


def _round_down(value: float) -> str:
    """A number of three digits that is not above a positive one."""
    step = 10.0 ** (floor(log10(value)) - 2)
    return f"{floor(value / step) * step:.3g}"


def _round_up(needed: float, greatest: float) -> str | None:
    """A number of few digits from `needed` to `greatest`; `None` if there is none."""
    if not 0 < needed <= greatest:
        return None
    for digits in (3, 4, 5, 6):
        step = 10.0 ** (floor(log10(needed)) + 1 - digits)
        rounded = f"{ceil(needed / step) * step:.{digits}g}"
        if needed <= float(rounded) <= greatest:
            return rounded
    return None
