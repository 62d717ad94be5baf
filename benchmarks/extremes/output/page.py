# Examples have the parts that are changed here, and plain numbers become arrays when built:
# pyright: reportArgumentType=false, reportOptionalOperand=false, reportOperatorIssue=false
"""`docs/extremes.md`: what the matrix found, from its own run."""

from pathlib import Path

from ...harness import row_of, write_text
from ..cells import KINDS, STATUSES, Table, is_bad, total
from ..structures import STRUCTURES, structure
from .picture import GROUPS, write_pictures

_HEAD = """\
# The matrix of extremes

This page is written by `python -m benchmarks extremes --docs docs`. Do not edit it by hand.

A **row** is an extreme: one number at the end of its range, a seeded combination of several
numbers, or NaN, infinity, zero or the negative value of one number. A **column** is a quantity of
the catalogue, or a result of modes, steady state, a method of transients, load sharing or the
half-space. A **cell** compares with an independent reference, or finds
a refusal by name. Each pair of row and column has three cells: the value, its forward derivative
and its reverse derivative.

## References

| what | reference | agreement |
|---|---|---|
| thread, contacts, steady turning, modes | mpmath at 50 digits: common normal of the helicoids, \
elliptic integrals, balance of forces, eigenvalues | 1e-9, or the effect of a change of all \
numbers by 1e-13 |
| stages with unequal rollers or supports | full matrices in mpmath | 1e-9 |
| transients at constant speed | SciPy's Radau at 1e-9 on an independent right-hand side | 2e-6 \
of the largest value |
| half-space | Hertz | 3 % on 24 × 24 cells, the error of the grid |
| derivatives of transients whose method chooses its steps | differences of the closed form \
| 5e-5 of the slope, implicit 3e-4: the error of steps at the default tolerance |
| derivatives, forward | extrapolated differences along random directions, with their own error | \
1e-6 and ten times that error |
| derivatives, reverse | forward derivatives along the same direction | 1e-8 |
| float32, one row for each structure | float64 at the same rounded numbers | values 1e-3, \
derivatives 1e-2, and a hundred times the effect of a change of all numbers by 1.2e-7 |

A result without a reference is only checked to be finite. A derivative is open where differences
cannot confirm it: at kinks, and where rounding is larger than a hundredth of it. Where differences
disagree, they are repeated with steps down to 1e-12. A member of a repeated frequency is compared
by the mean over its root, because only the mean has a derivative.

Float32 is tested only at the ordinary numbers of each structure. Seven digits are not enough for
stiffnesses that differ by a factor of a million, and no result code reports this: use float64 for
extremes.

## Earlier runs

The same matrix, of nine structures, at the commit 3d12be5: 65,389 cells, 2,047 bad. Its ten
structures of one stage with 60 combinations, at the commit 5da1ae1: 97,196 cells, 301 bad.

## Corrections since the previous run

The previous run had 253,824 cells, 10 of them bad. Seven were reverse derivatives of integrated
transients, at a lead of 1e-6 m and next to the jamming limit: reverse mode chose its steps anew,
and rounding changed this choice. Now it repeats the steps of a first integration. Two were a
carrier ratio of 2e-10, as large as the absolute tolerance of the steps. One, and seven more that
this run found, were derivatives of values that are 0 except for rounding: an efficiency of 0, a
ring gear force of 8e-15 N, a gap of 1e-11 m. The effect of rounding on a derivative is now measured
before the derivative is called wrong; the seven were then judged again.

Five structures (implicit, rosenbrock, explicit, bristles, torque_quasi_steady) ran at the commit
8bdfda7 on a machine of 16 cores with JAX 0.11.2, 25 rows of the first three at cd3f9d1. The others
ran at 42ffaf6 with JAX 0.10.2, and the rows that were judged again at 1803913.

## Structure `reversing`: corrected and known errors

A structure that was added after this run, `reversing`, ran alone: a speed that oscillates through
standstill at 500 Hz about a mean speed, carriers integrated by RODASP. At first 91 of its 3,510
cells of 398 rows were bad, all of them derivatives, in 24 rows. The causes:

* Steps kept a reversal at a fixed time, so derivatives by a number that shifts it were incomplete:
  in the two-stage example with carriers a thousand times too heavy, 1.6 % by the amplitude and 5 %
  by the mean speed were missing. Now the steps next to a reversal move with it; at a relative
  tolerance of 1e-10 the derivatives agree with differences to 2e-5.
* Next to a standstill the time constants of the carriers are proportional to the speed. After the
  standstill each step was up to ten times longer than the one before, and multiplied deviations by
  20: derivatives grew up to 1e37, and no check found it. Now a step takes at most 0.32 of the time
  to a standstill, and 1.2 of the time since one.
* Outside the range of carrier speeds in which friction changes its direction, deviations grow. Long
  steps of RODASP did not change such a state, and estimated no error. They are rejected now.
* At the reversal itself a force jumps, so a sample there has no derivative. It counts as open now.

At the commit d449a6c, which corrected these errors, 14 of its cells are bad, in 3 rows. Two are
carrier ratios whose derivative is 1e-8, with an error of 10 times the absolute tolerance of the
steps. One is 0.001 from the limit of jamming: just after a reversal, the range of carrier speeds in
which friction changes its direction is narrower there than the tolerance. In about one of twelve
runs at slightly different tolerances, a derivative was then wrong by an arbitrary factor.

Derivatives follow the variational equation since (commit 8d66debe; see [solvers](solvers.md)). 6
cells are bad now, forward and reverse derivatives in 3 rows: two carrier ratios whose derivative is
below 1e-7, and one with a thousand times the friction of a thrust bearing, with an error of 5.9e-3.
5 more cells count as "accepted", but are no faults: a negative frequency is the same oscillation,
reversed in time.

The limit for derivatives of `reversing` is 3e-3 of the largest, plus ten times the error of the
differences (at least 5e-5), plus the kink that the differences show. That is looser than for other
structures. Friction has a kink where a force passes zero. A step across the kink has an error of
the order of its length in derivatives and of the order of its square in values, and tolerances
control values. Of 714 derivatives 173 have an error of more than 5e-5 of the largest, 52 of more
than 5e-4. Apart from the cells above, the largest error is 3.9e-3 (contact angle 30°). With
derivatives of the arithmetic of the steps, as before, 104 and 27 of 706 had such errors; but in
missions at 5 Hz, at a tolerance of 1e-5, half of the designs had one that was off by more than
10 %.

"""


def _colours() -> list[str]:
    lines = ["| colour | status | meaning | a fault |", "|---|---|---|---|"]
    for name, status in STATUSES.items():
        if name == "absent":
            continue
        patch = (
            f'<span style="background:{status.colour};padding:0 0.8em;'
            f'border:1px solid #888"></span>'
        )
        fault = "yes" if status.bad else "no"
        lines.append(f"| {patch} | {name.replace('_', ' ')} | {status.meaning} | {fault} |")
    return lines


def _counts(tables: list[Table]) -> list[str]:
    names = [name for name in STATUSES if name != "absent"]
    head = [
        "structure",
        "rows",
        "combinations",
        "columns",
        *(name.replace("_", " ") for name in names),
    ]
    lines = [row_of(head), "|" + "---|" * len(head)]
    for table in tables:
        counts = table.counts()
        mixed = sum(row["group"] == "combination" for row in table.rows)
        numbers = len(table.rows), mixed, len(table.columns)
        row = [structure(table.structure).title, *map(str, numbers)]
        lines.append(row_of(row + [str(counts[name]) for name in names]))
    counts = total(tables)
    row = ["**all**", str(sum(len(t.rows) for t in tables)), "", ""]
    lines.append(row_of(row + [str(counts[name]) for name in names]))
    return lines


def _faults(tables: list[Table]) -> list[str]:
    found: dict[tuple[str, str, str, str], list[str]] = {}
    for table in tables:
        for row, column, kind, cell in table.bad():
            found.setdefault((table.structure, column, kind, cell.status), []).append(
                f"{row}: {cell.detail}"
            )
    if not found:
        return ["No cell is bad."]
    lines = ["| structure | column | kind | status | cells | first |", "|---|---|---|---|---|---|"]
    for (name, column, kind, status), rows in found.items():
        first = rows[0].replace("|", "\\|")
        lines.append(f"| {name} | {column} | {kind} | {status} | {len(rows)} | {first} |")
    return lines


def _largest(tables: list[Table]) -> list[str]:
    lines = ["| structure | value | forward | reverse |", "|---|---|---|---|"]
    for table in tables:
        worst = []
        for place in range(len(KINDS)):
            errors = [
                three[place].error
                for columns in table.cells.values()
                for three in columns.values()
                if three[place].status == "agrees" and three[place].error is not None
            ]
            worst.append(f"{max(errors):.1e}" if errors else "")
        lines.append(row_of([table.structure, *worst]))
    return lines


def write_page(tables: list[Table], folder: Path, arguments, seconds: float) -> list[Path]:
    """Write the page and its pictures; returns their paths."""
    titled = [(table, structure(table.structure).title) for table in tables]
    pictures = write_pictures(titled, folder / "images" / "extremes")
    counts = total(tables)
    bad = sum(number for name, number in counts.items() if is_bad(name))
    cells = sum(counts.values())
    lines = [_HEAD, "## This run", ""]
    lines.append(
        f"Seed {arguments.seed}, up to {arguments.rows} combinations, {len(tables)} structures: "
        f"{cells:,} cells, {bad:,} bad, in {seconds / 60:.0f} minutes of busy cores."
    )
    absent = [name for name in STRUCTURES if name not in {table.structure for table in tables}]
    if absent:
        lines += ["", f"Not in this run: {', '.join(absent).replace('_', ' ')}."]
    lines += ["", *_colours(), "", *_counts(tables), "", "## Faults", "", *_faults(tables), ""]
    lines += ["## Largest errors of cells that agree", ""]
    lines += [
        "Large errors occur where a change of all numbers by 1e-13 has the same effect, as next to "
        "jamming, or where the value is 0 except for rounding.",
        "",
    ]
    lines += [*_largest(tables), ""]
    lines += [
        "## Pictures",
        "",
        "The colour of a pair is that of the worst of its three cells.",
        "",
    ]
    for name, group, path in pictures:
        relative = path.relative_to(folder).as_posix()
        lines += [f"![{structure(name).title}: {GROUPS[group]}]({relative})", ""]
    page = write_text(folder / "extremes.md", "\n".join(lines))
    return [page, *(path for _, _, path in pictures)]
