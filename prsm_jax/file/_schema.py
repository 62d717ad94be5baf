"""The schema of a file, read from the classes of the mechanism.

A field of a class is a key of its table: a new field of the mechanism is a new key of the file,
with its unit, limit and description, without a second declaration. Only the differences between
pytree and file are written out: `[[stage]]`, `[[duty_cycle]]`, `[scenario]`, `[optimise]` and
`[tolerances]`.
"""

import dataclasses
from typing import Any

import numpy as np

from ..fields import declared
from ..mechanism import Axis, DutyCycle, Mechanism, OperatingPoint, Stage
from ..scenario import Scenario, TorqueScenario
from .numbers import Misplaced, Place, TableChoice, read_number
from .tables import (
    Key,
    design_problem,
    meaning,
    plain,
    read_keys,
    read_module,
    read_optimise,
    read_rows,
    read_text,
    read_tolerances,
    tolerances_of,
)


def _stages(value: Any, place: Place) -> tuple[Any, ...]:
    return read_rows(value, place, lambda row, at: read_module(TableChoice(Stage), row, at))


def _duty_cycle(value: Any, place: Place) -> DutyCycle:
    columns = {
        one.name: Key(plain(read_number, one.unit, one.limit), meaning(one))
        for one in declared(DutyCycle)
    }
    rows = read_rows(value, place, lambda row, at: read_keys(row, at, columns))
    lists: dict[str, Any] = {n: np.array([row[n] for row in rows], float) for n in columns}
    return DutyCycle(**lists)


def _scenario(data: Any, place: Place) -> Any:
    if not isinstance(data, dict):
        raise Misplaced((place, "must be a table of keys"))
    drives = {"speed": Scenario, "torque": TorqueScenario}
    given = [name for name in drives if name in data]
    if len(given) != 1:
        text = "both" if given else "none"
        raise Misplaced((place, f"needs either speed or torque; found {text}"))
    return read_module(TableChoice(drives[given[0]]), data, place)


_KEYS = {
    "title": Key(plain(read_text)),
    "author": Key(plain(read_text)),
    "revision": Key(plain(read_text)),
    "operating_point": Key(lambda v, at: read_module(TableChoice(OperatingPoint), v, at)),
    "axis": Key(lambda v, at: read_module(TableChoice(Axis), v, at)),
    "stage": Key(_stages, "stages, as [[stage]]"),
    "duty_cycle": Key(_duty_cycle),
    "optimise": Key(read_optimise),
    "scenario": Key(_scenario),
    "tolerances": Key(read_tolerances),
}


def mechanism_of(data: dict[str, Any]) -> Mechanism:
    """The mechanism that a file describes.

    **Raises:** `Misplaced` with the places of all errors.
    """
    content = read_keys(data, (), _KEYS)
    stages, optimise = content.pop("stage"), content.pop("optimise", None)
    tolerances = content.pop("tolerances", None)
    try:
        mechanism = Mechanism(stages, **content)
    except ValueError as error:
        raise Misplaced(((), str(error))) from error
    # The names in these tables can be looked up only once there is a mechanism.
    named: dict[str, Any] = {}
    if optimise is not None:
        named["design_problem"] = design_problem(optimise, mechanism)
    if tolerances is not None:
        named["tolerances"] = tolerances_of(tolerances, mechanism)
    return dataclasses.replace(mechanism, **named) if named else mechanism
