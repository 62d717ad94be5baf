"""The smallest size of the catalogue that meets five requirements, as a mechanism."""

import dataclasses
import math

import numpy as np

from ..friction import CoulombFriction
from ..mechanism import Mechanism, OperatingPoint, Stage
from ..results import Shown
from ..text import Line, aligned, display_unit, number
from ._limits import fits, margins, relaxations
from ._requirements import (
    BUCKLING_SAFETY,
    DN_LIMIT,
    SPEED_SHARE,
    STATIC_SAFETY,
    UNITS,
    Requirements,
    loaded_length,
    screw_length,
    unsupported_length,
)
from ._sizes import all_sizes, size_mechanism

#: A requirement changed by more than this ratio is told as a multiple, not in per cent.
_LEAST = 0.1
#: Reserves in words.
_WORDS = {
    "envelope": "bore / nut diameter",
    "life": "life by dynamic capacity / required life",
    "static_safety": f"static capacity / ({STATIC_SAFETY:g} × load)",
    "buckling": f"buckling load / ({BUCKLING_SAFETY:g} × load)",
    "critical_speed": f"{SPEED_SHARE:g} × critical speed / speed",
    "dn_value": "DN limit / DN value",
}


@dataclasses.dataclass(frozen=True, repr=False)
class Dimensioning(Shown):
    """The size that was found for requirements, or what would have to be relaxed.

    - `requirements`: the requirements.
    - `size`: row of the catalogue, by column; `None` if no size fits.
    - `mechanism`: the mechanism of this size; `None` if no size fits.
    - `margins`: what it has over what it needs, by limit; empty if no size fits.
    - `relaxed`: if no size fits, for each requirement the nearest value that would be enough with
      all others as they are [SI]. A requirement that cannot be enough alone is absent.
    - `sizes`: number of sizes that were considered.
    """

    requirements: Requirements
    size: dict[str, float] | None
    mechanism: Mechanism | None
    margins: dict[str, float]
    relaxed: dict[str, float]
    sizes: int

    def __str__(self) -> str:
        wanted = [
            Line(name, getattr(self.requirements, name), unit) for name, unit in UNITS.items()
        ]
        if self.size is None:
            lines = [Line("", sentence) for sentence in self.sentences()]
            return aligned("No size of the catalogue fits", [*wanted, *lines])
        size = self.size
        words = f"{size['nominal_diameter_mm']:g} × {size['lead_mm']:g} mm, {size['starts']:g}"
        chosen = Line("size", f"{words} starts")
        heading = Line("reserves (at least 1):", "")
        lines = [Line(_WORDS[name], value) for name, value in self.margins.items()]
        return aligned("Dimensioning", [*wanted, chosen, heading, *lines])

    def sentences(self) -> list[str]:
        """What to relax, one sentence for each requirement; empty if a size fits."""
        if self.size is not None:
            return []
        rows: list[str] = []
        for name, value in self.relaxed.items():
            asked = getattr(self.requirements, name)
            unit = display_unit(UNITS[name], [value, asked])
            ratio = value / asked
            words = "at least" if name == "envelope" else "at most"
            now, before = (f"{number(unit(one))} {unit.label}" for one in (value, asked))
            change = f"{100 * abs(ratio - 1):.3g} % {'more' if ratio > 1 else 'less'}"
            if ratio > 1 / _LEAST:
                change = f"{number(ratio, 3)} times as much"
            elif ratio < _LEAST:
                change = f"{number(100 * ratio, 3)} % of it"
            rows.append(f"{name}: {words} {now} instead of {before} ({change})")
        if not rows:
            rows.append("no requirement alone is enough: relax the load and the envelope together")
        return rows


def dimension(
    load: float, stroke: float, speed: float, life: float, envelope: float
) -> Dimensioning:
    """Find the smallest size of the catalogue that meets five requirements.

    Sizes are those of `prsm_jax.catalogue_sizes`, with the capacities, the buckling load and the
    critical speed of their mechanisms. A size fits if the nut fits into the envelope, its rating
    life by the dynamic capacity is as long as required (truncated contacts last longer under lower
    loads), its static capacity and its buckling load are twice the load or more, the screw turns at
    no more than 0.8 of its critical speed, and its DN value is 100,000 mm rpm or less (grease). The
    screw is fixed at one end and supported at the other; between the bearings it is longer than
    stroke and nut by two diameters. Of the sizes that fit, the one with the smallest nut is taken;
    of its leads those whose contact ellipses stay on the flanks under the load, if there are any,
    and of these the smallest, which needs the least torque.

    **Arguments:**

    - `load`, `stroke`, `speed`, `life`, `envelope`: as in `Requirements` [N, m, m/s, s, m].

    **Returns:** a `Dimensioning`.

    **Raises:** `ValueError` for a number that is not above 0.
    """
    wanted = Requirements(load, stroke, speed, life, envelope)
    sizes = all_sizes()
    found = margins(sizes, wanted)
    usable = np.flatnonzero(fits(found))
    if not usable.size:
        return Dimensioning(wanted, None, None, {}, relaxations(sizes, wanted), len(sizes.rows))
    cut = sizes.truncation_load[usable] < wanted.load
    keys = (sizes.lead[usable], cut, sizes.diameter[usable], sizes.nut_diameter[usable])
    order = np.lexsort(keys)
    place = int(usable[order[0]])
    row = sizes.rows[place]
    own = {name: float(values[place]) for name, values in found.items()}
    return Dimensioning(wanted, row, _mechanism(row, wanted), own, {}, len(sizes.rows))


def _mechanism(row: dict[str, float], wanted: Requirements) -> Mechanism:
    """The mechanism of a size, with its operating point, its shaft and the required life."""
    mechanism = size_mechanism(row)
    (stage,) = mechanism.stages
    assert stage.strength is not None
    assert stage.strength.shaft is not None
    diameter, nut_length = row["nominal_diameter_mm"] * 1e-3, float(stage.nut.length)  # pyright: ignore[reportArgumentType]
    shaft = dataclasses.replace(
        stage.strength.shaft,
        unsupported_length=unsupported_length(wanted.stroke, nut_length, diameter),
        loaded_length=loaded_length(wanted.stroke, nut_length),
        permissible_speed_share=SPEED_SHARE,
        dn_limit=DN_LIMIT,
    )
    strength = dataclasses.replace(stage.strength, required_life=wanted.life, shaft=shaft)
    length = screw_length(wanted.stroke, nut_length, diameter)
    screw = dataclasses.replace(stage.screw, length=length)
    stage = dataclasses.replace(stage, strength=strength, screw=screw)
    turning = 2 * math.pi * wanted.speed / (row["lead_mm"] * 1e-3)
    point = OperatingPoint(turning, wanted.load, _duration(stage, turning, wanted.load))
    return dataclasses.replace(mechanism, stages=(stage,), operating_point=point)


def _duration(stage: Stage, speed: float, load: float) -> float:
    """Duration of a transient in which the carriers settle after a step to a speed [s].

    Thread friction gives the rollers, in the time that is estimated, the angular momentum of a
    carrier that turns at r_S/(2 (r_S + r_R)) of the screw's speed. They settle a little sooner,
    because friction at the nut turns them too; three times as long shows it.
    """
    assert stage.material is not None
    assert stage.friction is not None
    assert isinstance(stage.friction.thread, CoulombFriction)
    assert stage.material.density is not None
    assert stage.roller.length is not None
    radius, density = float(stage.thread.roller_radius), float(stage.material.density)
    volume = math.pi * radius**2 * float(stage.roller.length)
    mass = float(stage.roller_count) * density * volume
    friction = float(stage.friction.thread.coefficient) * load
    orbit = float(stage.thread.screw_radius) + radius
    least = 3 * mass * orbit * speed / (2 * friction)
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= least)
