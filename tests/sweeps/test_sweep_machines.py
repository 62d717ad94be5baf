"""A sweep by processes as on many machines: sixteen shards, and a Dask scheduler with workers.

Processes are started as users start them, and some are killed with SIGKILL in mid-sweep. The store
has to be complete and equal, byte by byte, to that of one process.
"""

import concurrent.futures
import contextlib
import json
import os
import signal
import subprocess
import sys
import time

import pytest
from compilation_cache import cache_folder
from stored_sweeps import contents

pytest.importorskip("zarr")

SHARDS = 16
#: Blocks of four designs: 320, of which each shard has 20.
BLOCKS, CHUNK = 320, 4
#: Longest time that a process of a test may need on a busy machine [s].
PATIENCE = 240
AXES = ("--axis", "lead=6 mm:14 mm:64", "--axis", "contact_angle=40 deg:46 deg:20")
QUANTITIES = ("--quantities", "nut_speed,nut_radius")
WORDS = ("sweep", "wu2022", *AXES, *QUANTITIES, "--chunk", str(CHUNK))


def _environment():
    return os.environ | {"PRSM_JAX_CACHE": cache_folder()}


def _started(*words):
    return subprocess.Popen(
        [sys.executable, "-m", *map(str, words)],
        env=_environment(),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def _sweep(folder, *more):
    return _started("prsm_jax", *WORDS, "--out", folder, *more, "--json", "-")


def _finished(process):
    """What a process printed, as JSON."""
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    return json.loads(out)


def _marks(folder, shard=None):
    """Numbers of the blocks that are complete, of a shard or of all."""
    done = folder / "wu2022-sweep.zarr" / "progress" / "done" / "c"
    numbers = [int(path.name) for path in done.glob("*") if path.name.isdigit()]
    return [n for n in numbers if shard is None or n % SHARDS == shard - 1]


def _killed_at(process, enough):
    """Kill a process as soon as a condition holds."""
    end = time.monotonic() + PATIENCE
    while not enough():
        assert process.poll() is None, process.communicate()[1]
        assert time.monotonic() < end
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert process.returncode == -signal.SIGKILL


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """The store of one process."""
    folder = tmp_path_factory.mktemp("one")
    assert _finished(_sweep(folder))["missing"] == 0
    assert len(_marks(folder)) == BLOCKS
    return contents(folder / "wu2022-sweep.zarr")


def test_sixteen_shards_some_killed_and_one_twice_at_once(tmp_path, expected):
    """At most four at once; shards 3, 7 and 12 are killed and started again, and 5 runs twice."""

    def whole(shard):
        found = _finished(_sweep(tmp_path, "--shard", f"{shard}/{SHARDS}"))
        assert found["points"] == BLOCKS * CHUNK

    def killed(shard):
        process = _sweep(tmp_path, "--shard", f"{shard}/{SHARDS}")
        _killed_at(process, lambda: _marks(tmp_path, shard))
        assert 0 < len(_marks(tmp_path, shard)) < BLOCKS // SHARDS

    again = (3, 7, 12)
    others = [shard for shard in range(1, SHARDS + 1) if shard not in (*again, 5)]
    work = [(whole, 5), (whole, 5), *((killed, shard) for shard in again)]
    work += [(whole, shard) for shard in (*others, *again)]
    # Work begins in this order: a shard that was killed starts again after all others.
    with concurrent.futures.ThreadPoolExecutor(4) as threads:
        for future in [threads.submit(function, shard) for function, shard in work]:
            future.result()
    collected = _finished(_sweep(tmp_path, "--collect"))
    assert (collected["points"], collected["missing"]) == (BLOCKS * CHUNK, 0)
    assert contents(tmp_path / "wu2022-sweep.zarr") == expected


def test_a_dask_scheduler_with_four_workers_one_of_them_killed(tmp_path, expected):
    """All of them processes; the workers that are left compute what the lost one had begun."""
    pytest.importorskip("distributed")
    where = tmp_path / "scheduler.json"
    with contextlib.ExitStack() as stack:

        def started(*words):
            process = _started(*words)
            stack.callback(process.communicate)
            stack.callback(process.kill)
            return process

        # Port 0: the system chooses one that is free.
        started("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", 0,
                "--no-dashboard", "--scheduler-file", where)  # fmt: skip
        end = time.monotonic() + PATIENCE
        while not where.exists() or not where.read_text():
            assert time.monotonic() < end
            time.sleep(0.05)
        address = json.loads(where.read_text())["address"]
        workers = [
            started(
                "distributed.cli.dask_worker",
                address,
                "--nthreads",
                1,
                "--no-nanny",
                "--no-dashboard",
                "--host",
                "127.0.0.1",
                "--local-directory",
                tmp_path / "dask",
            )
            for _ in range(4)
        ]
        sweep = _sweep(tmp_path, "--scheduler", address)
        stack.callback(sweep.kill)
        _killed_at(workers[0], lambda: len(_marks(tmp_path)) >= 20)
        assert len(_marks(tmp_path)) < BLOCKS
        assert _finished(sweep)["missing"] == 0
    assert contents(tmp_path / "wu2022-sweep.zarr") == expected
