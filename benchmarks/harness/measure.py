"""Error and run time of every method of a problem, rivals interleaved in the same run."""

import gc
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import jax
import numpy as np

from .case import Kind, Prepared, Problem, Reference


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


def measure(problem: Problem, budget: Budget) -> list[Measurement]:
    """Measure all methods of a problem at all their settings.

    The first call compiles and is reported apart. Then samples are taken in rounds, one of every
    method in each round and every second round backwards, so that whatever else the machine does
    falls on rivals alike. Ratios compare samples of the same round.

    **Raises:** `ValueError` if a method gives other quantities than the reference.
    """
    reference = problem.reference()
    entries: list[tuple[Prepared, int, int]] = []
    measured: list[Measurement] = []
    for method in problem.methods:
        for setting in method.settings:
            prepared = method.prepare(setting)
            start = time.perf_counter()
            result = jax.block_until_ready(prepared.call())
            first_call = time.perf_counter() - start
            errors = _errors(prepared.read(result), reference, problem.name, method.name)
            once = max(_timed(prepared, 1), 1e-9)
            calls = max(1, math.ceil(budget.sample_seconds / once))
            rounds = max(2, min(budget.rounds, int(budget.seconds / (once * calls))))
            entries.append((prepared, calls, rounds))
            measured.append(
                Measurement(
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
                )
            )
    _sample_in_rounds(entries, measured)
    for row in measured:
        row.samples = len(row.times)
        row.best, row.median = min(row.times), float(np.median(row.times))
    baselines = [row for row in measured if row.method == problem.baseline]
    for row in measured:
        baseline = _counterpart(row, baselines)
        shared = zip(baseline.times, row.times, strict=False)
        ratios = [theirs / ours for theirs, ours in shared]
        row.speed_ratio = float(np.median(ratios))
        row.ratio_range = (min(ratios), max(ratios))
    return measured


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
    entries: list[tuple[Prepared, int, int]], measured: list[Measurement]
) -> None:
    collecting = gc.isenabled()
    gc.disable()
    try:
        for round_number in range(max(rounds for _, _, rounds in entries)):
            order = list(zip(entries, measured, strict=True))
            for (prepared, calls, rounds), row in order[:: -1 if round_number % 2 else 1]:
                if round_number < rounds:
                    row.times.append(_timed(prepared, calls) / prepared.instances)
    finally:
        if collecting:
            gc.enable()
