"""The benchmark harness on a toy: areas of circles with π to a few digits."""

import json
import time

import numpy as np
import pytest

from benchmarks.__main__ import main, run
from benchmarks.cases import case_names
from benchmarks.harness import (
    SCHEMA,
    Budget,
    Case,
    Method,
    Prepared,
    Problem,
    Reference,
    document,
    measure,
    summarise,
    survivors,
    table,
    write,
    written_whole,
)

_BUDGET = Budget(rounds=4, seconds=0.05, sample_seconds=1e-4)
_RADII = np.linspace(1.0, 2.0, 5)
_FIRST_CALL = 0.3
_SLOW_CALL = 0.005


def _digits(count: int) -> Prepared:
    """π cut after some digits."""
    value = np.floor(np.pi * 10**count) / 10**count
    return Prepared(lambda: value * _RADII**2, len(_RADII), lambda out: {"area": out})


def _slow_first_call(_) -> Prepared:
    """Stands for compilation: only the first call is slow."""
    calls = []

    def call():
        if not calls:
            time.sleep(_FIRST_CALL)
        calls.append(1)
        return np.pi * _RADII**2

    return Prepared(call, len(_RADII), lambda out: {"area": out})


def _slow(_) -> Prepared:
    """A rival that takes its time for a single instance, and fails at it."""

    def call():
        time.sleep(_SLOW_CALL)
        return np.full(1, np.nan)

    return Prepared(call, 1, lambda out: {"area": out}, lambda out: "gave up")


def _problem(**changes) -> Problem:
    options = {
        "name": "area",
        "title": "Area of a circle",
        "instance": "circle",
        "methods": [
            Method("digits", _digits, (1, 4, 8), "digits", "approximation"),
            Method("exact", _slow_first_call),
            Method("slow", _slow, kind="rival"),
        ],
        "reference": lambda: {"area": Reference(np.pi * _RADII[:3] ** 2)},
        "reference_note": "numpy",
        "baseline": "slow",
    }
    return Problem(**(options | changes))


@pytest.fixture(scope="module")
def measured():
    problem = _problem()
    return problem, measure(problem, _BUDGET)


@pytest.fixture(scope="module")
def toy(measured):
    return Case("toy", "Circles", [measured[0]]), [measured]


def test_errors_follow_the_digits(measured):
    _, rows = measured
    found = {row.setting: row.errors["area"].maximum for row in rows if row.method == "digits"}
    # π = 3.14159265358…, cut after 1, 4, 8 digits; rounding of the areas is 1e-16.
    expected = {n: 1 - np.floor(np.pi * 10**n) / 10**n / np.pi for n in (1, 4, 8)}
    assert found == pytest.approx(expected, abs=1e-15)
    assert found[1] > found[4] > found[8] > 0


def test_compilation_is_apart(measured):
    row = next(r for r in measured[1] if r.method == "exact")
    assert row.first_call > _FIRST_CALL
    # One slow call among the samples would be at least first call / instances.
    assert max(row.times) < _FIRST_CALL / len(_RADII) / 2


def test_times_are_per_instance_and_ratios_refer_to_the_baseline(measured):
    rows = {row.method: row for row in measured[1]}
    assert rows["slow"].best >= _SLOW_CALL
    assert rows["slow"].speed_ratio == 1.0
    assert rows["exact"].best <= rows["exact"].median
    # A few multiplications against 5 ms of sleep: only the order is certain on a busy machine.
    assert rows["exact"].speed_ratio > 10
    assert all(2 <= row.samples <= _BUDGET.rounds for row in rows.values())


def test_range_of_ratios_and_share_of_a_yardstick(measured):
    for row in measured[1]:
        low, high = row.ratio_range
        assert low <= row.speed_ratio <= high
    problem = _problem(yardstick=1e9)
    case = Case("toy", "Circles", [problem])
    found = document(case, [(problem, measured[1])], quick=True)["problems"][0]["results"]
    for result, row in zip(found, measured[1], strict=True):
        assert result["yardstick_share"] == pytest.approx(1e-9 / row.best)
    assert "share of 1e+09 per second" in table(case, [(problem, measured[1])])


def test_failures_are_counted_and_not_averaged(measured):
    error = next(r for r in measured[1] if r.method == "slow").errors["area"]
    assert (error.maximum, error.median, error.compared, error.not_finite) == (None, None, 1, 1)


def test_baseline_at_the_same_setting():
    methods = [
        Method("ours", _digits, (4, 8), "digits"),
        Method("theirs", _digits, (8, 4), "digits", "rival"),
    ]
    rows = measure(_problem(methods=methods, baseline="theirs"), _BUDGET)
    ours = {row.setting: row for row in rows if row.method == "ours"}
    theirs = {row.setting: row for row in rows if row.method == "theirs"}
    for setting, row in ours.items():
        pairs = zip(theirs[setting].times, row.times, strict=False)
        assert row.speed_ratio == pytest.approx(np.median([a / b for a, b in pairs]))


def _failing(at: int):
    """A rival that raises in one of its calls: the first one, or one among the samples."""
    calls = []

    def call():
        calls.append(1)
        if len(calls) > at:
            raise RuntimeError("CVODE flag -1 | too much work")
        return np.full(1, np.pi)

    return lambda _: Prepared(call, 1, lambda out: {"area": out})


def _cannot_be_built(_):
    raise ImportError("no compiler")


def test_a_rival_that_fails_is_a_row_with_its_cause(tmp_path):
    ours = Method("exact", _slow_first_call, defaults=(None,))
    fails = [
        Method("at once", _failing(0), kind="rival"),
        Method("later", _failing(3), ("rtol", 1e-3), "rtol", kind="rival"),
        Method("unbuilt", _cannot_be_built, kind="rival"),
    ]
    problem = _problem(methods=[ours, *fails], baseline="at once")
    found, rows = survivors(problem, _BUDGET)
    assert [row.method for row in rows] == ["exact"]
    assert rows[0].default
    assert rows[0].speed_ratio == 1.0
    assert found.baseline == "exact"
    assert dict(found.left_out) == {
        "at once": "failed: RuntimeError: CVODE flag -1 / too much work",
        "later, rtol rtol": "failed: RuntimeError: CVODE flag -1 / too much work",
        "later, rtol 0.001": "failed: RuntimeError: CVODE flag -1 / too much work",
        "unbuilt": "failed: ImportError: no compiler",
    }
    # The case goes on to its end, and each failure is a row of table and JSON.
    run(Case("toy", "Circles", [problem, _problem(name="second")]), tmp_path, quick=True)
    content = json.loads((tmp_path / "toy.json").read_text(encoding="utf-8"))
    assert [one["name"] for one in content["problems"]] == ["area", "second"]
    assert {one["method"] for one in content["problems"][0]["left_out"]} == set(found.left_out)
    text = (tmp_path / "toy.md").read_text(encoding="utf-8")
    assert "| later, rtol 0.001 (rival) |" in text
    # A method of this package that fails is a fault.
    with pytest.raises(RuntimeError, match="CVODE"):
        survivors(_problem(methods=[Method("slow", _failing(0))], baseline="slow"), _BUDGET)


def test_scale_replaces_the_value():
    reference = Reference(np.array([[0.0, 4.0], [1.0, 2.0]]), scale=np.array([[2.0], [8.0]]))
    # One row short: only the first instance counts. Errors 1/2 and 2/2.
    error = summarise(np.array([[1.0, 6.0]]), reference)
    assert (error.maximum, error.median, error.compared) == (1.0, 0.75, 2)
    # A value that ought to be zero is judged absolutely.
    assert summarise(np.array([0.25]), Reference(np.zeros(1))).maximum == 0.25


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"baseline": "none"}, "the baseline 'none' is none of its methods"),
        ({"methods": [Method("slow", _slow), Method("slow", _slow)]}, "two methods share a name"),
    ],
)
def test_misuse_of_a_problem(changes, message):
    with pytest.raises(ValueError, match=message):
        _problem(**changes)


def test_misuse_of_a_method():
    other = lambda: {"volume": Reference(_RADII)}  # noqa: E731
    with pytest.raises(ValueError, match=r"gives \['area'\], the reference has \['volume'\]"):
        measure(_problem(reference=other), _BUDGET)
    with pytest.raises(ValueError, match="shape"):
        summarise(np.ones((2, 3)), Reference(np.ones((2, 4))))


def test_json_has_the_documented_keys(toy, tmp_path):
    case, measurements = toy
    path, table_path = write(case, measurements, tmp_path, quick=True)
    content = json.loads(path.read_text(encoding="utf-8"))
    assert content == document(case, measurements, quick=True) | {"date": content["date"]}
    assert content["schema"] == SCHEMA
    assert set(content["machine"]) == {"system", "processor", "cores", "devices"}
    (problem,) = content["problems"]
    assert {"name", "title", "instance", "reference", "baseline", "results", "left_out"} == set(
        problem
    )
    assert len(problem["results"]) == 5
    for result in problem["results"]:
        assert set(result) == {
            "method",
            "kind",
            "default",
            "setting",
            "instances",
            "samples",
            "first_call_s",
            "best_s",
            "median_s",
            "per_second",
            "speed_ratio",
            "speed_ratio_range",
            "errors",
            "note",
        }
    assert problem["results"][1]["setting"] == {"name": "digits", "value": 4}
    assert problem["results"][-1]["note"] == "gave up"
    text = table_path.read_text(encoding="utf-8")
    assert text == table(case, measurements)
    assert "| slow (rival) |" in text


def test_files_are_whole_or_not_there(tmp_path):
    path = tmp_path / "results.json"
    path.write_text("before", encoding="utf-8")

    def half_written():
        with written_whole(path) as temporary:
            temporary.write_text("half", encoding="utf-8")
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        half_written()
    assert path.read_text(encoding="utf-8") == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_a_run_leaves_json_table_and_chart(tmp_path, capsys):
    quick = _problem(methods=[Method("digits", _digits, (1, 4), "digits")], baseline="digits")
    run(Case("toy", "Circles", [quick]), tmp_path, quick=True)
    assert {path.name for path in tmp_path.iterdir()} == {"toy.json", "toy.md", "toy-area.png"}
    assert (tmp_path / "toy-area.png").read_bytes().startswith(b"\x89PNG")
    assert "toy-area.png" in capsys.readouterr().out


def test_unknown_case_is_refused(tmp_path, capsys):
    with pytest.raises(SystemExit) as stop:
        main(["no_such_case", "--out", str(tmp_path)])
    assert stop.value.code == 2
    assert "no_such_case" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
    assert {"hertz", "meshing", "frequencies", "transient", "precision"} <= set(case_names())
