"""`docs/catalogue_benchmark.md`, its picture and its data, from the run's own JSON."""

import math
import textwrap
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..harness import table_of, time_text, where_and_when, write_json, write_text
from .picture import TITLES, draw, percents
from .problem import LOWER, MEASURES, OBJECTIVES, UPPER, VARIABLES
from .search import FEASIBLE
from .statement import STATEMENT

#: A result counts as better than another one from this difference of the objective on.
EQUAL = 1e-4
_CUT = "truncation_load"
#: A size counts as improved from this smallest gain on.
IMPROVED = 1e-6

Rows = Sequence[Mapping[str, Any]]


def _column(rows: Rows, *path: str) -> np.ndarray:
    found = []
    for row in rows:
        value: Any = row
        for key in path:
            value = value[key]
        found.append(value)
    return np.array(found, dtype=float)


def objectives_of_rival(rows: Rows, form: str, chosen: Callable[..., Any]) -> np.ndarray:
    """Objectives of NSGA-II, of the best, median or other choice of its runs."""
    return np.array([chosen([run["objective"] for run in row["rivals"][form]]) for row in rows])


def _digits(value: float) -> str:
    """Four digits after the point, without the sign of a zero."""
    return f"{round(float(value), 4) + 0.0:.4f}"


def _percent(value: float) -> str:
    return f"{value:.1f} %"


def _per_problem(document: Mapping[str, Any], heads: Sequence[str], cells: Any) -> list[str]:
    """A table with a column for each problem."""
    problems = document["problems"].values()
    rows = [[head, *(cells(one)[head] for one in problems)] for head in heads]
    return table_of(["", *(TITLES[name] for name in document["problems"])], rows)


def _summary(problem: Mapping[str, Any]) -> dict[str, str]:
    rows = problem["sizes"]
    t = _column(rows, "objective")
    improved = np.array(
        [[percents(rows, name)[i] > 0 for name in OBJECTIVES] for i in range(len(rows))]
    ).all(axis=1) & (t > IMPROVED)
    # The size's own design has t = 0.
    own = [row["objective_by_starts"].get(str(row["own_starts"]), 0.0) for row in rows]
    pressures = _column(rows, "checked", "over_own", "max_pressure")
    angles = np.degrees(_column(rows, "variables", "contact_angle"))
    centred, flat = (np.median(problem["objective_by_flattest_profile"][key]) for key in ("1", "3"))
    return {
        "sizes improved in all three": f"{improved.sum()} of {len(rows)}",
        "median increase of dynamic capacity": _percent(
            float(np.median(percents(rows, "dynamic_capacity")))
        ),
        "median increase of axial stiffness": _percent(
            float(np.median(percents(rows, "axial_stiffness")))
        ),
        "median decrease of mass": _percent(float(np.median(percents(rows, "nut_unit_mass")))),
        "t: smallest, median, largest": ", ".join(map(_digits, (t.min(), np.median(t), t.max()))),
        "λ: smallest, median, largest [deg]": (
            f"{angles.min():.3f}, {np.median(angles):.3f}, {angles.max():.3f}"
        ),
        "median t with the size's own starts": _digits(np.median(own)),
        "median t if κ may be at most 1": _digits(centred),
        "median t if κ may be up to 3": _digits(flat),
        "largest KKT residual": f"{_column(rows, 'kkt_residual').max():.0e}",
        "largest violation of a limit": f"{_column(rows, 'violation').max():.0e}",
        "largest difference of an independent evaluation": (
            f"{_column(rows, 'checked', 'difference').max():.0e}"
        ),
        "errors of `check`": str(sum(len(row["checked"]["errors"]) for row in rows)),
        "smallest ratio of buckling loads": (
            f"{_column(rows, 'checked', 'over_own', 'buckling_load').min():.4f}"
        ),
        "largest ratio of pressures at the operating point": f"{pressures.max():.4f}",
        "sizes where this pressure rises": str((pressures > 1 + IMPROVED).sum()),
    }


def _not_improved(document: Mapping[str, Any]) -> list[str]:
    """A paragraph for each problem in which some sizes are not improved."""
    lines: list[str] = []
    for name, problem in document["problems"].items():
        rows = [row for row in problem["sizes"] if not row["objective"] > IMPROVED]
        if not rows:
            continue
        # Lines do not break within a name.
        sizes = ", ".join(row["size"].partition(",")[0].replace(" ", "\u00a0") for row in rows)
        cut = sum(row["limits"][_CUT] == row["own"][_CUT] for row in rows)
        text = (
            f"With {TITLES[name]}, these sizes are not improved: {sizes}. In {cut} of {len(rows)} "
            "the operating load already cuts an ellipse of the size's own design, so the limit of "
            f"`{_CUT}` is its own value."
        )
        lines += ["", *textwrap.wrap(text, 100)]
    return lines


def _effort(problem: Mapping[str, Any]) -> dict[str, str]:
    rows = problem["sizes"]
    ours = {
        "searches in the batch": str(problem["searches"]),
        "evaluations with derivatives, per size": f"{problem['evaluations'] / len(rows):.1f}",
        "the same as designs, derivatives by four variables counted": (
            f"{problem['designs_per_size']:.0f}"
        ),
        "run time, all sizes": (
            f"{time_text(problem['seconds'])}; first call {time_text(problem['first_s'])}"
        ),
    }
    left_out = problem.get("left_out")
    return {**ours, **({"NSGA-II": left_out} if left_out else _against_rival(rows))}


def _against_rival(rows: Rows) -> dict[str, str]:
    runs = [run for row in rows for run in row["rivals"]["one"]]
    t = _column(rows, "objective")
    best = objectives_of_rival(rows, "one", max)
    three = objectives_of_rival(rows, "three", max)
    rival_s = sum(run["seconds"] for run in runs) / len(rows[0]["rivals"]["one"])
    ratios = best[t > EQUAL] / t[t > EQUAL]
    return {
        "NSGA-II: designs per size and run": f"{np.mean([r['evaluations'] for r in runs]):.0f}",
        "NSGA-II: run time, all sizes, one run": time_text(rival_s),
        "sizes where gradients are better, equal, worse": (
            f"{(t > best + EQUAL).sum()}, {(abs(t - best) <= EQUAL).sum()}, "
            f"{(t < best - EQUAL).sum()}"
        ),
        "t of NSGA-II over t of gradients: smallest, median": (
            f"{ratios.min():.3f}, {np.median(ratios):.3f}" if len(ratios) else "–"
        ),
        "the same, three objectives instead of one": (
            f"{(three[t > EQUAL] / t[t > EQUAL]).min():.3f}, "
            f"{np.median(three[t > EQUAL] / t[t > EQUAL]):.3f}"
            if len(ratios)
            else "–"
        ),
        "improved sizes that NSGA-II does not improve": (
            f"{((best <= IMPROVED) & (t > IMPROVED)).sum()} of {(t > IMPROVED).sum()}"
        ),
    }


_STARTS = ("the size's own starts", "one start more", "two or more starts more")


def _at_bounds(rows: Rows) -> dict[str, int]:
    """How many results lie at each bound and each limit."""
    counted: Counter[str] = Counter(dict.fromkeys(_STARTS, 0))
    for row in rows:
        found = row["variables"]
        for name, low, high in zip(VARIABLES, LOWER, UPPER, strict=False):
            counted[f"`{name}` at its lower bound"] += found[name] - low < FEASIBLE
            counted[f"`{name}` at its upper bound"] += high - found[name] < FEASIBLE
        counted["as many rollers as fit"] += round(found["roller_count"]) == row["most_rollers"]
        more = row["starts"] - row["own_starts"]
        counted[_STARTS[min(more, 2)]] += 1
        counted["most starts that may be chosen"] += row["starts"] == row["most_starts"]
        for name in MEASURES:
            counted[f"`{name}` active"] += name in row["active"]
    return counted


def _bounds(document: Mapping[str, Any]) -> list[str]:
    counted = [_at_bounds(one["sizes"]) for one in document["problems"].values()]
    names = list(dict.fromkeys(name for one in counted for name in one))
    rows = [[name, *(str(one.get(name, 0)) for one in counted)] for name in names]
    return table_of(["sizes with", *(TITLES[name] for name in document["problems"])], rows)


def _best_values(rows: Rows) -> list[str]:
    heads = ["size", "starts", "rollers", "λ [deg]", "κ", "ρ [mm]", "D [mm]", "l [mm]"]
    heads += ["C [kN]", "K [N/µm]", "m [kg]", "t", "t, NSGA-II"]
    return table_of(heads, map(_cells, rows))


def _cells(row: Mapping[str, Any]) -> list[str]:
    found, own, best = row["variables"], row["own"], row["measures"]
    runs = [run["objective"] for run in row["rivals"]["one"]]
    pairs = [
        (own["dynamic_capacity"] * 1e-3, best["dynamic_capacity"] * 1e-3),
        (own["axial_stiffness"] * 1e-6, best["axial_stiffness"] * 1e-6),
        (own["nut_unit_mass"], best["nut_unit_mass"]),
    ]
    return [
        row["size"].partition(",")[0],
        f"{row['own_starts']} → {row['starts']}",
        f"{row['own_rollers']} → {round(found['roller_count'])}",
        f"{math.degrees(found['contact_angle']):.3f}",
        f"{found['profile_ratio']:.3f}",
        f"{row['profile_radius_mm']:.3f}",
        f"{row['nut_outer_diameter_mm']:.2f}",
        f"{row['nut_length_mm']:.2f}",
        *(f"{before:.4g} → {after:.4g}" for before, after in pairs),
        _digits(row["objective"]),
        _digits(max(runs)) if runs else "–",
    ]


def page_of(document: Mapping[str, Any]) -> str:
    """The page as Markdown."""
    problems = document["problems"]
    one = next(iter(problems.values()))
    lines = [STATEMENT, "## Results", ""]
    lines += _per_problem(document, list(_summary(one)), _summary)
    lines += [
        "",
        _RESULTS,
        *_not_improved(document),
        "",
        "![Change of each objective](images/catalogue_benchmark.png)",
        "",
    ]
    lines += ["## Where the optimum lies", "", *_bounds(document), "", _LIES, ""]
    lines += ["## Gradients against NSGA-II", ""]
    lines += _per_problem(document, list(_effort(one)), _effort)
    if not any(problem.get("left_out") for problem in problems.values()):
        runs = "one run" if document["seeds"] == 1 else f"{document['seeds']} runs"
        numbers = {"times": document["times"], "population": document["population"]}
        lines += ["", _RIVAL.format(**numbers, runs=runs)]
    lines += ["", f"{where_and_when(document)}.", ""]
    for name, problem in problems.items():
        lines += [f"## Best values: {TITLES[name]}", "", _VALUES, ""]
        lines += [*_best_values(problem["sizes"]), ""]
    return "\n".join(lines)


_RESULTS = """\
A size counts as improved if capacity and stiffness are larger and the mass is smaller, all by more
than a millionth. The independent evaluation builds each result by `plain_catalogue_mechanism` with
a fixed number of rollers and calls `prsm.compute` and `prsm.check`; its difference is relative. The
KKT residual is the largest component of the gradient of the Lagrangian by t and by the variables
over their ranges, with the multipliers of active limits and bounds, none of them negative. The
lines with κ are results with another upper bound of κ. Ratios are to the size's own design;
buckling load and pressure are not limited."""
_LIES = """\
At 30 x 5 mm, the efficiency of a driving screw is largest at a contact angle of 46.8°, the
efficiency under a driving load at 43.4°: the normal force is proportional to 1/sin λ, and the
sliding grows with 1/cos λ. Any angle other than 45° lowers one of the two. Without any loss of
efficiency the angle therefore stays at 45°, and the gain comes from a flatter profile and from more
starts. If the efficiencies may fall by half of the last digit that the catalogue prints, the angle
rises until that limit is reached. One start more makes rollers smaller and more numerous, the pitch
finer and the nut narrower.

An active limit of `dynamic_capacity`, `axial_stiffness` or `nut_unit_mass` means that this gain is
the smallest one. Where κ is at its upper bound, the gain depends on that bound."""
_RIVAL = """\
NSGA-II (pymoo, default operators, {population} designs in a generation, {runs}) has the same
variables, with whole numbers of starts and rollers, the same bounds, limits and tolerance of 1e-7,
and evaluates a generation as one batch. It gets {times:g} times as many designs per size as the
batch on average, where each derivative by a variable counts as a design. The size's own design is
in its first generation. Its best run counts. In another run it has three objectives, the three
gains; the result is then the evaluated design with the largest t. Results are equal if their t
differs by at most 1e-4: without loss of efficiency the tolerance alone changes t by about 1e-5.
Run times are without compilation; those of the batch are of all searches, and the first call
includes compilation and building."""
_VALUES = """\
Own value → best value. λ contact angle, κ ratio of profile radii, ρ profile radius of the roller, D
and l outer diameter and length of the nut, C dynamic capacity, K axial stiffness, m mass of the nut
unit, t smallest gain."""


def write_page(document: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write the page, its picture and its data.

    **Arguments:**

    - `document`: what `catalogue.json` has.
    - `folder`: that of the documentation.

    **Returns:** their paths.
    """
    return [
        write_text(folder / "catalogue_benchmark.md", page_of(document)),
        draw(document, folder / "images" / "catalogue_benchmark.png"),
        write_json(folder / "catalogue_benchmark.json", document, allow_nan=False),
    ]
