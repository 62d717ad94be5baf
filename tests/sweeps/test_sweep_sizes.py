"""Sizes of blocks and calls: from the number of designs, memory and cache, and from a store."""

import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from stored_sweeps import contents

import prsm_jax as prsm
from prsm_jax.sweeps import _sizes, _sweep, open_store, sweep
from prsm_jax.sweeps._store import stored_identity

AXES = {"lead": np.linspace(6e-3, 14e-3, 20), "contact_angle": np.linspace(0.7, 0.8, 15)}


def run(store=None, **more):
    return sweep(prsm.load("wu2022"), AXES, ["nut_radius"], findings=False, store=store, **more)


def test_blocks_are_large_enough_to_write_and_small_enough_to_share():
    assert [_sizes.block_size(n) for n in (1, 10_000, 320_000, 10**6, 10**9)] == [
        4096, 4096, 10_000, 31_250, 32_768,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("size", "cores", "call"),
    [
        # 32 MB of two cores hold 2,048 designs of 8 kB for each.
        ("32768K", "0-1", 2048),
        ("32M", "0-1,8-9", 1024),
        ("512M", "0-3", 4096),
        ("1024K", "0-31", 512),
        ("strange", "0", 2048),
        ("32768K", "", 2048),
    ],
)
def test_calls_fit_into_a_core_s_share_of_the_cache(tmp_path, size, cores, call):
    for index, (of, shared) in enumerate((("48K", "0"), (size, cores))):
        entry = tmp_path / f"index{index}"
        entry.mkdir()
        (entry / "size").write_text(f"{of}\n")
        (entry / "shared_cpu_list").write_text(f"{shared}\n")
    assert _sizes.call_size(tmp_path) == call


def test_a_system_that_does_not_tell_its_caches(tmp_path):
    assert _sizes.call_size(tmp_path / "none") == 2048


@pytest.mark.parametrize(("total", "most"), [(1, 5), (5, 5), (6, 5), (3400, 2048), (4097, 2048)])
def test_calls_of_a_block_are_nearly_equal(total, most):
    size = _sizes.equal_parts(total, most)
    assert size <= most
    calls = -(-total // size)
    assert calls == -(-total // most)
    # Fewer designs are computed for nothing than there are calls.
    assert calls * size - total < calls


def test_results_of_a_block_fit_into_memory(tmp_path, monkeypatch):
    """A design has one number of 8 bytes and two codes of 4 or 8; 40 designs need 1 kB at most."""
    monkeypatch.setattr(_sizes, "RESULT_BYTES", 1024)
    run(tmp_path / "a.zarr")
    chunk = stored_identity(tmp_path / "a.zarr")["chunk"]
    assert 1024 // 24 - 15 <= chunk <= 1024 // 16
    monkeypatch.undo()
    whole = run(tmp_path / "b.zarr")
    assert stored_identity(tmp_path / "b.zarr")["chunk"] == 300
    np.testing.assert_array_equal(
        open_store(tmp_path / "a.zarr")["nut_radius"], whole["nut_radius"]
    )


def test_a_store_keeps_its_calls_on_a_machine_with_another_cache(tmp_path, monkeypatch):
    monkeypatch.setattr(_sweep, "call_size", lambda: 7)
    run(tmp_path / "a.zarr", chunk=30)
    run(tmp_path / "b.zarr", chunk=30, shard=(1, 2))
    monkeypatch.setattr(_sweep, "call_size", lambda: 11)
    run(tmp_path / "b.zarr", shard=(2, 2))
    assert stored_identity(tmp_path / "b.zarr")["call"] == 7
    assert contents(tmp_path / "b.zarr") == contents(tmp_path / "a.zarr")


#: A sweep of as many leads times 100 contact angles; prints the peak of the process [kB].
_SCRIPT = """
    import sys
    from pathlib import Path
    import numpy as np
    import prsm_jax as prsm
    axes = {
        "lead": np.linspace(6e-3, 14e-3, int(sys.argv[1])),
        "contact_angle": np.linspace(0.7, 0.8, 100),
    }
    prsm.sweep(prsm.load("wu2022"), axes, ["nut_radius", "nut_speed"], chunk=20_000,
               findings=False, store=Path(sys.argv[2]))
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            print(line.split()[1])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the peak is read from /proc")
def test_memory_does_not_grow_with_the_number_of_designs(tmp_path):
    """Results of 2,000,000 designs are 38 MB: two numbers of 8 bytes and three codes of one.

    Between two equal runs the peak differs by some MB: threads, and what the allocator keeps.
    """
    peaks = []
    for leads in (1000, 20_000):
        words = [sys.executable, "-c", textwrap.dedent(_SCRIPT)]
        done = subprocess.run(
            [*words, str(leads), str(tmp_path / f"{leads}.zarr")],
            env=os.environ,
            capture_output=True,
            text=True,
            check=True,
        )
        peaks.append(int(done.stdout) / 1024)
    assert abs(peaks[1] - peaks[0]) < 20, peaks
