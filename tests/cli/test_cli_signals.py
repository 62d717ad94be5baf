"""Signals at random times: one line, a status that tells, nothing that is half there."""

import json
import os
import random
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

#: The process has to end in this time [s], whatever it is doing; a busy machine doubles it.
PATIENCE = 2.0
_START = "import sys; sys.argv[0] = 'prsm'; from prsm_jax.cli import main; sys.exit(main())"
VERBS = {
    "sweep": ("sweep", "wu2022", "--axis", "lead=5 mm:15 mm:60", "--axis", "roller_count=5,6,7,9"),
    "optimise": ("optimise", "actuator", "--starts", "1"),
    "simulate": ("simulate", "actuator_mission", "--samples", "41", "--out", "out"),
    "demo": ("demo",),
}
_MESSAGES = {signal.SIGINT: "prsm: stopped (Ctrl-C)", signal.SIGTERM: "prsm: terminated"}


def start(words, folder, cache=""):
    return subprocess.Popen(
        [sys.executable, "-c", _START, *words],
        cwd=folder,
        env=os.environ | {"PRSM_JAX_CACHE": str(cache), "COLUMNS": "80"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        # A job in the background of a script ignores SIGINT, and so would its children.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def wait_until_heard(process):
    """Until signals are caught: before it, the process is Python that has not read our code yet."""
    status, bit = Path(f"/proc/{process.pid}/status"), 1 << (signal.SIGTERM - 1)
    while process.poll() is None:
        caught = next(x for x in status.read_text().splitlines() if x.startswith("SigCgt"))
        if int(caught.split()[1], 16) & bit:
            return
        time.sleep(0.002)


def readable(folder):
    """Every file that is there is one that can be read, and nothing is half made."""
    import xarray
    from PIL import Image

    for path in folder.rglob("*"):
        assert not path.name.startswith("."), path
        if path.suffix == ".zarr":
            data = xarray.open_zarr(path, consolidated=False)
            # A store that a later run continues does not count its failed designs yet.
            assert "failed" not in data.attrs or not bool(data.failed.all())
        elif path.suffix == ".json" and ".zarr" not in str(path):
            json.loads(path.read_text())
        elif path.suffix == ".toml":
            tomllib.loads(path.read_text())
        elif path.suffix in (".png", ".gif"):
            with Image.open(path) as picture:
                picture.load()
        elif path.suffix in (".svg", ".html"):
            assert path.read_text().rstrip().endswith(f"</{path.suffix[1:]}>")


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs Linux's /proc")
@pytest.mark.parametrize("verb", VERBS)
def test_signals_at_random_times(verb, tmp_path):
    """Seeded moments from the start of the program until past its usual end."""
    moments = random.Random(f"prsm {verb}")
    longest = {"sweep": 12.0, "optimise": 12.0, "simulate": 12.0, "demo": 40.0}[verb]
    for number in (signal.SIGINT, signal.SIGTERM):
        folder = tmp_path / number.name
        folder.mkdir()
        process = start(VERBS[verb], folder)
        try:
            wait_until_heard(process)
            process_end = moments.uniform(0.0, longest)
            try:
                process.wait(timeout=process_end)
            except subprocess.TimeoutExpired:
                process.send_signal(number)
            began = time.monotonic()
            _, err = process.communicate(timeout=60)
            taken = time.monotonic() - began
        finally:
            process.kill()
        if process.returncode in (0, -number):
            # It was done before, or the signal came while Python itself was ending, where it takes
            # its handlers away: the signal then ends a process whose result is written.
            assert (err, bool(list(folder.iterdir()))) == ("", True)
        else:
            assert (process.returncode, err) == (128 + number, _MESSAGES[number] + "\n")
        assert taken < PATIENCE
        readable(folder)


def test_killed_while_it_writes(tmp_path):
    """What was there is whole after SIGKILL at random moments of writing, again and again."""
    code = """
import pathlib, sys
sys.path.insert(0, sys.argv[2])
import numpy as np, xarray
from whole_stores import write_store
from prsm_jax.process._files import whole_file
here, count = pathlib.Path(sys.argv[1]), 0
while True:
    count += 1
    data = xarray.Dataset({"x": ("n", np.full(4096, count)), "y": ("n", np.full(4096, count))})
    write_store(data, here / "a.zarr")
    with whole_file(here / "a.json") as partial:
        partial.write_text("[" + ",".join([str(count)] * 4096) + "]")
    if count == 1:
        print("written", flush=True)
"""
    import xarray

    moments = random.Random(14)
    for _ in range(4):
        process = subprocess.Popen(
            [sys.executable, "-c", code, str(tmp_path), str(Path(__file__).parents[1])],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdout.readline() == "written\n"
        time.sleep(moments.uniform(0.0, 0.5))
        process.kill()
        process.communicate()
        numbers = json.loads((tmp_path / "a.json").read_text())
        assert (len(numbers), len(set(numbers))) == (4096, 1)
        data = xarray.open_zarr(tmp_path / "a.zarr", consolidated=False)
        assert len({int(n) for name in "xy" for n in data[name].values}) == 1


def test_two_runs_in_one_folder_with_one_cache(tmp_path):
    """Both end well and give the same numbers; so does a third from what they kept."""
    words = ("steady", "wu2022", "--out", "out", "--json")
    runs = [start((*words, f"{n}.json"), tmp_path, tmp_path / "cache") for n in (1, 2)]
    for run in runs:
        assert run.communicate(timeout=200)[1] == ""
    third = start((*words, "3.json"), tmp_path, tmp_path / "cache")
    assert third.communicate(timeout=200)[1] == ""
    assert [run.returncode for run in (*runs, third)] == [0, 0, 0]
    first, *others = (json.loads((tmp_path / f"{n}.json").read_text()) for n in (1, 2, 3))
    assert others == [first, first]
    readable(tmp_path)
