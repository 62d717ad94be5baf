"""What is read from `pyproject.toml` is what is tested with the lowest versions."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.versions.core import TESTS
from tests.versions.requirements import lowest, read_project

ROOT = Path(__file__).parents[2]


def test_every_requirement_has_a_lowest_version():
    project = read_project(ROOT / "pyproject.toml")
    found = lowest(project, tuple(project["optional-dependencies"]))
    assert {"jax", "equinox", "pint", "xarray", "zarr", "matplotlib", "pytest"} <= set(found)
    assert project["name"] not in found


def test_extras_are_followed_and_the_highest_of_several_bounds_counts():
    project = {
        "name": "this",
        "dependencies": ["jax>=0.7"],
        "optional-dependencies": {
            "one": ["this[two, three]", "numpy >= 2.0"],
            "two": ["jax>=0.10"],
            "three": ["rich>=13", "this[one]"],
            "four": ["pint"],
            "five": ["pint==1.0"],
        },
    }
    assert lowest(project, ("one",)) == {"jax": "0.10", "numpy": "2.0", "rich": "13"}
    with pytest.raises(ValueError, match="'pint' has no lowest version; write pint>=…"):
        lowest(project, ("four",))
    with pytest.raises(ValueError, match=r"'pint==1\.0' is not of the form name>=version"):
        lowest(project, ("five",))


def test_the_core_paths_are_there():
    for one in TESTS:
        path, _, name = one.partition("::")
        assert not name or f"\ndef {name}(" in (ROOT / path).read_text(encoding="utf-8")
        assert (ROOT / path).is_file()


def test_a_python_that_is_not_there_is_named(tmp_path):
    """By its path, or by its version."""
    for absent in (str(tmp_path / "python"), "3.999"):
        found = subprocess.run(
            [sys.executable, "-m", "tests.versions", "lowest", absent],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        assert found.stdout == f"NOT TESTED with Python {absent}: there is none on this machine\n"
        assert (found.returncode, found.stderr) == (0, "")
