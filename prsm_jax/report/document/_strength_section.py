"""Strength and life, and load sharing, as sections of a report."""

from collections.abc import Mapping

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ...fields import Scalar
from ...load_sharing import LoadDistribution
from ...mechanism import DutyCycle, Mechanism, Stage
from ...quantities import find_quantity
from ...strength import (
    LoadSpectrum,
    TruncatedFatigue,
    flank_loads,
    largest_demand,
    load_spectrum,
    preload_of,
    spectrum_of,
)
from ...text import number, related, show
from .._style import readable
from ..contact_charts import force_deflection_chart, roller_force_chart, thread_load_chart
from ..design_charts import life_chart, shaft_limits_chart
from ..interactive import deflection_curves, life_curve, shaft_limit_curves, thread_load_bars
from ..results import ReportData, largest_shared_pressure
from ._section import Picture, Section, Table
from ._status_section import margin_text

#: The check whose verdict a quantity has, and the limit of the quantity where it is a number.
_CHECK_OF: dict[str, tuple[str, float | None]] = {
    "static_safety": ("static_safety", 1.0),
    "life_ratio": ("rating_life", 1.0),
    "buckling_safety": ("buckling", None),
    "critical_speed_margin": ("screw_speed", 0.0),
    "axial_backlash": ("backlash", 0.0),
}


def _verdict(data: ReportData, name: str, unit: str, stage: int) -> tuple[str, str, str]:
    """Limit, margin and verdict of a quantity; `stage` is 0 for one of the whole mechanism.

    A quantity of the whole mechanism has the verdict of its worst stage.
    """
    check, limit = _CHECK_OF.get(name, ("", None))
    found = [c for c in data.checks or () if c.name == check and stage in (0, c.stage)]
    known = [one for one in found if one.limit is not None and one.margin is not None]
    if not known:
        return "", "", "no limit"
    worst = min(known, key=lambda one: one.margin if one.margin is not None else np.inf)
    least = worst.limit if limit is None else limit
    assert least is not None
    return related("at least", show(least, unit)), margin_text(worst), worst.verdict


def strength_section(data: ReportData) -> Section | None:
    """Capacities, safety, life, limits of the shaft, play: those that the file has data for."""
    if not data.strength:
        return None
    after = data.improved if data.improved is not None and data.improved.strength else None
    improved = None if after is None else after.strength
    rows = []
    for name, value in data.strength.items():
        quantity = find_quantity(name)
        later = np.ravel(improved[name]) if improved and name in improved else None
        for index, component in enumerate(np.ravel(value)):
            several = np.size(value) > 1
            words = f", {quantity.dimensions[0]} {index + 1}" if several else ""
            stage = index + 1 if quantity.dimensions else 0
            verdict = _verdict(data, name, quantity.unit, stage)
            cells = [readable(name) + words, quantity.symbol, show(component, quantity.unit, name)]
            cells += verdict
            if after is not None:
                cells.append("" if later is None else show(later[index], quantity.unit, name))
                cells += _verdict(after, name, quantity.unit, stage)[2:]
            rows.append(tuple(cells))
    head = ("", "symbol", "value", "limit", "margin", "verdict")
    head += (data.later, "verdict after") if after is not None else ()
    words = (
        "No standard exists for planetary roller screws: capacities and life follow the practice "
        "for ball bearings and ball screws (ISO 76, ISO 281, ISO 3408-5), applied to the contacts "
        "computed here.",
    )
    table = Table("Strength and life", head, tuple(rows))
    return Section("strength", "Strength and life", words, (table,), _strength_pictures(data))


def _strength_pictures(data: ReportData) -> tuple[Picture, ...]:
    mechanism, values = data.mechanism, data.strength or {}
    pictures = []
    cycle = mechanism.duty_cycle
    for index, stage in enumerate(mechanism.stages):
        suffix, words = data.of_stage(index)
        # Without a life there is no chart: then the preload is not known either.
        drawn = None
        fatigue = data.fatigue[index] if data.fatigue else None
        if cycle is not None and "dynamic_capacity" in values and "rating_life" in values:
            capacity = float(np.ravel(values["dynamic_capacity"])[index])
            drawn, note = _pressed(stage, cycle, capacity, fatigue)
        if drawn is not None and bool(jnp.any(drawn.load != 0)):
            static = values.get("static_capacity")
            ends = None if static is None else float(np.ravel(static)[index])
            pictures.append(
                Picture(
                    f"life{suffix}",
                    f"Loads of the duty cycle, their damage, and the life{words}.{note}"
                    + _cut_at_capacity(values, index),
                    lambda c=capacity, s=ends, d=drawn, f=fatigue: life_chart(c, d, s, f),
                    lambda c=capacity, s=ends, f=fatigue: life_curve(c, s, f),
                )
            )
        if stage.strength is not None and stage.strength.shaft is not None:
            pictures.append(
                Picture(
                    f"shaft_limits{suffix}",
                    f"Limits of the screw over its length{words}; points are the largest values of "
                    "operating point and duty cycle.",
                    lambda s=stage: shaft_limits_chart(s, *_demand(mechanism)),
                    lambda s=stage: shaft_limit_curves(s),
                )
            )
    return tuple(pictures)


def _cut_at_capacity(values: Mapping[str, Array], index: int) -> str:
    """Why a life line is not straight where ellipses are cut."""
    onset = values.get("truncation_load")
    if onset is None or np.ravel(onset)[index] >= np.ravel(values["dynamic_capacity"])[index]:
        return ""
    return (
        " Ends of flanks cut the contact ellipses at the dynamic capacity, and less at smaller "
        "loads: there the life falls faster than 1/F³. The equivalent load is "
        "the constant load with the same life."
    )


def _demand(mechanism: Mechanism) -> tuple[Scalar | None, Scalar | None]:
    """Largest load and speed; `None` without duty cycle and operating point."""
    if mechanism.duty_cycle is None and mechanism.operating_point is None:
        return None, None
    speed, load = largest_demand(mechanism, spectrum_of(mechanism))
    return load, speed


def _pressed(
    stage: Stage, cycle: DutyCycle, capacity: float, fatigue: TruncatedFatigue | None
) -> tuple[LoadSpectrum, str]:
    """The loads of a life chart, and a sentence on the flanks that carry them."""
    spectrum, preload = load_spectrum(cycle), preload_of(stage)
    if preload is None:
        if not bool(jnp.any(spectrum.load > 0) & jnp.any(spectrum.load < 0)):
            return spectrum, ""
        return spectrum, (
            " The chart puts the magnitudes of all loads on one flank; the table treats both "
            "flanks separately."
        )
    both = flank_loads(spectrum.load, preload)
    cubes = [
        load if fatigue is None else fatigue.comparable_load(load, jnp.asarray(capacity))
        for load in both
    ]
    damage = [jnp.sum(spectrum.weights * load**3) for load in cubes]
    worse = both[0 if damage[0] >= damage[1] else 1]
    return eqx.tree_at(lambda s: s.load, spectrum, worse), (
        " The loads are those of the more heavily loaded flanks, preload included; the table adds "
        "up the flanks on both sides."
    )


def _across_rows(shared: LoadDistribution) -> list[tuple[str, str]]:
    """Unbalance of the rollers, and force and moment across the axis, where rollers differ."""
    force, moment = shared.nut_radial_force, shared.nut_overturning_moment
    if force is None or moment is None:
        return []
    return [
        ("standard deviation over mean roller load", number(shared.nut.roller_load_unbalance)),
        ("radial force of the rollers on the nut", show(np.hypot(*force), "N")),
        ("moment of the rollers on the nut", show(np.hypot(*moment), "N·m")),
    ]


def sharing_section(data: ReportData) -> Section | None:
    """Load sharing among threads and rollers, in stages that model it."""
    if not data.shared:
        return None
    tables, pictures = [], []
    for index, shared in data.shared.items():
        suffix, words = data.of_stage(index)
        spacer, tangent = shared.spacer_force, shared.tangent_stiffness
        assert tangent is not None
        largest, uncut = largest_shared_pressure(data, index), float(shared.max_pressure)
        rows = [
            ("largest over mean thread load, screw", number(shared.screw.thread_sharing_factor)),
            ("largest over mean thread load, nut", number(shared.nut.thread_sharing_factor)),
            ("largest over mean roller load", number(shared.screw.roller_sharing_factor)),
            ("largest pressure", show(largest, "Pa")),
            ("deflection", show(shared.elastic.deflection, "m")),
            # It goes to 0 with the load; at 0 the result has that of a trace of a load.
            ("axial stiffness dF/dx", show(tangent if largest > 0 else 0.0, "N/m")),
        ]
        if largest > uncut:
            rows.insert(4, ("largest pressure of a whole ellipse", show(uncut, "Pa")))
        if spacer is not None:
            rows.append(("force in the spacer", show(spacer, "N")))
        rows += _across_rows(shared)
        tables.append(Table(f"Shared loads{words}", ("", ""), tuple(rows)))
        pictures.append(
            Picture(
                f"thread_loads{suffix}",
                f"Load of every thread{words}.",
                lambda shared=shared: thread_load_chart(shared),
                lambda shared=shared: thread_load_bars(shared),
            )
        )
        if shared.roller_angle is not None:
            pictures.append(
                Picture(
                    f"roller_forces{suffix}",
                    f"Loads of threads around the screw{words}, with errors of parts.",
                    lambda shared=shared: roller_force_chart(shared),
                )
            )
        curve = data.deflections.get(index)
        if curve is not None:
            pictures.append(
                Picture(
                    f"force_deflection{suffix}",
                    f"Axial load over deflection of the nut, and its stiffness{words}.",
                    lambda curve=curve: force_deflection_chart({data.label: curve}),
                    lambda curve=curve: deflection_curves({data.label: curve}),
                )
            )
    words = (
        "Shafts, teeth and contacts are elastic, so threads do not share the load equally. Threads "
        "are numbered from the end of the nut where the screw's force enters.",
    )
    return Section("load_sharing", "Load sharing", words, tuple(tables), tuple(pictures))
