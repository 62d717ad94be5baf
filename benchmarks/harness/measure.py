"""Error and run time of every method of a problem, rivals interleaved in the same run."""

import gc
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import jax
import numpy as np

from .case import Kind, Method, Prepared, Problem, Reference


@dataclass(frozen=True)
class Budget:
    """How long to measure: at most `rounds` samples and about `seconds` for each setting.

    A sample repeats short calls until it lasts `sample_seconds`, so that the clock and the
    dispatch are not what is measured.
    """

    rounds: int
    seconds: float
    sample_seconds: float = 20e-3


FULL = Budget(rounds=15, seconds=1.0)
QUICK = Budget(rounds=5, seconds=0.15, sample_seconds=2e-3)
#: As few samples as there can be: whether a method runs, and how wrong it is.
SMOKE = Budget(rounds=2, seconds=0.0, sample_seconds=0.0)


@dataclass(frozen=True)
class ErrorSummary:
    """Largest and median error of one quantity; `None` where no value was finite."""

    maximum: float | None
    median: float | None
    #: How many numbers were compared, and how many of those were NaN or infinite.
    compared: int
    not_finite: int
    #: How many instances those numbers belong to; the errors say nothing of the others.
    instances: int = 0


@dataclass
class Measurement:
    """One method at one setting. Times are those of one instance [s]."""

    method: str
    kind: Kind
    setting_name: str
    setting: Any
    instances: int
    #: First call, compilation included [s, whole call].
    first_call: float
    best: float
    median: float
    samples: int
    #: Run time per instance of the baseline (at the same setting, if it has that) over that of
    #: this method: > 1 is faster.
    speed_ratio: float
    #: Smallest and largest of those ratios over the rounds.
    ratio_range: tuple[float, float]
    errors: dict[str, ErrorSummary]
    note: str = ""
    #: Whether this is what a user of the package gets without asking.
    default: bool = False
    #: Every sample, for the ratios.
    times: list[float] = field(default_factory=list, repr=False)


def summarise(values: Any, reference: Reference) -> ErrorSummary:
    """Errors of the instances that both sides have.

    **Raises:** `ValueError` if an instance does not have the shape of the reference's.
    """
    expected = np.asarray(reference.values, dtype=np.float64)
    found = np.asarray(values, dtype=np.float64)
    if found.shape[1:] != expected.shape[1:]:
        raise ValueError(
            f"an instance has the shape {found.shape[1:]}, in the reference {expected.shape[1:]}"
        )
    count = min(len(found), len(expected))
    expected, found = expected[:count], found[:count]
    scale = np.abs(expected) if reference.scale is None else np.asarray(reference.scale)
    if np.ndim(scale):
        scale = scale[:count]
    # A value that ought to be exactly zero is judged absolutely.
    scale = np.where(scale == 0, 1.0, scale)
    errors = np.abs(found - expected) / scale
    finite = errors[np.isfinite(errors)]
    return ErrorSummary(
        maximum=float(finite.max()) if finite.size else None,
        median=float(np.median(finite)) if finite.size else None,
        compared=errors.size,
        not_finite=errors.size - finite.size,
        instances=count,
    )


def _timed(prepared: Prepared, calls: int) -> float:
    start = time.perf_counter()
    for _ in range(calls):
        jax.block_until_ready(prepared.call())
    return (time.perf_counter() - start) / calls


def survivors(problem: Problem, budget: Budget) -> tuple[Problem, list[Measurement]]:
    """Measure a problem whose rivals may fail: what failed is left out of it, with the cause.

    **Returns:** the problem with those methods that can be shown, and their measurements. Rivals
    that failed at some or all of their settings are in `left_out`; where the baseline failed, the
    first method that did not takes its place.

    **Raises:** whatever a method of this package raises.
    """
    failed: dict[str, str] = {}
    rows = measure(problem, budget, failed)
    shown = {row.method for row in rows}
    methods = [method for method in problem.methods if method.name in shown]
    baseline = problem.baseline if problem.baseline in shown else methods[0].name
    left_out = {**problem.left_out, **failed}
    return replace(problem, methods=methods, baseline=baseline, left_out=left_out), rows


def _cause(error: BaseException) -> str:
    """Name and first sentence of an error, fit for a cell of a table."""
    words = " ".join(str(error).split()).replace("|", "/")
    return f"{type(error).__name__}: {words[:200]}" if words else type(error).__name__


def measure(
    problem: Problem, budget: Budget, failed: dict[str, str] | None = None
) -> list[Measurement]:
    """Measure all methods of a problem at all their settings.

    The first call compiles and is reported apart. Then samples are taken in rounds, one of every
    method in each round and every second round backwards, so that whatever else the machine does
    falls on rivals alike. Ratios compare samples of the same round.

    **Arguments:**

    - `problem`, `budget`: what to measure, and for how long.
    - `failed`: takes rivals that raise an error, by name and setting, with its cause; without it,
      and for the methods of this package, the error goes to the caller.

    **Raises:** `ValueError` if a method gives other quantities than the reference.
    """
    reference = problem.reference()
    entries: list[tuple[Prepared, int, int]] = []
    measured: list[Measurement] = []
    for method in problem.methods:
        for setting in method.settings:
            try:
                entry, row = _first(problem, method, setting, reference, budget)
            except Exception as error:
                if failed is None or method.kind != "rival":
                    raise
                failed[_with_setting(method, setting)] = f"failed: {_cause(error)}"
                continue
            entries.append(entry)
            measured.append(row)
    entries, measured = _sample_in_rounds(entries, measured, failed)
    for row in measured:
        row.samples = len(row.times)
        row.best, row.median = min(row.times), float(np.median(row.times))
    baselines = [row for row in measured if row.method == problem.baseline] or measured[:1]
    for row in measured:
        baseline = _counterpart(row, baselines)
        shared = zip(baseline.times, row.times, strict=False)
        ratios = [theirs / ours for theirs, ours in shared]
        row.speed_ratio = float(np.median(ratios))
        row.ratio_range = (min(ratios), max(ratios))
    return measured


def _with_setting(method: Method, setting: Any) -> str:
    return method.name if setting is None else f"{method.name}, {method.setting_name} {setting}"


def _first(
    problem: Problem,
    method: Method,
    setting: Any,
    reference: Mapping[str, Reference],
    budget: Budget,
) -> tuple[tuple[Prepared, int, int], Measurement]:
    """The first calls of a method at one setting: its errors, and how often to repeat it."""
    prepared = method.prepare(setting)
    start = time.perf_counter()
    result = jax.block_until_ready(prepared.call())
    first_call = time.perf_counter() - start
    errors = _errors(prepared.read(result), reference, problem.name, method.name)
    once = max(_timed(prepared, 1), 1e-9)
    calls = max(1, math.ceil(budget.sample_seconds / once))
    rounds = max(2, min(budget.rounds, int(budget.seconds / (once * calls))))
    row = Measurement(
        method=method.name,
        kind=method.kind,
        setting_name=method.setting_name,
        setting=setting,
        instances=prepared.instances,
        first_call=first_call,
        best=math.nan,
        median=math.nan,
        samples=0,
        speed_ratio=math.nan,
        ratio_range=(math.nan, math.nan),
        errors=errors,
        note=prepared.note(result),
        default=setting in method.defaults,
    )
    return (prepared, calls, rounds), row


def _counterpart(row: Measurement, baselines: list[Measurement]) -> Measurement:
    """The baseline at the same setting (the same tolerance), or at its first one."""
    same = (b for b in baselines if (b.setting_name, b.setting) == (row.setting_name, row.setting))
    return next(same, baselines[0])


def _errors(values: Mapping[str, Any], reference: Mapping[str, Reference], problem, method):
    if set(values) != set(reference):
        raise ValueError(
            f"problem {problem!r}, method {method!r}: gives {sorted(values)}, the reference has "
            f"{sorted(reference)}"
        )
    return {name: summarise(values[name], reference[name]) for name in reference}


def _sample_in_rounds(
    entries: list[tuple[Prepared, int, int]],
    measured: list[Measurement],
    failed: dict[str, str] | None,
) -> tuple[list[tuple[Prepared, int, int]], list[Measurement]]:
    """Take the samples; returns what has not failed meanwhile."""
    broken: set[int] = set()
    collecting = gc.isenabled()
    gc.disable()
    try:
        for round_number in range(max(rounds for _, _, rounds in entries)):
            order = list(zip(entries, measured, strict=True))
            for (prepared, calls, rounds), row in order[:: -1 if round_number % 2 else 1]:
                if round_number >= rounds or id(row) in broken:
                    continue
                try:
                    row.times.append(_timed(prepared, calls) / prepared.instances)
                except Exception as error:
                    if failed is None or row.kind != "rival":
                        raise
                    broken.add(id(row))
                    place = "" if row.setting is None else f", {row.setting_name} {row.setting}"
                    failed[row.method + place] = f"failed: {_cause(error)}"
    finally:
        if collecting:
            gc.enable()
    kept = [pair for pair in zip(entries, measured, strict=True) if id(pair[1]) not in broken]
    return [entry for entry, _ in kept], [row for _, row in kept]
