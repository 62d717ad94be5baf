"""JSON and Markdown from measurements."""

import datetime
import importlib.metadata
import math
import os
import platform
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax

from ._atomic import write_json, write_text
from ._markdown import row_of, setting_text, table_of, time_text
from .case import Case, Problem
from .measure import ErrorSummary, Measurement

#: Raised by one when a key changes its meaning or goes; new keys do not raise it.
SCHEMA = 1

_PACKAGES = ("prsm-jax", "jax", "jaxlib", "diffrax", "equinox", "optimistix", "numpy", "scipy")
_PACKAGES = (*_PACKAGES, "mpmath", "numbalsoda", "casadi")

#: Measurements of one case, problem by problem.
Measured = Sequence[tuple[Problem, Sequence[Measurement]]]


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def machine() -> dict[str, Any]:
    """The machine without anything that names it: no host, no user, no paths."""
    affinity = getattr(os, "sched_getaffinity", None)
    return {
        "system": platform.system(),
        "processor": _processor(),
        "cores": len(affinity(0)) if affinity else os.cpu_count(),
        "devices": [f"{device.platform}: {device.device_kind}" for device in jax.devices()],
    }


def versions() -> dict[str, str]:
    """Of Python and of the packages that matter."""
    found = {"python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


def _setting(row: Measurement) -> dict[str, Any] | None:
    if row.setting is None:
        return None
    return {"name": row.setting_name, "value": row.setting}


def _result(row: Measurement, yardstick: float | None) -> dict[str, Any]:
    share = {} if yardstick is None else {"yardstick_share": 1 / row.best / yardstick}
    return share | {
        "method": row.method,
        "kind": row.kind,
        "default": row.default,
        "setting": _setting(row),
        "instances": row.instances,
        "samples": row.samples,
        "first_call_s": row.first_call,
        "best_s": row.best,
        "median_s": row.median,
        "per_second": 1 / row.best,
        "speed_ratio": row.speed_ratio,
        "speed_ratio_range": list(row.ratio_range),
        "errors": {
            quantity: {
                "max": error.maximum,
                "median": error.median,
                "compared": error.compared,
                "not_finite": error.not_finite,
                "instances": error.instances,
            }
            for quantity, error in row.errors.items()
        },
        "note": row.note,
    }


def cheapest(problem: Problem, rows: Sequence[Measurement]) -> list[Measurement]:
    """Of every method the fastest setting whose largest error reaches the problem's target."""

    target = math.inf if problem.target is None else problem.target

    def reaches(row: Measurement) -> bool:
        errors = [error.maximum for error in row.errors.values()]
        complete = all(error.not_finite == 0 for error in row.errors.values())
        return complete and all(e is not None and e <= target for e in errors)

    best: dict[str, Measurement] = {}
    for row in rows:
        if reaches(row) and (row.method not in best or row.best < best[row.method].best):
            best[row.method] = row
    return list(best.values())


def _at_equal_error(problem: Problem, rows: Sequence[Measurement]) -> dict[str, Any]:
    if problem.target is None:
        return {}
    found = cheapest(problem, rows)
    theirs = [row.best for row in found if row.method == problem.baseline]
    ratio = theirs[0] if theirs else None
    return {
        "at_equal_error": {
            "target": problem.target,
            "methods": [
                {
                    "method": row.method,
                    "setting": _setting(row),
                    "best_s": row.best,
                    "error": max(e.maximum or 0.0 for e in row.errors.values()),
                    "speed_ratio": None if ratio is None else ratio / row.best,
                }
                for row in found
            ],
        }
    }


def _equal_error_table(problem: Problem, rows: Sequence[Measurement]) -> list[str]:
    found = _at_equal_error(problem, rows).get("at_equal_error")
    if found is None:
        return []
    header = ["method", "setting", f"time per {problem.instance}", "largest error"]
    header.append(f"speed against {problem.baseline}")
    lines = [f"Cheapest settings with errors up to {problem.target:g}:", ""]
    lines += table_of(header)
    for row in found["methods"]:
        setting, ratio = row["setting"], row["speed_ratio"]
        cells = [
            row["method"],
            "" if setting is None else f"{setting['name']} {setting['value']:g}",
        ]
        cells += [time_text(row["best_s"]), f"{row['error']:.1e}"]
        lines.append(row_of([*cells, "" if ratio is None else f"{ratio:.3g}"]))
    return [*lines, ""]


def document(case: Case, measured: Measured, *, quick: bool) -> dict[str, Any]:
    """Everything that is known about one case, as JSON-able data (see `benchmarks/README.md`)."""
    return {
        "schema": SCHEMA,
        "case": case.name,
        "description": case.description,
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "quick": quick,
        "machine": machine(),
        "versions": versions(),
        "problems": [
            {
                "name": problem.name,
                "title": problem.title,
                "instance": problem.instance,
                "reference": problem.reference_note,
                "baseline": problem.baseline,
                "results": [_result(row, problem.yardstick) for row in rows],
                "left_out": [
                    {"method": name, "reason": reason} for name, reason in problem.left_out.items()
                ],
            }
            | _at_equal_error(problem, rows)
            for problem, rows in measured
        ],
    }


def _error(error: ErrorSummary, instances: int) -> str:
    if error.maximum is None or error.median is None:
        return "none finite"
    text = f"{error.maximum:.1e} / {error.median:.1e}"
    if error.instances < instances:
        text += f", first {error.instances} of {instances}"
    return text + (f" ({error.not_finite} not finite)" if error.not_finite else "")


def table(case: Case, measured: Measured) -> str:
    """The measurements of a case as Markdown."""
    lines = [f"# {case.name}", "", case.description, ""]
    for problem, rows in measured:
        quantities = list(rows[0].errors)
        header = ["method", "setting", f"time per {problem.instance} (best / median)"]
        header += ["per second", f"speed against {problem.baseline}"]
        if problem.yardstick is not None:
            header += [f"share of {problem.yardstick:.2g} per second"]
        header += [f"error in {name} (max / median)" for name in quantities]
        header += ["first call", "note"]
        lines += [f"## {problem.title}", "", f"Reference: {problem.reference_note}", ""]
        lines += table_of(header)
        for row in rows:
            cells = [
                row.method + (" (rival)" if row.kind == "rival" else ""),
                setting_text(row.setting_name, row.setting),
            ]
            cells += [f"{time_text(row.best)} / {time_text(row.median)}", f"{1 / row.best:.3g}"]
            cells += [
                f"{row.speed_ratio:.3g} ({row.ratio_range[0]:.3g} … {row.ratio_range[1]:.3g})"
            ]
            if problem.yardstick is not None:
                cells += [f"{100 / row.best / problem.yardstick:.2g} %"]
            cells += [_error(row.errors[name], row.instances) for name in quantities]
            cells += [time_text(row.first_call), row.note]
            lines.append(row_of(cells))
        for name, reason in problem.left_out.items():
            blank = [""] * (len(header) - 2)
            lines.append(row_of([f"{name} (rival)", *blank, f"left out: {reason}"]))
        lines += ["", *_equal_error_table(problem, rows)]
    return "\n".join(lines)


def write(case: Case, measured: Measured, folder: Path, *, quick: bool) -> tuple[Path, Path]:
    """Write `<case>.json` and `<case>.md`, each whole or not at all; returns their paths."""
    # NaN is not JSON: better an error here than a file that other programs refuse.
    content = document(case, measured, quick=quick)
    return (
        write_json(folder / f"{case.name}.json", content, allow_nan=False),
        write_text(folder / f"{case.name}.md", table(case, measured)),
    )
