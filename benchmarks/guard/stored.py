"""The file of stored numbers."""

import dataclasses
import datetime
import math
from pathlib import Path
from typing import Any

from ..harness import machine, read_json, write_json
from .compared import Numbers

#: Renewed by `--store`.
STORED = Path(__file__).with_name("stored.json")
_GROUPS = tuple(one.name for one in dataclasses.fields(Numbers))


def read_stored(path: Path = STORED) -> dict[str, tuple[Numbers, int]]:
    """For each benchmark its stored numbers, and the cores of the machine they were measured on."""
    if not path.exists():
        return {}
    return {
        name: (
            Numbers(**{
                # null is an error that is not finite.
                group: {k: math.inf if v is None else v for k, v in one.get(group, {}).items()}
                for group in _GROUPS
            }),
            one["cores"],
        )
        for name, one in read_json(path)["benchmarks"].items()
    }  # fmt: skip


def store(name: str, numbers: Numbers, path: Path = STORED) -> None:
    """Store the numbers of one benchmark, and leave those of all others."""
    benchmarks: dict[str, Any] = {}
    if path.exists():
        benchmarks = read_json(path)["benchmarks"]
    groups = {group: getattr(numbers, group) for group in _GROUPS}
    benchmarks[name] = {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "cores": machine()["cores"],
        **{
            group: {label: _short(value) for label, value in members.items()}
            for group, members in groups.items()
            if members
        },
    }
    content = {"schema": 1, "benchmarks": dict(sorted(benchmarks.items()))}
    write_json(path, content, allow_nan=False)


def _short(value: float) -> float | int | None:
    if not math.isfinite(value):
        return None
    return value if isinstance(value, int) else float(f"{value:.3g}")
