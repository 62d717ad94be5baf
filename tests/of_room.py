"""`python -m tests.of_room [ROOM]`: folders of tests of one room of the package, or of all."""

import sys
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


def main() -> int:
    """Print them, or say which rooms exist."""
    if not sys.argv[1:]:
        print("tests")
        return 0
    try:
        print(" ".join(files_of(sys.argv[1])))
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
