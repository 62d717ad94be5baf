"""The page of accuracy and speed: fronts, choices and verdicts, on a toy whose front is known."""

import json

import pytest

from benchmarks.__main__ import main
from benchmarks.cases import case_names, find_case
from benchmarks.defaults import DEFAULTS
from benchmarks.page.advice import CASES
from benchmarks.page.front import dominating, error_of, fastest_within, on_front
from benchmarks.page.write import time_text, write_page


def _row(method, best, error, kind="method", instances=100, default=False, setting=None):
    errors = {"q": {"max": error, "median": error, "compared": 1, "not_finite": 0, "instances": 1}}
    if error is None:
        errors["q"]["not_finite"] = 1
    return {
        **{"method": method, "kind": kind, "setting": setting, "instances": instances},
        **{"best_s": best, "errors": errors, "default": default, "note": ""},
    }


_ROWS = [
    _row("exact", 2e-6, 1e-15, default=True),
    _row("rough", 1e-6, 1e-3, "approximation"),
    _row("slow", 4e-6, 1e-9, default=True, setting={"name": "rtol", "value": 1e-8}),
    _row("as good", 1.9e-6, 1e-15),  # faster by less than the noise
    _row("one", 5e-5, 1e-15, instances=1, default=True),
    _row("rival", 1e-7, 1e-16, "rival"),
    _row("broken", 1e-9, None, default=True),
]


def test_the_front_is_of_ours_and_of_one_kind_of_call():
    on = {row["method"]: on_front(row, _ROWS) for row in _ROWS}
    # "slow" is beaten in both; a rival beats nobody; a single call is not compared with a batch.
    assert on == {
        **{"exact": True, "rough": True, "slow": False, "as good": True},
        **{"one": True, "rival": True, "broken": False},
    }
    better = dominating(_ROWS[2], _ROWS)
    assert better is not None
    assert better["method"] == "as good"
    # Twice as fast and as good would beat it.
    assert not on_front(_ROWS[0], [*_ROWS, _row("faster", 1e-6, 1e-15)])
    # As fast, and half the error.
    assert not on_front(_ROWS[1], [*_ROWS, _row("better", 1e-6, 4e-4)])
    assert on_front(_ROWS[1], [*_ROWS, _row("alike", 1e-6, 6e-4)])
    assert error_of(_ROWS[-1]) is None


def test_the_fastest_within_an_error():
    ours = [row for row in _ROWS if row["kind"] != "rival"]
    found = {limit: fastest_within(limit, ours) for limit in (1e-2, 1e-4, 1e-16)}
    names = {limit: row and row["method"] for limit, row in found.items()}
    assert names == {1e-2: "rough", 1e-4: "as good", 1e-16: None}


def test_times_have_units():
    assert [time_text(t) for t in (2.5, 3.2e-3, 4.56e-6, 7.891e-9)] == [
        *("2.5 s", "3.2 ms", "4.56 µs", "7.89 ns")
    ]


def _written(tmp_path, left_out=()):
    problem = {
        **{"name": "toy", "title": "Circles", "instance": "circle", "reference": "by hand"},
        **{"baseline": "rival", "results": _ROWS, "left_out": list(left_out)},
    }
    case = {"case": "hertz", "description": "What", "date": "2026-01-02T03", "quick": True}
    case |= {"machine": {"processor": "P", "cores": 2}, "problems": [problem]}
    (tmp_path / "hertz.json").write_text(json.dumps(case), encoding="utf-8")
    page, data = write_page(tmp_path, tmp_path / "docs")
    return page.read_text(encoding="utf-8"), json.loads(data.read_text(encoding="utf-8"))


def test_page_and_json_say_what_was_measured(tmp_path):
    reason = "failed: RuntimeError: CVODE flag -1"
    page, data = _written(tmp_path, [{"method": "CVODES", "reason": reason}])
    (problem,) = data["cases"][0]["problems"]
    front = {row["method"]: row["on_front"] for row in problem["results"]}
    assert front["rival"] is False  # rivals have no front
    assert front["exact"] is True
    assert front["slow"] is False
    assert {row["method"] for row in problem["results"] if row["single"]} == {"one"}
    assert "Of 4 defaults 2 lie on the front; the others" in page
    assert "* Default **exact**, 2 µs, error 1.0e-15: on the front." in page
    assert "**slow, rtol 1e-08**, 4 µs, error 1.0e-09: **not on the front**; as good" in page
    assert "takes 1.9 µs at 1.0e-15" in page
    assert "**broken**, 1 ns: its error is not finite." in page
    assert f"* Not in the chart: CVODES ({reason})." in page
    # At 1e-4 and up to the last digit "as good" is the fastest of ours: 1.9 µs against 0.1 µs.
    assert "| 1e-2 | rough | 1 µs | rival | 100 ns | 0.1 |" in page
    assert "| 1e-12 | as good | 1.9 µs | rival | 100 ns | 0.0526 |" in page
    assert "by the quick form" in page
    assert CASES["hertz"][1] in page
    picture = tmp_path / "docs/images/bench_hertz_toy.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "images/bench_hertz_toy.png" in page


def test_only_the_page_without_measuring(tmp_path, capsys):
    given = ["--page", "--out", str(tmp_path), "--docs", str(tmp_path / "docs")]
    assert main(given) == 2
    assert "run `prsm bench` first" in capsys.readouterr().err
    _written(tmp_path)
    assert main(given) == 0
    assert "accuracy_and_speed.md" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["--page"])
    assert "--page needs --docs" in capsys.readouterr().err


def test_every_case_has_advice_and_defaults():
    assert set(CASES) == set(case_names()) == set(DEFAULTS)


@pytest.mark.parametrize(
    "name", ["hertz", "meshing", "precision", "roller_bending", "slip_and_spin", "gradients"]
)
def test_defaults_are_methods_of_their_case(name):
    case = find_case(name, quick=True)
    for problem in case.problems:
        assert any(set(one.defaults) & set(one.settings) for one in problem.methods), problem.name
    known = {method.name for problem in case.problems for method in problem.methods}
    assert set(DEFAULTS[name]) <= known


def test_bench_without_a_checkout_is_one_sentence(tmp_path, monkeypatch, capsys):
    from prsm_jax.cli._main import main as prsm
    from prsm_jax.cli.verbs import _bench

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(_bench, "__file__", str(tmp_path / "a/b/c.py"))
    assert prsm(["bench", "--page"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "checkout" in said
    assert "pip install" in said
    assert list(tmp_path.iterdir()) == []
    # A folder that cannot be written is refused before anything is measured.
    monkeypatch.undo()
    (tmp_path / "mine").write_text("mine")
    for option in ("--out", "--docs"):
        assert prsm(["bench", "hertz", option, str(tmp_path / "mine")]) == 2
        assert f"{option} {tmp_path}/mine" in capsys.readouterr().err
