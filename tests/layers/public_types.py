"""`python -m tests.layers.public_types`: every name of a door has a known type.

A wrong call is then red in a user's editor. `make lint` runs this; it fails for a public name that
has lost an annotation, and for one whose type is guessed.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]


def unknown(report: dict[str, Any]) -> list[str]:
    """A line for each public name without a known type.

    **Arguments:**

    - `report`: the JSON of `pyright --verifytypes`.

    **Raises:** `ValueError` if the report has no public names.
    """
    public = [one for one in report["typeCompleteness"]["symbols"] if one["isExported"]]
    if not public:
        raise ValueError("pyright found no public names")
    return [
        f"{one['name']}: {'; '.join(d['message'].splitlines()[0] for d in one['diagnostics'])}"
        for one in public
        if not one["isTypeKnown"] or one["isTypeAmbiguous"]
    ]


def main() -> int:
    """Print the names; 1 if there is one."""
    # Pyright takes packages from the `python` that it finds first, and the tree from the path.
    found = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    done = subprocess.run(
        ["pyright", "--verifytypes", "prsm_jax", "--ignoreexternal", "--outputjson"],
        cwd=ROOT,
        env=os.environ | {"PATH": found, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    try:
        report = json.loads(done.stdout)
    except ValueError:
        print(done.stdout + done.stderr, file=sys.stderr)
        return 1
    lines = unknown(report)
    print("\n".join(lines) if lines else "the type of every public name is known")
    return 1 if lines else 0


if __name__ == "__main__":
    raise SystemExit(main())
