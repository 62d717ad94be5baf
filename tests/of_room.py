"""`python -m tests.of_room [ROOM]`: files of tests of one room of the package, or of all."""

import sys
from pathlib import Path

from tests.layers.room_order import LAYERS
from tests.mutation.rooms import TESTS

ROOT = Path(__file__).parent
#: Folders of tests that have other names than their rooms.
_FOLDERS = {
    "sensitivities": ("sensitivity",),
    "optimisation": ("optimise",),
    "sweeps": ("sweep",),
    "report": ("report", "reading"),
    "explanation": ("no_dead_weight",),
}
#: Tests of rooms at the ground, which faults are not put into.
_FILES = {
    "fields": ("analytic/test_analytic_ends_of_laws.py", "file/test_file_errors.py"),
    "programs": ("analytic/test_analytic_one_program.py", "analytic/test_analytic_batches.py"),
    "text": (
        "cli/test_cli_tables.py",
        "reading/test_reading_display_units.py",
        "report/test_report_markup.py",
        "report/test_report_units.py",
    ),
    "process": (
        "cli/test_cli_interrupt.py",
        "cli/test_cli_signals.py",
        "sweep/test_sweep_stores.py",
        "threads/test_threads_fork.py",
    ),
}


def files_of(room: str) -> list[str]:
    """Files and folders of tests, from the top folder of the project; the layers among them.

    **Raises:** `ValueError` for a room that there is not.
    """
    if room not in LAYERS:
        raise ValueError(f"ROOM is {room!r}; choose one of {', '.join(LAYERS)}")
    folders = list(_FOLDERS.get(room, (room,) if (ROOT / room).is_dir() else ()))
    files = [
        name
        for start, names in TESTS
        if start.split("/")[0] == room
        for name in names
        if name.split("/")[0] not in folders
    ]
    files += _FILES.get(room, ())
    return [f"tests/{name}" for name in ("layers", *folders, *dict.fromkeys(files))]


def main() -> int:
    """Print them, or say which rooms there are."""
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
