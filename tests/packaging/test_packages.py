"""The wheel and the source archive hold the package's files, all of them and no others."""

import importlib.util
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from prsm_jax import __version__

ROOT = Path(__file__).parents[2]
ABOUT = f"prsm_jax-{__version__}.dist-info"
#: What the wheel holds beside the package.
METADATA = {"METADATA", "RECORD", "WHEEL", "entry_points.txt", "licenses/LICENSE"}
#: Settings of the project's own checks, which need git.
NOT_IN_SOURCE = {".ci/run", ".pre-commit-config.yaml"}


def _files_of_the_project() -> set[str]:
    """All files that git holds, or would hold."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True, text=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("the list of files needs git and a checkout")
    return {name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()}


def _built(kind: str, source: Path, folder: Path) -> Path:
    """A package, built by the backend itself: nothing is fetched from a network."""
    if importlib.util.find_spec("hatchling") is None:
        pytest.skip("hatchling, the build backend, is not installed")
    command = [sys.executable, "-W", "error", "-m", "hatchling", "build", "-t", kind]
    done = subprocess.run(
        [*command, "-d", str(folder)], cwd=source, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "warning" not in (done.stdout + done.stderr).lower()
    (package,) = folder.iterdir()
    return package


def test_the_wheel_holds_the_package_and_nothing_else(tmp_path):
    tracked = {name for name in _files_of_the_project() if name.startswith("prsm_jax/")}
    with zipfile.ZipFile(_built("wheel", ROOT, tmp_path / "wheel")) as wheel:
        held = set(wheel.namelist())
        about = wheel.read(f"{ABOUT}/METADATA").decode()
        changed = [n for n in tracked & held if wheel.read(n) != (ROOT / n).read_bytes()]
    assert held == tracked | {f"{ABOUT}/{name}" for name in METADATA}
    assert not changed
    assert f"\nVersion: {__version__}\n" in about
    # What a list of files from git alone would not show: a file that nobody tracks any more.
    assert {"prsm_jax/py.typed", "prsm_jax/file/examples/actuator.toml"} < held
    assert {f"prsm_jax/report/templates/report.{kind}.jinja" for kind in ("html", "md")} < held
    assert sum(name.endswith(".csv") for name in held) >= 7


def test_the_source_archive_builds_the_same_wheel(tmp_path):
    expected = _files_of_the_project() - NOT_IN_SOURCE
    archive = _built("sdist", ROOT, tmp_path / "source")
    with tarfile.open(archive) as source:
        top = archive.name.removesuffix(".tar.gz")
        held = {one.name.removeprefix(f"{top}/") for one in source if one.isfile()}
        source.extractall(tmp_path / "unpacked", filter="data")
    assert held == expected | {"PKG-INFO"}
    ours = _built("wheel", ROOT, tmp_path / "ours")
    theirs = _built("wheel", tmp_path / "unpacked" / top, tmp_path / "theirs")
    assert theirs.read_bytes() == ours.read_bytes()
