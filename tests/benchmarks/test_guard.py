"""The guard of errors and ratios: what turns it red, what does not, and what is stored."""

import importlib
import json
import math

import numpy as np
import pytest

from benchmarks import guard
from benchmarks.__main__ import main
from benchmarks.guard import Numbers, compare, conservative, guarded, numbers_of_case, recurring
from benchmarks.harness import Case, Method, Prepared, Problem, Reference
from benchmarks.joint.guard import LIMITS, numbers_of_joint

_STORED = Numbers(
    errors={"pressure": 2e-13, "approach": 1e-17},
    ratios={"speed": 40.0, "differences": 4.6},
    costs={"Jacobian": 1.4},
)
_LIMITS = {"Jacobian": 5.0, "differences": 1.5}


def _failing(measured: Numbers, **options) -> list[str]:
    return [one.name for one in compare(_STORED, measured, _LIMITS, **options)]


def _changed(**changes: float) -> Numbers:
    groups = {group: dict(getattr(_STORED, group)) for group in ("errors", "ratios", "costs")}
    for name, value in changes.items():
        (members,) = [members for members in groups.values() if name in members]
        members[name] = value
    return Numbers(**groups)


def test_noise_does_not_fail():
    assert _failing(_STORED) == []
    # Rounding of another processor; a busy core; a ratio with a limit of its own.
    noise = _changed(pressure=8e-13, approach=5e-15, speed=21.0, differences=1.6, Jacobian=4.9)
    assert _failing(noise) == []
    better = _changed(pressure=0.0, speed=400.0, Jacobian=0.1)
    assert _failing(better) == []


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("pressure", 20 * 2e-13),
        ("pressure", math.inf),
        ("pressure", math.nan),
        ("approach", 2e-14),
        ("speed", 20.0),
        ("differences", 1.4),
        ("Jacobian", 58.0),
        ("Jacobian", math.nan),
    ],
)
def test_each_fault_fails_alone(name, value):
    assert _failing(_changed(**{name: value})) == [name]


def test_a_number_that_is_not_measured_any_more_fails():
    assert _failing(Numbers()) == ["pressure", "approach", "speed", "differences", "Jacobian"]
    (first, *_) = compare(_STORED, Numbers(), _LIMITS)
    assert "not measured any more" in str(first)


def test_more_values_that_are_not_finite_fail():
    stored = Numbers(errors={"speed": math.inf, "time": 1e-9}, not_finite={"speed": 3})
    assert compare(stored, stored) == []
    worse = Numbers(errors=stored.errors, not_finite={"speed": 3, "time": 1})
    (failure,) = compare(stored, worse)
    assert (failure.name, failure.measured) == ("time, values not finite", 1)


def test_a_cost_needs_a_limit():
    with pytest.raises(ValueError, match="no limit for the stored cost Jacobian"):
        compare(_STORED, _STORED)


def test_a_ratio_fails_only_if_it_recurs_and_an_error_at_once():
    first = compare(_STORED, _changed(pressure=1e-9, speed=3.0, Jacobian=70.0), _LIMITS)
    again = compare(_STORED, _changed(Jacobian=60.0), _LIMITS)
    assert [one.name for one in recurring(first, again)] == ["pressure", "Jacobian"]


def test_the_worst_of_several_measurements_is_stored():
    found = conservative([_STORED, _changed(pressure=3e-13, speed=50.0, Jacobian=1.2)])
    assert found.errors == {"pressure": 3e-13, "approach": 1e-17}
    assert found.ratios["speed"] == 40.0
    assert found.costs["Jacobian"] == 1.4


def test_verdict_names_the_ratio_the_stored_and_the_measured_number(tmp_path, capsys):
    path = tmp_path / "stored.json"
    assert guarded("mine", lambda: _STORED, _LIMITS, path=path) == 1
    assert "mine: nothing is stored" in capsys.readouterr().err
    assert guarded("mine", lambda: _STORED, _LIMITS, renew=True, path=path) == 0
    # A second benchmark leaves the first.
    assert guarded("other", Numbers, renew=True, path=path) == 0
    capsys.readouterr()

    assert guarded("mine", lambda: _STORED, _LIMITS, path=path) == 0
    assert "mine: 5 numbers compared with stored.json, 0 worse" in capsys.readouterr().out
    calls = []

    def slow():
        calls.append(1)
        return _changed(speed=19.5, pressure=4e-12)

    assert guarded("mine", slow, _LIMITS, path=path) == 1
    assert len(calls) == 3
    told = capsys.readouterr().err
    assert "WORSE  mine: speed: stored 40, limit 20, measured 19.5" in told
    assert "WORSE  mine: pressure: stored 2e-13, limit 2e-12, measured 4e-12" in told

    # Busy once only.
    calls.clear()
    once = iter([_changed(speed=19.5), _STORED])
    assert guarded("mine", lambda: next(once), _LIMITS, path=path) == 0


def test_ratios_are_not_judged_with_fewer_cores(tmp_path, capsys):
    path = tmp_path / "stored.json"
    guarded("mine", lambda: _STORED, renew=True, path=path)
    content = json.loads(path.read_text(encoding="utf-8"))
    content["benchmarks"]["mine"]["cores"] = 100_000
    path.write_text(json.dumps(content), encoding="utf-8")
    capsys.readouterr()
    assert guarded("mine", lambda: _changed(speed=1.0), _LIMITS, path=path) == 0
    assert "2 numbers compared" in capsys.readouterr().out
    assert guarded("mine", lambda: _changed(pressure=1.0), _LIMITS, path=path) == 1


def _row(method, kind, setting, best, error):
    errors = {"area": {"max": error, "median": error, "not_finite": 0 if error else 2}}
    value = None if setting is None else {"name": "terms", "value": setting}
    return {"method": method, "kind": kind, "setting": value, "best_s": best, "errors": errors}


def test_numbers_of_a_case():
    """The baseline counts at the same setting if it has that, else at its first."""
    rows = [
        _row("ours", "method", 3, 1e-6, 1e-5),
        _row("ours", "method", 4, 2e-6, None),
        _row("theirs", "rival", 3, 8e-6, 1e-3),
        _row("theirs", "rival", 5, 9e-6, 1e-3),
    ]
    found = numbers_of_case(
        {"problems": [{"name": "circle", "baseline": "theirs", "results": rows}]}
    )
    assert found.errors == {
        "circle: ours, terms 3: error in area": 1e-5,
        "circle: ours, terms 4: error in area": math.inf,
    }
    assert found.not_finite == {"circle: ours, terms 4: error in area": 2}
    assert found.ratios == {
        "circle: ours, terms 3: speed over theirs": pytest.approx(8.0),
        "circle: ours, terms 4: speed over theirs": pytest.approx(4.0),
    }


def test_numbers_of_joint_derivatives_have_their_limits():
    row = {
        "error_dictionary": 1e-9,
        "error_forward": 2e-9,
        "differences_over_forward": 4.6,
        "over_value": {"dictionary": 1.41, "concatenated": 1.38},
    }
    second = {
        "error": 3e-9,
        "reverse_over_value": 1.5,
        "hessian_over_value": 15.4,
        "processor_s": {"forward over forward": 43.0},
        "instructions": {"forward over forward": 154_000},
    }
    found = numbers_of_joint(row, second, 0.9, 2.4)
    assert compare(found, found, LIMITS) == []
    row["over_value"]["concatenated"] = 58.0
    row["error_dictionary"] = 2e-8
    second["processor_s"]["forward over forward"] = 401.0
    second["instructions"]["forward over forward"] = 251_000
    worse = numbers_of_joint(row, second, 5.0, 19.0)
    assert [one.name for one in compare(found, worse, LIMITS)] == [
        "error of the Jacobian, dictionary",
        "Jacobian over value, concatenated",
        "Jacobian together over one by one",
        "Jacobian over value, results of verbs",
        "Hessian: processor time of compiling [s]",
        "Hessian: instructions of the compiled program",
    ]


def test_the_file_has_the_cases_and_every_cost_a_limit():
    known = guard.read_stored()
    assert {"hertz", "meshing", "frequencies", "load_sharing", "transient"} <= set(known)
    numbers, _ = known["joint actuator"]
    assert set(numbers.costs) <= set(LIMITS)
    assert compare(numbers, numbers, LIMITS) == []


def test_stored_numbers_are_those_of_the_quick_form(capsys):
    for option in ("--compare", "--store"):
        with pytest.raises(SystemExit):
            main(["hertz", option])
        assert "add --quick" in capsys.readouterr().err


def test_the_command_measures_and_compares(tmp_path, monkeypatch, capsys):
    """A method that gets twenty times worse is named, and the exit status is 1."""
    digits = {"error": 1e-4}

    def prepare(error):
        return lambda _: Prepared(
            lambda: np.full(3, 3.0 * (1 + error())), 3, lambda out: {"area": out}
        )

    problem = Problem(
        name="circle",
        title="Three circles",
        instance="circle",
        methods=[
            Method("ours", prepare(lambda: digits["error"])),
            Method("theirs", prepare(lambda: 0.0), kind="rival"),
        ],
        reference=lambda: {"area": Reference(np.full(3, 3.0))},
        reference_note="by hand",
        baseline="theirs",
    )
    command = importlib.import_module("benchmarks.__main__")
    monkeypatch.setattr(command, "find_case", lambda *a, **k: Case("hertz", "toy", [problem]))
    path = tmp_path / "stored.json"
    # How long nothing takes is all noise: no clock.
    monkeypatch.setattr(guard, "guarded", lambda *a, **k: guarded(*a, **k, path=path))
    monkeypatch.setattr("benchmarks.guard.compared.RATIO_FALL", 1e9)
    given = ["hertz", "--quick", "--out", str(tmp_path)]
    assert main([*given, "--store"]) == 0
    assert main([*given, "--compare"]) == 0
    digits["error"] = 2e-3
    capsys.readouterr()
    assert main([*given, "--compare"]) == 1
    said = capsys.readouterr()
    assert "hertz: circle: ours: error in area: stored 0.0001, limit 0.001, measured 0.002" in (
        said.err
    )
    assert "hertz: 2 numbers compared with stored.json, 1 worse" in said.out
