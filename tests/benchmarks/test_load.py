"""Growth with size: what is fitted, and the smallest sizes of every task."""

import json

import pytest

from benchmarks.__main__ import main
from benchmarks.load.growth import exponent, of_rows
from benchmarks.load.picture import draw
from benchmarks.load.sharing import sharing
from benchmarks.load.tasks import TASKS


def test_an_exponent_is_that_of_the_large_sizes():
    sizes = [1, 100, 1000, 10_000]
    assert exponent(sizes, [3 * n**1.5 for n in sizes]) == pytest.approx(1.5)
    # A call costs 1 whatever its size: the smallest, 1/10,000 of the largest, does not count.
    assert exponent(sizes, [max(1.0, n / 100) for n in sizes]) == pytest.approx(1.0)
    assert exponent(sizes, [None, None, None, 1.0]) is None


def test_memory_that_does_not_rise_has_no_exponent():
    rows = [{"count": n, "best_s": n, "run_bytes": 1e6 * n} for n in (1, 10)]
    assert of_rows(rows) == {"time": pytest.approx(1.0), "memory": None}
    rows[-1]["run_bytes"] = 1e8
    assert of_rows(rows)["memory"] == pytest.approx(2.0)


def test_what_is_no_balance_is_seen():
    call, error, count = sharing(10, 6)
    found = call()
    assert count == 60
    assert error(found) < 1e-8
    first, second, result, steps = found
    assert error((first.at[2, 3].multiply(1 + 1e-3), second, result, steps)) > 1e-4
    assert not error((first, second, result + 1, steps)) >= 0


def test_a_measurement_is_written_whole(tmp_path):
    """One task at its two smallest sizes, each in a process of its own."""
    assert main(["load", "sharing", "--smoke", "--out", str(tmp_path)]) == 0
    (task,) = json.loads((tmp_path / "load.json").read_text(encoding="utf-8"))["tasks"]
    assert [row["count"] for row in task["sizes"]] == [60, 375]
    for row in task["sizes"]:
        assert row["error"] < 1e-8
        assert 0 < row["best_s"] < row["first_call_s"]
    assert "| load sharing, threads × 0.6 as many unlike rollers | 375 thread contacts |" in (
        tmp_path / "load.md"
    ).read_text(encoding="utf-8")
    assert (tmp_path / "load.png").stat().st_size > 1000


def test_tasks_by_name(capsys, tmp_path):
    assert main(["load", "--list"]) == 0
    assert capsys.readouterr().out.count("\n") == len(TASKS)
    with pytest.raises(SystemExit):
        main(["load", "nothing"])
    assert "unknown task nothing" in capsys.readouterr().err
    row = {"count": 1, "best_s": 1.0, "run_bytes": None, "error": None}
    empty = {"title": "t", "unit": "u", "sizes": [row], "exponents": {"time": None, "memory": None}}
    assert draw([empty], tmp_path / "a.png").stat().st_size > 1000
