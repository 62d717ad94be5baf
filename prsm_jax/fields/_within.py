"""Numbers known at construction are checked against the limits that apply to files.

A traced number is not known, and passes; so does NaN, which stands for a number to be set later.
`jax.tree`, `eqx.tree_at` and transformations build modules without `__init__`, and so
without these checks.
"""

import dataclasses
from typing import Any

import equinox as eqx
import jax.core
import numpy as np

from ._limits import Limit, limit_of

#: Some published models lead to a negative stiffness: `check` reports it, files refuse it.
FREE_UNITS = ("N/m",)
_EXAMPLES = {
    "m": "numbers in Python are in metres: 10 mm is 10e-3",
    "rad": "numbers in Python are in radians: 45 deg is math.radians(45)",
}


class Contradiction(ValueError):
    """Two numbers of a stage exclude each other; `place` is the path of the one to change."""

    def __init__(self, place: tuple[str, ...], value: float, message: str):
        super().__init__(f"{'.'.join(place)} is {value:.6g} m; it {message}")
        self.place = place
        self.message = message


def _known(value: object) -> np.ndarray | None:
    """A number or list of numbers as an array, if all of it is known; else `None`."""
    if value is None or callable(value) or isinstance(value, jax.core.Tracer):
        return None
    try:
        return np.asarray(value, float)
    except (TypeError, ValueError):
        return None


def check_number(
    owner: str, name: str, unit: str, value: object, declared: Limit | None = None
) -> None:
    """Refuse a known number that is out of its range.

    **Arguments:**

    - `owner`: the object it belongs to, for the message.
    - `name`: of the field or parameter.
    - `unit`: its SI unit.
    - `value`: the number or numbers; traced ones and NaN pass.
    - `declared`: the limit that its field declares, if any.

    **Raises:** `ValueError` with name, value, what is allowed, and what to do.
    """
    known = _known(value)
    if known is None or unit in FREE_UNITS:
        return
    limit = limit_of(unit, declared)
    for one in known.ravel().tolist():
        if one == one and not limit.admits(one):
            text = f"{one:.6g} {unit}" if unit not in ("1", "*") else f"{one:.6g}"
            hint = _EXAMPLES.get(unit, "" if unit in ("1", "*") else f"give it in {unit}")
            words = f"{owner}{name} is {text}; it must be {limit.allowed}"
            raise ValueError(f"{words}; {hint}" if hint else f"{words}; change {name}")


class Limited(eqx.Module):
    """A part of a mechanism whose numbers are checked when it is made.

    **Raises:** `ValueError` at construction for a known number out of its range.
    """

    def __check_init__(self) -> None:
        for field in dataclasses.fields(self):
            unit = field.metadata.get("unit")
            if unit is not None:
                check_number(
                    f"{type(self).__name__}: ",
                    field.name,
                    unit,
                    getattr(self, field.name),
                    field.metadata.get("limit"),
                )


def _scalar(value: object) -> float | None:
    """A single number that is known, as a Python float; it starts no compiler."""
    known = _known(value)
    return None if known is None or known.ndim or np.isnan(known) else float(known)


def _below(part: object, body: str, key: str, limit: float | None, meaning: str) -> None:
    value = _scalar(getattr(part, key, None))
    if value is not None and limit is not None and not value < limit:
        raise Contradiction((body, key), value, f"must be less than {meaning}, {_mm(limit)}")


def _mm(value: float) -> str:
    return f"{value * 1e3:.6g} mm"


def check_stage(stage: Any) -> None:
    """Check relations between the numbers of a stage, such as a bore inside its cylinder.

    **Arguments:**

    - `stage`: a `Stage`; numbers that are traced or NaN are left out.

    **Raises:** `Contradiction` at the first number that does not fit the others.
    """
    roller_radius, starts = _scalar(stage.thread.roller_radius), _scalar(stage.thread.starts)
    if roller_radius is not None and starts is not None:
        screw_radius = (starts - 2) * roller_radius
        circle = 2 * (screw_radius + roller_radius)
        meaning = "twice the radius of the circle of the roller axes"
        _below(stage.screw, "screw", "bore_radius", screw_radius, "the screw's nominal radius")
        _below(stage.carrier, "carrier", "radial_width", circle, meaning)
    _below(stage.roller, "roller", "bore_radius", roller_radius, "the roller's nominal radius")
    shaft = None if stage.strength is None else stage.strength.shaft
    root = None if shaft is None else _scalar(shaft.root_radius)
    bore_radius = stage.screw.bore_radius
    bore = 0.0 if bore_radius is None else _scalar(bore_radius)
    if root is not None and bore is not None and not root > bore:
        message = f"must be more than the screw's bore_radius, {_mm(bore)}"
        raise Contradiction(("strength", "shaft", "root_radius"), root, message)
    line = stage.line_contact
    if line is not None:
        for body in ("screw", "roller"):
            meaning = f"{body}_major_radius"
            major = _scalar(getattr(line, meaning))
            _below(line, "line_contact", f"{body}_minor_radius", major, meaning)
