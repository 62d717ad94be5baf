"""Stdout that is closed, full or no longer read: no traceback, and no result lost."""

import ctypes
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

_START = "import sys; sys.argv[0] = 'prsm'; from prsm_jax.cli import main; sys.exit(main())"


def _as_anyone():
    """Root may write everywhere: give that up (PR_CAPBSET_DROP of CAP_DAC_OVERRIDE)."""
    ctypes.CDLL(None).prctl(24, 1, 0, 0, 0)


def shell(command, folder, cache=""):
    """A command of the shell in which `prsm` is the program; status, stdout and stderr."""
    program = f'prsm() {{ \'{sys.executable}\' -c "{_START}" "$@"; }}'
    found = subprocess.run(
        ["bash", "-c", f"set -o pipefail\n{program}\n{command}"],
        cwd=folder,
        env=os.environ | {"PRSM_JAX_CACHE": str(cache)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=200,
        preexec_fn=_as_anyone if sys.platform == "linux" else None,
        check=False,
    )
    return found.returncode, found.stdout, found.stderr


def test_a_reader_that_has_seen_enough(tmp_path):
    """The rest of the run goes on, and what it writes is there."""
    status, out, err = shell("prsm quantities --out kept | head -n 1", tmp_path)
    assert (status, err) == (0, "")
    assert len(out.splitlines()) == 1
    assert json.loads((tmp_path / "kept" / "quantities.json").read_text())["quantities"]


def test_a_closed_stdout(tmp_path):
    status, out, err = shell("prsm example wu2022 --json there.json >&-", tmp_path)
    assert (status, out, err) == (0, "", "")
    assert json.loads((tmp_path / "there.json").read_text())["name"] == "wu2022"
    status, out, err = shell("prsm example wu2022 --json - >&-", tmp_path)
    assert (status, out) == (2, "")
    assert err == "prsm: --json -: stdout is closed; give the path of a file\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_stdout(tmp_path):
    status, _, err = shell("prsm example wu2022 >/dev/full", tmp_path)
    assert (status, err) == (2, "prsm: stdout: No space left on device\n")


def test_a_disk_that_is_full_and_a_folder_that_is_read_only(tmp_path):
    """One line, and nothing is there that was not: no file, and no folder for it."""
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "quantities.json").write_text("old")
    (tmp_path / "read-only").mkdir(mode=0o555)
    small = "ulimit -f 8; prsm quantities --out"
    for command, words in (
        (f"{small} new/inner", "File too large"),
        (f"{small} old", "File too large"),
        ("prsm quantities --json read-only/x.json", "nothing can be written in"),
        ("prsm quantities --out read-only/new", "nothing can be written in"),
    ):
        status, out, err = shell(command, tmp_path)
        assert (status, out) == (2, "")
        (line,) = err.splitlines()
        assert line.startswith("prsm: ")
        assert words in line
    assert {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")} == {
        *("old", "old/quantities.json", "read-only"),
    }
    assert (tmp_path / "old" / "quantities.json").read_text() == "old"


def test_a_closed_stderr(tmp_path):
    status, out, _ = shell("prsm modal nothing.toml 2>&-", tmp_path)
    assert (status, out) == (2, "")


def test_an_unwritable_folder_of_compiled_programs_is_one_line(tmp_path):
    """Once, however many programs are compiled; the results are the same."""
    (tmp_path / "file").write_text("mine")
    status, out, err = shell("prsm modal wu2022", tmp_path, cache=tmp_path / "file" / "cache")
    assert status == 0
    assert "Natural frequencies" in out
    (line,) = err.splitlines()
    assert line.startswith(f"prsm: {tmp_path}/file/cache: compiled programs cannot be kept here")
    assert (tmp_path / "file").read_text() == "mine"


def test_damaged_compiled_programs_are_made_anew_once(tmp_path):
    """Half a file, as a process that was killed leaves it, and bytes that were changed."""
    cache = tmp_path / "cache"
    status, first, err = shell("prsm steady wu2022", tmp_path, cache)
    assert (status, err) == (0, "")
    kept = sorted(path for path in cache.rglob("*") if path.is_file())
    assert {path.parent.name for path in kept} == {"cache", "programs"}
    for number, path in enumerate(kept):
        data = bytearray(path.read_bytes())
        if path.parent.name == "cache" and number % 2:
            data = data[: len(data) // 2]
        else:
            data[len(data) // 2] ^= 1
        path.write_bytes(data)
    status, second, err = shell("prsm steady wu2022", tmp_path, cache)
    assert (status, second) == (0, first)
    assert len(err.splitlines()) == 1
    assert err.startswith("prsm: a compiled program could not be read (")
    status, third, err = shell("prsm steady wu2022", tmp_path, cache)
    assert (status, third, err) == (0, first, "")


def test_an_integrated_transient_is_kept_for_the_next_run(tmp_path, monkeypatch):
    """No program is kept that calls Python, as diffrax's checks do where they raise."""
    monkeypatch.delenv("EQX_ON_ERROR", raising=False)
    kept = tmp_path / "programs of JAX"
    command = "prsm simulate li2020_two_stage --method explicit --samples 3"
    status, first, err = shell(command, tmp_path, kept)
    assert (status, err) == (0, "")
    # The transient, its numbers and those of `check`, as the second run reads them.
    programs = _stored(kept)
    assert len(programs) == 3
    status, second, err = shell(command, tmp_path, kept)
    assert (status, second, err) == (0, first, "")
    assert _stored(kept) == programs


def _stored(folder):
    """When each program was written; the list of their names is shorter than any of them."""
    found = {path: path.stat() for path in (folder / "programs").iterdir()}
    return {path: stat.st_mtime_ns for path, stat in found.items() if stat.st_size > 1000}
