"""The front of several objectives: its picture, the JSON of its verb, and the printed table."""

import dataclasses
import json

import numpy as np
import pytest
import scenes
from expectations import reads
from matplotlib import colormaps
from reading_figures import Chart, handles
from reading_tables import assert_json, column_unit, without_words
from reading_units import label_unit, same_dimension, to_si

from prsm_jax.cli import main
from prsm_jax.mechanism import DesignProblem, Objective, Variable
from prsm_jax.optimisation import ConstraintReport, FrontPoint, ParetoFront
from prsm_jax.report import front_chart, parallel_chart
from tests.compilation_cache import cache_folder


def _made(*senses: tuple[str, str, str, tuple[float, ...]]):
    """A front of three points and the present design, of which no two numbers are alike.

    **Arguments:**

    - `senses`: quantity, its unit and sense, and its values: the present design first.
    """
    names = [one[0] for one in senses]

    def point(index, status, residual):
        return FrontPoint(
            variables={"lead": 0.0101 + 1e-3 * index},
            objectives={name: values[index] for name, _, _, values in senses},
            constraints={"max_pressure": 1.5e9 + 1e7 * index},
            margins={"backlash (stage 1)": 1e-6 * (index + 3)},
            weights={} if not index else dict(zip(names, (0.1 * index, 0.7, 0.2), strict=False)),
            active=("max_pressure", "upper bound of lead")[:index],
            kkt_residual=residual,
            violation=1e-9 * index,
            status=status,
            message=f"message {index}",
        )

    problem = DesignProblem(
        (Variable("lead", 0.005, 0.02),),
        tuple(Objective(name, sense) for name, _, sense, _ in senses),  # type: ignore[arg-type]
    )
    return ParetoFront(
        mechanism=scenes.example("wu2022"),
        problem=problem,
        points=(
            point(1, "optimal", 1.1e-9),
            point(2, "optimal", 2.2e-8),
            point(3, "not converged", 3.3e-3),
        ),
        start=point(0, "present design", float("nan")),
        dropped=(point(2, "repeated", 4.4e-7),),
        hypervolume=0.617,
        reference=dict(zip(names, (0.7, 0.077, 3.3), strict=False)),
        ideal=dict(zip(names, (0.91, 0.051, 1.1), strict=False)),
        tolerance=1e-6,
        message="two points of three",
        evaluations=41,
        derivative_evaluations=37,
        variable_units={"lead": "m"},
        objective_units={name: unit for name, unit, _, _ in senses},
    )


EFFICIENCY = ("efficiency", "1", "maximise", (0.841, 0.862, 0.853, 0.847))
DIAMETER = ("nut_outer_diameter", "m", "minimise", (0.0611, 0.0582, 0.0563, 0.0541))
MASS = ("mass", "kg", "minimise", (1.61, 1.52, 1.57, 1.43))


def _breaking(one):
    """The design as one that breaks two limits."""
    words: dict = {"equal": None, "active": False, "satisfied": False, "multiplier": 0.0}
    pressure = ConstraintReport("max_pressure", "Pa", 1.5e9, None, 1.4e9, limit=1.4e9, **words)
    play = ConstraintReport("backlash (stage 1)", "m", -3e-6, 0.0, None, limit=0.0, **words)
    return dataclasses.replace(one, broken=(pressure, play))


def _read_panel(chart, axes, x, y):
    units = (x[1], y[1])
    if len(chart.axes) == 1:
        line = next(one for one in chart.lines(axes) if one.get_linestyle() == "-")
        chart.curve(axes, line, x[3][1:], y[3][1:], units)
    dots, hollow, square = chart.lines(axes)
    chart.curve(axes, dots, x[3][1:3], y[3][1:3], units)
    chart.curve(axes, hollow, x[3][3], y[3][3], units)
    assert hollow.get_markerfacecolor() == "white"
    chart.curve(axes, square, x[3][0], y[3][0], units)
    assert f"({x[2]})" in axes.get_xlabel()
    assert f"({y[2]})" in axes.get_ylabel()


@reads("chart", "front_chart")
def test_two_objectives_in_one_picture():
    chart = Chart(front_chart(_made(EFFICIENCY, DIAMETER)))
    (axes,) = chart.axes
    _read_panel(chart, axes, EFFICIENCY, DIAMETER)
    assert handles(chart.figure) == ["front", "not converged", "present design"]
    chart.finish()


def test_three_objectives_in_three_projections():
    chart = Chart(front_chart(_made(EFFICIENCY, DIAMETER, MASS)))
    pairs = ((EFFICIENCY, DIAMETER), (EFFICIENCY, MASS), (DIAMETER, MASS))
    for axes, (x, y) in zip(chart.axes, pairs, strict=True):
        _read_panel(chart, axes, x, y)
    chart.finish()


@reads("chart", "parallel_chart")
def test_designs_across_variables_and_objectives():
    """Heights are read on the scale of each axis, in the unit that stands below it."""
    chart = Chart(parallel_chart(_made(EFFICIENCY, DIAMETER, MASS)))
    axes, *scales, bar = chart.axes
    labels = [label.get_text().replace("\n", " ") for label in axes.get_xticklabels()]
    assert labels == [
        "lead in mm",
        "efficiency in % (maximise)",
        "nut outer diameter in mm (minimise)",
        "mass in kg (minimise)",
    ]
    lead = (0.0101, 0.0111, 0.0121, 0.0131)
    columns = [("m", lead), *((one[1], one[3]) for one in (EFFICIENCY, DIAMETER, MASS))]
    lines = chart.lines(axes)
    assert len(lines) == 4
    for place, (label, own, (unit, values)) in enumerate(zip(labels, scales, columns, strict=True)):
        assert same_dimension(label_unit(label), unit)
        low, high = own.get_ylim()
        # The axis stands where the lines have their corners.
        assert own.spines["right"].get_position() == ("data", place)
        for line, value in zip(lines, (*values[1:], values[0]), strict=True):
            assert np.asarray(line.get_xdata())[place] == place
            shown = low + np.asarray(line.get_ydata())[place] * (high - low)
            assert to_si(shown, label_unit(label)) == pytest.approx(value, rel=1e-12)
    assert [line.get_linestyle() for line in lines] == ["-", "-", ":", "--"]
    assert bar.get_ylabel() == "efficiency in %"
    low, high = to_si(bar.get_ylim(), "%")
    assert (low, high) == pytest.approx((0.847, 0.862))
    for line, value in zip(lines[:3], EFFICIENCY[3][1:], strict=True):
        assert line.get_color() == colormaps["cividis"]((value - low) / (high - low))
    assert handles(chart.figure) == ["not converged", "present design"]
    chart.ignore([*lines, *bar.collections, *bar.patches, *bar.lines])
    assert chart.text("3 designs of the front")
    chart.finish()


def test_the_legend_names_limits_that_the_present_design_breaks():
    front = _made(EFFICIENCY, DIAMETER)
    front = dataclasses.replace(front, start=_breaking(front.start))
    for chart in (front_chart, parallel_chart):
        words = " ".join(handles(chart(front))[-1].split())
        assert words == "present design, breaks max pressure, backlash (stage 1) of prsm check"


def test_a_number_that_all_designs_share_lies_in_the_middle_of_its_axis():
    level = ("mass", "kg", "minimise", (1.5, 1.5, 1.5, 1.5))
    chart = Chart(parallel_chart(_made(EFFICIENCY, level)))
    own = chart.axes[3]
    assert sum(own.get_ylim()) / 2 == pytest.approx(1.5)
    for line in chart.axes[0].lines:
        assert np.asarray(line.get_ydata())[2] == pytest.approx(0.5)


def test_a_present_design_that_fails_is_left_out():
    front = _made(EFFICIENCY, MASS)
    start = dataclasses.replace(
        front.start, status="fails", objectives=dict.fromkeys(front.start.objectives, np.nan)
    )
    chart = Chart(parallel_chart(dataclasses.replace(front, start=start)))
    assert len(chart.axes[0].lines) == 3
    assert handles(chart.figure) == ["not converged"]


def test_a_front_without_points_is_refused():
    empty = dataclasses.replace(_made(EFFICIENCY, DIAMETER), points=(), message="none feasible")
    for chart in (front_chart, parallel_chart):
        with pytest.raises(ValueError, match=r"no points.*none feasible"):
            chart(empty)


def test_without_a_feasible_design_the_first_line_says_so(monkeypatch, tmp_path, capsys):
    """JSON and exit status too; no picture is made, and one of an earlier run is named."""
    made = _made(EFFICIENCY, DIAMETER)
    far = dataclasses.replace(_breaking(made.points[0]), status="infeasible", violation=0.4)
    near = dataclasses.replace(_breaking(made.points[1]), status="infeasible", violation=0.2)
    message = "no feasible design found; the design of least violation has max_pressure = 1500"
    empty = dataclasses.replace(made, points=(), dropped=(far, near), message=message)
    monkeypatch.setattr("prsm_jax.optimisation.pareto", lambda *_, **__: empty)
    words = ["pareto", "wu2022", "--out", str(tmp_path / "o")]
    monkeypatch.setenv("PRSM_JAX_CACHE", cache_folder())
    monkeypatch.setenv("COLUMNS", "300")
    assert main(words) == 1
    out = capsys.readouterr().out
    lines = out.splitlines()
    assert lines[0] == f"NO FEASIBLE DESIGN: {message}"
    assert lines.index(next(one for one in lines if one.startswith("least violation"))) < (
        lines.index(next(one for one in lines if one.startswith("start")))
    )
    assert "no file written: without a feasible design there is no picture" in lines
    assert main([*words, "--json", "-"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert (found["valid"], found["points"], found["pictures"]) == (False, [], [])
    assert_json(found["least_violation"], _keys(near))


def _keys(one):
    return {
        "variables": dict(one.variables),
        "quantities": one.objectives | one.constraints,
        "margins": dict(one.margins),
        "weights": dict(one.weights),
        "active": list(one.active),
        "kkt_residual": None if np.isnan(one.kkt_residual) else one.kkt_residual,
        "violation": one.violation,
        "status": one.status,
        "message": one.message,
        "broken": [
            {"name": row.name, "unit": row.unit, "value": row.value, "limit": row.limit}
            for row in one.broken
        ],
    }


@reads("verb", "pareto")
def test_pareto(run, monkeypatch, tmp_path):
    front = _made(EFFICIENCY, DIAMETER)
    # Otherwise the exit status is 1.
    points = tuple(dataclasses.replace(one, status="optimal") for one in front.points)
    start = _breaking(front.start)
    front = dataclasses.replace(front, points=points, start=start, message="every point is")
    given = {}

    def found_by(*arguments, **options):
        given["objectives"] = arguments[1]
        return front

    monkeypatch.setattr("prsm_jax.optimisation.pareto", found_by)
    words = (
        "--maximise",
        "efficiency",
        "--minimise",
        "nut_outer_diameter",
        "--out",
        tmp_path / "o",
    )
    found, printed = run("pareto", "wu2022", *words)
    assert given["objectives"] == list(front.objectives)
    assert {path.stem for path in (tmp_path / "o").iterdir()} == {"front", "front-parallel"}
    pictures = [f"{name}.{kind}" for name in ("front", "front-parallel") for kind in ("png", "svg")]
    assert_json(
        without_words(found),
        {
            "objectives": [
                {"quantity": "efficiency", "sense": "maximise"},
                {"quantity": "nut_outer_diameter", "sense": "minimise"},
            ],
            "points": [_keys(one) for one in front.points],
            "start": _keys(front.start),
            "dropped": [_keys(one) for one in front.dropped],
            "hypervolume": 0.617,
            "hypervolume_reference": {"efficiency": 0.7, "nut_outer_diameter": 0.077},
            "ideal": {"efficiency": 0.91, "nut_outer_diameter": 0.051},
            "converged": True,
            "message": "every point is",
            "evaluations": 41,
            "derivative_evaluations": 37,
            "variable_units": {"lead": "m"},
            "objective_units": {"efficiency": "1", "nut_outer_diameter": "m"},
            "least_violation": None,
            "pictures": [str(tmp_path / "o" / name) for name in pictures],
        },
    )
    head = next(line for line in printed.lines if line[0].startswith("maximise efficiency"))
    printed.lines.remove(head)
    assert [column_unit(cell) for cell in head[:3]] == ["%", "mm", "mm"]
    for name, one in (("start", front.start), *zip("123", front.points, strict=True)):
        cells = printed.row(name)
        values = [*one.objectives.values(), *one.variables.values()]
        shown = [
            float(to_si(float(cell), unit))
            for cell, unit in zip(cells, ("%", "mm", "mm"), strict=False)
        ]
        assert shown == pytest.approx(values, rel=5e-6)
        residual = "–" if np.isnan(one.kkt_residual) else f"{one.kkt_residual:.6g}"
        assert cells[3] == residual
        breaks = (
            ", breaks max_pressure, backlash (stage 1) of prsm check" if name == "start" else ""
        )
        assert cells[4] == one.status + breaks
    printed.row("converged: every point is")
    printed.row(
        "3 points; 41 evaluations of values, 37 of derivatives; the front dominates 61.7 % of the "
        "box up to its reference point"
    )
    printed.finish()
