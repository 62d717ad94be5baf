"""The tables of joint derivatives, and `docs/joint_derivatives.md` from the runs' own JSON."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..harness import write_text
from .measured import FOUR, VARIABLES
from .picture import draw

_HEAD = """\
# Derivatives of several quantities together

This page is written by `python -m benchmarks joint --page FILES --docs docs`. Do not edit it by
hand.

Natural frequencies, efficiency and contact pressure are needed together, with their derivatives.
The first row of each table has these three, every other row a random subset of two to six
quantities. Everything is computed for a batch of designs within a thousandth of the example, by one
program under `jax.jit` and `jax.vmap`, with derivatives by {variables}:

* the **value** alone;
* **dictionary**: value and Jacobian, by `jax.jacfwd` of a function that returns a dictionary;
* **concatenated**: the same of a function that concatenates the quantities to one array;
* **differences**: central differences of the values.

Run times are the best of samples that were taken in turn in one run, so their ratios are valid.
Errors are relative to the largest derivative of each number, at one design, against differences of
sixth order. These differences have errors of 1e-12 to 1e-8, so the tables give upper limits for the
errors of Jacobians.
"""

_WHY = """\
XLA for CPUs recomputes the operands of a concatenation or a stack for each of its elements. Before
the correction, the Jacobian of the first row of the actuator took 724 µs per design when
concatenated and 10 µs as a dictionary. Parts of the physics are now calls that XLA
does not replace by their operations (`numerics.apart`), so that it does not fuse later operations
into them. Each part is cut into pieces of a
few dozen operations where few numbers pass from one piece to the next: within a part, too, XLA
repeats the calculation of a number for each operation that uses it.

A Jacobian by three numbers needs three derivatives of each operation in addition to the operation
itself; central differences need six values. If the value needs an iteration, the derivative at the
root does not, and the ratio is near 1; shear stresses below the surface are an example. Where the
value takes less than a microsecond, the ratio is largest, and differences cost about as much as two
Jacobians.
"""


def _goals(document: Mapping[str, Any]) -> list[str]:
    """Lines that count how often each goal is met."""
    rows, seconds = document["joint"], document["hessians"]
    counted: list[tuple[str, Sequence[Any], Callable[[Any], bool]]] = [
        ("dictionary at most 3 values", rows, lambda row: row["over_value"]["dictionary"] <= 3),
        ("concatenated at most 3 values", rows, lambda row: row["over_value"]["concatenated"] <= 3),
        (
            "concatenated at most 1.5 times the dictionary",
            rows,
            lambda row: row["over_value"]["concatenated"] <= 1.5 * row["over_value"]["dictionary"],
        ),
        (
            "differences at least 2 times the concatenated Jacobian",
            rows,
            lambda row: row["differences_over_forward"] >= 2,
        ),
        (
            "error below a tenth of that of differences",
            rows,
            lambda row: row["error_forward"] < 0.1 * row["error_differences"],
        ),
        ("reverse mode at most 5 values", seconds, lambda row: row["reverse_over_value"] <= 5),
        ("Hessian at most 40 values", seconds, lambda row: row["hessian_over_value"] <= 40),
        (
            "Hessian compiled within 15 s",
            seconds,
            lambda row: row["compile_s"]["forward over forward"] <= 15,
        ),
    ]
    return [
        f"| {name} | `{document['example']}` | {sum(map(met, of))} of {len(of)} |"
        for name, of, met in counted
        if of
    ]


def tables(document: Mapping[str, Any]) -> str:
    """The results of one example as Markdown."""
    lines = [
        f"Designs of `{document['example']}`, {document['designs']} at once, by "
        f"{', '.join(VARIABLES)}; times per design; subsets measured: {len(document['joint'])}.",
        "",
        "| quantities | value [µs] | dictionary / value | concatenated / value "
        "| differences / concatenated | error, dictionary | error, concatenated "
        "| error, differences | compile [s] |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {', '.join(row['quantities'])} | {row['microseconds']['value']:.2f} "
        f"| {row['over_value']['dictionary']:.2f} | {row['over_value']['concatenated']:.2f} "
        f"| {row['differences_over_forward']:.2f} | {row['error_dictionary']:.0e} "
        f"| {row['error_forward']:.0e} | {row['error_differences']:.0e} "
        f"| {row['compile_s']['forward, concatenated']:.1f} |"
        for row in document["joint"]
    ]
    if not document["hessians"]:
        return "\n".join(lines) + "\n"
    lines += [
        "",
        f"Second derivatives by {', '.join(FOUR)}.",
        "",
        "| quantity | value [µs] | reverse / value | Hessian / value | error | compile [s] "
        "| processor time of compiling [s] |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row['quantity']} | {row['microseconds']['value']:.2f} "
        f"| {row['reverse_over_value']:.2f} | {row['hessian_over_value']:.1f} | {row['error']:.0e} "
        f"| {row['compile_s']['forward over forward']:.1f} "
        f"| {row['processor_s']['forward over forward']:.1f} |"
        for row in document["hessians"]
    ]
    return "\n".join(lines) + "\n"


def write_page(documents: Sequence[Mapping[str, Any]], folder: Path) -> list[Path]:
    """Write the page and its picture.

    **Arguments:**

    - `documents`: what `joint-<example>.json` has, one of each example.
    - `folder`: that of the documentation.

    **Returns:** their paths.
    """
    picture = draw(documents, folder / "images" / "joint_derivatives.png")
    machine = documents[0]["machine"]
    lines = [_HEAD.format(variables=", ".join(name.replace("_", " ") for name in VARIABLES))]
    lines += ["## Goals", "", "| goal | example | met |", "|---|---|---|"]
    for document in documents:
        lines += _goals(document)
    lines += [
        "",
        "![Jacobians and differences over the value](images/joint_derivatives.png)",
        "",
        _WHY,
    ]
    for document in documents:
        lines += [f"## `{document['example']}`", "", tables(document)]
    lines += [
        f"On {machine['cores']} cores of a busy machine ({machine['processor']}), "
        f"{documents[0]['date'][:10]}. On a busy machine compile times are too long.",
        "",
    ]
    return [write_text(folder / "joint_derivatives.md", "\n".join(lines)), picture]
