"""`python -m benchmarks joint`: joint Jacobians of random subsets, and Hessians; JSON and table."""

import argparse
from pathlib import Path
from typing import Any

import jax

from ..guard import Numbers, guarded
from ..harness import of_this_run, parser_of, read_json, write_json, write_text
from .guard import LIMITS, numbers_of_joint
from .measured import quantity_names, random_subsets
from .page import tables, write_page
from .rows import hessian, joint, joint_to_single, verbs_to_value

#: What the toolkit is for: together, by lead, contact angle and roller radius.
_THREE = ("efficiency", "max_pressure", "natural_frequencies")
_SEED = 15
#: For how long the programs of a row are sampled in turn [s].
_SECONDS, _QUICK_SECONDS = 1.0, 0.5


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("joint", __doc__, several=True)
    parser.add_argument("--example", default="actuator", help="example to vary; default actuator")
    parser.add_argument("--subsets", type=int, default=30, help="number of random subsets")
    parser.add_argument("--designs", type=int, default=1000, help="designs in a batch")
    parser.add_argument(
        "--hessians", nargs="*", default=["efficiency", "max_pressure", "drive_torque"],
        help="scalar quantities whose Hessian is compiled",
    )  # fmt: skip
    parser.add_argument(
        "--quick",
        action="store_true",
        help="the guard: the three main quantities and one Hessian, compared with stored numbers",
    )
    parser.add_argument(
        "--store", action="store_true", help="with --quick: renew the stored numbers"
    )
    parser.add_argument("--resume", action="store_true", help="keep the rows of an interrupted run")
    return parser.parse_args(argv)


def _begun(example: str, designs: int, kept: Path | None) -> dict[str, Any]:
    """A document without rows, or with those of a run that was stopped.

    **Raises:** `ValueError` if that run was of other designs.
    """
    if kept is not None and kept.exists():
        document = read_json(kept)
        if (document["example"], document["designs"]) != (example, designs):
            raise ValueError(
                f"{kept} has {document['designs']} designs of {document['example']!r}, not "
                f"{designs} of {example!r}: run without --resume, or with another --out"
            )
        return document
    return {
        **of_this_run(2),
        "example": example,
        "designs": designs,
        "joint": [],
        "hessians": [],
    }


def main(argv: list[str] | None = None) -> int:
    """Entry point; with `--quick` the exit status is 1 where the guard finds a number worse."""
    given = _arguments(argv)
    if given.page is not None:
        _said(write_page([*map(read_json, given.page)], given.docs or given.out))
        return 0
    if given.quick:
        return guarded(
            f"joint {given.example}",
            lambda: _quick(given.example, given.designs, given.hessians[0]),
            LIMITS,
            renew=given.store,
            # The limits are far from noise, and a measurement takes minutes.
            measurements=1 if given.store else 2,
        )
    kept = given.out / f"joint-{given.example}.json"
    document = _begun(given.example, given.designs, kept if given.resume else None)
    subsets = [_THREE, *random_subsets(quantity_names(given.example), given.subsets, _SEED)]
    done = {tuple(row["quantities"]) for row in document["joint"]}
    for names in [one for one in subsets if one not in done]:
        document["joint"].append(joint(given.example, names, given.designs, _SECONDS))
        print(f"joint: {', '.join(names)}: {document['joint'][-1]['over_value']}", flush=True)
        _write(document, kept)
        jax.clear_caches()
    done = {row["quantity"] for row in document["hessians"]}
    for name in [one for one in given.hessians if one not in done]:
        document["hessians"].append(hessian(given.example, name, given.designs, _SECONDS))
        print(f"joint: Hessian of {name}: {document['hessians'][-1]['compile_s']}", flush=True)
        _write(document, kept)
        jax.clear_caches()
    print(tables(document))
    if given.docs is not None:
        _said(write_page([document], given.docs))
    return 0


def _quick(example: str, designs: int, of_hessian: str) -> Numbers:
    """One measurement for the guard, printed."""
    row = joint(example, _THREE, designs, _QUICK_SECONDS)
    second = hessian(example, of_hessian, designs, _QUICK_SECONDS)
    together = joint_to_single(example, _THREE, designs, _QUICK_SECONDS)
    verbs = verbs_to_value(example, designs, _QUICK_SECONDS)
    found = numbers_of_joint(row, second, together, verbs)
    for name, value in {**found.errors, **found.ratios, **found.costs}.items():
        print(f"{name}: {value:.3g}", flush=True)
    jax.clear_caches()
    return found


def _said(paths: list[Path]) -> None:
    print(f"joint: {', '.join(str(path) for path in paths)}")


def _write(document: dict[str, Any], path: Path) -> None:
    write_json(path, document)
    write_text(path.with_suffix(".md"), tables(document))
