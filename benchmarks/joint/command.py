"""`python -m benchmarks joint`: joint Jacobians of random subsets, and Hessians; JSON and table."""

import argparse
import datetime
import json
from pathlib import Path
from typing import Any

import jax
import numpy as np

from ..harness import written_whole
from ..harness.report import machine, versions
from .measured import (
    FOUR,
    VARIABLES,
    as_one,
    central_differences,
    designs_around,
    error_of,
    of_numbers,
    quantity_names,
    random_subsets,
    reference_jacobian,
    timed,
)

#: What the toolkit is for: together, by lead, contact angle and roller radius.
_THREE = ("efficiency", "max_pressure", "natural_frequencies")
_SEED = 15
#: Limits of the guard, far from noise: 58 and more than 400 s before the cure.
_LARGEST_JOINT_RATIO = 6.0
_LARGEST_HESSIAN_COMPILE = 200.0


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks joint", description=__doc__)
    parser.add_argument("--example", default="actuator", help="whose designs; default actuator")
    parser.add_argument("--subsets", type=int, default=30, help="how many random subsets")
    parser.add_argument("--designs", type=int, default=1000, help="designs in a batch")
    parser.add_argument(
        "--hessians", nargs="*", default=["efficiency", "max_pressure", "drive_torque"],
        help="scalar quantities whose Hessian is compiled",
    )  # fmt: skip
    parser.add_argument(
        "--quick", action="store_true", help="the guard: the three alone and one Hessian, limits"
    )
    parser.add_argument("--out", type=Path, default=Path("out/benchmarks"), help="folder")
    return parser.parse_args(argv)


def joint(example: str, names: tuple[str, ...], count: int, seconds: float) -> dict[str, Any]:
    """Value, Jacobians and differences of some quantities together, in one run."""
    evaluate, centre = of_numbers(example, names)
    together, designs = as_one(evaluate), designs_around(centre, count)
    found = timed(
        {
            "value": evaluate,
            "forward, as a dictionary": jax.jacfwd(evaluate),
            "forward, concatenated": jax.jacfwd(together),
            "central differences": central_differences(together, len(VARIABLES)),
        },
        designs,
        seconds,
    )
    expected = reference_jacobian(together, designs[0])
    value, *slopes = found.values()
    dictionary, concatenated, differences = slopes
    return {
        "quantities": list(names),
        "microseconds": {name: 1e6 * sample.seconds for name, sample in found.items()},
        "compile_s": {name: sample.compile_seconds for name, sample in found.items()},
        "processor_s": {name: s.compile_processor_seconds for name, s in found.items()},
        "over_value": {
            "dictionary": dictionary.seconds / value.seconds,
            "concatenated": concatenated.seconds / value.seconds,
        },
        "differences_over_forward": differences.seconds / concatenated.seconds,
        "error_forward": error_of(np.asarray(concatenated.found[0]), expected),
        "error_differences": error_of(np.asarray(differences.found[0]), expected),
    }


def hessian(example: str, name: str, count: int, seconds: float) -> dict[str, Any]:
    """Hessian of a scalar quantity by four numbers, and its derivative in reverse mode."""
    evaluate, centre = of_numbers(example, (name,), FOUR)

    def scalar(numbers):
        return evaluate(numbers)[name]

    designs = designs_around(centre, count)
    found = timed(
        {
            "value": scalar,
            "reverse": jax.grad(scalar),
            "forward over forward": jax.jacfwd(jax.jacfwd(scalar)),
        },
        designs,
        seconds,
    )
    value, reverse, second = found.values()
    expected = reference_jacobian(jax.jacfwd(scalar), designs[0])
    return {
        "quantity": name,
        "compile_s": {key: sample.compile_seconds for key, sample in found.items()},
        "processor_s": {key: s.compile_processor_seconds for key, s in found.items()},
        "microseconds": {key: 1e6 * sample.seconds for key, sample in found.items()},
        "reverse_over_value": reverse.seconds / value.seconds,
        "hessian_over_value": second.seconds / value.seconds,
        "error": error_of(np.asarray(second.found[0]), expected),
    }


def joint_to_single(example: str, names: tuple[str, ...], count: int, seconds: float) -> float:
    """Time of one concatenated Jacobian over those of its parts one by one."""
    evaluate, centre = of_numbers(example, names)
    parts = {name: jax.jacfwd(as_one(of_numbers(example, (name,))[0])) for name in names}
    found = timed(
        {**parts, "together": jax.jacfwd(as_one(evaluate))}, designs_around(centre, count), seconds
    )
    return found["together"].seconds / sum(found[name].seconds for name in names)


def tables(document: dict[str, Any]) -> str:
    """The results as Markdown."""
    lines = [
        f"Designs of `{document['example']}`, {document['designs']} at once, by "
        f"{', '.join(VARIABLES)}; times of a design.",
        "",
        "| quantities | value [µs] | Jacobian / value | concatenated / value "
        "| differences / Jacobian | error | error of differences | compile [s] |",
        "|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {', '.join(row['quantities'])} | {row['microseconds']['value']:.2f} "
        f"| {row['over_value']['dictionary']:.2f} | {row['over_value']['concatenated']:.2f} "
        f"| {row['differences_over_forward']:.2f} | {row['error_forward']:.0e} "
        f"| {row['error_differences']:.0e} | {row['compile_s']['forward, concatenated']:.1f} |"
        for row in document["joint"]
    ]
    lines += [
        "",
        f"Second derivatives by {', '.join(FOUR)}.",
        "",
        "| quantity | value [µs] | reverse / value | Hessian / value | error | compile [s] |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row['quantity']} | {row['microseconds']['value']:.2f} "
        f"| {row['reverse_over_value']:.2f} | {row['hessian_over_value']:.1f} | {row['error']:.0e} "
        f"| {row['compile_s']['forward over forward']:.1f} |"
        for row in document["hessians"]
    ]
    return "\n".join(lines) + "\n"


def main(argv: list[str] | None = None) -> int:
    """Entry point; with `--quick` the exit status is 1 where a limit of the guard is passed."""
    given = _arguments(argv)
    seconds = 0.3 if given.quick else 1.0
    subsets = [_THREE]
    if not given.quick:
        subsets += random_subsets(quantity_names(given.example), given.subsets, _SEED)
    document: dict[str, Any] = {
        "schema": 1,
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": versions(),
        "example": given.example,
        "designs": given.designs,
        "joint": [],
        "hessians": [],
    }
    for names in subsets:
        document["joint"].append(joint(given.example, names, given.designs, seconds))
        print(f"joint: {', '.join(names)}: {document['joint'][-1]['over_value']}", flush=True)
        _write(document, given.out)
        jax.clear_caches()
    for name in given.hessians[: 1 if given.quick else None]:
        document["hessians"].append(hessian(given.example, name, given.designs, seconds))
        _write(document, given.out)
        jax.clear_caches()
    print(tables(document))
    if not given.quick:
        return 0
    ratio = joint_to_single(given.example, _THREE, given.designs, seconds)
    compiled = document["hessians"][0]["processor_s"]["forward over forward"]
    print(f"together over one by one: {ratio:.2f} (limit {_LARGEST_JOINT_RATIO:g})")
    print(f"processor time of compiling: {compiled:.0f} s (limit {_LARGEST_HESSIAN_COMPILE:g} s)")
    return int(ratio > _LARGEST_JOINT_RATIO or compiled > _LARGEST_HESSIAN_COMPILE)


def _write(document: dict[str, Any], folder: Path) -> None:
    with written_whole(folder / "joint.json") as temporary:
        temporary.write_text(json.dumps(document, indent=1, ensure_ascii=False), encoding="utf-8")
    with written_whole(folder / "joint.md") as temporary:
        temporary.write_text(tables(document), encoding="utf-8")
