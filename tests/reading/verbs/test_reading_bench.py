"""The verb `bench`: the page and its JSON, against the numbers of a case of one method."""

import json
import re

from expectations import reads

_ERROR = {"max": 3.2e-9, "median": 1e-9, "compared": 2, "not_finite": 0, "instances": 2}
_ROW = {
    **{"method": "exact", "kind": "method", "setting": {"name": "rtol", "value": 1e-8}},
    **{"instances": 50, "best_s": 4.56e-6, "default": True, "errors": {"η": _ERROR}},
}
_PROBLEM = {
    **{"name": "toy", "title": "Circles", "instance": "circle", "reference": "by hand"},
    **{"baseline": "exact", "results": [_ROW], "left_out": []},
}
_CASE = {
    **{"case": "hertz", "description": "What", "date": "2026-01-02T03:04", "quick": False},
    **{"machine": {"processor": "P 5000", "cores": 2}, "problems": [_PROBLEM]},
}


@reads("verb", "bench")
def test_bench_writes_what_was_measured(tmp_path):
    from prsm_jax.cli._main import main as prsm

    results, docs = tmp_path / "results", tmp_path / "docs"
    results.mkdir()
    (results / "hertz.json").write_text(json.dumps(_CASE), encoding="utf-8")
    assert prsm(["bench", "--page", "--out", str(results), "--docs", str(docs)]) == 0
    data = json.loads((docs / "accuracy_and_speed.json").read_text(encoding="utf-8"))
    (row,) = data["cases"][0]["problems"][0]["results"]
    assert row == _ROW | {"single": False, "largest_error": 3.2e-9, "on_front": True}
    page = (docs / "accuracy_and_speed.md").read_text(encoding="utf-8")
    assert "Of 1 defaults 1 lie on the front." in page
    assert "* Default **exact, rtol 1e-08**, 4.56 µs, error 3.2e-09: on the front." in page
    assert "Measured on 2026-01-02, P 5000, 2 cores." in page
    cells = [re.split(r" *\| *", line)[1:-1] for line in page.splitlines() if line[:2] == "| "]
    assert cells[0][:3] == ["error allowed", "fastest of ours", "time"]
    # Within 1e-2 and 1e-6 it is the same row, and at 1e-9 there is none.
    assert cells[2:] == [["1e-6", "exact, rtol 1e-08", "4.56 µs", "none", "", ""]]
    assert (docs / "images" / "bench_hertz_toy.png").stat().st_size > 1000
