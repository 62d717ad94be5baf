"""Fields known at construction are checked against what their class declares, as in files.

A traced number is not known, and passes; so does NaN, which stands for a number to be set later.
`jax.tree`, `eqx.tree_at` and transformations build modules without `__init__`, and so
without these checks.
"""

import html
from typing import Any, ClassVar

import equinox as eqx
import jax.core
import numpy as np

from ._declared import Declared, declared
from ._limits import Limit
from ._printed import printed

#: Of more numbers, only the extremes are compared with a limit.
_MANY = 64
_EXAMPLES = {
    "m": "numbers in Python are in metres: 10 mm is 10e-3",
    "rad": "numbers in Python are in radians: 45 deg is math.radians(45)",
}


class Contradiction(ValueError):
    """Two numbers of a stage exclude each other; `place` is the path of the one to change."""

    def __init__(self, place: tuple[str, ...], value: float, message: str, unit: str = "m"):
        text = f"{value:.6g} {unit}" if unit != "1" else f"{value:.6g}"
        super().__init__(f"{'.'.join(place)} is {text}; it {message}")
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
    owner: str,
    name: str,
    unit: str,
    value: object,
    limit: Limit,
    *,
    description: str = "",
    to_come: bool = True,
) -> None:
    """Refuse a known number that is out of its range.

    **Arguments:**

    - `owner`: the object it belongs to, for the message.
    - `name`: of the field or parameter.
    - `unit`: its SI unit.
    - `value`: the number or numbers; traced ones pass.
    - `limit`: its limit.
    - `description`: what it is, for the message on a number that is not finite.
    - `to_come`: whether NaN passes, as a number to be set later.

    **Raises:** `ValueError` with name, value, what is allowed, and what to do.
    """
    known = _known(value)
    if known is None:
        return
    numbers = known.ravel()
    if numbers.size > _MANY and limit.zero_allowed:
        # NaN is the smallest if there is one, and is passed over by `fmin`.
        numbers = np.array([numbers.min(), np.fmin.reduce(numbers), np.fmax.reduce(numbers)])
    for one in numbers.tolist():
        if not (limit.admits(one) or (to_come and one != one)):
            named = unit not in ("1", "*")
            hint = _EXAMPLES.get(unit, f"give it in {unit}" if named else f"change {name}")
            if not np.isfinite(one) and description and named:
                hint = f"give the {description} in {unit}"
            text = f"{one:.6g} {unit}" if named else f"{one:.6g}"
            raise ValueError(f"{owner}{name} is {text}; it must be {limit.allowed}; {hint}")


def _check_list(owner: str, module: Any, one: Declared, values: Any) -> None:
    # In a batch of mechanisms the entries are the last axis.
    shape, length = np.shape(values), one.metadata["length"]
    count = shape[-1] if shape else 0
    if length:
        other = getattr(module, length)
        whole = np.ndim(other) == 0
        expected = other if whole else np.shape(other)[-1]
        if count != expected:
            raise ValueError(
                f"{owner}{one.name} has {count} number{'s' if count != 1 else ''}, but {length} "
                f"{'is' if whole else 'has'} {expected}; give as many"
            )
    known, rising = _known(values), one.metadata["increasing"]
    falls = rising and known is not None and np.any(np.diff(known, axis=-1) <= 0)
    if count < one.least or falls:
        many = "two" if one.least == 2 else "one"
        kind = "values that increase" if rising else "numbers"
        raise ValueError(f"{owner}{one.name} is {values}; it must be {many} or more {kind}")


def _check_choice(owner: str, one: Declared, value: Any) -> None:
    if one.registered and callable(value):
        return _check_hashable(owner, one, value)
    if one.words and value not in one.words:
        raise ValueError(f"{owner}{one.name} is {value!r}; choose one of {', '.join(one.words)}")
    if one.whole:
        number = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if not (number and one.limit.admits(int(value))):
            raise ValueError(f"{owner}{one.name} is {value}; it must be {one.limit.allowed}")
    if one.static and one.hint is bool and not isinstance(value, bool | np.bool_):
        raise ValueError(f"{owner}{one.name} is {value!r}; it must be True or False")


def _check_hashable(owner: str, one: Declared, value: Any) -> None:
    try:
        hash(value)
    except TypeError as error:
        raise ValueError(
            f"{owner}{one.name} is a {type(value).__name__}, which is not hashable; give a "
            "function, or an object of a frozen dataclass with plain numbers"
        ) from error


def check_related(place: tuple[str, ...], value: object, limit: Limit) -> None:
    """Refuse known numbers out of a range that depends on other fields.

    **Arguments:**

    - `place`: path of the field.
    - `value`: the number or numbers; traced ones and NaN pass.
    - `limit`: its limit there.

    **Raises:** `Contradiction` with what is allowed.
    """
    known = _known(value)
    for one in () if known is None else known.ravel().tolist():
        if one == one and not limit.admits(one):
            raise Contradiction(place, one, f"must be {limit.words}", "1")


def check_fields(module: Any, *, to_come: bool = True) -> None:
    """Check known numbers, lists and choices of a part against what its class declares.

    **Arguments:**

    - `module`: the part.
    - `to_come`: whether NaN passes, as a number to be set later.

    **Raises:** `ValueError` with class, field, value, what is allowed, and what to do.
    """
    owner = f"{type(module).__name__}: "
    for one in declared(type(module)):
        value = getattr(module, one.name)
        if value is not None and one.unit is not None:
            if one.is_list:
                _check_list(owner, module, one, value)
            words = {"description": one.description, "to_come": to_come}
            check_number(owner, one.name, one.unit, value, one.limit, **words)
        elif value is not None and one.static:
            _check_choice(owner, one, value)


class Limited(eqx.Module):
    """A part of a mechanism whose fields are checked when it is made.

    `print` shows its numbers, in SI units.

    **Raises:** `ValueError` at construction for a known number out of its range, a list of a wrong
    length or order, and a word that is not among the choices.
    """

    #: Whether NaN passes, as a number to be set later.
    to_come: ClassVar[bool] = True

    def __check_init__(self) -> None:
        check_fields(self, to_come=self.to_come)

    def __str__(self) -> str:
        return printed(self)

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


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
    thread = stage.thread
    roller_radius, beyond = _scalar(thread.roller_radius), thread.family.ratio_beyond_starts
    ratio = _scalar(thread.radius_ratio if beyond is None else thread.starts)
    if roller_radius is not None and ratio is not None:
        screw_radius = (ratio + (beyond or 0) - 2) * roller_radius
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


def check_distances(axis: Any, screw: Any) -> None:
    """Check that the bearings and the nut of an axis lie on its screw, the nut between bearings.

    **Arguments:**

    - `axis`: an `Axis`; numbers that are traced or NaN are left out.
    - `screw`: its `Screw`.

    **Raises:** `Contradiction` at the first distance that does not fit.
    """
    shaft = axis.shaft
    if shaft is None:
        return
    end, meaning = _scalar(screw.length), "the screw's length (stage.screw.length)"
    if shaft.far_bearing is not None:
        far = _scalar(shaft.far_bearing.distance)
        if far is not None and end is not None and not far <= end:
            message = f"must be at most {meaning}, {_mm(end)}"
            raise Contradiction(("axis", "shaft", "far_bearing", "distance"), far, message)
        if far is not None:
            end, meaning = far, "the far bearing's distance"
    _below(shaft, "axis.shaft", "nut_distance", end, meaning)
