"""One structure in a process of its own: `python -m benchmarks.extremes.worker NAME`.

It prints a line of JSON before and after each row, so that whoever started it sees a crash or a
hang, and of which row.
"""

import argparse
import json
import os
import sys
import traceback

# Programs run a few thousand times: code that is not optimised compiles in a quarter of the time.
_QUICK = "--xla_backend_optimization_level=0 --xla_cpu_parallel_codegen_split_count=1"


def _line(**content) -> None:
    sys.stdout.write(json.dumps(content) + "\n")
    sys.stdout.flush()


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("structure")
    parser.add_argument("--rows", type=int, default=300)
    parser.add_argument("--seed", type=int, default=14)
    parser.add_argument("--skip", type=int, default=0, help="rows that are done already")
    parser.add_argument("--part", default="1/1", help="every N-th row only, from the K-th: K/N")
    parser.add_argument("--row", action="append", default=[], help="this row only")
    arguments = parser.parse_args(argv)
    os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {_QUICK}".strip()

    from .judge import crashed, judge, programs
    from .plan import rows_of
    from .structures import columns_of, structure

    one = structure(arguments.structure)
    columns = columns_of(one)
    first, step = map(int, arguments.part.split("/"))
    rows = rows_of(one, count=arguments.rows, seed=arguments.seed)[first - 1 :: step]
    if arguments.row:
        unknown = set(arguments.row) - {row.name for row in rows}
        if unknown:
            parser.error(f"{one.name} has no row {', '.join(map(repr, sorted(unknown)))}")
        rows = [row for row in rows if row.name in arguments.row]
    _line(columns=columns, count=len(rows), numbers=len(programs(one.name).numbers))
    compiled = programs(one.name)
    base, _ = compiled.values(compiled.leaves)
    for row in rows[arguments.skip :]:
        _line(begin=row.as_json())
        try:
            cells, seconds = judge(compiled, row, base, arguments.seed)
        except Exception as error:
            traceback.print_exc()
            cells, seconds = crashed(columns, error), 0.0
        given = {
            name: [[cell.status, cell.error, cell.detail] for cell in three]
            for name, three in cells.items()
        }
        _line(end=row.name, seconds=seconds, cells=_finite(given))
    return 0


def _finite(cells):
    # NaN and infinity are no JSON.
    for three in cells.values():
        for cell in three:
            if cell[1] is not None and not abs(cell[1]) < float("inf"):
                cell[1] = 1e300
    return cells


if __name__ == "__main__":
    sys.exit(main())
