"""One example in a process of its own: `python -m benchmarks.parts.worker EXAMPLE`.

Prints one JSON object: what `prsm_jax.explain` finds with `time=True`.
"""

import argparse
import json
from typing import Any

import prsm_jax as prsm


def measure(example: str, programs: list[str] | None, time: bool = True) -> dict[str, Any]:
    """Costs of all parts of an example that are tables or stages.

    **Arguments:**

    - `example`: its name.
    - `programs`: as for `prsm_jax.explain`.
    - `time`: whether programs are compiled and run.
    """
    found = prsm.explain(prsm.load(example), programs=programs, time=time).to_dict()
    parts = [part for part in found["parts"] if part["costs"]]
    keys = ("name", "law", "costs")
    return {
        "example": example,
        "programs": found["programs"],
        "parts": [{key: part[key] for key in keys} for part in parts],
        "error": None,
    }


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.parts.worker", description=__doc__)
    parser.add_argument("example")
    parser.add_argument("--programs", nargs="*", default=None)
    parser.add_argument("--count-only", action="store_true")
    given = parser.parse_args()
    print(json.dumps(measure(given.example, given.programs, not given.count_only)))


if __name__ == "__main__":
    main()
