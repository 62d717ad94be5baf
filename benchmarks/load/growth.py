"""How fast something grows with the size of what is asked."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

#: Growth is fitted to sizes up to so many times smaller than the largest: below, what a call costs
#: whatever its size hides it.
_RANGE = 150.0


def exponent(sizes: Sequence[float], values: Sequence[float | None]) -> float | None:
    """p of `value ∝ size^p`, least squares of the logarithms; 1 is linear.

    `None` where fewer than two sizes have a value above zero.
    """
    largest = max(sizes, default=0.0)
    pairs = [(s, v) for s, v in zip(sizes, values, strict=True) if v and s * _RANGE >= largest]
    if len(pairs) < 2:
        return None
    size, value = np.log(np.array(pairs)).T
    return float(np.polyfit(size, value, 1)[0])


def finished(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Sizes with a finite result: how long one ran that did not end says nothing."""
    return [row for row in rows if row["error"] is not None and math.isfinite(row["error"])]


def of_rows(rows: Sequence[dict[str, Any]]) -> dict[str, float | None]:
    """Powers of the size with which operations, processor time and memory grow."""
    rows = finished(rows)
    sizes = [row["size"] for row in rows]
    keys = {"operations": "operations", "time": "processor_s", "memory": "run_bytes"}
    return {name: exponent(sizes, [row[key] for row in rows]) for name, key in keys.items()}
