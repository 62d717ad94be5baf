"""Profiles, duty cycles and measurements as CSV tables: header cells `name [unit]`, in and out."""

import csv
import dataclasses
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from .._errors import FileError, closest, missing_extra
from ..calibration import Measurements
from ..fields import ANY, NOT_NEGATIVE, POSITIVE, Limit
from ..file.numbers import CsvColumn, csv_column, csv_heading, csv_number, csv_rows, one_line
from ..mechanism import DutyCycle, Mechanism, find_parameters
from ..process import whole_file
from ..quantities import quantity_of
from ..scenario import Scenario, TableProfile, TorqueScenario, depends_on_motion

_MOTION: dict[str, tuple[str, Limit]] = {
    "time": ("s", NOT_NEGATIVE),
    "speed": ("rad/s", ANY),
    "torque": ("N·m", ANY),
    "load": ("N", ANY),
}
_PHASES: dict[str, tuple[str, Limit]] = {
    "duration": ("s", POSITIVE),
    "speed": ("rad/s", ANY),
    "load": ("N", ANY),
}
_SAMPLES = 201


def read_scenario(
    path: str | os.PathLike[str], *, samples: int = _SAMPLES
) -> Scenario | TorqueScenario:
    """Read a drive and a load over time from a CSV file, such as a recorded mission.

    Columns are `time`, `load` and one of `speed` and `torque`, each with its unit in the header,
    such as `time [s], speed [rpm], load [kN]`. Between rows the numbers change linearly. Lines that
    begin with `#` are comments; cells are separated by commas or semicolons.

    **Arguments:**

    - `path`: the file.
    - `samples`: number of times in the result of a simulation.

    **Returns:** a scenario that ends at the last time.

    **Raises:** `FileError`, with one line that names file, row, column and remedy.
    """
    columns = _read(path, _MOTION, increasing="time")
    name = one_line(str(path), 300)
    drives = [one for one in ("speed", "torque") if one in columns]
    if len(drives) != 1 or not {"time", "load"} <= set(columns):
        raise FileError(
            f"{name}: has the columns {', '.join(columns)}; a scenario needs time, load, and one "
            "of speed and torque"
        )
    if len(columns["time"]) < 2:
        raise FileError(f"{name}: has one row of numbers; a scenario needs two or more")
    try:
        times = columns["time"]
        drive, load = (TableProfile(times, columns[one]) for one in (drives[0], "load"))
        if drives[0] == "torque":
            return TorqueScenario(drive, load, times[-1], samples=samples)
        return Scenario(drive, load, times[-1], samples=samples)
    except ValueError as error:
        raise FileError(f"{name}: {error}") from error


def write_scenario(path: str | os.PathLike[str], scenario: Scenario | TorqueScenario) -> Path:
    """Write drive and load over time to a CSV file in SI that `read_scenario` reads back.

    Linear tables are written at their own times, and are read back exactly; all else is written at
    the times of the result of a simulation.

    **Arguments:**

    - `path`: the file; it is complete or, if anything fails, as before.
    - `scenario`: the scenario; its load does not depend on the motion of the nut. The state at the
      start and `most_phases` have no place in the file, and must be those of the default;
      `read_scenario` is given `samples`.

    **Returns:** the path.

    **Raises:** `ValueError` for a load that depends on the motion, and for numbers that the file
    cannot hold.
    """
    if depends_on_motion(scenario.load):
        raise ValueError(
            "the load depends on the motion of the nut, so it is no function of time; simulate the "
            "scenario and write the load of the run (export_result)"
        )
    _refuse_lost(scenario)
    torque = isinstance(scenario, TorqueScenario)
    drive = scenario.torque if torque else scenario.speed
    functions = [one for one in (drive, scenario.load) if callable(one)]
    end = float(scenario.duration)
    if all(isinstance(one, TableProfile) and one.interpolation == "linear" for one in functions):
        own = [np.asarray(one.times) for one in functions if isinstance(one, TableProfile)]
        times = np.unique(np.concatenate([[0.0, end], *own]))
        times = times[times <= end]
    else:
        times = np.linspace(0.0, end, scenario.samples)

    def column(function) -> np.ndarray:
        if callable(function):
            return np.asarray(jax.vmap(function)(jnp.asarray(times)))
        return np.full_like(times, float(function))

    values = {"time": times, "torque" if torque else "speed": column(drive)}
    return _write(path, values | {"load": column(scenario.load)}, _units_of(_MOTION))


def _refuse_lost(scenario: Scenario | TorqueScenario) -> None:
    """Refuse numbers other than the default that a table over time does not hold."""
    defaults: dict[str, Any] = {one.name: one.default for one in dataclasses.fields(scenario)}
    lost = [
        f"{name} is {float(getattr(scenario, name)):g} in place of {float(default):g}"
        for name, default in defaults.items()
        if name.startswith("initial_") or name == "most_phases"
        if float(getattr(scenario, name)) != default
    ]
    if lost:
        raise ValueError(
            f"{type(scenario).__name__}: {', '.join(lost)}, which a table over time cannot hold; "
            "replace it by the default and set it after reading, or write the whole mechanism "
            "(prsm_jax.dump, prsm export --as toml)"
        )


def read_duty_cycle(path: str | os.PathLike[str]) -> DutyCycle:
    """Read a duty cycle from a CSV file: a row for each phase of constant speed and load.

    **Arguments:**

    - `path`: the file, with the columns `duration`, `speed` and `load` and their units in the
      header, such as `duration [s], speed [rpm], load [kN]`.

    **Raises:** `FileError`, with one line that names file, row, column and remedy.
    """
    columns = _read(path, _PHASES)
    if missing := [one for one in _PHASES if one not in columns]:
        raise FileError(
            f"{one_line(str(path), 300)}: has no column {', '.join(missing)}; a duty cycle needs "
            f"{', '.join(_PHASES)}"
        )
    return DutyCycle(**columns)


def write_duty_cycle(path: str | os.PathLike[str], cycle: DutyCycle) -> Path:
    """Write a duty cycle to a CSV file in SI that `read_duty_cycle` reads back exactly.

    **Arguments:**

    - `path`: the file; it is complete or, if anything fails, as before.
    - `cycle`: the duty cycle.

    **Returns:** the path.
    """
    return _write(path, {one: getattr(cycle, one) for one in _PHASES}, _units_of(_PHASES))


def write_measurements(
    path: str | os.PathLike[str], measured: Measurements, mechanism: Mechanism
) -> Path:
    """Write measurements to a CSV file in SI that `read_measurements` reads back exactly.

    **Arguments:**

    - `path`: the file; it is complete or, if anything fails, as before.
    - `measured`: the measurements.
    - `mechanism`: the mechanism that the conditions belong to.

    **Returns:** the path.
    """
    units = {name: quantity_of(name).unit for name in measured.values}
    units |= {name: find_parameters(mechanism, name)[0].unit for name in measured.conditions}
    return _write(path, {**measured.values, **measured.conditions}, units)


def _units_of(columns: Mapping[str, tuple[str, Limit]]) -> dict[str, str]:
    return {name: unit for name, (unit, _) in columns.items()}


def _read(
    path: str | os.PathLike[str],
    known: Mapping[str, tuple[str, Limit]],
    increasing: str | None = None,
) -> dict[str, np.ndarray]:
    """Columns of a table of known names [SI]; the numbers of one of them may have to increase."""
    source, name = Path(path), one_line(str(path), 300)
    if not source.is_file():
        raise FileError(f"{name}: there is no such file; give a CSV file")
    try:
        (number, header), *body = csv_rows(source, name)
        columns = []
        for cell in header:
            place = f"{name}: row {number}"
            heading, unit = csv_heading(cell, place, "time [s]")
            if heading not in known:
                raise FileError(f"{place}, column {heading}: unknown; {closest(heading, known)}")
            if heading in [one.name for one in columns]:
                raise FileError(f"{name}: column {heading} is there twice; remove one")
            columns.append(csv_column(heading, unit, *known[heading], place))
        rows = [
            [
                csv_number(cell, column, f"{name}: row {number}, column")
                for cell, column in zip(row, columns, strict=True)
            ]
            for number, row in body
        ]
    except ModuleNotFoundError as error:
        raise missing_extra("file", "reading units of a table", error) from error
    table = dict(zip([column.name for column in columns], np.array(rows).T, strict=True))
    if increasing is not None and increasing in table:
        _check_increasing(columns, table[increasing], body, increasing, name)
    return table


def _check_increasing(
    columns: list[CsvColumn],
    values: np.ndarray,
    body: list[tuple[int, list[str]]],
    heading: str,
    name: str,
) -> None:
    wrong = np.flatnonzero(np.diff(values) <= 0)
    if wrong.size:
        place = [column.name for column in columns].index(heading)
        unit = columns[place].unit
        # As they stand in the file, not in SI.
        before, after = (one_line(body[k][1][place], 40) for k in (wrong[0], wrong[0] + 1))
        raise FileError(
            f"{name}: row {body[wrong[0] + 1][0]}, column {heading}: {after} {unit} is not after "
            f"{before} {unit} in the row before; give increasing values"
        )


def _write(
    path: str | os.PathLike[str], columns: Mapping[str, ArrayLike], units: Mapping[str, str]
) -> Path:
    """A table; an empty cell where there is no number."""
    headings = [
        name if units[name] == "1" else f"{name} [{units[name].replace('·', ' ')}]"
        for name in columns
    ]
    rows = np.array([np.asarray(one, float) for one in columns.values()]).T.tolist()
    target = Path(path)
    with (
        whole_file(target) as partial,
        partial.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file)
        writer.writerow(headings)
        writer.writerows([["" if cell != cell else cell for cell in row] for row in rows])
    return target
