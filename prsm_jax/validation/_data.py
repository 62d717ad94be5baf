"""Tables of the papers, stored as package data."""

import csv
from pathlib import Path

_FOLDER = Path(__file__).parent / "data"


def read_table(name: str) -> list[dict[str, str]]:
    """The rows of a CSV table as printed text, by column; lines that start with # are comments."""
    with (_FOLDER / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))
