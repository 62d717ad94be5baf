"""Which rows a structure gets."""

import mpmath

from prsm_jax.friction import CoulombFriction
from prsm_jax.mechanism import Mechanism

from .expected.chain import Contact
from .numbers import Change, numbers_of, split
from .rows import (
    COMBINATIONS,
    SEED,
    Row,
    combinations,
    in_single_precision,
    singles,
    spoiled,
)
from .structures import Structure

#: Share of the combinations that a slow structure gets.
_SLOW_SHARE = 5
#: How far from the limits of friction.
_DISTANCES = (1e-12, 1e-9, 1e-6, 1e-3)


def _limits(one: Structure) -> list[Row]:
    """Friction close to self-locking and jamming of each stage, on both sides."""
    mechanism = one.base
    if not isinstance(mechanism, Mechanism):
        return []
    leaves, _ = split(mechanism)
    given = dict(zip([n.name for n in numbers_of(mechanism)], leaves, strict=True))
    found = []
    for index, stage in enumerate(mechanism.stages[:2]):
        if stage.friction is None or not isinstance(stage.friction.thread, CoulombFriction):
            continue
        with mpmath.workdps(40):
            names = ("lead", "starts", "roller_radius", "contact_angle", "roller_profile_radius")
            path = f"stage.{index + 1}.thread."
            thread = {n: mpmath.mpf(float(given[path + n])) for n in names if path + n in given}
            for name, limit in zip(("locking", "jamming"), Contact(thread).limits(), strict=True):
                for distance in _DISTANCES:
                    for sign in (-1, 1):
                        value = float(limit * (1 + sign * mpmath.mpf(distance)))
                        pattern = f"stage.{index + 1}.friction.thread.coefficient"
                        label = (
                            f"stage {index + 1}, {name} limit × (1 {'+-'[sign < 0]} {distance:g})"
                        )
                        found.append(Row(label, "single", (Change(pattern, "set", value),)))
    return found


def rows_of(one: Structure, *, count: int = COMBINATIONS, seed: int = SEED) -> list[Row]:
    """All rows that concern a structure: the ordinary one first."""
    numbers = numbers_of(one.base)
    own = count // _SLOW_SHARE if one.slow else count

    def concerns(row: Row) -> bool:
        return not row.changes or any(c.matches(n.name) for c in row.changes for n in numbers)

    alone = [row for row in singles() if concerns(row)]
    mixed = [row for row in combinations(count, seed)[:own] if concerns(row)]
    # In float32 the ordinary numbers only: ratios beyond 1e7 are beyond its digits.
    short = in_single_precision(alone[:1])
    return [*alone, *short, *_limits(one), *mixed, *spoiled(numbers)]


def reduced_rows(one: Structure, *, seed: int = SEED) -> list[Row]:
    """Few of them, spread over all groups, for tests."""
    every = rows_of(one, count=30, seed=seed)
    groups: dict[str, list[Row]] = {}
    for row in every:
        groups.setdefault(row.group, []).append(row)
    chosen = [every[0]]
    for group, limit in (("single", 20), ("combination", 5), ("number", 32)):
        rows = groups.get(group, [])
        chosen += rows[:: -(-len(rows) // limit)] if rows else []
    return list(dict.fromkeys(chosen))
