"""Stores and files beside links, other processes, damage and disks without room."""

import contextlib
import json
import os
import pathlib
import resource
import signal
import stat
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest
import xarray
from whole_stores import write_store

from prsm_jax.process import _files, _placing
from prsm_jax.process._files import whole_file
from prsm_jax.sweeps._store import check_store


def _data(number, size=64):
    return xarray.Dataset({name: ("n", np.full(size, number)) for name in "xy"})


def _numbers(path):
    with xarray.open_zarr(path, consolidated=False) as data:
        return {int(n) for name in "xy" for n in data[name].values}


def test_a_store_behind_a_link(tmp_path):
    (tmp_path / "link.zarr").symlink_to("real.zarr")
    for number in (1, 2):
        write_store(_data(number), tmp_path / "link.zarr")
        assert (tmp_path / "link.zarr").is_symlink()
        assert _numbers(tmp_path / "real.zarr") == {number}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link.zarr", "real.zarr"]


@pytest.mark.parametrize("exchange", [True, False])
def test_a_store_takes_the_place_of_another(tmp_path, monkeypatch, exchange):
    """In one step where the system can exchange two folders; in two, with a way back, elsewhere."""
    if not exchange:
        monkeypatch.setattr(_placing, "_exchanged", lambda *_: False)
    write_store(_data(1), tmp_path / "a.zarr")
    write_store(_data(2), tmp_path / "a.zarr")
    assert _numbers(tmp_path / "a.zarr") == {2}
    if not exchange:
        replace, calls = os.replace, []

        def fails_once(one, other):
            calls.append(other)
            if len(calls) == 2:
                raise OSError("no")
            replace(one, other)

        monkeypatch.setattr(os, "replace", fails_once)
        with pytest.raises(OSError, match="no"):
            write_store(_data(3), tmp_path / "a.zarr")
        assert _numbers(tmp_path / "a.zarr") == {2}
    assert [path.name for path in tmp_path.iterdir()] == ["a.zarr"]


@pytest.mark.parametrize("damage", ["cut", "empty", "not JSON", "no chunks"])
def test_a_damaged_store_is_replaced(tmp_path, damage):
    store = tmp_path / "a.zarr"
    write_store(_data(1), store)
    mark = store / "zarr.json"
    if damage == "no chunks":
        for path in [p for p in store.rglob("c") if p.is_dir()]:
            for chunk in path.iterdir():
                chunk.unlink()
    else:
        text = mark.read_text()
        mark.write_text({"cut": text[: len(text) // 2], "empty": "", "not JSON": "\0{"}[damage])
    check_store(store)
    write_store(_data(2), store)
    assert _numbers(store) == {2}


def test_the_folder_of_a_store_may_go_meanwhile(tmp_path):
    """Another process that made it for results and found none takes it away again."""
    check_store(tmp_path / "a.zarr")
    (tmp_path / "gone").mkdir()
    (tmp_path / "gone").rmdir()
    write_store(_data(1), tmp_path / "gone" / "a.zarr")
    assert _numbers(tmp_path / "gone" / "a.zarr") == {1}


_TESTS = str(pathlib.Path(__file__).parents[1])
_WRITER = """
    import pathlib, sys
    sys.path.insert(0, sys.argv[3])
    import numpy as np, xarray
    from prsm_jax.process._files import whole_file
    from whole_stores import write_store
    folder, number = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    sys.stdin.readline()
    for _ in range(8):
        data = xarray.Dataset({name: ("n", np.full(512, number)) for name in "xy"})
        write_store(data, folder / "a.zarr")
        with whole_file(folder / "a.json") as partial:
            partial.write_text(str([number] * 2000))
"""


def test_two_processes_write_one_store(tmp_path):
    """The store and the file are at every moment those of one of them."""
    writers = [
        subprocess.Popen(
            [sys.executable, "-c", textwrap.dedent(_WRITER), str(tmp_path), str(number), _TESTS],
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for number in (1, 2)
    ]
    for writer in writers:
        writer.stdin.write("\n")
        writer.stdin.flush()
    while any(writer.poll() is None for writer in writers):
        with contextlib.suppress(FileNotFoundError):
            assert len(set(json.loads((tmp_path / "a.json").read_text()))) == 1
        time.sleep(0.01)
    for writer in writers:
        # Old versions of numcodecs warn past any filter.
        told = writer.communicate()[1]
        assert (writer.returncode, "Error" in told) == (0, False), told
    assert len(_numbers(tmp_path / "a.zarr")) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "a.zarr"]


@contextlib.contextmanager
def _files_no_larger_than(size):
    """As on a disk that is nearly full: what grows past the size fails."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


def test_no_room_leaves_what_was_there(tmp_path):
    noise = np.random.default_rng(1).random(20_000)
    small, large = _data(1), xarray.Dataset({"x": ("n", noise), "y": ("n", noise)})
    write_store(small, tmp_path / "a.zarr")
    (tmp_path / "a.json").write_text("old")
    with _files_no_larger_than(20_000):
        with pytest.raises(OSError, match="too large"):
            write_store(large, tmp_path / "a.zarr")
        with (
            pytest.raises(OSError, match="too large"),
            whole_file(tmp_path / "a.json") as partial,
        ):
            partial.write_text("x" * 100_000)
    assert _numbers(tmp_path / "a.zarr") == {1}
    assert (tmp_path / "a.json").read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "a.zarr"]


def test_what_is_no_regular_file_is_written_to(tmp_path):
    """Also through a link; a folder in memory is a folder as any other."""
    ours, theirs = os.openpty()
    try:
        (tmp_path / "link").symlink_to(os.ttyname(theirs))
        for target in (os.ttyname(theirs), tmp_path / "link"):
            with whole_file(_files.Path(target)) as partial:
                partial.write_text("words")
            assert os.read(ours, 100) == b"words"
            assert stat.S_ISCHR(os.stat(target).st_mode)
        assert (tmp_path / "link").is_symlink()
    finally:
        os.close(ours)
        os.close(theirs)
    assert not _files.is_written_through(_files.Path("/dev/shm/x.json"))
    assert _files.is_written_through(_files.Path("/dev/stdout"))


def test_links_in_a_circle_and_who_may_read(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(OSError, match="symbolic links"), whole_file(tmp_path / "a") as partial:
        partial.write_text("words")
    assert (tmp_path / "a").is_symlink()
    (tmp_path / "private").write_text("old")
    (tmp_path / "private").chmod(0o600)
    with whole_file(tmp_path / "private") as partial:
        partial.write_text("new")
    assert stat.S_IMODE((tmp_path / "private").stat().st_mode) == 0o600
