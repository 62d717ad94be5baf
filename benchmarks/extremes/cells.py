"""What a cell of the matrix says, and a table of cells."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple


class Status(NamedTuple):
    """One outcome: its letter in the files, what it means, and whether it is a fault."""

    letter: str
    meaning: str
    bad: bool
    colour: str


STATUSES = {
    "agrees": Status("o", "agrees with an independent reference", False, "#2a9d5c"),
    "untouched": Status("i", "does not depend on the number that was changed", False, "#a9d8b8"),
    "refused": Status("r", "refused by name: a result code, or one error", False, "#8fb4d9"),
    "finite": Status("f", "finite and flagged as valid; no reference is known", False, "#e4e7b2"),
    "open": Status(
        "u", "finite; the differences are too uncertain to confirm or refute it", False, "#e8b84a"
    ),
    "not_finite": Status("n", "NaN or infinity with a flag that says valid", True, "#d7191c"),
    "wrong_value": Status("w", "a wrong number with a flag that says valid", True, "#8c1eb4"),
    "wrong_gradient": Status("g", "a derivative that differs from differences", True, "#ff7f0e"),
    "accepted": Status(
        "s", "an impossible number was accepted and changed the result", True, "#e377c2"
    ),
    "crash": Status("x", "an exception or the end of the process", True, "#000000"),
    "hang": Status("h", "no answer within the time limit", True, "#555555"),
    "absent": Status(".", "does not apply", False, "#ffffff"),
}
BY_LETTER = {status.letter: name for name, status in STATUSES.items()}
#: What is looked at in every pair of a row and a column.
KINDS = ("value", "forward", "reverse")


def is_bad(status: str) -> bool:
    """Whether a status is a fault."""
    return STATUSES[status].bad


@dataclass(frozen=True)
class Cell:
    """One judgement: a status, an error (relative) where there is one, and what was seen."""

    status: str
    error: float | None = None
    detail: str = ""


@dataclass
class Table:
    """Cells of one structure: `cells[row][column]` is a tuple of one cell per kind."""

    structure: str
    columns: tuple[str, ...]
    rows: list[dict[str, Any]] = field(default_factory=list)
    cells: dict[str, dict[str, tuple[Cell, ...]]] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    #: Whether the process came as far as the first row that is not here.
    ended: bool = True

    def counts(self, column: str | None = None, group: str | None = None) -> Counter[str]:
        """How many cells have each status; of one column or group of rows if asked."""
        found: Counter[str] = Counter()
        groups = {row["name"]: row["group"] for row in self.rows}
        for row, columns in self.cells.items():
            if group is not None and groups[row] != group:
                continue
            for name, kinds in columns.items():
                if column is None or name == column:
                    found.update(cell.status for cell in kinds)
        return found

    def bad(self) -> list[tuple[str, str, str, Cell]]:
        """Row, column, kind and cell of every fault."""
        return [
            (row, column, kind, cell)
            for row, columns in self.cells.items()
            for column, kinds in columns.items()
            for kind, cell in zip(KINDS, kinds, strict=True)
            if is_bad(cell.status)
        ]

    def as_json(self) -> dict[str, Any]:
        """Letters and errors, row by row: one string per kind, a letter per column."""
        rows = []
        for row in self.rows:
            cells = self.cells.get(row["name"], {})
            kinds = {}
            for place, kind in enumerate(KINDS):
                kinds[kind] = "".join(
                    STATUSES[cells[c][place].status].letter if c in cells else "."
                    for c in self.columns
                )
            details = {
                f"{column} {kind}": [cell.status, cell.error, cell.detail]
                for column, three in cells.items()
                for kind, cell in zip(KINDS, three, strict=True)
                if is_bad(cell.status)
            }
            errors = {
                kind: [
                    None if c not in cells else _rounded(cells[c][place].error)
                    for c in self.columns
                ]
                for place, kind in enumerate(KINDS)
            }
            rows.append(row | {"letters": kinds, "errors": errors, "bad": details})
        return {
            "structure": self.structure,
            "columns": list(self.columns),
            "rows": rows,
            "seconds": self.seconds,
        }


def table_of(data: dict[str, Any]) -> Table:
    """A table from what `Table.as_json` wrote."""
    table = Table(data["structure"], tuple(data["columns"]), seconds=data["seconds"])
    for row in data["rows"]:
        table.rows.append({key: row[key] for key in ("name", "group", "changes")})
        cells = {}
        for place, column in enumerate(table.columns):
            three = []
            for kind in KINDS:
                status = BY_LETTER[row["letters"][kind][place]]
                detail = row["bad"].get(f"{column} {kind}", ("", None, ""))[2]
                three.append(Cell(status, row["errors"][kind][place], detail))
            cells[column] = tuple(three)
        table.cells[row["name"]] = cells
    return table


def joined(tables: list[Table]) -> list[Table]:
    """Parts of one structure as one table, in the order of their first parts.

    A row that was run again stands where it stood, with its last cells.
    """
    whole: dict[str, Table] = {}
    for table in tables:
        if table.structure not in whole:
            whole[table.structure] = table
            continue
        first = whole[table.structure]
        first.columns = first.columns or table.columns
        there = {row["name"] for row in first.rows}
        first.rows.extend(row for row in table.rows if row["name"] not in there)
        first.cells.update(table.cells)
        first.seconds.update(table.seconds)
    return list(whole.values())


def _rounded(error: float | None) -> float | None:
    return None if error is None or not error < float("inf") else float(f"{error:.1e}")


def total(tables: Iterable[Table]) -> Counter[str]:
    """Counts over several tables."""
    found: Counter[str] = Counter()
    for table in tables:
        found.update(table.counts())
    del found["absent"]
    return found
