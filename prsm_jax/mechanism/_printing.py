"""What `print` shows of a mechanism: the main numbers of its stages, and which parts it has."""

import re
from collections.abc import Callable, Iterator
from typing import Any

import equinox as eqx
import numpy as np

from ..fields import declared
from ..text import Line

#: Parts of a mechanism beside its stages, with what a user calls them.
_WHOLE = {"duty_cycle": "duty cycle", "scenario": "scenario", "tolerances": "tolerances"}


def lines_of_mechanism(mechanism: Any) -> tuple[tuple[int, ...], list[Line]]:
    """Shape of the batch of designs, and the lines.

    **Arguments:**

    - `mechanism`: the mechanism, or a tree of its structure, such as a derivative.
    """
    stages = mechanism.stages
    shapes = [np.shape(number) for stage in stages for number in vars(stage.thread).values()]
    shape = np.broadcast_shapes(*shapes)
    lines = list(_of_stages(stages))
    unusual = _out_of_range(stages)
    if unusual:
        # `jax.grad` returns a mechanism of derivatives: 1/m is then not 1000/mm.
        lines = [Line(one.label, one.value, "") for one in lines]
        note = f"{', '.join(unusual)}: out of range; so this may be a derivative, and has no units"
        lines.insert(0, Line("note", note))
    head = [Line("title", mechanism.title)] if mechanism.title else []
    if mechanism.operating_point is not None and not unusual:
        point = mechanism.operating_point
        head += [Line("speed", point.speed, "rad/s"), Line("load", point.load, "N")]
    if len(stages) > 1:
        head.append(Line("stages", len(stages)))
    return shape, [*head, *lines, *_parts(mechanism)]


def _of_stages(stages: tuple[Any, ...]) -> Iterator[Line]:
    """Main numbers; where there are several stages, of one after the other."""
    rows: tuple[tuple[str, str, Callable[[Any], Any]], ...] = (
        ("lead", "m", lambda s: s.thread.lead),
        ("starts", "1", lambda s: s.thread.starts),
        ("screw diameter", "m", lambda s: 2 * np.subtract(s.thread.starts, 2) * _radius(s)),
        ("roller diameter", "m", lambda s: 2 * _radius(s)),
        ("nut diameter", "m", lambda s: 2 * np.asarray(s.thread.starts) * _radius(s)),
        ("contact angle", "rad", lambda s: s.thread.contact_angle),
        ("rollers", "1", lambda s: s.present_roller_count),
        ("engaged threads", "1", lambda s: s.engaged_threads),
        ("screw length", "m", lambda s: s.screw.length),
        ("roller length", "m", lambda s: s.roller.length),
        ("nut length", "m", lambda s: s.nut.length),
        ("teeth of the roller", "1", lambda s: s.gear and s.gear.roller_teeth),
    )
    for label, unit, number in rows:
        values = [number(stage) for stage in stages]
        known = [np.asarray(value) for value in values if value is not None]
        if len(known) == len(values):
            yield Line(label, np.stack(np.broadcast_arrays(*known), -1), unit)
        elif known:
            yield Line(label, ", ".join(Line("", value, unit).text for value in values))


def _radius(stage: Any) -> np.ndarray:
    return np.asarray(stage.thread.roller_radius)


def _out_of_range(stages: tuple[Any, ...]) -> list[str]:
    """Numbers of the threads that no mechanism can have; NaN stands for a number to be set."""
    names: list[str] = []
    for stage in stages:
        for one in declared(type(stage.thread)):
            value = getattr(stage.thread, one.name)
            known = [] if value is None else np.ravel(value).tolist()
            if any(not one.limit.admits(x) and x == x for x in known):
                names.append(one.name.replace("_", " "))
    return list(dict.fromkeys(names))


def _parts(mechanism: Any) -> Iterator[Line]:
    names: list[str] = []
    for stage in mechanism.stages:
        law = stage.thread_law
        if law is not None:
            yield Line("thread friction", _words(type(law)))
        names += [
            one.name.replace("_", " ")
            for one in declared(type(stage))
            if one.name != "thread" and _given(getattr(stage, one.name))
        ]
    if names:
        yield Line("parts", ", ".join(dict.fromkeys(names)))
    names = [words for name, words in _WHOLE.items() if getattr(mechanism, name) is not None]
    if mechanism.design_problem is not None:
        names.append("design problem")
    if names:
        yield Line("with", ", ".join(names))


def _words(cls: type) -> str:
    """Words of a class: "coulomb friction"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", cls.__name__).lower()


def _given(part: Any) -> bool:
    """Whether a part of a stage is there, and has any numbers of its own."""
    if isinstance(part, tuple):
        return bool(part)
    return isinstance(part, eqx.Module) and any(
        value is not None for value in vars(part).values() if not isinstance(value, str)
    )
