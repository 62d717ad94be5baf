"""Cost of parts and time to an answer: what is divided how, and what stands in which cell."""

import json

import pytest

from benchmarks.parts import page as parts_page
from benchmarks.parts.command import main as parts
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


@pytest.mark.slow
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
    document = {"machine": {"cores": 2, "processor": "x"}, "date": "2026-01-02T", "verbs": [row]}
    text = startup_page.write_page(document, tmp_path).read_text()
    assert "On a busy machine of two cores (x), 2026-01-02." in text
    assert {"steady", "modal", "simulate", "sensitivity", "optimise", "check"} <= set(COMMANDS)
