"""Cost of parts and time to an answer: what is divided how, and what stands in which cell."""

import json

import numpy as np
import pytest

import prsm_jax as prsm
from benchmarks.parts import page as parts_page
from benchmarks.parts.command import main as parts
from benchmarks.programs import command as programs_command, page as programs_page
from benchmarks.programs.command import measured
from benchmarks.programs.functions import VARIABLES, program
from benchmarks.startup import page as startup_page
from benchmarks.startup.child import divided
from benchmarks.startup.command import COMMANDS

_WHOLE = {
    "name": "modes", "equations": 2042, "flops": 1e4, "bytes": 2e5, "memory_bytes": 3000,
    "compile_s": 1.25, "run_s": 12e-6, "error": None,
}  # fmt: skip


def _cost(equations, needed=None):
    found = {f"{key}_without": value for key, value in _WHOLE.items() if key not in ("name",)}
    return {
        "equations": equations,
        "needed": needed,
        **found,
        "equations_without": None if needed else 2042 - equations,
    }


def test_each_part_is_a_row_or_is_named_beneath():
    example = {
        "example": "wu2022",
        "error": None,
        "programs": [_WHOLE, {**_WHOLE, "name": "transient", "error": "no inertia"}],
        "parts": [
            {"name": "stage.1.gear", "law": None, "costs": {"modes": _cost(42)}},
            {"name": "stage.1.drag", "law": "coulomb", "costs": {"modes": _cost(0)}},
            {"name": "stage.1.screw", "law": None, "costs": {"modes": _cost(None, "why")}},
        ],
    }
    text = parts_page.tables([example, {"example": "slow", "error": "not done in 9 s"}])
    lines = text.splitlines()
    assert "| modes | **nothing** | 2,042 | 10,000 | 200,000 | 3.0 kB | 1.25 s | 12 µs |" in lines
    assert "| modes | stage.1.gear | 2,000 | 10,000 | 200,000 | 3.0 kB | 1.25 s | 12 µs |" in lines
    assert "The same without, modes: stage.1.drag." in lines
    assert "Not possible without, modes: stage.1.screw." in lines
    assert "No transient: no inertia." in lines
    assert lines[lines.index("## slow") + 2] == "Not measured: not done in 9 s."


def test_parts_of_an_example_in_a_process_of_its_own(tmp_path):
    words = ["li2021_two_stage", "--programs", "steady_state", "--count-only"]
    assert parts([*words, "--out", str(tmp_path), "--docs", str(tmp_path)]) == 0
    document = json.loads((tmp_path / "parts.json").read_text())
    (example,) = document["examples"]
    (whole,) = example["programs"]
    costs = {part["name"]: part["costs"]["steady_state"] for part in example["parts"]}
    spline = costs["stage.2.friction.spline"]
    assert spline["equations"] + spline["equations_without"] == whole["equations"]
    row = f"stage.2.friction.spline (coulomb) | {spline['equations_without']:,} |"
    assert row in (tmp_path / "parts.md").read_text()
    with pytest.raises(SystemExit):
        parts(["no_example"])


def test_every_moment_counts_once():
    """Tracing inside tracing, compiling inside an import, and what is apart."""
    found = divided(
        [
            (0.0, 4.0, "tracing"),
            (1.0, 2.0, "tracing"),
            (3.0, 6.0, "imports"),
            (5.0, 5.5, "compiling"),
            (8.0, 9.0, "lowering"),
        ]
    )
    assert found == {"compiling": 0.5, "lowering": 1.0, "imports": 2.5, "tracing": 3.0}
    assert divided([]) == dict.fromkeys(found, 0.0)


def test_startup_cells_and_verbs(tmp_path):
    parts = ("wall", "processor", "interpreter", "imports", "tracing", "lowering", "compiling")
    cold = {f"{name}_s": 1.0 + k for k, name in enumerate((*parts, "rest"))}
    warm = {key: value / 10 for key, value in cold.items()}
    row = {
        "verb": "steady", "command": "steady wu2022", "error": None, "cold": cold, "warm": warm,
        "over_imports": 1.497, "imports": {"processor_s": 1.2},
    }  # fmt: skip
    lines = startup_page.tables([row, {"command": "modal", "error": "not done"}]).splitlines()
    numbers = " | ".join(f"{k:.2f}" for k in range(1, 9))
    assert lines[2] == f"| `prsm steady wu2022` | cold | {numbers} |  |"
    assert lines[3].startswith("| `prsm steady wu2022` | warm | 0.10 | 0.20 |")
    assert lines[3].endswith(" | 0.80 | 1.50 |")
    assert lines[4].startswith("| modal | not done |")
    calls = [{"call": "modal(m)", "first_s": 4.25, "later_s": 3.1e-4}]
    document = {
        "machine": {"cores": 2, "processor": "x"}, "date": "2026-01-02T", "verbs": [row],
        "calls": calls,
    }  # fmt: skip
    text = startup_page.write_page(document, tmp_path).read_text()
    assert "On a busy machine of two cores (x), 2026-01-02." in text
    assert "| `modal(m)` | 4.25 | 0.31 |" in text
    assert {"steady", "modal", "simulate", "sensitivity", "optimise", "check"} <= set(COMMANDS)


def _row(**changes):
    row = {
        "example": "wu2022", "function": "modal", "kind": "value", "batch": 1,
        "equations": 2042, "trace_s": 0.5, "lower_s": 0.25, "compile_s": 3.0, "flops": 4045.0,
        "run_s": 49e-6, "finite": True, "error": None,
    }  # fmt: skip
    return row | changes


def test_program_cells_and_ratios(tmp_path):
    failed = _row(kind="hessian", error="not done in 9 s")
    lines = programs_page.tables([_row(), failed, _row(finite=False)]).splitlines()
    begin = "| wu2022 | modal | value | 1 | 2,042 | 0.50 s | 0.25 s | 3.00 s | 4.04e+03 | 49 µs"
    assert lines[2] == f"{begin} |"
    assert lines[3].startswith("| wu2022 | modal | hessian | 1 | not done in 9 s |")
    assert lines[4] == f"{begin} (not finite) |"
    old = {"programs": [_row(compile_s=6.0, equations=4084, run_s=98e-6), failed]}
    text = programs_page.compared({"programs": [_row(), failed]}, old)
    assert "| wu2022 modal value 1 | 0.50 | 0.50 | 1.00 | 0.50 |" in text
    assert "All compile times: 3.0 s over 6.0 s." in text
    document = {"machine": {"cores": 2, "processor": "x"}, "date": "2026-01-02T", **old}
    page = programs_page.write_page(document, tmp_path).read_text()
    assert "On a busy machine of two cores (x), 2026-01-02." in page
    assert "li2020_two_stage steady_state" in page.partition("Not in this run: ")[2]


def test_totals_of_two_commits(tmp_path):
    """A program that is not done counts with its limit; one that a commit lacks does not count."""
    late = {"kind": "hessian", "error": "not done in 9 s", "limit_s": 9.0}
    gone = {"function": "campbell", "error": "no such name"}
    document = {
        "machine": {"cores": 2, "processor": "x"}, "date": "2026-01-02T", "beside_commit": "abc",
        "programs": [_row(), _row(kind="hessian", trace_s=1.25), _row(function="campbell")],
        "beside": [_row(compile_s=6.75, kind="value"), _row(**late), _row(**gone)],
    }  # fmt: skip
    text = programs_page.totals(document)
    assert "| values | 1 | 8 s | 4 s | 0.50 |" in text
    assert "| gradients | 0 | 0 s | 0 s |  |" in text
    assert "| Hessians | 1 | 9 s | 4 s | 0.50 |" in text
    assert "| all | 2 | 16 s | 8 s | 0.50 |" in text
    assert "Not done within their limit, which is counted, then: wu2022 modal hessian 1." in text
    assert "counted, now" not in text
    page = programs_page.write_page(document, tmp_path).read_text()
    assert "## Against commit abc" in page
    assert text in page


def test_rows_of_two_commits_are_of_one_run(monkeypatch, tmp_path):
    """A row measured alone has none beside it, and rows beside are of one commit."""

    def row(*program):
        return _row(**dict(zip(("example", "function", "kind", "batch"), program, strict=False)))

    monkeypatch.setattr(programs_command, "measured", lambda *a: row(*a[:4]))
    commits = iter(("first", "second"))
    monkeypatch.setattr(programs_command, "_commit", lambda tree: next(commits))
    common = ["--examples", "wu2022", "--batches", "1", "--add", "--out", str(tmp_path)]

    def beside(*words):
        assert programs_command.main([*words, *common]) == 0
        document = json.loads((tmp_path / "programs.json").read_text())
        rows = [(r["function"], r["kind"]) for r in document["beside"]]
        return document.get("beside_commit"), rows

    kinds = ("value", "gradient", "hessian")
    first = [("modal", kind) for kind in kinds]
    assert beside("modal", "--beside", "then") == ("first", first)
    assert beside("modal", "--kinds", "value") == ("first", first[1:])
    second = [("steady_state", kind) for kind in kinds]
    assert beside("steady_state", "--beside", "then") == ("second", second)


def test_a_program_that_takes_too_long_and_one_of_another_tree(tmp_path):
    row = measured("li2020_two_stage", "steady_state", "value", 1, 1.0)
    assert (row["error"], row["limit_s"]) == ("not done in 1 s", 1.0)
    package = tmp_path / "prsm_jax"
    package.mkdir()
    (package / "__init__.py").write_text("raise ValueError('this is the other tree')")
    row = measured("li2020_two_stage", "steady_state", "value", 1, 100.0, tmp_path)
    assert row["error"] == "this is the other tree"


def test_a_program_and_one_that_there_is_not():
    row = measured("li2020_two_stage", "max_pressure", "value", 1, 200.0)
    assert row["error"] is None
    assert row["equations"] > 10
    assert row["finite"]
    assert row["run_s"] > 0
    row = measured("li2020_two_stage", "rating_life", "value", 1, 200.0)
    assert row["equations"] is None
    assert "quantity 'rating_life'" in row["error"]


def test_programs_are_derivatives_of_what_they_say():
    from prsm_jax.mechanism import set_parameters

    one = prsm.load("li2020_two_stage")
    slope, numbers = program("li2020_two_stage", "max_pressure", "gradient", 1)
    batch, many = program("li2020_two_stage", "max_pressure", "value", 100)
    assert many.shape == (100, 3)

    def value(moved):
        return prsm.compute(
            set_parameters(one, dict(zip(VARIABLES, moved, strict=True))), ["max_pressure"]
        )["max_pressure"]

    step = np.array([1e-5, 0, 0]) * numbers
    difference = (value(numbers + step) - value(numbers - step)) / (2 * step[0])
    assert slope(numbers)[0] == pytest.approx(float(difference), rel=1e-6)
    assert batch(many)[0][3] == pytest.approx(float(value(many[3])), rel=1e-12)
    with pytest.raises(ValueError, match="no scalar"):
        program("wu2022", "check", "hessian", 1)
