"""The benchmark of sweeps: its rival against mpmath, shares and ratios, the model, the page."""

import math

import mpmath
import numpy as np
import pytest

from benchmarks.references import geometry_chain
from benchmarks.references.contact import forward_efficiency, largest_pressure
from benchmarks.references.meshing import Design
from benchmarks.references.vibration import DIGITS, frequencies
from benchmarks.sweeps import rival
from benchmarks.sweeps.page import model, outside, ratio, write_page
from benchmarks.sweeps.worker import throughput


def test_the_rival_against_mpmath():
    lead, angle, roller = 9.1e-3, 0.85, 4.3e-3
    found, efficiency, pressure = rival.design(lead, angle, roller)
    with mpmath.workdps(DIGITS):
        expected, _ = frequencies(geometry_chain.numbers(lead, angle, roller), 10)
    # Eigenvalues of a spread of 1e5 lose some digits.
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    thread = Design(lead, 5, roller, angle, roller / math.cos(angle))
    modulus = 210e9 / (2 * (1 - 0.3**2))
    assert pressure == pytest.approx(largest_pressure(thread, 12e3 / 200, modulus), rel=1e-13)
    # Work of a turn: that of the load through the thread, friction at 15 mm in the bearing, drag.
    work = 12e3 * lead
    spent = work / forward_efficiency(thread, 0.06)
    spent += 2 * math.pi * (0.003 * 12e3 * 0.015 + 0.05)
    assert efficiency == pytest.approx(work / spent, rel=1e-13)


def _times(wall, processor):
    return {"wall_s": wall, "processor_s": processor}


def _row(**more):
    rounds = [
        {"sweep": _times(10.0, 16.0), "kernel": _times(9.0, 12.0), "rival": _times(2.0, 1.0)},
        {"sweep": _times(10.0, 16.0), "kernel": _times(8.0, 12.0), "rival": _times(2.0, 1.0)},
        {"sweep": _times(20.0, 16.0), "kernel": _times(10.0, 12.0), "rival": _times(4.0, 1.0)},
    ]
    return {
        "scene": "actuator", "findings": False, "points": 1_000_000, "rounds": rounds,
        "rival_designs": 1000, "memory": {"compiled": 5e8, "swept": 6e8}, "stored_bytes": 84e6,
        "files": 615, "block": 10_000, "compile": _times(30.0, 14.0),
        "error": {"efficiency": 2e-15},
    } | more  # fmt: skip


def test_shares_and_ratios_are_medians_of_rounds():
    assert outside(_row(), "wall_s") == pytest.approx(0.2)
    assert outside(_row(), "processor_s") == pytest.approx(0.25)
    # 2 ms a design against 10 µs; 1 ms of processor time against 16 µs.
    assert ratio(_row(), "wall_s") == pytest.approx(200)
    assert ratio(_row(), "processor_s") == pytest.approx(62.5)


def test_the_model_of_many_threads():
    one = model(1e6, 1, 30.0, 5e4, 10_000, 84.0)
    assert one == pytest.approx(
        {"seconds": 50, "efficiency": 1, "bytes_per_second": 4.2e6, "files_per_second": 35}
    )
    # A hundred blocks: ten each for ten threads, and one thread with one block each beyond.
    assert model(1e6, 10, 30.0, 5e4, 10_000, 84.0)["seconds"] == pytest.approx(32)
    many = model(1e6, 1000, 30.0, 5e4, 10_000, 84.0)
    assert many["seconds"] == pytest.approx(30.2)
    assert many["bytes_per_second"] == pytest.approx(100 * 4.2e6)
    assert many["efficiency"] == pytest.approx(50 / 30_200)


def test_the_page(tmp_path):
    machine = {"cores": 2, "processor": "a processor"}
    scaling = [
        {"points": 1000, "processes": p, "cores": c, "processor_s": 1.5, "wall_s": wall}
        for p, c, wall in ((1, 1, 2.0), (1, 2, 1.0), (2, 1, 1.25))
    ]
    calls = [{"scene": "actuator", "points": 8, "sizes": [
        {"call": 512, "wall_us": 9.0, "processor_us": 8.0},
        {"call": 4096, "wall_us": 9.5, "processor_us": 10.0},
    ]}]  # fmt: skip
    document = {"machine": machine, "date": "2026-01-02T03:04", "sweeps": [_row()],
                "calls": calls, "scaling": scaling}  # fmt: skip
    lines = write_page(document, tmp_path).read_text().splitlines()
    assert "On a busy machine of two cores (a processor), 2026-01-02." in lines
    row = "| actuator | no | 1,000,000 | 10 s | 100,000 | 16 µs | 20 % | 25 % "
    assert f"{row}| 500 MB, 600 MB | 84 MB in 615 files | 30 s |" in lines
    assert "| actuator | 2e+03 µs | 10 µs | 200 | 62 | efficiency 2e-15 |" in lines
    assert "| actuator | 4,096 | 9.50 µs | 10.00 µs | 1.25 |" in lines
    assert "| 2 | 1 | 1.25 s | 800 | 1.60 | 1.5e+03 µs |" in lines
    assert any(line.startswith("s = 14 s") and "r = 62,500 designs" in line for line in lines)


def test_one_measurement():
    found = throughput("actuator as the rival has it", 6, False, 1, 3)
    assert (found["points"], found["failed"], found["blocks"]) == (216, 0, 1)
    assert max(found["error"].values()) < 1e-9
    assert set(found["rounds"][0]) == {"sweep", "kernel", "rival"}
