"""`python -m tests.of_room [ROOM]`: folders of tests of one room of the package, or of all."""

import argparse
import sys
from collections import Counter
from pathlib import Path

from tests.layers.room_order import LAYERS
from tests.mutation.rooms import TESTS

ROOT = Path(__file__).parent
#: Tests in folders of other rooms, where no list of faults names them.
_ELSEWHERE = {
    "report": ("reading",),
    "fields": ("file/test_file_errors.py", "file/test_file_limits.py"),
    "text": (
        "cli/test_cli_tables.py",
        "reading/test_reading_display_units.py",
        "report/test_report_markup.py",
        "report/test_report_units.py",
    ),
    "process": (
        "cli/test_cli_interrupt.py",
        "cli/test_cli_signals.py",
        "sweeps/test_sweep_stores.py",
        "programs/test_threads_fork.py",
    ),
}


def files_of(room: str) -> list[str]:
    """Files and folders of tests, from the top folder of the project; the layers among them.

    **Raises:** `ValueError` for a room that does not exist.
    """
    if room not in LAYERS:
        raise ValueError(f"ROOM is {room!r}; choose one of {', '.join(LAYERS)}")
    folders = [room] if (ROOT / room).is_dir() else []
    files = [
        name
        for start, names in TESTS
        if start.split("/")[0] == room
        for name in names
        if name.split("/")[0] not in folders
    ]
    files += _ELSEWHERE.get(room, ())
    return [f"tests/{name}" for name in ("layers", *folders, *dict.fromkeys(files))]


def folders_of_part(part: int, parts: int) -> list[str]:
    """Folders with tests, of one of several parts with about as many slow tests each.

    A worker keeps some memory of every program that it compiled, so the slow tests run in several
    sessions.

    **Arguments:**

    - `part`: 1 for the first.
    - `parts`: how many there are.
    """
    names = (ROOT / "slow.txt").read_text(encoding="utf-8").splitlines()
    count = Counter(name.split("/")[1] for name in names)
    chosen, before = [], 0
    for folder in sorted(path.name for path in ROOT.iterdir() if any(path.rglob("test_*.py"))):
        # The part in which the middle one of its tests is.
        middle = before + count[folder] / 2
        if min(int(parts * middle / len(names)), parts - 1) == part - 1:
            chosen.append(f"tests/{folder}")
        before += count[folder]
    return chosen


def main() -> int:
    """Print them, or say which rooms exist."""
    parser = argparse.ArgumentParser(prog="python -m tests.of_room", description=__doc__)
    parser.add_argument("room", nargs="?", help="of the package; default: all")
    parser.add_argument("--part", default="1/1", help="K/N, one of N parts of all folders")
    given = parser.parse_args()
    if given.room is None:
        part, parts = map(int, given.part.split("/"))
        print("tests" if parts == 1 else " ".join(folders_of_part(part, parts)))
        return 0
    try:
        print(" ".join(files_of(given.room)))
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
