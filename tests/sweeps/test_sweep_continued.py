"""Stores written block by block: killed runs, shards and workers give the same bytes."""

import concurrent.futures
import contextlib
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import textwrap
from typing import Any

import jax
import numpy as np
import pytest
import xarray
from stored_sweeps import contents

import prsm_jax as prsm
from prsm_jax.sweeps import _run, _sweep, collect, count_codes, open_store, sweep
from prsm_jax.sweeps._store import BlockStore

QUANTITIES = ["nut_radius", "nut_speed"]
#: Blocks of four designs: 12 in a grid of 4 × 3 × 4.
AXES = {
    "lead": np.linspace(6e-3, 14e-3, 4),
    "contact_angle": [0.7, 0.75, 0.8],
    "operating_point.load": np.linspace(3e3, 9e3, 4),
}
CHUNK = 4


def run(store, **more):
    mechanism = more.pop("mechanism", None) or prsm.load("wu2022")
    options = {"chunk": CHUNK, "findings": False, "store": store, "speed": None} | more
    options.setdefault("load", None)
    return sweep(mechanism, options.pop("axes", AXES), QUANTITIES, **options)


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """The store of a run in one go, in this process."""
    store = tmp_path_factory.mktemp("expected") / "a.zarr"
    run(store)
    return contents(store)


@pytest.fixture
def counted(monkeypatch):
    """Numbers of the blocks that this process computes."""
    numbers, compute = [], _run.compute_block

    def counting(task):
        numbers.append(task.number)
        return compute(task)

    monkeypatch.setattr(_run, "compute_block", counting)
    return numbers


#: Runs a sweep in a process of its own, waits a little before each block, and says when it is done.
_SCRIPT = """
    import sys, time
    from pathlib import Path
    import prsm_jax as prsm
    from prsm_jax.sweeps import _run, sweep
    import numpy as np
    shard = tuple(map(int, sys.argv[2].split("/")))
    pause = float(sys.argv[3])

    compute = _run.compute_block

    def slowly(task):
        time.sleep(pause)
        return compute(task)

    _run.compute_block = slowly

    def told(done, total):
        print(done, flush=True)

    axes = {
        "lead": np.linspace(6e-3, 14e-3, 4),
        "contact_angle": [0.7, 0.75, 0.8],
        "operating_point.load": np.linspace(3e3, 9e3, 4),
    }
    sweep(
        prsm.load("wu2022"), axes, ["nut_radius", "nut_speed"],
        chunk=4, findings=False, store=Path(sys.argv[1]), shard=shard, progress=told,
    )
"""


def started(store, shard="1/1", pause=0.0):
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(_SCRIPT), str(store), shard, str(pause)],
        stdout=subprocess.PIPE,
        text=True,
    )


def killed_after(process, lines):
    """Kill a process when it has said so many lines."""
    with process:
        for _ in range(lines):
            process.stdout.readline()
        process.send_signal(signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL


def test_a_killed_run_continues_where_it_stopped(tmp_path, expected, counted):
    store = tmp_path / "a.zarr"
    killed_after(started(store, pause=0.5), lines=4)
    # Half a chunk of a writer that was killed, and a block whose mark was not yet written.
    (store / "nut_speed" / "c" / "0.3f.partial").write_bytes(b"half")
    before = np.flatnonzero(open_done(store))
    assert 0 < len(before) < 12
    partly = open_store(store)
    assert count_codes(partly).missing >= 4
    assert "failed" not in partly.attrs
    missing = partly["code"] == partly["code"].attrs["flag_meanings"].split().index("not_computed")
    # A block can be written and its mark not yet.
    assert 0 < int(missing.sum()) <= 4 * (12 - len(before))
    assert bool(np.isnan(partly["nut_speed"].values[missing.values]).all())

    data = run(store)
    assert sorted([*counted, *before]) == list(range(12))
    assert contents(store) == expected
    assert data.attrs["failed"] == 0
    assert not data["failed"].any()


def open_done(store):
    import zarr

    marks: Any = zarr.open_group(store, mode="r")["progress/done"]
    return np.asarray(marks[:, 0]) != 0


def test_a_finished_one_is_not_computed_again(tmp_path, expected, counted):
    store = tmp_path / "a.zarr"
    first, told = run(store), []
    assert len(counted) == 12
    second = run(store, progress=lambda done, total: told.append((done, total)))
    assert len(counted) == 12
    assert told[0] == (48, 48)
    xarray.testing.assert_identical(first.load(), second.load())
    # The number of designs in a block is that of the store.
    run(store, chunk=None)
    assert len(counted) == 12
    assert contents(store) == expected


def test_a_damaged_block_is_computed_again_when_its_mark_goes(tmp_path, expected, counted):
    store = tmp_path / "a.zarr"
    run(store)
    counted.clear()
    (store / "progress" / "done" / "c" / "7" / "0").unlink()
    run(store)
    assert counted == [7]
    assert contents(store) == expected


def test_shards_in_any_order_give_the_same_bytes(tmp_path, expected):
    store = tmp_path / "a.zarr"
    for shard in ((3, 5), (1, 5), (5, 5), (4, 5)):
        data = run(store, shard=shard)
        assert "failed" not in data.attrs
    # Blocks 1, 6 and 11 are those of the second shard.
    np.testing.assert_array_equal(np.flatnonzero(~open_done(store)), [1, 6, 11])
    run(store, shard=(2, 5))
    assert contents(store) == expected


def test_processes_at_once_killed_and_started_twice(tmp_path, expected):
    """Four shards; one is killed and started again twice at once, while the others run."""
    store = tmp_path / "a.zarr"
    first = started(store, "2/4", pause=0.3)
    others = [started(store, f"{i}/4", pause=0.05) for i in (1, 3, 4)]
    killed_after(first, lines=2)
    again = [started(store, "2/4") for _ in range(2)]
    for process in (*others, *again):
        process.communicate()
        assert process.returncode == 0
    assert contents(store) == expected


@pytest.mark.parametrize("kind", ["threads", "processes"])
def test_executors_give_the_same_bytes(tmp_path, expected, kind):
    store = tmp_path / "a.zarr"
    if kind == "threads":
        executor = concurrent.futures.ThreadPoolExecutor(3)
    else:
        context = multiprocessing.get_context("spawn")
        executor = concurrent.futures.ProcessPoolExecutor(2, context)
    with executor:
        run(store, executor=executor)
        in_memory = run(None, executor=executor)
    assert contents(store) == expected
    xarray.testing.assert_identical(in_memory, open_store(store).load())


def test_a_worker_that_is_killed_leaves_a_store_that_continues(tmp_path, expected):
    store = tmp_path / "a.zarr"
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, context) as executor:
        pid = executor.submit(os.getpid).result()

        def kill(done, total):
            if done >= 8:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)

        with pytest.raises(concurrent.futures.process.BrokenProcessPool):
            run(store, executor=executor, progress=kill)
    assert 0 < open_done(store).sum() < 12
    run(store)
    assert contents(store) == expected


def test_dask_workers_one_of_them_killed(tmp_path, expected):
    """A scheduler and four workers, each a process; one is killed in mid-sweep."""
    distributed = pytest.importorskip("distributed")
    store = tmp_path / "a.zarr"
    with (
        distributed.LocalCluster(
            n_workers=4,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            local_directory=tmp_path / "dask",
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = list(client.run(os.getpid).values())
        killed = []

        def kill(done, total):
            if done >= 8 and not killed:
                killed.append(os.kill(pids[0], signal.SIGKILL))

        run(store, executor=client.get_executor(), progress=kill)
    assert killed
    assert contents(store) == expected


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"axes": AXES | {"lead": np.linspace(6e-3, 13e-3, 4)}}, "axes: lead: there .*, here .*"),
        ({"axes": {"lead": AXES["lead"]}}, "points: there 48, here 4"),
        ({"chunk": 5, "axes": AXES | {"contact_angle": [0.7, 0.8]}}, "points: there 48, here 32"),
        ({"chunk": 12}, "chunk: there 4, here 12"),
        ({"gradients": ["lead"]}, r"gradients: there \[\], here \[\"lead\"\]"),
        ({"findings": True}, "findings: there false, here true"),
        ({"speed": 5.0}, "point: speed: there null, here 5.0"),
    ],
)
def test_a_store_of_another_sweep_is_refused(tmp_path, more, words):
    store = tmp_path / "a.zarr"
    run(store)
    before = contents(store)
    remedy = r"resume=False \(--no-resume\)"
    with pytest.raises(ValueError, match=rf"belongs to another sweep \({words}\).*{remedy}"):
        run(store, **more)
    assert contents(store) == before


def test_stores_of_other_mechanisms_and_versions_are_refused(tmp_path, monkeypatch):
    store = tmp_path / "a.zarr"
    run(store)
    other = prsm.set_parameter(prsm.load("wu2022"), "screw_radius", 10.1e-3)
    with pytest.raises(ValueError, match="its mechanism has other numbers"):
        run(store, mechanism=other)
    monkeypatch.setattr(_sweep, "__version__", "99.0")
    with pytest.raises(ValueError, match=r'prsm_jax: there .*, here "99.0"'):
        run(store)


@pytest.mark.parametrize("damage", ["cut", "empty", "not JSON", "gone", "no sweep"])
def test_what_no_sweep_wrote_is_refused_and_stays(tmp_path, damage):
    store = tmp_path / "a.zarr"
    run(store)
    mark = store / "progress" / "zarr.json"
    text = mark.read_text()
    if damage == "gone":
        mark.unlink()
    else:
        other = json.dumps({**json.loads(text), "attributes": {}})
        words = {"cut": text[: len(text) // 2], "empty": "", "not JSON": "\0{", "no sweep": other}
        mark.write_text(words[damage])
    before = contents(store)
    with pytest.raises(ValueError, match=r"not written by a sweep, or is damaged.*resume=False"):
        run(store)
    assert contents(store) == before
    run(store, resume=False)
    assert open_done(store).all()


def test_replacing_keeps_the_old_store_until_the_new_one_is_complete(tmp_path, monkeypatch):
    store = tmp_path / "a.zarr"
    run(store)
    before = contents(store)

    def broken(task):
        raise OSError("disk full")

    with monkeypatch.context() as patched:
        patched.setattr(_run, "compute_block", broken)
        with pytest.raises(OSError, match="disk full"):
            run(store, resume=False)
    assert contents(store) == before
    assert [path.name for path in tmp_path.iterdir()] == ["a.zarr"]


def test_no_store_to_open(tmp_path):
    with pytest.raises(ValueError, match="does not exist; run the sweep"):
        open_store(tmp_path / "a.zarr")


def test_memory_of_a_stored_sweep_does_not_hold_the_results(tmp_path):
    """What comes back reads its values when they are used."""
    data = run(tmp_path / "a.zarr")
    assert not data["nut_speed"].variable._in_memory


def test_a_block_that_cannot_be_written_has_no_mark(tmp_path):
    """The mark comes last: whatever fails before it, the block counts as missing."""
    store = tmp_path / "a.zarr"
    run(store)
    (store / "progress" / "done" / "c" / "0" / "0").unlink()
    blocks = BlockStore(store)
    where = (slice(0, 1), slice(0, 1), slice(0, 4))
    good = {"nut_speed": np.zeros((1, 1, 4))}
    with pytest.raises(ValueError, match=r"shape|broadcast"):
        blocks.write(0, where, good | {"code": np.zeros((1, 7, 3), np.int8)}, (0, 0))
    assert not blocks.marks()[0, 0]
    blocks.write(0, where, good, (0, 0))
    assert blocks.marks()[0, 0]


def test_a_store_that_was_removed_and_made_again_has_its_own_blocks(tmp_path):
    """In one process: blocks of twelve designs go where those of four designs were."""
    store = tmp_path / "a.zarr"
    run(store)
    shutil.rmtree(store)
    again = run(store, chunk=12)
    xarray.testing.assert_identical(again.load(), run(None, chunk=12))


def test_parts_of_chunks_stay_while_blocks_are_missing(tmp_path):
    """Another machine, whose locks this one may not see, can still be writing them."""
    store = tmp_path / "a.zarr"
    run(store, shard=(1, 2))
    part = store / "nut_speed" / "c" / "0.3f.partial"
    part.write_bytes(b"half")
    run(store, shard=(1, 2))
    assert part.exists()
    run(store, shard=(2, 2))
    assert not part.exists()


def test_progress_of_a_shard_and_of_a_run_that_continues(tmp_path):
    """A shard counts its own designs; what was there before comes with the first block."""
    store, told = tmp_path / "a.zarr", []

    def tell(done, total):
        told.append((done, total))

    run(store, shard=(1, 3), progress=tell)
    assert told == [(4, 16), (8, 16), (12, 16), (16, 16)]
    (store / "progress" / "done" / "c" / "0" / "0").unlink()
    told.clear()
    run(store, progress=tell)
    # Three blocks of the shard are there.
    assert (told[0], told[-1], len(told)) == ((16, 48), (48, 48), 9)


def test_shards_are_collected_from_the_store_alone(tmp_path):
    store = tmp_path / "a.zarr"
    run(store, shard=(1, 2))
    with pytest.raises(ValueError, match="6 of 12 blocks are not computed yet"):
        collect(store)
    run(store, shard=(2, 2))
    assert collect(store).attrs["failed"] == 0
    with pytest.raises(ValueError, match="does not exist; run the shards"):
        collect(tmp_path / "b.zarr")
    (store / "progress" / "zarr.json").unlink()
    with pytest.raises(ValueError, match="not written by a sweep"):
        collect(store)


def test_a_device_compiles_a_program_of_its_own(monkeypatch):
    """Another device waits for its program as the first one did."""
    monkeypatch.setattr(_run, "_compiled", set())
    run(None)
    with jax.default_device(jax.devices()[0]):
        run(None, executor=_Here())
    assert len(_run._compiled) == 2


#: Sweeps on a CPU that is two devices, and prints the devices that held each block's results.
_TWO_DEVICES = """
    import sys
    from pathlib import Path
    import jax
    jax.config.update("jax_num_cpu_devices", 2)
    import numpy as np
    import prsm_jax as prsm
    from prsm_jax.sweeps import _run, sweep

    compute = _run.evaluate_block

    def told(*arguments):
        results = compute(*arguments)
        for device in jax.tree.leaves(results)[0].devices():
            # One write: two threads do.
            sys.stdout.write(f"{device.id}\\n")
        return results

    _run.evaluate_block = told
    axes = {
        "lead": np.linspace(6e-3, 14e-3, 4),
        "contact_angle": [0.7, 0.75, 0.8],
        "operating_point.load": np.linspace(3e3, 9e3, 4),
    }
    sweep(prsm.load("wu2022"), axes, ["nut_radius", "nut_speed"], chunk=4, findings=False,
          store=Path(sys.argv[1]))
"""


def test_all_devices_compute_and_the_store_is_the_same(tmp_path, expected):
    """Blocks take the devices in turn: each of two devices computes half of the twelve blocks."""
    store = tmp_path / "a.zarr"
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(_TWO_DEVICES), str(store)],
        capture_output=True,
        text=True,
        check=True,
    )
    assert sorted(done.stdout.split()) == ["0"] * 6 + ["1"] * 6
    assert contents(store) == expected


class _Here(concurrent.futures.Executor):
    """Computes at once, in this thread."""

    def submit(self, fn, /, *args, **kwargs):
        future: concurrent.futures.Future[Any] = concurrent.futures.Future()
        future.set_result(fn(*args, **kwargs))
        return future
