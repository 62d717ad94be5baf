"""The notebooks run from top to bottom, and the committed ones belong to their scripts."""

import importlib.util
from pathlib import Path

import jupytext
import pytest

from tests.compilation_cache import cache_folder

FOLDER = Path(__file__).parents[2] / "notebooks"
_spec = importlib.util.spec_from_file_location("build_notebooks", FOLDER / "build.py")
assert _spec is not None
assert _spec.loader is not None
build = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(build)


@pytest.mark.timeout(900)
@pytest.mark.filterwarnings("default")  # those of the kernel's own machinery are not ours
@pytest.mark.parametrize("script", build.scripts(), ids=lambda path: path.stem)
def test_a_notebook_runs(script, monkeypatch):
    # The kernel is a process of its own; let it share what the tests have compiled.
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", cache_folder())
    monkeypatch.setenv("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
    notebook = build.execute(script)
    pictures = [
        output
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) >= 4


@pytest.mark.parametrize("script", build.scripts(), ids=lambda path: path.stem)
def test_the_committed_notebook_is_that_of_the_script(script):
    def sources(path):
        return [(cell.cell_type, cell.source) for cell in jupytext.read(path).cells]

    assert sources(script.with_suffix(".ipynb")) == sources(script)
