"""The rows of the matrix: extremes one by one, seeded combinations, and numbers that are none."""

import dataclasses
import math
from typing import Any

import numpy as np

from .numbers import Change, Number

#: Seed of the combinations; `--seed` takes another.
SEED = 14
#: Combinations of a full run.
COMBINATIONS = 300


@dataclasses.dataclass(frozen=True)
class Row:
    """One extreme or one combination of several.

    - `group`: `single`, `combination` or `number`.
    - `number`, `offered`: the leaf that a row of the group `number` spoils, and by what.
    - `precision`: `float64`, or `float32` where the program runs in single precision.
    """

    name: str
    group: str
    changes: tuple[Change, ...]
    number: str = ""
    offered: str = ""
    precision: str = "float64"

    def as_json(self) -> dict[str, Any]:
        """What a file needs to know of it."""
        return {
            "name": self.name,
            "group": self.group,
            # NaN and infinity are no JSON.
            "changes": [[c.pattern, c.how, repr(c.value)] for c in self.changes],
        }


def _set(pattern: str, *values: float) -> list[tuple[Change, ...]]:
    return [(Change(pattern, "set", value),) for value in values]


def _times(pattern: str, *factors: float) -> list[tuple[Change, ...]]:
    return [(Change(pattern, "times", factor),) for factor in factors]


_DEGREE = math.pi / 180
_ALL_SUPPORTS = ("support.radial_stiffness", "support.radial_stiffness_y")
_ALL_SUPPORTS = (*_ALL_SUPPORTS, "support.torsional_stiffness")


def _supports(factor: float) -> tuple[Change, ...]:
    return tuple(Change(pattern, "times", factor) for pattern in _ALL_SUPPORTS)


def _masses(factor: float) -> tuple[Change, ...]:
    return (
        Change("density", "times", factor),
        Change("mass", "times", factor),
        Change("inertia", "times", factor),
    )


def _scaled(size: float) -> tuple[Change, ...]:
    """Every length of the thread in proportion."""
    names = ("lead", "roller_radius", "roller_profile_radius", "screw_addendum", "roller_addendum")
    return tuple(Change(f"thread.{name}", "times", size) for name in names)


#: One factor at a time, each at its ends and on the way.
_SINGLES: dict[str, list[tuple[Change, ...]]] = {
    "as it is": [()],
    "stiffness of all supports ×": [
        _supports(f) for f in (1e-12, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9, 1e12)
    ],
    "torsional support of the screw ×": _times(
        "screw.support.torsional_stiffness", 1e-12, 1e-6, 1e6, 1e12
    ),
    "radial support of the nut ×": _times("nut.support.radial_stiffness", 1e-12, 1e-6, 1e6, 1e12),
    "torsional support of the carrier ×": _times(
        "carrier.support.torsional_stiffness", 1e-12, 1e12
    ),
    "pins of the rollers ×": _times("roller.support.radial_stiffness", 1e-12, 1e-6, 1e6, 1e12),
    "supports without stiffness": [_supports(0.0)],
    "Young's modulus ×": _times("youngs_modulus", 1e-12, 1e-6, 1e-3, 1e3, 1e6, 1e12),
    "Poisson's ratio": _set("poisson_ratio", -0.999, 0.0, 0.4999, 0.5 - 1e-12),
    "density, masses and inertias ×": [_masses(f) for f in (1e-6, 1e-3, 1e3, 1e6)],
    "roller mass ×": _times("roller.mass", 1e-6, 1e6) + _times("roller.length", 1e-6, 1e6),
    "carrier inertia ×": _times("carrier.inertia", 1e-12, 1e-6, 1e6)
    + _times("carrier.length", 1e-6, 1e6),
    "lead": _set("thread.lead", 1e-6, 1e-5, 1e-4, 1e-3, 5e-3, 30e-3, 60e-3, 120e-3),
    "contact angle (deg)": [
        (Change("thread.contact_angle", "set", degrees * _DEGREE),)
        for degrees in (5, 10, 20, 30, 60, 70, 80, 85)
    ],
    "starts": _set("thread.starts", 2.0 + 1e-9, 2.1, 3.0, 8.0, 40.0),
    "roller radius": _set("thread.roller_radius", 1e-5, 1e-3, 2e-2, 0.5),
    "profile radius ×": _times(
        "thread.roller_profile_radius", 1e-4, 1e-2, 0.1, 0.5, 2.0, 10.0, 1e3, 1e6
    ),
    "all lengths of the thread ×": [_scaled(size) for size in (1e-6, 1e-3, 10.0)],
    "speed": _set("operating_point.speed", -157.0, -1e-3, 0.0, 1e-12, 1e-3, 1e5)
    + _set("scenario.speed", -100.0, 1e-3, 1.0, 1e5),
    "load": _set("operating_point.load", -12e3, 0.0, 1e-99, 1e-12, 1e-3, 1.0, 1e5, 1e6, 1e9)
    + _set("scenario.load", -7e3, 0.0, 1e-12, 1.0, 1e6),
    "thread friction": _set(
        "friction.thread.coefficient", 0.0, 1e-99, 1e-12, 1e-6, 0.3, 0.9, 0.999, 1.5
    ),
    "other friction ×": _times("thrust_bearing.coefficient", 0.0, 1e3)
    + _times("spline.coefficient", 0.0, 10.0)
    + _times("drag.torque", 0.0, 1e3)
    + _times("spin.coefficient", 0.0, 1e-12, 10.0)
    + _times("loss_factor", 0.0, 10.0),
    "duration": _set("scenario.duration", 1e-9, 1e-7, 1e-5, 1e-2, 1.0, 1e3, 1e6),
    "carrier ratio at the start": _set("initial_carrier_ratio", -1.0, 0.373694, 0.5, 100.0),
    "driving torque": _set("scenario.torque", -20.0, 0.0, 1.0, 13.0, 100.0, 1e4),
    "speed at the start": _set("scenario.initial_speed", -10.0, 0.0, 1e-9, 1e3),
    "swing of the speed": _set("speed.amplitude", 0.0, 99.0, 99.999999, 150.0)
    + _set("speed.frequency", 0.0, 1e-3, 1e4),
    "bristles ×": _times("bristle_stiffness", 1e-3, 1e3) + _times("bristle_damping", 1e-3, 1e3),
    "backlash": _set("load_sharing.backlash", 0.0, 1e-12, 1e-3),
    "pitch errors ×": _times("screw_pitch_error", 0.0, 1e-6, 10.0, 1e3),
    "teeth ×": _times("tooth.effective_length", 1e-6, 1e-3, 1e3, 1e6),
    "ends of the flanks ×": _times("addendum", 0.0, 1e-6, 0.1, 3.0)
    + [
        tuple(Change(f"{body}_addendum", "times", f) for body in ("screw", "roller"))
        for f in (1e-3, 0.1, 0.5, 2.0)
    ],
    "a roller's stiffness": [
        (Change("stiffness_factor", "set", 1 + gap),)
        for gap in (0.0, 1e-16, 2.3e-16, 1e-14, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 1e6, -1 + 1e-6)
    ],
    "gap of two supports": [
        (Change("radial_stiffness_y", "set", 200e6 * (1 + gap)),)
        for gap in (0.0, 2.3e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1e3)
    ],
    "force ×": _times("force", 0.0, 1e-55, 1e-12, 1e12),
    "modulus ×": _times("modulus", 1e-12, 1e12),
    "A over B": [
        (
            Change("total", "set", 240.0 * (1 + ratio)),
            Change("difference_squared", "set", (240.0 * (1 - ratio)) ** 2),
        )
        for ratio in (1.0, 1 - 1e-15, 1 - 1e-12, 1 - 1e-8, 1 - 1e-4, 0.5, 1e-2, 1e-4, 1e-6, 1e-9)
    ],
    "curvatures ×": [
        (Change("total", "times", f), Change("difference_squared", "times", f**2))
        for f in (1e-6, 1e6)
    ],
}


def _label(name: str, changes: tuple[Change, ...]) -> str:
    if not changes:
        return name
    value = changes[0].value
    if "deg" in name:
        value = value / _DEGREE
    if name.startswith(("a roller", "gap")):
        base = 1.0 if name.startswith("a roller") else 200e6
        return f"{name} 1 + {value / base - 1:.3g}"
    if name == "A over B":
        return (
            f"{name} 1 - {1 - value / 240.0:.3g}" if value > 200 else f"A over B {value / 240:.3g}"
        )
    where = changes[0].pattern.rpartition(".")[0]
    return f"{name} {value:.6g}" + (f" ({where})" if where and len(changes) == 1 else "")


def singles() -> list[Row]:
    """The extremes one by one."""
    found: dict[str, Row] = {}
    for name, choices in _SINGLES.items():
        for changes in choices:
            label = _label(name, changes)
            found.setdefault(label, Row(label, "single", changes))
    return list(found.values())


def in_single_precision(rows: list[Row]) -> list[Row]:
    """The same rows, computed in float32."""
    return [
        dataclasses.replace(row, name=f"{row.name}, in float32", precision="float32")
        for row in rows
    ]


#: Ranges of the combinations: pattern, how, and the ends; log-uniform where both are positive.
_RANGES: tuple[tuple[str, str, float, float], ...] = (
    ("thread.lead", "set", 1e-6, 0.12),
    ("thread.contact_angle", "set", 5 * _DEGREE, 85 * _DEGREE),
    ("thread.starts", "set", 3.0, 12.0),
    ("thread.roller_radius", "times", 0.05, 20.0),
    ("thread.roller_profile_radius", "times", 0.02, 100.0),
    ("screw.support.radial_stiffness", "times", 1e-12, 1e12),
    ("screw.support.torsional_stiffness", "times", 1e-12, 1e12),
    ("nut.support.torsional_stiffness", "times", 1e-12, 1e12),
    ("ring_gear.support.radial_stiffness", "times", 1e-12, 1e12),
    ("radial_stiffness_y", "times", 1e-3, 1e3),
    ("stiffness_factor", "times", 1e-3, 1e3),
    ("mass_factor", "times", 1e-3, 1e3),
    ("roller.support.radial_stiffness", "times", 1e-6, 1e6),
    ("youngs_modulus", "times", 1e-6, 1e6),
    ("poisson_ratio", "set", 0.01, 0.499),
    ("density", "times", 1e-6, 1e6),
    ("roller.mass", "times", 1e-3, 1e3),
    ("roller.inertia", "times", 1e-3, 1e3),
    ("carrier.inertia", "times", 1e-3, 1e3),
    ("roller.length", "times", 1e-3, 1e3),
    ("screw.length", "times", 1e-2, 1e2),
    ("operating_point.speed", "set", 1e-3, 1e5),
    ("operating_point.load", "set", 1e-3, 1e6),
    ("scenario.speed", "set", 1e-3, 1e5),
    ("scenario.load", "set", 1e-3, 1e6),
    ("scenario.duration", "set", 1e-9, 1e6),
    ("initial_carrier_ratio", "set", 1e-3, 1e3),
    ("scenario.torque", "set", 1e-3, 1e3),
    ("scenario.initial_speed", "set", 1e-3, 1e3),
    ("speed.amplitude", "set", 1e-3, 300.0),
    ("speed.frequency", "set", 1e-2, 1e4),
    ("friction.thread.coefficient", "set", 1e-6, 1.2),
    ("thrust_bearing.coefficient", "set", 1e-6, 0.5),
    ("spline.coefficient", "set", 1e-6, 0.5),
    ("spin.coefficient", "set", 1e-6, 0.5),
    ("loss_factor", "set", 1e-6, 0.5),
    ("bristle_stiffness", "times", 1e-2, 1e2),
    ("load_sharing.backlash", "set", 1e-9, 1e-4),
    ("screw_pitch_error", "times", 1e-3, 1e3),
    ("tooth.effective_length", "times", 1e-3, 1e3),
    ("thread.screw_addendum", "times", 1e-2, 3.0),
    ("thread.roller_addendum", "times", 1e-2, 3.0),
    ("force", "set", 1e-9, 1e12),
    ("total", "set", 162.0, 1e6),
    ("difference_squared", "times", 1e-9, 1.02),
    ("modulus", "times", 1e-9, 1e9),
)


def combinations(count: int, seed: int = SEED) -> list[Row]:
    """Random combinations: each range is taken with a chance that grows along the list."""
    random = np.random.default_rng(seed)
    found = []
    for index in range(count):
        # Mild ones too: with every factor extreme most designs are refused, and say little.
        chance = random.choice([0.15, 0.4, 0.8])
        width = random.choice([0.2, 1.0])
        changes = []
        for pattern, how, low, high in _RANGES:
            taken, place = random.uniform() < chance, random.uniform()
            if taken:
                middle = 0.0 if how == "times" else None
                logs = math.log(low), math.log(high)
                place = logs[0] + place * (logs[1] - logs[0])
                if middle is not None:
                    place = place * width
                changes.append(Change(pattern, how, math.exp(place)))
        found.append(Row(f"combination {index + 1}", "combination", tuple(changes)))
    return found


#: What every number is replaced by.
OFFERED = {"NaN": math.nan, "infinity": math.inf, "zero": 0.0, "negative": -1.0}


def spoiled(numbers: tuple[Number, ...]) -> list[Row]:
    """NaN, infinity, zero and its negative in every number, one at a time."""
    found = []
    for number in numbers:
        for offered, value in OFFERED.items():
            how = "times" if offered == "negative" else "set"
            found.append(
                Row(
                    f"{number.name}: {offered}",
                    "number",
                    (Change(number.name, how, value),),
                    number.name,
                    offered,
                )
            )
    return found


def admitted(number: Number, value: float) -> bool:
    """Whether a number may have a value, as files are read."""
    return number.limit.admits(float(value))
