"""Margins between contact ellipses and the ends of their flanks."""

from collections.abc import Iterator

import jax.numpy as jnp

from .. import strength
from .._errors import MissingDataError
from ..contact import load_beyond
from ..fields import Scalar
from ..geometry import end_names
from ..mechanism import Mechanism, Stage
from ..quantities import (
    Analysis,
    SharedLoad,
    dynamic_capacity_of,
    on_one_flank,
    sharing_factor_of,
    static_capacity_of,
)
from ._margin import Margin, Reading, margin_source

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


@margin_source
def _contact_truncation(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    for place, (side, kind, body) in enumerate(end_names(mechanism.stages[index])):

        def details(analysis: Analysis, place=place) -> dict[str, Scalar]:
            reach = _reaches(analysis, index)[place]
            numbers = {"distance": reach.end.distance}
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
            at_most=True,
            subject=f"{kind} of {body} on the {side} side",
            shares=_shares(mechanism.stages[index]),
        )


def _message(reading: Reading, index: int, side: str, kind: str, body: str) -> str:
    stage, numbers = reading.mechanism.stages[index], reading.details
    distance, place = numbers["distance"], f"the {kind} of the {body}"
    if not distance > 0:
        return (
            f"the contact on the {side} side lies beyond {place}: pressures and capacities are not "
            f"valid. Remedy: {_remedy(stage, kind, body, -distance)}"
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
        f"{', '.join(parts)}. {_taken(stage)} take this into account, "
        "but not the concentration of pressure at the edge. Remedy: "
        + _remedy(stage, kind, body, -reading.value)
    )


def _taken(stage: Stage) -> str:
    """What the truncation is part of."""
    data = stage.strength
    rated = data is not None and data.fatigue_rule == "equivalent_balls"
    return "The static capacity and pressures" if rated else "Capacities, life and pressures"


def _remedy(stage: Stage, kind: str, body: str, missing: float) -> str:
    """What to change; `missing` is the length of flank that the longest ellipse lacks [m]."""
    load = "engage more threads or rollers, or lower the load"
    if kind == "root":
        return f"deepen the {body}'s thread, {load}"
    name = "roller_addendum" if body == "roller" else "screw_addendum"
    present = float(getattr(stage.thread, name))
    needed = present + missing * float(jnp.cos(stage.thread.flank_angle))
    return (
        f"raise stage.thread.{name} from {present * 1e3:.3g} to {needed * 1e3:.3g} mm (as far as "
        f"the pitch allows), {load}"
    )
