"""Which rows of a problem are worth having: nothing of ours is faster and as accurate."""

from collections.abc import Sequence
from typing import Any

#: Times within this share of each other are the same: repeated runs differ by as much.
NOISE = 0.1

Row = dict[str, Any]


def error_of(row: Row) -> float | None:
    """The largest error of all quantities; `None` where a number is missing or not finite."""
    errors = list(row["errors"].values())
    if not errors or any(one["not_finite"] or one["max"] is None for one in errors):
        return None
    return max(one["max"] for one in errors)


def is_single(row: Row) -> bool:
    """Whether a call solves one instance."""
    return row["instances"] == 1


def is_ours(row: Row) -> bool:
    """Whether a row is of this package."""
    return row["kind"] != "rival"


def dominating(row: Row, rows: Sequence[Row]) -> Row | None:
    """The fastest row of ours that is faster than this one and as accurate; `None` on the front.

    Faster by more than the noise, or as fast and twice as accurate. Single calls compare with
    single calls, batches with batches. A row without an error is nowhere on the front.
    """
    error = error_of(row)
    better = []
    for other in rows:
        theirs = error_of(other)
        if other is row or not is_ours(other) or theirs is None:
            continue
        if is_single(other) != is_single(row):
            continue
        faster = other["best_s"] < (1 - NOISE) * row["best_s"] and theirs <= (error or 0.0)
        better_too = other["best_s"] <= row["best_s"] and theirs < (error or 0.0) / 2
        if error is None or faster or better_too:
            better.append(other)
    return min(better, key=lambda one: one["best_s"]) if better else None


def on_front(row: Row, rows: Sequence[Row]) -> bool:
    """Whether none of ours is both faster and as accurate."""
    return error_of(row) is not None and dominating(row, rows) is None


def fastest_within(limit: float, rows: Sequence[Row]) -> Row | None:
    """The fastest of some rows whose largest error is within a limit."""
    good = [row for row in rows if (e := error_of(row)) is not None and e <= limit]
    return min(good, key=lambda row: row["best_s"]) if good else None
