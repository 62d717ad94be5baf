"""`python -m benchmarks extremes`: run the matrix, print its counts, write JSON, page, pictures."""

import argparse
import concurrent.futures
import datetime
import json
import queue
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

from ..harness import parser_of, read_json, write_text
from .cells import STATUSES, Cell, Table, is_bad, joined, table_of, total
from .rows import COMBINATIONS, SEED

#: A row that takes longer is said to hang; compiling is in the first one [s].
ROW_LIMIT, FIRST_LIMIT = 120.0, 1200.0


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("extremes", __doc__, several=True)
    parser.add_argument("structures", nargs="*", help="which structures; default all")
    parser.add_argument(
        "--rows", type=int, default=COMBINATIONS, help="number of random combinations"
    )
    parser.add_argument("--seed", type=int, default=SEED, help="seed of the combinations")
    parser.add_argument(
        "--part", default="1/1", metavar="K/N", help="every N-th row only, from the K-th"
    )
    parser.add_argument(
        "--row", action="append", default=[], metavar="NAME", help="this row only; may be repeated"
    )
    parser.add_argument("--jobs", type=int, default=2, help="number of processes at a time")
    parser.add_argument("--list", action="store_true", help="list the structures and exit")
    return parser.parse_args(argv)


def _reader(stream, lines: queue.Queue[Any]) -> None:
    for line in stream:
        lines.put(line)
    lines.put(None)


class _Worker:
    """A process that works through the rows of one structure."""

    def __init__(self, name: str, arguments: argparse.Namespace, skip: int):
        self.process = subprocess.Popen(
            [
                *(sys.executable, "-m", "benchmarks.extremes.worker", name),
                *("--rows", str(arguments.rows), "--seed", str(arguments.seed)),
                *("--skip", str(skip), "--part", arguments.part),
                *(part for row in arguments.row for part in ("--row", row)),
            ],
            stdout=subprocess.PIPE,
            text=True,
        )
        self.lines: queue.Queue[Any] = queue.Queue()
        self.reader = threading.Thread(
            target=_reader, args=(self.process.stdout, self.lines), daemon=True
        )
        self.reader.start()

    def next(self, limit: float) -> dict[str, Any] | None:
        """The next line; `None` at the end of the process.

        **Raises:** `queue.Empty` past the limit.
        """
        line = self.lines.get(timeout=limit)
        return None if line is None else json.loads(line)

    def stop(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.wait()
        self.reader.join()
        assert self.process.stdout is not None
        self.process.stdout.close()


def run_structure(name: str, arguments: argparse.Namespace) -> Table:
    """All rows of one structure; a row that ends or hangs the process is marked and passed over."""
    table, done, count = Table(name, ()), 0, None
    while count is None or done < count:
        worker, row, first = _Worker(name, arguments, done), None, True
        while True:
            # The row in single precision is compiled anew.
            compiles = first or (row is not None and row["name"].endswith("float32"))
            limit = FIRST_LIMIT if compiles else ROW_LIMIT
            try:
                found = worker.next(limit)
            except queue.Empty:
                fault = Cell("hang", None, f"no answer in {limit} s")
                break
            if found is None:
                fault = Cell("crash", None, f"the process ended with {worker.process.wait()}")
                break
            if "columns" in found:
                table.columns, count = tuple(found["columns"]), found["count"]
            elif "begin" in found:
                row = found["begin"]
                table.rows.append(row)
            else:
                done, first = done + 1, False
                table.seconds[found["end"]] = round(found["seconds"], 4)
                table.cells[found["end"]] = {
                    column: tuple(Cell(*cell) for cell in three)
                    for column, three in found["cells"].items()
                }
                row = None
        worker.stop()
        if count is not None and done >= count:
            break
        if row is None:
            print(f"{name}: {fault.detail}, before its first row", flush=True)
            table.ended = False
            break
        print(f"{name}: {row['name']}: {fault.detail}", flush=True)
        absent = Cell("absent")
        table.cells[row["name"]] = dict.fromkeys(table.columns, (fault, absent, absent))
        done += 1
    return table


def faults(table: Table) -> list[str]:
    """Every class of faults once, with how many cells it has and the first of them."""
    classes: Counter[tuple[str, str, str]] = Counter()
    example = {}
    for row, column, kind, cell in table.bad():
        key = (column, kind, cell.status)
        classes[key] += 1
        example.setdefault(key, f"{row}: {cell.detail}")
    return [
        f"  {table.structure} {column} {kind} {status} × {number}; {example[column, kind, status]}"
        for (column, kind, status), number in classes.most_common()
    ]


def summary(tables: list[Table]) -> str:
    """Counts by structure and status."""
    lines = []
    names = [name for name in STATUSES if name != "absent"]
    lines.append("structure".ljust(22) + "".join(name.rjust(15) for name in names))
    for table in tables:
        counts = table.counts()
        lines.append(
            table.structure.ljust(22) + "".join(str(counts[name]).rjust(15) for name in names)
        )
    counts = total(tables)
    lines.append("all".ljust(22) + "".join(str(counts[name]).rjust(15) for name in names))
    bad = sum(n for name, n in counts.items() if is_bad(name))
    lines.append(f"{sum(counts.values())} cells, {bad} bad")
    return "\n".join(lines)


def document(tables: list[Table], arguments: argparse.Namespace, seconds: float) -> dict[str, Any]:
    """Everything as JSON-able data."""
    return {
        "schema": 1,
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "seed": arguments.seed,
        "combinations": arguments.rows,
        "seconds": round(seconds, 1),
        "statuses": {s.letter: [name, s.meaning, s.bad] for name, s in STATUSES.items()},
        "counts": dict(total(tables)),
        "tables": [table.as_json() for table in tables],
    }


def _page_of(arguments: argparse.Namespace) -> int:
    """The page again, from files of earlier runs of the same seed."""
    from .output.page import write_page

    found = [*map(read_json, arguments.page)]
    tables = joined([table_of(data) for one in found for data in one["tables"]])
    arguments.seed = found[0]["seed"]
    arguments.rows = max(one["combinations"] for one in found)
    folder = Path("docs") if arguments.docs is None else arguments.docs
    for written in write_page(tables, folder, arguments, sum(one["seconds"] for one in found)):
        print(written)
    print(summary(tables))
    return 1 if any(table.bad() for table in tables) else 0


def main(argv: list[str] | None = None) -> int:
    """Entry point; the exit status is 1 where a cell is bad."""
    from .structures import STRUCTURES

    arguments = _arguments(argv)
    unknown = sorted(set(arguments.structures) - set(STRUCTURES))
    if unknown:
        print(f"unknown structure {', '.join(unknown)}; choose from {', '.join(STRUCTURES)}")
        return 2
    if arguments.page:
        return _page_of(arguments)
    chosen = arguments.structures or list(STRUCTURES)
    if arguments.list:
        print("\n".join(STRUCTURES))
        return 0
    print(f"seed {arguments.seed}, {arguments.rows} combinations", flush=True)
    begin = time.perf_counter()
    tables: dict[str, Table] = {}
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        jobs = {pool.submit(run_structure, name, arguments): name for name in chosen}
        for job in concurrent.futures.as_completed(jobs):
            name = jobs[job]
            tables[name] = job.result()
            counts = tables[name].counts()
            bad = sum(n for status, n in counts.items() if is_bad(status))
            spent = time.perf_counter() - begin
            print(f"{name}: {len(tables[name].rows)} rows, {bad} bad, {spent:.0f} s", flush=True)
            print("\n".join(faults(tables[name])), flush=True)
    ordered = [tables[name] for name in chosen]
    seconds = time.perf_counter() - begin
    print(summary(ordered))
    content = json.dumps(document(ordered, arguments, seconds), allow_nan=False)
    print(write_text(arguments.out / "extremes.json", content + "\n"))
    if arguments.docs is not None:
        from .output.page import write_page

        for written in write_page(ordered, arguments.docs, arguments, seconds):
            print(written)
    return 1 if any(table.bad() or not table.ended for table in ordered) else 0
