"""`python -m tests.mutation`: puts single faults into the core and counts those that tests see.

Faults are drawn by a seed from all operators, comparisons, constants, signs and names of the core,
evenly over its text. Each is put into a copy of the package and tried against the quick tests of
its room until the first one fails; tests that fail without a fault are left out. Results go to a
JSON file as they come, so that a run can be stopped and taken up again. Faults that no test sees
are listed at the end, with the reason where `reasons.json` has one; those that have one are not
tried unless asked for, and count as not seen. A fault takes about half a minute.
"""

import argparse
import json
import random
from pathlib import Path

from .operators import Fault, faults
from .rooms import ROOMS, core_files
from .trying import try_faults

_TREE = Path(__file__).parents[2]
_REASONS = Path(__file__).parent / "reasons.json"


def draw(tree: Path, count: int, seed: int, rooms: tuple[str, ...]) -> list[Fault]:
    """So many faults in a random order that depends on the seed and on each fault alone.

    A change of the package elsewhere leaves the others in their order.
    """
    package, pool = tree / "prsm_jax", []
    for path in core_files(package):
        name = str(path.relative_to(package))
        if name.partition("/")[0] in rooms:
            pool += faults(name, path.read_text())
    return sorted(pool, key=lambda fault: random.Random(f"{seed} {fault.name}").random())[:count]


def _report(rows: list[dict], reasons: dict[str, str]) -> float:
    """Print a table by room and those that were not seen; the share of faults that was seen."""
    print(f"\n{'room':14} {'faults':>6} {'seen':>6} {'excused':>8}")
    for room in (*ROOMS, ""):
        mine = [row for row in rows if row["path"].startswith(room)]
        if not mine:
            continue
        seen = sum(bool(row["seen"]) for row in mine)
        excused = sum(not row["seen"] and row["fault"] in reasons for row in mine)
        print(f"{room or 'together':14} {len(mine):6} {seen:6} {excused:8}")
    missed = [row for row in rows if not row["seen"]]
    if missed:
        print("\nnot seen:")
    for row in missed:
        print(f"  {row['fault']}\n      {reasons.get(row['fault'], 'no reason known')}")
    return sum(bool(row["seen"]) for row in rows) / max(len(rows), 1)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=__doc__)
    parser.add_argument("--count", type=int, default=150, help="how many faults")
    parser.add_argument("--seed", type=int, default=13)
    parser.add_argument("--rooms", default=",".join(ROOMS), help="separated by commas")
    parser.add_argument("--jobs", type=int, default=1, help="faults tried at once")
    parser.add_argument("--budget", type=int, default=300, help="processor time of a fault [s]")
    parser.add_argument("--again", action="store_true", help="try what was not seen again")
    parser.add_argument("--excused", action="store_true", help="try those with a reason too")
    parser.add_argument("--tree", type=Path, default=_TREE, help="a checkout of another commit")
    parser.add_argument("--output", type=Path, default=Path("out/mutation.json"))
    parser.add_argument("--least", type=float, default=0.9, help="share that has to be seen")
    parser.add_argument("--list", action="store_true", help="only print the faults")
    given = parser.parse_args()
    chosen = draw(given.tree, given.count, given.seed, tuple(given.rooms.split(",")))
    if given.list:
        print("\n".join(f"{fault.line:4} {fault.name}" for fault in chosen))
        return 0
    reasons = json.loads(_REASONS.read_text())
    left = {} if given.excused else reasons
    rows = [
        {"fault": fault.name, "path": fault.path, "line": fault.line, "seen": ""}
        for fault in chosen
        if fault.name in left
    ]
    todo = [fault for fault in chosen if fault.name not in left]
    for row in try_faults(todo, given.tree, given.output, given.jobs, given.budget, given.again):
        rows.append(row)
        print(f"{row['seen'] or 'NOT SEEN':8} {row['seconds']:6.1f} s  {row['fault']}", flush=True)
    share = _report(rows, reasons)
    print(f"\n{100 * share:.1f} % of the faults were seen")
    return int(share < given.least)


if __name__ == "__main__":
    raise SystemExit(main())
