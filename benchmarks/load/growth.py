"""How fast something grows with the size of what is asked."""

from collections.abc import Sequence

import numpy as np

#: Growth is fitted to sizes up to so many times smaller than the largest: below, what a call costs
#: whatever its size hides it.
_RANGE = 150.0
#: Memory of the largest size that is less than this is what the process does anyway [bytes].
LEAST_MEMORY = 20e6


def exponent(sizes: Sequence[float], values: Sequence[float | None]) -> float | None:
    """p of `value ∝ size^p`, least squares of the logarithms; 1 is linear.

    `None` where fewer than two sizes have a value above zero.
    """
    pairs = [(s, v) for s, v in zip(sizes, values, strict=True) if v and s * _RANGE >= max(sizes)]
    if len(pairs) < 2:
        return None
    size, value = np.log(np.array(pairs)).T
    return float(np.polyfit(size, value, 1)[0])


def of_rows(rows: Sequence[dict]) -> dict[str, float | None]:
    """Exponents of run time and of memory; `None` for memory that does not rise above the rest."""
    sizes = [row["count"] for row in rows]
    memory = [row["run_bytes"] for row in rows]
    grows = memory[-1] is not None and memory[-1] > LEAST_MEMORY
    return {
        "time": exponent(sizes, [row["best_s"] for row in rows]),
        "memory": exponent(sizes, memory) if grows else None,
    }
