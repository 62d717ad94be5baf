"""`python -m tests.slow SECONDS.json`: write which tests are slow, from the times of a run.

`PRSM_TEST_SECONDS=SECONDS.json .venv/bin/python -m pytest -n 2` measures all of them in one run.
Use an empty compilation cache (`PRSM_TEST_CACHE`) and a machine without other work.
"""

import json
import sys
from pathlib import Path

#: Tests that take longer are slow [s].
LIMIT = 2.5
LIST = Path(__file__).with_name("slow.txt")


def main() -> int:
    """Write the list; tests that were not run keep their place."""
    if len(sys.argv) != 2:
        print("usage: python -m tests.slow SECONDS.json", file=sys.stderr)
        return 2
    seconds = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    before = set(LIST.read_text(encoding="utf-8").splitlines()) if LIST.exists() else set()
    slow = {name for name, time in seconds.items() if time > LIMIT} | (before - set(seconds))
    LIST.write_text("".join(f"{name}\n" for name in sorted(slow)), encoding="utf-8")
    quick = sum(time for name, time in seconds.items() if name not in slow)
    print(f"{len(slow)} slow tests; {len(seconds) - len(slow)} others take {quick:.0f} s in all")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
