"""The benchmark of devices: a small run, its shares by hand, and the cells of its page."""

import json

import jax
import numpy as np
import pytest

from benchmarks.devices.command import main
from benchmarks.devices.measured import measured, reference
from benchmarks.devices.page import page_of
from benchmarks.devices.tasks import TASKS


def test_a_run_says_that_there_is_no_accelerator(tmp_path, capsys):
    """Rows of the processor in both precisions, errors of their rounding, one JSON."""
    assert main(["hertz", "--smoke", "--out", str(tmp_path)]) == 0
    assert "no accelerator" in capsys.readouterr().out
    document = json.loads((tmp_path / "devices.json").read_text())
    assert [row["precision"] for row in document["rows"]] == ["float64", "float32"]
    full, short = document["rows"]
    assert full["designs"] == 1000
    assert full["error"] < 1e-14
    # Single precision is there: neither exact nor worse than some of its roundings.
    assert 1e-9 < short["error"] < 1e-5


def test_share_of_the_ceiling_by_hand():
    """1e12 bytes a second and one operation a second: all of the time is needed, and more."""
    device = jax.devices("cpu")[0]
    ceiling = {"bytes_per_second": 1e12, "operations_per_second": 1.0}
    row = measured("hertz", 100, device, np.float64, reference(TASKS["hertz"]), ceiling)
    assert row["share_of_ceiling"] == pytest.approx(
        row["operations_per_design"] * 100 / row["seconds"]
    )
    ceiling = {"bytes_per_second": 1.0, "operations_per_second": 1e30}
    row = measured("hertz", 100, device, np.float64, reference(TASKS["hertz"]), ceiling)
    # Four numbers in, two out, of eight bytes.
    assert row["needed_bytes_per_design"] == pytest.approx(48)
    assert row["share_of_ceiling"] == pytest.approx(4800 / row["seconds"])


def test_cells_of_the_page():
    """2 million designs in 4 ms are 2 ns each."""
    row = {
        "task": "hertz",
        "designs": 2_000_000,
        "device": "an accelerator",
        "precision": "float64",
        "seconds": 4e-3,
        "designs_per_second": 5e8,
        "share_of_ceiling": 0.25,
        "error": 3e-16,
        "compile_seconds": 1.5,
    }
    late = {"task": "meshing", "designs": 10, "device": "cpu", "precision": "float32"}
    page = page_of(
        {
            "no_accelerator": "",
            "versions": {"jax": "1"},
            "ceilings": {
                "an accelerator": {
                    "float64": {"bytes_per_second": 3e12, "operations_per_second": 3e13}
                }
            },
            "rows": [row, {**late, "failure": "left out: the time limit was reached"}],
        }
    )
    assert (
        "| exact Hertz contact | 2,000,000 | float64 | 5.00e+08 | 2 ns | 25 % | 3e-16 | 1.5 s |"
        in page
    )
    assert "| meshing of both sides | 10 | float32 | left out: the time limit was reached |" in page
    assert "3e+03 GB/s, 3e+04 billion operations a second" in page
